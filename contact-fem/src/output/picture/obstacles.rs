//! Obstacles in pictures: hatched lines in the plane, light grey surfaces in space.

use plotters::element::PathElement;
use plotters::style::{Color, RGBColor, ShapeStyle};

use super::layout::Layout;
use super::view::project;
use super::{Canvas, DrawError};
use crate::contact::obstacle::outline::{Frame, Piece, outward};
use crate::model::Problem;
use crate::output::snapshot::Snapshot;
use crate::tensor::Vector;

/// What is seen of an obstacle.
pub(super) struct Shown<const D: usize> {
    /// Its number.
    pub index: usize,
    pub pieces: Vec<Piece<D>>,
}

/// The obstacles that count at the state, within the frame.
pub(super) fn shown<const D: usize>(
    problem: &Problem<D>,
    snapshot: &Snapshot<D>,
    frame: &Frame<D>,
) -> Vec<Shown<D>> {
    let present = problem.obstacles_at(snapshot.load_factor);
    let all = present.map(|(index, obstacle, pose)| Shown {
        index,
        pieces: obstacle.outline(&pose, frame),
    });
    all.filter(|shown| !shown.pieces.is_empty()).collect()
}

const LINE: RGBColor = RGBColor(110, 110, 110);

/// Draws the outline of an obstacle in the plane, with short strokes on its inside.
pub(super) fn hatch<const D: usize>(
    canvas: &Canvas<'_>,
    layout: &Layout,
    panel: usize,
    pieces: &[Piece<D>],
) -> Result<(), DrawError> {
    /// Between strokes, and their length, in pixels.
    const SPACING: f64 = 12.0;
    const LENGTH: f64 = 14.0;
    let line = ShapeStyle::from(&LINE).stroke_width(3);
    let thin = ShapeStyle::from(&LINE).stroke_width(1);
    let mut since = 0.5 * SPACING;
    for piece in pieces {
        let ends: Vec<(i32, i32)> = piece
            .iter()
            .map(|x| layout.pixel(panel, &project(x).into()))
            .collect();
        canvas.draw(&PathElement::new(ends, line))?;
        let [from, to] = [piece[0], piece[1]].map(|x| layout.place(panel, &project(&x).into()));
        let way = to - from;
        let length = way.norm();
        // the inside is to the left, which is down to the right where y is downwards
        let along = way / length.max(f64::MIN_POSITIVE);
        let inward = Vector::<2>::new(along[1], -along[0]);
        let stroke = (inward - along) * (LENGTH / 2f64.sqrt());
        while since < length {
            let start = from + along * since;
            let [a, b] =
                [start, start + stroke].map(|x| (x[0].round() as i32, x[1].round() as i32));
            canvas.draw(&PathElement::new(vec![a, b], thin))?;
            since += SPACING;
        }
        since -= length;
    }
    Ok(())
}

/// The colour of a part of an obstacle in space, seen along `towards` the viewer: grey by how much it faces the viewer, and nearly
/// transparent where it is seen from inside, as a lid is from above. Then the colour of its border.
pub(super) fn surface<const D: usize>(
    piece: &Piece<D>,
    towards: &Vector<D>,
) -> (ShapeStyle, Option<ShapeStyle>) {
    let normal = outward(piece);
    let facing = normal.dot(towards) / normal.norm().max(f64::MIN_POSITIVE);
    if facing < 0.0 {
        return (RGBColor(120, 120, 120).mix(0.12).filled(), None);
    }
    let bright = (195.0 + 45.0 * facing) as u8;
    let grey = RGBColor(bright, bright, bright);
    (grey.filled(), Some(ShapeStyle::from(&grey).stroke_width(1)))
}

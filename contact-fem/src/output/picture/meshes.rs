//! Pictures of deformed meshes side by side, coloured by a field on the cells.

use std::path::Path;

use plotters::element::{PathElement, Polygon, Rectangle};
use plotters::prelude::Text;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    BLACK, Color, FontTransform, IntoFont, IntoTextStyle, RGBColor, ShapeStyle, TextStyle,
};

use super::colours::Colours;
use super::trails::trails;
use super::view::{Patch, patches, project};
use super::{Canvas, DrawError, save};
use crate::assembly::CellState;
use crate::error::Error;
use crate::model::Problem;
use crate::output::snapshot::Snapshot;
use crate::tensor::Vector;

/// One state in a picture.
#[derive(Clone, Debug)]
pub struct Panel<'a, const D: usize> {
    /// The title above the panel.
    pub title: String,
    /// The state.
    pub snapshot: &'a Snapshot<D>,
}

/// A row of deformed meshes at one scale, with a common colour bar. Bodies in space are seen from
/// the front, the right and above; patches farther away are drawn first.
#[derive(Clone, Debug)]
pub struct MeshPicture<'a, const D: usize> {
    /// The panels from left to right.
    pub panels: Vec<Panel<'a, D>>,
    /// The field that determines the colour.
    pub field: fn(&CellState<D>) -> f64,
    /// The name and units of the field, beside the colour bar.
    pub label: String,
}

impl<'a, const D: usize> MeshPicture<'a, D> {
    /// The von Mises stress (UF/UL²) of these panels.
    pub fn von_mises(panels: Vec<Panel<'a, D>>) -> Self {
        MeshPicture {
            panels,
            field: CellState::von_mises,
            label: "von Mises stress (UF/UL²)".into(),
        }
    }

    /// Draws the picture as SVG at `path`. Colours range from the field's smallest value (at most
    /// 0) to the value below which [`SHARE`](Self::SHARE) of the area lies in the panel with the
    /// highest values: a few small cells have much higher stresses, with which all other cells
    /// would have the same colour. These cells have the colour at the top of the bar, whose number
    /// is marked with `≥`.
    ///
    /// # Errors
    /// A snapshot of another problem, [`Error::Write`].
    pub fn save(&self, path: impl AsRef<Path>, problem: &Problem<D>) -> Result<(), Error> {
        for panel in &self.panels {
            panel.snapshot.check(problem)?;
        }
        let layout = Layout::new(problem, &self.panels);
        let colours = self.colours(problem);
        save(path.as_ref(), layout.size(), |canvas| {
            for (k, panel) in self.panels.iter().enumerate() {
                let title = Text::new(panel.title.as_str(), layout.title(k), centred(TITLE));
                canvas.draw(&title)?;
                let pixels = layout.pixels(k, problem, panel.snapshot);
                let values = panel.snapshot.cells.iter().map(self.field);
                let fills: Vec<_> = values.map(|value| colours.of(value)).collect();
                let patches = patches(problem, panel.snapshot);
                paint::<D>(canvas, &pixels, &patches, &fills)?;
                outlines(canvas, &pixels, problem)?;
            }
            colour_bar(canvas, &layout, &colours, &self.label)
        })
    }

    /// The share of the reference area in one panel whose values the colours resolve (no unit).
    pub const SHARE: f64 = 0.98;

    fn colours(&self, problem: &Problem<D>) -> Colours {
        let bodies = problem.scene().bodies().iter();
        let meshes = bodies.map(|body| body.mesh());
        let areas: Vec<f64> = meshes
            .flat_map(|mesh| (0..mesh.len()).map(|cell| mesh.volume(cell)))
            .collect();
        let mut colours = Colours::default();
        let mut highest = 0.0;
        for panel in &self.panels {
            let values = panel.snapshot.cells.iter().map(self.field);
            let mut weighted: Vec<(f64, f64)> = values
                .zip(areas.iter().copied())
                .filter(|(value, _)| value.is_finite())
                .collect();
            weighted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            let all: f64 = weighted.iter().map(|(_, area)| area).sum();
            let mut below = 0.0;
            for (value, area) in weighted {
                colours.low = colours.low.min(value);
                highest = f64::max(highest, value);
                if below < Self::SHARE * all {
                    colours.high = colours.high.max(value);
                }
                below += area;
            }
        }
        colours.is_cut = highest > colours.high;
        colours
    }
}

const TITLE: u32 = 40;
const LABEL: u32 = 32;

/// The layout, with lengths in pixels: panels in a row, the colour bar to their right.
struct Layout {
    panels: u32,
    /// The point of the scene that is drawn at the upper left of every panel (UL).
    corner: Vector<2>,
    /// The scale (pixels per UL).
    scale: f64,
    height: u32,
}

impl Layout {
    const PANEL: u32 = 760;
    const GAP: u32 = 30;
    const TOP: u32 = 80;
    const BAR: u32 = 34;
    /// The width of the colour bar, its numbers and its label.
    const RIGHT: u32 = 210;

    /// The layout that shows the bodies of all panels.
    fn new<const D: usize>(problem: &Problem<D>, panels: &[Panel<'_, D>]) -> Self {
        let start: (Vector<2>, Vector<2>) = (
            Vector::repeat(f64::INFINITY),
            Vector::repeat(f64::NEG_INFINITY),
        );
        let (low, high) = panels
            .iter()
            .flat_map(|panel| {
                problem
                    .reference()
                    .iter()
                    .zip(&panel.snapshot.displacements)
            })
            .map(|(X, u)| Vector::from(project(&(X + u))))
            .fold(start, |(low, high), x| (low.inf(&x), high.sup(&x)));
        let extent = if panels.is_empty() {
            Vector::repeat(1.0)
        } else {
            high - low
        };
        let scale = f64::from(Self::PANEL) / extent[0].max(extent[1] / 2.0);
        Layout {
            panels: panels.len() as u32,
            corner: Vector::<2>::new(low[0], high[1]),
            scale,
            height: ((scale * extent[1]).ceil() as u32).max(300),
        }
    }

    fn size(&self) -> (u32, u32) {
        let width = Self::GAP + self.panels * (Self::PANEL + Self::GAP) + Self::RIGHT;
        (width, Self::TOP + self.height + Self::GAP)
    }

    fn left(&self, panel: usize) -> u32 {
        Self::GAP + panel as u32 * (Self::PANEL + Self::GAP)
    }

    fn title(&self, panel: usize) -> (i32, i32) {
        let middle = self.left(panel) + Self::PANEL / 2;
        (middle as i32, Self::TOP as i32 / 2)
    }

    /// The positions at which the nodes are drawn.
    fn pixels<const D: usize>(
        &self,
        panel: usize,
        problem: &Problem<D>,
        snapshot: &Snapshot<D>,
    ) -> Vec<(i32, i32)> {
        let (left, top) = (f64::from(self.left(panel)), f64::from(Self::TOP));
        let nodes = problem.reference().iter().zip(&snapshot.displacements);
        let pixel = |(X, u): (&Vector<D>, &Vector<D>)| {
            let from_corner = (Vector::from(project(&(X + u))) - self.corner) * self.scale;
            let x = left + from_corner[0];
            let y = top - from_corner[1];
            (x.round() as i32, y.round() as i32)
        };
        nodes.map(pixel).collect()
    }
}

/// Draws the patches, and in the plane the edges between them and the bodies' outlines; in space
/// every patch has its own edges, so that nearer patches hide them.
fn paint<const D: usize>(
    canvas: &Canvas<'_>,
    pixels: &[(i32, i32)],
    patches: &[Patch],
    colours: &[RGBColor],
) -> Result<(), DrawError> {
    // a grey that is visible on all colours
    let thin = ShapeStyle::from(&RGBColor(150, 150, 150)).stroke_width(1);
    let points = |nodes: &[usize]| nodes.iter().map(|&a| pixels[a]).collect::<Vec<_>>();
    for patch in patches {
        let colour = colours[patch.cell].filled();
        let mut around = points(&patch.nodes);
        canvas.draw(&Polygon::new(around.clone(), colour))?;
        if D > 2 {
            around.push(around[0]);
            canvas.draw(&PathElement::new(around, thin))?;
        }
    }
    if D == 2 {
        let polygons: Vec<&[usize]> = patches.iter().map(|p| p.nodes.as_slice()).collect();
        for trail in trails(&polygons) {
            canvas.draw(&PathElement::new(points(&trail), thin))?;
        }
    }
    Ok(())
}

/// Draws the bodies' boundaries, in the plane.
fn outlines<const D: usize>(
    canvas: &Canvas<'_>,
    pixels: &[(i32, i32)],
    problem: &Problem<D>,
) -> Result<(), DrawError> {
    if D > 2 {
        return Ok(());
    }
    let line = ShapeStyle::from(&BLACK).stroke_width(2);
    for (k, body) in problem.scene().bodies().iter().enumerate() {
        let first = problem.first_node(k);
        for facet in body.mesh().exterior() {
            // the ends of a side with the middle node between them
            let [start, end] = [facet[0], facet[1]];
            let nodes = [&[start], &facet[2..], &[end]].concat();
            let points: Vec<_> = nodes.iter().map(|a| pixels[first + a]).collect();
            canvas.draw(&PathElement::new(points, line))?;
        }
    }
    Ok(())
}

fn colour_bar(
    canvas: &Canvas<'_>,
    layout: &Layout,
    colours: &Colours,
    label: &str,
) -> Result<(), DrawError> {
    const STRIPES: i32 = 128;
    let left = (layout.size().0 - Layout::RIGHT) as i32;
    let right = left + Layout::BAR as i32;
    let (top, height) = (Layout::TOP as i32, layout.height as i32);
    let y = |share: f64| top + (f64::from(height) * (1.0 - share)).round() as i32;
    let span = colours.high - colours.low;
    for k in (0..STRIPES).rev() {
        // each stripe extends to the bottom, so that there are no seams
        let (from, to) = (f64::from(k), f64::from(k + 1));
        let (from, to) = (from / f64::from(STRIPES), to / f64::from(STRIPES));
        let value = colours.low + 0.5 * (from + to) * span;
        let stripe = [(left, y(to)), (right, y(0.0))];
        canvas.draw(&Rectangle::new(stripe, colours.of(value).filled()))?;
    }
    let frame = [(left, top), (right, top + height)];
    canvas.draw(&Rectangle::new(frame, BLACK.stroke_width(2)))?;
    for (value, label) in colours.ticks() {
        let at = y((value - colours.low) / span.max(f64::MIN_POSITIVE));
        let mark = vec![(right, at), (right + 8, at)];
        canvas.draw(&PathElement::new(mark, BLACK.stroke_width(2)))?;
        let beside = text(LABEL, HPos::Left);
        canvas.draw(&Text::new(label, (right + 14, at), beside))?;
    }
    let upright = ("sans-serif", LABEL)
        .into_font()
        .transform(FontTransform::Rotate270)
        .into_text_style(canvas)
        .pos(Pos::new(HPos::Center, VPos::Center));
    let middle = (right + 135, top + height / 2);
    canvas.draw(&Text::new(label.to_string(), middle, upright))
}

fn centred(size: u32) -> TextStyle<'static> {
    text(size, HPos::Center)
}

fn text(size: u32, side: HPos) -> TextStyle<'static> {
    let style = TextStyle::from(("sans-serif", size).into_font());
    style.pos(Pos::new(side, VPos::Center))
}

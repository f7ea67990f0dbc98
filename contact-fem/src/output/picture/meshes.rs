//! Pictures of deformed meshes side by side, coloured by a field on the cells.

use std::path::Path;

use plotters::element::{PathElement, Polygon};
use plotters::style::{BLACK, Color, RGBColor, ShapeStyle};

use super::colours::Colours;
use super::layout::{Layout, colour_bar, title};
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
        let drawn = |panel: &Panel<'_, D>| -> Vec<Vector<2>> {
            let nodes = problem
                .reference()
                .iter()
                .zip(&panel.snapshot.displacements);
            nodes.map(|(X, u)| project(&(X + u)).into()).collect()
        };
        let points: Vec<Vec<Vector<2>>> = self.panels.iter().map(drawn).collect();
        let layout = Layout::new(self.panels.len(), points.iter().flatten().copied());
        let colours = self.colours(problem);
        save(path.as_ref(), layout.size(), |canvas| {
            for (k, panel) in self.panels.iter().enumerate() {
                title(canvas, &layout, k, &panel.title)?;
                let pixels = points[k].iter().map(|x| layout.pixel(k, x));
                let pixels: Vec<(i32, i32)> = pixels.collect();
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

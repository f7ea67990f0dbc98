//! Pictures of deformed meshes side by side, coloured by a field on the cells.

use std::path::Path;

use plotters::element::{PathElement, Polygon};
use plotters::style::{BLACK, Color, RGBColor, ShapeStyle};

use super::colours::Colours;
use super::depth::back_to_front;
use super::layout::{Label, Layout, colour_bar, labels, scale, title};
use super::obstacles::{Shown, hatch, shown, surface};
use super::trails::trails;
use super::view::{Patch, axes, patches, project, seen};
use super::{Canvas, DrawError, save};
use crate::assembly::CellState;
use crate::contact::obstacle::outline::{Frame, Piece, outward};
use crate::error::Error;
use crate::model::Problem;
use crate::output::snapshot::Snapshot;
use crate::tensor::{Vector, unit_vector};

/// One state in a picture.
#[derive(Clone, Debug)]
pub struct Panel<'a, const D: usize> {
    /// The title above the panel.
    pub title: String,
    /// The state.
    pub snapshot: &'a Snapshot<D>,
}

/// A row of deformed meshes at one scale, with a common colour bar. Bodies in space are seen from
/// the front, the right and above, and nearer parts hide what is behind them. Obstacles that count at the state are drawn around the
/// bodies, where they are then: hatched lines in the plane, grey surfaces in space. The first panel has the names of all.
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
    /// is marked with `≥`; the largest value stands above it.
    ///
    /// # Errors
    /// A snapshot of another problem, [`Error::Write`].
    pub fn save(&self, path: impl AsRef<Path>, problem: &Problem<D>) -> Result<(), Error> {
        for panel in &self.panels {
            panel.snapshot.check(problem)?;
        }
        let positions: Vec<Vec<Vector<D>>> =
            self.panels.iter().map(|p| positions(problem, p)).collect();
        let frame = Frame::around(positions.iter().flatten().copied());
        let obstacles: Vec<Vec<Shown<D>>> = self
            .panels
            .iter()
            .map(|panel| frame.map_or(Vec::new(), |frame| shown(problem, panel.snapshot, &frame)))
            .collect();
        let pieces = obstacles.iter().flatten().flat_map(|shown| &shown.pieces);
        // in the plane names of obstacles have the whole frame
        let frame = frame.filter(|_| D == 2 && pieces.clone().next().is_some());
        let ends: Vec<Vector<D>> = frame.iter().flat_map(|f| [f.low, f.high]).collect();
        let points = positions
            .iter()
            .flatten()
            .chain(pieces.flatten())
            .chain(&ends);
        let points = points.map(|x| project(x).into());
        let layout = Layout::new(self.panels.len(), points, Layout::BOTTOM);
        let colours = self.colours(problem);
        save(path.as_ref(), layout.size(), |canvas| {
            for (k, panel) in self.panels.iter().enumerate() {
                title(canvas, &layout, k, &panel.title)?;
                let values = panel.snapshot.cells.iter().map(self.field);
                let drawing = Drawing {
                    canvas,
                    layout: &layout,
                    panel: k,
                    positions: &positions[k],
                    patches: patches(problem, panel.snapshot),
                    colours: values.map(|value| colours.of(value)).collect(),
                    obstacles: &obstacles[k],
                };
                drawing.draw(problem)?;
            }
            scale(canvas, &layout, axis_names(problem))?;
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
                colours.highest = colours.highest.max(value);
                if below < Self::SHARE * all {
                    colours.high = colours.high.max(value);
                }
                below += area;
            }
        }
        colours
    }
}

/// x of all nodes.
fn positions<const D: usize>(problem: &Problem<D>, panel: &Panel<'_, D>) -> Vec<Vector<D>> {
    let nodes = problem.reference().iter();
    let nodes = nodes.zip(&panel.snapshot.displacements);
    nodes.map(|(X, u)| X + u).collect()
}

/// The axes with their directions in the picture.
fn axis_names<const D: usize>(
    problem: &Problem<D>,
) -> impl Iterator<Item = (&'static str, [f64; 2])> {
    let names = match problem.scene().is_of_revolution() {
        true => ["r", "z", ""],
        false => ["x", "y", "z"],
    };
    let axes = names.into_iter().enumerate().take(D);
    axes.map(|(i, name)| (name, project(&unit_vector::<D>(i))))
}

/// What is drawn in a panel.
struct Drawing<'a, 'b, const D: usize> {
    canvas: &'a Canvas<'b>,
    layout: &'a Layout,
    panel: usize,
    positions: &'a [Vector<D>],
    patches: Vec<Patch>,
    /// One for each cell.
    colours: Vec<RGBColor>,
    obstacles: &'a [Shown<D>],
}

impl<const D: usize> Drawing<'_, '_, D> {
    fn draw(&self, problem: &Problem<D>) -> Result<(), DrawError> {
        let mut names = Vec::new();
        match D {
            2 => {
                for obstacle in self.obstacles {
                    hatch(self.canvas, self.layout, self.panel, &obstacle.pieces)?;
                }
                self.cells()?;
                self.outlines(problem)?;
                names = self.names_beside(problem);
            }
            _ => {
                let corners = self.corners();
                let order = back_to_front(&corners);
                self.faces(&order)?;
                if self.panel == 0 {
                    names = self.names_on(problem, &corners, &order);
                }
            }
        }
        // the first panel tells what is what
        match self.panel {
            0 => labels(self.canvas, self.layout, self.panel, &names),
            _ => Ok(()),
        }
    }

    fn pixel(&self, x: &Vector<D>) -> (i32, i32) {
        self.layout.pixel(self.panel, &project(x).into())
    }

    fn pixels(&self, nodes: &[usize]) -> Vec<(i32, i32)> {
        nodes
            .iter()
            .map(|&a| self.pixel(&self.positions[a]))
            .collect()
    }

    /// Draws the cells of the plane, and the edges between them.
    fn cells(&self) -> Result<(), DrawError> {
        for patch in &self.patches {
            let colour = self.colours[patch.cell].filled();
            let polygon = Polygon::new(self.pixels(&patch.nodes), colour);
            self.canvas.draw(&polygon)?;
        }
        let polygons: Vec<&[usize]> = self.patches.iter().map(|p| p.nodes.as_slice()).collect();
        for trail in trails(&polygons) {
            let edges = PathElement::new(self.pixels(&trail), thin());
            self.canvas.draw(&edges)?;
        }
        Ok(())
    }

    /// The parts of obstacles, with their numbers among those shown.
    fn pieces(&self) -> impl Iterator<Item = (usize, &Piece<D>)> {
        let all = self.obstacles.iter().enumerate();
        all.flat_map(|(k, obstacle)| obstacle.pieces.iter().map(move |piece| (k, piece)))
    }

    /// The corners of the faces of bodies, and then of obstacles, in the picture.
    fn corners(&self) -> Vec<Vec<Vector<3>>> {
        let place = |&a: &usize| seen(&self.positions[a]);
        let patches = self.patches.iter();
        let of_bodies = patches.map(|patch| patch.nodes.iter().map(place).collect());
        let of_obstacles = self
            .pieces()
            .map(|(_, piece)| piece.iter().map(seen).collect());
        of_bodies.chain(of_obstacles).collect()
    }

    /// Draws the faces of bodies and obstacles in space, each with its own edges, so that nearer ones hide them.
    fn faces(&self, order: &[usize]) -> Result<(), DrawError> {
        let [towards, ..] = axes::<D>();
        let pieces: Vec<&Piece<D>> = self.pieces().map(|(_, piece)| piece).collect();
        for &face in order {
            let (mut around, (fill, edge)) = match self.patches.get(face) {
                Some(patch) => {
                    let colour = self.colours[patch.cell].filled();
                    (self.pixels(&patch.nodes), (colour, Some(thin())))
                }
                None => {
                    let piece = pieces[face - self.patches.len()];
                    let around = piece.iter().map(|x| self.pixel(x)).collect();
                    (around, surface(piece, &towards))
                }
            };
            self.canvas.draw(&Polygon::new(around.clone(), fill))?;
            if let Some(edge) = edge {
                around.push(around[0]);
                self.canvas.draw(&PathElement::new(around, edge))?;
            }
        }
        Ok(())
    }

    /// Draws the bodies' boundaries, in the plane.
    fn outlines(&self, problem: &Problem<D>) -> Result<(), DrawError> {
        let line = ShapeStyle::from(&BLACK).stroke_width(2);
        for (k, body) in problem.scene().bodies().iter().enumerate() {
            let first = problem.first_node(k);
            for facet in body.mesh().exterior() {
                // the ends of a side with the middle node between them
                let [start, end] = [facet[0], facet[1]];
                let nodes = [&[start], &facet[2..], &[end]].concat();
                let nodes: Vec<usize> = nodes.iter().map(|a| first + a).collect();
                self.canvas
                    .draw(&PathElement::new(self.pixels(&nodes), line))?;
            }
        }
        Ok(())
    }

    /// The names of bodies in the plane, on them, and of obstacles, inside them beside their outlines.
    fn names_beside(&self, problem: &Problem<D>) -> Vec<Label> {
        let scene = problem.scene();
        let middle = |nodes: &[usize]| {
            let sum: Vector<D> = nodes.iter().map(|&a| self.positions[a]).sum();
            Vector::<2>::from(project(&(sum / nodes.len() as f64)))
        };
        let of_body = |(k, name): (usize, &String)| {
            let own = problem.nodes(k);
            let patches = self.patches.iter();
            let patches = patches.filter(|patch| own.contains(&patch.nodes[0]));
            let middles: Vec<_> = patches.map(|patch| middle(&patch.nodes)).collect();
            let at = most_central(&middles).into_iter().next();
            at.map(|at| Label {
                name: name.clone(),
                at,
                side: Vector::zeros(),
            })
        };
        let of_obstacle = |obstacle: &Shown<D>| {
            let piece = &obstacle.pieces[obstacle.pieces.len() / 2];
            let middle = piece.iter().sum::<Vector<D>>() / piece.len() as f64;
            let inward = -Vector::<2>::from(project(&outward(piece)));
            Label {
                name: scene.obstacle_names()[obstacle.index].clone(),
                at: project(&middle).into(),
                side: inward.try_normalize(0.0).unwrap_or(Vector::zeros()),
            }
        };
        let bodies = scene.names().iter().enumerate().filter_map(of_body);
        bodies
            .chain(self.obstacles.iter().map(of_obstacle))
            .collect()
    }

    /// The names of bodies and obstacles in space, on what is seen of them.
    fn names_on(
        &self,
        problem: &Problem<D>,
        corners: &[Vec<Vector<3>>],
        order: &[usize],
    ) -> Vec<Label> {
        let scene = problem.scene();
        let bodies = scene.names().len();
        let mut owners: Vec<usize> = (self.patches.iter())
            .map(|patch| (0..bodies).position(|k| problem.nodes(k).contains(&patch.nodes[0])))
            .map(|body| body.unwrap_or(0))
            .collect();
        owners.extend(self.pieces().map(|(k, _)| bodies + k));
        // what is nearer may hide a place
        let mut rank = vec![0; order.len()];
        order
            .iter()
            .enumerate()
            .for_each(|(k, &face)| rank[face] = k);
        let obstacles = self
            .obstacles
            .iter()
            .map(|own| &scene.obstacle_names()[own.index]);
        let names = scene.names().iter().chain(obstacles).enumerate();
        let label = |(owner, name): (usize, &String)| {
            let own = (0..corners.len()).filter(|&face| owners[face] == owner);
            let places: Vec<(usize, Vector<2>)> = own
                .flat_map(|face| {
                    places_on(&corners[face])
                        .into_iter()
                        .map(move |x| (face, x))
                })
                .collect();
            let all: Vec<Vector<2>> = places.iter().map(|(_, x)| *x).collect();
            let is_seen = |x: &&Vector<2>| {
                let mut here = places.iter().filter(|(_, y)| y == *x);
                here.any(|(face, _)| {
                    let mut nearer = order[rank[*face] + 1..].iter();
                    !nearer.any(|&other| owners[other] != owner && covers(&corners[other], x))
                })
            };
            let central = most_central(&all);
            // the middle will do for what is hidden, or costs too long to find
            let at = central.iter().take(200).find(is_seen).or(central.first());
            at.map(|&at| Label {
                name: name.clone(),
                at,
                side: Vector::zeros(),
            })
        };
        names.filter_map(label).collect()
    }
}

/// Points of a face in the picture: its middle, and others towards its corners.
fn places_on(corners: &[Vector<3>]) -> Vec<Vector<2>> {
    let flat = |x: &Vector<3>| Vector::<2>::new(x[0], x[1]);
    let middle = corners.iter().map(flat).sum::<Vector<2>>() / corners.len() as f64;
    let towards = corners.iter().map(|x| middle + (flat(x) - middle) * 0.85);
    std::iter::once(middle).chain(towards).collect()
}

/// Whether a convex face covers a place in the picture.
fn covers(corners: &[Vector<3>], x: &Vector<2>) -> bool {
    let next = corners.iter().cycle().skip(1);
    let turn = |(a, b): (&Vector<3>, &Vector<3>)| {
        (b[0] - a[0]) * (x[1] - a[1]) - (b[1] - a[1]) * (x[0] - a[0])
    };
    let turns: Vec<f64> = corners.iter().zip(next).map(turn).collect();
    turns.iter().all(|t| *t >= 0.0) || turns.iter().all(|t| *t <= 0.0)
}

/// The places by their distance from their mean: a ring has none in its middle.
fn most_central(places: &[Vector<2>]) -> Vec<Vector<2>> {
    let mean = places.iter().sum::<Vector<2>>() / places.len() as f64;
    let mut sorted = places.to_vec();
    sorted.sort_by(|a, b| (a - mean).norm().total_cmp(&(b - mean).norm()));
    sorted
}

/// The edges of cells: a grey that is visible on all colours.
fn thin() -> ShapeStyle {
    ShapeStyle::from(&RGBColor(150, 150, 150)).stroke_width(1)
}

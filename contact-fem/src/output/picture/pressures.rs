//! Pictures of the contact pressure: along the surfaces in the plane, on them in space.

use std::path::Path;

use plotters::chart::SeriesLabelPosition;
use plotters::element::{PathElement, Polygon};
use plotters::style::{Color, RGBColor, ShapeStyle};

use super::colours::Colours;
use super::curves::{Curve, Curves};
use super::layout::{Layout, colour_bar, title};
use super::save;
use crate::contact::Surface;
use crate::error::Error;
use crate::model::{Geometry, Problem};
use crate::output::snapshot::Snapshot;
use crate::tensor::Vector;

/// The contact pressure of one state.
///
/// In the plane, pressures are curves over the length along each surface, where contact is searched. The length is 0 in the centre of pressure, and grows to the
/// right there, so that the curves of two surfaces that press each other lie on top of each other. In space, the loaded part of
/// each surface has a panel, seen from outside of its body, against the mean normal.
#[derive(Clone, Copy)]
pub struct PressurePicture<'a, const D: usize> {
    problem: &'a Problem<D>,
    snapshot: &'a Snapshot<D>,
}

impl<'a, const D: usize> PressurePicture<'a, D> {
    /// A state of the problem; `None` where nothing presses.
    ///
    /// # Errors
    /// A snapshot of another problem.
    pub fn new(problem: &'a Problem<D>, snapshot: &'a Snapshot<D>) -> Result<Option<Self>, Error> {
        snapshot.check(problem)?;
        let presses = snapshot.pressures.iter().any(|p| *p > 0.0);
        Ok(presses.then_some(PressurePicture { problem, snapshot }))
    }

    /// Draws the picture as SVG at `path`.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        match D {
            // from zero, so that a constant pressure is a level line, with the legend below the curves
            2 => {
                let legend = SeriesLabelPosition::LowerMiddle;
                (self.curves()).save_with(path.as_ref(), (0.0, 0.0), legend)
            }
            _ => self.save_panels(path.as_ref()),
        }
    }

    /// The surfaces that are pressed, each with the name of its body and the pressures at its nodes.
    fn loaded(&self) -> impl Iterator<Item = (String, &'a Surface<D>, Vec<f64>)> {
        let surfaces = self.problem.surfaces().iter().map(|surface| &**surface);
        let with_pressures = surfaces.map(|surface| {
            let nodes = surface.nodes().iter();
            let pressures: Vec<f64> = nodes.map(|&a| self.snapshot.pressures[a]).collect();
            let name = self.problem.scene().names()[surface.body()].clone();
            (name, surface, pressures)
        });
        with_pressures.filter(|(_, _, pressures)| pressures.iter().any(|p| *p > 0.0))
    }

    /// Where contact is searched.
    fn positions(&self, surface: &Surface<D>) -> Vec<Vector<D>> {
        let X = surface.reference_nodes();
        match self.problem.geometry() {
            Geometry::Reference => X.to_vec(),
            Geometry::Current => {
                let u = surface.gather(&self.snapshot.displacements);
                X.iter().zip(u).map(|(X, u)| X + u).collect()
            }
        }
    }

    fn curves(&self) -> Curves {
        let (geometry, scene) = (self.problem.geometry(), self.problem.scene());
        let curves = self.loaded().flat_map(|(name, surface, pressures)| {
            let x = self.positions(surface);
            let lines = chains(surface).into_iter();
            let lines = lines.filter_map(move |chain| along(&x, &chain, &pressures));
            lines.map(move |points| Curve {
                name: name.clone(),
                points,
            })
        });
        let is_revolved = scene
            .bodies()
            .iter()
            .any(|body| body.mesh().is_of_revolution());
        let of = match (geometry, is_revolved) {
            (Geometry::Reference, false) => "undeformed length (UF/UL)",
            (Geometry::Current, false) => "current length (UF/UL)",
            (Geometry::Reference, true) => "undeformed area (UF/UL²)",
            (Geometry::Current, true) => "current area (UF/UL²)",
        };
        Curves {
            title: "Contact pressure".into(),
            x_label: "length along the surface from the centre of pressure (UL)".into(),
            y_label: format!("pressure, per {of}"),
            curves: curves.collect(),
        }
    }

    fn save_panels(&self, path: &Path) -> Result<(), Error> {
        let panels: Vec<(String, Vec<Tile>)> = (self.loaded())
            .map(|(name, surface, pressures)| (name, tiles(surface, &pressures)))
            .collect();
        let all = || panels.iter().flat_map(|(_, tiles)| tiles);
        let points = all().flat_map(|tile| tile.corners.iter().copied());
        let layout = Layout::new(panels.len(), points);
        let colours = Colours {
            high: all().map(|tile| tile.pressure).fold(0.0, f64::max),
            ..Colours::default()
        };
        save(path, layout.size(), |canvas| {
            let thin = ShapeStyle::from(&RGBColor(150, 150, 150)).stroke_width(1);
            for (k, (name, tiles)) in panels.iter().enumerate() {
                title(canvas, &layout, k, name)?;
                for tile in tiles {
                    let corners = tile.corners.iter().map(|x| layout.pixel(k, x));
                    let mut around: Vec<(i32, i32)> = corners.collect();
                    let fill = colours.of(tile.pressure).filled();
                    canvas.draw(&Polygon::new(around.clone(), fill))?;
                    around.push(around[0]);
                    canvas.draw(&PathElement::new(around, thin))?;
                }
            }
            colour_bar(canvas, &layout, &colours, "contact pressure (UF/UL²)")
        })
    }
}

/// The nodes of a curve in the plane one after the other, each connected part by itself; a closed part begins and ends with the same
/// node.
fn chains<const D: usize>(surface: &Surface<D>) -> Vec<Vec<usize>> {
    let mut next = vec![None; surface.nodes().len()];
    let mut has_previous = vec![false; next.len()];
    for facet in surface.facets() {
        // the ends of a side with the middle node between them
        let nodes = [&facet[..1], &facet[2..], &facet[1..2]].concat();
        for pair in nodes.windows(2) {
            next[pair[0]] = Some(pair[1]);
            has_previous[pair[1]] = true;
        }
    }
    let mut chains = Vec::new();
    let open = (0..next.len()).filter(|&a| !has_previous[a]);
    for start in open.chain(0..next.len()).collect::<Vec<_>>() {
        let mut chain = vec![start];
        while let Some(following) = next[chain[chain.len() - 1]].take() {
            chain.push(following);
        }
        if chain.len() > 1 {
            chains.push(chain);
        }
    }
    chains
}

/// The pressures along a chain over the length from the centre of pressure, to the second unloaded node on either side.
fn along<const D: usize>(
    x: &[Vector<D>],
    chain: &[usize],
    pressures: &[f64],
) -> Option<Vec<(f64, f64)>> {
    let is_closed = chain[0] == chain[chain.len() - 1];
    let mut chain = chain.to_vec();
    if is_closed {
        chain.pop();
        let seam = seam(&chain, pressures);
        chain.rotate_left(seam);
        chain.push(chain[0]);
    }
    let mut length = 0.0;
    let mut points = vec![(0.0, pressures[chain[0]])];
    for pair in chain.windows(2) {
        length += (x[pair[1]] - x[pair[0]]).norm();
        points.push((length, pressures[pair[1]]));
    }
    let first = points.iter().position(|(_, p)| *p > 0.0)?;
    let last = points.iter().rposition(|(_, p)| *p > 0.0)?;
    let (first, last) = (first.saturating_sub(2), (last + 2).min(points.len() - 1));
    // of the pressure that is linear between the nodes
    let [mut force, mut moment] = [0.0; 2];
    for pair in points.windows(2) {
        let [(s, p), (t, q)] = [pair[0], pair[1]];
        force += 0.5 * (t - s) * (p + q);
        moment += (t - s) / 6.0 * (p * (2.0 * s + t) + q * (s + 2.0 * t));
    }
    let centre = moment / force;
    let towards = x[chain[last]] - x[chain[first]];
    let is_leftward = towards[0] < 0.0 || (towards[0] == 0.0 && towards[1] < 0.0);
    let sign = if is_leftward { -1.0 } else { 1.0 };
    let shown = points[first..=last].iter();
    Some(shown.map(|&(s, p)| (sign * (s - centre), p)).collect())
}

/// Where a closed chain is cut: in the middle of the most unloaded nodes in a row.
fn seam(chain: &[usize], pressures: &[f64]) -> usize {
    let count = chain.len();
    let loaded = (0..count).filter(|&k| pressures[chain[k]] > 0.0);
    let loaded: Vec<usize> = loaded.collect();
    let following = loaded.iter().cycle().skip(1);
    let ways = loaded.iter().zip(following);
    let way = ways.map(|(&from, &to)| ((to + count - from - 1) % count + 1, from));
    way.max()
        .map_or(0, |(length, from)| (from + length / 2) % count)
}

/// A triangle of a surface as it is drawn, with the mean pressure of its corners.
struct Tile {
    corners: Vec<Vector<2>>,
    pressure: f64,
}

/// The facets with a loaded node and those next to them; quadratic ones in four parts.
fn tiles<const D: usize>(surface: &Surface<D>, pressures: &[f64]) -> Vec<Tile> {
    let X = surface.reference_nodes();
    let weighted = |a: usize| pressures[a];
    let total: f64 = (0..X.len()).map(weighted).sum();
    let centre = (0..X.len())
        .map(|a| X[a] * (weighted(a) / total))
        .sum::<Vector<D>>();
    let normals = surface.reference_normals();
    let normal: Vector<D> = (0..X.len()).map(|a| normals[a] * weighted(a)).sum();
    let [right, up] = across(&normal);
    let drawn = |a: usize| {
        let x = X[a] - centre;
        Vector::<2>::new(x.dot(&right), x.dot(&up))
    };
    let mut is_near = vec![false; X.len()];
    for facet in surface.facets() {
        if facet.iter().any(|&a| pressures[a] > 0.0) {
            facet.iter().for_each(|&a| is_near[a] = true);
        }
    }
    let shown = surface
        .facets()
        .filter(|facet| facet.iter().any(|&a| is_near[a]));
    let parts = shown.flat_map(|facet| match facet.len() {
        6 => [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
            .map(|part| part.map(|k| facet[k]))
            .to_vec(),
        _ => vec![[facet[0], facet[1], facet[D - 1]]],
    });
    let tile = |corners: [usize; 3]| Tile {
        corners: corners.map(drawn).to_vec(),
        pressure: corners.iter().map(|&a| pressures[a]).sum::<f64>() / 3.0,
    };
    parts.map(tile).collect()
}

/// Two unit vectors across `normal`: to the right and up for who looks against it.
fn across<const D: usize>(normal: &Vector<D>) -> [Vector<D>; 2] {
    let n = normal.normalize();
    let axis = |i: usize| Vector::<D>::from_fn(|j, _| f64::from(u8::from(i == j)));
    // the last axis is up, unless the normal is along it
    let upward = if n[D - 1].abs() < 0.9 {
        axis(D - 1)
    } else {
        axis(D - 2)
    };
    let up = (upward - n * n.dot(&upward)).normalize();
    let right = match D {
        3 => Vector::<D>::from_fn(|i, _| {
            let (j, k) = ((i + 1) % D, (i + 2) % D);
            up[j] * n[k] - up[k] * n[j]
        }),
        _ => up,
    };
    [right, up]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Order;

    /// A wall that faces x is seen with z up and y to the right; a floor from below has no vertical of its own.
    #[test]
    fn right_and_up() {
        let [right, up] = across(&Vector::<3>::new(2.0, 0.0, 0.0));
        assert!((right - Vector::<3>::new(0.0, 1.0, 0.0)).norm() < 1e-15);
        assert!((up - Vector::<3>::new(0.0, 0.0, 1.0)).norm() < 1e-15);
        let [right, up] = across(&Vector::<3>::new(0.0, 0.0, -1.0));
        let towards = right.cross(&up);
        assert!((towards - Vector::<3>::new(0.0, 0.0, -1.0)).norm() < 1e-15);
    }

    fn loop_of(x: &[[f64; 2]]) -> Surface<2> {
        let x: Vec<Vector<2>> = x.iter().map(|x| Vector::from(*x)).collect();
        let facets: Vec<[usize; 2]> = (0..x.len()).map(|a| [a, (a + 1) % x.len()]).collect();
        Surface::new(0, Order::Linear, facets.iter().map(|f| &f[..]), &x)
    }

    /// Around a square of side 4 with nodes 2 apart, the pressure is around one corner: the curve has its centre there, and ends two nodes
    /// beyond it, wherever the list of nodes begins.
    #[test]
    fn a_closed_line_is_cut_where_nothing_presses() {
        let square = [
            [0, 0],
            [2, 0],
            [4, 0],
            [4, 2],
            [4, 4],
            [2, 4],
            [0, 4],
            [0, 2],
        ];
        let square = square.map(|x| x.map(f64::from));
        let surface = loop_of(&square);
        let chains = chains(&surface);
        assert_eq!(chains.len(), 1);
        let at = |x: [f64; 2]| {
            let mut nodes = surface.reference_nodes().iter();
            nodes.position(|y| *y == Vector::from(x)).expect("a node")
        };
        for corner in [[0.0, 0.0], [4.0, 4.0]] {
            let mut pressures = vec![0.0; 8];
            pressures[at(corner)] = 3.0;
            let points = along(surface.reference_nodes(), &chains[0], &pressures).expect("a load");
            let mut points = points;
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let expected = [(-4.0, 0.0), (-2.0, 0.0), (0.0, 3.0), (2.0, 0.0), (4.0, 0.0)];
            assert_eq!(points, expected, "{corner:?}");
        }
        assert_eq!(
            along(surface.reference_nodes(), &chains[0], &[0.0; 8]),
            None
        );
    }

    /// A constant pressure on a line from 0 to 4 has its centre at 2, wherever the nodes are.
    #[test]
    fn the_centre_does_not_depend_on_the_nodes() {
        let x = [0.0, 0.25, 0.5, 1.0, 4.0].map(|x| Vector::<2>::new(x, 0.0));
        let points = along(&x, &[0, 1, 2, 3, 4], &[3.0; 5]).expect("a load");
        assert_eq!((points[0].0, points[4].0), (-2.0, 2.0));
    }
}

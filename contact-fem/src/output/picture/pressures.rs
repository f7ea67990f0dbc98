//! Pictures of the contact pressure: along the surfaces in the plane, on them in space.

use std::path::Path;

use plotters::element::{PathElement, Polygon};
use plotters::style::{Color, RGBColor, ShapeStyle};

use super::colours::Colours;
use super::curves::{Curve, Curves};
use super::layout::{Layout, colour_bar, title};
use super::save;
use crate::contact::Surface;
use crate::error::Error;
use crate::model::{Geometry, Problem};
use crate::output::snapshot::{Place, Snapshot};
use crate::tensor::Vector;

/// The contact pressure of one state.
///
/// In the plane, pressures are curves over the length along the surface, where contact is searched: one for each place of contact,
/// which is a side of a pair or a boundary on an obstacle, and for each zone of it by itself. The length is 0 in the centre of
/// pressure of the zone, and grows to the right there, so that the curves of two surfaces that press each other lie on top of each
/// other. In space, the loaded part of each place has a panel, seen from outside of its body, against the mean normal.
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
        let mut pressures = snapshot.places.iter().flat_map(|place| &place.pressures);
        let presses = pressures.any(|p| *p > 0.0);
        Ok(presses.then_some(PressurePicture { problem, snapshot }))
    }

    /// Draws the picture as SVG at `path`.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        match D {
            // from zero, so that a constant pressure is a level line
            2 => self.curves().save_from_zero(path.as_ref()),
            _ => self.save_panels(path.as_ref()),
        }
    }

    /// The places of contact that are pressed, with their surfaces.
    fn loaded(&self) -> impl Iterator<Item = (&'a Place, &'a Surface<D>)> {
        let places = self.snapshot.places.iter();
        let pressed = places.filter(|place| place.pressures.iter().any(|p| *p > 0.0));
        pressed.map(|place| (place, &*self.problem.surfaces()[place.surface]))
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
        let mut curves = Vec::new();
        for (place, surface) in self.loaded() {
            let x = self.positions(surface);
            let chains = chains(surface);
            let zones = chains
                .iter()
                .flat_map(|chain| zones(chain, &place.pressures));
            let zones: Vec<_> = zones
                .filter_map(|zone| along(&x, &zone, &place.pressures))
                .collect();
            let count = zones.len();
            curves.extend(zones.into_iter().enumerate().map(|(k, points)| Curve {
                name: match count {
                    1 => place.name.clone(),
                    _ => format!("{} ({})", place.name, k + 1),
                },
                points,
            }));
        }
        let of = match self.problem.geometry() {
            Geometry::Reference => "undeformed",
            Geometry::Current => "current",
        };
        Curves {
            title: match &curves[..] {
                [only] => format!("Contact pressure: {}", only.name),
                _ => "Contact pressure".into(),
            },
            x_label: "length along the surface from the centre of pressure (UL)".into(),
            y_label: format!("pressure, per {of} area (UF/UL²)"),
            curves,
        }
    }

    fn save_panels(&self, path: &Path) -> Result<(), Error> {
        let panels: Vec<(String, Vec<Tile>)> = (self.loaded())
            .map(|(place, surface)| (place.name.clone(), tiles(surface, &place.pressures)))
            .collect();
        let all = || panels.iter().flat_map(|(_, tiles)| tiles);
        let points = all().flat_map(|tile| tile.corners.iter().copied());
        let layout = Layout::new(panels.len(), points, 0);
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

/// The parts of a chain that are loaded, each with two unloaded nodes on either side where there are some. A part ends where more
/// than [`APART`] nodes in a row have no pressure. A closed chain is cut where nothing presses.
fn zones(chain: &[usize], pressures: &[f64]) -> Vec<Vec<usize>> {
    let mut chain = chain.to_vec();
    if chain.len() > 1 && chain[0] == chain[chain.len() - 1] {
        chain.pop();
        let seam = seam(&chain, pressures);
        chain.rotate_left(seam);
        chain.push(chain[0]);
    }
    let loaded = (0..chain.len()).filter(|&k| pressures[chain[k]] > 0.0);
    let mut zones: Vec<[usize; 2]> = Vec::new();
    for k in loaded {
        match zones.last_mut() {
            Some([_, last]) if k - *last <= APART + 1 => *last = k,
            _ => zones.push([k, k]),
        }
    }
    let part = |[first, last]: [usize; 2]| {
        let end = (last + 2).min(chain.len() - 1);
        chain[first.saturating_sub(2)..=end].to_vec()
    };
    zones.into_iter().map(part).collect()
}

/// The most unloaded nodes in a row within a zone of contact.
const APART: usize = 4;

/// The pressures along a chain over the length from the centre of pressure.
fn along<const D: usize>(
    x: &[Vector<D>],
    chain: &[usize],
    pressures: &[f64],
) -> Option<Vec<(f64, f64)>> {
    let mut length = 0.0;
    let mut points = vec![(0.0, pressures[chain[0]])];
    for pair in chain.windows(2) {
        length += (x[pair[1]] - x[pair[0]]).norm();
        points.push((length, pressures[pair[1]]));
    }
    // of the pressure that is linear between the nodes
    let [mut force, mut moment] = [0.0; 2];
    for pair in points.windows(2) {
        let [(s, p), (t, q)] = [pair[0], pair[1]];
        force += 0.5 * (t - s) * (p + q);
        moment += (t - s) / 6.0 * (p * (2.0 * s + t) + q * (s + 2.0 * t));
    }
    if !(force > 0.0) {
        return None;
    }
    let centre = moment / force;
    let towards = x[chain[chain.len() - 1]] - x[chain[0]];
    let is_leftward = towards[0] < 0.0 || (towards[0] == 0.0 && towards[1] < 0.0);
    let sign = if is_leftward { -1.0 } else { 1.0 };
    let from_centre = points.into_iter().map(|(s, p)| (sign * (s - centre), p));
    Some(from_centre.collect())
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
            let zones = zones(&chains[0], &pressures);
            assert_eq!(zones.len(), 1);
            let mut points =
                along(surface.reference_nodes(), &zones[0], &pressures).expect("a load");
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let expected = [(-4.0, 0.0), (-2.0, 0.0), (0.0, 3.0), (2.0, 0.0), (4.0, 0.0)];
            assert_eq!(points, expected, "{corner:?}");
        }
        assert!(zones(&chains[0], &[0.0; 8]).is_empty());
        assert_eq!(
            along(surface.reference_nodes(), &chains[0], &[0.0; 8]),
            None
        );
    }

    /// Pressures at nodes 2, 3 and 5 are one zone, those at 11 and 12 another one: five nodes between them have none. Each has its own
    /// centre: by hand, with p = 3, 1, 2 at s = 2, 3, 5 and unit spacing at (6 + 3 + 10)/6, and in the middle of 11 and 12.
    #[test]
    fn zones_apart_have_centres_of_their_own() {
        let x: Vec<Vector<2>> = (0..14)
            .map(|k| Vector::<2>::new(f64::from(k), 0.0))
            .collect();
        let chain: Vec<usize> = (0..14).collect();
        let mut pressures = [0.0; 14];
        for (node, p) in [(2, 3.0), (3, 1.0), (5, 2.0), (11, 1.0), (12, 1.0)] {
            pressures[node] = p;
        }
        let zones = zones(&chain, &pressures);
        assert_eq!(zones, [(0..=7).collect::<Vec<_>>(), (9..=13).collect()]);
        for (zone, centre) in zones.iter().zip([19.0 / 6.0, 11.5]) {
            let points = along(&x, zone, &pressures).expect("a load");
            for ((s, _), &node) in points.iter().zip(zone) {
                assert!((s - (node as f64 - centre)).abs() < 1e-13, "{s} at {node}");
            }
        }
        // one node nearer, and they are one
        pressures[10] = 1.0;
        assert_eq!(super::zones(&chain, &pressures).len(), 1);
    }

    /// A constant pressure on a line from 0 to 4 has its centre at 2, wherever the nodes are.
    #[test]
    fn the_centre_does_not_depend_on_the_nodes() {
        let x = [0.0, 0.25, 0.5, 1.0, 4.0].map(|x| Vector::<2>::new(x, 0.0));
        let points = along(&x, &[0, 1, 2, 3, 4], &[3.0; 5]).expect("a load");
        assert_eq!((points[0].0, points[4].0), (-2.0, 2.0));
    }
}

//! Structured meshes of simple shapes with named boundaries.

use std::f64::consts::{PI, TAU};

use super::Mesh;
use crate::error::Error;

/// How the quadrilaterals of a grid are cut into triangles.
///
/// Along one diagonal every node has the same surroundings, which keeps contact pressures smooth;
/// alternating diagonals make two kinds of nodes, and pressures of linear triangles alternate with
/// them by a few percent. In polar grids the radius takes the place of x and the angle that of y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Diagonals {
    /// From the corner with the smallest x and y to the one with the largest.
    #[default]
    Rising,
    /// Across that.
    Falling,
    /// Alternating like a chessboard.
    Alternating,
}

/// `count + 1` equally spaced values from `from` to `to`.
pub fn linspace(from: f64, to: f64, count: usize) -> Vec<f64> {
    let at = |k: usize| from + (to - from) * k as f64 / count as f64;
    (0..=count).map(at).collect()
}

/// `count + 1` values from `from` to `to` whose spacing changes by a constant factor q, so that the
/// first step is `first` (UL) long.
///
/// # Errors
/// Values that are not finite, fewer than two steps, and a first step that no q between 1/1000 and
/// 1000 leads to.
pub fn graded(from: f64, to: f64, first: f64, count: usize) -> Result<Vec<f64>, Error> {
    const STEEPEST: f64 = 1e3;
    Error::check_finite("graded(from, to, first)", &[from, to, first])?;
    if count < 2 {
        return Err(Error::Setting {
            name: "count",
            value: count as f64,
            remedy: "grade at least two steps",
        });
    }
    // the whole length over the first step's: 1 + q + q² + …
    let sum = |q: f64, steps: usize| (0..steps).map(|k| q.powi(k as i32)).sum::<f64>();
    let target = (to - from).abs() / first;
    let (mut low, mut high) = (1.0 / STEEPEST, STEEPEST);
    if !(sum(low, count) <= target && target <= sum(high, count)) {
        return Err(Error::Setting {
            name: "first",
            value: first,
            remedy: "give a first step that is positive and shorter than the whole length",
        });
    }
    for _ in 0..200 {
        let q = 0.5 * (low + high);
        match sum(q, count) < target {
            true => low = q,
            false => high = q,
        }
    }
    let at = |k: usize| from + (to - from) * sum(low, k) / sum(low, count);
    let mut values: Vec<f64> = (0..=count).map(at).collect();
    values[count] = to;
    Ok(values)
}

/// A rectangle on the grid `xs` × `ys` (both ascending, UL), each cell of the grid cut in two.
/// Boundaries: `bottom`, `right`, `top`, `left`.
///
/// # Errors
/// As [`Mesh::new`], for values that do not ascend or are fewer than two.
pub fn rectangle(xs: &[f64], ys: &[f64], diagonals: Diagonals) -> Result<Mesh<2>, Error> {
    ascending("xs", xs)?;
    ascending("ys", ys)?;
    let nodes = ys.iter().flat_map(|&y| xs.iter().map(move |&x| [x, y]));
    let mut cells = Vec::new();
    let columns = xs.len();
    for j in 0..ys.len() - 1 {
        for i in 0..columns - 1 {
            let a = j * columns + i;
            let corners = [a, a + 1, a + columns + 1, a + columns];
            split(&mut cells, corners, diagonals.first(i + j));
        }
    }
    let mut mesh = Mesh::new(nodes.collect(), cells)?;
    let (x0, x1, y0, y1) = (xs[0], xs[xs.len() - 1], ys[0], ys[ys.len() - 1]);
    mesh.name_boundary("bottom", |X| X[1] == y0);
    mesh.name_boundary("right", |X| X[0] == x1);
    mesh.name_boundary("top", |X| X[1] == y1);
    mesh.name_boundary("left", |X| X[0] == x0);
    Ok(mesh)
}

/// A ring with nodes at `radii` (ascending, UL) and angles 2πi/`segments`.
/// Boundaries: `inner`, `outer`.
///
/// # Errors
/// As [`rectangle`]; `segments` < 3; an inner radius that is not positive.
pub fn annulus(radii: &[f64], segments: usize, diagonals: Diagonals) -> Result<Mesh<2>, Error> {
    let angles = full_circle(segments, 0.0)?;
    positive("radii[0]", radii.first().copied())?;
    polar(radii, &angles, true, diagonals)
}

/// A disc of the given radius (UL) around the origin: `rings` rings of `segments` nodes at angles
/// `phase` + 2πi/`segments`, a fan at the centre. Boundary: `boundary`.
///
/// # Errors
/// As [`annulus`].
pub fn disc(radius: f64, segments: usize, rings: usize, phase: f64) -> Result<Mesh<2>, Error> {
    let angles = full_circle(segments, phase)?;
    positive("radius", Some(radius))?;
    positive("rings", Some(rings as f64))?;
    let mut mesh = polar(
        &linspace(0.0, radius, rings),
        &angles,
        true,
        Diagonals::Rising,
    )?;
    let outer = mesh.boundaries.remove("outer").unwrap_or_default();
    mesh.boundaries.insert("boundary".into(), outer);
    Ok(mesh)
}

/// The lower half of a disc around the origin: nodes at `radii` (ascending from 0, UL) and
/// `angles` (ascending from π to 2π). Boundaries: `arc`, `flat`.
///
/// # Errors
/// As [`rectangle`]; angles that do not run from π to 2π.
pub fn half_disc(radii: &[f64], angles: &[f64], diagonals: Diagonals) -> Result<Mesh<2>, Error> {
    sector(radii, angles, PI, diagonals)
}

/// The quarter of a disc from straight below the origin to its right, for scenes symmetric about
/// x = 0: `angles` ascend from 3π/2 to 2π. Boundaries: `arc`, `flat` (y = 0) and `axis` (x = 0).
///
/// # Errors
/// As [`half_disc`].
pub fn quarter_disc(radii: &[f64], angles: &[f64], diagonals: Diagonals) -> Result<Mesh<2>, Error> {
    let mut mesh = sector(radii, angles, 1.5 * PI, diagonals)?;
    mesh.name_boundary("axis", |X| X[0] == 0.0);
    Ok(mesh)
}

/// A sector of a disc from `first` to 2π with its straight edge on y = 0 called `flat`.
fn sector(
    radii: &[f64],
    angles: &[f64],
    first: f64,
    diagonals: Diagonals,
) -> Result<Mesh<2>, Error> {
    if radii.first() != Some(&0.0) {
        return Err(Error::Setting {
            name: "radii[0]",
            value: radii.first().copied().unwrap_or(f64::NAN),
            remedy: "start at the centre, 0",
        });
    }
    let (start, end) = (angles.first().copied(), angles.last().copied());
    let spans = |a: Option<f64>, b: f64| a.is_some_and(|a| (a - b).abs() < 1e-9);
    if !(spans(start, first) && spans(end, TAU)) {
        return Err(Error::Setting {
            name: "angles",
            value: start.unwrap_or(f64::NAN),
            remedy: "ascend to 2π from π (half disc) or 3π/2 (quarter disc)",
        });
    }
    let mut mesh = polar(radii, angles, false, diagonals)?;
    let arc = mesh.boundaries.remove("outer").unwrap_or_default();
    mesh.boundaries.insert("arc".into(), arc);
    mesh.name_boundary("flat", |X| X[1] == 0.0);
    Ok(mesh)
}

/// A grid in polar coordinates; a first radius of 0 collapses to one node with a fan around it.
/// Boundaries: `outer`, and `inner` unless collapsed.
fn polar(
    radii: &[f64],
    angles: &[f64],
    closed: bool,
    diagonals: Diagonals,
) -> Result<Mesh<2>, Error> {
    ascending("radii", radii)?;
    ascending("angles", angles)?;
    let columns = angles.len();
    let collapsed = radii[0] == 0.0;
    let mut nodes = Vec::new();
    if collapsed {
        nodes.push([0.0, 0.0]);
    }
    let rings = &radii[usize::from(collapsed)..];
    let on_axes = |r: f64, angle: f64| {
        // nodes that should lie on an axis lie there exactly
        let (s, c) = angle.sin_cos();
        [c, s].map(|v| {
            if v.abs() < 1e-15 * angle.max(1.0) {
                0.0
            } else {
                r * v
            }
        })
    };
    for &r in rings {
        nodes.extend(angles.iter().map(|&angle| on_axes(r, angle)));
    }
    let node = |ring: usize, i: usize| usize::from(collapsed) + ring * columns + i % columns;
    let steps = if closed { columns } else { columns - 1 };
    let mut cells = Vec::new();
    for i in 0..if collapsed { steps } else { 0 } {
        cells.extend([0, node(0, i), node(0, i + 1)]);
    }
    for ring in 0..rings.len() - 1 {
        for i in 0..steps {
            let corners = [
                node(ring, i),
                node(ring + 1, i),
                node(ring + 1, i + 1),
                node(ring, i + 1),
            ];
            split(&mut cells, corners, diagonals.first(ring + i));
        }
    }
    let mut mesh = Mesh::new(nodes, cells)?;
    let reach = |X: &crate::tensor::Vector<2>, r: f64| (X.norm() - r).abs() < 1e-12 * r;
    let outer = radii[radii.len() - 1];
    mesh.name_boundary("outer", |X| reach(X, outer));
    if !collapsed {
        mesh.name_boundary("inner", |X| reach(X, radii[0]));
    }
    Ok(mesh)
}

impl Diagonals {
    /// Whether the cell whose grid indices sum to `index` is cut along its first diagonal.
    fn first(self, index: usize) -> bool {
        match self {
            Diagonals::Rising => true,
            Diagonals::Falling => false,
            Diagonals::Alternating => index % 2 == 0,
        }
    }
}

/// Cuts a counter-clockwise quadrilateral along its first or second diagonal.
fn split(cells: &mut Vec<usize>, [a, b, c, d]: [usize; 4], first: bool) {
    if first {
        cells.extend([a, b, c, a, c, d]);
    } else {
        cells.extend([a, b, d, b, c, d]);
    }
}

fn full_circle(segments: usize, phase: f64) -> Result<Vec<f64>, Error> {
    if segments < 3 {
        return Err(Error::Setting {
            name: "segments",
            value: segments as f64,
            remedy: "a circle needs at least 3",
        });
    }
    let at = |i: usize| phase + TAU * i as f64 / segments as f64;
    Ok((0..segments).map(at).collect())
}

fn ascending(name: &'static str, values: &[f64]) -> Result<(), Error> {
    Error::check_finite(name, values)?;
    if values.len() < 2 {
        return Err(Error::Setting {
            name,
            value: values.len() as f64,
            remedy: "give at least two grid values",
        });
    }
    match values.windows(2).find(|pair| pair[1] <= pair[0]) {
        Some(pair) => Err(Error::Setting {
            name,
            value: pair[1],
            remedy: "grid values must ascend strictly",
        }),
        None => Ok(()),
    }
}

fn positive(name: &'static str, value: Option<f64>) -> Result<(), Error> {
    match value {
        Some(v) if v > 0.0 && v.is_finite() => Ok(()),
        other => Err(Error::Setting {
            name,
            value: other.unwrap_or(f64::NAN),
            remedy: "must be positive and finite",
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(mesh: &Mesh<2>) -> f64 {
        (0..mesh.len()).map(|k| mesh.volume(k)).sum()
    }

    /// Area of a regular polygon with `n` corners on a circle of radius `r`.
    fn polygon(n: usize, r: f64) -> f64 {
        0.5 * n as f64 * r * r * (TAU / n as f64).sin()
    }

    #[test]
    fn areas_and_boundaries() {
        let mesh = rectangle(
            &linspace(0.0, 2.0, 4),
            &graded(-1.0, 0.5, 0.1, 5).expect("grading"),
            Diagonals::Rising,
        )
        .expect("mesh");
        assert!((area(&mesh) - 3.0).abs() < 1e-14);
        assert_eq!(mesh.boundary("top").expect("named").len(), 4);
        assert_eq!(mesh.boundary_nodes("left").expect("named").len(), 6);

        let mesh = annulus(&[0.7, 1.0, 2.0], 64, Diagonals::Alternating).expect("mesh");
        assert!((area(&mesh) - polygon(64, 2.0) + polygon(64, 0.7)).abs() < 1e-12);
        assert_eq!(mesh.boundary("inner").expect("named").len(), 64);
        assert_eq!(mesh.exterior().len(), 128);

        let mesh = disc(0.6, 52, 3, 0.03).expect("mesh");
        assert!((area(&mesh) - polygon(52, 0.6)).abs() < 1e-12);
        assert_eq!(mesh.boundary("boundary").expect("named").len(), 52);
        assert_eq!(mesh.len(), 52 * 5);

        let mesh = half_disc(
            &linspace(0.0, 1.0, 3),
            &linspace(PI, TAU, 16),
            Diagonals::Alternating,
        )
        .expect("mesh");
        assert!((area(&mesh) - 0.5 * polygon(32, 1.0)).abs() < 1e-12);
        assert_eq!(mesh.boundary("flat").expect("named").len(), 6);
        assert_eq!(mesh.boundary("arc").expect("named").len(), 16);

        let mesh = quarter_disc(
            &linspace(0.0, 1.0, 3),
            &linspace(1.5 * PI, TAU, 8),
            Diagonals::Rising,
        )
        .expect("mesh");
        assert_eq!(mesh.boundary("axis").expect("named").len(), 3);
        assert_eq!(mesh.boundary("flat").expect("named").len(), 3);
    }

    #[test]
    fn gradings_start_with_the_step_asked_for() {
        for (from, to, first) in [(0.0, 3.0, 0.1), (2.0, -1.0, 0.5), (0.0, 1.0, 0.9)] {
            let values = graded(from, to, first, 6).expect("possible");
            assert_eq!((values.len(), values[0], values[6]), (7, from, to));
            assert!(((values[1] - from).abs() - first).abs() < 1e-12);
            let ratio = |k: usize| (values[k + 1] - values[k]) / (values[k] - values[k - 1]);
            assert!((2..6).all(|k| (ratio(k) - ratio(1)).abs() < 1e-9 * ratio(1)));
        }
        for first in [0.0, -0.1, 2.0, f64::NAN, f64::INFINITY, 1e-300] {
            graded(0.0, 1.0, first, 6).expect_err("impossible");
        }
        graded(0.0, 1.0, 0.1, 1).expect_err("one step");
    }

    #[test]
    fn unknown_names_list_the_known_ones() {
        let mesh = disc(1.0, 8, 1, 0.0).expect("mesh");
        let message = mesh.boundary("rim").expect_err("unknown").to_string();
        assert!(
            message.contains("rim") && message.contains("boundary"),
            "{message}"
        );
    }

    #[test]
    fn bad_cells_are_named() {
        let nodes = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [2.0, 0.0]];
        let error = |cells| Mesh::<2>::new(nodes.clone(), cells).expect_err("bad");
        assert!(matches!(
            error(vec![0, 1, 2, 1, 2, 3]),
            Error::InvertedCell { cell: 1, .. }
        ));
        assert!(matches!(
            error(vec![0, 1, 2, 0, 1, 3]),
            Error::DegenerateCell { cell: 1, .. }
        ));
        assert!(matches!(
            error(vec![0, 1, 7]),
            Error::NodeOutOfRange {
                cell: 0,
                node: 7,
                nodes: 4
            }
        ));
        assert!(matches!(
            error(vec![0, 1, 2]),
            Error::OrphanNode { node: 3 }
        ));
        assert!(matches!(error(vec![]), Error::EmptyMesh));
        let far = vec![[0.0, 0.0], [1e200, 0.0], [0.0, 1e200]];
        assert!(matches!(
            Mesh::<2>::new(far, vec![0, 1, 2]),
            Err(Error::DegenerateCell { cell: 0, .. })
        ));
        let nan = vec![[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]];
        assert!(matches!(
            Mesh::<2>::new(nan, vec![0, 1, 2]),
            Err(Error::NotFinite { .. })
        ));
    }
}

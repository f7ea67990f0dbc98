//! Discs, rings and sectors around the origin.

use std::f64::consts::{PI, TAU};

use super::rectangle::{Diagonals, split};
use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesh::generators::{affordable, ascending, linspace, positive};
use crate::tensor::Vector;

/// A ring with nodes at `radii` (ascending, UL) and angles 2πi/`segments`.
/// Boundaries: `inner`, `outer`.
///
/// # Errors
/// As [`rectangle`](super::rectangle()); also if `segments` < 3, the inner radius is not positive,
/// or there are more than 10⁸ triangles.
pub fn annulus(radii: &[f64], segments: usize, diagonals: Diagonals) -> Result<Mesh<2>, Error> {
    affordable(2.0 * radii.len() as f64 * segments as f64)?;
    let angles = full_circle(segments, 0.0)?;
    positive("radii[0]", radii.first().copied())?;
    polar(radii, &angles, true, diagonals)
}

/// A disc of the given radius (UL) around the origin: `rings` rings with `segments` nodes at angles
/// `phase` + 2πi/`segments`, and a fan at the centre. Boundary: `boundary`.
///
/// # Errors
/// As [`annulus`].
pub fn disc(radius: f64, segments: usize, rings: usize, phase: f64) -> Result<Mesh<2>, Error> {
    affordable(2.0 * rings as f64 * segments as f64)?;
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

/// A disc of the given radius (UL) around the origin with 6 `rings`² nearly equilateral triangles:
/// the k-th of `rings` equidistant rings has 6k nodes. Boundary: `boundary`.
///
/// # Errors
/// If the radius is not positive and finite, `rings` is 0, or there are more than 10⁸ triangles.
pub fn equilateral_disc(radius: f64, rings: usize) -> Result<Mesh<2>, Error> {
    positive("radius", Some(radius))?;
    positive("rings", Some(rings as f64))?;
    affordable(6.0 * (rings as f64).powi(2))?;
    let mut nodes = vec![[0.0, 0.0]];
    for ring in 1..=rings {
        let r = radius * ring as f64 / rings as f64;
        let angle = |i: usize| TAU * i as f64 / (6 * ring) as f64;
        nodes.extend((0..6 * ring).map(|i| on_circle(r, angle(i))));
    }
    let node = |ring: usize, i: usize| match ring {
        0 => 0,
        _ => 1 + 3 * ring * (ring - 1) + i % (6 * ring),
    };
    let mut cells = Vec::new();
    for ring in 0..rings {
        for sixth in 0..6 {
            for i in 0..=ring {
                let inner = [i, i + 1].map(|i| node(ring, sixth * ring + i));
                let outer = [i, i + 1].map(|i| node(ring + 1, sixth * (ring + 1) + i));
                cells.extend([inner[0], outer[0], outer[1]]);
                if i < ring {
                    cells.extend([inner[0], outer[1], inner[1]]);
                }
            }
        }
    }
    let mut mesh = Mesh::new(nodes, cells)?;
    mesh.name_boundary("boundary", |X| on_radius(X, radius));
    Ok(mesh)
}

/// The lower half of a disc around the origin: nodes at `radii` (ascending from 0, UL) and
/// `angles` (ascending from π to 2π). Boundaries: `arc`, `flat`.
///
/// # Errors
/// As [`rectangle`](super::rectangle()); also if the angles do not run from π to 2π.
pub fn half_disc(radii: &[f64], angles: &[f64], diagonals: Diagonals) -> Result<Mesh<2>, Error> {
    sector(radii, angles, PI, diagonals)
}

/// A quarter of a disc, from straight below the origin to its right, for scenes that are symmetric
/// about x = 0. The `angles` ascend from 3π/2 to 2π. Boundaries: `arc`, `flat` (y = 0) and `axis`
/// (x = 0).
///
/// # Errors
/// As [`half_disc`].
pub fn quarter_disc(radii: &[f64], angles: &[f64], diagonals: Diagonals) -> Result<Mesh<2>, Error> {
    let mut mesh = sector(radii, angles, 1.5 * PI, diagonals)?;
    mesh.name_boundary("axis", |X| X[0] == 0.0);
    Ok(mesh)
}

/// A sector of a disc from angle `first` to 2π, with the boundary `flat` on y = 0.
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
    // the sides are straight to the last digit
    let mut angles = angles.to_vec();
    angles[0] = first;
    if let Some(end) = angles.last_mut() {
        *end = TAU;
    }
    let mut mesh = polar(radii, &angles, false, diagonals)?;
    let arc = mesh.boundaries.remove("outer").unwrap_or_default();
    mesh.boundaries.insert("arc".into(), arc);
    mesh.name_boundary("flat", |X| X[1] == 0.0);
    Ok(mesh)
}

/// A grid in polar coordinates; a first radius of 0 gives one node with a fan of triangles around
/// it. Boundaries: `outer`, and `inner` unless the first radius is 0.
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
    for &r in rings {
        nodes.extend(angles.iter().map(|&angle| on_circle(r, angle)));
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
    let outer = radii[radii.len() - 1];
    mesh.name_boundary("outer", |X| on_radius(X, outer));
    if !collapsed {
        mesh.name_boundary("inner", |X| on_radius(X, radii[0]));
    }
    Ok(mesh)
}

/// The point at this radius and angle; points on an axis lie on it exactly.
fn on_circle(r: f64, angle: f64) -> [f64; 2] {
    let (s, c) = angle.sin_cos();
    [c, s].map(|v| {
        if v.abs() < 1e-15 * angle.max(1.0) {
            0.0
        } else {
            r * v
        }
    })
}

fn on_radius(X: &Vector<2>, r: f64) -> bool {
    (X.norm() - r).abs() < 1e-12 * r
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

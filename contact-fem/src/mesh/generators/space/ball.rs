//! Balls and their parts, from the octants of an octahedron projected on spheres.

use std::collections::HashMap;

use super::tetrahedra;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesh::generators::{affordable, positive};
use crate::tensor::Vector;

/// A ball of the given radius (UL) around the origin, with its nodes on `shells` equidistant
/// spheres and 8 `shells`³ tetrahedra. Boundary: `surface`.
///
/// An octahedron is divided along the lattice of its `shells` divisions, and each of its layers is
/// projected along the radius on a sphere. At the six poles on the axes, the edges on the surface
/// are as long as the distance of the shells; half-way between three poles they are 2.4 times as
/// long. The dihedral angles are between 33° and 126° for any number of shells.
///
/// # Errors
/// If the radius is not positive and finite or so small that volumes underflow, `shells` is 0, or
/// there are more than 10⁸ tetrahedra.
pub fn sphere(radius: f64, shells: usize) -> Result<Mesh<3>, Error> {
    let signs = [1, -1];
    let octants = signs.map(|x| signs.map(|y| signs.map(|z| [x, y, z])));
    ball(radius, shells, octants.as_flattened().as_flattened())
}

/// The half of a ball below the plane z = 0, as [`sphere`], with 4 `shells`³ tetrahedra.
/// Boundaries: `surface`, the dome with its pole at z = −`radius`, and `flat` (z = 0).
///
/// # Errors
/// As [`sphere`].
pub fn hemisphere(radius: f64, shells: usize) -> Result<Mesh<3>, Error> {
    let octants = [[1, 1, -1], [-1, 1, -1], [-1, -1, -1], [1, -1, -1]];
    let mut mesh = ball(radius, shells, &octants)?;
    mesh.name_boundary("flat", |X| X[2] == 0.0);
    Ok(mesh)
}

/// The quarter of a [`hemisphere`] with x ≥ 0 and y ≥ 0, for scenes that are symmetric about both
/// planes. Boundaries: `surface`, `flat` (z = 0), `left` (x = 0) and `front` (y = 0), as of a
/// cuboid.
///
/// # Errors
/// As [`sphere`].
pub fn eighth_sphere(radius: f64, shells: usize) -> Result<Mesh<3>, Error> {
    let mut mesh = ball(radius, shells, &[[1, 1, -1]])?;
    for (axis, name) in ["left", "front", "flat"].into_iter().enumerate() {
        mesh.name_boundary(name, |X| X[axis] == 0.0);
    }
    Ok(mesh)
}

/// A point of the lattice: i₁ + i₂ + i₃ is the number of its shell.
type Point = [i64; 3];

/// The given octants of a ball, each denoted by the signs of its coordinates. Boundary: `surface`.
fn ball(radius: f64, shells: usize, octants: &[Point]) -> Result<Mesh<3>, Error> {
    positive("radius", Some(radius))?;
    positive("shells", Some(shells as f64))?;
    affordable((octants.len() as f64) * (shells as f64).powi(3))?;
    let octant = octant(shells as i64);
    let mut numbers: HashMap<Point, usize> = HashMap::new();
    let (mut nodes, mut cells) = (Vec::new(), Vec::new());
    for signs in octants {
        for point in octant.as_flattened() {
            let point = [0, 1, 2].map(|i| signs[i] * point[i]);
            let number = *numbers.entry(point).or_insert_with(|| {
                nodes.push((on_shell(point) * (radius / shells as f64)).into());
                nodes.len() - 1
            });
            cells.push(number);
        }
    }
    let mut mesh = tetrahedra(nodes, cells)?;
    mesh.name_boundary("surface", |X| (X.norm() - radius).abs() < 1e-12 * radius);
    Ok(mesh)
}

/// A point of the lattice projected on the sphere of its shell; the shells have a distance of 1.
fn on_shell(point: Point) -> Vector<3> {
    let shell = point.iter().map(|i| i.abs()).sum::<i64>() as f64;
    let X = Vector::from(point.map(|i| i as f64));
    X * (shell / X.norm().max(1.0))
}

/// The positive octant x + y + z ≤ `shells` of the lattice, divided into `shells`³ tetrahedra.
///
/// The planes of the lattice divide it into tetrahedra and octahedra. An octahedron may be divided
/// along any of its three diagonals without a change to its facets; the diagonal that is shortest
/// in the ball gives the best-shaped tetrahedra.
fn octant(shells: i64) -> Vec<[Point; 4]> {
    let mut cells = Vec::new();
    for x in 0..shells {
        for y in 0..shells - x {
            for z in 0..shells - x - y {
                let at = |i: i64, j: i64, k: i64| [x + i, y + j, z + k];
                let [a, b, c] = [at(1, 0, 0), at(0, 1, 0), at(0, 0, 1)];
                cells.push([at(0, 0, 0), a, b, c]);
                let [d, e, f] = [at(0, 1, 1), at(1, 0, 1), at(1, 1, 0)];
                let room = shells - (x + y + z);
                if room >= 2 {
                    cells.extend(octahedron([a, b, c], [d, e, f]));
                }
                if room >= 3 {
                    cells.push([d, e, f, at(1, 1, 1)]);
                }
            }
        }
    }
    cells
}

/// The octahedron with these corners, k of `low` opposite to k of `high`, as four tetrahedra around
/// its shortest diagonal.
fn octahedron(low: [Point; 3], high: [Point; 3]) -> [[Point; 4]; 4] {
    // diagonals whose lengths differ by no more than this factor are equal; the last of them is
    // chosen
    const TIE: f64 = 1.0 + 1e-9;
    let length = |k: usize| (on_shell(low[k]) - on_shell(high[k])).norm();
    let shorter = |best: usize, k: usize| {
        if length(k) <= length(best) * TIE {
            k
        } else {
            best
        }
    };
    let k = (0..3).fold(0, shorter);
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let around = [low[i], low[j], high[i], high[j]];
    [0, 1, 2, 3].map(|q| [low[k], high[k], around[q], around[(q + 1) % 4]])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::super::battery::{area, check, dihedral_angles, is_mirrored};
    use super::*;

    fn volume(mesh: &Mesh<3>) -> f64 {
        (0..mesh.len()).map(|k| mesh.volume(k)).sum()
    }

    #[test]
    fn balls_converge_at_second_order() {
        let r = 0.7;
        for n in [1, 2, 3, 5, 8, 16] {
            // relative errors tend to 1.53 / n² (volume), 0.85 / n² (surface) and π² / 24n² (flat)
            let tolerance = 1.55 / (n * n) as f64;
            let (surface, flat) = (4.0 * PI * r * r, PI * r * r);
            let whole = sphere(r, n).expect("mesh");
            let exact = 4.0 / 3.0 * PI * r.powi(3);
            check(&whole, 1, exact, &[("surface", surface)], tolerance);
            let half = hemisphere(r, n).expect("mesh");
            let areas = [("flat", flat), ("surface", surface / 2.0)];
            check(&half, 1, exact / 2.0, &areas, tolerance);
            let eighth = eighth_sphere(r, n).expect("mesh");
            let side = flat / 4.0;
            let areas = [
                ("flat", side),
                ("front", side),
                ("left", side),
                ("surface", surface / 8.0),
            ];
            check(&eighth, 1, exact / 8.0, &areas, tolerance);
            assert_eq!(
                [&whole, &half, &eighth].map(Mesh::len),
                [8, 4, 1].map(|k| k * n.pow(3))
            );
            for (mesh, octants) in [(&whole, 8), (&half, 4), (&eighth, 1)] {
                let facets = mesh.boundary("surface").expect("named").len();
                assert_eq!(facets, octants * n * n);
            }
        }
        let errors = |n: usize| {
            let mesh = eighth_sphere(1.0, n).expect("mesh");
            [
                1.0 - volume(&mesh) / (PI / 6.0),
                1.0 - area(&mesh, "surface") / (PI / 2.0),
            ]
        };
        let (coarse, fine) = (errors(16), errors(32));
        for k in 0..2 {
            let order = (coarse[k] / fine[k]).log2();
            assert!((order - 2.0).abs() < 0.02, "{order}");
        }
    }

    #[test]
    fn angles_are_bounded_at_all_refinements() {
        for n in [1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 32, 64] {
            let (low, high) = dihedral_angles(&eighth_sphere(3.0, n).expect("mesh"));
            assert!(low > 33.0 && high < 126.0, "{n}: {low} {high}");
        }
    }

    #[test]
    fn nodes_lie_on_their_spheres() {
        let r = 12.3;
        let mesh = sphere(r, 9).expect("mesh");
        for a in mesh.boundary_nodes("surface").expect("named") {
            assert!((mesh.nodes()[a].norm() - r).abs() < 4.0 * f64::EPSILON * r);
        }
        let pole = Vector::<3>::new(0.0, 0.0, -r);
        let distance = |X: &Vector<3>| (X - pole).norm();
        let nearest = mesh
            .nodes()
            .iter()
            .map(distance)
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 4.0 * f64::EPSILON * r, "the pole is a node");
    }

    #[test]
    fn balls_are_mirror_symmetric() {
        for n in [1, 4, 7] {
            let (whole, half) = (
                sphere(1.0, n).expect("mesh"),
                hemisphere(1.0, n).expect("mesh"),
            );
            assert!((0..3).all(|axis| is_mirrored(&whole, axis)));
            assert_eq!(
                [0, 1, 2].map(|axis| is_mirrored(&half, axis)),
                [true, true, false]
            );
            let (low, high) = half.bounding_box();
            assert!(
                (low[2] + 1.0).abs() < 1e-15 && high[2] == 0.0,
                "the dome is below"
            );
        }
    }

    #[test]
    fn bad_balls_are_refused() {
        for make in [sphere, hemisphere, eighth_sphere] {
            for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
                let error = make(radius, 2).expect_err("radius");
                assert!(matches!(error, Error::Setting { name: "radius", .. }));
            }
            let error = make(1.0, 0).expect_err("no shells");
            assert!(matches!(error, Error::Setting { name: "shells", .. }));
            for shells in [500, 1 << 32, usize::MAX] {
                let error = make(1.0, shells).expect_err("too many");
                assert!(matches!(error, Error::Setting { name: "cells", .. }));
            }
            for radius in [1e-200, 1e200] {
                make(radius, 1).expect_err("out of the range of volumes");
            }
        }
    }
}

//! The checks that every mesh of tetrahedra passes.

use std::collections::{BTreeMap, BTreeSet};

use crate::mesh::Mesh;
use crate::tensor::{Vector, facet_normal};

/// Checks the orientation, Euler's V − E + F − T, that the boundaries partition a closed exterior,
/// and the volume and areas to a relative tolerance.
pub fn check(mesh: &Mesh<3>, euler: i64, volume: f64, areas: &[(&str, f64)], tolerance: f64) {
    assert!((0..mesh.len()).all(|k| mesh.volume(k) > 0.0));
    assert_eq!(euler_characteristic(mesh), euler);
    let flux: f64 = mesh
        .exterior()
        .map(|facet| {
            let x = [0, 1, 2].map(|k| mesh.nodes()[facet[k]]);
            facet_normal(&x).dot(&x[0]) / 3.0
        })
        .sum();
    let filled: f64 = (0..mesh.len()).map(|k| mesh.volume(k)).sum();
    // ∫ div X = ∫ X·n: all facets are present and outward
    assert!((flux - filled).abs() < 1e-12 * filled, "{flux} {filled}");
    assert!((filled - volume).abs() <= tolerance * volume, "{filled}");
    let mut names: BTreeMap<&[usize], Vec<String>> = BTreeMap::new();
    for name in mesh.boundary_names() {
        for facet in mesh.boundary(name).expect("named") {
            names.entry(facet).or_default().push(name.to_string());
        }
    }
    for facet in mesh.exterior() {
        assert_eq!(names.get(facet).map_or(0, Vec::len), 1, "{facet:?}");
    }
    assert_eq!(mesh.boundary_names().count(), areas.len());
    for &(name, exact) in areas {
        let found = area(mesh, name);
        assert!((found - exact).abs() <= tolerance * exact, "{name} {found}");
    }
}

/// The area of a boundary.
pub fn area(mesh: &Mesh<3>, name: &str) -> f64 {
    let facets = mesh.boundary(name).expect("named");
    let of = |facet: &[usize]| facet_normal(&[0, 1, 2].map(|k| mesh.nodes()[facet[k]])).norm();
    facets.into_iter().map(of).sum()
}

fn euler_characteristic(mesh: &Mesh<3>) -> i64 {
    let mut edges = BTreeSet::new();
    let mut facets = BTreeSet::new();
    for cell in mesh.cells() {
        let mut cell = cell.to_vec();
        cell.sort_unstable();
        for k in 0..4 {
            let facet: Vec<usize> = (0..4).filter(|&a| a != k).map(|a| cell[a]).collect();
            facets.insert([facet[0], facet[1], facet[2]]);
            edges.extend((0..k).map(|j| [cell[j], cell[k]]));
        }
    }
    let count = |n: usize| n as i64;
    count(mesh.nodes().len()) - count(edges.len()) + count(facets.len()) - count(mesh.len())
}

/// The smallest and the largest angle between two facets of one cell, in degrees.
pub fn dihedral_angles(mesh: &Mesh<3>) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    for cell in mesh.cells() {
        let x: Vec<Vector<3>> = cell.iter().map(|&a| mesh.nodes()[a]).collect();
        for (a, b, c, d) in [
            (0, 1, 2, 3),
            (0, 2, 1, 3),
            (0, 3, 1, 2),
            (1, 2, 0, 3),
            (1, 3, 0, 2),
            (2, 3, 0, 1),
        ] {
            let edge = (x[b] - x[a]).normalize();
            let across = |corner: usize| {
                let v = x[corner] - x[a];
                v - edge * v.dot(&edge)
            };
            let angle = across(c).angle(&across(d)).to_degrees();
            (low, high) = (low.min(angle), high.max(angle));
        }
    }
    (low, high)
}

/// Whether the mesh is its own mirror image in the plane through the origin across `axis`.
pub fn is_mirrored(mesh: &Mesh<3>, axis: usize) -> bool {
    let cells = |sign: f64| -> BTreeSet<[[i64; 3]; 4]> {
        let point = |a: usize| {
            let mut X = mesh.nodes()[a];
            X[axis] *= sign;
            [0, 1, 2].map(|i| (X[i] * 1e9).round() as i64)
        };
        let cell = |cell: &[usize]| {
            let mut corners = [0, 1, 2, 3].map(|k| point(cell[k]));
            corners.sort_unstable();
            corners
        };
        mesh.cells().map(cell).collect()
    };
    cells(1.0) == cells(-1.0)
}

//! Extrusion of plane meshes along z.

use std::collections::HashMap;

use super::tetrahedra;
use crate::element::Order;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesh::generators::{affordable, ascending, equilateral_disc, linspace, positive};

/// A plane mesh extruded along z, with a layer of prisms between successive values of `z`
/// (ascending, UL). Boundaries: those of the plane mesh, which become the sides, and the two
/// `caps`, lowest and highest.
///
/// Each prism is divided into three tetrahedra. On every side the diagonal rises from the node with
/// the smaller number in the plane to the one with the larger, and falls in odd layers. Neighbours
/// therefore match, and an even number of layers is symmetric about the middle. A node of the plane
/// mesh has in layer l the number l `plane.nodes().len()` + its own number.
///
/// ```
/// use contact_fem::mesh::generators::{Diagonals, extrude, linspace, rectangle};
///
/// let plane = rectangle(&linspace(0.0, 2.0, 4), &[0.0, 0.5, 1.0], Diagonals::Rising)?;
/// let bar = extrude(&plane, &linspace(0.0, 3.0, 6), ["behind", "before"])?;
/// assert_eq!(bar.boundary("top")?.len(), 4 * 6 * 2);
/// assert_eq!(bar.boundary("behind")?.len(), plane.len());
/// # Ok::<(), contact_fem::Error>(())
/// ```
///
/// # Errors
/// As [`Mesh::new`]; also if the mesh is quadratic, the values of `z` do not ascend or are fewer
/// than two, a cap has the name of a boundary of the plane mesh, or there are more than 10⁸
/// tetrahedra.
pub fn extrude(plane: &Mesh<2>, z: &[f64], caps: [&str; 2]) -> Result<Mesh<3>, Error> {
    ascending("z", z)?;
    if let Some(name) = caps.iter().find(|&&cap| plane.boundaries.contains_key(cap)) {
        return Err(Error::BoundaryExists {
            name: name.to_string(),
        });
    }
    if plane.order() != Order::Linear {
        return Err(Error::Setting {
            name: "plane.order()",
            value: 2.0,
            remedy: "extrude the linear mesh and make the result quadratic",
        });
    }
    let layers = z.len() - 1;
    affordable(3.0 * plane.len() as f64 * layers as f64)?;
    let level = |&z: &f64| plane.nodes.iter().map(move |X| [X[0], X[1], z]);
    let nodes = z.iter().flat_map(level).collect();
    let mut cells = Vec::new();
    for layer in 0..layers {
        for triangle in plane.cells() {
            cells.extend(prism(triangle, layer, plane.nodes.len()));
        }
    }
    let mut mesh = tetrahedra(nodes, cells)?;
    name_sides(&mut mesh, plane);
    for (name, end) in caps.into_iter().zip([z[0], z[layers]]) {
        mesh.name_boundary(name, |X| X[2] == end);
    }
    Ok(mesh)
}

/// The prism over a triangle of the plane, as three tetrahedra: the paths from one end to the other
/// with the triangle's nodes in ascending order.
fn prism(triangle: &[usize], layer: usize, nodes: usize) -> impl Iterator<Item = usize> + use<> {
    let mut corners = [triangle[0], triangle[1], triangle[2]];
    corners.sort_unstable();
    let (from, to) = (layer + layer % 2, layer + (layer + 1) % 2);
    (0..3).flat_map(move |turn| {
        let [low, high] = [from, to].map(|level| corners.map(|a| level * nodes + a));
        low.into_iter()
            .take(turn + 1)
            .chain(high.into_iter().skip(turn))
    })
}

/// Names the sides of an extruded mesh after the edges of the plane mesh below them.
fn name_sides(mesh: &mut Mesh<3>, plane: &Mesh<2>) {
    let sorted = |a: usize, b: usize| [a.min(b), a.max(b)];
    let edges = plane.exterior().enumerate();
    let edge_at: HashMap<_, _> = edges
        .map(|(k, edge)| (sorted(edge[0], edge[1]), k))
        .collect();
    let mut sides = vec![Vec::new(); edge_at.len()];
    for (f, facet) in mesh.exterior().enumerate() {
        let [a, b, c] = [0, 1, 2].map(|k| facet[k] % plane.nodes.len());
        // of a side's three nodes, two have the same node of the plane; those of a cap do not
        let edge = if a == b || a == c {
            sorted(b, c)
        } else {
            sorted(a, b)
        };
        let upright = a == b || b == c || c == a;
        if let Some(&k) = edge_at.get(&edge).filter(|_| upright) {
            sides[k].push(f);
        }
    }
    for (name, edges) in &plane.boundaries {
        let mut facets: Vec<usize> = edges.iter().flat_map(|&k| sides[k].clone()).collect();
        facets.sort_unstable();
        mesh.boundaries.insert(name.clone(), facets);
    }
}

/// A cylinder around the z axis from z = 0 to `height` (UL), of the given radius (UL): an
/// [`equilateral_disc`] with `rings` rings, extruded in `layers` equal layers, with 18 `rings`²
/// `layers` tetrahedra. Boundaries: `bottom`, `top`, `side`.
///
/// If the layers are as high as the distance of the rings, the dihedral angles are between 33° and
/// 126°.
///
/// # Errors
/// If the radius or height is not positive and finite, `rings` or `layers` is 0, or there are more
/// than 10⁸ tetrahedra.
pub fn cylinder(radius: f64, height: f64, rings: usize, layers: usize) -> Result<Mesh<3>, Error> {
    positive("height", Some(height))?;
    positive("layers", Some(layers as f64))?;
    affordable(18.0 * (rings as f64).powi(2) * layers as f64)?;
    let disc = equilateral_disc(radius, rings)?;
    let mut mesh = extrude(&disc, &linspace(0.0, height, layers), ["bottom", "top"])?;
    let side = mesh.boundaries.remove("boundary").unwrap_or_default();
    mesh.boundaries.insert("side".into(), side);
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::super::battery::{check, dihedral_angles, is_mirrored};
    use super::*;
    use crate::mesh::generators::{Diagonals, annulus, half_disc, rectangle};

    #[test]
    fn sides_keep_their_names() {
        let plane = rectangle(&[0.0, 0.5, 2.0], &[0.0, 1.0], Diagonals::Falling).expect("plane");
        let mesh = extrude(&plane, &[-1.0, 0.0, 2.0, 2.5], ["below", "above"]).expect("mesh");
        let areas = [
            ("below", 2.0),
            ("above", 2.0),
            ("bottom", 7.0),
            ("top", 7.0),
            ("left", 3.5),
            ("right", 3.5),
        ];
        check(&mesh, 1, 7.0, &areas, 1e-13);
        assert_eq!(mesh.len(), 3 * plane.len() * 3);

        let angles = linspace(PI, TAU, 6);
        let plane = half_disc(&[0.0, 0.5, 1.0], &angles, Diagonals::Alternating).expect("plane");
        let mesh = extrude(&plane, &[0.0, 0.2], ["ends", "ends"]).expect("mesh");
        let area: f64 = (0..plane.len()).map(|k| plane.volume(k)).sum();
        let arc = 6.0 * 2.0 * (PI / 12.0).sin();
        let areas = [("arc", 0.2 * arc), ("flat", 0.4), ("ends", 2.0 * area)];
        check(&mesh, 1, 0.2 * area, &areas, 1e-13);
    }

    #[test]
    fn rings_become_tubes() {
        let plane = annulus(&[0.7, 1.0], 24, Diagonals::Rising).expect("plane");
        let mesh = extrude(&plane, &linspace(0.0, 1.0, 4), ["bottom", "top"]).expect("mesh");
        let area: f64 = (0..plane.len()).map(|k| plane.volume(k)).sum();
        let outline = 24.0 * 2.0 * (PI / 24.0).sin();
        let areas = [
            ("bottom", area),
            ("top", area),
            ("inner", 0.7 * outline),
            ("outer", outline),
        ];
        check(&mesh, 0, area, &areas, 1e-13);
    }

    #[test]
    fn cylinders_converge_at_second_order() {
        let (r, h) = (0.8, 1.5);
        for n in [1, 2, 4, 9, 16] {
            let mesh = cylinder(r, h, n, 2 * n).expect("mesh");
            let end = PI * r * r;
            let areas = [("bottom", end), ("top", end), ("side", TAU * r * h)];
            // a polygon with 6n corners: sin(π/3n) / (π/3n) = 1 − π²/54n²
            check(&mesh, 1, end * h, &areas, PI * PI / (54 * n * n) as f64);
            assert_eq!(mesh.len(), 18 * n * n * 2 * n);
            assert_eq!(
                mesh.boundary("side").expect("named").len(),
                6 * n * 2 * n * 2
            );
            assert_eq!(mesh.boundary("top").expect("named").len(), 6 * n * n);
            for a in mesh.boundary_nodes("side").expect("named") {
                let distance = mesh.nodes()[a].xy().norm();
                assert!((distance - r).abs() < 4.0 * f64::EPSILON * r);
            }
        }
    }

    #[test]
    fn angles_are_bounded_at_all_refinements() {
        for n in [1, 2, 3, 4, 5, 6, 8, 16, 32] {
            let mesh = cylinder(1.0, 2.0 / n as f64, n, 2).expect("mesh");
            let (low, high) = dihedral_angles(&mesh);
            assert!(low > 33.0 && high < 126.0, "{n}: {low} {high}");
        }
    }

    #[test]
    fn even_layers_are_symmetric_about_the_middle() {
        for (layers, symmetric) in [(4, true), (3, false)] {
            let mesh = cylinder(1.0, 2.0, 3, layers).expect("mesh");
            let mesh = mesh.translated([0.0, 0.0, -1.0]).expect("moved");
            assert_eq!(is_mirrored(&mesh, 2), symmetric);
        }
    }

    #[test]
    fn bad_extrusions_are_refused() {
        let plane = rectangle(&[0.0, 1.0], &[0.0, 1.0], Diagonals::Rising).expect("plane");
        let error = extrude(&plane, &[0.0, 1.0], ["bottom", "above"]).expect_err("name");
        assert!(matches!(&error, Error::BoundaryExists { name } if name == "bottom"));
        let bad: [&[f64]; 4] = [&[], &[1.0], &[0.0, 1.0, 1.0], &[1.0, 0.0]];
        for z in bad {
            let error = extrude(&plane, z, ["below", "above"]).expect_err("z");
            assert!(matches!(error, Error::Setting { name: "z", .. }));
        }
        extrude(&plane, &[0.0, f64::NAN], ["below", "above"]).expect_err("NaN");
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = cylinder(bad, 1.0, 1, 1).expect_err("radius");
            assert!(matches!(error, Error::Setting { name: "radius", .. }));
            let error = cylinder(1.0, bad, 1, 1).expect_err("height");
            assert!(matches!(error, Error::Setting { name: "height", .. }));
        }
        cylinder(1.0, 1.0, 0, 1).expect_err("no rings");
        cylinder(1.0, 1.0, 1, 0).expect_err("no layers");
        for (rings, layers) in [(usize::MAX, 1), (1, usize::MAX), (1 << 20, 1 << 20)] {
            let error = cylinder(1.0, 1.0, rings, layers).expect_err("too many");
            assert!(matches!(error, Error::Setting { name: "cells", .. }));
        }
    }
}

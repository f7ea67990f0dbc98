//! Quadratic contact facets that are straight where the surface is curved.

use super::limits::{CORNER, MOST_STRAIGHT, STRAIGHT};
use super::{Finding, FindingKind, Report, Setup, Severity};
use crate::contact::Surface;
use crate::element::Order;
use crate::tensor::Vector;

/// Finds quadratic surfaces whose facets are straight along a curve.
pub(super) fn check<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    let names = setup.scene.names();
    for surface in &setup.contact.surfaces {
        let bends = bends(surface);
        let Some(&(angle, x)) = bends.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else {
            continue;
        };
        if bends.len() > MOST_STRAIGHT {
            let name = &names[surface.body()];
            let finding = Finding::new(Severity::Warning, FindingKind::StraightFacets, &[name]);
            report.add(finding.at(&x).measured(angle, STRAIGHT).says(
                format!(
                    "{} quadratic contact facets of body `{name}` are straight, and turn by up to {angle:.1}° \
                     from one to the next, as those of a curve whose middle nodes were not moved onto it",
                    bends.len()
                ),
                "if they stand for a curve, move the nodes there with `Mesh::curved`, or read a mesh of order 2",
            ));
        }
    }
}

/// The largest angle (degrees) between a facet and those around it, and its centroid, of each straight quadratic
/// facet along a curve: all its corners are on bends, and all of those go the same way and are no sharp corners.
fn bends<const D: usize>(surface: &Surface<D>) -> Vec<(f64, Vector<D>)> {
    if surface.order() == Order::Linear {
        return Vec::new();
    }
    let middle = Vector::<D>::repeat(1.0 / D as f64);
    let facets = surface.reference().iter();
    let planes: Vec<(Vector<D>, Vector<D>)> = facets
        .map(|facet| (facet.point(&middle), facet.normal(&middle).normalize()))
        .collect();
    let bend = |f: usize| {
        let (x, n) = &planes[f];
        let (mut largest, mut turns) = (0.0_f64, 0.0);
        for &corner in &surface.facet(f)[..D] {
            let mut here = 0.0_f64;
            for (other, _) in surface.facets_around(corner) {
                let (y, m) = &planes[other];
                let angle = (m - n).norm().atan2((m + n).norm()).to_degrees() * 2.0;
                here = here.max(angle);
                if angle > STRAIGHT {
                    let turn = n.dot(&(y - x)).signum();
                    if turn == -turns {
                        return None;
                    }
                    turns = turn;
                }
            }
            // written so that NaN is no bend
            if !(here > STRAIGHT && here < CORNER) {
                return None;
            }
            largest = largest.max(here);
        }
        Some((largest, *x))
    };
    let is_flat = |f: &usize| surface.reference()[*f].is_flat();
    (0..surface.len())
        .filter(is_flat)
        .filter_map(bend)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::generators::{cuboid, cylinder, onto_sphere, sphere};

    fn found(mesh: &Mesh<3>, boundary: &str) -> Vec<f64> {
        let facets = mesh.boundary(boundary).expect("named");
        let facets = facets.iter().copied();
        let surface = Surface::new(0, mesh.order(), facets, mesh.nodes());
        bends(&surface)
            .into_iter()
            .map(|(angle, _)| angle)
            .collect()
    }

    #[test]
    fn balls_and_cylinders_that_are_not_curved_are_found() {
        let ball = sphere(1.0, 6).expect("a ball").quadratic();
        assert_eq!(found(&ball, "surface").len(), ball.exterior().len());
        let curved = ball.curved("surface", onto_sphere(1.0)).expect("curved");
        assert!(found(&curved, "surface").is_empty());
        // 24 facets around, each a rectangle of two triangles
        let cylinder = cylinder(1.0, 1.0, 4, 2).expect("a cylinder");
        assert!(
            found(&cylinder, "side").is_empty(),
            "linear facets are straight"
        );
        let cylinder = cylinder.quadratic();
        let angles = found(&cylinder, "side");
        assert_eq!(angles.len(), 24 * 2 * 2);
        assert!(angles.iter().all(|angle| (angle - 15.0).abs() < 1e-9));
        assert!(found(&cylinder, "top").is_empty());
    }

    #[test]
    fn corners_and_planes_are_no_curves() {
        let mut block = cuboid([0.0; 3], [1.0; 3], [3, 3, 3]).expect("a block");
        block.name_boundary("all", |_| true);
        let block = block.quadratic();
        assert!(found(&block, "all").is_empty());
        // a roof with a bend of 11.4°, more than one facet on each side
        let roof =
            |X: &Vector<3>| Vector::<3>::new(X[0], X[1], X[2] - 0.1 * (X[0] - 1.0 / 3.0).abs());
        let roof = block.mapped(roof).expect("a roof");
        assert!(found(&roof, "top").is_empty());
    }
}

//! The rigid motions that contact can resist: those that move a contact surface along its normal.

use super::supports::{Cluster, Row};
use crate::contact::obstacle::Placed;
use crate::model::{Pair, Scene, Side};
use crate::tensor::{Vector, facet_normal, turned};

/// The cosine of the angle between a facet's normal and the inward one of an obstacle, from which on the two may meet.
const MEETS: f64 = 0.5;

/// The rigid motions of a cluster that neither supports nor contact resist, by name. Without friction, contact resists a motion only if it
/// has a part along the normals of the facets, and one along those of the obstacles: a disc on a floor may slide, and turn about its
/// centre. A surface that turns away from an obstacle does not count.
pub(super) fn unresisted<const D: usize>(
    cluster: &Cluster,
    scene: &Scene<D>,
    pairs: &[Pair],
) -> Vec<String> {
    let (mut own, mut opposite) = (Vec::new(), Vec::new());
    for pair in pairs {
        for side in [&pair.first, &pair.second] {
            for facet in facets(cluster, scene, side) {
                for rows in [&mut own, &mut opposite] {
                    rows.push(facet.along(&facet.normal));
                    if pair.friction > 0.0 {
                        rows.push(facet.along(&turned(&facet.normal)));
                    }
                }
            }
        }
    }
    for (side, number) in scene.obstructed() {
        let Some(obstacle) = scene.obstacles().get(*number) else {
            continue;
        };
        for facet in facets(cluster, scene, side) {
            let normal = Placed::new(obstacle, facet.size).normal(&facet.centre);
            let has_friction = scene.obstacle_frictions()[*number] > 0.0;
            own.push(facet.along(&facet.normal));
            if has_friction {
                own.push(facet.along(&turned(&facet.normal)));
            }
            if -facet.normal.dot(&normal) > MEETS {
                opposite.push(facet.along(&normal));
                if has_friction {
                    opposite.push(facet.along(&turned(&normal)));
                }
            }
        }
    }
    let mut names = cluster.unheld(scene, own);
    for name in cluster.unheld(scene, opposite) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// A facet that may touch something.
struct Facet<const D: usize> {
    /// Its corners, numbered through the bodies, and the barycentric coordinates of its circumcentre: of a facet in a ball, the normal there
    /// leads to the ball's centre, so that no rotation about that moves it along the normal.
    corners: [usize; D],
    weights: [f64; D],
    normal: Vector<D>,
    centre: Vector<D>,
    size: f64,
}

impl<const D: usize> Facet<D> {
    /// Its motion along a direction.
    fn along(&self, direction: &Vector<D>) -> Row {
        let corners = self.corners.iter().zip(&self.weights);
        let of_corner =
            |(&node, &w): (&usize, &f64)| (0..D).map(move |i| (node, i, w * direction[i]));
        corners.flat_map(of_corner).collect()
    }
}

/// The facets of a side, where it is one of the cluster.
fn facets<const D: usize>(cluster: &Cluster, scene: &Scene<D>, side: &Side) -> Vec<Facet<D>> {
    let index = side.body.index();
    let (Some(body), true) = (scene.bodies().get(index), cluster.has_body(index)) else {
        return Vec::new();
    };
    let (mesh, first) = (body.mesh(), scene.first_nodes()[index]);
    // the side was checked when it was declared
    let all = mesh.boundary(&side.boundary).unwrap_or_default();
    let facet = |nodes: &[usize]| {
        let x: [Vector<D>; D] = std::array::from_fn(|c| mesh.nodes()[nodes[c]]);
        Facet {
            corners: std::array::from_fn(|c| first + nodes[c]),
            weights: circumcentre(&x),
            normal: facet_normal(&x).normalize(),
            centre: x.iter().sum::<Vector<D>>() / D as f64,
            size: (x[1] - x[0]).norm(),
        }
    };
    let is_own = |nodes: &&[usize]| cluster.has(index, nodes[0]);
    all.into_iter().filter(is_own).map(facet).collect()
}

/// The barycentric coordinates of the point that is as far from all corners: the middle of a segment; of a triangle, in proportion to
/// a²(b² + c² − a²), with the side a opposite the corner.
fn circumcentre<const D: usize>(x: &[Vector<D>; D]) -> [f64; D] {
    let squares: [f64; D] =
        std::array::from_fn(|c| (x[(c + 1) % D] - x[(c + 2) % D]).norm_squared());
    let all: f64 = squares.iter().sum();
    let parts: [f64; D] = match D {
        3 => squares.map(|square| square * (all - 2.0 * square)),
        _ => [1.0; D],
    };
    let sum: f64 = parts.iter().sum();
    parts.map(|part| part / sum)
}

#[cfg(test)]
mod tests {
    use crate::mesh::generators::{Diagonals, disc, linspace, rectangle, sphere};
    use crate::model::{FindingKind, Obstacle};
    use crate::{Body, LinearElastic, Mesh, Scene};

    /// What is found of a body on a floor, with a wall beside it if asked.
    fn found(mesh: Mesh<2>, sides: [&str; 2], has_wall: bool) -> Vec<(FindingKind, String)> {
        let mut scene = Scene::new();
        let law = LinearElastic::new(1.0, 0.3).expect("a law");
        let body = scene.add("body", Body::new(mesh, law));
        let floor = Obstacle::half_space([0.0, 0.0], [0.0, 1.0]).expect("a floor");
        scene
            .obstacle("floor", body.on(sides[0]), floor)
            .expect("held");
        if has_wall {
            let wall = Obstacle::half_space([0.0, 0.0], [1.0, 0.0]).expect("a wall");
            scene
                .obstacle("wall", body.on(sides[1]), wall)
                .expect("held");
        }
        let kinds = [FindingKind::HeldByContact, FindingKind::HeldByNothing];
        let all = scene.preflight().into_iter();
        let own = all.filter(|finding| kinds.contains(&finding.kind));
        own.map(|finding| (finding.kind, finding.what)).collect()
    }

    #[test]
    fn a_floor_holds_neither_sliding_nor_a_disc_that_turns() {
        let block = || {
            let x = linspace(0.0, 1.0, 2);
            rectangle(&x, &x, Diagonals::Rising).expect("a mesh")
        };
        let disc = disc(1.0, 12, 2, 0.0).expect("a mesh");
        let disc = disc.translated([0.0, 1.0]).expect("moved");
        let told = |mesh, sides, has_wall| -> Vec<String> {
            found(mesh, sides, has_wall)
                .into_iter()
                .map(|(_, what)| what)
                .collect()
        };
        assert_eq!(
            told(block(), ["bottom", "left"], false),
            [
                "neither supports nor contact hold body `body`: translation x",
                "only contact holds body `body`: translation y, rotation",
            ]
        );
        assert_eq!(
            told(block(), ["bottom", "left"], true),
            ["only contact holds body `body`: translation x, translation y, rotation"]
        );
        let ball = sphere(1.0, 3).expect("a mesh");
        let ball = ball.translated([0.0, 0.0, 1.0]).expect("moved");
        let mut scene = Scene::new();
        let law = LinearElastic::new(1.0, 0.3).expect("a law");
        let body = scene.add("ball", Body::new(ball, law));
        let floor = Obstacle::half_space([0.0; 3], [0.0, 0.0, 1.0]).expect("a floor");
        scene
            .obstacle("floor", body.on("surface"), floor)
            .expect("held");
        let notes = scene.preflight();
        let kind = |kind| {
            notes
                .iter()
                .find(|note| note.kind == kind)
                .expect("a note")
                .what
                .clone()
        };
        let loose = kind(FindingKind::HeldByNothing);
        for motion in [
            "translation x",
            "translation y",
            "rotation about x",
            "rotation about y",
            "rotation about z",
        ] {
            assert!(loose.contains(motion), "{loose}");
        }
        assert!(kind(FindingKind::HeldByContact).ends_with("`ball`: translation z"));
        let found = told(disc, ["boundary", "boundary"], false);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].ends_with("rotation, translation x"), "{found:?}");
        assert!(
            found[1].ends_with("body `body`: translation y"),
            "{found:?}"
        );
    }
}

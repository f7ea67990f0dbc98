//! The surfaces of contact pairs: where they are, where they face, and how fine they are.

use super::limits::{FACES, MESH_RATIO, OUTWARD};
use super::steps::relative_motion;
use super::{Finding, FindingKind, Report, Setup, Severity};
use crate::contact::{Master, Pass, Surface};
use crate::model::Geometry;
use crate::model::contact_set::sides_and_passes;
use crate::tensor::Vector;

/// Finds surfaces that are out of reach, face away, have normals that point inward, or differ in fineness.
pub(super) fn check<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    let located = setup.contact.located_at(&setup.kinematics.X);
    let names = setup.scene.names();
    for surface in &setup.contact.surfaces {
        inward_normal(surface, &names[surface.body()], report);
    }
    let (sides, _) = sides_and_passes(setup.pairs);
    for pass in one_pass_a_pair(setup) {
        let [first, second] = [pass.slave, pass.master].map(|k| located.master(k));
        let bodies = [first, second].map(|side| side.surface().body());
        if bodies[0] == bodies[1] {
            continue;
        }
        // of surfaces that may touch all others, most do not touch each other
        let both = [pass.slave, pass.master].map(|k| sides[k]);
        let is_one_of_many = both.iter().all(|side| setup.scene.is_general(side));
        let names = bodies.map(|body| &names[body]);
        let [one, other] = both.map(|side| &side.boundary);
        let between = |kind| Finding::new(Severity::Warning, kind, &names);
        let what = format!("`{one}` of `{}` and `{other}` of `{}`", names[0], names[1]);
        let (there, back) = (towards(first, second), towards(second, first));
        let nearest = match there.distance <= back.distance {
            true => &there,
            false => &back,
        };
        let reach = setup.contact.reach;
        let motion = match setup.contact.geometry {
            Geometry::Reference => 0.0,
            Geometry::Current => relative_motion(setup.scene, bodies),
        };
        let faces = there.faces.max(back.faces);
        let is_apart = faces < FACES || nearest.distance > reach + motion;
        if is_apart && is_one_of_many {
            continue;
        }
        if faces < FACES {
            let finding = between(FindingKind::FacingAway).at(&nearest.x);
            report.add(finding.measured(faces, FACES).says(
                format!("{what} do not face each other anywhere: no point of one meets the other"),
                "check that the boundaries are those that may touch",
            ));
        } else if nearest.distance > reach + motion {
            let finding = between(FindingKind::OutOfReach).at(&nearest.x);
            report.add(finding.measured(nearest.distance, reach).says(
                format!(
                    "{what} are {:.3e} apart, further than the search radius of {reach:.3e} and what is \
                     prescribed: loads alone could bring them together",
                    nearest.distance
                ),
                "set `Scene::reach`, move the bodies together, or leave out the pair",
            ));
        }
        let sizes = [first, second].map(|side| side.surface().facet_size());
        let ratio = sizes[0].max(sizes[1]) / sizes[0].min(sizes[1]);
        // the coarse facets of a rigid body have no pressure to share
        let coarser = bodies[usize::from(sizes[1] > sizes[0])];
        let coarser = &setup.scene.bodies()[coarser];
        let is_free = !coarser.is_rigid() && coarser.prescribed().iter().any(Option::is_none);
        if ratio > MESH_RATIO && !is_apart && is_free {
            report.add(between(FindingKind::MeshRatio).measured(ratio, MESH_RATIO).says(
                format!("the facets of {what} differ by a factor of {ratio:.1}"),
                "refine the coarser one where they touch, or set `Scene::integration` to `Integration::Exact`",
            ));
        }
    }
}

/// One pass for each two surfaces that may touch, whichever roles they have.
pub(super) fn one_pass_a_pair<const D: usize>(setup: &Setup<'_, D>) -> Vec<Pass> {
    let passes = setup.contact.passes.iter().copied();
    let mut passes: Vec<Pass> = passes
        .filter(|pass| setup.contact.obstacle_of(*pass).is_none())
        .collect();
    passes.sort_by_key(|pass| (pass.slave.min(pass.master), pass.slave.max(pass.master)));
    passes.dedup_by_key(|pass| (pass.slave.min(pass.master), pass.slave.max(pass.master)));
    passes
}

/// How the nodes of a surface see another one.
struct View<const D: usize> {
    /// The least distance (UL), and the node that has it.
    distance: f64,
    x: Vector<D>,
    /// The largest −n·n̄ of a node and its closest point.
    faces: f64,
}

fn towards<const D: usize>(slave: &Master<D>, master: &Master<D>) -> View<D> {
    let mut view = View {
        distance: f64::INFINITY,
        x: Vector::zeros(),
        faces: -1.0,
    };
    for (x, n) in slave.moving().positions().iter().zip(slave.normals()) {
        let Some(p) = master.project(x) else { continue };
        if p.distance < view.distance {
            (view.distance, view.x) = (p.distance, *x);
        }
        view.faces = view.faces.max(-n.dot(&p.normal));
    }
    view
}

/// Finds a node whose averaged normal is not an outward one of a facet around it.
fn inward_normal<const D: usize>(surface: &Surface<D>, name: &String, report: &mut Report) {
    let centre = Vector::<D>::repeat(1.0 / D as f64);
    let normals = surface.reference_normals();
    let mut worst: Option<(f64, usize)> = None;
    for (nodes, facet) in surface.facets().zip(surface.reference()) {
        let outward = facet.normal(&centre).normalize();
        for &a in nodes {
            let cosine = normals[a].dot(&outward);
            // NaN is no direction
            if (cosine.is_nan() || cosine < OUTWARD)
                && worst.is_none_or(|(least, _)| cosine < least)
            {
                worst = Some((cosine, a));
            }
        }
    }
    if let Some((cosine, a)) = worst {
        let finding = Finding::new(Severity::Warning, FindingKind::InwardNormal, &[name]);
        let finding = finding
            .at(&surface.reference_nodes()[a])
            .measured(cosine, OUTWARD);
        report.add(finding.says(
            format!(
                "the averaged normal of body `{name}` at {:?} does not point out of all facets there",
                surface.reference_nodes()[a].as_slice()
            ),
            "leave the sharp edge out of the contact boundary, or round it off",
        ));
    }
}

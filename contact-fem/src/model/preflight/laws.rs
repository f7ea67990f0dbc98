//! Laws against elements and motions.

use nalgebra::{Matrix3, Vector3};

use super::limits::{AT_LIMIT, BEYOND_FACET, LOCKING, ROTATION};
use super::steps::times;
use super::surfaces::one_pass_a_pair;
use super::{Finding, FindingKind, Report, Setup, Severity};
use crate::error::Error;
use crate::model::{Body, Geometry};
use crate::tensor::Vector;

/// Finds linear elements that lock, and laws for small strains whose bodies move too far or turn too much.
pub(super) fn check<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    for (body, name) in setup.scene.bodies().iter().zip(setup.scene.names()) {
        locking(body, name, report);
        if body.is_small_strain() {
            rotation(body, name, report);
        }
    }
    match setup.contact.geometry {
        Geometry::Reference => beyond_facets(setup, report),
        Geometry::Current => {
            let bodies = setup.scene.bodies().iter().zip(setup.scene.names());
            for (_, body) in bodies.filter(|(body, _)| body.turns()) {
                let body = body.clone();
                report.take::<()>(Err(Error::TurnsTooFar { body }));
            }
        }
    }
}

fn locking<const D: usize>(body: &Body<D>, name: &String, report: &mut Report) {
    let is_rigid = body.prescribed().iter().all(Option::is_some);
    let (shear, longitudinal) = body.rest_moduli();
    let nu = (longitudinal - 2.0 * shear) / (2.0 * (longitudinal - shear));
    if body.locks() && !is_rigid && nu > LOCKING * (1.0 + AT_LIMIT) {
        let finding = Finding::new(Severity::Warning, FindingKind::Locking, &[name]);
        report.add(finding.measured(nu, LOCKING).says(
            format!("body `{name}` has linear elements and a Poisson's ratio of {nu:.4}: it is too stiff"),
            "take quadratic elements, as by `Mesh::quadratic`, or `Body::with_averaged_volumes`",
        ));
    }
}

fn rotation<const D: usize>(body: &Body<D>, name: &String, report: &mut Report) {
    let turns = body
        .times()
        .into_iter()
        .map(|t| prescribed_rotation(body, t));
    let degrees = turns.fold(0.0, f64::max).to_degrees();
    if degrees > ROTATION {
        let finding = Finding::new(Severity::Warning, FindingKind::Rotation, &[name]);
        report.add(finding.measured(degrees, ROTATION).says(
            format!(
                "body `{name}` has a law for small strains and is turned by {degrees:.1}°, which strains it"
            ),
            "take a law for large strains, as `NeoHookean`",
        ));
    }
}

/// The rotation (radians) that the prescribed displacements of a body have as a rigid motion at the load factor `t`, the best fit to nodes of which
/// all components are prescribed: u = sin θ n × r − (1 − cos θ) r⊥ beside their mean, with r⊥ across the axis n. It is a
/// rotation only where they move as a rigid body does, that is where the fit leaves little.
fn prescribed_rotation<const D: usize>(body: &Body<D>, t: f64) -> f64 {
    let prescribed = body.prescribed_values(t);
    let nodes = body.mesh().nodes().iter().zip(prescribed.chunks_exact(D));
    let spatial =
        |v: &dyn Fn(usize) -> f64| Vector3::from_fn(|i, _| if i < D { v(i) } else { 0.0 });
    let held = nodes.filter_map(|(X, u)| {
        let u: Vec<f64> = u.iter().copied().collect::<Option<_>>()?;
        Some((spatial(&|i| X[i]), spatial(&|i| u[i])))
    });
    let held: Vec<(Vector3<f64>, Vector3<f64>)> = held.collect();
    if held.is_empty() {
        return 0.0;
    }
    let count = held.len() as f64;
    let sums = held
        .iter()
        .fold((Vector3::zeros(), Vector3::zeros()), |s, (X, u)| {
            (s.0 + X, s.1 + u)
        });
    let (centre, mean) = (sums.0 / count, sums.1 / count);
    let (mut inertia, mut moment) = (Matrix3::zeros(), Vector3::zeros());
    for (X, u) in &held {
        let (r, u) = (X - centre, u - mean);
        inertia += Matrix3::identity() * r.norm_squared() - r * r.transpose();
        moment += r.cross(&u);
    }
    // nodes on a line do not tell the rotation about it
    let largest = inertia.amax();
    let inverse = inertia.pseudo_inverse(AT_LIMIT * largest);
    let turn = match inverse {
        Ok(inverse) if largest > 0.0 => inverse * moment,
        _ => return 0.0,
    };
    let axis = match D {
        2 => Vector3::z(),
        _ => turn.try_normalize(0.0).unwrap_or_else(Vector3::zeros),
    };
    let across = |X: &Vector3<f64>| (X - centre) - axis * axis.dot(&(X - centre));
    let sums = held.iter().fold((0.0, 0.0), |sums, (X, u)| {
        let r = across(X);
        (sums.0 + r.dot(&(u - mean)), sums.1 + r.norm_squared())
    });
    let along = if sums.1 > 0.0 { sums.0 / sums.1 } else { 0.0 };
    let fit = |X: &Vector3<f64>| turn.cross(&(X - centre)) + along * across(X);
    let left = held.iter().map(|(X, u)| (u - mean - fit(X)).norm_squared());
    let fitted = held.iter().map(|(X, _)| fit(X).norm_squared());
    match left.sum::<f64>() <= fitted.sum::<f64>() * 0.25 {
        true => turn.norm().atan2(1.0 + along),
        false => 0.0,
    }
}

/// Finds surfaces that are moved along each other further than a facet, with contact at the reference positions.
fn beyond_facets<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    let surfaces = &setup.contact.surfaces;
    for pass in one_pass_a_pair(setup) {
        let sides = [&surfaces[pass.slave], &surfaces[pass.master]];
        let bodies = sides.map(|side| side.body());
        let names = bodies.map(|body| &setup.scene.names()[body]);
        let facet = sides[0].facet_size().min(sides[1].facet_size());
        // towards each other they may move as far as they like; the flatter surface has the longer mean normal
        let [one, other] = sides.map(|side| {
            let normals = side.reference_normals();
            normals.iter().sum::<Vector<D>>() / normals.len().max(1) as f64
        });
        let normal = if other.norm() > one.norm() {
            other
        } else {
            one
        };
        let bodies = bodies.map(|body| &setup.scene.bodies()[body]);
        let ratio = |t: f64| {
            let [first, second] = bodies.map(|body| mean_displacement(body, t));
            let motion = second - first;
            (motion - normal * normal.dot(&motion)).norm() / facet
        };
        let ratio = times(bodies).into_iter().map(ratio).fold(0.0, f64::max);
        if ratio > BEYOND_FACET * (1.0 + AT_LIMIT) {
            let finding = Finding::new(Severity::Warning, FindingKind::BeyondFacet, &names);
            report.add(finding.measured(ratio, BEYOND_FACET).says(
                format!(
                    "bodies `{}` and `{}` are moved by {ratio:.1} facets along each other, but contact is looked \
                     for at the reference positions",
                    names[0], names[1]
                ),
                "take a law for large strains and `Geometry::Current`, or prescribe less",
            ));
        }
    }
}

/// The mean of the prescribed displacements at the load factor `t` (UL); 0 for components of which none is prescribed.
fn mean_displacement<const D: usize>(body: &Body<D>, t: f64) -> Vector<D> {
    let prescribed = body.prescribed_values(t);
    Vector::from_fn(|i, _| {
        let values = prescribed.iter().skip(i).step_by(D).flatten();
        let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), v| (sum + v, count + 1));
        sum / count.max(1) as f64
    })
}

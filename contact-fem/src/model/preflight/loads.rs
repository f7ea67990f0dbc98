//! Loads and prescribed displacements against round-off and against each other; sizes and stiffnesses of bodies.

use super::limits::{AT_LIMIT, LARGEST, SMALLEST_LINEAR, SMALLEST_OF_F, UNITS};
use super::{Finding, FindingKind, Report, Severity};
use crate::error::Error;
use crate::model::{Body, InitialGaps, Pair, Scene};
use crate::tensor::{Vector, facet_normal};

/// Checks the loads, and compares bodies.
pub(super) fn check<const D: usize>(scene: &Scene<D>, pairs: &[Pair], report: &mut Report) {
    let bodies = scene.bodies();
    let (low, high) = bounding_box(bodies);
    let size = (high - low).norm();
    let prescribed = bodies.iter().map(|body| body.largest().0);
    let prescribed = prescribed.fold(scene.obstacle_way().max(scene.longest_jump()), f64::max);
    let stretches: Vec<f64> = stretches(scene, size);
    let stretch = stretches.iter().copied().fold(0.0, f64::max);
    let largest = prescribed.max(stretch);
    let limit = match bodies.iter().all(Body::is_small_strain) {
        true => SMALLEST_LINEAR,
        false => SMALLEST_OF_F,
    };
    // how far resolved overlaps push is not known before surfaces are searched
    let is_drawn = scene.ties().iter().any(|tie| tie.drawn::<D>().is_some());
    let is_told = scene.initial_gaps != InitialGaps::Resolve && !is_drawn;
    if largest / size < limit {
        if is_told && largest > 0.0 {
            let share = largest / size;
            report.take::<()>(Err(Error::Negligible { share, limit }));
        } else if is_told {
            report.add(
                Finding::new(Severity::Note, FindingKind::Unloaded, &[]).says(
                    "no body is loaded, and all prescribed displacements are zero".into(),
                    "prescribe a displacement or add a load, unless the bodies are to stay as they are",
                ),
            );
        }
    } else {
        let farthest = low.amax().max(high.amax());
        if !pairs.is_empty() && largest / farthest < limit {
            let finding = Finding::new(Severity::Warning, FindingKind::RoundOff, &[]);
            report.add(finding.measured(largest / farthest, limit).says(
                format!(
                    "displacements of about {largest:.1e} are lost in the round-off of positions as far from \
                     the origin as {farthest:.1e}"
                ),
                "move the scene to the origin",
            ));
        }
        for ((name, &own), body) in scene.names().iter().zip(&stretches).zip(bodies) {
            if own > 0.0 && own / largest < SMALLEST_LINEAR {
                let finding = Finding::new(Severity::Warning, FindingKind::RoundOff, &[name]);
                let force = body.largest().1;
                report.add(finding.measured(own / largest, SMALLEST_LINEAR).says(
                    format!(
                        "the load of {force:.1e} on body `{name}` stretches it by {own:.1e}, which is lost beside \
                         displacements of {largest:.1e}"
                    ),
                    "check the units of the load, or leave it out",
                ));
            }
        }
    }
    report.take(excessive(scene, size));
    units(scene, report);
    idle(scene, report);
}

/// Checks that no body is moved or loaded beyond all measure, as by a unit that is wrong by many powers of ten.
fn excessive<const D: usize>(scene: &Scene<D>, size: f64) -> Result<(), Error> {
    let bodies = scene.bodies().iter().zip(scene.names());
    for (body, name) in bodies {
        let (displacement, force) = body.largest();
        let force = if is_deformable(body) { force } else { 0.0 };
        let area = match D == 3 || body.mesh().is_of_revolution() {
            true => size * size,
            false => size,
        };
        let shear = body.rest_moduli().0;
        // laws without stiffness at rest tell nothing
        let stretch = if shear > 0.0 {
            force / shear / area
        } else {
            0.0
        };
        let all = [
            ("the prescribed displacement", displacement / size),
            ("the load", stretch),
        ];
        let mut all = all.into_iter();
        if let Some((what, share)) = all.find(|(_, share)| *share > LARGEST) {
            return Err(Error::Excessive {
                body: name.clone(),
                what,
                share,
                limit: LARGEST,
            });
        }
    }
    Ok(())
}

/// Finds loads all of whose forces act on held components, and move nothing.
fn idle<const D: usize>(scene: &Scene<D>, report: &mut Report) {
    let deformable = |(_, body): &(&String, &Body<D>)| is_deformable(body);
    for (name, body) in scene.names().iter().zip(scene.bodies()).filter(deformable) {
        let mut held = body.is_always_prescribed();
        body.ties().keys().for_each(|dof| held[*dof] = false);
        for (origin, load) in body.loads_at(1.0) {
            let is_idle = load.iter().zip(&held).all(|(f, held)| *f == 0.0 || *held);
            if is_idle && load.iter().any(|f| *f != 0.0) {
                let boundary = origin
                    .boundary()
                    .map_or(String::new(), |on| format!(" on `{on}`"));
                let finding = Finding::new(Severity::Warning, FindingKind::Unloaded, &[name]);
                report.add(finding.says(
                    format!(
                        "the {}{boundary} of body `{name}` acts on held nodes alone, and moves nothing",
                        origin.kind()
                    ),
                    "leave the load out, or hold fewer nodes or components",
                ));
            }
        }
    }
}

/// For each body, a large estimate of the displacement (UL) under its loads: of a bar as long as the scene's `size`
/// and as thin as the thinnest body, bent by the sum of the forces, of the softest material. Scenes have bodies that
/// pass loads on, so that a body's own stiffness does not tell.
fn stretches<const D: usize>(scene: &Scene<D>, size: f64) -> Vec<f64> {
    let deformable = || scene.bodies().iter().filter(|body| is_deformable(body));
    let shear = |body: &Body<D>| body.rest_moduli().0;
    let softest = deformable().map(shear).fold(f64::INFINITY, f64::min);
    let thinnest = deformable().map(mean_thickness).fold(size, f64::min);
    let stretch = |body: &Body<D>| {
        let force = body.largest().1;
        let is_in_space = D == 3 || body.mesh().is_of_revolution();
        let across = if is_in_space { size } else { 1.0 };
        let stretch = force / softest / across * (size / thinnest).powi(3);
        // laws without stiffness at rest tell nothing
        if stretch.is_finite() && stretch >= 0.0 {
            stretch
        } else {
            size
        }
    };
    scene.bodies().iter().map(stretch).collect()
}

/// Whether a body has unknowns.
fn is_deformable<const D: usize>(body: &Body<D>) -> bool {
    body.prescribed().iter().any(Option::is_none)
}

/// Twice the volume divided by the surface (UL): the thickness of a plate or a shell.
fn mean_thickness<const D: usize>(body: &Body<D>) -> f64 {
    let mesh = body.mesh();
    let volume: f64 = (0..mesh.len()).map(|cell| mesh.volume(cell)).sum();
    let area = |facet: &[usize]| {
        let corners: [Vector<D>; D] = std::array::from_fn(|k| mesh.nodes()[facet[k]]);
        facet_normal(&corners).norm()
    };
    2.0 * volume / mesh.exterior().map(area).sum::<f64>()
}

/// The corners of the box around all bodies (UL).
fn bounding_box<const D: usize>(bodies: &[Body<D>]) -> (Vector<D>, Vector<D>) {
    let boxes = bodies.iter().map(|body| body.mesh().bounding_box());
    let around = boxes.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)));
    around.unwrap_or((Vector::zeros(), Vector::zeros()))
}

/// Finds bodies whose sizes or stiffnesses differ as units do.
fn units<const D: usize>(scene: &Scene<D>, report: &mut Report) {
    let size = |body: &Body<D>| {
        let (low, high) = body.mesh().bounding_box();
        Some((high - low).norm())
    };
    let shear = |body: &Body<D>| {
        let deforms = is_deformable(body) && !body.is_rigid();
        deforms.then_some(body.rest_moduli().0)
    };
    type Measure<'a, const D: usize> = &'a dyn Fn(&Body<D>) -> Option<f64>;
    let measures: [(&str, Measure<'_, D>); 2] = [("size", &size), ("stiffness", &shear)];
    for (what, measure) in measures {
        let values = scene.bodies().iter().zip(scene.names());
        let values = values.filter_map(|(body, name)| Some((measure(body)?, name)));
        let mut values: Vec<_> = values.filter(|(value, _)| *value > 0.0).collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let [(least, small), .., (most, large)] = &values[..] else {
            continue;
        };
        let ratio = most / least;
        if ratio > UNITS * (1.0 + AT_LIMIT) {
            let finding = Finding::new(Severity::Warning, FindingKind::Units, &[small, large]);
            report.add(finding.measured(ratio, UNITS).says(
                format!(
                    "the {what} of body `{large}` is {ratio:.1e} times that of body `{small}` ({most:.3e} and \
                     {least:.3e})"
                ),
                "check that all bodies have the same units; prescribe a body that is to be rigid",
            ));
        }
    }
}

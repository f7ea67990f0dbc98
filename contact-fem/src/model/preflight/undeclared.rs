//! Bodies that are moved into each other without contact between them.

use super::limits::MEETS;
use super::steps::times;
use super::{Finding, FindingKind, Report, Setup, Severity};
use crate::model::{Body, Overlaps};
use crate::tensor::Vector;

/// At most so many prescribed nodes of a body, and so many load factors, are looked at.
const MOST: usize = 64;

/// Finds two bodies without a pair or a tie whose prescribed displacements move them into each other. Nodes that are not prescribed
/// go along with those that are, the nearer the more. That is an estimate: a warning, and no error.
pub(super) fn check<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    let (scene, X) = (setup.scene, &setup.kinematics.X);
    if scene.overlaps == Overlaps::Allowed {
        return;
    }
    let names = scene.names();
    for second in 1..scene.bodies().len() {
        for first in 0..second {
            let bodies = [first, second];
            if setup.contact.is_pair(bodies) || setup.ties.join(bodies) {
                continue;
            }
            let both = bodies.map(|body| &scene.bodies()[body]);
            let times = times(both);
            let every = times.len().div_ceil(MOST).max(1);
            let depths = times.iter().rev().step_by(every).filter_map(|t| {
                let moved = bodies.map(|body| moved(&scene.bodies()[body], *t));
                if !meet(&moved.each_ref().map(|own| &own.0[..])) {
                    return None;
                }
                let mut x = X.clone();
                for (body, (own, _)) in bodies.into_iter().zip(&moved) {
                    x[setup.kinematics.nodes(body)].copy_from_slice(own);
                }
                let motion = moved[0].1.max(moved[1].1);
                let of = |x: &[Vector<D>]| deepest(setup, x, bodies);
                let (depth, at) = of(&x)?;
                let depth = depth - of(X).map_or(0.0, |(rest, _)| rest);
                (depth > MEETS * motion).then_some((depth, motion, at))
            });
            let Some((depth, motion, at)) = depths.max_by(|a, b| a.0.total_cmp(&b.0)) else {
                continue;
            };
            let [a, b] = bodies.map(|body| &names[body]);
            let finding = Finding::new(Severity::Warning, FindingKind::Undeclared, &[a, b]);
            let finding = finding.at(&at).measured(depth, MEETS * motion);
            report.add(finding.says(
                format!(
                    "bodies `{a}` and `{b}` are moved {depth:.3e} into each other, and no contact pair parts them"
                ),
                "declare the surfaces that come together for contact, or set `Scene::overlaps` if the bodies are to pass through each other",
            ));
        }
    }
}

/// The deepest overlap of two bodies at positions of all nodes (UL), and where it is.
fn deepest<const D: usize>(
    setup: &Setup<'_, D>,
    x: &[Vector<D>],
    [a, b]: [usize; 2],
) -> Option<(f64, Vector<D>)> {
    let overlaps = setup.audit.overlaps(x).into_iter();
    let own = overlaps.filter(|overlap| overlap.bodies == [a, b] || overlap.bodies == [b, a]);
    // chords of round surfaces that turn in each other overlap by their sag
    let depths = own.map(|overlap| (overlap.depth - overlap.sag, overlap.at));
    depths.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Whether the boxes of two sets of points meet.
fn meet<const D: usize>(points: &[&[Vector<D>]; 2]) -> bool {
    let boxes = points.map(|x| {
        let low = x.iter().fold(x[0], |low, x| low.inf(x));
        (low, x.iter().fold(x[0], |high, x| high.sup(x)))
    });
    let [a, b] = boxes;
    (0..D).all(|i| a.0[i] < b.1[i] && b.0[i] < a.1[i])
}

/// The positions of a body's nodes where the prescribed ones are at a load factor, and the largest prescribed displacement (UL).
fn moved<const D: usize>(body: &Body<D>, t: f64) -> (Vec<Vector<D>>, f64) {
    let X = body.mesh().nodes();
    let mut x = X.to_vec();
    let values = body.prescribed_values(t);
    let mut largest = 0.0_f64;
    for i in 0..D {
        let held = values.iter().skip(i).step_by(D).enumerate();
        let held: Vec<(usize, f64)> = held.filter_map(|(a, value)| Some((a, (*value)?))).collect();
        let motions = held.iter().map(|(_, value)| value.abs());
        largest = motions.fold(largest, f64::max);
        if held.iter().all(|(_, value)| *value == 0.0) {
            continue;
        }
        let every = held.len().div_ceil(MOST).max(1);
        for (x, X_a) in x.iter_mut().zip(X) {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (a, value) in held.iter().step_by(every) {
                let weight = 1.0 / (X[*a] - X_a).norm_squared().max(f64::MIN_POSITIVE);
                (sum, weights) = (sum + weight * value, weights + weight);
            }
            x[i] += sum / weights;
        }
        held.iter()
            .for_each(|(a, value)| x[*a][i] = X[*a][i] + value);
    }
    (x, largest)
}

//! Forces against the energy itself: its slope along a random direction of each body, by differences of its value.

use std::f64::consts::TAU;

use contact_core::friction::Friction;
use contact_core::{ContactProblem, LinearGaps, Reduction};

use super::worse;
use crate::model::Problem;

/// The step, as a share of the smallest height of the body's cells. Differences of the fourth order leave out its fourth power.
const STEP: f64 = 1e-3;
/// The largest share of the largest force by which round-off, or the step, may change a slope; beyond it, the slope is not judged.
const RESOLVED: f64 = 5e-6;
/// The round-off of an energy (no unit) in units of modulus times volume, as long as deformation gradients are about 1 and displacements are not larger
/// than the body. Stiff bodies on soft ones showed 60 times the resolution of numbers.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// The largest difference of the slope of a body's energy along its direction from the work of the forces of contact and friction and of those that hold motions
/// which nothing resists, divided by the
/// largest force on a node of the body and the length of the direction; `None` where displacements are so small that the value of the
/// energy does not resolve them.
pub(super) fn apart<const D: usize>(
    problem: &Problem<D>,
    u: &[f64],
    (gaps, lambda): (&LinearGaps, &[f64]),
    (held, friction): (&[f64], Option<&Friction>),
    units: &[f64],
) -> Option<f64> {
    let mut forces = vec![0.0; u.len()];
    forces.iter_mut().zip(held).for_each(|(f, held)| *f = *held);
    gaps.add_forces(lambda, &mut forces);
    if let Some(friction) = friction {
        friction.rows.add_forces(&friction.forces, &mut forces);
    }
    let reduction = problem.reduction();
    let mut worst = None;
    for (body, unit) in units.iter().enumerate() {
        // of revolution the area of the cross-section, and at most its ring about the axis
        let [height, area] = problem.height_and_volume(body);
        let mesh = problem.scene().bodies()[body].mesh();
        let volume = match mesh.is_of_revolution() {
            true => TAU * mesh.bounding_box().1[0] * area,
            false => area,
        };
        let step = STEP * height;
        let v = direction(problem, body, reduction.as_ref(), u.len());
        let length = v.iter().map(|v| v * v).sum::<f64>().sqrt();
        let modulus = problem.body_energies()[body].contact_modulus();
        let (low, high) = mesh.bounding_box();
        let moved = u.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
        let carried = 1.0 + moved / (high - low).max();
        let lost = ROUND_OFF * modulus * volume * carried / step;
        if length == 0.0 || !(lost <= RESOLVED * unit * length) {
            continue;
        }
        let [slope, error] = slope(problem, (u, &v), step);
        if !(error <= RESOLVED * unit * length) {
            continue;
        }
        let work: f64 = forces.iter().zip(&v).map(|(f, v)| f * v).sum();
        let own = (slope - work).abs() / (unit * length);
        worst = Some(worst.map_or(own, |worst| worse(worst, own)));
    }
    worst
}

/// The slope of the energy along v at u, and an estimate of its error: differences over three steps, each twice the one before, extrapolated.
/// Of a quadratic energy, one difference is exact.
fn slope<const D: usize>(problem: &Problem<D>, (u, v): (&[f64], &[f64]), step: f64) -> [f64; 2] {
    let over = |steps: f64| {
        let [back, on] = [-steps, steps].map(|steps| {
            let moved = u.iter().zip(v).map(|(u, v)| u + steps * step * v);
            value(problem, &moved.collect::<Vec<f64>>(), v)
        });
        // loads have a large potential where they are carried far
        let rounded = f64::EPSILON * (on.abs() + back.abs());
        [on - back, rounded].map(|change| change / (2.0 * steps * step))
    };
    let [near, rounded] = over(1.0);
    if problem.energy().is_quadratic() {
        return [near, rounded];
    }
    let [far, farthest] = [2.0, 4.0].map(|steps| over(steps)[0]);
    let [fine, coarse] = [[near, far], [far, farthest]].map(|[a, b]| (4.0 * a - b) / 3.0);
    // the error of an extrapolated difference grows with the fourth power of the step
    [fine, (fine - coarse).abs() / 15.0 + rounded]
}

/// The energy of those bodies that a direction moves.
fn value<const D: usize>(problem: &Problem<D>, u: &[f64], v: &[f64]) -> f64 {
    let mut first = 0;
    let mut sum = 0.0;
    for (body, energy) in problem.body_energies().iter().enumerate() {
        let own = first..first + energy.dofs();
        first = own.end;
        if v[own.clone()].iter().any(|v| *v != 0.0) {
            // a stiffness loses digits that strains have
            sum += match problem.scene().bodies()[body].is_small_strain() {
                true => energy.add_residual(&u[own], &mut vec![0.0; D * problem.nodes(body).len()]),
                false => energy.value(&u[own]),
            };
        }
    }
    sum
}

/// A direction in the unknowns of a body, and what follows from them in others that are tied to it. Components have random signs and random
/// sizes from ½ to 1, so that equal and opposite errors of two forces do not cancel.
fn direction<const D: usize>(
    problem: &Problem<D>,
    body: usize,
    reduction: Option<&Reduction>,
    unknowns: usize,
) -> Vec<f64> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64 ^ ((body as u64) << 32);
    let mut component = || {
        // xorshift
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        let size = 0.5 + 0.5 * (state >> 40) as f64 / (1_u64 << 24) as f64;
        match (state >> 20) & 1 {
            0 => size,
            _ => -size,
        }
    };
    let mut v = vec![0.0; unknowns];
    let energies = problem.body_energies();
    let first: usize = energies[..body].iter().map(|energy| energy.dofs()).sum();
    let own = first..first + energies[body].dofs();
    v[own].iter_mut().for_each(|v| *v = component());
    match reduction {
        None => v,
        Some(reduction) => {
            let free = reduction.map.restricted(&v);
            let none = vec![0.0; reduction.constants.len()];
            reduction.map.expanded(&free, &none)
        }
    }
}

//! Comparison of each single pass with both, on meshes of different fineness and for various ratios
//! of the moduli.

use contact_core::Ending;
use contact_core::Retry;
use contact_core::equilibrium::Solution;
use contact_core::{InteriorPoint, LoadStepped, Method, PenalizedSlack, Penalty};
use contact_fem::Simulation;
use contact_fem::element::Order;
use contact_fem::model::{Passes, Problem};
use contact_fem::simulation::History;

use crate::Failure;
use crate::disc_in_disc::{self, Roles};
use crate::hertz::{self, Fineness, Hertz};
use crate::tables::{Table, digits};

/// The roles of the surfaces.
const ALL_PASSES: [Passes; 3] = [Passes::Both, Passes::FirstIsSlave, Passes::SecondIsSlave];

/// Runs Hertz's contact and the disc-in-disc.
pub fn tables(quick: bool) -> Result<Vec<Table>, Failure> {
    Ok(vec![hertz(quick)?, discs(quick)?])
}

/// Cylinder and block with facet sizes in the ratios 1 : 3 and 3 : 1, for all ratios of their
/// moduli. The loads are such that Hertz's pressure and half-width are the same for all.
fn hertz(quick: bool) -> Result<Table, Failure> {
    let columns =
        "E cylinder : block | facets in a, cylinder : block | method | slave | energy off | \
            pressure off, cylinder | pressure off, block | cylinder's nodes inside | \
            block's nodes inside"
            .split(" | ");
    let mut table = Table::new("hertz_passes", columns);
    let (ratios, reference): (Vec<i32>, _) = match quick {
        true => (vec![-3, 0, 3], 12),
        false => ((-3..=3).collect(), 48),
    };
    for ratio in ratios {
        let of = |fineness: [usize; 2]| Hertz {
            fineness: fineness.map(Fineness::family),
            ..Hertz::new(Fineness::family(1), Order::Linear)
        };
        let of = |fineness| of(fineness).with_ratio(10f64.powi(ratio));
        let exact = Indented::new(of([reference; 2]), &mut InteriorPoint::default())?;
        for fineness in [[12, 4], [4, 12]] {
            for passes in ALL_PASSES {
                let scene = Hertz {
                    passes,
                    ..of(fineness)
                };
                for (name, mut method) in methods() {
                    let found = Indented::new(scene, method.as_mut())?;
                    let slave = name_of(passes, ["cylinder", "block"]);
                    let facets = format!("{} : {}", fineness[0], fineness[1]);
                    let head = [format!("1e{ratio}"), facets, name.into(), slave.into()];
                    table.push([head.to_vec(), found.against(&exact)].concat());
                }
            }
        }
    }
    Ok(table)
}

fn methods() -> [(&'static str, Box<dyn Method>); 3] {
    [
        ("(7)", Box::new(InteriorPoint::default())),
        ("(37)", Box::new(PenalizedSlack::default())),
        ("(39)", Box::new(Penalty::default())),
    ]
}

fn name_of(passes: Passes, names: [&'static str; 2]) -> &'static str {
    match passes {
        Passes::Both => "both",
        Passes::FirstIsSlave => names[0],
        Passes::SecondIsSlave => names[1],
    }
}

/// Runs the scene to full load.
fn solved(
    problem: &mut Problem<2>,
    method: &mut dyn Method,
    increments: usize,
) -> Result<Option<History<2>>, Failure> {
    let history = Simulation::solved_by(Retry::with(method), increments).run(problem)?;
    Ok((history.run.ending == Ending::Complete).then_some(history))
}

/// The results for a cylinder on a block.
struct Indented {
    scene: Hertz,
    found: Option<State>,
}

/// The results at full load.
struct State {
    energy: f64,
    /// (x, pressure) along cylinder and block.
    profiles: [Vec<(f64, f64)>; 2],
    /// The largest depths of nodes of the cylinder and of the block inside the other body (UL).
    inside: [f64; 2],
}

impl Indented {
    fn new(scene: Hertz, method: &mut dyn Method) -> Result<Self, Failure> {
        let mut problem = scene.scene()?.problem()?;
        let history = solved(&mut problem, method, 1)?;
        let Some(solution) = history.and_then(|history| history.run.solution) else {
            return Ok(Indented { scene, found: None });
        };
        let of_side = |passes| -> Result<Problem<2>, Failure> {
            Ok(Hertz { passes, ..scene }.scene()?.problem()?)
        };
        let found = State {
            energy: solution.energy,
            profiles: profiles(&problem, &solution)?,
            inside: inside(of_side, &solution)?,
        };
        Ok(Indented {
            scene,
            found: Some(found),
        })
    }

    /// Energy, root mean square of the pressure over the contact, and penetration divided by
    /// Hertz's approach a²/R, all relative to a reference.
    fn against(&self, exact: &Indented) -> Vec<String> {
        let (Some(found), Some(exact)) = (&self.found, &exact.found) else {
            return vec!["-".into(); 5];
        };
        let a = self.scene.half_width();
        let approach = a * a / hertz::RADIUS;
        let pressure = |k: usize| mean_square(&found.profiles[k], &exact.profiles[k], 1.5 * a);
        let off = (found.energy - exact.energy) / exact.energy.abs();
        let values = [
            off,
            pressure(0),
            pressure(1),
            found.inside[0] / approach,
            found.inside[1] / approach,
        ];
        values.map(|value| digits(Some(value))).to_vec()
    }
}

/// The largest depths of nodes of the first and of the second surface inside the other one (UL): in
/// each case those that a scene with this single pass measures at the same state.
fn inside(
    scene: impl Fn(Passes) -> Result<Problem<2>, Failure>,
    solution: &Solution,
) -> Result<[f64; 2], Failure> {
    let side = |passes| -> Result<f64, Failure> {
        let mut problem = scene(passes)?;
        problem.set_load(1.0)?;
        Ok(problem.penetration(&solution.state.u))
    };
    Ok([side(Passes::FirstIsSlave)?, side(Passes::SecondIsSlave)?])
}

/// The contact pressure over x along both surfaces, first the cylinder's.
fn profiles(problem: &Problem<2>, solution: &Solution) -> Result<[Vec<(f64, f64)>; 2], Failure> {
    let pressures = problem.pressures(&solution.state.u, &solution.gaps, &solution.lambda)?;
    let mut profiles = [Vec::new(), Vec::new()];
    for (surface, pressure) in problem.surfaces().iter().zip(pressures) {
        let nodes = surface.nodes().iter();
        let x = nodes.map(|&a| problem.reference()[a][0]);
        let mut profile: Vec<(f64, f64)> = x.zip(pressure).collect();
        profile.sort_by(|p, q| p.0.total_cmp(&q.0));
        profiles[surface.body()] = profile;
    }
    Ok(profiles)
}

/// √(∫ (p − q)² / ∫ q²) over the interval from 0 to `end`.
fn mean_square(p: &[(f64, f64)], q: &[(f64, f64)], end: f64) -> f64 {
    const SAMPLES: usize = 2000;
    let (mut above, mut below) = (0.0, 0.0);
    for k in 0..SAMPLES {
        let x = end * (k as f64 + 0.5) / SAMPLES as f64;
        let (p, q) = (at(p, x), at(q, x));
        above += (p - q).powi(2);
        below += q * q;
    }
    f64::sqrt(above / below)
}

/// Linear interpolation between neighbours.
fn at(profile: &[(f64, f64)], x: f64) -> f64 {
    let right = profile
        .partition_point(|p| p.0 < x)
        .clamp(1, profile.len() - 1);
    let [(x0, p0), (x1, p1)] = [profile[right - 1], profile[right]];
    p0 + (p1 - p0) * (x - x0) / (x1 - x0)
}

/// Runs the disc-in-disc on three pairs of meshes.
fn discs(quick: bool) -> Result<Table, Failure> {
    let columns = "facets hole : disc | slave | energy | energy off | reaction off | \
            hole's nodes inside (UL) | disc's nodes inside (UL)"
        .split(" | ");
    let mut table = Table::new("discs_passes", columns);
    let (divisor, increments) = if quick { (4, 10) } else { (1, 40) };
    let fineness = |hole: usize, disc: usize| disc_in_disc::Fineness {
        hole: hole / divisor,
        layers: (12 * hole / 64 / divisor).max(1),
        disc: disc / divisor,
    };
    let exact = pushed(fineness(256, 208), Passes::Both, increments)?;
    let exact = exact.ok_or("the reference did not converge")?;
    for (hole, disc) in [(64, 52), (96, 32), (32, 96)] {
        for passes in ALL_PASSES {
            let fineness = fineness(hole, disc);
            let found = pushed(fineness, passes, increments)?;
            let found = found.as_ref();
            let off = |value: fn(&Pushed) -> f64| {
                digits(found.map(|found| value(found) / value(&exact) - 1.0))
            };
            table.push(vec![
                format!("{} : {}", fineness.hole, fineness.disc),
                name_of(passes, ["hole", "disc"]).into(),
                found.map_or("-".into(), |found| format!("{:.3}", found.energy)),
                off(|p| p.energy),
                off(|p| p.reaction),
                digits(found.map(|found| found.inside[0])),
                digits(found.map(|found| found.inside[1])),
            ]);
        }
    }
    Ok(table)
}

/// The disc-in-disc at full load.
struct Pushed {
    energy: f64,
    reaction: f64,
    inside: [f64; 2],
}

fn pushed(
    fineness: disc_in_disc::Fineness,
    passes: Passes,
    increments: usize,
) -> Result<Option<Pushed>, Failure> {
    let problem = |passes| -> Result<Problem<2>, Failure> {
        let roles = Roles {
            passes,
            ..Roles::default()
        };
        Ok(disc_in_disc::scene(fineness, roles)?.problem()?)
    };
    let history = solved(
        &mut problem(passes)?,
        &mut InteriorPoint::default(),
        increments,
    )?;
    let Some(history) = history else {
        return Ok(None);
    };
    let reaction = history.steps.last().map(|step| step.reactions[0][1]);
    let (Some(solution), Some(reaction)) = (history.run.solution, reaction) else {
        return Ok(None);
    };
    Ok(Some(Pushed {
        energy: solution.energy,
        reaction,
        inside: inside(problem, &solution)?,
    }))
}

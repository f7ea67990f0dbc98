//! What the audit finds when the contact search is wrong: the solver gets rows with a planted fault, and the audit, which
//! shares nothing with the search, looks at the state that comes of them. The certificate projects anew, without the fault.

use std::ops::ControlFlow;

use contact_core::equilibrium::Automatic;
use contact_core::gaps::{Row, Sampling};
use contact_core::load_steps::LoadSteps;
use contact_core::nlp::Bounds;
use contact_core::{
    ContactProblem, Ending, Energy, Error, LinearGaps, LoadStepped, RowKey, Scale, State,
};
use contact_fem::audit::Overlap;
use contact_fem::certificate::Certificate;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::model::Problem;
use contact_fem::{Body, NeoHookean};
use ipopt_contact_scenes::pair;

/// A row as the search found it.
struct Found {
    key: RowKey,
    /// Its number.
    number: usize,
    /// The reference position of its node.
    X: [f64; 2],
    /// Its gap at the state of the search.
    gap: f64,
    row: Row,
}

/// What becomes of a row; `None` if it is lost.
type Fault = fn(Found) -> Option<Row>;

/// A problem whose rows have a fault.
struct Faulty {
    problem: Problem<2>,
    fault: Fault,
}

impl Faulty {
    fn spoiled(&self, gaps: &LinearGaps, u: &[f64]) -> LinearGaps {
        let mut spoiled = LinearGaps::new(gaps.is_exact());
        let mut at = vec![0.0; gaps.len()];
        gaps.value(u, &mut at);
        for (number, (&key, gap)) in gaps.keys().iter().zip(at).enumerate() {
            let X = self.problem.reference()[key.node as usize];
            let found = Found {
                key,
                number,
                X: [X[0], X[1]],
                gap,
                row: gaps.row(number),
            };
            if let Some(row) = (self.fault)(found) {
                spoiled.push(key, &row);
            }
        }
        spoiled
    }
}

impl ContactProblem for Faulty {
    fn energy(&self) -> &dyn Energy {
        self.problem.energy()
    }
    fn bounds(&self) -> &Bounds {
        self.problem.bounds()
    }
    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        Ok(self.spoiled(&self.problem.linearize_gaps(u, sampling)?, u))
    }
    fn linearize_reversed(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        let gaps = self.problem.linearize_reversed(u, sampling)?;
        Ok(self.spoiled(&gaps, u))
    }
    fn scale(&self) -> Option<Scale> {
        Some(self.problem.scale())
    }
    fn prescribed_magnitude(&self) -> f64 {
        self.problem.prescribed_magnitude()
    }
}

impl LoadStepped for Faulty {
    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        self.problem.set_load(factor)
    }
    fn lift(&self, u: &[f64], from: f64) -> Vec<f64> {
        self.problem.lift(u, from)
    }
}

/// A block of 1 by 1 pressed by 0.3 on one of 2 by 1.
fn pressed() -> Problem<2> {
    let block = |low: [f64; 2], size: [f64; 2], cells: [usize; 2]| {
        let line = |i: usize| linspace(low[i], low[i] + size[i], cells[i]);
        let mesh = rectangle(&line(0), &line(1), Diagonals::Alternating);
        Body::new(mesh.expect("mesh"), NeoHookean::new(1e3, 0.3).expect("law"))
    };
    let mut lower = block([-0.5, -1.0], [2.0, 1.0], [8, 4]);
    lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let mut upper = block([0.0, 0.0], [1.0, 1.0], [5, 5]);
    upper
        .prescribe("top", [Some(0.0), Some(-0.3)])
        .expect("support");
    let scene = pair((lower, "top"), (upper, "bottom")).expect("a pair");
    scene.problem().expect("a scene")
}

fn scaled(row: Row, of_gap: f64, of_coefficients: f64) -> Row {
    let all = |entries: Vec<(usize, f64)>| {
        let entries = entries.into_iter();
        entries.map(|(j, a)| (j, of_coefficients * a)).collect()
    };
    Row {
        free: all(row.free),
        prescribed: all(row.prescribed),
        constant: of_gap * row.constant,
        ..row
    }
}

fn shifted(row: Row, by: f64) -> Row {
    Row {
        constant: row.constant + by,
        ..row
    }
}

/// Name, fault, and whether it loses contact: bodies are then in each other.
const FAULTS: [(&str, Fault, bool); 22] = [
    ("no row is found", |_| None, true),
    (
        "one role is lost",
        |found| (found.key.pass == 0).then_some(found.row),
        false,
    ),
    (
        "the other role is lost",
        |found| (found.key.pass == 1).then_some(found.row),
        false,
    ),
    (
        "the left half is lost",
        |found| (found.X[0] > 0.5).then_some(found.row),
        true,
    ),
    (
        "the right half is lost",
        |found| (found.X[0] < 0.5).then_some(found.row),
        true,
    ),
    (
        "the middle is lost",
        |found| ((found.X[0] - 0.5).abs() > 0.3).then_some(found.row),
        true,
    ),
    (
        "the ends are lost",
        |found| ((found.X[0] - 0.5).abs() < 0.3).then_some(found.row),
        true,
    ),
    (
        "all but one node are lost",
        |found| ((found.X[0] - 0.4).abs() < 0.01).then_some(found.row),
        true,
    ),
    (
        "every second row is lost",
        |found| (found.number % 2 == 0).then_some(found.row),
        false,
    ),
    (
        "two of three rows are lost",
        |found| (found.number % 3 == 0).then_some(found.row),
        false,
    ),
    (
        "rows that overlap by a tenth of a facet are lost",
        |found| (found.gap > -0.02).then_some(found.row),
        true,
    ),
    (
        "gaps are larger by the facets",
        |found| Some(shifted(found.row, 0.25)),
        true,
    ),
    (
        "gaps are larger by half a facet",
        |found| Some(shifted(found.row, 0.125)),
        true,
    ),
    (
        "gaps are larger by a tenth of a facet",
        |found| Some(shifted(found.row, 0.025)),
        false,
    ),
    (
        "gaps are smaller by a tenth of a facet",
        |found| Some(shifted(found.row, -0.025)),
        false,
    ),
    (
        "gaps have the other sign",
        |found| Some(scaled(found.row, -1.0, -1.0)),
        true,
    ),
    (
        "gaps at the start are ten times as large",
        |found| Some(scaled(found.row, 10.0, 1.0)),
        false,
    ),
    (
        "coefficients have the other sign",
        |found| Some(scaled(found.row, 1.0, -1.0)),
        true,
    ),
    (
        "the slave's side of coefficients is lost",
        |Found { row, .. }| {
            let free = row.free.iter().copied().filter(|(_, a)| *a < 0.0).collect();
            Some(Row { free, ..row })
        },
        false,
    ),
    (
        "normals are turned by 90 degrees",
        |Found { row, .. }| {
            let turned =
                |entries: &[(usize, f64)]| entries.iter().map(|&(j, a)| (j ^ 1, a)).collect();
            Some(Row {
                free: turned(&row.free),
                prescribed: turned(&row.prescribed),
                ..row
            })
        },
        true,
    ),
    (
        "rows are those of their neighbours",
        |Found { row, .. }| {
            let free = row
                .free
                .iter()
                .map(|&(j, a)| (if j > 3 { j - 2 } else { j }, a))
                .collect();
            Some(Row { free, ..row })
        },
        false,
    ),
    (
        "rows that overlap are lost",
        |found| (found.gap > 0.0).then_some(found.row),
        true,
    ),
];

/// Whether the run is complete; the reaction, its largest overlap by the audit, whether the certificate holds.
fn with_fault(fault: Fault) -> (bool, f64, f64, bool) {
    let mut faulty = Faulty {
        problem: pressed(),
        fault,
    };
    let steps = LoadSteps {
        increments: 6,
        max_halvings: 2,
        ..LoadSteps::default()
    };
    let start = State {
        u: vec![0.0; faulty.problem.energy().dofs()],
        ..State::default()
    };
    let mut solver = Automatic::default();
    let run = steps.run(&mut faulty, &mut solver, start, |_| {
        ControlFlow::Continue(())
    });
    let run = run.expect("no misuse");
    let Some(solution) = &run.solution else {
        return (false, f64::NAN, f64::NAN, false);
    };
    let problem = &faulty.problem;
    let u = &solution.state.u;
    let forces = problem.contact_forces(&solution.gaps, &solution.lambda);
    let reaction = problem.reactions(u, &forces)[1][1];
    let overlaps = problem.audit(u).expect("a state").overlaps.into_iter();
    let deepest = overlaps.map(|o| o.relative).fold(0.0, f64::max);
    let holds = Certificate::new(problem, solution).holds(&Default::default());
    (run.ending == Ending::Complete, reaction, deepest, holds)
}

/// Faults that lose contact are found by the audit, or no result comes of them. No fault gives a wrong result that is
/// certified.
#[test]
fn faults_of_the_search_are_found() {
    let (complete, expected, depth, holds) = with_fault(|found| Some(found.row));
    assert!(complete && holds && depth < Overlap::<2>::LIMIT);
    let mut counts = [0; 4];
    for (name, fault, loses) in FAULTS {
        let (complete, reaction, depth, holds) = with_fault(fault);
        let off = (reaction / expected - 1.0).abs();
        let is_audited = depth > Overlap::<2>::LIMIT;
        let found = match (complete, is_audited, holds) {
            (false, ..) => "not converged",
            (_, true, _) => "audit",
            (_, _, false) => "certificate",
            _ => "nothing",
        };
        println!("{name} | {found} | force off by {off:.1e} | depth {depth:.2} | {loses}");
        counts[["audit", "certificate", "not converged", "nothing"]
            .iter()
            .position(|f| *f == found)
            .expect("one of these")] += 1;
        assert!(!(complete && holds && off > 1e-3), "{name}: {off}");
        assert!(!(complete && loses) || is_audited, "{name}: {depth}");
    }
    println!("audit, certificate, not converged, nothing: {counts:?}");
}

//! Contact forces that are the gradient of the gaps, beside those of the paper.
//!
//! The paper's rows have forces along normals that do not turn with the nodes they are averaged of. Here C(u) is replaced by
//! G(u) = ∂c/∂u, so that an equilibrium is a stationary point of E under c(u) ≥ 0, and no work is lost.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;

use contact_core::gaps::{Row, Sampling};
use contact_core::load_steps::Passage;
use contact_core::nlp::Bounds;
use contact_core::{
    Automatic, ContactProblem, Ending, Energy, Error, GapVariation, LinearGaps, LoadStepped,
    LoadSteps, Scale, State, Stop,
};
use contact_fem::Scene;
use contact_fem::model::Problem;
use contact_fem::tensor::Vector;

use ipopt_contact_scenes::disc_in_disc::{self, Fineness, PUSH, Roles};
use ipopt_contact_scenes::tables::{Table, digits};
use ipopt_contact_scenes::{Failure, sliding_disc};

/// A problem whose contact forces are the gradient of its gaps.
struct Conservative(Problem<2>);

impl Conservative {
    /// c + G (v − u) ≥ 0 for the rows c + C (v − u) ≥ 0, both frozen at `u`. Prescribed nodes have no entries: their
    /// forces are not asked for.
    fn with_gradients(&self, u: &[f64], rows: LinearGaps) -> Result<LinearGaps, Error> {
        let asked = vec![Some(0.0); rows.len()];
        let Some(variation) = self.0.vary_gaps(u, &rows, &asked)? else {
            return Ok(rows);
        };
        let mut c = vec![0.0; rows.len()];
        rows.value(u, &mut c);
        let mut gaps = LinearGaps::new(false).sampled_at(rows.sampling());
        for (i, (key, gap)) in rows.keys().iter().zip(c).enumerate() {
            let mut entries = BTreeMap::new();
            let direct = variation.gradients.row(i);
            let by_internal = variation.internal_gradients.row(i);
            let indirect = by_internal
                .flat_map(|(y, g)| variation.internal.row(y).map(move |(j, a)| (j, g * a)));
            for (j, g) in direct.chain(indirect) {
                *entries.entry(j).or_insert(0.0) += g;
            }
            let at_u: f64 = entries.iter().map(|(j, g)| g * u[*j]).sum();
            let row = Row {
                free: entries.into_iter().collect(),
                prescribed: Vec::new(),
                constant: gap - at_u,
                weight: rows.weights()[i],
            };
            gaps.push(*key, &row);
        }
        Ok(gaps)
    }
}

impl ContactProblem for Conservative {
    fn energy(&self) -> &dyn Energy {
        self.0.energy()
    }

    fn bounds(&self) -> &Bounds {
        self.0.bounds()
    }

    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        self.with_gradients(u, self.0.linearize_gaps(u, sampling)?)
    }

    fn linearize_reversed(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        self.with_gradients(u, self.0.linearize_reversed(u, sampling)?)
    }

    /// G exactly, and of the forces Gᵀλ the part that those of the paper have.
    fn vary_gaps(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        self.0.vary_gaps(u, gaps, lambda)
    }

    fn watch(&mut self, stop: Option<&Stop>) {
        self.0.watch(stop);
    }

    fn scale(&self) -> Option<Scale> {
        ContactProblem::scale(&self.0)
    }

    fn prescribed_magnitude(&self) -> f64 {
        self.0.prescribed_magnitude()
    }
}

impl LoadStepped for Conservative {
    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        self.0.set_load(factor)
    }

    fn tunnels(&self, u: &[f64], last: &[f64], from: f64) -> Option<Passage> {
        self.0.tunnels(u, last, from)
    }

    fn lift(&self, u: &[f64], from: f64) -> Vec<f64> {
        self.0.lift(u, from)
    }
}

/// A run's end.
struct Ended {
    energy: f64,
    /// The force that moves the second body (UF), along its motion.
    force: f64,
    /// Work less stored energy, over the latter.
    leak: f64,
    iterations: usize,
    factorizations: usize,
    /// Attempts at load steps that Newton's method did not solve.
    failed: usize,
    seconds: f64,
}

/// Runs a problem whose second body is moved as a whole by `motion` (UL) at full load, against the first one that its supports hold. The
/// work is that of the first body's reaction along the motion.
fn run<P: LoadStepped>(
    mut problem: P,
    of: impl Fn(&P) -> &Problem<2>,
    increments: usize,
    motion: [f64; 2],
) -> Result<Ended, Failure> {
    let clock = Instant::now();
    let start = State {
        u: vec![0.0; problem.energy().dofs()],
        ..State::default()
    };
    let steps = LoadSteps {
        increments,
        ..LoadSteps::default()
    };
    let motion = Vector::from(motion);
    let (mut work, mut last) = (0.0, (0.0, 0.0));
    let mut energy = 0.0;
    let run = steps.run(&mut problem, &mut Automatic::default(), start, |step| {
        let inner = of(step.problem);
        let solution = step.solution;
        let forces = inner.contact_forces(&solution.gaps, &solution.lambda);
        let reaction = inner.reactions(&solution.state.u, &forces)[0];
        let now = (step.factor, -reaction.dot(&motion));
        work += 0.5 * (now.0 - last.0) * (now.1 + last.1);
        last = now;
        energy = solution.energy;
        ControlFlow::Continue(())
    })?;
    if run.ending != Ending::Complete {
        return Err(run.ending.to_string().into());
    }
    let cost = run.cost();
    let failed = run.attempts.iter().map(|attempt| attempt.failed.len());
    Ok(Ended {
        energy,
        force: last.1 / motion.norm(),
        leak: work / energy - 1.0,
        iterations: cost.outer_iterations,
        factorizations: cost.factorizations,
        failed: failed.sum::<usize>() + run.cuts(),
        seconds: clock.elapsed().as_secs_f64(),
    })
}

/// Both kinds of forces on meshes and increments: what is lost of the work, errors against the finest mesh, and what they cost.
///
/// # Errors
/// Scenes that cannot be built, runs that do not converge.
pub fn table(quick: bool) -> Result<Table, Failure> {
    let columns = "scene | mesh | increments | forces | leak | energy off | force off | iterations | \
        factorisations | attempts that failed | s";
    let mut table = Table::new("work", columns.split(" | "));
    let increments: &[usize] = if quick { &[10, 20] } else { &[10, 40, 160] };
    let (meshes, finest): (&[usize], _) = match quick {
        true => (&[16, 24], 48),
        false => (&[24, 48, 96], 256),
    };
    let discs = |segments: usize| disc_in_disc::scene(Fineness::scaled(segments), Roles::default());
    let study = Study {
        name: "disc-in-disc",
        scene: &discs,
        motion: [0.0, -PUSH],
    };
    study.rows(meshes, finest, increments, &mut table)?;
    let along = 1.5;
    let sliding = |cells: usize| sliding_disc::scene(cells, along);
    let study = Study {
        name: "disc along a block",
        scene: &sliding,
        motion: [along, -sliding_disc::PRESSED],
    };
    let (meshes, finest): (&[usize], _) = match quick {
        true => (&[4, 6], 12),
        false => (&[6, 12, 24], 48),
    };
    study.rows(meshes, finest, increments, &mut table)?;
    Ok(table)
}

/// A scene by the fineness of its mesh, and the motion of its second body (UL).
struct Study<'a> {
    name: &'static str,
    scene: &'a dyn Fn(usize) -> Result<Scene<2>, contact_fem::Error>,
    motion: [f64; 2],
}

impl Study<'_> {
    /// The row of every mesh and number of increments; errors are taken against a finer mesh under the paper's forces.
    fn rows(
        &self,
        meshes: &[usize],
        finest: usize,
        increments: &[usize],
        table: &mut Table,
    ) -> Result<(), Failure> {
        let problem = |mesh: usize| (self.scene)(mesh)?.problem();
        let reference = run(problem(finest)?, |own| own, increments[0], self.motion)?;
        for &mesh in meshes {
            for &count in increments {
                let papers = run(problem(mesh)?, |own| own, count, self.motion);
                let gradients = run(
                    Conservative(problem(mesh)?),
                    |own| &own.0,
                    count,
                    self.motion,
                );
                for (forces, ended) in [("paper's", papers), ("gradient", gradients)] {
                    let head = [self.name.into(), mesh.to_string(), count.to_string()];
                    let mut cells = [&head[..], &[forces.to_string()]].concat();
                    cells.extend(ended.map_or_else(
                        |why| [vec![why.to_string()], vec!["-".into(); 6]].concat(),
                        |ended| ended.cells(&reference),
                    ));
                    table.push(cells);
                }
            }
        }
        Ok(())
    }
}

impl Ended {
    fn cells(&self, reference: &Ended) -> Vec<String> {
        vec![
            digits(Some(self.leak)),
            digits(Some(self.energy / reference.energy - 1.0)),
            digits(Some(self.force / reference.force - 1.0)),
            self.iterations.to_string(),
            self.factorizations.to_string(),
            self.failed.to_string(),
            format!("{:.1}", self.seconds),
        ]
    }
}

//! Recorded runs: they write files, show progress and stop cleanly on Ctrl-C.

mod ending;
mod folder;
mod interrupt;
mod observer;
mod progress;
mod summary;
mod usage;

use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;
use std::process::{ExitCode, Termination};
use std::time::Instant;

use contact_core::load_steps::LoadSteps;
use contact_core::memory::MemoryLeft;
use contact_core::{Ending, Equilibrium, MemoryNeed};

use super::file;
use super::picture::{Curve, Curves, MeshPicture, Panel, PressurePicture};
use super::snapshot::Snapshot;
use crate::certificate::Limits;
use crate::error::Error;
use crate::instances::instance;
use crate::model::Problem;
use crate::simulation::{self, DefaultSolver, History, Simulation, StepRecord, StepView};
use ending::{Ended, size};
use folder::{Folder, Heading, check_file_name};
use observer::Observer;
use summary::Summary;

use interrupt::refuse_rather_than_end;
pub use interrupt::{INTERRUPTED, stop_on_ctrl_c};
pub use usage::{cpu_seconds, peak_memory};

/// The exit code of a run that converged with a certificate that does not hold.
pub const NOT_CERTIFIED: u8 = 3;

type Force<'a, const D: usize> = Box<dyn Fn(&StepRecord<D>) -> f64 + 'a>;
type Message<'a, const D: usize> = Box<dyn Fn(&StepView<'_, D>) -> String + 'a>;

/// A run that writes files, made by [`Simulation::record`]. The files are complete up to the last
/// converged step at any time.
///
/// | file | what |
/// |---|---|
/// | `NAME.csv`, `NAME_iterations.csv` | the load steps and their iterations, see [`Tables`](super::history::Tables) |
/// | `NAME_pairs.csv`, `NAME_supports.csv`, `NAME_work.csv` | for each step the contact of each pair, the reaction of each supported boundary, and the work of each support, load and obstacle |
/// | `NAME.pvd`, `NAME_0000.vtu`, … | the states for ParaView, see [`Series`](super::vtk::Series) |
/// | `meshes.svg` | the deformed bodies at rest, half way and at the end |
/// | `pressure.svg` | the contact pressure at the end, see [`PressurePicture`]; none where nothing presses |
/// | `force.svg` | the force of [`Recording::force`] over time, which is the load factor; none of fewer than three steps or without a force |
/// | `summary.json` | what ran on what, the findings before the run, how it ended, the results and what they cost |
/// | `run.lock` | the names of all these files; locked during the run |
///
/// A run has its folder for itself. A second one gets [`Error::FolderInUse`] and changes nothing. The lock is `flock`'s,
/// on Unix only; it ends with the process, by whatever cause. The file `run.lock` stays.
///
/// Before a run writes anything, it removes the files of the run before: those that `run.lock` lists, the summary first.
/// It leaves all others alone. Copy results that you want to keep, or record each run to a folder of its own.
///
/// The summary's `status` is at any time one of these, with its `reason`:
///
/// | `status` | the run |
/// |---|---|
/// | `running` | goes on; or the process was killed, if the lock is free: `flock --nonblock FOLDER/run.lock true` succeeds then |
/// | `complete` | reached full load; `reason` is null unless the certificate does not hold |
/// | `stopped` | was stopped by Ctrl-C, a termination request, its observer, or its budget of time or factorisations; `reason` says which |
/// | `failed` | has a load step that did not converge, met an error, could not write a file, or panicked |
///
/// While it is `running`, and where it failed before the first load step or by a panic, the summary has its first keys
/// only, up to `reason`. A folder with files and no summary is one whose next run was killed before it began.
pub struct Recording<'a, const D: usize, S = DefaultSolver> {
    simulation: &'a mut Simulation<S>,
    /// The files and the output.
    pub plan: Plan<'a, D>,
}

/// What a run will need of memory, and what there is at its start.
#[derive(Clone, Copy)]
struct Memory {
    need: Option<MemoryNeed>,
    left: Option<MemoryLeft>,
}

impl Memory {
    fn line(&self) -> Option<String> {
        let need = self.need?;
        let left = self.left.map(|left| format!("; left: {left}"));
        Some(format!("memory: about {need}{}", left.unwrap_or_default()))
    }
}

/// The files and the output of a [`Recording`].
pub struct Plan<'a, const D: usize> {
    /// The folder of all files; it is created if it does not exist.
    pub folder: PathBuf,
    /// The prefix of the file names, of letters, digits, `_`, `-` and `.`; by default the name of
    /// the folder.
    pub name: String,
    /// The interval of `.vtu` files in increments, beside the first and the last state; 0 writes none. 1 by default.
    pub vtu_every: usize,
    /// The file name of the picture; an empty name draws none.
    pub picture: String,
    /// The file name of the picture of the contact pressure at the last converged step, `pressure.svg` by default. An empty name
    /// draws none; neither is there one where nothing presses.
    pub pressure_picture: String,
    /// The file name of the picture of the force over time, `force.svg` by default. An empty name draws none; neither is there one of
    /// fewer than three converged steps, or without a force.
    pub force_picture: String,
    /// Whether the state half way to full load is kept for the picture; `true` by default.
    pub half_way: bool,
    /// The names of files that the caller adds to the folder after the run, such as pictures. The next run removes them
    /// with the others. None by default.
    pub own_files: Vec<String>,
    /// Whether nothing is printed; `false` by default.
    pub quiet: bool,
    /// Whether the end of the run prints all conditions of the certificate, what was left out, and what the time was spent on; `false` by
    /// default, and a line for each result that matters.
    pub verbose: bool,
    increments: usize,
    /// The force that is called `reaction`, if it is not the largest one.
    force: Option<Force<'a, D>>,
    message: Option<Message<'a, D>>,
}

/// A recorded run. As the result of `main` it gives the exit code.
#[derive(Debug)]
pub struct Recorded<const D: usize> {
    /// The history: the ending and the steps.
    pub history: History<D>,
    /// The states at rest, half way and at the last converged step, as far as the run reached them.
    pub stages: Vec<Stage<D>>,
}

/// A state for a picture.
#[derive(Clone, Debug)]
pub struct Stage<const D: usize> {
    /// A title: the increment that the state completes, and its time.
    pub title: String,
    is_half_way: bool,
    /// The fields of the state.
    pub snapshot: Snapshot<D>,
}

impl<S: Equilibrium> Simulation<S> {
    /// Records the run: it prints the findings of the scene, writes all files to `folder`, shows progress and stops on
    /// Ctrl-C. The folder belongs to the run, which removes the files of an earlier one, see [`Recording`].
    ///
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Body, NeoHookean, Scene, Simulation};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let sides = linspace(0.0, 1.0, 4);
    /// let mut block = Body::new(rectangle(&sides, &sides, Diagonals::Rising)?, NeoHookean::new(1.0, 0.3)?);
    /// block.prescribe("bottom", [Some(0.0), Some(0.0)])?;
    /// block.traction("top", [0.1, 0.0])?;
    /// let mut scene = Scene::new();
    /// let block = scene.add("block", block);
    ///
    /// let folder = std::env::temp_dir().join("sheared_block");
    /// let recorded = Simulation::with_increments(2).record(&folder).run(&mut scene.problem()?)?;
    /// assert!(recorded.history.is_complete() && folder.join("summary.json").exists());
    /// # Ok(())
    /// # }
    /// ```
    pub fn record<const D: usize>(&mut self, folder: impl Into<PathBuf>) -> Recording<'_, D, S> {
        let folder = folder.into();
        let name = folder.file_name().map(|name| name.to_string_lossy());
        let plan = Plan {
            name: name.map_or("run".into(), |name| plain(&name)),
            folder,
            vtu_every: 1,
            picture: "meshes.svg".into(),
            pressure_picture: "pressure.svg".into(),
            force_picture: "force.svg".into(),
            half_way: true,
            own_files: Vec::new(),
            quiet: false,
            verbose: false,
            increments: self.load_steps.all_increments(),
            force: None,
            message: None,
        };
        Recording {
            simulation: self,
            plan,
        }
    }
}

/// A folder's name as the name of a series, which has fewer characters.
fn plain(name: &str) -> String {
    let allowed = |c: char| c.is_alphanumeric() || "_-.".contains(c);
    name.chars()
        .map(|c| if allowed(c) { c } else { '_' })
        .collect()
}

impl<'a, const D: usize, S: Equilibrium> Recording<'a, D, S> {
    /// Sets the force (UF) that the summary reports as `reaction`; the default is the largest one of the supports of a body, or on an
    /// obstacle.
    pub fn force(mut self, force: impl Fn(&StepRecord<D>) -> f64 + 'a) -> Self {
        self.plan.force = Some(Box::new(force));
        self
    }

    /// Sets the text that progress shows for a step; the default is energy, force and iterations.
    pub fn message(mut self, message: impl Fn(&StepView<'_, D>) -> String + 'a) -> Self {
        self.plan.message = Some(Box::new(message));
        self
    }

    /// Solves the problem from rest to full load, as [`Simulation::run`] does.
    ///
    /// # Errors
    /// As [`Simulation::run`]; [`Error::FolderInUse`] if another run writes to the folder; [`Error::Write`] with the
    /// first file that cannot be written. A run that ends with an error leaves a summary, too, with the status
    /// `failed`, if the disk takes one.
    ///
    /// The calling thread gets an error instead of the signal SIGXFSZ from now on, where a file grows beyond a limit of
    /// the system.
    pub fn run(self, problem: &mut Problem<D>) -> Result<Recorded<D>, Error> {
        let Simulation { load_steps, solver } = self.simulation;
        instance().record(self.plan, load_steps, solver, problem)
    }
}

impl<const D: usize> Plan<'_, D> {
    /// [`Recording::run`].
    pub(crate) fn run(
        self,
        load_steps: &LoadSteps,
        solver: &mut dyn Equilibrium,
        problem: &mut Problem<D>,
    ) -> Result<Recorded<D>, Error> {
        let plan = self;
        plan.check()?;
        let (clock, processor) = (Instant::now(), cpu_seconds());
        refuse_rather_than_end();
        stop_on_ctrl_c(&load_steps.stop);
        let choice = solver.choice(problem);
        let memory = Memory {
            need: solver.memory(problem),
            left: contact_core::memory::left(),
        };
        let mut folder = Folder::claim(&plan.folder, Heading::new(&plan, choice))?;
        if !plan.quiet {
            let findings = problem.findings_in(plan.increments);
            findings.iter().for_each(print);
            print(format!("plan: {}", problem.plan()));
            print(format!("solver: {choice}"));
            memory.line().iter().for_each(print);
        }
        let mut observer = match Observer::new(&plan, &mut folder, problem) {
            Ok(observer) => observer,
            Err(error) => return Err(folder.failed(error)),
        };
        let result = simulation::run(load_steps, solver, problem, &mut |step| {
            observer.observe(step)
        });
        let written = observer.finish(problem, result.as_ref().ok());
        let drawn = plan.draw(
            problem,
            (&observer.stages, &observer.records),
            observer.folder,
        );
        let written = written.and(drawn);
        let spent = cpu_seconds()
            .zip(processor)
            .map(|(now, before)| now - before);
        let seconds = (clock.elapsed().as_secs_f64(), spent);
        let became = (&result, written.as_ref().err());
        let ended = Ended::new(&plan, problem, &observer, became, (choice, memory), seconds);
        let summary = Summary::new(&ended, &observer.folder.heading);
        let (told, text) = (ended.text(), summary.json());
        let stages = observer.stages;
        let text = text.map_err(|why| file::failed(&plan.folder, why));
        let concluded = text.and_then(|text| folder.conclude(&text));
        written.and(concluded).map_err(|why| folder.failed(why))?;
        if !plan.quiet {
            let files = plan.folder.display();
            print(format!("{told}\n  files              {files}"));
        }
        result.map(|history| Recorded { history, stages })
    }
}

/// A value with so many decimals, or with digits that count where these would not.
fn fixed(value: f64, decimals: usize) -> String {
    let least = 10f64.powi(1 - decimals as i32);
    match value == 0.0 || (least..1e7).contains(&value.abs()) {
        true => format!("{:.decimals$}", value + 0.0),
        false => format!("{value:.4e}"),
    }
}

impl<const D: usize> Plan<'_, D> {
    /// The force that is called `reaction` (UF): by default the largest one of the supports of a body, or on an obstacle.
    fn force_of(&self, record: &StepRecord<D>, problem: &Problem<D>) -> f64 {
        if let Some(force) = &self.force {
            return force(record);
        }
        let forces = record.reactions.iter().chain(&record.obstacle_forces);
        forces
            .map(|force| size(force, problem.scene()))
            .fold(0.0, f64::max)
    }

    fn message_of(&self, step: &StepView<'_, D>) -> String {
        if let Some(message) = &self.message {
            return message(step);
        }
        let record = step.record;
        format!(
            "energy {}  reaction {}  iterations {} ({} inner)",
            fixed(record.energy, 4),
            fixed(self.force_of(record, step.problem), 2),
            record.attempt.iterations.len(),
            record.attempt.cost.inner_iterations
        )
    }

    /// Checks the names of files, as a run does before it touches the folder.
    ///
    /// # Errors
    /// [`Error::Write`] with a name that none of its files may have.
    pub fn check(&self) -> Result<(), Error> {
        file::check_name(&self.folder, &self.name)?;
        let all = [&self.picture, &self.pressure_picture, &self.force_picture];
        let mut pictures = all.into_iter().filter(|name| !name.is_empty());
        let mut names = self.own_files.iter().chain(pictures.clone());
        names.try_for_each(|name| check_file_name(&self.folder, name))?;
        let is_taken = |name: &&String| {
            let same = pictures.clone().filter(|other| other == name);
            self.own_files.contains(name) || same.count() > 1
        };
        if let Some(name) = pictures.clone().find(is_taken) {
            let why = format!(
                "{name:?} is the name of another file of the run: give the picture another one"
            );
            return Err(file::failed(&self.folder, why));
        }
        // so that none takes the place of a table or a state
        match pictures.find(|name| !name.ends_with(".svg")) {
            Some(name) => {
                let why = format!("{name:?} must end with .svg: pictures are in this format");
                Err(file::failed(&self.folder, why))
            }
            None => Ok(()),
        }
    }

    /// The force over time; `None` of few steps, and without a force.
    fn force_curve(&self, problem: &Problem<D>, records: &[StepRecord<D>]) -> Option<Curves> {
        let steps = records.iter();
        let points: Vec<(f64, f64)> = steps
            .map(|step| (step.factor, self.force_of(step, problem)))
            .collect();
        let has_force = points.iter().any(|(_, force)| *force != 0.0);
        (points.len() >= 3 && has_force).then(|| Curves {
            title: "Reaction".into(),
            x_label: "time (load factor)".into(),
            y_label: "reaction (UF)".into(),
            curves: vec![Curve {
                name: "reaction".into(),
                // nothing is loaded at rest
                points: [vec![(0.0, 0.0)], points].concat(),
            }],
        })
    }

    /// Draws the pictures, and lists the files that the caller adds.
    fn draw(
        &self,
        problem: &Problem<D>,
        (stages, records): (&[Stage<D>], &[StepRecord<D>]),
        folder: &mut Folder,
    ) -> Result<(), Error> {
        self.own_files
            .iter()
            .try_for_each(|name| folder.add(name))?;
        if let (Some(picture), false) = (
            self.force_curve(problem, records),
            self.force_picture.is_empty(),
        ) {
            folder.add(&self.force_picture)?;
            picture.save(self.folder.join(&self.force_picture))?;
        }
        if let (Some(last), false) = (stages.last(), self.pressure_picture.is_empty()) {
            if let Some(picture) = PressurePicture::new(problem, &last.snapshot)? {
                folder.add(&self.pressure_picture)?;
                picture.save(self.folder.join(&self.pressure_picture))?;
            }
        }
        if self.picture.is_empty() {
            return Ok(());
        }
        folder.add(&self.picture)?;
        let panels = stages.iter().map(|stage| Panel {
            title: stage.title.clone(),
            snapshot: &stage.snapshot,
        });
        let path = self.folder.join(&self.picture);
        MeshPicture::von_mises(panels.collect()).save(path, problem)
    }
}

/// 0 at full load, 1 if an increment did not converge, [`NOT_CERTIFIED`] if a certificate does not
/// hold, [`INTERRUPTED`] where it was stopped.
impl<const D: usize> Termination for Recorded<D> {
    fn report(self) -> ExitCode {
        let certificate = self.history.certificate();
        match self.history.run.ending {
            Ending::Complete if certificate.is_none_or(|c| c.holds(&Limits::default())) => {
                ExitCode::SUCCESS
            }
            Ending::Complete => ExitCode::from(NOT_CERTIFIED),
            Ending::Interrupted { .. } => ExitCode::from(INTERRUPTED),
            _ => ExitCode::FAILURE,
        }
    }
}

/// For `main`: the exit code of the result, or 2 on an error, which is printed on the standard
/// error.
pub fn exit<T: Termination>(result: Result<T, impl Display>) -> ExitCode {
    match result {
        Ok(done) => done.report(),
        Err(error) => {
            complain(format_args!("error: {error}"));
            ExitCode::from(2)
        }
    }
}

/// Prints a line on the standard output. A closed pipe, as after `| head`, is ignored.
pub fn print(line: impl Display) {
    match writeln!(std::io::stdout(), "{line}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            complain(format_args!("cannot print: {error}"));
        }
        _ => {}
    }
}

/// Prints a line on the standard error, if that can be written to: it may be a file on a full disk.
fn complain(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

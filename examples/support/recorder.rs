//! Everything that a run leaves on disk while it goes on.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use ipopt_contact::contact_core::Stop;
use ipopt_contact::contact_fem::Error;
use ipopt_contact::contact_fem::output::Snapshot;
use ipopt_contact::contact_fem::output::history::Tables;
use ipopt_contact::contact_fem::output::vtk::Series;
use ipopt_contact::prelude::*;

use super::options::Options;
use super::progress::Progress;

/// The observer of a run: writes tables and `.vtu` files, shows progress, keeps what pictures need,
/// and passes Ctrl-C on.
pub struct Recorder<const D: usize> {
    folder: PathBuf,
    increments: usize,
    vtu_every: usize,
    series: Series,
    tables: Tables,
    progress: Progress,
    stop: Stop,
    /// One a converged step.
    pub records: Vec<StepRecord<D>>,
    /// The states at rest, half way and at the last converged step, as far as the run came.
    pub stages: Vec<Stage<D>>,
    /// Seconds spent in here.
    pub seconds: f64,
    failure: Option<Error>,
}

/// A state to make a picture of.
pub struct Stage<const D: usize> {
    /// The increment it completes, or how far it is.
    pub title: String,
    is_half_way: bool,
    /// Its fields.
    pub snapshot: Snapshot<D>,
}

impl<const D: usize> Recorder<D> {
    /// Files called `name` in `folder`, with the state at rest as the first one.
    pub fn new(
        folder: &Path,
        name: &str,
        problem: &Problem<D>,
        options: &Options,
        stop: Stop,
    ) -> Result<Self, Error> {
        let bodies = problem.scene().bodies().len();
        let mut recorder = Recorder {
            folder: folder.to_path_buf(),
            increments: options.increments(),
            vtu_every: options.vtu_every,
            series: Series::create(folder, name)?,
            tables: Tables::create::<D>(folder, name, bodies)?,
            progress: Progress::new(options.increments(), options.quiet),
            stop,
            records: Vec::new(),
            stages: Vec::new(),
            seconds: 0.0,
            failure: None,
        };
        let rest = Snapshot::at_rest(problem)?;
        if recorder.vtu_every > 0 {
            recorder.series.write(0.0, problem, &rest)?;
        }
        recorder.stages.push(Stage {
            title: "step 0".into(),
            is_half_way: false,
            snapshot: rest,
        });
        Ok(recorder)
    }

    /// To be called for every converged step; stops the run on Ctrl-C and when a file cannot be
    /// written.
    pub fn observe(&mut self, step: &StepView<'_, D>, message: String) -> ControlFlow<()> {
        let clock = Instant::now();
        let record = step.record;
        self.progress.step(record.increment, record.factor, message);
        self.failure = self.write(step).err();
        self.records.push(record.clone());
        self.seconds += clock.elapsed().as_secs_f64();
        match self.failure.is_some() || self.stop.is_requested() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    fn write(&mut self, step: &StepView<'_, D>) -> Result<(), Error> {
        let record = step.record;
        self.tables.write(record)?;
        let snapshot = Snapshot::of_step(step)?;
        let is_due = match record.increment {
            Some(increment) => self.vtu_every > 0 && increment % self.vtu_every == 0,
            None => self.vtu_every == 1,
        };
        if is_due {
            self.series.write(record.factor, step.problem, &snapshot)?;
        }
        // the last stage is replaced by the next one unless it is worth keeping
        if self.stages.len() > 1 && !self.stages[self.stages.len() - 1].is_half_way {
            self.stages.pop();
        }
        self.stages.push(Stage {
            title: match record.increment {
                Some(increment) => format!("step {increment}"),
                None => format!("load {:.4}", record.factor),
            },
            is_half_way: record.increment == Some(self.increments / 2),
            snapshot,
        });
        Ok(())
    }

    /// To be called after the run: failed attempts come into the tables. Reports what could not be
    /// written on the way.
    pub fn finish(&mut self, history: Option<&History<D>>) -> Result<(), Error> {
        let clock = Instant::now();
        self.progress.finish();
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        if let Some(history) = history {
            self.tables.finish(history)?;
        }
        self.seconds += clock.elapsed().as_secs_f64();
        Ok(())
    }

    /// The folder that everything is in.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

//! The observer of a recorded run, which writes files during the run.

use std::ops::ControlFlow;
use std::time::Instant;

use super::folder::Folder;
use super::progress::Progress;
use super::{Plan, Stage};
use crate::error::Error;
use crate::model::Problem;
use crate::output::history::Tables;
use crate::output::snapshot::Snapshot;
use crate::output::vtk::Series;
use crate::simulation::{History, StepRecord, StepView};

/// The observer of a run: writes tables and `.vtu` files, shows progress, and keeps the states for
/// pictures.
pub(super) struct Observer<'a, const D: usize> {
    recording: &'a Plan<'a, D>,
    pub(super) folder: &'a mut Folder,
    series: Series,
    tables: Tables,
    progress: Progress,
    /// One entry for each converged step.
    pub(super) records: Vec<StepRecord<D>>,
    /// The states at rest, half way and at the last converged step, as far as the run reached them.
    pub(super) stages: Vec<Stage<D>>,
    /// The time spent in the observer (s).
    pub(super) seconds: f64,
    failure: Option<Error>,
    /// The load factor of the last state, if no file of the series has it.
    unwritten: Option<f64>,
}

impl<'a, const D: usize> Observer<'a, D> {
    /// Creates the files, with the state at rest as the first one.
    pub(super) fn new(
        recording: &'a Plan<'a, D>,
        folder: &'a mut Folder,
        problem: &Problem<D>,
    ) -> Result<Self, Error> {
        let (path, name) = (&recording.folder, &recording.name);
        let mut series = Series::create(path, name)?;
        for table in Tables::files(name) {
            folder.add(&table)?;
        }
        let tables = {
            let scene = problem.scene();
            Tables::create::<D>(
                path,
                name,
                (scene.names(), scene.obstacle_names(), &scene.rigid_names()),
            )?
        };
        let rest = Snapshot::at_rest(problem)?;
        if recording.vtu_every > 0 {
            write(folder, &mut series, 0.0, problem, &rest)?;
        }
        Ok(Observer {
            recording,
            folder,
            series,
            tables,
            progress: Progress::new(recording.increments, recording.quiet),
            records: Vec::new(),
            stages: vec![Stage {
                title: "at rest".into(),
                is_half_way: false,
                snapshot: rest,
            }],
            seconds: 0.0,
            failure: None,
            unwritten: None,
        })
    }

    /// Records a converged step; stops the run if a file cannot be written.
    pub(super) fn observe(&mut self, step: &StepView<'_, D>) -> ControlFlow<()> {
        let clock = Instant::now();
        let record = step.record;
        let message = self.recording.message_of(step);
        self.progress.step(record.increment, record.factor, message);
        self.failure = self.write(step).err();
        self.records.push(record.clone());
        self.seconds += clock.elapsed().as_secs_f64();
        match self.failure.is_some() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    fn write(&mut self, step: &StepView<'_, D>) -> Result<(), Error> {
        let (record, recording) = (step.record, self.recording);
        self.tables.write(record)?;
        let snapshot = Snapshot::of_step(step)?;
        let is_due = match record.increment {
            Some(increment) => recording.vtu_every > 0 && increment % recording.vtu_every == 0,
            None => recording.vtu_every == 1,
        };
        if is_due {
            let (time, problem) = (record.factor, step.problem);
            write(self.folder, &mut self.series, time, problem, &snapshot)?;
        }
        self.unwritten = (recording.vtu_every > 0 && !is_due).then_some(record.factor);
        // the last stage is replaced by the next one unless it is at rest or half way
        if self.stages.len() > 1 && !self.stages[self.stages.len() - 1].is_half_way {
            self.stages.pop();
        }
        let half_way = recording.increments / 2;
        self.stages.push(Stage {
            title: match record.increment {
                Some(increment) => {
                    format!("increment {increment}, time {}", rounded(record.factor))
                }
                None => format!("time {}", rounded(record.factor)),
            },
            is_half_way: recording.half_way && record.increment == Some(half_way),
            snapshot,
        });
        Ok(())
    }

    /// Ends the recording: writes the last state if the series lacks it, adds the failed attempts to the tables and brings all data to
    /// the disk, or returns the error of a file that could not be written during the run.
    pub(super) fn finish(
        &mut self,
        problem: &Problem<D>,
        history: Option<&History<D>>,
    ) -> Result<(), Error> {
        let clock = Instant::now();
        self.progress.finish();
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        if let (Some(time), Some(stage)) = (self.unwritten.take(), self.stages.last()) {
            let snapshot = &stage.snapshot;
            write(self.folder, &mut self.series, time, problem, snapshot)?;
        }
        if let Some(history) = history {
            self.tables.finish(history)?;
        }
        self.folder.sync()?;
        self.seconds += clock.elapsed().as_secs_f64();
        Ok(())
    }
}

/// A time with at most four decimals.
fn rounded(time: f64) -> f64 {
    (time * 1e4).round() / 1e4
}

/// Lists the next files of a series and writes them.
fn write<const D: usize>(
    folder: &mut Folder,
    series: &mut Series,
    time: f64,
    problem: &Problem<D>,
    snapshot: &Snapshot<D>,
) -> Result<(), Error> {
    for name in series.next_files(problem) {
        folder.add(&name)?;
    }
    series.write(time, problem, snapshot)
}

//! From a scene to its files and an exit code, the same for every example.

use std::process::ExitCode;
use std::time::Instant;

use ipopt_contact::contact_fem::certificate::Limits;
use ipopt_contact::prelude::*;

use super::files::print;
use super::options::Options;
use super::recorder::Recorder;
use super::summary::{End, Summary, worst};
use super::{Failure, stop};

/// The exit code of a run that converged to something whose certificate does not hold.
const NOT_CERTIFIED: u8 = 3;

/// What is an example's own.
pub struct Run<'a, const D: usize> {
    /// Its name, of folder and files too.
    pub name: &'a str,
    /// The force (UF) that it is about.
    pub reaction: &'a dyn Fn(&StepRecord<D>) -> f64,
    /// What progress shows of a step.
    pub message: &'a dyn Fn(&StepView<'_, D>) -> String,
    /// Pictures, after the run.
    pub draw: &'a dyn Fn(&Problem<D>, &Recorder<D>) -> Result<(), Failure>,
    /// What else there is to say.
    pub report: &'a dyn Fn(&Problem<D>, &Recorder<D>) -> String,
}

impl<const D: usize> Run<'_, D> {
    /// Solves the problem, with everything on disk up to wherever it comes: code 0 at full load, 1
    /// if some increment does not converge, 3 if a certificate does not hold, 130 on Ctrl-C.
    pub fn go(&self, mut problem: Problem<D>, options: &Options) -> Result<ExitCode, Failure> {
        let clock = Instant::now();
        let stop = stop::on_ctrl_c()?;
        let mut simulation = options.simulation(stop.clone())?;
        let folder = options.folder(self.name);
        let mut recorder = Recorder::new(&folder, self.name, &problem, options, stop)?;
        let result = simulation.run_observed(&mut problem, |step| {
            let message = (self.message)(step);
            recorder.observe(step, message)
        });
        let ending = match &result {
            Ok(history) => End::History(history),
            Err(error) => End::Failure(error),
        };
        let written = recorder.finish(result.as_ref().ok());
        (self.draw)(&problem, &recorder)?;

        let seconds = clock.elapsed().as_secs_f64();
        let summary = Summary::new(
            self.name,
            &problem,
            &recorder,
            options.increments(),
            &ending,
            seconds,
            self.reaction,
        );
        summary.save(&folder)?;
        written?;
        if !options.quiet {
            let report = (self.report)(&problem, &recorder);
            let files = folder.display();
            let table = summary.table();
            print(format!("{table}\n  files              {files}{report}"))?;
        }
        let worst = worst(&recorder.records);
        let is_certified = worst.is_none_or(|found| found.holds(&Limits::default()));
        Ok(match ending {
            End::Failure(error) => return Err(error.to_string().into()),
            _ if ending.is_complete() && !is_certified => ExitCode::from(NOT_CERTIFIED),
            _ if ending.is_complete() => ExitCode::SUCCESS,
            _ if ending.is_interrupted() => ExitCode::from(stop::INTERRUPTED),
            _ => ExitCode::FAILURE,
        })
    }
}

/// For `main`: the code, or 2 with the error on stderr.
pub fn exit(result: Result<ExitCode, Failure>) -> ExitCode {
    result.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        ExitCode::from(2)
    })
}

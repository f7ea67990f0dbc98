//! Checks of a scene before any solve. They cost much less than one factorisation.

mod curves;
mod finding;
mod input;
mod interference;
mod laws;
mod limits;
mod loads;
mod meshes;
mod obstacles;
mod overlap;
mod pieces;
mod pressures;
mod resisted;
mod steps;
mod supports;
mod surfaces;
#[cfg(test)]
mod tests;
mod ties;
mod undeclared;

pub use finding::{Finding, FindingKind, Severity};
pub(super) use steps::at_increments;
pub(super) use supports::{clusters, held, held_rows, modes, motion, unheld_motions};

use super::contact_set::ContactSet;
use super::kinematics::Kinematics;
use super::tie::{self, Ties};
use super::{Pair, Scene};
use crate::audit::Audit;
use crate::error::Error;

/// The findings so far, and the errors among them.
#[derive(Default)]
pub(crate) struct Report {
    findings: Vec<Finding>,
    errors: Vec<Error>,
}

impl Report {
    pub fn add(&mut self, finding: Finding) {
        self.findings.push(finding);
    }

    /// The value of a check that passed; else `None`, and the error is reported.
    pub fn take<T>(&mut self, result: Result<T, Error>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                self.findings.push(Finding::of(&error));
                self.errors.push(error);
                None
            }
        }
    }

    /// The findings, the worst first.
    pub fn into_findings(mut self) -> Vec<Finding> {
        self.findings
            .sort_by_key(|finding| std::cmp::Reverse(finding.severity));
        self.findings
    }

    /// The errors, in the order of the findings.
    pub fn into_errors(self) -> Vec<Error> {
        self.errors
    }

    /// The findings, the worst first.
    ///
    /// # Errors
    /// The first error, if there is one.
    pub fn accepted(self) -> Result<Self, Error> {
        let Report { findings, errors } = self;
        match errors.into_iter().next() {
            Some(error) => Err(error),
            None => Ok(Report {
                findings,
                errors: Vec::new(),
            }),
        }
    }
}

/// A scene with all its pairs, its surfaces and its audit.
pub(super) struct Setup<'a, const D: usize> {
    pub scene: &'a Scene<D>,
    pub pairs: &'a [Pair],
    pub kinematics: &'a Kinematics<D>,
    pub contact: &'a ContactSet<D>,
    pub audit: &'a Audit<D>,
    pub ties: &'a Ties<D>,
}

/// The checks of names, numbers, supports and loads. They need neither surfaces nor assembly. Returns whether the settings are within
/// their ranges, without which no other check is done.
pub(super) fn without_surfaces<const D: usize>(
    scene: &Scene<D>,
    pairs: &[Pair],
    report: &mut Report,
) -> bool {
    report.take(input::names(scene));
    if report.take(input::settings(scene)).is_none() {
        return false;
    }
    report.take(input::kinds(scene));
    report.take(input::forces(scene));
    report.take(input::laws(scene));
    report.take(tie::check(scene));
    input::boundaries(scene, report);
    supports::check(scene, pairs, report);
    report.take(pressures::rims(scene));
    loads::check(scene, pairs, report);
    true
}

/// The checks of the supports that hold in a later phase.
pub(super) fn supports_of_phase<const D: usize>(
    scene: &Scene<D>,
    pairs: &[Pair],
    report: &mut Report,
) {
    supports::check(scene, pairs, report);
    report.take(pressures::rims(scene));
}

/// The checks that need surfaces and thicknesses.
pub(super) fn with_surfaces<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    report.take(input::offsets(setup.scene, setup.contact.reach));
    report.take(input::frictions(setup.scene));
    interference::check(setup, report);
    obstacles::check(setup, report);
    surfaces::check(setup, report);
    curves::check(setup, report);
    ties::check(setup, report);
    meshes::check(setup, report);
    laws::check(setup, report);
    steps::check(setup, report);
    undeclared::check(setup, report);
}

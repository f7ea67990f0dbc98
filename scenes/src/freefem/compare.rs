//! Runs FreeFEM's scripts and this library side by side.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::Parser;
use contact_core::ipopt::versions;
use contact_fem::output::record::print;

use super::cases::{Built, CASES, Case, Script, Size};
use super::outcome::Outcome;
use super::process::{Usage, measured, stop_together};
use super::reference::Reference;
use super::report::{Entry, Report};
use super::solve::solve;
use super::theirs::{FreeFem, INSTALL};
use crate::cli::positive;
use crate::{Failure, files};

/// The CPU time (s) above which a run is not repeated.
const LONG: f64 = 60.0;

/// FreeFEM and this library on the same scenes
#[derive(Parser, Debug)]
pub struct Arguments {
    /// Only this scene; may be repeated
    #[arg(long, value_name = "NAME")]
    scene: Vec<String>,
    /// Only this size; may be repeated
    #[arg(long, value_enum, default_values_t = [Size::Tiny])]
    size: Vec<Size>,
    /// Runs of each program, if they take less than a minute
    #[arg(long, default_value_t = 3, value_parser = positive)]
    runs: usize,
    /// Only one of the two programs; its results are compared with earlier ones of the other, if
    /// there are any
    #[arg(long, value_enum)]
    only: Option<Program>,
    /// Only FreeFEM's scripts of this style: tuned or literal
    #[arg(long, value_parser = ["tuned", "literal"])]
    style: Option<String>,
    /// Keep FreeFEM's results of the first script of each scene in freefem/reference
    #[arg(long)]
    save_reference: bool,
    /// Only write the meshes for FreeFEM to DIR/SCENE/SIZE
    #[arg(long, value_name = "DIR")]
    export_only: Option<PathBuf>,
    /// Folder for all files
    #[arg(long, value_name = "DIR", default_value = "out/freefem_compare")]
    out: PathBuf,
    /// Run a single task in this process
    #[arg(long, hide = true, value_enum)]
    child: Option<Child>,
}

/// `--only`
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Program {
    Ours,
    Freefem,
}

/// `--child`
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Child {
    Export,
    Solve,
}

fn export(case: &Case, size: Size, folder: &Path) -> Result<(), Failure> {
    files::make_folder(folder)?;
    Ok(case.scene(size)?.export(case.bodies, folder)?)
}

fn compare(arguments: &Arguments, cases: &[&Case]) -> Result<ExitCode, Failure> {
    let freefem = FreeFem::find();
    if freefem.is_none() {
        print(INSTALL);
    }
    let versions = versions();
    let mut report = Report {
        freefem: freefem.as_ref().map(|found| found.version.clone()),
        ipopt: versions.ipopt.into(),
        libraries: [
            versions.linear_solver,
            versions.blas.map(|blas| blas.to_string()),
        ],
        entries: Vec::new(),
        failures: Vec::new(),
    };
    for (case, size) in arguments.pairs(cases) {
        let bench = Bench::new(arguments, case, size)?;
        if let Err(why) = bench.run(freefem.as_ref(), &mut report) {
            let failure = format!("{} {}: {why}", case.name, size.name());
            eprintln!("error: {failure}");
            report.failures.push(failure);
            report.save(&arguments.out)?;
        }
    }
    for table in report.tables() {
        print(table.markdown());
    }
    print(format!("files in {}", arguments.out.display()));
    let failed = !report.failures.is_empty();
    Ok(ExitCode::from(if failed { 2 } else { 0 }))
}

/// Removes the files of an earlier run, so that they are not mistaken for those of the next.
fn clear(folder: &Path) -> Result<(), Failure> {
    let clear = || {
        for file in std::fs::read_dir(folder)? {
            let file = file?;
            if file.file_type()?.is_file() {
                std::fs::remove_file(file.path())?;
            }
        }
        Ok(())
    };
    clear().map_err(|error: std::io::Error| files::cannot("clear", folder, error))
}

/// One scene of one size, for all programs.
struct Bench<'a> {
    arguments: &'a Arguments,
    case: &'a Case,
    size: Size,
    folder: PathBuf,
}

impl<'a> Bench<'a> {
    fn new(arguments: &'a Arguments, case: &'a Case, size: Size) -> Result<Self, Failure> {
        files::make_folder(&arguments.out)?;
        let out = arguments.out.canonicalize();
        let out = out.map_err(|error| files::cannot("find", &arguments.out, error))?;
        let folder = out.join(case.name).join(size.name());
        files::make_folder(&folder)?;
        Ok(Bench {
            arguments,
            case,
            size,
            folder,
        })
    }

    /// Runs all requested programs, compares the results, and saves the report after each.
    fn run(&self, freefem: Option<&FreeFem>, report: &mut Report) -> Result<(), Failure> {
        let meshes = self.folder.join("meshes");
        files::make_folder(&meshes)?;
        measured(&mut self.child(Child::Export, &meshes)?, &meshes)?;
        let ours = self.entry("ours", Program::Ours, |out| self.child(Child::Solve, out))?;
        if let Some((entry, _)) = &ours {
            report.add(entry.clone(), &self.arguments.out)?;
        }
        let Some(freefem) = freefem else {
            let stored = match &ours {
                Some((entry, outcome)) => self.stored(entry, outcome)?,
                None => None,
            };
            return match stored {
                Some(entry) => report.add(entry, &self.arguments.out),
                None => Err("there is no stored result of FreeFEM to compare with".into()),
            };
        };
        for script in self.case.scripts.iter().filter(|s| self.runs(s)) {
            let command = |out: &Path| freefem.command(self.case, script, self.size, &meshes, out);
            let Some((mut entry, theirs)) = self.entry(script.style, Program::Freefem, command)?
            else {
                continue;
            };
            if let Some((ours, outcome)) = &ours {
                let differences = [
                    theirs.energy_difference(outcome),
                    theirs.displacement_difference(outcome),
                    theirs.reaction_difference(outcome),
                    theirs.pressure_difference(outcome),
                ];
                entry.compare(ours, differences);
            }
            let is_new = entry.usage.is_some() && entry.converged;
            report.add(entry, &self.arguments.out)?;
            if is_new {
                self.keep(script, freefem, &theirs)?;
            }
        }
        Ok(())
    }

    /// Whether a script is requested and meant for this size.
    fn runs(&self, script: &Script) -> bool {
        let style = &self.arguments.style;
        let is_asked = style.as_ref().is_none_or(|style| style == script.style);
        is_asked && self.size <= script.up_to
    }

    /// Runs a program as often as required. If only the other program was requested, returns the
    /// results of an earlier run, if there are any.
    fn entry(
        &self,
        name: &str,
        program: Program,
        command: impl Fn(&Path) -> Result<Command, Failure>,
    ) -> Result<Option<(Entry, Outcome)>, Failure> {
        let out = self.folder.join(name);
        files::make_folder(&out)?;
        let mut runs: Vec<Usage> = Vec::new();
        let is_asked = self.arguments.only.is_none_or(|only| only == program);
        if is_asked {
            clear(&out)?;
        } else if !out.join("result.txt").exists() {
            return Ok(None);
        }
        while is_asked && runs.len() < self.arguments.runs {
            eprintln!(
                "{} {} {name}, run {}",
                self.case.name,
                self.size.name(),
                runs.len() + 1
            );
            runs.push(measured(&mut command(&out)?, &out)?);
            if runs[0].cpu > LONG {
                break;
            }
        }
        let outcome = Outcome::read(self.case, &out)?;
        let mut entry = Entry::new(self.case.name, self.size.name(), name, &outcome);
        entry.runs = runs.len();
        entry.usage = (!runs.is_empty()).then(|| Usage::median(&runs));
        Ok(Some((entry, outcome)))
    }

    /// A command that runs this program again for a single task on this scene.
    fn child(&self, child: Child, out: &Path) -> Result<Command, Failure> {
        let mut command = Command::new(std::env::current_exe()?);
        let child = match child {
            Child::Export => "export",
            Child::Solve => "solve",
        };
        command
            .args(["--child", child, "--scene", self.case.name])
            .args(["--size", self.size.name(), "--out"])
            .arg(out);
        Ok(command)
    }

    /// Stores the result of the scene's first script if requested.
    fn keep(&self, script: &Script, freefem: &FreeFem, outcome: &Outcome) -> Result<(), Failure> {
        let is_first = std::ptr::eq(script, &self.case.scripts[0]);
        if !self.arguments.save_reference || !is_first {
            return Ok(());
        }
        let dimension = match self.case.scene(self.size)? {
            Built::Plane(_) => 2,
            Built::Space(_) => 3,
        };
        let version = &freefem.version;
        let reference = Reference::new(self.case, dimension, outcome, script.file, version);
        reference.save(self.case, self.size)
    }

    /// The stored result, which replaces FreeFEM's.
    fn stored(&self, ours: &Entry, outcome: &Outcome) -> Result<Option<Entry>, Failure> {
        let Some(reference) = Reference::read(self.case, self.size)? else {
            return Ok(None);
        };
        let theirs = reference.outcome(self.case);
        let mut entry = Entry::new(self.case.name, self.size.name(), "stored", &theirs);
        let differences = [
            theirs.energy_difference(outcome),
            reference.displacement_difference(self.case, &outcome.displacements),
            theirs.reaction_difference(outcome),
            theirs.pressure_difference(outcome),
        ];
        entry.compare(ours, differences);
        Ok(Some(entry))
    }
}

impl Arguments {
    /// Runs the comparison, or the other task that the arguments request. The exit code is 2 if a
    /// scene could not be compared.
    ///
    /// # Errors
    /// If the comparison cannot continue.
    pub fn run(&self) -> Result<ExitCode, Failure> {
        let cases = self.cases()?;
        if let Some(folder) = &self.export_only {
            for (case, size) in self.pairs(&cases) {
                let folder = folder.join(case.name).join(size.name());
                export(case, size, &folder)?;
                print(folder.display());
            }
            return Ok(ExitCode::SUCCESS);
        }
        if let Some(child) = self.child {
            for (case, size) in self.pairs(&cases) {
                match child {
                    Child::Export => export(case, size, &self.out)?,
                    Child::Solve => solve(case, size, &self.out)?,
                }
            }
            return Ok(ExitCode::SUCCESS);
        }
        stop_together()?;
        compare(self, &cases)
    }

    fn cases(&self) -> Result<Vec<&'static Case>, Failure> {
        match self.scene.is_empty() {
            true => Ok(CASES.iter().collect()),
            false => Ok(self
                .scene
                .iter()
                .map(|name| Case::named(name))
                .collect::<Result<_, _>>()?),
        }
    }

    /// Every combination of scene and size.
    fn pairs<'a>(&self, cases: &[&'a Case]) -> Vec<(&'a Case, Size)> {
        let sizes = |&case| self.size.iter().map(move |&size| (case, size));
        cases.iter().flat_map(sizes).collect()
    }
}

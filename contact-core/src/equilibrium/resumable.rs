//! Runs that go on where they ended: the answers of a solver, kept in a file.

use std::cell::Cell;
use std::collections::VecDeque;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};

use super::{Choice, Equilibrium, Solution, StepContext};
use crate::gaps::Sampling;
use crate::{ContactProblem, Error, LOG, LinearGaps, MemoryNeed, Outcome, State};

/// A solver whose answers are kept in a file, so that a run which was ended at any moment goes on.
///
/// Do the same run again, with the same file: the solver gives the answers that are there again, without solving, and goes on
/// behind them. Observers, records and files see all load steps again. Energies, states, forces and
/// counts are those of a run that was not ended, to the last bit. Times are those of this run: kept answers take none.
///
/// Answers are kept in groups. A group ends once its answers have taken [`Resumable::WORTH`] factorisations, which is mostly after each
/// one where steps are costly, after [`Resumable::every`] answers at the latest, and at the end of each phase. **The solver begins anew
/// after each group**, in any run: that is how a resumed run continues alike. Factors and starts of inner solvers that last over load
/// steps are computed again then.
///
/// A group is written at its end, and the file is synchronised, unless the last time is so short ago that writing would take more than
/// some per cent of the run; it is written with a later one then. A run that is killed loses the answers of one group at most, and those
/// of some twenty times as long as it takes to write one.
///
/// The file tells whether it belongs to the run: it has a checksum of the rows at the first start, and of rows and energy gradient
/// at each answer, which take one linearisation each. An answer that disagrees is [`Error::Resume`], before the run sees it. The file takes some
/// 8 bytes for each unknown and load step, and some 10 for each entry of a row. One run uses it at a time.
///
/// ```
/// use contact_core::equilibrium::Resumable;
/// use contact_core::{Automatic, LoadSteps};
/// # fn example(mut problem: impl contact_core::LoadStepped, start: contact_core::State) -> Result<(), contact_core::Error> {
/// let mut solver = Resumable::new("press.resume", Automatic::default).every(20);
/// let run = LoadSteps::default().run(&mut problem, &mut solver, start, |_| std::ops::ControlFlow::Continue(()))?;
/// # Ok(())
/// # }
/// ```
pub struct Resumable<F, E> {
    make: F,
    solver: E,
    file: PathBuf,
    settings: String,
    every: usize,
    /// The file, once there was a question.
    journal: Option<Journal>,
    /// Whether a run has begun since the last question, which reads the file from its beginning.
    is_new: Cell<bool>,
}

impl<F: Fn() -> E, E: Equilibrium> Resumable<F, E> {
    /// The factorisations after which a group ends: to begin anew takes no more than an analysis and one of them. Their number, unlike a
    /// time, is the same in any run.
    pub const WORTH: usize = 10;

    /// Solvers that `make` makes, all alike, and the file of their answers, which need not be there yet.
    pub fn new(file: impl Into<PathBuf>, make: F) -> Self {
        Resumable {
            solver: make(),
            make,
            file: file.into(),
            settings: String::new(),
            every: 10,
            journal: None,
            is_new: Cell::new(true),
        }
    }

    /// The most answers in a group; 10 by default, and at least 1.
    pub fn every(self, answers: usize) -> Self {
        Resumable {
            every: answers,
            ..self
        }
    }

    /// A text on which answers depend beside the problem, such as the settings of the solver: a file with another one is
    /// refused.
    pub fn with_settings(self, settings: impl Into<String>) -> Self {
        Resumable {
            settings: settings.into(),
            ..self
        }
    }

    /// The header of a file of this run.
    fn header(&self, print: u32) -> Header {
        Header {
            version: VERSION,
            library: env!("CARGO_PKG_VERSION").to_string(),
            settings: self.settings.clone(),
            every: self.every,
            print,
        }
    }

    /// The kept answer to this question; `None` if there is none.
    fn kept(
        &mut self,
        problem: &dyn ContactProblem,
        question: &Question,
        start: &State,
    ) -> Result<Option<Solution>, Error> {
        if self.journal.is_none() {
            let header = self.header(print_of_rows(problem, &start.u)?);
            self.journal = Some(Journal::open(&self.file, &header)?);
        }
        let Some(journal) = &mut self.journal else {
            return Ok(None);
        };
        let fault = |why: &str| Err(foreign(&self.file, why));
        let Some(answer) = journal.next(&self.file)? else {
            return Ok(None);
        };
        if answer.question != *question {
            return fault("has answers for other load steps, or from other starts");
        }
        let u = &answer.solution.state.u;
        if u.len() != problem.energy().dofs() || answer.gradient != print_of_gradient(problem, u) {
            return fault("has answers of another problem");
        }
        if answer.rows != print_of_rows(problem, u)? {
            return fault("has answers of a problem with other contacts, supports or motions");
        }
        if answer.is_last {
            self.solver = (self.make)();
        }
        let mut solution = answer.solution;
        for iteration in &mut solution.history {
            iteration.cost = iteration.cost.without_times();
        }
        Ok(Some(solution))
    }

    /// Keeps an answer, and writes the group that it completes.
    fn keep(
        &mut self,
        problem: &dyn ContactProblem,
        question: Question,
        solution: &Solution,
    ) -> Result<(), Error> {
        let Some(journal) = &mut self.journal else {
            return Ok(());
        };
        let u = &solution.state.u;
        let at_end = question.is_end && solution.outcome == Outcome::Converged;
        let own = journal.group.iter().map(|answer| &answer.solution);
        let took = own.chain([solution]).map(|own| own.cost().factorizations);
        let took: usize = took.sum();
        let is_last = at_end || journal.group.len() + 1 >= self.every || took >= Self::WORTH;
        journal.group.push(Answer {
            question,
            gradient: print_of_gradient(problem, u),
            rows: print_of_rows(problem, u)?,
            is_last,
            solution: solution.clone(),
        });
        if is_last {
            journal.complete(&self.file, at_end)?;
            self.solver = (self.make)();
        }
        Ok(())
    }
}

impl<F: Fn() -> E, E: Equilibrium> Equilibrium for Resumable<F, E> {
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        if self.is_new.take() && self.journal.take().is_some() {
            self.solver = (self.make)();
        }
        let question = Question {
            from: context.from.to_bits(),
            to: context.to.to_bits(),
            is_end: context.is_end,
            start: print_of_numbers(crc32fast::Hasher::new(), &start.u),
        };
        if let Some(solution) = self.kept(problem, &question, &start)? {
            return Ok(solution);
        }
        let solution = self.solver.solve(problem, start, context)?;
        let dofs = problem.energy().dofs();
        Error::check_length("the solver's u", &solution.state.u, dofs)?;
        // where a request or a limit of time came is no answer
        if solution.outcome != Outcome::Interrupted {
            self.keep(problem, question, &solution)?;
        }
        Ok(solution)
    }

    fn choice(&self, problem: &dyn ContactProblem) -> Choice {
        self.solver.choice(problem)
    }

    fn lifts_starts(&self, problem: &dyn ContactProblem) -> bool {
        self.solver.lifts_starts(problem)
    }

    fn validate(&self) -> Result<(), Error> {
        if self.every == 0 {
            return Err(Error::Setting {
                name: "every",
                value: "0".into(),
                remedy: "a group has at least one answer",
            });
        }
        self.is_new.set(true); // this is called before each run
        self.solver.validate()
    }

    /// Refuses a file of other settings, too, before a run writes anything.
    fn check(&self, problem: &dyn ContactProblem) -> Result<(), Error> {
        if let Some((_, known)) = begun(&self.file)? {
            let asked = self.header(known.print);
            if known != asked {
                return Err(foreign(&self.file, known.otherwise(&asked)));
            }
        }
        self.solver.check(problem)
    }

    fn memory(&self, problem: &dyn ContactProblem) -> Option<MemoryNeed> {
        self.solver.memory(problem)
    }
}

/// What the file of a run that is to go on has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kept {
    /// Load steps that converged.
    pub steps: usize,
    /// The largest load factor of these.
    pub until: f64,
}

/// What a file has for a run to resume; `None` if it is not there, or has no load step that converged. Whether it belongs to a run is told
/// when that begins.
///
/// # Errors
/// A file that cannot be read, or is none of a run.
pub fn kept(path: impl AsRef<Path>) -> Result<Option<Kept>, Error> {
    let path = path.as_ref();
    let failed = |error| failed(path, "read", error);
    let Some((mut file, header)) = begun(path)? else {
        return Ok(None);
    };
    if header.version != VERSION {
        return Ok(None);
    }
    let mut kept: Option<Kept> = None;
    loop {
        let group: Option<Vec<Answer>> = record(&mut file).map_err(failed)?;
        let Some(group) = group else {
            return Ok(kept);
        };
        let is_reached = |answer: &&Answer| answer.solution.outcome == Outcome::Converged;
        for answer in group.iter().filter(is_reached) {
            let to = f64::from_bits(answer.question.to);
            let before = kept.unwrap_or(Kept {
                steps: 0,
                until: 0.0,
            });
            kept = Some(Kept {
                steps: before.steps + 1,
                until: to.max(before.until),
            });
        }
    }
}

/// A file behind its header, and the header; `None` if it is not there, or has no whole header.
fn begun(path: &Path) -> Result<Option<(File, Header)>, Error> {
    let failed = |error| failed(path, "read", error);
    match path.metadata() {
        Err(_) => return Ok(None),
        // to open a pipe would wait for who writes it
        Ok(known) if !known.is_file() => return Err(foreign(path, "is no regular file")),
        Ok(_) => {}
    }
    let mut file = File::open(path).map_err(failed)?;
    let mut magic = Vec::new();
    let head = Read::by_ref(&mut file).take(MAGIC.len() as u64);
    { head }.read_to_end(&mut magic).map_err(failed)?;
    if !MAGIC.starts_with(&magic) {
        return Err(foreign(path, "is no file of a run to resume"));
    }
    let header = record(&mut file).map_err(failed)?;
    Ok(header.map(|header| (file, header)))
}

/// What a solver was asked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Question {
    /// The bits of both load factors.
    from: u64,
    to: u64,
    is_end: bool,
    /// The checksum of the start.
    start: u32,
}

/// What it answered.
#[derive(Serialize, Deserialize)]
struct Answer {
    question: Question,
    /// The checksums of ∇E and of the rows at the answer.
    gradient: u32,
    rows: u32,
    /// Whether it completes a group.
    is_last: bool,
    solution: Solution,
}

/// The first record.
#[derive(PartialEq, Serialize, Deserialize)]
struct Header {
    version: u32,
    library: String,
    settings: String,
    every: usize,
    /// The checksum of the rows at the first start.
    print: u32,
}

const VERSION: u32 = 2;
/// Groups wait until the last writing is so many times as long ago as it took.
const REST: u32 = 20;
const MAGIC: &[u8; 8] = b"contact\n";

/// The file: records, each with its length and its checksum. The first one is the header, all others are groups of answers.
struct Journal {
    file: File,
    /// Answers of a group that were read, and not given yet.
    read: VecDeque<Answer>,
    /// Whether all groups were read.
    is_at_end: bool,
    /// Answers of a group that is not complete.
    group: Vec<Answer>,
    /// Records of complete groups that are not written yet.
    waiting: Vec<u8>,
    /// When groups were written last, and how long that took.
    written: Option<(Instant, Duration)>,
}

impl Journal {
    /// Opens the file behind its header, which it gets if it is new.
    fn open(path: &Path, header: &Header) -> Result<Self, Error> {
        let failed = |error| failed(path, "used", error);
        // to open a pipe would wait for who reads it
        if path.metadata().is_ok_and(|known| !known.is_file()) {
            return Err(foreign(path, "is no regular file"));
        }
        let mut options = OpenOptions::new();
        let options = options.read(true).write(true).create(true).truncate(false);
        let mut file = options.open(path).map_err(failed)?;
        let mut bytes = MAGIC.to_vec();
        bytes.extend(to_record(header).map_err(failed)?);
        let mut beginning = Vec::new();
        let most = Read::by_ref(&mut file).take(bytes.len() as u64);
        let read = { most }.read_to_end(&mut beginning);
        read.map_err(failed)?;
        let is_new = beginning.len() < bytes.len() && bytes.starts_with(&beginning);
        if is_new {
            // or of a run that was killed as it began
            rewritten(&mut file, 0, &bytes).map_err(failed)?;
        } else if beginning != bytes {
            if !beginning.starts_with(MAGIC) {
                return Err(foreign(path, "is no file of a run to resume"));
            }
            file.seek(SeekFrom::Start(MAGIC.len() as u64))
                .map_err(failed)?;
            let known: Option<Header> = record(&mut file).map_err(failed)?;
            let why = known.map_or("has a damaged beginning", |known| known.otherwise(header));
            return Err(foreign(path, why));
        }
        Ok(Journal {
            file,
            read: VecDeque::new(),
            is_at_end: is_new,
            group: Vec::new(),
            waiting: Vec::new(),
            written: None,
        })
    }

    /// The next answer; `None` behind the last one.
    fn next(&mut self, path: &Path) -> Result<Option<Answer>, Error> {
        let failed = |error| failed(path, "read", error);
        if self.read.is_empty() && !self.is_at_end {
            let place = self.file.stream_position().map_err(failed)?;
            let group: Option<VecDeque<Answer>> = record(&mut self.file).map_err(failed)?;
            match group.filter(|group| group.iter().all(|answer| answer.is_whole())) {
                Some(group) => self.read = group,
                None => {
                    // the end, or a group that was being written when the run ended
                    self.is_at_end = true;
                    let lost = self.file.metadata().map_err(failed)?.len() - place;
                    if lost > 0 {
                        log::warn!(
                            target: LOG,
                            "the last {lost} bytes of {} are no answers: those load steps are solved again",
                            path.display()
                        );
                    }
                    rewritten(&mut self.file, place, &[]).map_err(failed)?;
                }
            }
        }
        Ok(self.read.pop_front())
    }

    /// Completes the group, and writes what waits unless that was done a short time ago.
    fn complete(&mut self, path: &Path, at_once: bool) -> Result<(), Error> {
        let failed = |error| failed(path, "written", error);
        let record = to_record(&self.group).map_err(failed)?;
        self.waiting.extend(record);
        self.group.clear();
        let is_due = |(at, took): (Instant, Duration)| at.elapsed() >= REST * took;
        match at_once || self.written.is_none_or(is_due) {
            true => self.write().map_err(failed),
            false => Ok(()),
        }
    }

    /// Appends what waits. What was written of it before a failure is cut off when the file is read.
    fn write(&mut self) -> io::Result<()> {
        let clock = Instant::now();
        let waiting = std::mem::take(&mut self.waiting);
        self.file.write_all(&waiting)?;
        self.file.sync_data()?;
        self.written = Some((Instant::now(), clock.elapsed()));
        Ok(())
    }
}

/// A run that ends within a phase leaves its complete groups.
impl Drop for Journal {
    fn drop(&mut self) {
        if self.waiting.is_empty() {
            return;
        }
        if let Err(why) = self.write() {
            log::warn!(target: LOG, "the last answers of a run to resume are lost: {why}");
        }
    }
}

impl Header {
    /// The first difference.
    fn otherwise(&self, asked: &Header) -> &'static str {
        if self.version != asked.version || self.library != asked.library {
            "was written by another version of the library"
        } else if self.settings != asked.settings {
            "belongs to a run with another scene or other settings"
        } else if self.every != asked.every {
            "has groups of another length"
        } else {
            "belongs to a problem with other contacts, supports or first load step"
        }
    }
}

impl Answer {
    /// Whether its rows are rows.
    fn is_whole(&self) -> bool {
        let Solution { gaps, lambda, .. } = &self.solution;
        let friction = self.solution.friction.as_ref();
        let n = self.solution.state.u.len();
        let has_friction = friction.is_none_or(|friction| friction.is_whole(n));
        gaps.is_whole(n) && lambda.len() == gaps.len() && has_friction
    }
}

/// The next record; `None` where the file ends or has something else.
fn record<T: DeserializeOwned>(file: &mut File) -> io::Result<Option<T>> {
    let place = file.stream_position()?;
    let left = file.metadata()?.len().saturating_sub(place);
    let mut head = [0; 12];
    if left < head.len() as u64 {
        return Ok(None);
    }
    file.read_exact(&mut head)?;
    let [length, sum] = [&head[..8], &head[8..]].map(|bytes| {
        let digits = bytes.iter().rev();
        digits.fold(0, |number, &byte| number << 8 | u64::from(byte))
    });
    if length > left - head.len() as u64 {
        return Ok(None);
    }
    let mut bytes = Vec::new();
    Read::by_ref(file).take(length).read_to_end(&mut bytes)?;
    let is_sound = u64::from(crc32fast::hash(&bytes)) == sum;
    Ok(postcard::from_bytes(&bytes).ok().filter(|_| is_sound))
}

fn to_record(content: &impl Serialize) -> io::Result<Vec<u8>> {
    let content = postcard::to_stdvec(content).map_err(io::Error::other)?;
    let mut bytes = (content.len() as u64).to_le_bytes().to_vec();
    bytes.extend(crc32fast::hash(&content).to_le_bytes());
    bytes.extend(content);
    Ok(bytes)
}

/// Cuts the file at `place` and writes there.
fn rewritten(file: &mut File, place: u64, bytes: &[u8]) -> io::Result<()> {
    file.set_len(place)?;
    file.seek(SeekFrom::Start(place))?;
    file.write_all(bytes)?;
    file.sync_data()
}

/// The file is of something else.
fn foreign(path: &Path, why: &str) -> Error {
    Error::Resume {
        file: path.display().to_string(),
        why: format!("{why}; do the run that it belongs to, or remove it to begin anew"),
    }
}

/// The system refuses.
fn failed(path: &Path, what: &str, error: io::Error) -> Error {
    Error::Resume {
        file: path.display().to_string(),
        why: format!(
            "cannot be {what}: {error}; mend that and do the run again, and what the file has is kept"
        ),
    }
}

fn print_of_numbers(mut sum: crc32fast::Hasher, numbers: &[f64]) -> u32 {
    for number in numbers {
        sum.update(&number.to_bits().to_le_bytes());
    }
    sum.finalize()
}

fn print_of_gradient(problem: &dyn ContactProblem, u: &[f64]) -> u32 {
    let energy = problem.energy();
    let mut gradient = vec![0.0; energy.dofs()];
    if energy.value(u).is_finite() {
        energy.gradient(u, &mut gradient);
    }
    print_of_numbers(crc32fast::Hasher::new(), &gradient)
}

fn print_of_rows(problem: &dyn ContactProblem, u: &[f64]) -> Result<u32, Error> {
    let forward: LinearGaps = problem.linearize_gaps(u, Sampling::Nodes)?;
    let rows = forward.and(problem.linearize_reversed(u, Sampling::Nodes)?);
    let mut sum = crc32fast::Hasher::new();
    for (row, unknown, _) in rows.entries() {
        sum.update(&(row as u64).to_le_bytes());
        sum.update(&(unknown as u64).to_le_bytes());
    }
    let values = rows.entries().map(|(_, _, value)| value);
    let numbers: Vec<f64> = rows.constant().iter().copied().chain(values).collect();
    Ok(print_of_numbers(sum, &numbers))
}

/// Reads a name that programs have as a constant. Each is kept for the life of the process, once.
pub(crate) fn name<'de, D: Deserializer<'de>>(from: D) -> Result<&'static str, D::Error> {
    use std::sync::{Mutex, PoisonError};
    static NAMES: Mutex<Vec<&'static str>> = Mutex::new(Vec::new());
    let name = String::deserialize(from)?;
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = names.iter().find(|known| **known == name) {
        return Ok(known);
    }
    let new: &'static str = name.leak();
    names.push(new);
    Ok(new)
}

#[cfg(test)]
mod tests;

//! The target of Ipopt's log.

use std::{
    fmt,
    io::{self, Write},
    mem,
    sync::{Arc, Mutex, PoisonError},
};

use thiserror::Error;

/// The target of Ipopt's log, see [`Solver::set_log`](super::Solver::set_log); it is never standard output.
///
/// The option [`print_level`](super::Options::print_level) sets its detail: 0 a few warnings only, 3 a summary, 5 a
/// line per iteration, 12 everything. The default is 0, and 5 for a [`Log::Writer`].
#[derive(Default)]
#[non_exhaustive]
pub enum Log {
    /// Discarded; Ipopt generates no text.
    Off,
    /// To the `log` crate, line by line: target `ipopt`, level debug. If that level is disabled, Ipopt generates no
    /// text.
    #[default]
    Crate,
    /// To a file, a buffer or a channel, while Ipopt runs.
    Writer(Box<dyn Write + Send>),
}

impl Log {
    /// To this writer.
    pub fn writer(writer: impl Write + Send + 'static) -> Self {
        Self::Writer(Box::new(writer))
    }

    /// A log that is kept as a string, and the [`LogText`] to read it.
    ///
    /// ```
    /// # use contact_core::ipopt::{Log, Options, Solver, Start};
    /// # use contact_core::nlp::{Bounds, Nlp, Pattern, Structure};
    /// # struct Parabola;
    /// # impl Nlp for Parabola {
    /// #     fn objective(&mut self, x: &[f64], _: bool) -> f64 { x[0] * x[0] }
    /// #     fn gradient(&mut self, x: &[f64], _: bool, g: &mut [f64]) { g[0] = 2.0 * x[0]; }
    /// # }
    /// # let structure = Structure::new(Bounds::free(1), Bounds::default(), Pattern::empty(), None)?;
    /// # let mut solver = Solver::new(structure, &Options::new())?;
    /// let (log, text) = Log::text();
    /// solver.set_log(log);
    /// solver.solve(&mut Parabola, &Start::at(&[1.0]))?;
    /// assert!(text.take().contains("Optimal Solution Found"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn text() -> (Self, LogText) {
        let text = LogText::default();
        (Self::writer(text.clone()), text)
    }
}

/// What Ipopt has logged: see [`Log::text`]. Clones share it.
#[derive(Debug, Clone, Default)]
pub struct LogText(Arc<Mutex<Vec<u8>>>);

impl LogText {
    /// The text logged since the last call, or since the beginning.
    pub fn take(&self) -> String {
        let bytes = mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner));
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

impl Write for LogText {
    fn write(&mut self, text: &[u8]) -> io::Result<usize> {
        let mut bytes = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        bytes.extend_from_slice(text);
        Ok(text.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl fmt::Debug for Log {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Off => "Off",
            Self::Crate => "Crate",
            Self::Writer(_) => "Writer(..)",
        })
    }
}

/// The error that kept the [`Log::Writer`] from receiving the whole log. The solve continues without it.
#[derive(Clone, PartialEq, Eq, Error)]
#[error("Ipopt's log could not be written: {message}")]
#[non_exhaustive]
pub struct LogError {
    /// The kind of the writer's error.
    pub kind: io::ErrorKind,
    /// Its message.
    pub message: String,
}

/// The log of one solve.
pub(super) struct Sink<'a> {
    log: &'a mut Log,
    /// The line that has begun, for the `log` crate.
    line: Vec<u8>,
    pub(super) error: Option<LogError>,
}

impl<'a> Sink<'a> {
    pub(super) fn new(log: &'a mut Log) -> Self {
        Self {
            log,
            line: Vec::new(),
            error: None,
        }
    }

    /// Whether Ipopt has to generate text.
    pub(super) fn is_open(&self) -> bool {
        match self.log {
            Log::Off => false,
            Log::Crate => log::log_enabled!(target: "ipopt", log::Level::Debug),
            Log::Writer(_) => true,
        }
    }

    pub(super) fn write(&mut self, text: &[u8]) {
        match self.log {
            Log::Off => {}
            Log::Crate => {
                for piece in text.split_inclusive(|&byte| byte == b'\n') {
                    self.line.extend_from_slice(piece);
                    if piece.ends_with(b"\n") {
                        emit(&mem::take(&mut self.line));
                    }
                }
            }
            Log::Writer(writer) if self.error.is_none() => {
                self.error = writer.write_all(text).err().map(LogError::from);
            }
            Log::Writer(_) => {}
        }
    }

    /// Emits the last, incomplete line and flushes the writer.
    pub(super) fn finish(&mut self) {
        if !self.line.is_empty() {
            emit(&mem::take(&mut self.line));
        }
        if let (Log::Writer(writer), None) = (&mut *self.log, &self.error) {
            self.error = writer.flush().err().map(LogError::from);
        }
    }
}

fn emit(line: &[u8]) {
    log::debug!(target: "ipopt", "{}", String::from_utf8_lossy(line).trim_end());
}

impl From<io::Error> for LogError {
    fn from(error: io::Error) -> Self {
        Self {
            kind: error.kind(),
            message: error.to_string(),
        }
    }
}

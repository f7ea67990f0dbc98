//! The progress of a run: a bar in a terminal, plain lines elsewhere.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};

use super::print;

/// Shows one message for each converged step.
pub(super) enum Progress {
    /// A bar, in a terminal.
    Bar(ProgressBar),
    /// Plain lines, in a file or a pipe.
    Lines,
    /// No output.
    Quiet,
}

impl Progress {
    /// Progress of a run with this number of increments.
    pub fn new(increments: usize, quiet: bool) -> Self {
        if quiet {
            return Progress::Quiet;
        }
        if !std::io::stderr().is_terminal() {
            return Progress::Lines;
        }
        let template = "{bar:20} {pos}/{len}, {eta} left: {wide_msg}";
        let style = ProgressStyle::with_template(template);
        let bar = ProgressBar::new(increments as u64);
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Progress::Bar(bar)
    }

    /// Shows a converged step; `increment` is the increment that it completes, if any.
    pub fn step(&self, increment: Option<usize>, factor: f64, message: String) {
        match self {
            Progress::Bar(bar) => {
                if let Some(increment) = increment {
                    bar.set_position(increment as u64);
                }
                bar.set_message(message);
            }
            Progress::Lines => print(format!("time {factor:.4}: {message}")),
            Progress::Quiet => {}
        }
    }

    /// Clears the line for later output.
    pub fn finish(&self) {
        if let Progress::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

//! One table as Markdown and as comma-separated values.

use std::fmt::Display;
use std::path::Path;

use crate::{Failure, files};

/// A table that grows row by row.
pub struct Table {
    name: &'static str,
    rows: Vec<Vec<String>>,
    /// Rows do not show on the standard error as they come.
    pub quiet: bool,
}

impl Table {
    /// An empty one with these columns.
    pub fn new(name: &'static str, columns: &[&str]) -> Self {
        let head = columns.iter().map(|c| c.to_string()).collect();
        Table {
            name,
            rows: vec![head],
            quiet: false,
        }
    }

    /// Appends a row, a cell a column, and shows it on the standard error, as progress.
    pub fn push(&mut self, cells: Vec<String>) {
        if !self.quiet {
            eprintln!("{}: {}", self.name, cells.join("  "));
        }
        self.rows.push(cells);
    }

    /// The head and all rows.
    pub fn rows(&self) -> &[Vec<String>] {
        &self.rows
    }

    /// In Markdown, columns aligned.
    pub fn markdown(&self) -> String {
        let width = |k: usize| {
            let cells = self.rows.iter().map(|row| row[k].chars().count());
            cells.max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.rows[0].len()).map(width).collect();
        let line = |row: &Vec<String>| {
            let cells = row.iter().zip(&widths);
            let cells: Vec<String> = cells.map(|(c, w)| format!(" {c:<w$} ")).collect();
            format!("|{}|\n", cells.join("|"))
        };
        let dashes: Vec<String> = widths.iter().map(|w| "-".repeat(w + 2)).collect();
        let rule = format!("|{}|\n", dashes.join("|"));
        let body: String = self.rows[1..].iter().map(line).collect();
        line(&self.rows[0]) + &rule + &body
    }

    /// Writes `.md` and `.csv` with the table's name to `folder`.
    pub fn save(&self, folder: &Path) -> Result<(), Failure> {
        let path = folder.join(self.name);
        files::write(path.with_extension("md"), self.markdown())?;
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in &self.rows {
            writer.write_record(row)?;
        }
        files::write(path.with_extension("csv"), writer.into_inner()?)
    }
}

/// Three digits, or a dash.
pub fn digits(value: Option<f64>) -> String {
    value.map_or("-".into(), |v| format!("{v:.2e}"))
}

/// A number, or a dash.
pub fn number(value: Option<impl Display>) -> String {
    value.map_or("-".into(), |v| v.to_string())
}

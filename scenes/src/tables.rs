//! One table as Markdown and as comma-separated values.

use std::fmt::Display;
use std::path::Path;

use crate::{Failure, files};

/// A table to which rows are appended.
pub struct Table {
    name: &'static str,
    rows: Vec<Vec<String>>,
    /// Whether rows are not printed on the standard error.
    pub quiet: bool,
}

impl Table {
    /// An empty table with these columns.
    pub fn new(name: &'static str, columns: impl IntoIterator<Item: AsRef<str>>) -> Self {
        let columns = columns.into_iter();
        let head = columns.map(|c| c.as_ref().to_string()).collect();
        Table {
            name,
            rows: vec![head],
            quiet: false,
        }
    }

    /// Appends a row with one cell for each column, and prints it on the standard error as
    /// progress.
    pub fn push(&mut self, cells: Vec<String>) {
        if !self.quiet {
            eprintln!("{}: {}", self.name, cells.join("  "));
        }
        self.rows.push(cells);
    }

    /// All lines: the column titles and the rows.
    pub fn rows(&self) -> &[Vec<String>] {
        &self.rows
    }

    /// The table in Markdown, with aligned columns.
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

    /// Writes the table to `folder` as `.md` and `.csv` files with its name.
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

/// A number with three digits, or a dash.
pub fn digits(value: Option<f64>) -> String {
    value.map_or("-".into(), |v| format!("{v:.2e}"))
}

/// A number, or a dash.
pub fn number(value: Option<impl Display>) -> String {
    value.map_or("-".into(), |v| v.to_string())
}

//! The comparison as tables, as JSON and as a picture.

use std::path::Path;

use contact_fem::output::picture::{Curve, Curves};
use serde::Serialize;

use super::outcome::Outcome;
use super::process::Usage;
use crate::tables::Table;
use crate::{Failure, files};

/// One program on one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Entry {
    /// The scene's name.
    pub scene: String,
    /// The size's name.
    pub size: String,
    /// Cells of all bodies.
    pub cells: f64,
    /// `ours`, `tuned` or `literal`; `stored` for a result kept from another machine.
    pub program: String,
    /// What it took, the median of `runs` runs; nothing of a stored result.
    pub usage: Option<Usage>,
    /// How many runs.
    pub runs: usize,
    /// Whether it says that all increments converged.
    pub converged: bool,
    /// Iterations of all fixed points, and of Ipopt in them.
    pub iterations: [f64; 2],
    /// Seconds by the program's own clock, of CPU time in FreeFEM and of wall time in ours: rows;
    /// Ipopt with its linear solver; all else.
    pub seconds: [f64; 3],
    /// Energy, displacement, reaction and pressure: relative differences from ours.
    pub differences: Option<[f64; 4]>,
    /// CPU time, wall time and peak memory over ours.
    pub ratios: Option<[f64; 3]>,
}

impl Entry {
    /// Of a run that left `outcome`.
    pub fn new(scene: &str, size: &str, program: &str, outcome: &Outcome) -> Self {
        let pair = |a: &str, b: &str| [outcome.value(a), outcome.value(b)];
        let [rows, ipopt] = pair("seconds_rows", "seconds_ipopt");
        Entry {
            scene: scene.into(),
            size: size.into(),
            cells: outcome.value("cells"),
            program: program.into(),
            usage: None,
            runs: 0,
            converged: outcome.converged(),
            iterations: pair("fixed_point_iterations", "ipopt_iterations"),
            seconds: [rows, ipopt, outcome.value("seconds_total") - rows - ipopt],
            differences: None,
            ratios: None,
        }
    }

    /// Notes differences from our run and the ratio of CPU times.
    pub fn compare(&mut self, ours: &Entry, differences: [f64; 4]) {
        self.cells = ours.cells;
        self.differences = Some(differences);
        self.ratios = self.usage.zip(ours.usage).map(|(theirs, ours)| {
            let memory = theirs.peak as f64 / ours.peak as f64;
            [theirs.cpu / ours.cpu, theirs.wall / ours.wall, memory]
        });
    }
}

/// Everything there is to say.
#[derive(Serialize)]
pub struct Report {
    /// FreeFEM's version, if it ran.
    pub freefem: Option<String>,
    /// The version of Ipopt, which both use where they come from one system.
    pub ipopt: String,
    /// The linear solver and the BLAS that our runs load.
    pub libraries: [Option<String>; 2],
    /// All runs.
    pub entries: Vec<Entry>,
    /// What went wrong where.
    pub failures: Vec<String>,
}

impl Report {
    /// Adds a program and saves everything so far, since the next one may take long.
    pub fn add(&mut self, entry: Entry, folder: &Path) -> Result<(), Failure> {
        let (scene, size, program) = (&entry.scene, &entry.size, &entry.program);
        eprintln!("{scene} {size} {program}: done");
        self.entries.push(entry);
        self.save(folder)
    }

    /// The differences of every program from ours, and what each took.
    pub fn tables(&self) -> [Table; 2] {
        let mut results = Table::new(
            "results",
            &[
                "scene",
                "size",
                "cells",
                "program",
                "converged",
                "fixed point",
                "Ipopt",
                "energy off",
                "displacement off",
                "reaction off",
                "pressure off",
            ],
        );
        let mut costs = Table::new(
            "costs",
            &[
                "scene",
                "size",
                "cells",
                "program",
                "runs",
                "wall s",
                "CPU s",
                "rows s",
                "Ipopt s",
                "rest s",
                "peak MB",
                "CPU / ours",
                "wall / ours",
                "memory / ours",
            ],
        );
        (results.quiet, costs.quiet) = (true, true);
        for entry in &self.entries {
            let name = || {
                let cells = format!("{}", entry.cells);
                vec![
                    entry.scene.clone(),
                    entry.size.clone(),
                    cells,
                    entry.program.clone(),
                ]
            };
            let off = |k: usize| match entry.differences {
                Some(all) if all[k].is_finite() => format!("{:.1e}", all[k]),
                _ => "-".into(),
            };
            let converged = if entry.converged { "yes" } else { "no" };
            let mut row = name();
            row.extend([converged.into()]);
            row.extend(entry.iterations.map(|n| format!("{n}")));
            row.extend([0, 1, 2, 3].map(off));
            results.push(row);
            if let Some(usage) = entry.usage {
                let mut row = name();
                row.push(entry.runs.to_string());
                let [rows, ipopt, rest] = entry.seconds;
                let seconds = [usage.wall, usage.cpu, rows, ipopt, rest];
                row.extend(seconds.map(|s| format!("{s:.2}")));
                row.push(format!("{:.0}", usage.peak as f64 / 1e6));
                row.extend(
                    entry
                        .ratios
                        .map_or([1.0; 3], |r| r)
                        .map(|r| format!("{r:.1}")),
                );
                costs.push(row);
            }
        }
        [results, costs]
    }

    /// Writes `results` and `costs` as Markdown and comma-separated values, `compare.json`, `cpu.svg`
    /// and `memory.svg`.
    pub fn save(&self, folder: &Path) -> Result<(), Failure> {
        for table in self.tables() {
            table.save(folder)?;
        }
        let text = serde_json::to_string_pretty(self)?;
        files::write(folder.join("compare.json"), text + "\n")?;
        let cpu = self.picture("CPU time, one thread", "CPU seconds", |usage| usage.cpu);
        cpu.save(folder.join("cpu.svg"))?;
        let peak = |usage: Usage| usage.peak as f64 / 1e6;
        let memory = self.picture("Peak memory", "megabytes", peak);
        Ok(memory.save(folder.join("memory.svg"))?)
    }

    /// What runs took over cells, a curve for each program on each scene.
    fn picture(&self, title: &str, unit: &str, taken: impl Fn(Usage) -> f64) -> Curves {
        let mut curves: Vec<Curve> = Vec::new();
        for entry in &self.entries {
            let Some(usage) = entry.usage else { continue };
            let name = format!("{}, {}", entry.scene.replace('_', " "), entry.program);
            let point = (entry.cells.log10(), taken(usage).log10());
            match curves.iter_mut().find(|curve| curve.name == name) {
                Some(curve) => curve.points.push(point),
                None => curves.push(Curve {
                    name,
                    points: vec![point],
                }),
            }
        }
        Curves {
            title: title.into(),
            x_label: "log10 of the number of cells".into(),
            y_label: format!("log10 of {unit}"),
            curves,
        }
    }
}

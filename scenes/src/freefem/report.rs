//! The results of the comparison as tables, JSON and pictures.

use std::path::Path;

use contact_fem::output::picture::{Curve, Curves};
use serde::Serialize;

use super::outcome::Outcome;
use super::process::Usage;
use crate::tables::Table;
use crate::{Failure, files};

/// The result of one program on one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Entry {
    /// The scene's name.
    pub scene: String,
    /// The size's name.
    pub size: String,
    /// Cells of all bodies.
    pub cells: f64,
    /// `ours`, `tuned` or `literal`; `stored` for a stored result from another machine.
    pub program: String,
    /// The median cost of `runs` runs; `None` for a stored result.
    pub usage: Option<Usage>,
    /// The number of runs.
    pub runs: usize,
    /// Whether the run reports that all increments converged.
    pub converged: bool,
    /// The total number of fixed-point iterations, and of Ipopt's iterations in them.
    pub iterations: [f64; 2],
    /// Seconds by the program's own clock (CPU time in FreeFEM, wall time in this library): rows;
    /// Ipopt with its linear solver; everything else.
    pub seconds: [f64; 3],
    /// Energy, displacement, reaction and pressure: relative differences from this library's.
    pub differences: Option<[f64; 4]>,
    /// CPU time, wall time and peak memory, divided by this library's.
    pub ratios: Option<[f64; 3]>,
}

impl Entry {
    /// The entry of a run with the result `outcome`.
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

    /// Records the differences from this library's run and the ratios of the costs.
    pub fn compare(&mut self, ours: &Entry, differences: [f64; 4]) {
        self.cells = ours.cells;
        self.differences = Some(differences);
        self.ratios = self.usage.zip(ours.usage).map(|(theirs, ours)| {
            let memory = theirs.peak as f64 / ours.peak as f64;
            [theirs.cpu / ours.cpu, theirs.wall / ours.wall, memory]
        });
    }
}

/// All results.
#[derive(Serialize)]
pub struct Report {
    /// The version of FreeFEM, if it ran.
    pub freefem: Option<String>,
    /// The version of Ipopt; both programs use it if they come from one system.
    pub ipopt: String,
    /// The linear solver and the BLAS of this library's runs.
    pub libraries: [Option<String>; 2],
    /// All runs.
    pub entries: Vec<Entry>,
    /// The errors and the scenes in which they occurred.
    pub failures: Vec<String>,
}

impl Report {
    /// Adds an entry and saves the report, since the next run may take long.
    pub fn add(&mut self, entry: Entry, folder: &Path) -> Result<(), Failure> {
        let (scene, size, program) = (&entry.scene, &entry.size, &entry.program);
        eprintln!("{scene} {size} {program}: done");
        self.entries.push(entry);
        self.save(folder)
    }

    /// The differences of every program from this library, and the cost of each.
    pub fn tables(&self) -> [Table; 2] {
        let mut results = Table::new(
            "results",
            "scene | size | cells | program | converged | fixed point | Ipopt | energy off | \
            displacement off | reaction off | pressure off"
                .split(" | "),
        );
        let mut costs = Table::new(
            "costs",
            "scene | size | cells | program | runs | wall s | CPU s | rows s | Ipopt s | rest s | \
            peak MB | CPU / ours | wall / ours | memory / ours"
                .split(" | "),
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

    /// The cost of the runs over the number of cells, one curve for each program and scene.
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

//! The raw data, as CSV and JSON.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde::Serialize;

use crate::Failure;
use crate::record::{Numbers, Record};
use crate::study::{Run, Study};

#[derive(Serialize)]
struct Data<'a> {
    environment: Vec<(&'a str, &'a str)>,
    runs: Vec<Row<'a>>,
}

#[derive(Serialize)]
struct Row<'a> {
    #[serde(flatten)]
    record: &'a Record,
    /// Those against the refined solution included.
    all_errors: &'a Numbers,
}

/// Writes `report.json` and `report.csv`.
pub fn save(
    folder: &Path,
    studies: &[Study<'_>],
    environment: &[(&str, String)],
) -> Result<(), Failure> {
    let runs = || studies.iter().flat_map(|study| &study.runs);
    let data = Data {
        environment: environment.iter().map(|(k, v)| (*k, v.as_str())).collect(),
        runs: runs()
            .map(|run| Row {
                record: run.record,
                all_errors: &run.errors,
            })
            .collect(),
    };
    fs::write(
        folder.join("report.json"),
        serde_json::to_vec_pretty(&data)?,
    )?;
    let names: BTreeSet<&String> = runs().flat_map(|run| run.errors.keys()).collect();
    let mut writer = csv::Writer::from_path(folder.join("report.csv"))?;
    let mut head: Vec<String> = COLUMNS.iter().map(|name| name.to_string()).collect();
    head.extend(names.iter().map(|name| format!("error of {name}")));
    writer.write_record(&head)?;
    for run in runs() {
        let mut cells = cells(run);
        let error = |name: &&String| run.errors.get(*name).map(f64::to_string);
        cells.extend(names.iter().map(|name| error(name).unwrap_or_default()));
        writer.write_record(&cells)?;
    }
    Ok(writer.flush()?)
}

const COLUMNS: [&str; 26] = [
    "family",
    "degree",
    "level",
    "mesh",
    "integration",
    "method",
    "fixed point",
    "TOLER",
    "gap times force",
    "status",
    "certificate",
    "h (UL)",
    "free dofs",
    "rows",
    "wall (s)",
    "CPU (s)",
    "peak memory (B)",
    "load steps",
    "cuts",
    "fixed-point iterations",
    "Ipopt iterations",
    "factorisations",
    "set-up (s)",
    "projection and rows (s)",
    "energy and derivatives (s)",
    "Ipopt and linear solver (s)",
];

fn cells(run: &Run<'_>) -> Vec<String> {
    let (case, result) = (run.case(), run.result());
    let cost = &result.cost;
    let optional = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
    let mut cells = vec![
        case.family.clone(),
        case.degree.to_string(),
        case.level.to_string(),
        case.mesh.map(|mesh| mesh.to_string()).unwrap_or_default(),
        format!("{:?}", case.points),
        format!("{:?}", case.method),
        format!("{:?}", case.variant),
        case.tolerance.to_string(),
        case.complementarity.to_string(),
        result.status.clone(),
        match result.certificate.is_empty() {
            true => "holds".into(),
            false => result.certificate.join("; "),
        },
        result.h.to_string(),
        result.dofs.to_string(),
        result.rows.to_string(),
        cost.wall.to_string(),
        optional(cost.cpu),
        optional(cost.memory.map(|bytes| bytes as f64)),
        cost.steps.to_string(),
        cost.cuts.to_string(),
        cost.fixed_point.to_string(),
        cost.iterations.to_string(),
        cost.factorizations.to_string(),
    ];
    let phases = cost.phases.entries();
    cells.extend(phases[..4].iter().map(|(_, seconds)| seconds.to_string()));
    cells
}

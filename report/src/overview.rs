//! The tables of the report, for the page and for Markdown alike.

use crate::families::{Bound, Kind};
use crate::study::{Run, Series, Study};
use ipopt_contact_scenes::tables::{Table, digits};

/// What had to be shown, and whether it was.
pub fn claims(studies: &[Study<'_>]) -> Table {
    let columns = ["family", "order", "quantity", "must be", "was", ""];
    let mut table = quiet("claims", &columns);
    for study in studies {
        for verdict in study.verdicts() {
            let claim = verdict.claim;
            let (bound, found) = match claim.bound {
                Bound::Order(least) => {
                    let found = verdict.found.map(|k| format!("order {k:.3}"));
                    (format!("order ≥ {least}"), found)
                }
                Bound::Finest(most) => {
                    let found = verdict.found.map(percent);
                    (format!("≤ {} at the smallest h", percent(most)), found)
                }
            };
            let title = study.family.quantity(claim.quantity).map(|q| q.title);
            table.push(vec![
                study.family.title.into(),
                format!("P{}", claim.degree),
                title.unwrap_or(claim.quantity).into(),
                bound,
                found.unwrap_or_else(|| "not measured".into()),
                if verdict.holds() {
                    "holds"
                } else {
                    "DOES NOT HOLD"
                }
                .into(),
            ]);
        }
    }
    table
}

/// A table whose rows are no progress.
fn quiet(name: &'static str, columns: &[&str]) -> Table {
    let mut table = Table::new(name, columns);
    table.quiet = true;
    table
}

fn percent(value: f64) -> String {
    format!("{:.3} %", 100.0 * value)
}

/// For each target and kind of quantity the cheapest setting.
pub fn advice(studies: &[Study<'_>]) -> Table {
    let columns = ["family", "error in", "1 %", "0.1 %", "0.01 %"];
    let mut table = quiet("advice", &columns);
    for study in studies {
        let kinds = [Kind::Pressure, Kind::Force, Kind::Displacement];
        for (kind, word) in kinds.into_iter().zip(["pressure", "force", "displacement"]) {
            let Some(quantity) = study.family.quantities.iter().find(|q| q.kind == kind) else {
                continue;
            };
            let name = match quantity.title.contains(word) {
                true => quantity.title.to_string(),
                false => format!("{word}: {}", quantity.title),
            };
            let mut row = vec![study.family.title.to_string(), name];
            let targets = [1e-2, 1e-3, 1e-4].map(|most| study.cheapest(kind, most));
            let cell = |run: &Run| {
                let confirmed = study.is_confirmed(run, quantity.name);
                setting_and_cost(run) + if confirmed { "" } else { " †" }
            };
            row.extend(targets.map(|run| run.map_or("not reached".into(), cell)));
            table.push(row);
        }
    }
    table
}

fn setting_and_cost(run: &Run<'_>) -> String {
    let (case, result) = (run.case(), run.result());
    let mark = if result.certificate.is_empty() {
        ""
    } else {
        " *"
    };
    format!(
        "{}, level {}: {:.2} s, {} dofs{mark}",
        case.setting(),
        case.level,
        result.cost.wall,
        result.dofs
    )
}

/// The orders that were observed, of every series with a fit.
pub fn orders(study: &Study<'_>) -> Table {
    let columns = [
        "settings",
        "quantity",
        "order",
        "theory",
        "fitted to h (UL)",
        "between neighbours",
        "finest error",
    ];
    let mut table = quiet("orders", &columns);
    for series in study.series() {
        for quantity in study.family.quantities {
            let Some(fit) = series.fit(quantity.name) else {
                continue;
            };
            let theory = quantity.orders[series.setting.case().degree - 1];
            let [low, high] = fit.local;
            let bends = if fit.is_asymptotic() { "" } else { ", bends" };
            let finest = finest(&series, quantity.name);
            table.push(vec![
                series.setting.to_string(),
                quantity.title.into(),
                format!("{:.2}", fit.order),
                theory.map_or("-".into(), |k| format!("{k}")),
                format!(
                    "{:.3e} to {:.3e}, {} meshes",
                    fit.h[0], fit.h[1], fit.points
                ),
                format!("{low:.2} to {high:.2}{bends}"),
                digits(finest),
            ]);
        }
    }
    table
}

fn finest(series: &Series<'_>, quantity: &str) -> Option<f64> {
    let last = series.runs.iter().rev();
    last.filter_map(|run| run.errors.get(quantity).copied())
        .next()
}

/// Every run, with its errors and what it cost.
pub fn runs(study: &Study<'_>) -> Table {
    let mut columns = vec!["settings", "level", "dofs"];
    columns.extend(study.family.quantities.iter().map(|q| q.title));
    columns.extend([
        "wall (s)",
        "CPU (s)",
        "fixed point",
        "Ipopt",
        "factorisations",
        "memory (MB)",
        "certificate",
    ]);
    let mut table = quiet("runs", &columns);
    for series in study.series() {
        for run in &series.runs {
            table.push(row(study, run));
        }
    }
    table
}

fn row(study: &Study<'_>, run: &Run<'_>) -> Vec<String> {
    let (case, result) = (run.case(), run.result());
    let cost = &result.cost;
    let mut row = vec![
        case.setting().to_string(),
        case.level.to_string(),
        result.dofs.to_string(),
    ];
    let quantities = study.family.quantities.iter();
    row.extend(quantities.map(|q| digits(run.errors.get(q.name).copied())));
    let certificate = match (result.converged(), result.certificate.is_empty()) {
        (false, _) => result.status.clone(),
        (true, true) => "holds".into(),
        (true, false) => result.certificate.join("; "),
    };
    row.extend([
        format!("{:.2}", cost.wall),
        cost.cpu.map_or("-".into(), |s| format!("{s:.2}")),
        cost.fixed_point.to_string(),
        cost.iterations.to_string(),
        cost.factorizations.to_string(),
        cost.memory
            .map_or("-".into(), |b| format!("{:.0}", b as f64 / 1e6)),
        certificate,
    ]);
    row
}

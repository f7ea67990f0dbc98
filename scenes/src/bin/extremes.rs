//! Runs the scenes at the limits, each in a process of its own, and writes what came of them.
//!
//! ```text
//! cargo run --release -p ipopt-contact-scenes --bin extremes
//! ```
//!
//! `extremes.json` has one entry a case; `extremes.md` a table by class, the false claims, and what did not solve. The
//! exit code is 1 if the library claims a wrong result to be right.
#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use clap::Parser;
use contact_fem::output::record::exit;
use ipopt_contact_scenes::Failure;
use ipopt_contact_scenes::cli::Solver;
use ipopt_contact_scenes::extremes::{self, Case, Entry};
use ipopt_contact_scenes::files;
use ipopt_contact_scenes::tables::Table;

/// Scenes at the limits, with their truths and their benign twins
#[derive(Parser, Debug)]
struct Arguments {
    /// The folder for the results
    #[arg(long, default_value = "out/extremes")]
    out: PathBuf,
    /// A small selection, within a minute
    #[arg(long)]
    quick: bool,
    /// Leave out the elastic discs on fine meshes
    #[arg(long)]
    coarse: bool,
    /// Only cases whose name contains this
    #[arg(long, default_value = "")]
    filter: String,
    /// How a load increment is solved
    #[arg(long, value_enum, default_value_t = Solver::Automatic)]
    solver: Solver,
    /// Seconds after which a case is given up
    #[arg(long, default_value_t = 120)]
    limit: u64,
    /// Write the cases as files for other programs into this folder, and solve none
    #[arg(long)]
    export: Option<PathBuf>,
    /// Print how the runs in this file compare with the truths, by program and class, and solve none
    #[arg(long)]
    judge: Option<PathBuf>,
    /// Run one case in this process and print its entry
    #[arg(long, hide = true)]
    only: Option<String>,
}

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let mut cases = extremes::all();
    if let Some(name) = &arguments.only {
        let case = cases.iter().find(|case| case.name == *name);
        let case = case.ok_or_else(|| format!("there is no case `{name}`"))?;
        println!("{}", serde_json::to_string(&case.run(arguments.solver))?);
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(file) = &arguments.judge {
        let runs: Vec<extremes::Foreign> = serde_json::from_str(&files::read(file)?)?;
        print!("{}", extremes::judged(&runs)?);
        return Ok(ExitCode::SUCCESS);
    }
    let is_wanted = |case: &Case| {
        let is_left_out = (arguments.quick && !case.quick) || (arguments.coarse && case.fine);
        case.name.contains(&arguments.filter) && !is_left_out
    };
    cases.retain(is_wanted);
    if cases.is_empty() {
        return Err(format!("no case has `{}` in its name", arguments.filter).into());
    }
    if let Some(folder) = &arguments.export {
        return export(&cases, folder);
    }
    files::make_folder(&arguments.out)?;
    let mut entries = Vec::new();
    for (k, case) in cases.iter().enumerate() {
        let entry = in_a_child(case, arguments.solver, Duration::from_secs(arguments.limit))?;
        let mark = match (entry.is_a_false_claim(), entry.truth_ok) {
            (true, _) => "FALSE CLAIM",
            (_, true) => "right",
            _ => "told",
        };
        let (outcome, seconds) = (&entry.outcome, entry.seconds);
        println!(
            "{}/{} {}: {outcome}, {mark}, {seconds:.1} s",
            k + 1,
            cases.len(),
            case.name
        );
        entries.push(entry);
        let json = serde_json::to_string_pretty(&entries)?;
        files::write(arguments.out.join("extremes.json"), json)?;
    }
    let page = page(&entries);
    files::write(arguments.out.join("extremes.md"), &page)?;
    println!("\n{page}");
    let false_claims = entries.iter().filter(|entry| entry.is_a_false_claim());
    Ok(match false_claims.count() {
        0 => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    })
}

/// Writes all cases that other programs can read.
fn export(cases: &[Case], folder: &Path) -> Result<ExitCode, Failure> {
    files::make_folder(folder)?;
    let mut count = 0;
    for (k, case) in cases.iter().enumerate() {
        let exchanged = case.exchanged();
        let exchanged = exchanged.map_err(|error| format!("case `{}`: {error}", case.name))?;
        if let Some(case) = exchanged {
            count += 1;
            files::write(folder.join(format!("{k:03}.json")), case.to_string())?;
        }
    }
    println!(
        "{count} of {} cases are in {}",
        cases.len(),
        folder.display()
    );
    Ok(ExitCode::SUCCESS)
}

fn in_a_child(case: &Case, solver: Solver, limit: Duration) -> Result<Entry, Failure> {
    let clock = Instant::now();
    let mut child = Command::new(std::env::current_exe()?)
        .args(["--only", &case.name, "--solver", &solver.to_string()])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()?;
    let given_up = |outcome: &str| Entry {
        name: case.name.clone(),
        class: case.class.to_string(),
        outcome: outcome.to_string(),
        certificate: false,
        truth_ok: false,
        reason: String::new(),
        factorisations: 0,
        iterations: 0,
        reactions: Vec::new(),
        twin: case.twin.clone(),
        seconds: clock.elapsed().as_secs_f64(),
    };
    while child.try_wait()?.is_none() {
        if clock.elapsed() > limit {
            child.kill()?;
            child.wait()?;
            return Ok(given_up("killed"));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output()?;
    match serde_json::from_slice(&output.stdout) {
        Ok(entry) => Ok(entry),
        Err(_) => Ok(given_up("crashed")),
    }
}

/// The table by class, and the cases that are not right.
fn page(entries: &[Entry]) -> String {
    let mut classes: BTreeMap<&str, Vec<&Entry>> = BTreeMap::new();
    for entry in entries {
        classes.entry(&entry.class).or_default().push(entry);
    }
    let columns = [
        "class",
        "cases",
        "right",
        "told",
        "false claims",
        "factorisations / twin",
    ];
    let mut table = Table::new("extremes", columns);
    for (class, entries) in &classes {
        let count = |is: &dyn Fn(&Entry) -> bool| entries.iter().filter(|e| is(e)).count();
        let right = count(&|e| e.truth_ok);
        let wrong = count(&|e| e.is_a_false_claim());
        table.push(vec![
            class.to_string(),
            entries.len().to_string(),
            right.to_string(),
            (entries.len() - right - wrong).to_string(),
            wrong.to_string(),
            ratios(entries, &classes),
        ]);
    }
    let mut page = table.markdown();
    for (title, is) in [
        (
            "False claims",
            (|e: &Entry| e.is_a_false_claim()) as fn(&Entry) -> bool,
        ),
        ("Not solved, or not certified, and told", |e| {
            !e.truth_ok && !e.is_a_false_claim()
        }),
        ("Right, with a reason", |e| {
            e.truth_ok && !e.reason.is_empty()
        }),
    ] {
        page.push_str(&format!("\n{title}:\n\n"));
        for entry in entries.iter().filter(|entry| is(entry)) {
            page.push_str(&format!(
                "- {}: {}. {}\n",
                entry.name, entry.outcome, entry.reason
            ));
        }
    }
    page
}

/// The median and the largest ratio of factorisations to those of the benign twin.
fn ratios(entries: &[&Entry], classes: &BTreeMap<&str, Vec<&Entry>>) -> String {
    let named = |name: &String| classes.values().flatten().find(|entry| entry.name == *name);
    let ratio = |entry: &&Entry| {
        let twin = entry.twin.as_ref().and_then(named)?;
        let is_solved = entry.outcome == "complete" && twin.factorisations > 0;
        is_solved.then(|| entry.factorisations as f64 / twin.factorisations as f64)
    };
    let mut ratios: Vec<f64> = entries.iter().filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    match ratios.last() {
        Some(largest) => format!("{:.1}, at most {largest:.1}", ratios[ratios.len() / 2]),
        None => "-".to_string(),
    }
}

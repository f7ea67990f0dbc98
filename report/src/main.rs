//! Error against run time: runs the benchmark families and writes what they show.
//!
//! ```text
//! cargo run --release -p ipopt-contact-report              # everything
//! cargo run --release -p ipopt-contact-report -- --quick   # what continuous integration checks
//! ```
//!
//! Every run has a process of its own, one at a time. What is done is appended to `runs.jsonl` at once, so that an
//! interrupted report goes on where it stopped.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the symbols of the field

mod campaign;
mod case;
mod data;
mod environment;
mod exact;
mod families;
mod fit;
mod freefem;
mod markdown;
mod measure;
mod norms;
mod overview;
mod page;
mod pareto;
mod peers;
mod processor;
mod record;
mod refined;
mod revision;
mod store;
mod study;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;

use crate::campaign::Campaign;
use crate::families::{Family, Scope};
use crate::page::Page;
use crate::page::site::{self, Sheet};
use crate::study::Study;

/// What anything here may fail with, for `main` to print.
type Failure = Box<dyn std::error::Error>;

/// Measures error against run time and writes a page, tables and data
#[derive(Parser, Debug)]
struct Arguments {
    /// Few and coarse meshes, for continuous integration
    #[arg(long)]
    quick: bool,
    /// Only families whose name contains this
    #[arg(long, value_name = "NAME", default_value = "")]
    only: String,
    /// Folder for all files [default: out/report, or out/report-quick]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Seconds after which a run is given up, and the page says so
    #[arg(long, value_name = "SECONDS", default_value_t = 600)]
    limit: u64,
    /// Compute and store the errors of what report/peers/campaign.py left here
    #[arg(long, value_name = "DIR")]
    peers: Option<PathBuf>,
    /// Do one run in this process: its settings as JSON, and where the refined solution is kept
    #[arg(long, hide = true, num_args = 2)]
    run: Option<Vec<String>>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = match (arguments.run.as_deref(), &arguments.peers) {
        (Some([case, place]), _) => campaign::child(case, place),
        (_, Some(folder)) => peers_of(folder),
        _ => report(&arguments),
    };
    result.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        ExitCode::from(2)
    })
}

/// Where the results of other programs are kept.
fn peers_file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("peers/results.json")
}

fn peers_of(folder: &Path) -> Result<ExitCode, Failure> {
    let environment = environment::environment(&revision::revision()?);
    let stored = peers::store(folder, &environment, &peers_file())?;
    for scene in &peers::SCENES {
        println!("{}", scene.title);
        for target in scene.targets() {
            println!("  {}", stored.sentence(scene, target));
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn report(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let scope = match arguments.quick {
        true => Scope::Quick,
        false => Scope::Full,
    };
    let default = PathBuf::from("out").join(scope.pick("report-quick", "report"));
    let folder = arguments.out.clone().unwrap_or(default);
    let mut families = families::all();
    families.retain(|family| family.name.contains(&arguments.only));
    let campaign = Campaign::new(&folder, scope, arguments.limit)?;
    let records = campaign.run(&families)?;
    let refined = |family: &Family| family.refined.map(|case| case(scope));
    let studies: Vec<Study> = families
        .iter()
        .map(|family| Study::new(family, &records, refined(family).as_ref()))
        .collect();
    let environment = environment::environment(campaign.revision());
    write(&folder, &studies, &environment)?;
    let verdicts = studies.iter().flat_map(Study::verdicts);
    let broken = verdicts.filter(|verdict| !verdict.holds()).count();
    print!("\n{}", overview::claims(&studies).markdown());
    println!(
        "{} runs: {}",
        records.len(),
        folder.join("index.html").display()
    );
    Ok(match broken {
        0 => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    })
}

/// The pages, the same in Markdown, and the data. Pages with links that lead nowhere, or with empty plots, are an error.
fn write(
    folder: &Path,
    studies: &[Study<'_>],
    environment: &[(&'static str, String)],
) -> Result<(), Failure> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../freefem/reference");
    let (freefem, freefem_remarks) = freefem::load(&source);
    let peers = peers::load(&peers_file())?;
    let page = Page {
        peers: &peers,
        studies,
        environment,
        freefem: &freefem,
        freefem_remarks: &freefem_remarks,
    };
    let mut sheets = page.sheets();
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    for (name, question) in site::DOCUMENTS {
        let text = fs::read_to_string(docs.join(format!("{name}.md")))?;
        sheets.push(Sheet {
            name: name.into(),
            question: question.into(),
            body: site::document(&text),
        });
    }
    let files = site::files(&sheets);
    for (name, html) in &files {
        fs::write(folder.join(name), html)?;
    }
    fs::write(folder.join("report.md"), markdown::markdown(&page))?;
    data::save(folder, studies, environment)?;
    match site::broken(&files)[..] {
        [] => Ok(()),
        ref broken => Err(broken.join("\n").into()),
    }
}

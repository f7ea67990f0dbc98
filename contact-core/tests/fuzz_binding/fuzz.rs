//! Solves random problems with random options and faults in their functions for a while, in other processes: nothing
//! may crash, end the process, hang, panic unasked, or come back as solved where the functions say otherwise.
//!
//! `make fuzz-binding SECONDS=60 SEED=1`. Arguments: seconds and the first seed; or `case`, "default" or "random" for
//! the options, and a seed, to see one case again in this process.

mod case;
mod hunt;
mod problem;

use std::{
    env,
    error::Error,
    process::{Command, ExitCode},
    time::{Duration, Instant},
};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let number = |place: usize, otherwise: u64| match arguments.get(place) {
        Some(text) => text.parse(),
        None => Ok(otherwise),
    };
    let random_options = arguments.get(1).is_some_and(|options| options == "random");
    match arguments.first().map(String::as_str) {
        Some("obey") => {
            hunt::obey(random_options, number(2, 0)?..number(3, 0)?, false);
            return Ok(ExitCode::SUCCESS);
        }
        Some("case") => {
            let seed = number(2, 0)?;
            hunt::obey(random_options, seed..seed + 1, true);
            return Ok(ExitCode::SUCCESS);
        }
        _ => {}
    }
    let (seconds, first) = (number(0, 60)?, number(1, 1)?);
    let program = env::current_exe()?;
    let folder = env::temp_dir().join(format!("fuzz-binding-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let mut findings = 0;
    for options in ["default", "random"] {
        let until = Instant::now() + Duration::from_secs(seconds) / 2;
        let command = |seeds: std::ops::Range<u64>| {
            let mut command = Command::new(&program);
            let (from, to) = (seeds.start.to_string(), seeds.end.to_string());
            // options may name files
            command
                .args(["obey", options, &from, &to])
                .current_dir(&folder);
            command
        };
        let tell = |found: &hunt::Found| println!("case {options} {}: {}", found.seed, found.what);
        let (cases, found) = hunt::hunt(first..u64::MAX, Some(until), command, tell);
        println!(
            "{cases} cases with {options} options: {} findings",
            found.len()
        );
        findings += found.len();
    }
    std::fs::remove_dir_all(&folder)?;
    Ok(ExitCode::from(u8::from(findings > 0)))
}

//! The machine and the programs that numbers belong to.

use std::fs;
use std::process::Command;

/// Names and values, for the head of the page.
pub fn environment(revision: &str) -> Vec<(&'static str, String)> {
    let versions = ipopt_contact::versions();
    let known = |value: Option<String>| value.unwrap_or_else(|| "unknown".into());
    let cores = std::thread::available_parallelism().map(|n| n.to_string());
    let blas = versions.blas.as_ref().map(ToString::to_string);
    let load = fs::read_to_string("/proc/loadavg").ok();
    let load = load.and_then(|text| text.split_whitespace().next().map(str::to_string));
    vec![
        ("processor", known(field("/proc/cpuinfo", "model name"))),
        ("cores", known(cores.ok())),
        ("memory", known(field("/proc/meminfo", "MemTotal"))),
        ("system", known(output("uname", &["-srm"]))),
        (
            "date",
            known(output("date", &["-u", "+%Y-%m-%d %H:%M UTC"])),
        ),
        ("load at the end", known(load)),
        (
            "ipopt-contact",
            format!(
                "{} ({}, {})",
                versions.ipopt_contact, versions.rustc, versions.profile
            ),
        ),
        ("Ipopt", versions.ipopt.to_string()),
        ("linear solver", known(versions.linear_solver.clone())),
        ("BLAS", format!("{}, one thread", known(blas))),
        ("revision", revision.to_string()),
    ]
}

/// What follows `name:` in a file of the system.
fn field(path: &str, name: &str) -> Option<String> {
    let text = fs::read_to_string(path).ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    Some(line.split_once(':')?.1.trim().to_string())
}

/// The output of a program, if it is there.
fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_string())
}

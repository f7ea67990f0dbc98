//! Runs cases in other processes, so that a crash, an exit or a hang is a finding with its seed.

use std::{
    io::{BufRead, BufReader, Write},
    ops::Range,
    panic,
    process::{Command, Stdio},
    sync::mpsc::{RecvTimeoutError, channel},
    thread,
    time::{Duration, Instant},
};

use super::case::{Intended, Maker};

/// No case takes longer.
const PATIENCE: Duration = Duration::from_secs(20);
/// The cases of one process.
const BATCH: u64 = 500;

/// What went wrong, and with which seed.
pub struct Found {
    pub seed: u64,
    pub what: String,
}

/// In the other process: runs the cases of these seeds and says so.
pub fn obey(random_options: bool, seeds: Range<u64>, tell: bool) {
    let usual = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        if !info.payload().is::<Intended>() {
            usual(info);
        }
    }));
    let maker = Maker::new(random_options);
    // not `println!`, which a test captures
    let say = |text: String| writeln!(std::io::stdout(), "{text}").expect("someone listens");
    for seed in seeds {
        say(format!("\ncase {seed}"));
        if let Err(what) = maker.run(seed, tell) {
            say(format!("finding {seed} {}", what.replace('\n', " ")));
        }
    }
    say("\nall done".into());
}

/// Runs cases until the seeds or the time are at an end; `command` starts a process that obeys. Returns how many ran.
pub fn hunt(
    seeds: Range<u64>,
    until: Option<Instant>,
    command: impl Fn(Range<u64>) -> Command,
    mut tell: impl FnMut(&Found),
) -> (u64, Vec<Found>) {
    let (mut next, mut found, mut told) = (seeds.start, Vec::new(), 0);
    while next < seeds.end && until.is_none_or(|until| Instant::now() < until) {
        let end = (next + BATCH).min(seeds.end);
        let (reached, finding) = batch(command(next..end), next..end, &mut found);
        next = reached;
        if let Some(what) = finding {
            found.push(Found { seed: next, what });
            next += 1;
        }
        found[told..].iter().for_each(&mut tell);
        told = found.len();
    }
    (next - seeds.start, found)
}

/// Runs one process to its end: the case at which it ended, and how, if not well.
fn batch(mut command: Command, seeds: Range<u64>, found: &mut Vec<Found>) -> (u64, Option<String>) {
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("a process");
    let output = BufReader::new(child.stdout.take().expect("piped"));
    let (sender, lines) = channel();
    thread::spawn(move || {
        for line in output.lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    let (mut current, mut done) = (seeds.start, false);
    let hangs = loop {
        match lines.recv_timeout(PATIENCE) {
            Ok(line) => {
                if let Some(seed) = line.strip_prefix("case ") {
                    current = seed.parse().unwrap_or(current);
                } else if let Some(what) = line.strip_prefix("finding ") {
                    let what = what
                        .split_once(' ')
                        .map_or(what, |(_, what)| what)
                        .to_owned();
                    found.push(Found {
                        seed: current,
                        what,
                    });
                } else if line == "all done" {
                    done = true;
                }
            }
            Err(RecvTimeoutError::Timeout) => break true,
            Err(RecvTimeoutError::Disconnected) => break false,
        }
    };
    if hangs {
        child.kill().expect("a child");
    }
    let status = child.wait().expect("a child");
    match (hangs, done && status.success()) {
        (true, _) => (current, Some(format!("hangs for {} s", PATIENCE.as_secs()))),
        (false, true) => (seeds.end, None),
        (false, false) => (current, Some(format!("ends the process: {status}"))),
    }
}

//! Solves random small scenes, sound ones and wrong ones, for a while: nothing may panic or hang, no result that is complete
//! may have values that are no numbers, and where the certificate holds, the forces on each body must be in balance by a
//! sum of their own.
//!
//! `make fuzz-scenes SECONDS=60 SEED=1`, or with arguments: seconds, seed and, to show one case again, its number.
#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use ipopt_contact_scenes::Failure;
use ipopt_contact_scenes::random::case;

/// When a case is said to hang: a budget is looked at between steps only.
const PATIENCE: Duration = Duration::from_secs(60);

fn main() -> Result<ExitCode, Failure> {
    let mut arguments = std::env::args().skip(1);
    let seconds = arguments.next().map_or(Ok(60), |s| s.parse())?;
    let seed = arguments.next().map_or(Ok(1), |s| s.parse())?;
    if let Some(number) = arguments.next() {
        println!("{:?}", case(seed, number.parse()?));
        return Ok(ExitCode::SUCCESS);
    }
    println!("{seconds} s, seed {seed}");
    std::panic::set_hook(Box::new(|_| {}));
    let number = Arc::new(AtomicU64::new(0));
    let since = Arc::new(Mutex::new(Instant::now()));
    let watched = (Arc::clone(&number), Arc::clone(&since));
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let began = watched
                .1
                .lock()
                .map_or_else(|e| *e.into_inner(), |began| *began);
            if began.elapsed() > PATIENCE {
                println!("case {} hangs", watched.0.load(Ordering::Relaxed));
                std::process::exit(1);
            }
        }
    });
    let end = Instant::now() + Duration::from_secs(seconds);
    let (mut outcomes, mut findings) = (BTreeMap::<String, (u64, Duration)>::new(), 0);
    while Instant::now() < end && findings < 100 {
        let now = number.fetch_add(1, Ordering::Relaxed) + 1;
        let began = Instant::now();
        if let Ok(mut since) = since.lock() {
            *since = began;
        }
        let outcome = case(seed, now).unwrap_or_else(|what| {
            println!("case {now}: {what}");
            findings += 1;
            "finding".to_string()
        });
        let (count, taken) = outcomes.entry(outcome).or_default();
        *count += 1;
        *taken += began.elapsed();
    }
    for (outcome, (count, taken)) in outcomes {
        println!("{count:8}  {:8.1} s  {outcome}", taken.as_secs_f64());
    }
    println!(
        "{} cases, {findings} findings",
        number.load(Ordering::Relaxed)
    );
    Ok(ExitCode::from(u8::from(findings > 0)))
}

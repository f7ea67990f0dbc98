//! A few hundred cases of the fuzzer (`make fuzz-binding`), the same ones each time.
#![cfg(feature = "ipopt")]

mod case;
mod hunt;
mod problem;

use std::{env, ops::Range, process::Command};

/// In the processes that hunt: the options, the first seed and the last.
const ORDER: &str = "CONTACT_CORE_FUZZ_ORDER";

fn hunt(options: &str, seeds: Range<u64>) {
    let folder = env::temp_dir().join(format!("fuzz-binding-{}-{options}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let program = env::current_exe().expect("a test program");
    let command = |seeds: Range<u64>| {
        let mut command = Command::new(&program);
        let order = format!("{options} {} {}", seeds.start, seeds.end);
        // options may name files
        command.current_dir(&folder).env(ORDER, order);
        command.args(["obey", "--exact", "--nocapture"]);
        command
    };
    let (cases, found) = hunt::hunt(seeds.clone(), None, command, |_| {});
    std::fs::remove_dir_all(&folder).expect("a folder");
    let found: Vec<String> = found
        .iter()
        .map(|found| format!("{} {}", found.seed, found.what))
        .collect();
    assert!(found.is_empty(), "{options} options: {found:#?}");
    assert_eq!(cases, seeds.end - seeds.start);
}

#[test]
fn default_options() {
    hunt("default", 1..151);
}

#[test]
fn random_options() {
    hunt("random", 1..151);
}

/// What the other processes run; without an order there is nothing to do.
#[test]
fn obey() {
    let Ok(order) = env::var(ORDER) else { return };
    let words: Vec<&str> = order.split(' ').collect();
    let seed = |place: usize| words[place].parse().expect("a seed");
    hunt::obey(words[0] == "random", seed(1)..seed(2), false);
}

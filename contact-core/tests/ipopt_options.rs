//! The table of options against the Ipopt that is installed, and the presets.
#![cfg(feature = "ipopt")]

mod common;

use common::*;
use contact_core::ipopt::*;

fn set(name: &str, value: impl Into<OptionValue>) -> Result<Solver, Error> {
    Solver::new(hs071_structure(), &Options::new().with(name, value))
}

#[test]
fn every_option_of_the_table_has_ipopts_type_and_default() {
    let solver = hs071_solver();
    for option in KNOWN_OPTIONS {
        let name = option.name;
        let default = option.default_in(VERSION);
        if option.is_in(VERSION) {
            let found = solver.ipopt_default(name);
            // An Ipopt that is linked with HSL prefers MA27.
            if !(name == "linear_solver" && found == Some("ma27".into())) {
                assert_eq!(found, Some(default.clone()), "{name}: Ipopt's and ours");
            }
            assert!(set(name, default).is_ok(), "{name} takes its default");
        } else {
            assert_eq!(solver.ipopt_default(name), None, "{name}");
            let error = set(name, default).unwrap_err().to_string();
            let since = option.since.unwrap();
            assert!(
                error.contains(name) && error.contains(&format!("since {since}")),
                "{error}"
            );
        }
    }
    assert_eq!(
        KNOWN_OPTIONS.iter().filter(|o| o.is_in((3, 11, 9))).count() + 4,
        KNOWN_OPTIONS.len(),
        "four came after 3.11"
    );
    assert_eq!(solver.ipopt_default("no_such_option"), None);
}

/// The words in a message such as `… it takes one of "a" "b"`.
fn listed(error: &Error) -> Vec<String> {
    let Error::Option(OptionError::Invalid { expected, .. }) = error else {
        panic!("{error}");
    };
    let list = expected.split(';').next().unwrap_or_default();
    list.split('"')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_word_is_accepted_where_ipopt_has_it_and_none_is_missing() {
    for option in KNOWN_OPTIONS.iter().filter(|o| !o.words.is_empty()) {
        let name = option.name;
        if !option.is_in(VERSION) {
            continue;
        }
        let registered = listed(&set(name, "no such word").unwrap_err());
        for word in &registered {
            // A solver of the caller's own cannot be handed over from Rust.
            let known = option.words.iter().any(|w| w.text == word) || word == "custom";
            assert!(known, "{name}: {word} has no variant");
        }
        for word in option.words {
            let outcome = set(name, word.text);
            assert_eq!(
                outcome.is_ok(),
                registered.iter().any(|r| r == word.text),
                "{name}: {outcome:?}"
            );
            match (word.available, outcome) {
                (Available::Always, outcome) => assert!(outcome.is_ok(), "{name}: {outcome:?}"),
                (Available::Since(since), Err(error)) => assert!(
                    VERSION < (3, 14, 0) && error.to_string().contains(&format!("since {since}")),
                    "{error}"
                ),
                (Available::With(with), Err(error)) => assert!(
                    error.to_string().contains(&format!("built with {with}")),
                    "{error}"
                ),
                _ => {}
            }
        }
    }
}

#[test]
fn setters_do_what_names_do() {
    let typed = Options::new()
        .tol(1e-9)
        .max_iter(7)
        .mu_strategy(MuStrategy::Adaptive)
        .linear_solver(LinearSolver::Mumps)
        .sb(true)
        .tol(1e-10);
    let named = Options::new()
        .with("tol", 1e-10)
        .with("max_iter", 7)
        .with("mu_strategy", "adaptive")
        .with("linear_solver", "mumps")
        .with("sb", "yes");
    assert_eq!(typed, named);
    let solution = Solver::new(hs071_structure(), &typed)
        .unwrap()
        .solve(&mut Hs071, &Start::at(&HS071_START))
        .unwrap();
    assert_eq!(solution.status, Status::IterationLimit);
    assert_eq!(solution.statistics.iterations, 7);
}

#[test]
fn a_value_out_of_range_names_option_and_range() {
    let error = Solver::new(hs071_structure(), &Options::new().tau_min(1.5)).unwrap_err();
    assert!(
        matches!(&error, Error::Option(OptionError::Invalid { name, value, .. })
            if name == "tau_min" && *value == 1.5.into())
    );
    assert!(
        error.to_string().contains("a number > 0 and < 1"),
        "{error}"
    );
}

//! The table of options against the Ipopt that is installed, and the presets.
#![cfg(feature = "ipopt")]

use contact_core::{ipopt::*, nlp::Structure};
use problems::*;

fn set(name: &str, value: impl Into<OptionValue>) -> Result<Solver, Error> {
    Solver::new(hs071_structure(), &Options::new().with(name, value))
}

#[test]
fn every_option_of_the_table_has_ipopts_type_and_default() {
    let solver = hs071_solver!();
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

/// What is registered and not in the table would be refused without a reason of its own.
#[test]
fn every_option_of_this_ipopt_was_tried() {
    let solver = hs071_solver!();
    let names = solver.ipopt_options();
    assert!(names.len() >= 200, "{names:?}");
    for name in names {
        let default = solver.ipopt_default(&name).expect("a default");
        if let Err(error) = set(&name, default) {
            let told = error.to_string();
            assert!(!told.contains("nothing is known"), "{told}");
        }
    }
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

#[track_caller]
fn refused(name: &str, value: impl Into<OptionValue>) -> OptionError {
    match set(name, value) {
        Err(Error::Option(error)) => {
            assert!(error.to_string().contains(name), "{error}");
            error
        }
        other => panic!("{name}: {other:?}"),
    }
}

/// Up to 1e30; beyond, Ipopt would overflow, crash, or iterate without end and without a look at its limits.
#[test]
fn numbers_are_finite_and_of_a_reasonable_size() {
    let ends = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 1e308, -1e308];
    let open = ["max_cpu_time", "max_wall_time", "nlp_lower_bound_inf"];
    let numbers = KNOWN_OPTIONS
        .iter()
        .filter(|option| matches!(option.default, DefaultValue::Number(_)))
        .filter(|option| option.is_in(VERSION));
    for name in numbers.map(|option| option.name) {
        for end in ends {
            if !open.contains(&name) && name != "nlp_upper_bound_inf" {
                let error = refused(name, end);
                assert!(matches!(error, OptionError::Invalid { .. }), "{error}");
            }
        }
        for value in [1e30, 1e-300, -1e30] {
            for structure in [hs071_structure(), without_hessian()] {
                let options = Options::new().max_iter(5).with(name, value);
                if let Ok(mut solver) = Solver::new(structure, &options) {
                    solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
                }
            }
        }
    }
    let error = refused("tol", f64::INFINITY).to_string();
    assert!(
        error.contains("a number > 0, from -1e30 to 1e30"),
        "{error}"
    );
    // By name and without a setter, too.
    refused("resto.bound_push", 1e308);
    refused("warm_start_target_mu", f64::INFINITY);
}

#[test]
fn infinite_numbers_stand_for_no_limit_and_no_bound() {
    let mut options = Options::new()
        .max_cpu_time(f64::INFINITY)
        .nlp_lower_bound_inf(f64::NEG_INFINITY)
        .nlp_upper_bound_inf(f64::INFINITY);
    if KnownOption::named("max_wall_time").unwrap().is_in(VERSION) {
        options = options.max_wall_time(f64::INFINITY);
    }
    let mut solver = Solver::new(hs071_structure(), &options).unwrap();
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert_close(&solution.x, &HS071_X, 1e-6);
    for (name, value) in [
        ("max_cpu_time", f64::NAN),
        ("max_cpu_time", f64::NEG_INFINITY),
        ("nlp_lower_bound_inf", f64::INFINITY),
        ("nlp_upper_bound_inf", f64::NEG_INFINITY),
    ] {
        refused(name, value);
    }
}

#[test]
fn an_objective_is_not_scaled_to_nothing() {
    for zero in [OptionValue::from(0), 0.0.into(), (-0.0).into()] {
        let error = refused("obj_scaling_factor", zero);
        assert!(error.to_string().contains("but not 0"), "{error}");
    }
    // Unscaled, the multipliers overflow: none is better than ∞.
    let options = Options::new().obj_scaling_factor(1e-310).max_iter(3);
    let mut solver = Solver::new(hs071_structure(), &options).unwrap();
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.multipliers, None, "{solution:?}");
}

fn without_hessian() -> Structure {
    let s = hs071_structure();
    let bounds = (s.variable_bounds().clone(), s.constraint_bounds().clone());
    Structure::new(bounds.0, bounds.1, s.jacobian().clone(), None).unwrap()
}

#[test]
fn words_are_taken_in_any_case() {
    let options = Options::new()
        .with("mu_strategy", "ADAPTIVE")
        .with("resto.mu_strategy", "Monotone")
        .with("output_file", "Some.Name");
    assert_eq!(options.get("mu_strategy"), Some(&"adaptive".into()));
    assert_eq!(options.get("resto.mu_strategy"), Some(&"monotone".into()));
    assert_eq!(options.get("output_file"), Some(&"Some.Name".into()));

    let solve = |name: &str, word: &str| {
        let mut solver = set(name, word).unwrap();
        solver.solve(&mut Hs071, &Start::at(&HS071_START))
    };
    for yes in ["yes", "Yes", "YES"] {
        let outcome = solve("warm_start_init_point", yes);
        assert_eq!(outcome, Err(Error::MissingMultipliers), "{yes}");
    }
    let none = solve("derivative_test", "NONE").unwrap();
    assert_eq!(none.derivative_check, None);
    let first = solve("derivative_test", "First-Order").unwrap();
    assert!(first.derivative_check.unwrap().is_clean());
    let scaling = Scaling {
        objective: 2.0,
        variables: None,
        constraints: None,
    };
    let mut scaled = set("nlp_scaling_method", "User-Scaling").unwrap();
    scaled.set_scaling(&scaling).unwrap();
    let options = Options::new().with("hessian_approximation", "Limited-Memory");
    Solver::new(without_hessian(), &options).unwrap();
}

#[test]
fn the_only_prefix_is_that_of_the_restoration_phase() {
    for name in [
        ".tol",
        "x.tol",
        "resto..tol",
        "resto.resto.tol",
        "tol.",
        "Resto.tol",
    ] {
        let error = refused(name, 1e-3);
        assert!(matches!(error, OptionError::Unknown { .. }), "{error}");
        if !name.ends_with('.') {
            assert!(error.to_string().contains("`resto.`"), "{error}");
        }
        assert_eq!(hs071_solver!().ipopt_default(name), None);
    }
    refused("x.warm_start_init_point", "yes");
    set("resto.tol", 1e-3).unwrap();
    refused("resto.tol", -1.0);
    refused("resto.toll", 1.0);
    for word in ["exact", "Exact"] {
        let options = Options::new().with("resto.hessian_approximation", word);
        let error = Solver::new(without_hessian(), &options).unwrap_err();
        let Error::Option(OptionError::Refused { name, .. }) = error else {
            panic!("{error}");
        };
        assert_eq!(name, "resto.hessian_approximation");
    }
}

#[test]
fn options_that_are_refused_leave_the_others_as_they_were() {
    let mut solver = Solver::new(hs071_structure(), &Options::new().max_iter(3)).unwrap();
    let bad = Options::new()
        .max_iter(1)
        .derivative_test(DerivativeTest::FirstOrder)
        .with("warm_start_init_point", "yes")
        .tol(-1.0);
    assert!(solver.set_options(&bad).is_err());
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.status, Status::IterationLimit);
    assert_eq!(solution.statistics.iterations, 3);
    assert_eq!(solution.derivative_check, None);
}

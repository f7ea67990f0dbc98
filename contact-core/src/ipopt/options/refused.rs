//! Values that Ipopt takes and that would end the process, hide the solution or spoil it.

use super::{OptionError, OptionValue, check::bare};

/// A value of an option that the driver does not pass on.
struct Refusal {
    name: &'static str,
    /// With the prefix of the restoration phase only.
    restoration_only: bool,
    is_refused: fn(&OptionValue) -> bool,
    /// What Ipopt does with it.
    why: &'static str,
    remedy: &'static str,
}

const REFUSALS: [Refusal; 22] = [
    Refusal {
        name: "max_soc",
        restoration_only: false,
        is_refused: is_endless,
        why: "Ipopt then corrects one step so often between two iterates, where it looks at no limit",
        remedy: "choose at most 1000; Ipopt's own default is 4",
    },
    Refusal {
        name: "min_refinement_steps",
        restoration_only: false,
        is_refused: is_endless,
        why: "Ipopt then refines one solution so often between two iterates, where it looks at no limit",
        remedy: "choose at most 1000; Ipopt's own default is 1",
    },
    Refusal {
        name: "max_refinement_steps",
        restoration_only: false,
        is_refused: is_endless,
        why: "Ipopt then refines one solution so often between two iterates, where it looks at no limit",
        remedy: "choose at most 1000; Ipopt's own default is 10",
    },
    Refusal {
        name: "quality_function_max_section_steps",
        restoration_only: false,
        is_refused: is_endless,
        why: "Ipopt then searches for one μ so often between two iterates, where it looks at no limit",
        remedy: "choose at most 1000; Ipopt's own default is 8",
    },
    Refusal {
        name: "alpha_red_factor",
        restoration_only: false,
        is_refused: |value| number(value).is_some_and(|share| share > 0.99),
        why: "Ipopt then shortens one step so often between two iterates, where it looks at no limit",
        remedy: "choose at most 0.99; Ipopt's own default is 0.5",
    },
    Refusal {
        name: "output_file",
        restoration_only: false,
        is_refused: |value| !is_word(value, ""),
        why: "Ipopt then overwrites whatever file has this name",
        remedy: "leave the option out, and take the log by `Solver::set_log`",
    },
    Refusal {
        name: "nlp_lower_bound_inf",
        restoration_only: false,
        is_refused: |value| !number(value).is_some_and(|bound| bound <= -1e6),
        why: "Ipopt then takes finite bounds for none",
        remedy: "choose at most -1e6; Ipopt's own default is -1e19",
    },
    Refusal {
        name: "nlp_upper_bound_inf",
        restoration_only: false,
        is_refused: |value| !number(value).is_some_and(|bound| bound >= 1e6),
        why: "Ipopt then takes finite bounds for none",
        remedy: "choose at least 1e6; Ipopt's own default is 1e19",
    },
    Refusal {
        name: "option_file_name",
        restoration_only: false,
        is_refused: |value| !is_word(value, ""),
        why: "Ipopt ignores a file that is missing, and sets what is in it without a check",
        remedy: "read the file with `Options::read`, and leave the option out",
    },
    Refusal {
        name: "skip_finalize_solution_call",
        restoration_only: false,
        is_refused: |value| !is_word(value, "no"),
        why: "Ipopt then keeps the solution to itself",
        remedy: "leave the option out",
    },
    Refusal {
        name: "check_derivatives_for_naninf",
        restoration_only: false,
        is_refused: |value| !is_word(value, "no"),
        why: "Ipopt then reads values that were never written, and crashes, where a function fails",
        remedy: "leave the option out: every value of every function is checked before Ipopt sees it",
    },
    Refusal {
        name: "limited_memory_max_history",
        restoration_only: false,
        is_refused: is_zero,
        why: "Ipopt then crashes in its restoration phase",
        remedy: "remember at least 1 iteration",
    },
    Refusal {
        name: "limited_memory_max_history",
        restoration_only: false,
        is_refused: is_endless,
        why: "Ipopt then takes memory for so many iterations at once, and may take for ever",
        remedy: "choose at most 1000; Ipopt's own default is 6",
    },
    Refusal {
        name: "jacobian_approximation",
        restoration_only: false,
        is_refused: |value| !is_word(value, "exact"),
        why: "Ipopt then takes the differences of one variable for those of another where a variable is in no constraint, \
              calls solved what is not, and reads values that were never written where one is fixed",
        remedy: "leave the option out, and take differences of g in `Nlp::jacobian`",
    },
    Refusal {
        name: "slack_move",
        restoration_only: false,
        is_refused: is_zero,
        why: "slacks may then be 0, by which Ipopt divides, and MUMPS writes beyond its memory where values are infinite",
        remedy: "choose a positive number; Ipopt's own default is 1.8e-12",
    },
    Refusal {
        name: "mehrotra_algorithm",
        restoration_only: true,
        is_refused: |value| !is_word(value, "no"),
        why: "Ipopt then crashes in its restoration phase",
        remedy: "leave the prefix out: the restoration phase does without it",
    },
    Refusal {
        name: "nlp_scaling_constr_target_gradient",
        restoration_only: false,
        is_refused: |value| !is_zero(value),
        why: "Ipopt then divides by the largest derivative at the start, be it 0, and may iterate without end",
        remedy: "leave the option out, and scale with `Solver::set_scaling`",
    },
    Refusal {
        name: "hessian_approximation",
        restoration_only: true,
        is_refused: |_| true,
        why: "Ipopt crashes in its restoration phase where it is not that of the other phase",
        remedy: "leave the prefix out",
    },
    Refusal {
        name: "line_search_method",
        restoration_only: true,
        is_refused: |value| is_word(value, "cg-penalty"),
        why: "Ipopt then crashes in its restoration phase",
        remedy: "take \"filter\" or \"penalty\", or leave the option out",
    },
    Refusal {
        name: "warm_start_target_mu",
        restoration_only: false,
        is_refused: |value| !is_zero(value),
        why: "Ipopt then crashes as it starts",
        remedy: "leave the option out, and set `mu_init`",
    },
    Refusal {
        name: "bound_mult_init_method",
        restoration_only: false,
        is_refused: |value| !is_word(value, "constant"),
        why: "Ipopt then crashes where the start is next to a bound",
        remedy: "leave the option out, and set `bound_mult_init_val`",
    },
    Refusal {
        name: "dependency_detector",
        restoration_only: false,
        is_refused: |value| !is_word(value, "none"),
        why: "Ipopt then drops equalities that contradict others, and calls solved what violates them",
        remedy: "leave the option out, and remove constraints that depend on others",
    },
];

fn number(value: &OptionValue) -> Option<f64> {
    match *value {
        OptionValue::Number(number) => Some(number),
        OptionValue::Integer(number) => Some(number.into()),
        OptionValue::Text(_) => None,
    }
}

fn is_word(value: &OptionValue, word: &str) -> bool {
    matches!(value, OptionValue::Text(text) if text.eq_ignore_ascii_case(word))
}

/// More than a thousand, or no whole number.
fn is_endless(value: &OptionValue) -> bool {
    !matches!(value, OptionValue::Integer(..=1000))
}

fn is_zero(value: &OptionValue) -> bool {
    matches!(value, OptionValue::Number(0.0) | OptionValue::Integer(0))
}

/// The options that the versions of Ipopt register with which this driver was tried.
const REGISTERED: &str = include_str!("registered.txt");

fn is_registered(name: &str) -> bool {
    let lines = REGISTERED.lines().filter(|line| !line.starts_with('#'));
    lines
        .filter_map(|line| line.split(' ').next())
        .any(|known| known == name)
}

/// Rejects what must not reach Ipopt.
pub(super) fn check(name: &str, value: &OptionValue) -> Result<(), OptionError> {
    let is_for_restoration = bare(name) != name;
    if !is_registered(bare(name)) {
        return Err(OptionError::Refused {
            name: name.to_owned(),
            value: value.clone(),
            why: "neither Ipopt 3.11 nor 3.14 has it, and nothing is known of what it does",
            remedy: "leave it out",
        });
    }
    let refusal = REFUSALS.iter().find(|refusal| {
        refusal.name == bare(name)
            && (is_for_restoration || !refusal.restoration_only)
            && (refusal.is_refused)(value)
    });
    match refusal {
        Some(&Refusal { why, remedy, .. }) => Err(OptionError::Refused {
            name: name.to_owned(),
            value: value.clone(),
            why,
            remedy,
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_ipopt_known_here_has_is_refused() {
        for refusal in &REFUSALS {
            assert!(is_registered(refusal.name), "{}", refusal.name);
        }
        for name in ["tol", "resto.tol", "hsllib", "ma28_pivtol"] {
            check(name, &OptionValue::Number(1.0)).expect("registered");
        }
        for name in ["tolerance", "to", "since", "#", ""] {
            let refused = check(name, &OptionValue::Number(1.0)).expect_err("refused");
            assert!(
                refused.to_string().contains("nothing is known"),
                "{refused}"
            );
        }
    }

    #[test]
    fn bounds_count_steps_end_and_files_stay() {
        let number = |value: f64| OptionValue::Number(value);
        for (name, allowed, wrong) in [
            ("alpha_red_factor", number(0.99), number(0.999_999_99)),
            (
                "nlp_lower_bound_inf",
                number(f64::NEG_INFINITY),
                number(2.0),
            ),
            (
                "nlp_lower_bound_inf",
                OptionValue::Integer(-1_000_000),
                number(-10.0),
            ),
            ("nlp_upper_bound_inf", number(1e6), number(1e-300)),
            ("output_file", "".into(), "a.csv".into()),
        ] {
            check(name, &allowed).expect("allowed");
            let refused = check(name, &wrong).expect_err("refused").to_string();
            assert!(refused.contains(name), "{refused}");
        }
    }

    /// Found by the fuzzer: `slack_move` 0, and invalid accesses in the matching of MUMPS, seen by valgrind.
    #[test]
    fn slacks_of_zero_are_not_asked_for() {
        for name in ["slack_move", "resto.slack_move"] {
            check(name, &OptionValue::Number(1e-300)).expect("allowed");
            let refused = check(name, &OptionValue::Number(0.0)).expect_err("refused");
            assert!(refused.to_string().contains("slack"), "{refused}");
        }
    }

    /// Found by the fuzzer: `max_soc` 1038577779, and back solves without end; `limited_memory_max_history` 408788544.
    #[test]
    fn loops_between_iterates_are_bounded() {
        for name in [
            "max_soc",
            "min_refinement_steps",
            "resto.max_refinement_steps",
            "limited_memory_max_history",
            "quality_function_max_section_steps",
        ] {
            check(name, &OptionValue::Integer(1000)).expect("allowed");
            for many in [1001, 1_038_577_779] {
                let refused = check(name, &OptionValue::Integer(many));
                let told = refused.expect_err("refused").to_string();
                assert!(
                    told.contains(name) && told.contains(&many.to_string()),
                    "{told}"
                );
            }
        }
    }
}

//! Files of options. An `ipopt.opt` in the working directory is not read: alone in its process, whose working directory
//! it changes.
#![cfg(feature = "ipopt")]

use std::{env, fs, path::Path, process};

use contact_core::ipopt::{Error, OptionError, OptionValue, Options, Solver, Start, Status};
use problems::*;

#[test]
fn an_option_file_is_read_on_request_only() {
    let directory = env::temp_dir().join(format!("ipopt-option-file-{}", process::id()));
    fs::create_dir_all(&directory).unwrap();
    fs::write(directory.join("ipopt.opt"), "max_iter 1\n").unwrap();
    env::set_current_dir(&directory).unwrap();

    let unasked = hs071_solver!()
        .solve(&mut Hs071, &Start::at(&HS071_START))
        .unwrap();
    let options = Options::read("ipopt.opt").unwrap();
    let mut solver = Solver::new(hs071_structure(), &options).unwrap();
    let asked = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    what_a_file_may_hold(&directory.join("options"));

    env::set_current_dir(env::temp_dir()).unwrap();
    fs::remove_dir_all(&directory).unwrap();
    assert_eq!(unasked.status, Status::Solved);
    assert_close(&unasked.x, &HS071_X, 1e-6);
    assert_eq!(asked.status, Status::IterationLimit);
}

fn what_a_file_may_hold(path: &Path) {
    let read = |text: &str| {
        fs::write(path, text).unwrap();
        Options::read(path)
    };
    let text = "# all of these are fine\n\n tol 1d-9# so is this\n\tmax_iter  7\r\nmax_iter 70\n\
                mu_strategy Adaptive\noutput_file \"a # b\"\nprint_info_string no";
    let options = read(text).unwrap();
    let found: Vec<_> = options.iter().collect();
    let expected: [(&str, OptionValue); 5] = [
        ("tol", 1e-9.into()),
        ("max_iter", 70.into()),
        ("mu_strategy", "adaptive".into()),
        ("output_file", "a # b".into()),
        ("print_info_string", "no".into()),
    ];
    assert!(
        expected
            .iter()
            .map(|(n, v)| (*n, v))
            .eq(found.iter().copied()),
        "{found:?}"
    );
    assert_eq!(read(""), Ok(Options::new()));

    for (text, line) in [
        ("tol", 1),
        ("tol 1e-3\n\nfoo bar baz", 3),
        ("tol \"1e-3", 1),
    ] {
        match read(text) {
            Err(OptionError::Line { number, .. }) => assert_eq!(number, line, "{text:?}"),
            other => panic!("{text:?}: {other:?}"),
        }
    }
    fs::write(path, [0xff, 0xfe, 0x00]).unwrap();
    let absent = path.with_extension("absent");
    for path in [path, &absent] {
        let error = Options::read(path).expect_err("no text is there");
        assert!(matches!(error, OptionError::File { .. }), "{error}");
        assert!(error.to_string().contains(&path.display().to_string()));
    }
    // what would end the process reaches the same checks
    let options = read("option_file_name other.opt").unwrap();
    assert!(matches!(
        Solver::new(hs071_structure(), &options),
        Err(Error::Option(OptionError::Refused { .. }))
    ));
    let options = read("tol yes").unwrap();
    assert!(matches!(
        Solver::new(hs071_structure(), &options),
        Err(Error::Option(OptionError::WrongType { .. }))
    ));
}

//! A program that returns an error of this library from `main` prints its message, and not how it is stored.

use std::{env, error::Error, path::Path, process::Command};

use ipopt_contact::contact_core::{self, ipopt, nlp};
use ipopt_contact::contact_fem;
use ipopt_contact::contact_fem::output::compare::compare;
use ipopt_contact::prelude::*;

/// What stands for the number of an error in the process that returns it.
const CHILD: &str = "IPOPT_CONTACT_RETURNS";

/// An error of each public type, wrapped and bare.
fn errors() -> Vec<Box<dyn Error>> {
    let structure =
        |bounds| nlp::Structure::new(bounds, nlp::Bounds::default(), nlp::Pattern::empty(), None);
    let nowhere = || structure(nlp::Bounds::uniform(1, 2.0, 1.0)).expect_err("crossed");
    let unknown = || {
        let structure = structure(nlp::Bounds::free(1)).expect("valid");
        let options = ipopt::Options::new().with("no_such_option", 1);
        ipopt::Solver::new(structure, &options).expect_err("unknown")
    };
    let ipopt::Error::Option(option) = unknown() else {
        panic!("{}", unknown());
    };
    let foreign = || MeshFile::parse(b"\x1f\x8b").expect_err("no mesh");
    let contact_fem::Error::MeshFile { problem, .. } = foreign() else {
        panic!("{}", foreign());
    };
    vec![
        Box::new(nowhere()),
        Box::new(option),
        Box::new(unknown()),
        Box::new(contact_core::Error::from(unknown())),
        Box::new(contact_fem::Error::from(contact_core::Error::from(
            nowhere(),
        ))),
        Box::new(NeoHookean::new(1.0, 0.5).expect_err("incompressible")),
        Box::new(foreign()),
        Box::new(problem),
        Box::new(compare(Path::new("a"), Path::new("b")).expect_err("nothing there")),
    ]
}

/// In a child it returns an error, which the harness reports as `main` would.
#[test]
fn returned_from_main() -> Result<(), Box<dyn Error>> {
    if let Ok(number) = env::var(CHILD) {
        return Err(errors().swap_remove(number.parse()?));
    }
    for (number, error) in errors().iter().enumerate() {
        let output = Command::new(env::current_exe()?)
            .args(["--exact", "returned_from_main", "--nocapture"])
            .env(CHILD, number.to_string())
            .output()?;
        assert!(!output.status.success());
        let printed = String::from_utf8(output.stderr)?;
        let message = format!("Error: {error}\n");
        assert!(printed.contains(&message), "{message} is not in {printed}");
    }
    Ok(())
}

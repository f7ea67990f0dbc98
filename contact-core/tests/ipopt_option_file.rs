//! An `ipopt.opt` in the working directory. Alone in its process, whose working directory it changes.
#![cfg(feature = "ipopt")]

use std::{env, fs, process};

use contact_core::ipopt::{Options, Solver, Start, Status};
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
    let options = Options::new().with("option_file_name", "ipopt.opt");
    let mut solver = Solver::new(hs071_structure(), &options).unwrap();
    let asked = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();

    env::set_current_dir(env::temp_dir()).unwrap();
    fs::remove_dir_all(&directory).unwrap();
    assert_eq!(unasked.status, Status::Solved);
    assert_close(&unasked.x, &HS071_X, 1e-6);
    assert_eq!(
        asked.status,
        Status::IterationLimit,
        "the file would have been read"
    );
}

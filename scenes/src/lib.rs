//! The scenes that tests, examples, benches and the report share, and what programs about them need beside the library.
//!
//! | module | what |
//! |---|---|
//! | [`disc_in_disc`], [`beams`] | sections 6.1 and 6.2 of the paper |
//! | [`hertz`], [`arch`], [`blocks`], [`hairpin`] | Hertz's contact, Signorini's problem, the patch test, self-contact |
//! | [`studies`] | methods and passes side by side |
//! | [`freefem`] | the same scenes solved by FreeFEM's scripts |
//! | [`cli`], [`files`], [`tables`] | options of the examples, files, tables |
#![allow(non_snake_case)] // the symbols of the field

pub mod arch;
pub mod beams;
pub mod blocks;
pub mod cli;
pub mod disc_in_disc;
pub mod files;
pub mod freefem;
pub mod hairpin;
pub mod hertz;
pub mod studies;
pub mod tables;

use contact_fem::model::Passes;

/// What a program about scenes may fail with, for `main` to print.
pub type Failure = Box<dyn std::error::Error>;

/// The same roles for the pair in the other order.
fn mirrored(passes: Passes) -> Passes {
    match passes {
        Passes::Both => Passes::Both,
        Passes::FirstIsSlave => Passes::SecondIsSlave,
        Passes::SecondIsSlave => Passes::FirstIsSlave,
    }
}

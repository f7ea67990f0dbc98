//! What the examples share: their options, files, progress, and a clean stop.
#![allow(dead_code)] // no example uses all of it

pub mod files;
pub mod machine;
pub mod options;
pub mod progress;
pub mod recorder;
pub mod run;
pub mod stop;
pub mod summary;

/// What any part of an example may fail with, for `main` to print.
pub type Failure = Box<dyn std::error::Error>;

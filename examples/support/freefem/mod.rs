//! What the comparison with FreeFEM is made of.

pub mod cases;
pub mod outcome;
pub mod process;
pub mod reference;
pub mod report;
pub mod solve;
pub mod theirs;

use crate::support::{Failure, files};

//! The comparison with FreeFEM.

pub mod cases;
pub mod compare;
pub mod outcome;
pub mod process;
pub mod reference;
pub mod report;
pub mod solve;
pub mod theirs;

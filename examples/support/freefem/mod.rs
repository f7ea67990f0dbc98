//! What the comparison with FreeFEM is made of.

pub mod cases;

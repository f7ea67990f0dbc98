//! Studies: comparison of the methods, and of single passes with both.

pub mod asymmetry;
mod condition;
pub mod methods;
pub mod pointwise;

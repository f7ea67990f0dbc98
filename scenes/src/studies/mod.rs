//! Studies: methods side by side, and one pass against the other and against both.

pub mod asymmetry;
mod condition;
pub mod methods;
pub mod pointwise;

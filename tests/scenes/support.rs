//! Scenes of the examples, which use more of them.
#![allow(dead_code)]

#[path = "../../examples/support/beams.rs"]
pub mod beams;
#[path = "../../examples/support/blocks.rs"]
pub mod blocks;
#[path = "../../examples/support/hairpin.rs"]
pub mod hairpin;
#[path = "../../examples/support/hertz.rs"]
pub mod hertz;
#[path = "../../examples/support/pointwise.rs"]
pub mod pointwise;

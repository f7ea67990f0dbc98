//! Scenes of the examples, which use more of them.
#![allow(dead_code)]

#[path = "../../examples/support/arch.rs"]
pub mod arch;
#[path = "../../examples/support/beams.rs"]
pub mod beams;
#[path = "../../examples/support/blocks.rs"]
pub mod blocks;
#[path = "../../examples/support/discs.rs"]
pub mod discs;
#[path = "../../examples/support/files.rs"]
pub mod files;
#[path = "../../examples/support/freefem/mod.rs"]
pub mod freefem;
#[path = "../../examples/support/hairpin.rs"]
pub mod hairpin;
#[path = "../../examples/support/hertz.rs"]
pub mod hertz;
#[path = "../../examples/support/pointwise.rs"]
pub mod pointwise;
#[path = "../../examples/support/stop.rs"]
pub mod stop;
#[path = "../../examples/support/tables.rs"]
pub mod tables;

/// What parts of examples may fail with.
pub type Failure = Box<dyn std::error::Error>;

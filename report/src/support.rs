//! Scenes and helpers of the examples, which use more of them.
#![allow(dead_code)]

#[path = "../../examples/support/beams.rs"]
pub mod beams;
#[path = "../../examples/support/blocks.rs"]
pub mod blocks;
#[path = "../../examples/support/discs.rs"]
pub mod discs;
#[path = "../../examples/support/files.rs"]
pub mod files;
#[path = "../../examples/support/hertz.rs"]
pub mod hertz;
#[path = "../../examples/support/machine.rs"]
pub mod machine;
#[path = "../../examples/support/tables.rs"]
pub mod tables;

use crate::Failure;

//! Scenes of one or a few bodies against theory, integrated equations and each other: one program, which shares what it compiles.

mod boundaries;
mod common;
mod edges;
mod estimate;
mod fits_and_corners;
mod geometric_error;
mod locking;
mod offsets;
mod plane_stress;
mod pressures;
mod regions;
mod revolution;
mod revolution_contact;
mod rigid;
mod rollers;
mod supports;
mod switches;
mod ties;

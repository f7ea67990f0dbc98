//! Scenes from meshes to forces, in one program: what they instantiate is compiled once.

#![allow(non_snake_case)] // the symbols of the field

mod common;

mod audit;
mod automatic;
mod bad_input;
mod beams;
mod budget;
mod certificate;
mod condensed;
mod continuity;
mod derivatives;
mod disc_in_disc;
mod extremes;
mod freefem;
mod friction;
mod hertz;
mod initial_gaps;
mod inverted;
mod ironing;
mod left_out;
mod many_bodies;
mod memory;
mod methods;
mod needs;
mod newton;
mod obstacles;
mod patch;
mod patch_exact;
mod pressure;
mod programs;
mod rows;
mod search_faults;
mod space;
mod standing;
mod surfaces;
mod toy;
mod units;
mod wrong_parts;

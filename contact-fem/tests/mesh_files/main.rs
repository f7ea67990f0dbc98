//! Mesh files: read, refused, damaged, made into bodies, written. The fuzzer beside them (`fuzz.rs`) is an example.

mod damaged;
mod decks;
mod from_elsewhere;
mod labels;
mod refused;
mod support;
mod to_bodies;
mod written;

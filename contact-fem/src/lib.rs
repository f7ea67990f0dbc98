//! Finite elements for contact: meshes, materials, assembly, the weak
//! non-penetration constraints, and scenes that put them together.
//!
//! The space dimension `D` (2: plane strain, plane stress or bodies of revolution; 3) is a const generic throughout. The code for both is compiled with this
//! crate, by the settings of the profile for dependencies, and not again in crates that use it; a program in the plane links none for space. Any consistent units work: UF for force, UL for length;
//! plane energies and forces are those of a slice of thickness 1 UL, those of bodies of revolution of the whole circumference.
//!
//! The names follow the paper: `X` reference and `x = X + u` current position, `F = I + ∇u`,
//! `J = det F`, `P = ∂ψ/∂F`. *Slave* and *master* are roles within one pass only, since every pair
//! has one pass for each assignment of the roles.
#![forbid(unsafe_code)]
#![allow(non_snake_case)]

pub mod accuracy;
pub mod assembly;
pub mod audit;
pub mod certificate;
pub mod contact;
pub mod element;
pub mod error;
pub mod freefem;
mod instances;
mod jacobi;
pub mod left_out;
pub mod material;
pub mod mesh;
pub mod model;
pub mod output;
mod parallel;
pub mod program;
pub mod simulation;
pub mod tensor;

/// Vectors and matrices of the interface are types of `nalgebra`, re-exported here in the version
/// that this crate uses.
pub use nalgebra;

pub use certificate::Certificate;
pub use contact_core::Phase;
pub use error::Error;
pub use left_out::LeftOut;
pub use material::{
    Deformation, LinearElastic, Material, MooneyRivlin, NeoHookean, Ogden, PlaneStress,
    StVenantKirchhoff,
};
pub use mesh::Mesh;
pub use mesh::read::MeshFile;
pub use model::{Body, BodyId, Obstacle, Scene};
pub use program::{Amplitude, Motion};
pub use simulation::{Simulation, StepRecord};

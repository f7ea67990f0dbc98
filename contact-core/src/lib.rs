//! Two things: a safe driver of Ipopt for problems of any kind, and contact as an optimisation problem in ℝⁿ, with no
//! mesh and no space dimension in sight.
//!
//! # Ipopt
//! **To solve min f(x) subject to x_L ≤ x ≤ x_U and g_L ≤ g(x) ≤ g_U, go to [`ipopt`]**, which leads from zero to a
//! first solution; [`nlp`] has the trait of a problem, and [`check::nlp`] compares its derivatives with differences.
//! Nothing of the rest is needed for it.
//!
//! # Contact
//! An [`Energy`] is minimised under linearised gap constraints [`LinearGaps`] by a [`Method`];
//! [`fixed_point`] repeats that with fresh constraints until the displacement stands still
//! (Algorithm 2 of Houssein, Garnotel and Hecht), and [`load_steps`] walks the load up to its full
//! value. Whoever can state a [`ContactProblem`] gets the rest from here.
//!
//! # Glossary
//!
//! | name | meaning |
//! |---|---|
//! | `u` | the FREE unknowns, ℝⁿ; prescribed ones are eliminated by the problem |
//! | E(u) | total potential energy, UF·UL; `+∞` where the state is inadmissible |
//! | d(u) | the energy's [domain](Energy::domain): admissible means every d > 0 (volume ratios J) |
//! | c(u) = C u + c₀ ≥ 0 | linearised gaps, each a length (UL), positive = open |
//! | λ ≥ 0 | multipliers of the gaps, each a compressive force (UF): ∇E = Cᵀλ |
//! | UF, UL | the user's units of force and length |
#![allow(non_snake_case)]
// The front page leads to the module of a feature.
#![cfg_attr(not(feature = "ipopt"), allow(rustdoc::broken_intra_doc_links))]

pub mod anderson;
pub mod check;
pub mod energy;
pub mod error;
pub mod fixed_point;
pub mod gaps;
#[cfg(feature = "ipopt")]
pub mod ipopt;
pub mod linear;
pub mod load_steps;
pub mod method;
pub mod nlp;
pub mod problem;

pub use energy::{DirectSum, Energy};
pub use error::Error;
pub use fixed_point::{Acceleration, FixedPoint};
pub use gaps::{LinearGaps, RowKey};
pub use load_steps::{LoadStepped, LoadSteps};
#[cfg(feature = "ipopt")]
pub use method::{Continuation, InteriorPoint, PenalizedSlack, Penalty};
pub use method::{Method, Minimum};
pub use nlp::Bounds;
pub use problem::{ContactProblem, Multipliers, Scale, State};

/// The example of the README, as a test.
#[cfg(all(doctest, feature = "ipopt"))]
#[doc = include_str!("../README.md")]
struct Readme;

//! This crate has two parts: a safe driver of Ipopt for nonlinear problems of any kind, and contact as an optimisation
//! problem in ℝⁿ, which needs neither a mesh nor a space dimension.
//!
//! # Ipopt
//! **To solve min f(x) subject to x_L ≤ x ≤ x_U and g_L ≤ g(x) ≤ g_U, start with [`ipopt`]**, which explains every step
//! to a first solution. [`nlp`] defines the trait of a problem; [`check::nlp`] compares its derivatives with finite
//! differences. This part does not depend on the other one.
//!
//! # Contact
//! A [`Method`] minimises an [`Energy`] under linearised gap constraints [`LinearGaps`]. A [`FixedPoint`]
//! linearises the constraints anew and minimises again until the displacement no longer changes (Algorithm 2
//! of Houssein, Garnotel and Hecht). It implements [`Equilibrium`], which solves for one load. With the feature `linear`,
//! `Condensed` and `CondensedNewton` do so without an inner optimiser, and `Automatic` takes the one that fits the
//! problem. [`LoadSteps`] raises the load step by step to its full value. All of them work on any [`ContactProblem`].
//!
//! | level | result | how it ended |
//! |---|---|---|
//! | subproblem | [`Minimum`] | [`Solved`] |
//! | load step | [`Solution`](equilibrium::Solution) | [`Outcome`] |
//! | run | [`Run`](load_steps::Run) | [`Ending`] |
//!
//! Each level reports a [`Cost`]; costs are additive.
//!
//! A run writes lines by the crate `log`, with the target `contact`, for whichever logger the application has set.
//!
//! | level | what |
//! |---|---|
//! | `warn` | a run that ends before full load, and what is left out, repeated or leapt over |
//! | `info` | the beginning of each phase, each attempt at a load step with its outcome, the end of the run |
//! | `debug` | each iteration of the fixed point, of Newton's method and of `Condensed`, as it ends |
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
//! | Δs = T u + d, r | slips of contact nodes (UL) and forces of [`friction`] against them (UF): ∇E = Cᵀλ − Tᵀr |
//! | UF, UL | the user's units of force and length |
#![allow(non_snake_case)]
// The front page links to a module that exists with the feature `ipopt` only.
#![cfg_attr(not(feature = "ipopt"), allow(rustdoc::broken_intra_doc_links))]

/// The target of the lines that runs log, see the front page of this crate.
pub(crate) const LOG: &str = "contact";

pub mod check;
pub mod cost;
pub mod energy;
pub mod equilibrium;
pub mod error;
pub mod friction;
pub mod gaps;
#[cfg(feature = "ipopt")]
#[allow(unsafe_code)] // the calls of Ipopt
pub mod ipopt;
pub mod linear;
pub mod load_steps;
pub mod memory;
pub mod method;
pub mod nlp;
pub mod outcome;
#[cfg(feature = "linear")]
mod parallel;
#[cfg(planted)]
pub mod planted;
pub mod problem;
pub mod quadratic;
pub mod reduction;
mod stop;

pub use cost::Cost;
pub use energy::{DirectSum, Energy};
#[cfg(feature = "ipopt")]
pub use equilibrium::Literal;
pub use equilibrium::{Acceleration, Equilibrium, FixedPoint, Retry};
#[cfg(feature = "linear")]
pub use equilibrium::{Automatic, Condensed, CondensedNewton};
pub use error::Error;
pub use gaps::{LinearGaps, RowKey};
pub use load_steps::{LoadStepped, LoadSteps, Phase};
pub use memory::{MemoryError, MemoryNeed};
#[cfg(feature = "ipopt")]
pub use method::{Continuation, InteriorPoint, PenalizedSlack, Penalty};
pub use method::{Method, Minimum};
pub use nlp::Bounds;
pub use outcome::{Ending, Interruption, Outcome, Solved};
pub use problem::{ContactProblem, GapVariation, Multipliers, Scale, Separable, State};
pub use reduction::{Dependent, LinearMap, Reduction};
pub use stop::{Budget, Stop};

/// The example of the README, as a test.
#[cfg(all(doctest, feature = "ipopt"))]
#[doc = include_str!("../README.md")]
struct Readme;

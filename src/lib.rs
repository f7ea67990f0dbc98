//! Contact between elastic bodies by energy minimisation: symmetric, with no master and slave
//! to choose.
//!
//! The library minimises the total energy of all bodies under weak non-penetration constraints, which both sides of
//! every contact impose on each other. With projections and normals held, the constraints are linear. A fixed-point
//! iteration updates the projections until the displacement no longer changes, and load steps increase the load to its
//! full value. The method is that of Houssein, Garnotel and Hecht, *Contact problems in industrial applications using
//! FreeFEM*.
//!
//! Simulations find the same equilibria by faster solvers, and use the paper's where these do not apply or fail, see
//! [`Automatic`](contact_core::Automatic). `Simulation::solved_by(Retry::<InteriorPoint>::default(), 100)` runs the paper's,
//! accelerated; with [`Acceleration::Plain`](contact_core::Acceleration::Plain) it is the paper's to the letter.
//!
//! This crate re-exports two crates and has a [`prelude`] for scenes:
//! - [`contact_fem`]: meshes, materials, assembly, contact constraints, scenes, load histories, output;
//! - [`contact_core`]: energies, the solvers of one load, load steps, and the safe Ipopt driver, all in ℝⁿ; it knows no
//!   mesh.
//!
//! [`nalgebra`], whose vectors and matrices are in the interface of [`contact_fem`], is re-exported in the version used.
//!
//! # A scene
//! A disc is pushed 1.125 lengths down through the ring around it (the paper's section 6.1 on a coarse mesh). No
//! energy is lost: what the disc's support does in work is stored as strain.
//! ```
//! use ipopt_contact::prelude::*;
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let hollow = annulus(&linspace(0.7, 2.0, 5), 24, Diagonals::Alternating)?;
//!     let mut ring = Body::new(hollow, NeoHookean::new(1000.0, 0.0)?);
//!     ring.prescribe("outer", [Some(0.0), Some(0.0)])?;
//!     let mut inner = Body::new(disc(0.6, 20, 1, 0.03)?, NeoHookean::new(2000.0, 0.3)?);
//!     inner.prescribe_all([Some(0.0), Some(-1.125)])?;
//!
//!     let mut scene = Scene::new();
//!     let ring = scene.add("ring", ring);
//!     let inner = scene.add("disc", inner);
//!     scene.contact(ring.on("inner"), inner.on("boundary"))?;
//!     let history = Simulation::with_increments(10).run(&mut scene.problem()?)?;
//!
//!     let last = history.last().ok_or("no increment converged")?;
//!     let force = last.reaction(ring)[1];
//!     println!("energy {:.2}, force {force:.2}", last.energy);
//!     // the work by the trapezoidal rule over ten equal increments
//!     let forces = history.steps.iter().map(|step| step.reaction(ring)[1]);
//!     let work = 1.125 / 10.0 * (forces.sum::<f64>() - 0.5 * force);
//!     assert!(history.is_complete() && history.run.cuts() == 0);
//!     assert!((work / last.energy - 1.0).abs() < 0.01);
//!     Ok(())
//! }
//! ```
//!
//! # The shortest problem
//! A block is pressed on a floor: six names, each of which says something of the scene.
//! ```
//! use ipopt_contact::prelude::{Body, LinearElastic, Obstacle, Scene, Simulation, cuboid};
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let mut block = Body::new(cuboid([0.0; 3], [1.0; 3], [4; 3])?, LinearElastic::new(200.0, 0.0)?);
//!     block.prescribe("top", [Some(0.0), Some(0.0), Some(-0.1)])?;
//!     let mut scene = Scene::new();
//!     let block = scene.add("block", block);
//!     scene.obstacle("floor", block.on("bottom"), Obstacle::half_space([0.0; 3], [0.0, 0.0, 1.0])?)?;
//!
//!     let history = Simulation::with_increments(1).run(&mut scene.problem()?)?;
//!     let force = history.last().ok_or("no equilibrium")?.reaction(block)[2];
//!     // the stress E·0.1 on an area of 1
//!     assert!((force + 20.0).abs() < 1e-6);
//!     Ok(())
//! }
//! ```
//!
//! # Another method, a single pass, exact integration, and what the result is worth
//! ```
//! # use ipopt_contact::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let block = |y, cells| rectangle(&linspace(0.0, 1.0, cells), &linspace(y, y + 1.0, cells), Diagonals::Rising);
//! let mut lower = Body::new(block(0.0, 5)?, LinearElastic::new(210.0, 0.3)?);
//! lower.prescribe("bottom", [Some(0.0), Some(0.0)])?;
//! let mut upper = Body::new(block(1.0, 7)?, LinearElastic::new(210.0, 0.3)?);
//! upper.prescribe("top", [Some(0.0), Some(-0.01)])?;
//! let mut scene = Scene::new();
//! let (lower, upper) = (scene.add("lower", lower), scene.add("upper", upper));
//! scene.integration = Some(Integration::Exact);
//! // the lower block's surface alone is slave; `contact` takes both in turn
//! scene.contact_in_passes(lower.on("top"), upper.on("bottom"), Passes::FirstIsSlave)?;
//!
//! // method (37) with a penalty factor that grows until 1e-4 of what matters is left of penetration
//! let continuation = Continuation { penetration: 1e-4, ..Continuation::default() };
//! let solver = Retry::with(PenalizedSlack::with(continuation));
//! let history = Simulation::solved_by(solver, 1).run(&mut scene.problem()?)?;
//! let certificate = history.certificate().ok_or("no step converged")?;
//! println!("{certificate}");
//! assert!(certificate.holds(&Limits::default()));
//! for entry in certificate.entries(&Limits::default()) {
//!     println!("{} {:?} of {:e}", entry.name, entry.value, entry.limit);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//! `vtk`, `csv` and `plot` are the output formats of [`contact_fem::output`], `record` makes all of them while a run
//! goes on: `simulation.record("out/disc")`. All are on by default. `threads` shares assembly, contact search and the
//! factors of separate bodies among threads; `resume` has runs that go on where they ended
//! ([`Resumable`](contact_core::equilibrium::Resumable)), and is part of `record`; `metis` orders large factors by nested dissection.
#![forbid(unsafe_code)]

#[cfg(feature = "record")]
pub mod scene_file;

pub use contact_core;
pub use contact_core::ipopt::{Blas, BlasKind, Versions, versions};
pub use contact_fem;
pub use contact_fem::nalgebra;

/// What most scenes need, in one `use`.
///
/// Two blocks of heights 1 are pressed together by 0.01. They are springs in series, and the force does not depend on
/// how many cells either has:
/// ```
/// use ipopt_contact::prelude::*;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let block = |y, cells| rectangle(&linspace(0.0, 1.0, cells), &linspace(y, y + 1.0, cells), Diagonals::Rising);
/// let mut soft = Body::new(block(0.0, 3)?, LinearElastic::new(100.0, 0.0)?);
/// soft.prescribe("bottom", [Some(0.0), Some(0.0)])?;
/// let mut stiff = Body::new(block(1.0, 4)?, LinearElastic::new(300.0, 0.0)?);
/// stiff.prescribe("top", [Some(0.0), Some(-0.01)])?;
///
/// let mut scene = Scene::new();
/// let (soft, stiff) = (scene.add("soft", soft), scene.add("stiff", stiff));
/// scene.integration = Some(Integration::Exact);
/// scene.contact(soft.on("top"), stiff.on("bottom"))?;
/// let history = Simulation::with_increments(1).run(&mut scene.problem()?)?;
///
/// let last = history.last().ok_or("not converged")?;
/// let force = 0.01 / (1.0 / 100.0 + 1.0 / 300.0);
/// assert!((last.contact_force(stiff)[1] / force - 1.0).abs() < 1e-5);
/// assert!(last.certificate.holds(&Limits::default()), "{}", last.certificate);
/// # Ok(())
/// # }
/// ```
pub mod prelude {
    pub use std::ops::ControlFlow;

    pub use contact_core::{
        Acceleration, Automatic, Budget, Condensed, CondensedNewton, Continuation, Ending,
        Equilibrium, FixedPoint, InteriorPoint, LoadSteps, Method, Outcome, PenalizedSlack,
        Penalty, Phase, Retry, Stop,
    };
    pub use contact_fem::certificate::{Condition, Limits};
    pub use contact_fem::mesh::generators::{
        Diagonals, annulus, cuboid, cuboid_graded, cylinder, disc, eighth_sphere, equilateral_disc,
        extrude, graded, half_disc, hemisphere, linspace, quarter_disc, rectangle, sphere,
    };
    pub use contact_fem::model::{
        BodyId, Corners, Geometry, InitialGaps, Integration, ObstacleId, Passes, Problem,
        Projection, Side, Tie, TiedSlave,
    };
    pub use contact_fem::simulation::{History, StepView};
    pub use contact_fem::{
        Amplitude, Body, Certificate, LeftOut, LinearElastic, Material, Mesh, MeshFile,
        MooneyRivlin, Motion, NeoHookean, Obstacle, Ogden, PlaneStress, Scene, Simulation,
        StVenantKirchhoff, StepRecord,
    };
}

#[cfg(test)]
mod tests {
    /// The documentation above runs as a test; the README's first two programs are held to it.
    #[test]
    fn the_readme_shows_the_scenes_that_are_tested() {
        let lines = include_str!("lib.rs").lines();
        let documented = lines.map_while(|line| line.strip_prefix("//!"));
        let documented: Vec<&str> = documented
            .map(|line| line.strip_prefix(' ').unwrap_or(line))
            .collect();
        let documented = documented.join("\n");
        let programs = |text: &str, fence: &str| -> Vec<String> {
            let blocks = text.split(fence).skip(1);
            let code = blocks.filter_map(|rest| Some(rest.split("```").next()?.trim()));
            let programs = code.filter(|code| code.contains("\nfn main()"));
            programs.take(2).map(String::from).collect()
        };
        let shown = programs(include_str!("../README.md"), "```rust\n");
        // every other block is the text between two
        let tested = programs(&documented, "\n```\n");
        assert!(
            shown.len() == 2 && shown[1].lines().count() > 10,
            "{shown:?}"
        );
        assert_eq!(shown, tested);
    }
}

/// The recipes, whose programs run as tests.
#[cfg(doctest)]
#[doc = include_str!("../docs/cookbook.md")]
struct Cookbook;

/// The estimate of the discretisation error.
#[cfg(doctest)]
#[doc = include_str!("../docs/error.md")]
struct DiscretisationError;

//! Signorini's problem: an elastic arch is pressed on a rigid foundation, at small strains.

use std::f64::consts::{PI, TAU};

use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::model::Passes;
use contact_fem::tensor::Vector;
use contact_fem::{Body, Error, LinearElastic, Mesh, NeoHookean, Obstacle, Scene};

/// The outer radius of the arch (UL): the lower half of a ring on the line y = 0.
pub const RADIUS: f64 = 10.0;
/// The thickness of the arch (UL).
pub const THICKNESS: f64 = 1.0;
/// Young's modulus (UF/UL²) and Poisson's ratio.
pub const YOUNG: f64 = 1000.0;
const NU: f64 = 0.3;
/// The downward displacement of its ends (UL).
pub const PUSH: f64 = 2.0;

/// The arch, which is the first body, with `across` cells through the thickness and 32 times as
/// many along it, and the foundation, all of whose displacements are prescribed.
///
/// Only the surface of the arch is slave: since all normals are vertical, its rows are the weighted
/// means of y + u_y with its test functions.
pub fn scene(across: usize) -> Result<Scene<2>, Error> {
    let ground = Body::new(ground()?, LinearElastic::new(YOUNG, NU)?);
    on_foundation(arch(across)?, ground)
}

/// A neo-Hookean arch with large displacements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Large {
    /// The number of cells along the arch.
    pub along: usize,
    /// The number of cells through its thickness.
    pub across: usize,
    /// The downward displacement of its ends (UL).
    pub push: f64,
    /// Poisson's ratio.
    pub poisson: f64,
}

impl Large {
    /// The bodies and roles of [`scene`].
    pub fn scene(&self) -> Result<Scene<2>, Error> {
        let law = NeoHookean::new(YOUNG, self.poisson)?;
        let arch = Body::new(mesh(self.along, self.across)?, law);
        on_foundation(pushed(arch, self.push)?, Body::new(ground()?, law))
    }
}

/// The foundation has the law of the arch, since a scene has either small or large strains.
fn on_foundation(arch: Body<2>, mut foundation: Body<2>) -> Result<Scene<2>, Error> {
    let mut scene = Scene::new();
    foundation.prescribe_all([Some(0.0); 2])?;
    let arch = scene.add("arch", arch);
    let foundation = scene.add("foundation", foundation);
    scene.contact_in_passes(
        arch.on("bottom"),
        foundation.on("top"),
        Passes::FirstIsSlave,
    )?;
    Ok(scene)
}

/// The same arch on a half-space that has no mesh.
pub fn on_obstacle(across: usize) -> Result<Scene<2>, Error> {
    let mut scene = Scene::new();
    let arch = scene.add("arch", arch(across)?);
    let foundation = Obstacle::half_space([0.0; 2], [0.0, 1.0])?;
    scene.obstacle("foundation", arch.on("bottom"), foundation)?;
    Ok(scene)
}

fn arch(across: usize) -> Result<Body<2>, Error> {
    let law = LinearElastic::new(YOUNG, NU)?;
    pushed(Body::new(mesh(32 * across, across)?, law), PUSH)
}

fn mesh(along: usize, across: usize) -> Result<Mesh<2>, Error> {
    let angles = linspace(PI, TAU, along);
    let depths = linspace(0.0, THICKNESS, across);
    let bend = |X: &Vector<2>| {
        let r = RADIUS - X[1];
        Vector::<2>::new(r * X[0].cos(), RADIUS + r * X[0].sin())
    };
    rectangle(&angles, &depths, Diagonals::Rising)?.mapped(bend)
}

/// Its ends are moved down.
fn pushed(mut arch: Body<2>, push: f64) -> Result<Body<2>, Error> {
    for end in ["left", "right"] {
        arch.prescribe(end, [Some(0.0), Some(-push)])?;
    }
    Ok(arch)
}

fn ground() -> Result<Mesh<2>, Error> {
    rectangle(
        &[-2.0 * RADIUS, 2.0 * RADIUS],
        &[-THICKNESS, 0.0],
        Diagonals::Rising,
    )
}

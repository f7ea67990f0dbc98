//! A soft wheel on a hub is pressed on a soft slab and rolled along it: on every step other facets touch.

use contact_fem::mesh::generators::{Diagonals, annulus, linspace, rectangle};
use contact_fem::tensor::Vector;
use contact_fem::{Amplitude, Body, Error, Mesh, Motion, NeoHookean, Phase, Scene};

/// How far the hub is pressed down, and by which angle it is turned then (UL, radians).
pub const PRESS: f64 = 0.08;
/// See [`PRESS`].
pub const TURN: f64 = 1.2;
/// The radii of the hub and of the wheel; length and height of the slab (UL).
const RADII: [f64; 2] = [0.4, 1.0];
const SLAB: [f64; 2] = [5.0, 1.0];
/// Where the hub is at first (UL).
const START: f64 = 1.8;
/// Young's modulus of both (UF/UL²), and Poisson's ratio.
const YOUNG: f64 = 10.0;
const NU: f64 = 0.3;

/// The two meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheel {
    /// The number of facets around the wheel, and of layers of cells from the hub to them.
    pub around: usize,
    /// See [`Wheel::around`].
    pub layers: usize,
    /// The angle by which the wheel's mesh is turned (radians).
    pub turned: f64,
    /// The number of cells along the slab; a fifth of it through its thickness.
    pub cells: usize,
    /// The slab's cells are narrower in the middle of the way and wider at its ends by up to this share; below 1.
    pub graded: f64,
    /// Whether cells are quadratic.
    pub quadratic: bool,
}

impl Wheel {
    /// # Errors
    /// Too few cells.
    pub fn scene(&self) -> Result<Scene<2>, Error> {
        let (sin, cos) = self.turned.sin_cos();
        let between = linspace(RADII[0], RADII[1], self.layers);
        let mesh = annulus(&between, self.around, Diagonals::Alternating)?;
        let mesh = if self.quadratic {
            mesh.quadratic()
        } else {
            mesh
        };
        let mesh = mesh.mapped(|X| {
            let turned = [cos * X[0] - sin * X[1], sin * X[0] + cos * X[1]];
            Vector::<2>::new(START + turned[0], RADII[1] + turned[1])
        })?;
        let mut wheel = Body::new(mesh, NeoHookean::new(YOUNG, NU)?);
        let ramp = |from: f64| Amplitude::table(&[(from, 0.0), (from + 1.0, 1.0)]);
        let press = Motion::translation([0.0, -PRESS])?.driven_by(ramp(0.0)?);
        // clockwise, about the hub where the press has left it
        let turn = Motion::<2>::rotation([START, RADII[1] - PRESS], -TURN)?.driven_by(ramp(1.0)?);
        let along = Motion::translation([TURN * RADII[1], 0.0])?.driven_by(ramp(1.0)?);
        wheel.prescribe_motion("inner", press.then(turn).then(along))?;
        let mut slab = Body::new(self.slab()?, NeoHookean::new(YOUNG, NU)?);
        slab.prescribe("bottom", [Some(0.0); 2])?;
        let mut scene = Scene::new();
        let slab = scene.add("slab", slab).on("top");
        let wheel = scene.add("wheel", wheel).on("outer");
        scene.contact(slab, wheel)?;
        Ok(scene)
    }

    fn slab(&self) -> Result<Mesh<2>, Error> {
        let grid = rectangle(
            &linspace(0.0, 1.0, self.cells),
            &linspace(-SLAB[1], 0.0, (self.cells / 5).max(1)),
            Diagonals::Alternating,
        )?;
        let grid = if self.quadratic {
            grid.quadratic()
        } else {
            grid
        };
        let full = std::f64::consts::TAU;
        grid.mapped(|X| {
            let moved = X[0] + self.graded * (full * X[0]).sin() / full;
            Vector::<2>::new(SLAB[0] * moved, X[1])
        })
    }
}

/// Pressed and rolled in these numbers of steps.
pub fn phases(press: usize, roll: usize) -> [Phase; 2] {
    [
        Phase::new("press", 1.0, press),
        Phase::new("roll", 2.0, roll),
    ]
}

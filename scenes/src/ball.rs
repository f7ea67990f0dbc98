//! Hertz's contact of a ball on a rigid plane, a quarter of it by symmetry.

use std::f64::consts::PI;

use contact_fem::element::Order;
use contact_fem::mesh::generators::{Diagonals, extrude, graded, linspace, onto_sphere, rectangle};
use contact_fem::tensor::Vector;
use contact_fem::{Body, Error, LinearElastic, Mesh, Scene};

use crate::pair;

/// The ball's radius (UL).
pub const RADIUS: f64 = 50.0;
/// The radius of the contact zone by Hertz's theory (UL), which the load is chosen for.
pub const CONTACT_RADIUS: f64 = 2.5;
/// The half side of the square prism that the ball is cut to, and its height (UL).
const SIDE: f64 = 30.0;
/// Young's modulus (UF/UL²) and Poisson's ratio.
pub const MODULI: [f64; 2] = [210.0, 0.3];

/// How fine, and of which order.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// Facets in the contact radius.
    pub in_contact: usize,
    /// P1, or P2 with a curved surface.
    pub order: Order,
}

impl Ball {
    /// E* = E/(1 − ν²) (UF/UL²).
    fn contact_modulus() -> f64 {
        MODULI[0] / (1.0 - MODULI[1] * MODULI[1])
    }

    /// The force on the whole ball (UF): a³ = 3FR/(4E*).
    pub fn force() -> f64 {
        4.0 * Self::contact_modulus() * CONTACT_RADIUS.powi(3) / (3.0 * RADIUS)
    }

    /// p₀ = 3F/(2πa²) (UF/UL²).
    pub fn peak_pressure() -> f64 {
        1.5 * Self::force() / (PI * CONTACT_RADIUS.powi(2))
    }

    /// The facet in the centre of contact (UL).
    pub fn facet(&self) -> f64 {
        CONTACT_RADIUS / self.in_contact as f64
    }

    /// The ball, which is the first body, and the plane.
    pub fn scene(&self) -> Result<Scene<3>, Error> {
        pair((self.ball()?, "below"), (self.plane()?, "above"))
    }

    /// The same scene with another mesh of the ball: linear cells of the prism cut out of it, x, y from 0 to 30 and z from the
    /// sphere to 30, its lowest point in the origin.
    pub fn scene_of(&self, mesh: Mesh<3>) -> Result<Scene<3>, Error> {
        let mut mesh = mesh;
        let is_near = |a: f64, b: f64| (a - b).abs() < 1e-6 * SIDE;
        mesh.name_boundary("left", |X| is_near(X[0], 0.0));
        mesh.name_boundary("bottom", |X| is_near(X[1], 0.0));
        mesh.name_boundary("above", |X| is_near(X[2], SIDE));
        let centre = Vector::<3>::new(0.0, 0.0, RADIUS);
        mesh.name_boundary("below", |X| is_near((X - centre).norm(), RADIUS));
        let ball = self.body(mesh.translated([0.0, 0.0, -RADIUS])?)?;
        pair((ball, "below"), (self.plane()?, "above"))
    }

    /// A box whose bottom is drawn up to the sphere, heights in proportion.
    fn ball(&self) -> Result<Body<3>, Error> {
        let grid = self.grid(self.facet())?;
        let onto = |X: &Vector<3>| {
            let drawn = RADIUS - (RADIUS * RADIUS - X[0] * X[0] - X[1] * X[1]).sqrt();
            let height = drawn + X[2] * (SIDE - drawn) / SIDE;
            Vector::<3>::new(X[0], X[1], height - RADIUS)
        };
        self.body(Self::block(&grid, &grid)?.mapped(onto)?)
    }

    /// Of linear cells around the ball's centre, with supports and load.
    fn body(&self, mut mesh: Mesh<3>) -> Result<Body<3>, Error> {
        if self.order == Order::Quadratic {
            mesh = mesh.quadratic().curved("below", onto_sphere(RADIUS))?;
        }
        let mesh = mesh.translated([0.0, 0.0, RADIUS])?;
        let mut ball = Body::new(mesh, LinearElastic::new(MODULI[0], MODULI[1])?);
        ball.prescribe("left", [Some(0.0), None, None])?;
        ball.prescribe("bottom", [None, Some(0.0), None])?;
        ball.traction("above", [0.0, 0.0, -0.25 * Self::force() / (SIDE * SIDE)])?;
        Ok(ball)
    }

    /// Steps of `h` up to half again the contact radius, and as many beyond, which grow.
    fn grid(&self, h: f64) -> Result<Vec<f64>, Error> {
        let count = 3 * self.in_contact / 2 + 1;
        let mut grid = linspace(0.0, h * count as f64, count);
        let end = grid[count];
        let growing = graded(end, SIDE, h, count)?;
        grid.extend(&growing[1..]);
        Ok(grid)
    }

    /// A square drawn out, all of whose surface nodes have the same surroundings, which keeps pressures of linear
    /// elements smooth. Sides `left` (x = 0) and `bottom` (y = 0); caps `below` and `above`.
    fn block(grid: &[f64], z: &[f64]) -> Result<Mesh<3>, Error> {
        let square = rectangle(grid, grid, Diagonals::Rising)?;
        extrude(&square, z, ["below", "above"])
    }

    /// Rigid, with facets larger by a tenth, so that nodes do not meet.
    fn plane(&self) -> Result<Body<3>, Error> {
        let grid = self.grid(1.1 * self.facet())?;
        let mesh = Self::block(&grid, &[-0.1 * SIDE, 0.0])?;
        let mut plane = Body::new(mesh, LinearElastic::new(MODULI[0], MODULI[1])?);
        plane.prescribe_all([Some(0.0); 3])?;
        Ok(plane)
    }
}

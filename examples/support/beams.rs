//! The three beams of section 6.2: cantilevers on top of each other, the top one loaded.

use ipopt_contact::contact_fem::Error;
use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::prelude::*;

/// The length of the beams (UL).
pub const LENGTH: f64 = 200.0;
/// The edge of their square sections (UL).
pub const SIDE: f64 = 25.0;
/// Young's modulus (UF/UL²).
pub const YOUNG: f64 = 2e5;
/// The load on the top face of the uppermost beam (UF/UL²).
pub const LOAD: f64 = 100.0;

/// The law of all beams.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// Linear elasticity, contact in the reference configuration.
    SmallStrain,
    /// Neo-Hookean bodies through large displacements.
    NeoHookean,
}

/// What a scene of the beams is made of.
#[derive(Clone, Copy, Debug)]
pub struct Beams {
    /// Cells across a beam's side; along the beam they are twice as long as high.
    pub across: usize,
    /// P1 or P2.
    pub order: Order,
    /// One law for all.
    pub law: Law,
    /// How many beams share the load.
    pub count: usize,
    /// Whether the beams touch; otherwise each goes its own way, the time of which is the floor for
    /// any contact algorithm.
    pub contact: bool,
}

impl Beams {
    /// The paper's three, in contact.
    pub fn new(across: usize, order: Order, law: Law) -> Self {
        Beams {
            across,
            order,
            law,
            count: 3,
            contact: true,
        }
    }

    /// Clamped at x = 0, the lowest beam first. Every other one has one division more along its
    /// length, so that nodes do not meet.
    pub fn scene(&self) -> Result<Scene<3>, Error> {
        let bodies: Result<Vec<_>, _> = (0..self.count).map(|k| self.beam(k)).collect();
        let mut scene = Scene::new(bodies?);
        if self.contact {
            for k in 1..self.count {
                scene.contact((k - 1, "top"), (k, "bottom"))?;
            }
        }
        Ok(scene)
    }

    fn beam(&self, k: usize) -> Result<Body<3>, Error> {
        let along = 4 * self.across + k % 2;
        let low = [0.0, 0.0, k as f64 * SIDE];
        let divisions = [along, self.across, self.across];
        let mut mesh = cuboid(low, [LENGTH, SIDE, SIDE], divisions)?;
        if self.order == Order::Quadratic {
            mesh = mesh.quadratic();
        }
        let mut beam = match self.law {
            Law::SmallStrain => Body::new(mesh, LinearElastic::new(YOUNG, 0.0)?),
            Law::NeoHookean => Body::new(mesh, NeoHookean::new(YOUNG, 0.0)?),
        };
        beam.prescribe("left", [Some(0.0); 3])?;
        // without contact every beam gets its share, so that all of them bend
        let share = match (self.contact, k + 1 == self.count) {
            (true, top) => f64::from(u8::from(top)),
            (false, _) => 1.0 / self.count as f64,
        };
        if share > 0.0 {
            beam.traction("top", [0.0, 0.0, -share * LOAD])?;
        }
        Ok(beam)
    }
}

/// The displacement of the middle of a beam's end (UL): the mean over the corners of its section.
pub fn tip(
    problem: &Problem<3>,
    displacements: &[contact_fem::tensor::Vector<3>],
    beam: usize,
) -> [f64; 3] {
    let corners: Vec<usize> = problem
        .nodes(beam)
        .filter(|&a| {
            let X = problem.reference()[a];
            let height = X[2] - beam as f64 * SIDE;
            X[0] == LENGTH
                && (X[1] == 0.0 || X[1] == SIDE)
                && (height.abs() < 1e-9 || (height - SIDE).abs() < 1e-9)
        })
        .collect();
    let sum = corners.iter().fold([0.0; 3], |sum, &a| {
        [0, 1, 2].map(|i| sum[i] + displacements[a][i])
    });
    sum.map(|s| s / corners.len() as f64)
}

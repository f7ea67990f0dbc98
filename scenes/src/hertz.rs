//! Hertz's contact of a half-cylinder on a block in plane strain, by symmetry their right halves.

use std::f64::consts::{PI, TAU};

use contact_fem::element::Order;
use contact_fem::mesh::generators::{Diagonals, graded, onto_sphere, quarter_disc, rectangle};
use contact_fem::model::{Integration, Passes};
use contact_fem::{Body, Error, LinearElastic, Scene};

use crate::mirrored;

/// The cylinder's radius, and the height and half width of the block are twice as much (UL).
pub const RADIUS: f64 = 50.0;
/// The force on the whole cylinder in the published case (UF per unit of thickness).
pub const FORCE: f64 = 7.0;
/// Poisson's ratio of both.
const NU: f64 = 0.3;

/// How fine the mesh of a body is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Facets from the centre of contact to its edge, were they all as small as the first.
    pub in_contact: f64,
    /// Facets on a quarter of the circle; other lines in proportion. They grow outwards.
    pub on_arc: usize,
}

impl Fineness {
    /// A family in which twice as fine halves all facets, about.
    pub fn family(in_contact: usize) -> Self {
        Fineness {
            in_contact: in_contact as f64,
            on_arc: 3 * in_contact,
        }
    }
}

/// Half-cylinder, the first body, and block. Geometry is that of the reference configuration.
#[derive(Clone, Copy, Debug)]
pub struct Hertz {
    /// Young's moduli of cylinder and block (UF/UL²).
    pub young: [f64; 2],
    /// Of cylinder and block.
    pub fineness: [Fineness; 2],
    /// The force on the whole cylinder (UF per unit of thickness).
    pub force: f64,
    /// P1, or P2 on the true circle.
    pub order: Order,
    /// Which surface is slave, were the cylinder the first body.
    pub passes: Passes,
    /// How gaps are integrated, if not by default.
    pub integration: Option<Integration>,
    /// The block comes first, which changes nothing.
    pub swapped: bool,
}

impl Hertz {
    /// The published case on two equally fine meshes, whose nodes do not meet.
    pub fn new(fineness: Fineness, order: Order) -> Self {
        Hertz {
            young: [210.0, 70.0],
            fineness: [fineness; 2],
            force: FORCE,
            order,
            passes: Passes::Both,
            integration: None,
            swapped: false,
        }
    }

    /// Moduli in the ratio `cylinder / block` for which pressure and half-width remain the same.
    pub fn with_ratio(self, ratio: f64) -> Self {
        let block = (1.0 - NU * NU) * self.contact_modulus() * (1.0 + 1.0 / ratio);
        Hertz {
            young: [ratio * block, block],
            ..self
        }
    }

    /// E*: 1/E* = Σ (1 − ν²)/E (UF/UL²).
    pub fn contact_modulus(&self) -> f64 {
        1.0 / self.young.map(|E| (1.0 - NU * NU) / E).iter().sum::<f64>()
    }

    /// Δ: the difference of (1 + ν)(1 − 2ν)/E, block less cylinder, by which their surfaces are shortened where they are
    /// pressed (UL²/UF).
    pub fn mismatch(&self) -> f64 {
        let [cylinder, block] = self.young.map(|E| (1.0 + NU) * (1.0 - 2.0 * NU) / E);
        block - cylinder
    }

    /// p₀ = √(P E*/(πR)) in the centre (UF/UL²).
    pub fn peak_pressure(&self) -> f64 {
        (self.force * self.contact_modulus() / (PI * RADIUS)).sqrt()
    }

    /// a = √(4PR/(πE*)) (UL).
    pub fn half_width(&self) -> f64 {
        (4.0 * self.force * RADIUS / (PI * self.contact_modulus())).sqrt()
    }

    /// The facet in the centre (UL) of cylinder and block.
    pub fn facets(&self) -> [f64; 2] {
        let facet = |fineness: Fineness| self.half_width() / fineness.in_contact;
        [facet(self.fineness[0]), 1.07 * facet(self.fineness[1])]
    }

    /// Both bodies, supported and loaded.
    pub fn scene(&self) -> Result<Scene<2>, Error> {
        let mut scene = Scene::new();
        let mut bodies = [
            ("cylinder", self.cylinder()?, "arc"),
            ("block", self.block()?, "top"),
        ];
        let mut passes = self.passes;
        if self.swapped {
            bodies.reverse();
            passes = mirrored(passes);
        }
        let [first, second] = bodies.map(|(name, body, side)| scene.add(name, body).on(side));
        scene.contact_in_passes(first, second, passes)?;
        scene.integration = self.integration;
        Ok(scene)
    }

    fn cylinder(&self) -> Result<Body<2>, Error> {
        let h = self.half_width() / self.fineness[0].in_contact;
        let count = self.fineness[0].on_arc;
        let angles = graded(1.5 * PI, TAU, h / RADIUS, count)?;
        let depths = graded(0.0, RADIUS, h, count * 52 / 90)?;
        let radii: Vec<f64> = depths.iter().rev().map(|d| RADIUS - d).collect();
        let mut mesh = quarter_disc(&radii, &angles, Diagonals::Falling)?;
        if self.order == Order::Quadratic {
            mesh = mesh.quadratic().curved("arc", onto_sphere(RADIUS))?;
        }
        let mesh = mesh.translated([0.0, RADIUS])?;
        let mut cylinder = Body::new(mesh, LinearElastic::new(self.young[0], NU)?);
        cylinder.prescribe("axis", [Some(0.0), None])?;
        cylinder.traction("flat", [0.0, -0.5 * self.force / RADIUS])?;
        Ok(cylinder)
    }

    fn block(&self) -> Result<Body<2>, Error> {
        let h = self.half_width() / self.fineness[1].in_contact;
        let count = self.fineness[1].on_arc;
        let xs = graded(0.0, 2.0 * RADIUS, 1.07 * h, count * 10 / 9)?;
        let depths = graded(0.0, 2.0 * RADIUS, h, count * 2 / 3)?;
        let ys: Vec<f64> = depths.iter().rev().map(|d| -d).collect();
        let mut mesh = rectangle(&xs, &ys, Diagonals::Rising)?;
        if self.order == Order::Quadratic {
            mesh = mesh.quadratic();
        }
        let mut block = Body::new(mesh, LinearElastic::new(self.young[1], NU)?);
        block.prescribe("left", [Some(0.0), None])?;
        block.prescribe("bottom", [Some(0.0), Some(0.0)])?;
        Ok(block)
    }
}

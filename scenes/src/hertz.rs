//! Hertz's contact of a half-cylinder and a block in plane strain; by symmetry only the right
//! halves.

use std::f64::consts::{PI, TAU};

use contact_fem::element::Order;
use contact_fem::mesh::generators::{Diagonals, graded, onto_sphere, quarter_disc, rectangle};
use contact_fem::model::{Integration, Passes};
use contact_fem::{Body, Error, LinearElastic, Obstacle, Scene};

use crate::mirrored;

/// The radius of the cylinder (UL). The height and half-width of the block are twice this value.
pub const RADIUS: f64 = 50.0;
/// The force on the whole cylinder in the published case (UF per unit thickness).
pub const FORCE: f64 = 7.0;
/// Poisson's ratio of both bodies.
const NU: f64 = 0.3;

/// The fineness of a body's mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// The number of facets of the smallest size, that at the centre of contact, in the half-width
    /// of contact.
    pub in_contact: f64,
    /// The number of facets on a quarter of the circle, which grow outwards; other lines in
    /// proportion.
    pub on_arc: usize,
}

impl Fineness {
    /// A family of meshes in which doubling `in_contact` approximately halves all facets.
    pub fn family(in_contact: usize) -> Self {
        Fineness {
            in_contact: in_contact as f64,
            on_arc: 3 * in_contact,
        }
    }
}

/// The half-cylinder, which is the first body, and the block, in the reference geometry.
#[derive(Clone, Copy, Debug)]
pub struct Hertz {
    /// Young's moduli of the cylinder and the block (UF/UL²).
    pub young: [f64; 2],
    /// The fineness of the cylinder and the block.
    pub fineness: [Fineness; 2],
    /// The force on the whole cylinder (UF per unit thickness).
    pub force: f64,
    /// The order of the elements: P1, or P2 with nodes on the true circle.
    pub order: Order,
    /// The roles of the surfaces with the cylinder as the first body.
    pub passes: Passes,
    /// The quadrature of the gaps; `None` for the default.
    pub integration: Option<Integration>,
    /// Whether the block is the first body; the result does not depend on it.
    pub swapped: bool,
}

impl Hertz {
    /// The published case on two meshes of equal fineness, whose nodes do not coincide.
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

    /// The scene with moduli in the ratio `cylinder / block` that preserve the pressure and the
    /// half-width.
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

    /// Δ: the difference between the block's and the cylinder's (1 + ν)(1 − 2ν)/E, which shortens
    /// the surfaces where they are compressed (UL²/UF).
    pub fn mismatch(&self) -> f64 {
        let [cylinder, block] = self.young.map(|E| (1.0 + NU) * (1.0 - 2.0 * NU) / E);
        block - cylinder
    }

    /// p₀ = √(P E*/(πR)), the pressure at the centre (UF/UL²).
    pub fn peak_pressure(&self) -> f64 {
        (self.force * self.contact_modulus() / (PI * RADIUS)).sqrt()
    }

    /// a = √(4PR/(πE*)), the half-width of contact (UL).
    pub fn half_width(&self) -> f64 {
        (4.0 * self.force * RADIUS / (PI * self.contact_modulus())).sqrt()
    }

    /// The size of the facet at the centre (UL) of the cylinder and of the block.
    pub fn facets(&self) -> [f64; 2] {
        let facet = |fineness: Fineness| self.half_width() / fineness.in_contact;
        [facet(self.fineness[0]), 1.07 * facet(self.fineness[1])]
    }

    /// The scene with both bodies, supported and loaded.
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

    /// The cylinder on the half-plane below it, which is rigid: a mesh none of whose nodes moves, or an obstacle. The
    /// contact modulus is that of an infinite second modulus.
    pub fn on_rigid(&self, is_meshed: bool) -> Result<Scene<2>, Error> {
        let mut scene = Scene::new();
        let arc = scene.add("cylinder", self.cylinder()?).on("arc");
        scene.integration = self.integration;
        if !is_meshed {
            let plane = Obstacle::half_space([0.0; 2], [0.0, 1.0])?;
            scene.obstacle("plane", arc, plane)?;
            return Ok(scene);
        }
        let corners = [-2.0 * RADIUS, 0.0];
        let mesh = rectangle(&[corners[0], -corners[0]], &corners, Diagonals::Rising)?;
        let mut plane = Body::new(mesh, LinearElastic::new(1.0, NU)?);
        plane.prescribe_all([Some(0.0); 2])?;
        let top = scene.add("plane", plane).on("top");
        scene.contact_in_passes(arc, top, Passes::FirstIsSlave)?;
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

//! The three beams of section 6.2: stacked cantilevers with a load on the top one.

use contact_fem::element::Order;
use contact_fem::mesh::generators::cuboid;
use contact_fem::model::Problem;
use contact_fem::tensor::Vector;
use contact_fem::{Body, BodyId, Error, LinearElastic, NeoHookean, Scene};

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
    /// Linear elasticity, with contact in the reference configuration.
    SmallStrain,
    /// Neo-Hookean material with large displacements.
    NeoHookean,
}

/// The parameters of a scene of beams.
#[derive(Clone, Copy, Debug)]
pub struct Beams {
    /// The number of cells across a beam's side.
    pub across: usize,
    /// The number of cells along a beam.
    pub along: usize,
    /// The order of the elements: P1 or P2.
    pub order: Order,
    /// The law of all beams.
    pub law: Law,
    /// Poisson's ratio; 0 in the paper.
    pub poisson: f64,
    /// The number of beams that share the load.
    pub count: usize,
    /// Whether the beams are in contact. Otherwise each carries its own share of the load; the run
    /// time of this scene is a lower bound for any contact algorithm.
    pub contact: bool,
}

impl Beams {
    /// The paper's three beams in contact, with cells that are twice as long as high.
    pub fn new(across: usize, order: Order, law: Law) -> Self {
        Beams {
            across,
            along: 4 * across,
            order,
            law,
            poisson: 0.0,
            count: 3,
            contact: true,
        }
    }

    /// Beams clamped at x = 0, the lowest first. Every second beam has one more division along its
    /// length, so that the nodes of neighbours do not coincide.
    pub fn scene(&self) -> Result<Scene<3>, Error> {
        let mut scene = Scene::new();
        let mut below: Option<BodyId> = None;
        for k in 0..self.count {
            let beam = scene.add(format!("beam{}", k + 1), self.beam(k)?);
            if let Some(below) = below.replace(beam).filter(|_| self.contact) {
                scene.contact(below.on("top"), beam.on("bottom"))?;
            }
        }
        Ok(scene)
    }

    fn beam(&self, k: usize) -> Result<Body<3>, Error> {
        let along = self.along + k % 2;
        let low = [0.0, 0.0, k as f64 * SIDE];
        let divisions = [along, self.across, self.across];
        let mut mesh = cuboid(low, [LENGTH, SIDE, SIDE], divisions)?;
        if self.order == Order::Quadratic {
            mesh = mesh.quadratic();
        }
        let mut beam = match self.law {
            Law::SmallStrain => Body::new(mesh, LinearElastic::new(YOUNG, self.poisson)?),
            Law::NeoHookean => Body::new(mesh, NeoHookean::new(YOUNG, self.poisson)?),
        };
        beam.prescribe("left", [Some(0.0); 3])?;
        // without contact the load is divided among the beams, so that all of them bend
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

/// The displacement of the centre of a beam's end section (UL): the mean over the section's
/// corners.
pub fn tip(problem: &Problem<3>, u: &[Vector<3>], beam: usize) -> [f64; 3] {
    let [bottom, top] = [0.0, 1.0].map(|level| end_edge(problem, u, beam, level));
    ((bottom + top) * 0.5).into()
}

/// The relative sliding (UL) of the end of beam `below` and that of the next one, along the beams.
pub fn slip(problem: &Problem<3>, u: &[Vector<3>], below: usize) -> f64 {
    let under = end_edge(problem, u, below, 1.0);
    let over = end_edge(problem, u, below + 1, 0.0);
    // the tangent of the interface at the tip, from the rotation of the lower beam's section
    let section = under - end_edge(problem, u, below, 0.0);
    let normal = (section + Vector::<3>::new(0.0, 0.0, SIDE)).normalize();
    let offset = over - under;
    (offset - normal * offset.dot(&normal)).norm()
}

/// The mean displacement of the two corners at the end of a beam, at `level` 0 (bottom) or 1 (top).
fn end_edge(problem: &Problem<3>, u: &[Vector<3>], beam: usize, level: f64) -> Vector<3> {
    let height = (beam as f64 + level) * SIDE;
    let is_corner = |&a: &usize| {
        let X = problem.reference()[a];
        let at = |x: f64, value: f64| (x - value).abs() < 1e-9;
        at(X[0], LENGTH) && (at(X[1], 0.0) || at(X[1], SIDE)) && at(X[2], height)
    };
    let corners: Vec<usize> = problem.nodes(beam).filter(is_corner).collect();
    let sum: Vector<3> = corners.iter().map(|&a| u[a]).sum();
    sum / corners.len() as f64
}

/// The mean contact pressure (UF/UL²) on the middle third of the top of beam `below`, over the
/// facets with centroids there. A field on a flat triangle has the mean of its corners if it is linear, and that of its
/// mid-side nodes if it is quadratic.
pub fn mid_span_pressure(problem: &Problem<3>, pressures: &[f64], below: usize) -> f64 {
    let height = (below + 1) as f64 * SIDE;
    let is_near =
        |x: Vector<3>| (x[0] / LENGTH - 0.5).abs() <= 1.0 / 6.0 && (x[2] - height).abs() < 1e-9;
    let centre = Vector::<3>::repeat(1.0 / 3.0);
    let (mut force, mut area) = (0.0, 0.0);
    for surface in problem.surfaces().iter().filter(|s| s.body() == below) {
        for (facet, reference) in surface.facets().zip(surface.reference()) {
            let nodes = &facet[facet.len() - 3..];
            if is_near(reference.point(&centre)) {
                let measure = reference.normal(&centre).norm();
                let values = nodes.iter().map(|&k| pressures[surface.nodes()[k]]);
                force += measure * values.sum::<f64>() / 3.0;
                area += measure;
            }
        }
    }
    force / area
}

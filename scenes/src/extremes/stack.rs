//! Blocks on top of each other, whose state is homogeneous in each: the truth is the solution of one scalar equation.

use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::model::InitialGaps;
use contact_fem::{Body, Mesh, Scene};

use super::exchange::{Elastic, Law, Must, Reaction};
use super::{Case, Truth};
use crate::Failure;

/// Blocks of width 1 on rollers below, pressed down from above; laterally they are free.
#[derive(Clone, Debug)]
pub(super) struct Stack {
    /// 2 or 3.
    pub dimension: usize,
    pub law: Law,
    pub nu: f64,
    /// From below.
    pub young: Vec<f64>,
    /// The heights of the blocks (UL).
    pub heights: Vec<f64>,
    /// The gap below the uppermost block (UL), negative if it overlaps with the one below.
    pub gap: f64,
    pub initial_gaps: InitialGaps,
    /// The shortening of all blocks together, without the gap (UL).
    pub press: f64,
    /// Cells along the width and over the height, block by block.
    pub cells: Vec<[usize; 2]>,
    pub is_quadratic: bool,
    /// A factor on all lengths.
    pub length: f64,
    /// Whether every block has its lower and its upper face declared.
    pub both_faces: bool,
}

impl Default for Stack {
    /// Two equal blocks in the plane, pressed by a tenth of one.
    fn default() -> Self {
        Stack {
            dimension: 2,
            law: Law::NeoHookean,
            nu: 0.3,
            young: vec![1e3; 2],
            heights: vec![1.0; 2],
            gap: 0.0,
            initial_gaps: InitialGaps::Refuse,
            press: 0.1,
            cells: vec![[3, 3], [4, 4]],
            is_quadratic: false,
            length: 1.0,
            both_faces: false,
        }
    }
}

impl Stack {
    pub fn case(self, name: impl Into<String>, class: &'static str) -> Case {
        let (name, stack) = (name.into(), self.clone());
        let own = self.clone();
        let reactions = move || {
            let (last, up) = (own.heights.len() - 1, own.dimension - 1);
            let size = own.length.powi(up as i32);
            let force = size * own.force(Volume::Logarithmic);
            let differs = own.law == Law::NeoHookean && own.nu != 0.0;
            let ciarlet = differs.then(|| size * own.force(Volume::Ciarlet));
            let of = |what, body, sign: f64| Reaction {
                be_ciarlet: ciarlet.map(|force| sign * force),
                ..Reaction::new(what, [body, up], Must::Be(sign * force), 1e-4)
            };
            // the lower support carries the force, and nothing else does
            vec![of("force", last, -1.0), of("force below", 0, 1.0)]
        };
        let laws = (0..self.young.len()).map(|k| self.elastic(k)).collect();
        let case = if stack.dimension == 2 {
            Case::plane(
                name,
                class,
                move || stack.plane(),
                Truth::reactions(reactions),
            )
        } else {
            Case::space(
                name,
                class,
                move || stack.space(),
                Truth::reactions(reactions),
            )
        };
        case.with_laws(laws)
    }

    /// The lower end of a block (UL).
    fn foot(&self, k: usize) -> f64 {
        let below: f64 = self.heights[..k].iter().sum();
        let is_last = k + 1 == self.heights.len();
        self.length * (below + if is_last { self.gap } else { 0.0 })
    }

    fn plane(&self) -> Result<Scene<2>, Failure> {
        self.scene(
            |k| {
                let ([along, over], foot) = (self.cells[k], self.foot(k));
                let x = linspace(0.0, self.length, along);
                let y = linspace(foot, foot + self.length * self.heights[k], over);
                Ok(rectangle(&x, &y, Diagonals::Alternating)?)
            },
            |mesh, k| self.elastic(k).body(mesh),
        )
    }

    fn space(&self) -> Result<Scene<3>, Failure> {
        self.scene(
            |k| {
                let ([along, over], l) = (self.cells[k], self.length);
                let size = [l, l, l * self.heights[k]];
                Ok(cuboid(
                    [0.0, 0.0, self.foot(k)],
                    size,
                    [along, along, over],
                )?)
            },
            |mesh, k| self.elastic(k).body(mesh),
        )
    }

    fn elastic(&self, k: usize) -> Elastic {
        Elastic {
            law: self.law,
            young: self.young[k],
            poisson: self.nu,
        }
    }

    fn scene<const D: usize>(
        &self,
        mesh: impl Fn(usize) -> Result<Mesh<D>, Failure>,
        body: impl Fn(Mesh<D>, usize) -> Result<Body<D>, Failure>,
    ) -> Result<Scene<D>, Failure> {
        let mut scene = Scene::new();
        scene.initial_gaps = self.initial_gaps;
        let mut ids = Vec::new();
        for k in 0..self.heights.len() {
            let mut mesh = mesh(k)?;
            if self.is_quadratic {
                mesh = mesh.quadratic();
            }
            let foot = self.foot(k);
            let head = foot + self.length * self.heights[k];
            let near = |x: f64, y: f64| (x - y).abs() < 1e-9 * self.length * self.heights[k];
            mesh.name_boundary("lower", |x| near(x[D - 1], foot));
            mesh.name_boundary("upper", |x| near(x[D - 1], head));
            mesh.name_boundary("faces", |x| near(x[D - 1], foot) || near(x[D - 1], head));
            let mut block = body(mesh, k)?;
            for i in 0..D - 1 {
                // symmetry planes at x = 0 and y = 0
                let nodes: Vec<usize> = {
                    let nodes = block.mesh().nodes().iter().enumerate();
                    nodes.filter(|(_, x)| x[i] == 0.0).map(|(a, _)| a).collect()
                };
                let mut held = [None; D];
                held[i] = Some(0.0);
                block.prescribe_nodes(&nodes, held)?;
            }
            let mut along = [None; D];
            if k == 0 {
                along[D - 1] = Some(0.0);
                block.prescribe("lower", along)?;
            }
            if k + 1 == self.heights.len() {
                let way = match self.initial_gaps {
                    InitialGaps::Adjust => self.press,
                    _ => self.press + self.gap,
                };
                along[D - 1] = Some(-self.length * way);
                block.prescribe("upper", along)?;
            }
            ids.push(scene.add(format!("block {k}"), block));
        }
        if self.both_faces {
            for id in &ids {
                scene.contact_surface(id.on("faces"))?;
            }
        } else {
            for pair in ids.windows(2) {
                scene.contact(pair[0].on("upper"), pair[1].on("lower"))?;
            }
        }
        Ok(scene)
    }

    /// The compressive force per width in the plane, or per area in space, at unit length.
    fn force(&self, volume: Volume) -> f64 {
        let shortening = |stress: f64| -> f64 {
            let blocks = self.heights.iter().zip(&self.young);
            blocks
                .map(|(h, E)| h * (1.0 - self.stretch(*E, -stress, volume)))
                .sum()
        };
        // from no force to more than enough
        let (mut low, mut high) = (0.0, 1e-12);
        let stiffest = self.young.iter().copied().fold(0.0, f64::max);
        high *= stiffest;
        while shortening(high) < self.press {
            (low, high) = (high, 2.0 * high);
        }
        loop {
            let middle = 0.5 * (low + high);
            if !(low < middle && middle < high) {
                return middle;
            }
            match shortening(middle) < self.press {
                true => low = middle,
                false => high = middle,
            }
        }
    }

    /// The stretch of a block under a nominal stress, with free sides; in the plane without strain across it.
    fn stretch(&self, E: f64, stress: f64, resists: Volume) -> f64 {
        let (nu, plane) = (self.nu, self.dimension == 2);
        if self.law == Law::Linear {
            let modulus = if plane { E / (1.0 - nu * nu) } else { E };
            return 1.0 + stress / modulus;
        }
        let mu = E / (2.0 * (1.0 + nu));
        let lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
        // P_i = μ (s_i − 1/s_i) + λ p(J) / s_i; the sides are free of stress
        let volume = |s: f64, side: f64| if plane { s * side } else { s * side * side };
        let pressed = |J: f64| match resists {
            Volume::Logarithmic => J.ln(),
            Volume::Ciarlet => 0.5 * (J * J - 1.0),
        };
        let side = |s: f64| {
            bisect(1e-6, 1e6, |side| {
                mu * (side - 1.0 / side) + lambda * pressed(volume(s, side)) / side
            })
        };
        bisect(1e-6, 1e6, |s| {
            mu * (s - 1.0 / s) + lambda * pressed(volume(s, side(s))) / s - stress
        })
    }
}

/// How a neo-Hookean law resists changes of volume: with λ/2 (ln J)², or by Ciarlet's law with λ/4 (J² − 1 − 2 ln J).
#[derive(Clone, Copy, PartialEq)]
enum Volume {
    Logarithmic,
    Ciarlet,
}

/// The zero of an increasing function of a positive number.
fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    loop {
        let middle = (low * high).sqrt();
        if !(low < middle && middle < high) {
            return middle;
        }
        match f(middle) < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
}

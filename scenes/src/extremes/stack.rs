//! Blocks on top of each other, whose state is homogeneous in each: the truth is the solution of one scalar equation.

use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::model::InitialGaps;
use contact_fem::{Body, LinearElastic, Mesh, NeoHookean, Scene};

use super::{Case, Check, Truth};
use crate::Failure;

/// The law of a stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Law {
    Linear,
    NeoHookean,
}

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
        // the lower support carries the force, and nothing else does
        let checks = move |found: f64, below: f64| {
            let force = self.force() * self.length.powi(self.dimension as i32 - 1);
            vec![
                Check::relative("force", found, force, 1e-4),
                Check::relative("force below", below, -force, 1e-4),
            ]
        };
        if stack.dimension == 2 {
            let truth = Truth::Values(Box::new(move |_, history| {
                let last = history.last().map(|step| &step.reactions);
                let of = |k: Option<usize>| last.zip(k).map_or(f64::NAN, |(r, k)| -r[k][1]);
                checks(of(last.map(|r| r.len() - 1)), of(Some(0)))
            }));
            Case::plane(name, class, move || stack.plane(), truth)
        } else {
            let truth = Truth::Values(Box::new(move |_, history| {
                let last = history.last().map(|step| &step.reactions);
                let of = |k: Option<usize>| last.zip(k).map_or(f64::NAN, |(r, k)| -r[k][2]);
                checks(of(last.map(|r| r.len() - 1)), of(Some(0)))
            }));
            Case::space(name, class, move || stack.space(), truth)
        }
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
            |mesh, k| {
                Ok(match self.law {
                    Law::Linear => Body::new(mesh, self.linear(k)?),
                    Law::NeoHookean => Body::new(mesh, self.hyperelastic(k)?),
                })
            },
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
            |mesh, k| {
                Ok(match self.law {
                    Law::Linear => Body::new(mesh, self.linear(k)?),
                    Law::NeoHookean => Body::new(mesh, self.hyperelastic(k)?),
                })
            },
        )
    }

    fn linear(&self, k: usize) -> Result<LinearElastic, Failure> {
        Ok(LinearElastic::new(self.young[k], self.nu)?)
    }

    fn hyperelastic(&self, k: usize) -> Result<NeoHookean, Failure> {
        Ok(NeoHookean::new(self.young[k], self.nu)?)
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
    fn force(&self) -> f64 {
        let shortening = |stress: f64| -> f64 {
            let blocks = self.heights.iter().zip(&self.young);
            blocks
                .map(|(h, E)| h * (1.0 - self.stretch(*E, -stress)))
                .sum()
        };
        // from no force to more than enough
        let (mut low, mut high) = (0.0, 1e-12);
        let stiffest = self.young.iter().copied().fold(0.0, f64::max);
        high *= stiffest;
        while shortening(high) < self.press {
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            match shortening(middle) < self.press {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }

    /// The stretch of a block under a nominal stress, with free sides; in the plane without strain across it.
    fn stretch(&self, E: f64, stress: f64) -> f64 {
        let (nu, plane) = (self.nu, self.dimension == 2);
        if self.law == Law::Linear {
            let modulus = if plane { E / (1.0 - nu * nu) } else { E };
            return 1.0 + stress / modulus;
        }
        let mu = E / (2.0 * (1.0 + nu));
        let lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
        // P_i = μ (s_i − 1/s_i) + λ ln J / s_i; the sides are free of stress
        let volume = |s: f64, side: f64| if plane { s * side } else { s * side * side };
        let side = |s: f64| {
            bisect(1e-6, 1e6, |side| {
                mu * (side - 1.0 / side) + lambda * volume(s, side).ln() / side
            })
        };
        bisect(1e-6, 1e6, |s| {
            let J: f64 = volume(s, side(s));
            mu * (s - 1.0 / s) + lambda * J.ln() / s - stress
        })
    }
}

/// The zero of an increasing function of a positive number.
fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..80 {
        let middle = (low * high).sqrt();
        match f(middle) < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    (low * high).sqrt()
}

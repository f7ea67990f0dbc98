//! Ironing: a stiff die with a round bottom is pressed into a soft slab and slid along it.
//!
//! The data are those of M. A. Puso and T. A. Laursen, *A mortar segment-to-segment contact method for large deformation
//! solid mechanics*, CMAME 193 (2004), as remembered: a slab of 9 by 3 with E = 1, a die of radius 3 with E = 1000, neo-Hookean
//! with ν = 0.3, slid by 4 from 2.5. Here the problem is plane, the die is solid, and it is pressed by 0.75, not by 1.4.

use std::fmt;

use contact_fem::element::Order;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::model::Integration;
use contact_fem::simulation::{History, StepRecord};
use contact_fem::tensor::Vector;
use contact_fem::{Amplitude, Body, BodyId, Error, Mesh, Motion, NeoHookean, Phase, Scene};

/// How far the die is pressed down, and then slid (UL).
pub const PRESS: f64 = 0.75;
/// See [`PRESS`].
pub const SLIDE: f64 = 4.0;
/// Length and height of the slab (UL).
const SLAB: [f64; 2] = [9.0, 3.0];
/// Half the width of the die and its height, over its radius.
const HALF_WIDTH: f64 = 0.75;
const HEIGHT: f64 = 0.6;
/// Where the die's middle is at first (UL).
const START: f64 = 2.5;
/// Young's modulus of the slab (UF/UL²), and Poisson's ratio of both.
const YOUNG: f64 = 1.0;
const NU: f64 = 0.3;

/// The bodies' indices.
pub const SLAB_ID: usize = 0;
/// See [`SLAB_ID`].
pub const DIE_ID: usize = 1;

/// The two meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ironing {
    /// The order of the elements; quadratic ones of the die have their middle nodes on the circle.
    pub order: Order,
    /// The number of cells along the slab; a third of it through its thickness.
    pub cells: usize,
    /// The quadrature of the gaps; `None` for the default.
    pub integration: Option<Integration>,
    /// The radius of the die's bottom (UL), to which its width and height are in proportion, and Young's modulus of the die (UF/UL²).
    pub radius: f64,
    /// See [`Ironing::radius`].
    pub young: f64,
    /// The slab's cells are narrower in the middle and wider at the ends by up to this share; below 1.
    pub graded: f64,
}

impl Ironing {
    /// With the default quadrature.
    pub fn new(order: Order, cells: usize) -> Self {
        Ironing {
            order,
            cells,
            integration: None,
            radius: 3.0,
            young: 1000.0,
            graded: 0.0,
        }
    }

    /// The slab on its held bottom, and the die, whose top is moved.
    ///
    /// # Errors
    /// Fewer than 3 cells along the slab.
    pub fn scene(&self) -> Result<Scene<2>, Error> {
        let mut slab = Body::new(self.slab()?, NeoHookean::new(YOUNG, NU)?);
        slab.prescribe("bottom", [Some(0.0); 2])?;
        let mut die = Body::new(self.die()?, NeoHookean::new(self.young, NU)?);
        let down = Motion::translation([0.0, -PRESS])?;
        let down = down.driven_by(Amplitude::table(&[(0.0, 0.0), (1.0, 1.0)])?);
        let along = Motion::translation([SLIDE, 0.0])?;
        let along = along.driven_by(Amplitude::table(&[(1.0, 0.0), (2.0, 1.0)])?);
        die.prescribe_motion("top", down.then(along))?;
        let mut scene = Scene::new();
        scene.integration = self.integration;
        let slab = scene.add("slab", slab).on("top");
        let die = scene.add("die", die).on("bottom");
        scene.contact(slab, die)?;
        Ok(scene)
    }

    fn slab(&self) -> Result<Mesh<2>, Error> {
        let (x, y) = (
            linspace(0.0, SLAB[0], self.cells),
            linspace(0.0, SLAB[1], self.cells / 3),
        );
        let full = std::f64::consts::TAU / SLAB[0];
        let graded = |x: f64| x + self.graded * (full * x).sin() / full;
        let x: Vec<f64> = x.into_iter().map(graded).collect();
        let mesh = rectangle(&x, &y, Diagonals::Alternating)?;
        Ok(match self.order {
            Order::Linear => mesh,
            Order::Quadratic => mesh.quadratic(),
        })
    }

    /// Cells a little smaller than the slab's, so that nodes meet those of the slab at other places all the way.
    fn die(&self) -> Result<Mesh<2>, Error> {
        let (R, widest) = (self.radius, HALF_WIDTH.asin());
        let size = SLAB[0] / self.cells as f64;
        let along = (1.1 * 2.0 * R * widest / size).ceil() as usize;
        let high = (HEIGHT * R / size).ceil() as usize / 2;
        let grid = rectangle(
            &linspace(-widest, widest, along),
            &linspace(0.0, 1.0, high.max(1)),
            Diagonals::Alternating,
        )?;
        let grid = match self.order {
            Order::Linear => grid,
            Order::Quadratic => grid.quadratic(),
        };
        grid.mapped(|X| {
            let bottom = 1.0 - X[0].cos();
            let y = bottom + X[1] * (HEIGHT - bottom);
            Vector::<2>::new(START + R * X[0].sin(), SLAB[1] + R * y)
        })
    }
}

/// The two phases, in these numbers of steps.
pub fn phases(press: usize, slide: usize) -> [Phase; 2] {
    [
        Phase::new("press", 1.0, press),
        Phase::new("slide", 2.0, slide),
    ]
}

/// The force that moves the die (UF).
pub fn force(step: &StepRecord<2>) -> Vector<2> {
    step.reaction(BodyId::from(DIE_ID))
}

/// How even a slide is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evenness {
    /// The mean force that presses the die down (UF).
    pub normal: f64,
    /// Half the range of the tangential force over the normal one.
    pub range: f64,
    /// The same of what a cubic polynomial in the way leaves of the tangential force: the slab is softer towards its ends, which pulls the
    /// die along, evenly.
    pub wobble: f64,
    /// Work less stored energy, over the latter, at the end.
    pub lost: f64,
}

impl fmt::Display for Evenness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = |value: f64| 100.0 * value;
        let Evenness {
            normal,
            range,
            wobble,
            lost,
        } = *self;
        writeln!(f, "  normal force       {normal:.5} UF")?;
        writeln!(f, "  tangential force   ±{:.3} % of it", share(range))?;
        writeln!(f, "  wobble             ±{:.4} % of it", share(wobble))?;
        write!(f, "  work not stored    {:+.3} %", share(lost))
    }
}

impl Evenness {
    /// Of a run that has reached the end of the slide.
    pub fn of(history: &History<2>) -> Option<Self> {
        let slide: Vec<_> = history.steps.iter().filter(|s| s.factor >= 1.0).collect();
        let last = slide.last().filter(|_| history.is_complete())?;
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / slide.len() as f64;
        let normal = mean(&mut slide.iter().map(|step| -force(step)[1]));
        let tangential: Vec<[f64; 2]> = slide
            .iter()
            .map(|step| [step.factor - 1.5, force(step)[0]])
            .collect();
        let half_range = |values: &mut dyn Iterator<Item = f64>| {
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
            0.5 * (high - low) / normal
        };
        let smooth = cubic(&tangential);
        Some(Evenness {
            normal,
            range: half_range(&mut tangential.iter().map(|[_, f]| *f)),
            wobble: half_range(&mut tangential.iter().map(|[t, f]| f - smooth(*t))),
            lost: last.work() / last.stored_energy - 1.0,
        })
    }
}

/// The cubic polynomial through these points by least squares: by Gram and Schmidt, with monomials in [−½, ½].
fn cubic(points: &[[f64; 2]]) -> impl Fn(f64) -> f64 {
    let monomials: [Vec<f64>; 4] =
        std::array::from_fn(|k| points.iter().map(|[t, _]| t.powi(k as i32)).collect());
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut left: Vec<f64> = points.iter().map(|[_, f]| *f).collect();
    // each basis vector with its coefficients of the monomials
    let mut basis: Vec<(Vec<f64>, [f64; 4])> = Vec::new();
    let mut sum = [0.0; 4];
    for (k, monomial) in monomials.into_iter().enumerate() {
        let (mut v, mut c) = (monomial, [0.0; 4]);
        c[k] = 1.0;
        for (w, d) in &basis {
            let part = dot(&v, w) / dot(w, w);
            v.iter_mut().zip(w).for_each(|(v, w)| *v -= part * w);
            c.iter_mut().zip(d).for_each(|(c, d)| *c -= part * d);
        }
        let part = dot(&left, &v) / dot(&v, &v);
        left.iter_mut().zip(&v).for_each(|(l, v)| *l -= part * v);
        sum.iter_mut().zip(&c).for_each(|(s, c)| *s += part * c);
        basis.push((v, c));
    }
    move |t: f64| (0..4).rev().fold(0.0, |value, k| value * t + sum[k])
}

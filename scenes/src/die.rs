//! A sharp die is pressed into a softer slab and slid along it, in the phases of [`ironing`](crate::ironing::phases): its corners cross vertices of the
//! slab, and may slide off its end.

use contact_fem::element::Order;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::{Amplitude, Body, Error, Mesh, Motion, NeoHookean, Scene};

/// Length and height of the slab, and the height of the die (UL).
const SLAB: [f64; 2] = [3.0, 1.0];
const HEIGHT: f64 = 0.8;
/// Young's modulus of the slab (UF/UL²), and Poisson's ratio of both.
const YOUNG: f64 = 10.0;
const NU: f64 = 0.3;

/// The two meshes, and the way of the die.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Die {
    /// The order of the elements.
    pub order: Order,
    /// The numbers of cells along the slab and through it.
    pub slab: [usize; 2],
    /// The same of the die.
    pub die: [usize; 2],
    /// Where the die begins, and its width (UL).
    pub from: f64,
    /// See [`Die::from`].
    pub width: f64,
    /// Young's modulus of the die (UF/UL²).
    pub young: f64,
    /// How far the die is pressed down, and then slid (UL).
    pub press: f64,
    /// See [`Die::press`].
    pub slide: f64,
}

impl Die {
    /// The slab on its held bottom, and the die, whose top is moved.
    ///
    /// # Errors
    /// Numbers of cells that are 0, and lengths that are not positive.
    pub fn scene(&self) -> Result<Scene<2>, Error> {
        let mesh =
            |x: [f64; 2], y: [f64; 2], [along, high]: [usize; 2]| -> Result<Mesh<2>, Error> {
                let (x, y) = (linspace(x[0], x[1], along), linspace(y[0], y[1], high));
                let mesh = rectangle(&x, &y, Diagonals::Alternating)?;
                Ok(match self.order {
                    Order::Linear => mesh,
                    Order::Quadratic => mesh.quadratic(),
                })
            };
        let [length, height] = SLAB;
        let slab = mesh([0.0, length], [0.0, height], self.slab)?;
        let mut slab = Body::new(slab, NeoHookean::new(YOUNG, NU)?);
        slab.prescribe("bottom", [Some(0.0); 2])?;
        let ends = [self.from, self.from + self.width];
        let die = mesh(ends, [height, height + HEIGHT], self.die)?;
        let mut die = Body::new(die, NeoHookean::new(self.young, NU)?);
        let down = Motion::translation([0.0, -self.press])?;
        let down = down.driven_by(Amplitude::table(&[(0.0, 0.0), (1.0, 1.0)])?);
        let along = Motion::translation([self.slide, 0.0])?;
        let along = along.driven_by(Amplitude::table(&[(1.0, 0.0), (2.0, 1.0)])?);
        die.prescribe_motion("top", down.then(along))?;
        let mut scene = Scene::new();
        let slab = scene.add("slab", slab).on("top");
        let die = scene.add("die", die).on("bottom");
        scene.contact(slab, die)?;
        Ok(scene)
    }
}

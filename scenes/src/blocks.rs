//! The contact patch test: two blocks with a flat interface and non-matching meshes, one pressed on
//! the other. Without lateral contraction the stress is uniform, and the elements represent this
//! state exactly: any error comes from the constraints.

use contact_core::Ending;
use contact_core::InteriorPoint;
use contact_core::Retry;
use contact_fem::element::{Element, Order, P1, P2};
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::model::{Integration, Passes, Problem};
use contact_fem::tensor::{Matrix, Vector};
use contact_fem::{Body, Error, LinearElastic, Mesh, NeoHookean, Scene, Simulation};

/// Young's modulus (UF/UL²).
const YOUNG: f64 = 2e6;
/// The displacement of the upper block's top (UL); the total height of the blocks is 2 UL.
const PRESSED: f64 = 0.1;

/// The parameters of a scene of blocks.
#[derive(Clone, Copy, Debug)]
pub struct Blocks {
    /// The number of cells along an edge of the lower and of the upper block.
    pub divisions: [usize; 2],
    /// The order of the elements of the lower and of the upper block: P1 or P2.
    pub orders: [Order; 2],
    /// The roles of the surfaces; the lower block is the first.
    pub passes: Passes,
    /// The rotation of the scene (degrees): in the plane, or about (1, 2, −0.5).
    pub degrees: f64,
    /// Whether the blocks are neo-Hookean instead of linear elastic.
    pub large_strains: bool,
    /// The quadrature of the constraints.
    pub integration: Integration,
}

impl Blocks {
    /// The blocks at small strains, without rotation, with both passes.
    pub fn new(divisions: [usize; 2], order: Order, integration: Integration) -> Self {
        Blocks {
            divisions,
            orders: [order; 2],
            passes: Passes::Both,
            degrees: 0.0,
            large_strains: false,
            integration,
        }
    }

    /// The scene in the plane.
    pub fn plane(&self) -> Result<Scene<2>, Error> {
        let edge = |k: usize, low: f64| linspace(low, low + 1.0, self.divisions[k]);
        let mesh = |k| rectangle(&edge(k, 0.0), &edge(k, k as f64), Diagonals::Rising);
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        self.scene([mesh(0)?, mesh(1)?], &Matrix::<2>::new(cos, -sin, sin, cos))
    }

    /// The scene in space.
    pub fn space(&self) -> Result<Scene<3>, Error> {
        let mesh = |k: usize| cuboid([0.0, 0.0, k as f64], [1.0; 3], [self.divisions[k]; 3]);
        let axis = Vector::<3>::new(1.0, 2.0, -0.5).normalize();
        let cross = Matrix::<3>::from_fn(|i, j| match (3 + j - i) % 3 {
            1 => -axis[3 - i - j],
            2 => axis[3 - i - j],
            _ => 0.0,
        });
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        let turn = Matrix::identity() + cross * sin + cross * cross * (1.0 - cos);
        self.scene([mesh(0)?, mesh(1)?], &turn)
    }

    fn scene<const D: usize>(
        &self,
        meshes: [Mesh<D>; 2],
        turn: &Matrix<D>,
    ) -> Result<Scene<D>, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let mut scene = Scene::new();
        let mut sides = Vec::new();
        for (k, mesh) in meshes.into_iter().enumerate() {
            let mesh = match self.orders[k] {
                Order::Linear => mesh,
                Order::Quadratic => mesh.quadratic(),
            };
            let mesh = mesh.mapped(|X| turn * X)?;
            let mut body = match self.large_strains {
                false => Body::new(mesh, LinearElastic::new(YOUNG, 0.0)?),
                true => Body::new(mesh, NeoHookean::new(YOUNG, 0.0)?),
            };
            let down = turn.column(D - 1) * -PRESSED;
            let (name, held, by, touching) = match k {
                0 => ("lower", "bottom", [Some(0.0); D], "top"),
                _ => (
                    "upper",
                    "top",
                    std::array::from_fn(|i| Some(down[i])),
                    "bottom",
                ),
            };
            body.prescribe(held, by)?;
            sides.push(scene.add(name, body).on(touching));
        }
        scene.integration = Some(self.integration);
        scene.contact_in_passes(sides[0].clone(), sides[1].clone(), self.passes)?;
        Ok(scene)
    }
}

/// The largest errors of a scene of blocks: of a stress component at the centre of a cell, divided
/// by the pressure, and of a nodal displacement, divided by the largest one.
///
/// The complementarity tolerance is much smaller than the default, whose residual affects the
/// stress. With an even smaller one Ipopt begins to fail where one mesh contains the other, so that
/// the constraints of both passes coincide.
pub fn errors<const D: usize>(scene: Scene<D>) -> Result<[f64; 2], Error> {
    let mut problem = scene.problem()?;
    let method = InteriorPoint {
        // relative to a length, which is smaller for small strains
        complementarity: if problem.is_exact() { 1e-12 } else { 1e-15 },
        ..InteriorPoint::default()
    };
    let mut simulation = Simulation::solved_by(Retry::with(method), 1);
    simulation.solver.fixed_point.tolerance = 1e-11;
    let history = simulation.run(&mut problem)?;
    if history.run.ending != Ending::Complete {
        return Ok([f64::NAN; 2]);
    }
    let u = problem.displacements(&history.run.state.u);
    Ok(deviation(&problem, &u))
}

/// The errors of the displacements `u` of all nodes against the exact solution, as in [`errors`].
pub fn deviation<const D: usize>(problem: &Problem<D>, u: &[Vector<D>]) -> [f64; 2] {
    let (exact, stress) = exact(problem);
    let pressure = stress.norm();
    let moved = u.iter().zip(&exact).map(|(u, v)| (u - v).amax() / PRESSED);
    let mut worst: f64 = 0.0;
    for (body, energy) in problem.body_energies().iter().enumerate() {
        let mesh = problem.scene().bodies()[body].mesh();
        for state in energy.cell_states(mesh, &u[problem.nodes(body)]) {
            worst = worst.max((state.sigma - stress).amax() / pressure);
        }
    }
    [worst, moved.fold(0.0, f64::max)]
}

/// The exact displacement of every node and the uniform Cauchy stress: u = −(X·a) a PRESSED/2 and σ
/// = −p a aᵀ, with a the direction in which the blocks are stacked. With the stretch F along a, p
/// is E (1 − F), or μ (1/F − F) for neo-Hookean blocks.
pub fn exact<const D: usize>(problem: &Problem<D>) -> (Vec<Vector<D>>, Matrix<D>) {
    let upper = &problem.scene().bodies()[1];
    let node = upper.mesh().boundary_nodes("top").unwrap_or_default()[0];
    let prescribed = &upper.prescribed()[D * node..D * (node + 1)];
    // the top moves down
    let axis = Vector::from_fn(|i, _| -prescribed[i].unwrap_or_default() / PRESSED);
    let u = |X: &Vector<D>| axis * (-0.5 * PRESSED * X.dot(&axis));
    let F: f64 = 1.0 - 0.5 * PRESSED;
    let pressure = match problem.is_exact() {
        true => YOUNG * (1.0 - F),
        false => 0.5 * YOUNG * (1.0 / F - F),
    };
    let stress = axis * axis.transpose() * -pressure;
    (problem.reference().iter().map(u).collect(), stress)
}

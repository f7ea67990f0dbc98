//! What a scene does not need is left out, and doing it all the same changes nothing.

use std::ops::ControlFlow;

use contact_core::gaps::Sampling;
use contact_core::linear::SymmetricPattern;
use contact_core::load_steps::Run;
use contact_core::nlp::Bounds;
use contact_core::{
    ContactProblem, DirectSum, Ending, Energy, Error, InteriorPoint, LinearGaps, LoadStepped,
    LoadSteps, Method, Penalty, Retry, Scale, State,
};
use contact_fem::assembly::{BodyEnergy, DofMap, StrainEnergy};
use contact_fem::contact::rows::{PassRows, Unknowns};
use contact_fem::contact::stencil::projected;
use contact_fem::contact::{Master, Projection};
use contact_fem::element::{Element, Order, P1, P2};
use contact_fem::mesh::generators::{Diagonals, cuboid, disc, linspace, rectangle};
use contact_fem::model::{Integration, Problem};
use contact_fem::tensor::Vector;
use contact_fem::{Body, LeftOut, LinearElastic, Material, Mesh, NeoHookean, Scene};

use crate::common::{relative, run_with};
use ipopt_contact_scenes::{alone, hairpin, pair};

fn of_order<const D: usize>(mesh: Mesh<D>, order: Order) -> Mesh<D> {
    match order {
        Order::Linear => mesh,
        Order::Quadratic => mesh.quadratic(),
    }
}

/// A disc, whose inside cannot deform, on a block that is held below. The sides of the block are
/// part of its contact surface, though nothing comes near them.
fn disc_on_block<M: Material<2>>(law: M, order: Order) -> Scene<2> {
    let xs = linspace(-1.0, 1.0, 12);
    let mesh = rectangle(&xs, &linspace(-1.0, 0.0, 6), Diagonals::Alternating);
    let mut mesh = of_order(mesh.expect("mesh"), order);
    mesh.name_boundary("skin", |X| X[1] > -1.0 || X[0].abs() == 1.0);
    let mut block = Body::new(mesh, law.clone());
    block.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let mesh = of_order(disc(0.3, 24, 3, 0.02).expect("mesh"), order);
    let mut disc = Body::new(mesh.translated([0.1, 0.3]).expect("moved"), law);
    disc.prescribe_all([Some(0.0), Some(-0.03)])
        .expect("support");

    let mut scene = pair((block, "skin"), (disc, "boundary")).expect("pair");
    scene.reach = Some(0.25);
    scene
}

/// A cube of rigid motion pressed obliquely into a larger block, all of which may be touched.
fn cube_on_block<M: Material<3>>(law: M, order: Order) -> Scene<3> {
    let mesh = cuboid([0.0; 3], [1.0, 1.1, 0.6], [3, 3, 2]).expect("mesh");
    let mut mesh = of_order(mesh, order);
    mesh.name_boundary("skin", |_| true);
    let mut block = Body::new(mesh, law.clone());
    block.prescribe("bottom", [Some(0.0); 3]).expect("support");
    let mesh = cuboid([0.23, 0.31, 0.61], [0.4; 3], [2; 3]).expect("mesh");
    let mut cube = Body::new(of_order(mesh, order), law);
    cube.prescribe_all([Some(0.01), Some(0.005), Some(-0.04)])
        .expect("support");

    let mut scene = pair((block, "skin"), (cube, "bottom")).expect("pair");
    scene.reach = Some(0.2);
    scene
}

/// The Gauss points that a scene has by default.
fn integration<const D: usize>(scene: &Scene<D>) -> Integration {
    let is_quadratic = |body: &Body<D>| body.mesh().order() == Order::Quadratic;
    if D == 2 {
        return Integration::Exact;
    }
    Integration::Gauss(match (scene.bodies().iter().any(is_quadratic), D) {
        (false, _) => 4,
        (true, 2) => 12,
        (true, _) => 8,
    })
}

/// A problem of which nothing is left out: prescribed dofs are unknowns between equal bounds, cells
/// that cannot deform are assembled, no row is out of reach, the stiffness is evaluated in every
/// iteration, and rows are never taken for exact.
struct Full<'a, const D: usize> {
    lean: &'a Problem<D>,
    integration: Integration,
    energy: DirectSum<Changing<D>>,
    /// Nothing is prescribed.
    dofs: DofMap,
    bounds: Bounds,
    factor: f64,
}

/// An energy that does not tell that its Hessian is constant if it is.
struct Changing<const D: usize>(Box<dyn BodyEnergy<D>>);

impl<const D: usize> Energy for Changing<D> {
    fn dofs(&self) -> usize {
        self.0.dofs()
    }
    fn value(&self, u: &[f64]) -> f64 {
        self.0.value(u)
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        self.0.gradient(u, g);
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        self.0.hessian_pattern()
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        self.0.hessian(u, values);
    }
    fn domain_len(&self) -> usize {
        self.0.domain_len()
    }
    fn domain(&self, u: &[f64], d: &mut [f64]) {
        self.0.domain(u, d);
    }
}

impl<'a, const D: usize> Full<'a, D>
where
    P1: Element<D>,
    P2: Element<D>,
{
    fn new<M: Material<D>>(lean: &'a Problem<D>, law: &M) -> Self {
        let energy = |body: &Body<D>| {
            let (mesh, law, forces) = (body.mesh(), law.clone(), body.forces().to_vec());
            let dofs = DofMap::new(&vec![false; forces.len()]);
            Changing(match mesh.order() {
                Order::Linear => Box::new(StrainEnergy::<D, P1, M>::new(
                    mesh,
                    law,
                    dofs,
                    vec![],
                    forces,
                )),
                Order::Quadratic => Box::new(StrainEnergy::<D, P2, M>::new(
                    mesh,
                    law,
                    dofs,
                    vec![],
                    forces,
                )),
            })
        };
        let scene = lean.scene();
        let n = lean.dofs().len();
        Full {
            integration: integration(scene),
            energy: DirectSum::new(scene.bodies().iter().map(energy).collect()),
            dofs: DofMap::new(&vec![false; n]),
            bounds: Bounds::free(n),
            factor: 0.0,
            lean,
        }
    }
}

impl<const D: usize> ContactProblem for Full<'_, D> {
    fn energy(&self) -> &dyn Energy {
        &self.energy
    }

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn scale(&self) -> Option<Scale> {
        Some(self.lean.scale())
    }

    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        let X = self.lean.reference();
        let moved = X.iter().zip(u.chunks_exact(D));
        let moved: Vec<_> = moved
            .map(|(X, u)| X + Vector::from_column_slice(u))
            .collect();
        let x = if self.lean.is_exact() { X } else { &moved };
        let surfaces = self.lean.surfaces();
        let masters: Vec<_> = surfaces
            .iter()
            .map(|s| Master::new(s, x, Projection::AlongNormals))
            .collect();
        let unknowns = Unknowns {
            dofs: &self.dofs,
            supports: self.lean.dofs(),
            prescribed: &[],
        };
        let mut gaps = LinearGaps::new(false);
        for (k, pass) in self.lean.passes().iter().enumerate() {
            let (slave, master) = (&surfaces[pass.slave], &masters[pass.master]);
            let reach = f64::INFINITY;
            let points = projected(slave, master, x, self.integration, reach);
            let rows = PassRows::new(slave, master, &points, sampling);
            rows.append(k as u32, X, &unknowns, &mut gaps);
        }
        Ok(gaps)
    }
}

impl<const D: usize> LoadStepped for Full<'_, D> {
    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        self.factor = factor;
        let energies = self.energy.parts_mut().iter_mut();
        energies.for_each(|energy| energy.0.set_load(factor));
        let bodies = self.lean.scene().bodies().iter();
        for (dof, value) in bodies.flat_map(|body| body.prescribed()).enumerate() {
            if let Some(value) = value {
                self.bounds.lower[dof] = factor * value;
                self.bounds.upper[dof] = factor * value;
            }
        }
        Ok(())
    }

    fn lift(&self, u: &[f64], from: f64) -> Vec<f64> {
        let mut lifted = u.to_vec();
        let bodies = self.lean.scene().bodies().iter().zip(self.energy.parts());
        for (k, (body, energy)) in bodies.enumerate() {
            let is_prescribed: Vec<bool> = body.prescribed().iter().map(Option::is_some).collect();
            let full = body.prescribed().iter().flatten();
            let increments: Vec<f64> = full.map(|p| p * (self.factor - from)).collect();
            let extension = energy.0.extend(&DofMap::new(&is_prescribed), &increments);
            let own = &mut lifted[self.energy.range(k)];
            own.iter_mut().zip(extension).for_each(|(u, v)| *u += v);
        }
        lifted
    }
}

impl<const D: usize> Full<'_, D> {
    fn outcome(&self, run: &Run) -> Outcome<D> {
        let solution = run.solution.as_ref().expect("converged");
        let u = &solution.state.u;
        let mut contact = vec![0.0; u.len()];
        solution.gaps.add_forces(&solution.lambda, &mut contact);
        let own = self.energy.range(0);
        let mut residual = vec![0.0; own.len()];
        let energies = self.energy.parts();
        energies[0].0.add_residual(&u[own], &mut residual);
        let mut reaction = Vector::zeros();
        let prescribed = self.lean.scene().bodies()[0].prescribed().iter();
        for (dof, _) in prescribed.enumerate().filter(|(_, value)| value.is_some()) {
            reaction[dof % D] += residual[dof] - contact[dof];
        }
        let nodal = |values: &[f64]| -> Vec<Vector<D>> {
            let nodes = values.chunks_exact(D);
            nodes.map(Vector::from_column_slice).collect()
        };
        let cost = run.cost();
        let solves = run.attempts.iter().map(|a| a.iterations.len());
        Outcome {
            displacements: nodal(u),
            energy: solution.energy,
            reaction,
            contact: nodal(&contact).iter().map(|force| force.norm()).sum(),
            rows: solution.gaps.len(),
            solves: solves.max().unwrap_or(0),
            left_out: LeftOut {
                dofs: self.lean.dofs().len() - self.energy.dofs(),
                cells: {
                    let all = self
                        .lean
                        .scene()
                        .bodies()
                        .iter()
                        .map(|body| body.mesh().len());
                    let assembled = energies.iter().map(|energy| energy.0.assembled_cells());
                    all.sum::<usize>() - assembled.sum::<usize>()
                },
                rows: self.lean.contact_nodes() - solution.gaps.len(),
                passes: 0,
                repeating: 0,
                solves: 0,
                factorizations: 0,
                hessians: cost.inner_iterations.saturating_sub(cost.hessians),
            },
        }
    }
}

/// Where rows are about to open, displacements follow the root of what is left of gap times force.
fn method() -> InteriorPoint {
    InteriorPoint {
        complementarity: 1e-14,
        ..InteriorPoint::default()
    }
}

const TOLERANCE: f64 = 1e-11;

/// The scene walked to full load, by all means that save work.
fn lean<const D: usize>(problem: &mut Problem<D>, increments: usize) -> Outcome<D> {
    let history = run_with(&mut method(), problem, increments, TOLERANCE);
    assert!(history.is_complete(), "{}", history.run.ending);
    let step = history.steps.last().expect("converged");
    let solution = history.run.solution.as_ref().expect("converged");
    let contact = problem.contact_forces(&solution.gaps, &solution.lambda);
    // a set of trees for every iteration, one for every step's result, one for the check at the start
    let iterations = history.run.attempts.iter().map(|a| a.iterations.len());
    let states = match problem.is_exact() {
        true => 1,
        false => iterations.clone().sum::<usize>() + history.run.attempts.len() + 1,
    };
    assert!(problem.searches_built() <= states, "{states}");
    Outcome {
        displacements: problem.displacements(&history.run.state.u),
        energy: step.energy,
        reaction: step.reaction(0),
        contact: contact.iter().map(|force| force.norm()).sum(),
        rows: step.rows,
        solves: iterations.max().unwrap_or(0),
        left_out: LeftOut::new(problem, &history),
    }
}

/// The same with nothing left out.
fn full<const D: usize, M: Material<D>>(
    problem: &Problem<D>,
    law: &M,
    increments: usize,
) -> Outcome<D>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let mut problem = Full::new(problem, law);
    let start = State {
        u: vec![0.0; problem.energy.dofs()],
        ..State::default()
    };
    let load_steps = LoadSteps {
        increments,
        ..LoadSteps::default()
    };
    let mut solver = Retry::with(method());
    solver.fixed_point.tolerance = TOLERANCE;
    let run = load_steps.run(&mut problem, &mut solver, start, |_| {
        ControlFlow::Continue(())
    });
    let run = run.expect("no misuse");
    assert_eq!(run.ending, Ending::Complete);
    problem.outcome(&run)
}

struct Outcome<const D: usize> {
    displacements: Vec<Vector<D>>,
    energy: f64,
    reaction: Vector<D>,
    /// Σ |Cᵀλ| over the nodes, which a body that touches itself has, too.
    contact: f64,
    rows: usize,
    /// The most solves of an attempt.
    solves: usize,
    left_out: LeftOut,
}

fn same<const D: usize>(a: &Outcome<D>, b: &Outcome<D>) {
    let all = a.displacements.iter();
    let largest = all.map(|u| u.amax()).fold(0.0, f64::max);
    for (u, v) in a.displacements.iter().zip(&b.displacements) {
        assert!((u - v).amax() < 1e-10 * largest, "{u} {v}");
    }
    assert!(relative(a.energy, b.energy) < 1e-10);
    assert!(relative(a.contact, b.contact) < 1e-10);
    // of one body alone nothing is left of it
    let error = (a.reaction - b.reaction).norm();
    let force = match a.reaction.norm() < 1e-10 * a.contact {
        true => a.contact,
        false => a.reaction.norm(),
    };
    assert!(error < 1e-10 * force, "{error}");
}

/// Both ways, with the same result.
fn lean_and_full<const D: usize, M: Material<D>>(
    scene: Scene<D>,
    law: M,
    increments: usize,
) -> [Outcome<D>; 2]
where
    P1: Element<D>,
    P2: Element<D>,
{
    let mut problem = scene.problem().expect("valid scene");
    let lean = lean(&mut problem, increments);
    let full = full(&problem, &law, increments);
    same(&lean, &full);
    assert_eq!((full.left_out.dofs, full.left_out.cells), (0, 0));
    assert_eq!(full.left_out.hessians, 0);
    assert!(full.solves > 1, "even exact rows are seen not to change");
    [lean, full]
}

#[test]
fn a_small_strain_scene_leaves_out_most() {
    let law = LinearElastic::new(10.0, 0.3).expect("law");
    let [lean, full] = lean_and_full(disc_on_block(law, Order::Linear), law, 1);
    let LeftOut {
        dofs,
        cells,
        rows,
        passes,
        repeating,
        solves,
        factorizations,
        hessians,
    } = lean.left_out;
    // 13 nodes below, and the disc's 1 + 3 · 24 nodes with its 24 · 5 cells
    assert_eq!((dofs, cells), (2 * (13 + 73), 120));
    assert_eq!((solves, lean.solves), (1, 1));
    assert_eq!((passes, repeating, factorizations), (0, 0, 0));
    assert!(rows > 20 && hessians > 5, "{:?}", lean.left_out);
    // what is left are rows of points that face away or are off an end
    assert!(full.left_out.rows < rows);
}

#[test]
fn so_does_one_of_large_strains() {
    let law = NeoHookean::new(10.0, 0.3).expect("law");
    let [lean, _] = lean_and_full(disc_on_block(law, Order::Linear), law, 2);
    assert_eq!(lean.left_out.cells, 120);
    assert_eq!(lean.left_out.solves, 0);
}

#[test]
fn so_do_quadratic_elements() {
    let order = Order::Quadratic;
    let linear = LinearElastic::new(10.0, 0.3).expect("law");
    let large = NeoHookean::new(10.0, 0.3).expect("law");
    let scenes = [
        lean_and_full(disc_on_block(linear, order), linear, 1),
        lean_and_full(disc_on_block(large, order), large, 2),
    ];
    for [lean, full] in scenes {
        assert_eq!(lean.left_out.cells, 120);
        assert!(lean.rows < full.rows);
    }
}

#[test]
fn so_do_scenes_in_space() {
    for order in [Order::Linear, Order::Quadratic] {
        let linear = LinearElastic::new(10.0, 0.3).expect("law");
        let large = NeoHookean::new(10.0, 0.3).expect("law");
        let scenes = [
            lean_and_full(cube_on_block(linear, order), linear, 1),
            lean_and_full(cube_on_block(large, order), large, 2),
        ];
        for [lean, full] in scenes {
            assert_eq!(lean.left_out.cells, 6 * 8);
            assert!(lean.rows > 3 && full.reaction.norm() > 0.01);
        }
    }
}

/// A hairpin whose arms meet: out of reach is most of it, and itself behind its own material.
#[test]
fn so_does_a_body_that_touches_itself() {
    let law = NeoHookean::new(1e3, 0.3).expect("the hairpin's law");
    let [lean, full] = lean_and_full(hairpin::scene(2, true).expect("scene"), law, 8);
    assert!(lean.rows > 5 && lean.rows < full.rows, "{}", lean.rows);
    assert!(lean.left_out.dofs > 0);
}

#[test]
fn no_pair_no_rows() {
    let mesh = rectangle(
        &linspace(0.0, 1.0, 3),
        &linspace(0.0, 1.0, 3),
        Diagonals::Rising,
    );
    let mut block = Body::new(
        mesh.expect("mesh"),
        NeoHookean::new(10.0, 0.3).expect("law"),
    );
    block.prescribe("bottom", [Some(0.0); 2]).expect("support");
    block.traction("top", [0.0, -1.0]).expect("load");
    let mut problem = alone(block).problem().expect("valid scene");
    assert_eq!(problem.contact_nodes(), 0);
    let history = run_with(&mut InteriorPoint::default(), &mut problem, 1, 1e-6);
    let step = history.steps.last().expect("converged");
    assert_eq!((step.rows, step.attempt.iterations.len()), (0, 1));
}

/// Rows that are integration points are not counted as if they were contact nodes.
#[test]
fn nodes_without_a_row_are_counted_whatever_the_rows_are() {
    let law = LinearElastic::new(10.0, 0.3).expect("law");
    let rows = |method: &mut dyn Method| {
        let scene = disc_on_block(law, Order::Linear);
        let mut problem = scene.problem().expect("valid scene");
        let history = run_with(method, &mut problem, 1, 1e-6);
        assert!(history.is_complete(), "{}", history.run.ending);
        LeftOut::new(&problem, &history).rows
    };
    let of_nodes = rows(&mut InteriorPoint::default());
    assert!(of_nodes > 0);
    assert_eq!(rows(&mut Penalty::default()), of_nodes);
}

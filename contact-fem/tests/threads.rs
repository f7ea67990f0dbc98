//! Threads do not change a bit: two blocks pressed on each other, solved on pools of one, two and three threads. On a
//! pool of one, assembly and search take the path that they take without the feature.

use contact_core::{
    Condensed, CondensedNewton, ContactProblem, Equilibrium, LoadStepped, Outcome, State,
};
use contact_fem::mesh::generators::cuboid;
use contact_fem::{Body, LinearElastic, Material, NeoHookean, Scene};

/// Two blocks of so many cells that all of assembly but the sum of E is shared among threads.
const CELLS: [usize; 3] = [14, 14, 4];

/// The bits of what one solve finds: u, λ, E, ∇E, ∇²E and the domain functions.
fn bits(law: impl Material<3>, solver: &mut dyn Equilibrium) -> Vec<u64> {
    let block = |z: f64, cells: [usize; 3]| {
        let mesh = cuboid([0.0, 0.0, z], [3.0, 3.0, 1.0], cells);
        Body::new(mesh.expect("cells"), law.clone())
    };
    let mut lower = block(0.0, CELLS);
    let mut upper = block(1.0, CELLS.map(|n| n + 1));
    lower.prescribe("bottom", [Some(0.0); 3]).expect("bottom");
    upper
        .prescribe("top", [Some(0.02), None, Some(-0.1)])
        .expect("top");
    upper
        .prescribe_nodes(&[0], [None, Some(0.0), None])
        .expect("a node");
    let mut scene = Scene::new();
    let lower = scene.add("lower", lower).on("top");
    let upper = scene.add("upper", upper).on("bottom");
    scene.contact(lower, upper).expect("a pair");
    let mut problem = scene.problem().expect("a problem");
    problem.set_load(1.0).expect("a load");

    let energy = problem.energy();
    assert!(energy.blocks().len() == 2);
    let start = State {
        u: vec![0.0; energy.dofs()],
        ..State::default()
    };
    let solution = solver.solve_from(&problem, start).expect("no misuse");
    assert_eq!(solution.outcome, Outcome::Converged);
    assert!(solution.lambda.iter().any(|l| *l > 0.0), "no contact");
    let u = &solution.state.u;
    let mut gradient = vec![0.0; energy.dofs()];
    let mut hessian = vec![0.0; energy.hessian_pattern().len()];
    let mut domain = vec![0.0; energy.domain_len()];
    energy.gradient(u, &mut gradient);
    energy.hessian(u, &mut hessian);
    energy.domain(u, &mut domain);
    let value = [energy.value(u)];
    let all = [
        u,
        &solution.lambda,
        &gradient,
        &hessian,
        &domain,
        &value[..],
    ];
    all.concat().into_iter().map(f64::to_bits).collect()
}

fn same_on_pools(bits: impl Fn() -> Vec<u64> + Send + Sync) {
    let [one, two, three] = [1, 2, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads").install(&bits)
    });
    assert!(one == two, "two threads");
    assert!(one == three, "three threads");
}

#[test]
fn newtons_method() {
    let law = NeoHookean::new(100.0, 0.3).expect("valid");
    same_on_pools(|| bits(law, &mut CondensedNewton::default()));
}

#[test]
fn static_condensation() {
    let law = LinearElastic::new(100.0, 0.3).expect("valid");
    same_on_pools(|| bits(law, &mut Condensed::new()));
}

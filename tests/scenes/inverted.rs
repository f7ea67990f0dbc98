//! Cells that are inverted between their quadrature points.

use contact_fem::Simulation;
use contact_fem::certificate::{Condition, Limits};
use contact_fem::element::{Element, P2};
use contact_fem::model::Problem;
use contact_fem::tensor::{Matrix, Vector};
use ipopt_contact_scenes::disc_in_disc::{Fineness, Roles, quadratic_scene};

/// The smallest det F at a grid of points of all cells, with nodes, from F = I + Σ u ⊗ ∇N.
fn sampled(problem: &Problem<2>, u: &[f64], n: usize) -> f64 {
    let U = problem.displacements(u);
    let mut least = f64::INFINITY;
    for (body, id) in problem.scene().bodies().iter().zip(problem.scene().ids()) {
        let (mesh, first) = (body.mesh(), problem.first_node(id));
        for cell in mesh.cells() {
            for (i, j) in (0..=n).flat_map(|j| (0..=n - j).map(move |i| (i, j))) {
                let xi = Vector::<2>::new(i as f64, j as f64) / n as f64;
                let dN = <P2 as Element<2>>::shape_gradients(&xi);
                let (mut dX, mut du) = (Matrix::<2>::zeros(), Matrix::<2>::zeros());
                for (&a, dN) in cell.iter().zip(&dN) {
                    dX += mesh.nodes()[a] * dN.transpose();
                    du += U[first + a] * dN.transpose();
                }
                let F = Matrix::<2>::identity() + du * dX.try_inverse().expect("a cell");
                least = least.min(F.determinant());
            }
        }
    }
    least
}

/// The disc-in-disc with coarse quadratic cells: J is positive at all quadrature points, and negative at nodes
/// where the disc presses the corner of a cell. The energy does not see that, and the run is complete; the certificate and the summary
/// tell it.
#[test]
fn a_cell_inverted_at_its_nodes() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("inverted");
    for (segments, is_inverted) in [(16, true), (32, false)] {
        let scene = quadratic_scene(Fineness::scaled(segments), Roles::default()).expect("scene");
        let mut problem = scene.problem().expect("problem");
        let mut simulation = Simulation::with_increments(10);
        let mut recording = simulation.record(&folder);
        (recording.plan.quiet, recording.plan.vtu_every) = (true, 0);
        let history = recording.run(&mut problem).expect("run").history;
        assert!(history.is_complete());
        for step in &history.steps {
            let bound = step.min_j_bound();
            assert!(step.min_j > 0.1 && bound <= step.min_j);
            let inverted = step.certificate.left(Condition::Inverted);
            assert_eq!(inverted > Some(0.0), bound <= 0.0, "load {}", step.factor);
            assert_eq!(step.certificate.holds(&Limits::default()), bound > 0.0);
        }
        let (last, u) = (history.last().expect("converged"), &history.run.state.u);
        let bound = last.min_j_bound();
        assert_eq!(bound <= 0.0, is_inverted, "{segments}: {bound}");
        let least = sampled(&problem, u, 40);
        assert!(bound <= least + 1e-9, "{segments}: {bound} for {least}");
        // the grid has the nodes, where the least J is here
        assert!((least - bound).abs() < 0.011 * least.abs());

        let text = std::fs::read_to_string(folder.join("summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(summary["min_j_bound"].as_f64(), Some(bound));
        let told = &summary["inverted"];
        match last.least_volume.filter(|_| is_inverted) {
            Some(least) => {
                assert_eq!(told["body"], "ring");
                assert_eq!(told["cell"].as_u64(), Some(least.cell as u64));
                assert_eq!(told["load_factor"], 1.0);
                let reason = summary["reason"].as_str().expect("a reason");
                assert!(reason.contains("certificate does not hold"), "{reason}");
            }
            None => assert!(told.is_null()),
        }
    }
}

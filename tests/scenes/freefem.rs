//! Our results against those that FreeFEM's scripts left on the same meshes.

use std::path::Path;

use ipopt_contact::contact_core::ContactProblem;
use ipopt_contact::prelude::*;

use ipopt_contact_scenes::beams::YOUNG;
use ipopt_contact_scenes::freefem::cases::{Built, CASES, Case, Size};
use ipopt_contact_scenes::freefem::outcome::Outcome;
use ipopt_contact_scenes::freefem::reference::Reference;
use ipopt_contact_scenes::freefem::solve::solve;

/// Energy to 1e-6, displacement and reaction to 1e-5, relative; pressure to what [`apart`] allows, where the
/// script leaves at most `left` of gap times force (UF·UL) at a row.
fn agrees(name: &str, size: Size, left: f64) {
    let case = Case::named(name).expect("a scene");
    let reference = Reference::read(case, size).expect("readable");
    let reference = reference.expect("stored");
    assert_eq!(reference.tolerance, case.tolerance);
    let theirs = reference.outcome(case);
    assert!(theirs.converged(), "FreeFEM's script converged");

    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    solve(case, size, &folder).expect("solved");
    let ours = Outcome::read(case, &folder).expect("complete");
    assert!(ours.converged());
    let increments = size.of(case.increments) as f64;
    assert_eq!(theirs.value("increments"), increments);
    assert_eq!(ours.value("increments"), increments);

    let energy = ours.energy_difference(&theirs);
    assert!(energy < 1e-6, "energy off by {energy:.1e}");
    let displacement = reference.displacement_difference(case, &ours.displacements);
    assert!(
        displacement < 1e-5,
        "displacement off by {displacement:.1e}"
    );
    let reaction = ours.reaction_difference(&theirs);
    assert!(reaction < 1e-5, "reaction off by {reaction:.1e}");
    let nodes = |outcome: &Outcome| -> Vec<Vec<usize>> {
        let pressures = outcome.pressures.iter();
        pressures.map(|all| all.keys().copied().collect()).collect()
    };
    assert_eq!(nodes(&theirs), nodes(&ours), "nodes with a pressure");
    let allowed = pressure_tolerance(case, size, &theirs, left);
    // a looser bound would say nothing
    assert!(allowed < 0.1, "pressures are compared to {allowed:.1e}");
    let pressure = ours.pressure_difference(&theirs);
    assert!(
        pressure < allowed,
        "pressure off by {pressure:.1e}, {allowed:.1e} are left"
    );
}

/// How far pressures may be apart, relative to the largest one.
fn pressure_tolerance(case: &Case, size: Size, theirs: &Outcome, left: f64) -> f64 {
    let pressures = || theirs.pressures.iter().flat_map(|all| all.values());
    let rows = pressures().count() as f64;
    let apart = match case.scene(size).expect("a scene") {
        Built::Plane(scene) => apart(&scene.problem().expect("a problem"), rows, left),
        Built::Space(scene) => apart(&scene.problem().expect("a problem"), rows, left),
    };
    apart / pressures().fold(0.0, |m: f64, p| m.max(p.abs()))
}

/// How far pressures of two solvers may be apart (UF/UL²), from what they leave of gap times force, at most τ at
/// each of m rows. The energy is then within mτ of its minimum, and nodal forces are off by δf with
///
/// ```text
/// ½ δfᵀ K⁻¹ δf ≤ mτ,   |δf| ≤ √(2 k mτ),   |δp| ≤ D(D + 1)/a |δf|,
/// ```
///
/// with k ≥ the largest eigenvalue of the stiffness K, here the largest row sum of |K| before any load, and a/(D(D + 1))
/// ≤ the smallest eigenvalue of the surfaces' mass matrix, a the measure of the smallest facet. All of it may be at one
/// node. At large strains K changes, and this is an estimate.
fn apart<const D: usize>(problem: &Problem<D>, rows: f64, theirs: f64) -> f64 {
    let scale = problem.scale();
    let method = InteriorPoint::default();
    let share = method.complementarity * (scale.resolution / scale.length).powi(2);
    let ours = share.min(method.tolerance) * scale.energy;
    let forces = |left: f64| (2.0 * stiffness(problem) * rows * left).sqrt();
    (D * (D + 1)) as f64 / scale.area * (forces(ours) + forces(theirs))
}

/// The largest row sum of |K| (UF/UL).
fn stiffness<const D: usize>(problem: &Problem<D>) -> f64 {
    let energy = problem.energy();
    let pattern = energy.hessian_pattern();
    let mut values = vec![0.0; pattern.len()];
    energy.hessian(&vec![0.0; energy.dofs()], &mut values);
    let mut sums = vec![0.0; energy.dofs()];
    for (k, value) in values.iter().enumerate() {
        let (row, column) = (pattern.rows()[k], pattern.cols()[k]);
        sums[row] += value.abs();
        if row != column {
            sums[column] += value.abs();
        }
    }
    sums.into_iter().fold(0.0, f64::max)
}

#[test]
fn the_disc_in_disc_agrees() {
    agrees("disc_in_disc", Size::Tiny, 1e-10);
}

#[test]
fn the_beams_agree_at_small_strains() {
    agrees("beams_small_strain", Size::Tiny, 1e-11 * YOUNG);
}

#[test]
fn the_neo_hookean_beams_agree() {
    agrees("beams_neo_hookean", Size::Tiny, 1e-11 * YOUNG);
}

/// The terms of λ, which the others do not have.
#[test]
fn the_neo_hookean_beams_with_poissons_ratio_agree() {
    agrees("beams_poisson", Size::Tiny, 1e-11 * YOUNG);
}

#[test]
fn hertz_agrees() {
    agrees("hertz", Size::Tiny, 1e-13 * 70.0);
}

#[test]
fn the_arch_agrees() {
    agrees("arch", Size::Tiny, 1e-12 * 1000.0);
}

#[test]
fn every_stored_result_belongs_to_a_scene() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("freefem/reference");
    let mut stored = 0;
    for entry in folder.read_dir().expect("a folder") {
        let name = entry.expect("an entry").file_name();
        let name = name.to_string_lossy();
        let belongs = CASES.iter().any(|case| name.starts_with(case.name));
        assert!(belongs && name.ends_with(".json"), "{name}");
        stored += 1;
    }
    assert!(stored > 0);
}

//! Our results against those that FreeFEM's scripts left on the same meshes.

use std::path::Path;

use crate::support::freefem::cases::{CASES, Case, Size};
use crate::support::freefem::outcome::Outcome;
use crate::support::freefem::reference::Reference;
use crate::support::freefem::solve::solve;

/// Energy to 1e-6 and displacement to 1e-5, relative.
fn agrees(name: &str, size: Size) {
    let case = Case::named(name).expect("a scene");
    let reference = Reference::read(case, size).expect("readable");
    let reference = reference.expect("stored");
    assert_eq!(reference.tolerance, case.tolerance);
    let theirs = reference.outcome();
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
}

#[test]
fn the_disc_in_disc_agrees() {
    agrees("disc_in_disc", Size::Tiny);
}

#[test]
fn the_beams_agree_at_small_strains() {
    agrees("beams_small_strain", Size::Tiny);
}

#[test]
fn the_neo_hookean_beams_agree() {
    agrees("beams_neo_hookean", Size::Tiny);
}

#[test]
fn hertz_agrees() {
    agrees("hertz", Size::Tiny);
}

#[test]
fn the_arch_agrees() {
    agrees("arch", Size::Tiny);
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

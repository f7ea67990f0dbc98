//! The units of a scene, in which its numbers are O(1), estimated before any solve.

use contact_core::Scale;

use super::{Body, Geometry, Scene};
use crate::assembly::BodyEnergy;

/// A lower bound of the estimated strain for laws that are not linear: smaller strains are lost to
/// round-off in F = I + ∇u. The length, resolution and energy scales depend on it.
const SMALLEST_STRAIN: f64 = 1e-9;
/// The resolution of gaps in [`Geometry::Reference`], as a share of the expected displacement of a
/// facet; in [`Geometry::Current`] the share is 1.
const FINER: f64 = 0.03;
/// The safety factor (no unit) of the estimated displacements.
const MARGIN: f64 = 10.0;
/// The estimated strain of a scene without loads and prescribed displacements.
const UNLOADED: f64 = 1e-6;

/// The units of a scene with diagonal `length`, smallest contact facet `facet` and an `overlap` that the load resolves (UL).
///
/// The length scale is the expected displacement over the whole scene, the resolution that of a
/// facet, and the energy scale that of the softest body at this displacement.
pub(super) fn estimate<const D: usize>(
    scene: &Scene<D>,
    geometry: Geometry,
    energies: &[Box<dyn BodyEnergy<D>>],
    (length, facet): (f64, f64),
    overlap: f64,
) -> Scale {
    let stiffness = softest(energies);
    let expected = expected_strain(scene, stiffness, (length, facet), overlap);
    let strain = match scene.bodies().iter().all(Body::is_small_strain) {
        true => expected,
        false => expected.max(SMALLEST_STRAIN),
    };
    let finer = match geometry {
        Geometry::Reference => FINER,
        Geometry::Current => 1.0,
    };
    Scale {
        length: strain * length,
        resolution: strain * facet * finer,
        area: facet.powi(match scene.is_of_revolution() {
            true => 2,
            false => D as i32 - 1,
        }),
        roundoff: f64::EPSILON / strain, // strains are differences of F and I
        energy: stiffness * (strain * length).powi(2),
    }
}

/// What is round-off of a scene with this scale: a length (UL), a force (UF) and an energy (UF·UL). Gradients are known up to
/// [`Scale::roundoff`], and sums of many of them to some digits less.
pub(crate) fn negligible(scale: &Scale) -> [f64; 3] {
    /// By how much sums exceed the round-off of their terms.
    const SUMS: f64 = 100.0;
    let share = SUMS * scale.roundoff;
    [scale.length, scale.energy / scale.length, scale.energy].map(|of| share * of)
}

/// The typical stiffness (UF/UL) of the softest body that has free unknowns. With the scale of a
/// stiffer body, the forces in the softer one would be smaller than the tolerances.
fn softest<const D: usize>(energies: &[Box<dyn BodyEnergy<D>>]) -> f64 {
    let all = energies.iter().map(|e| e.typical_stiffness());
    let softest = all.filter(|k| *k > 0.0).fold(f64::INFINITY, f64::min);
    if softest.is_finite() { softest } else { 1.0 }
}

/// The expected displacement divided by the scene's `length`, at most 1: [`MARGIN`] times the
/// largest prescribed displacement or resolved overlap, or the extension of a bar of the given stiffness under the
/// loads. The scales are proportional to the loads, so that the solutions of linear scenes are as
/// well, however small the loads are.
fn expected_strain<const D: usize>(
    scene: &Scene<D>,
    stiffness: f64,
    (length, facet): (f64, f64),
    overlap: f64,
) -> f64 {
    let bodies = || scene.bodies().iter();
    let force: f64 = bodies().map(|body| body.largest().1).sum();
    let prescribed = bodies().map(|body| body.largest().0).fold(0.0, f64::max);
    let prescribed = prescribed
        .max(scene.obstacle_way())
        .max(scene.longest_jump());
    let stretch = force / stiffness * (facet / length).powi(D as i32 - 2);
    match MARGIN * prescribed.max(overlap).max(stretch) / length {
        strain if strain > 0.0 => strain.min(1.0),
        _ => UNLOADED,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
    use crate::{LinearElastic, Material, NeoHookean};

    /// A block of 3 by 4, supported at the bottom and moved down by `by` on top.
    fn scene(law: impl Material<2>, by: f64) -> Scene<2> {
        let mesh = rectangle(
            &linspace(0.0, 3.0, 3),
            &linspace(0.0, 4.0, 4),
            Diagonals::Rising,
        );
        let mut body = Body::new(mesh.expect("mesh"), law);
        body.prescribe("bottom", [Some(0.0); 2]).expect("support");
        body.prescribe("top", [None, Some(-by)]).expect("support");
        let mut scene = Scene::new();
        scene.add("block", body);
        scene
    }

    fn pressed(law: impl Material<2>, by: f64) -> Scale {
        scene(law, by).problem().expect("a problem").scale()
    }

    #[test]
    fn lengths_are_ten_times_what_is_prescribed() {
        let law = |young| LinearElastic::new(young, 0.3).expect("law");
        let (one, half) = (pressed(law(1.0), 1e-3), pressed(law(1.0), 0.5e-3));
        assert!((one.length / 1e-2 - 1.0).abs() < 1e-14);
        assert!((half.length / 0.5e-2 - 1.0).abs() < 1e-14);
        assert!((one.energy / half.energy - 4.0).abs() < 1e-12);
        let stiff = pressed(law(7.0), 1e-3);
        assert!((stiff.energy / one.energy - 7.0).abs() < 1e-12);
        // no longer than the scene, and no shorter than a millionth of it where nothing moves
        assert_eq!(pressed(law(1.0), 0.9).length, 5.0);
        assert!((pressed(law(1.0), 0.0).length / 5e-6 - 1.0).abs() < 1e-14);
    }

    /// What a table prescribes after the load factor 1, or between 0 and 1 alone, counts as the same at full load.
    #[test]
    fn displacements_at_any_time_count() {
        let length = |pairs: &[(f64, f64)]| {
            let mesh = rectangle(
                &linspace(0.0, 3.0, 3),
                &linspace(0.0, 4.0, 4),
                Diagonals::Rising,
            );
            let law = LinearElastic::new(1.0, 0.3).expect("law");
            let mut block = Body::new(mesh.expect("mesh"), law);
            let table = crate::Amplitude::table(pairs).expect("a table");
            block
                .prescribe_in_time("top", [None, Some(-1e-3)], table)
                .expect("support");
            block.prescribe("bottom", [Some(0.0); 2]).expect("support");
            let mut scene = Scene::new();
            scene.add("block", block);
            scene.problem().expect("a problem").scale().length
        };
        for pairs in [
            [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)],
            [(0.0, 0.0), (1.0, 0.0), (2.0, 1.0)],
            [(0.0, 0.0), (0.33, 1.0), (0.66, 0.0)],
            [(0.0, 0.0), (1.5, 0.0), (1.51, 1.0)],
        ] {
            let found = length(&pairs);
            assert!((found / 1e-2 - 1.0).abs() < 1e-14, "{pairs:?}: {found}");
        }
    }

    #[test]
    fn strains_that_round_off_hides() {
        let length = |scene: Scene<2>| {
            let energies: Vec<_> = scene.bodies().iter().map(|body| body.energy()).collect();
            estimate(&scene, Geometry::Current, &energies, (5.0, 1.0), 0.0).length
        };
        let large = scene(NeoHookean::new(1.0, 0.3).expect("law"), 1e-12);
        assert!((length(large) / 5e-9 - 1.0).abs() < 1e-14);
        let linear = scene(LinearElastic::new(1.0, 0.3).expect("law"), 1e-12);
        assert!((length(linear) / 1e-11 - 1.0).abs() < 1e-14);
    }

    /// The energy is that of the softer block, and the round-off in strains of the size of what is
    /// expected: the length over the diagonal.
    #[test]
    fn the_softest_body_and_the_round_off_of_strains() {
        let of = |young: [f64; 2]| {
            let mut scene = Scene::new();
            for (k, young) in young.into_iter().enumerate() {
                let x = 6.0 * k as f64;
                let mesh = rectangle(
                    &linspace(x, x + 3.0, 3),
                    &linspace(0.0, 4.0, 4),
                    Diagonals::Rising,
                );
                let law = LinearElastic::new(young, 0.3).expect("law");
                let mut body = Body::new(mesh.expect("mesh"), law);
                body.prescribe("bottom", [Some(0.0); 2]).expect("support");
                body.prescribe("top", [None, Some(-1e-3)]).expect("support");
                scene.add(format!("block {k}"), body);
            }
            scene.problem().expect("a problem").scale()
        };
        let soft = of([1.0, 1.0]);
        assert!((soft.energy / of([1.0, 100.0]).energy - 1.0).abs() < 1e-12);
        assert!((soft.energy / of([100.0, 1.0]).energy - 1.0).abs() < 1e-12);
        let diagonal = 9.0f64.hypot(4.0);
        let strain = soft.length / diagonal;
        assert!((soft.roundoff / (f64::EPSILON / strain) - 1.0).abs() < 1e-12);
    }

    /// Cubes with faces of 2 by 2 squares, each of two triangles: a facet has an eighth of a unit's area.
    #[test]
    fn the_area_of_a_facet_in_space() {
        let cube = |z: f64| {
            let mesh = cuboid([0.0, 0.0, z], [1.0; 3], [2, 2, 2]).expect("mesh");
            let mut body = Body::new(mesh, LinearElastic::new(1.0, 0.3).expect("law"));
            let side = if z == 0.0 { "bottom" } else { "top" };
            body.prescribe(side, [Some(0.0); 3]).expect("support");
            body
        };
        let mut scene = Scene::new();
        let lower = scene.add("lower", cube(0.0)).on("top");
        let upper = scene.add("upper", cube(1.0)).on("bottom");
        scene.contact(lower, upper).expect("a pair");
        let scale = scene.problem().expect("a problem").scale();
        assert!((scale.area / 0.125 - 1.0).abs() < 1e-12, "{}", scale.area);
    }
}

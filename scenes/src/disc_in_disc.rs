//! The disc-in-disc scene of section 6.1: a disc inside a hollow disc is pushed down against its
//! wall.

use contact_fem::mesh::generators::{Diagonals, annulus, disc};
use contact_fem::model::Passes;
use contact_fem::{Body, BodyId, Error, Mesh, NeoHookean, Scene};

use crate::mirrored;

/// The displacement of the inner disc at full load (UL).
pub const PUSH: f64 = 1.125;

/// Energy and force at full load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FullLoad {
    /// Energy (UF·UL).
    pub energy: f64,
    /// The force on the disc (UF).
    pub force: f64,
}

/// The ends of [`Fineness::REFERENCE`] in 100 increments, with points as in the paper and the fixed point to 1e-8, to
/// all digits that README shows.
pub const ENDS: [(Passes, FullLoad); 3] = [
    (Passes::Both, full_load(965.2329, 2377.76)),
    (Passes::FirstIsSlave, full_load(963.41, 2366.97)),
    (Passes::SecondIsSlave, full_load(965.2329, 2377.91)),
];

/// The end with both passes, exact integration and feet at the closest points.
pub const EXACT_END: FullLoad = full_load(965.2273, 2377.605);

/// The end with both passes and default settings: exact integration along normals.
pub const DEFAULT_END: FullLoad = full_load(965.2109, 2377.53);

const fn full_load(energy: f64, force: f64) -> FullLoad {
    FullLoad { energy, force }
}

/// The fineness of the two meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fineness {
    /// The number of segments on the edge of the hole.
    pub hole: usize,
    /// The number of layers of cells from the hole to the outer edge.
    pub layers: usize,
    /// The number of segments on the edge of the inner disc.
    pub disc: usize,
}

impl Fineness {
    /// The mesh of the reference values: 1 588 triangles.
    pub const REFERENCE: Fineness = Fineness {
        hole: 64,
        layers: 12,
        disc: 52,
    };

    /// A mesh with `hole` segments on the edge of the hole, and the other numbers in the proportion
    /// of the reference mesh.
    pub fn scaled(hole: usize) -> Self {
        let reference = Self::REFERENCE;
        Fineness {
            hole,
            layers: (reference.layers * hole / reference.hole).max(1),
            disc: (reference.disc * hole / reference.hole).max(3),
        }
    }
}

/// The order of the bodies, and their roles.
#[derive(Clone, Copy, Debug, Default)]
pub struct Roles {
    /// Whether the inner disc is the first body.
    pub swapped: bool,
    /// The roles of the surfaces with the ring as the first body.
    pub passes: Passes,
}

impl Roles {
    /// The index of the ring.
    pub fn ring(self) -> BodyId {
        usize::from(self.swapped).into()
    }
}

/// The scene with both discs and their supports and contact pair.
pub fn scene(fineness: Fineness, roles: Roles) -> Result<Scene<2>, Error> {
    let laws = [NeoHookean::new(1000.0, 0.0)?, NeoHookean::new(2000.0, 0.3)?];
    pushed(meshes(fineness)?, laws, PUSH, roles)
}

/// As [`scene`], but with straight quadratic cells.
pub fn quadratic_scene(fineness: Fineness, roles: Roles) -> Result<Scene<2>, Error> {
    let laws = [NeoHookean::new(1000.0, 0.0)?, NeoHookean::new(2000.0, 0.3)?];
    let meshes = meshes(fineness)?.map(Mesh::quadratic);
    pushed(meshes, laws, PUSH, roles)
}

/// The ring and the disc.
fn meshes(fineness: Fineness) -> Result<[Mesh<2>; 2], Error> {
    // nodes are denser towards the hole, where the strains are largest
    let share = |k: usize| (k as f64 / fineness.layers as f64).powf(1.3);
    let radii: Vec<f64> = (0..=fineness.layers)
        .map(|k| 0.7 + 1.3 * share(k))
        .collect();
    let hollow = annulus(&radii, fineness.hole, Diagonals::Alternating)?;
    // every node of the inner disc is prescribed, so that it needs no interior nodes but the
    // centre; it is rotated by 0.03, so that its nodes do not coincide with those of the hole
    let inner = disc(0.6, fineness.disc, 1, 0.03)?;
    Ok([hollow, inner])
}

/// A coarse mesh with lengths scaled by `length` and moduli by `modulus`, pushed half as far.
pub fn in_units(length: f64, modulus: f64) -> Result<Scene<2>, Error> {
    let radii = [0.7, 0.8, 0.95, 1.2, 1.5, 2.0].map(|r| r * length);
    let hollow = annulus(&radii, 32, Diagonals::Alternating)?;
    let inner = disc(0.6 * length, 26, 1, 0.03)?;
    let law = |young: f64, nu| NeoHookean::new(young * modulus, nu);
    pushed(
        [hollow, inner],
        [law(1000.0, 0.2)?, law(2000.0, 0.3)?],
        0.6 * length,
        Roles::default(),
    )
}

/// The ring is supported on its outside; the disc is pushed down.
fn pushed(
    meshes: [Mesh<2>; 2],
    laws: [NeoHookean; 2],
    push: f64,
    roles: Roles,
) -> Result<Scene<2>, Error> {
    let ([hollow, inner], [first, second]) = (meshes, laws);
    let mut ring = Body::new(hollow, first);
    ring.prescribe("outer", [Some(0.0), Some(0.0)])?;
    let mut inner = Body::new(inner, second);
    inner.prescribe_all([Some(0.0), Some(-push)])?;

    let mut scene = Scene::new();
    let mut bodies = [("ring", ring, "inner"), ("disc", inner, "boundary")];
    let mut passes = roles.passes;
    if roles.swapped {
        bodies.reverse();
        passes = mirrored(passes);
    }
    let [first, second] = bodies.map(|(name, body, side)| scene.add(name, body).on(side));
    scene.contact_in_passes(first, second, passes)?;
    Ok(scene)
}

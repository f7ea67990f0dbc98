//! A soft disc that is pressed on a block and moved along it.

use contact_fem::mesh::generators::{Diagonals, disc, linspace, rectangle};
use contact_fem::tensor::Vector;
use contact_fem::{Body, Error, NeoHookean, Scene};

use crate::pair;

/// The disc's core goes down by this (UL); it starts 0.05 above the block.
pub const PRESSED: f64 = 0.15;
/// The disc's radius, and that of its core, whose nodes are held (UL).
const RADII: [f64; 2] = [0.5, 0.3];
/// The disc's centre (UL).
const CENTRE: [f64; 2] = [-1.0, 0.55];
/// Young's modulus (UF/UL²) and Poisson's ratio of both.
const MODULI: [f64; 2] = [1e3, 0.3];

/// The floor, 4 by 1, which is the first body, and the disc on it, whose core is moved by `along` and down by [`PRESSED`]. The floor's
/// height has `cells` of them, and all other lines as many in proportion: 6 cells are 24 facets on each surface.
///
/// # Errors
/// As the generators of meshes.
pub fn scene(cells: usize, along: f64) -> Result<Scene<2>, Error> {
    let (x, y) = (linspace(-2.0, 2.0, 4 * cells), linspace(-1.0, 0.0, cells));
    let mut mesh = rectangle(&x, &y, Diagonals::Alternating)?;
    mesh.name_boundary("all", |_| true);
    let mut floor = Body::new(mesh, NeoHookean::new(MODULI[0], MODULI[1])?);
    floor.prescribe("bottom", [Some(0.0); 2])?;
    let mesh = disc(RADII[0], 4 * cells, (2 * cells).div_ceil(3), 0.1)?;
    let mut mesh = mesh.translated(CENTRE)?;
    mesh.name_boundary("edge", |_| true);
    let nodes = mesh.nodes().iter().enumerate();
    let is_inside = |X: &Vector<2>| (X - Vector::from(CENTRE)).norm() < RADII[1];
    let core = nodes.filter(|(_, X)| is_inside(X)).map(|(a, _)| a);
    let core: Vec<usize> = core.collect();
    let mut roller = Body::new(mesh, NeoHookean::new(MODULI[0], MODULI[1])?);
    roller.prescribe_nodes(&core, [Some(along), Some(-PRESSED)])?;
    pair((floor, "all"), (roller, "edge"))
}

//! Two equal cantilevers on meshes that match, the upper one loaded: both bend as one, and each row of one pass is also
//! a row of the other.

use contact_fem::mesh::generators::cuboid;
use contact_fem::{Body, Error, LinearElastic, Scene};

/// The length (UL) of the cantilevers, whose section is a unit square.
pub const LENGTH: f64 = 10.0;
/// Young's modulus (UF/UL²).
pub const YOUNG: f64 = 1000.0;
/// Poisson's ratio.
pub const NU: f64 = 0.3;
/// The load on the top of the upper one (UF/UL²).
pub const LOAD: f64 = 0.01;

/// The cantilevers, clamped at x = 0, the lower one first, of so many cells along, across and in height.
///
/// # Errors
/// No cells.
pub fn scene(cells: [usize; 3]) -> Result<Scene<3>, Error> {
    let cantilever = |low: f64| -> Result<Body<3>, Error> {
        let mesh = cuboid([0.0, 0.0, low], [LENGTH, 1.0, 1.0], cells)?;
        let mut body = Body::new(mesh, LinearElastic::new(YOUNG, NU)?);
        body.prescribe("left", [Some(0.0); 3])?;
        Ok(body)
    };
    let (lower, mut upper) = (cantilever(0.0)?, cantilever(1.0)?);
    upper.traction("top", [0.0, 0.0, -LOAD])?;
    crate::pair((lower, "top"), (upper, "bottom"))
}

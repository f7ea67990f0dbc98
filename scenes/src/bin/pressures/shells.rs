//! Two concentric spherical shells under internal pressure, an eighth of them by symmetry: the contact pressure is constant.

use contact_fem::element::Order;
use contact_fem::mesh::generators::{extrude, linspace};
use contact_fem::model::InitialGaps;
use contact_fem::tensor::Vector;
use contact_fem::{Body, Error, LinearElastic, Mesh, Scene};

use ipopt_contact_scenes::tables::Table;
use ipopt_contact_scenes::{Failure, pair};

use super::rows::{COLUMNS, fields, order_name, row, solved};

/// The inner radius, that of the contact, and the outer one (UL).
const RADII: [f64; 3] = [1.0, 1.5, 2.0];
/// Young's modulus (UF/UL²) and Poisson's ratio of both.
const MODULI: [f64; 2] = [1e3, 0.3];
/// The pressure within (UF/UL²).
const WITHIN: f64 = 1.0;

/// Errors on both shells, those of meshes that match and of others, of at most `finest` facets on a quarter circle.
pub fn table(finest: usize) -> Result<Table, Failure> {
    let mut table = Table::new("shells", COLUMNS);
    let p = lame();
    for order in [Order::Linear, Order::Quadratic] {
        for facets in [[3, 3], [6, 6], [3, 4], [6, 8]] {
            // linear facets that do not match are apart by more than the pressure closes
            let is_apart = order == Order::Linear && facets[0] != facets[1];
            let is_large = order == Order::Quadratic && facets[1] > 6;
            if is_apart || is_large || facets.iter().any(|n| *n > finest) {
                continue;
            }
            let (problem, solution) = solved(scene(facets, order)?)?;
            let fields = fields(&problem, &solution)?;
            for (k, body) in ["inner", "outer"].iter().enumerate() {
                let [inner, outer] = facets;
                let mesh = format!("{inner} and {outer} facets a quarter circle");
                let body = format!("{}, {body}", order_name(order));
                let (one, all) = (|_: &Vector<3>| 1.0, |_: &Vector<3>| true);
                row(
                    &mut table,
                    [mesh, body],
                    &problem,
                    k,
                    &fields,
                    (p, &one, &all),
                );
            }
        }
    }
    Ok(table)
}

/// Lamé's pressure at the contact (UF/UL²), that of one shell without a joint: −σ_r = p a³ (c³/b³ − 1)/(c³ − a³).
fn lame() -> f64 {
    let [a, b, c] = RADII.map(|r| r.powi(3));
    WITHIN * a * (c / b - 1.0) / (c - a)
}

/// The inner shell, which is the first body, and the outer one, with so many facets on a quarter circle. Where these numbers differ, the
/// meshes overlap although the shells only touch.
///
/// # Errors
/// As the generators of meshes.
fn scene(facets: [usize; 2], order: Order) -> Result<Scene<3>, Error> {
    let shell = |k: usize| -> Result<Body<3>, Error> {
        let mesh = shell([RADII[k], RADII[k + 1]], facets[k], order)?;
        let mut body = Body::new(mesh, LinearElastic::new(MODULI[0], MODULI[1])?);
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let held = std::array::from_fn(|i| (i == axis).then_some(0.0));
            body.prescribe(name, held)?;
        }
        Ok(body)
    };
    let mut inner = shell(0)?;
    inner.traction_field("inside", |X| X * (WITHIN / X.norm()))?;
    let mut scene = pair((inner, "outside"), (shell(1)?, "inside"))?;
    scene.initial_gaps = InitialGaps::Adjust;
    Ok(scene)
}

/// A triangle of n² triangles, drawn out and projected on spheres around the origin. Boundaries: `x`, `y` and `z` in the planes of
/// symmetry, `inside` and `outside`.
fn shell([inner, outer]: [f64; 2], n: usize, order: Order) -> Result<Mesh<3>, Error> {
    let at = |i: usize, j: usize| j * (n + 1) - j * j.saturating_sub(1) / 2 + i;
    let rows = (0..=n).flat_map(|j| (0..=n - j).map(move |i| [i, j]));
    let nodes = rows.map(|node| node.map(|k| k as f64 / n as f64));
    let mut cells = Vec::new();
    for (i, j) in (0..n).flat_map(|j| (0..n - j).map(move |i| (i, j))) {
        cells.extend([at(i, j), at(i + 1, j), at(i, j + 1)]);
        if i + j + 1 < n {
            cells.extend([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    let triangle = Mesh::<2>::new(nodes.collect(), cells)?;
    let layers = n.div_ceil(2);
    let radii = linspace(inner, outer, layers);
    let mesh = extrude(&triangle, &radii, ["inside", "outside"])?;
    let mesh = match order {
        Order::Linear => mesh,
        Order::Quadratic => mesh.quadratic(),
    };
    let mut mesh = mesh.mapped(|X| {
        let flat = Vector::<3>::new(X[0], X[1], 1.0 - X[0] - X[1]);
        // exact zeros in the planes of symmetry
        let flat = flat.map(|x| if x.abs() < 1e-12 { 0.0 } else { x });
        flat * (X[2] / flat.norm())
    })?;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        mesh.name_boundary(name, |X| X[axis] == 0.0);
    }
    Ok(mesh)
}

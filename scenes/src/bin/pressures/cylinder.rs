//! Hertz's cylinder on a block and on a rigid plane.

use contact_fem::element::Order;
use contact_fem::model::Passes;
use contact_fem::tensor::Vector;
use ipopt_contact_scenes::Failure;
use ipopt_contact_scenes::hertz::{FORCE, Fineness, Hertz};
use ipopt_contact_scenes::tables::Table;

use super::rows::{COLUMNS, fields, profile, row, solved};

/// Errors on both bodies, on meshes of at most `finest` facets in the half-width.
pub fn table(finest: usize) -> Result<Table, Failure> {
    let mut table = Table::new("cylinder", COLUMNS);
    let all_passes = [
        ("both", Passes::Both),
        ("cylinder", Passes::FirstIsSlave),
        ("block", Passes::SecondIsSlave),
    ];
    for in_contact in [4, 8, 11, 16, 22, 32] {
        // the published load by both passes, and five times that by all
        let runs = all_passes.map(|passes| (5.0 * FORCE, passes));
        for (force, (slave, passes)) in [(FORCE, all_passes[0])].into_iter().chain(runs) {
            if in_contact > finest {
                continue;
            }
            let hertz = Hertz {
                force,
                passes,
                ..Hertz::new(Fineness::family(in_contact), Order::Quadratic)
            };
            let (problem, solution) = solved(hertz.scene()?)?;
            let fields = fields(&problem, &solution)?;
            let a = hertz.half_width();
            for (k, body) in ["cylinder", "block"].iter().enumerate() {
                let shape = |X: &Vector<2>| profile(X[0].abs() / a);
                let is_inside = |X: &Vector<2>| X[0] < 0.6 * a;
                let mesh = format!("a/{in_contact}, load {force}, slave {slave}");
                row(
                    &mut table,
                    [mesh, (*body).into()],
                    &problem,
                    k,
                    &fields,
                    (hertz.peak_pressure(), &shape, &is_inside),
                );
            }
        }
    }
    // the cylinder on a rigid plane
    for in_contact in [4, 8, 16, 32].into_iter().filter(|n| *n <= finest) {
        let published = Hertz::new(Fineness::family(in_contact), Order::Quadratic);
        let hertz = Hertz {
            young: [published.young[0], f64::INFINITY],
            ..published
        };
        let (problem, solution) = solved(hertz.on_rigid(false)?)?;
        let fields = fields(&problem, &solution)?;
        let a = hertz.half_width();
        let shape = |X: &Vector<2>| profile(X[0].abs() / a);
        let is_inside = |X: &Vector<2>| X[0] < 0.6 * a;
        row(
            &mut table,
            [
                format!("a/{in_contact}, on a rigid plane"),
                "cylinder".into(),
            ],
            &problem,
            0,
            &fields,
            (hertz.peak_pressure(), &shape, &is_inside),
        );
    }
    Ok(table)
}

//! The contact patch test: the error of the stress with different numbers of Gauss points, and with
//! exact integration.
//!
//! ```text
//! cargo run --release --example patch_test
//! ```
//!
//! Two blocks with a flat interface and non-matching meshes are pressed on each other; the scene is
//! defined in `scenes/src/blocks.rs`. Each line is for one kind of elements and pair of meshes. It
//! contains the largest error of a stress component in any cell, divided by the pressure, first
//! with both passes, then with the lower block as slave. The exit code is 1 if the error with exact
//! integration exceeds 1e-10. With both passes and quadratic elements in the plane the limit is
//! 1e-7: the constraints are then nearly linearly dependent, which limits the accuracy of the
//! solver.

use std::process::ExitCode;

use clap::Parser;
use ipopt_contact::contact_fem::Error;
use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::prelude::*;
use ipopt_contact_scenes::blocks::{Blocks, errors};

/// The numbers of Gauss points for each facet and direction.
const POINTS: [usize; 8] = [2, 3, 4, 6, 8, 12, 16, 32];
/// The largest error with exact integration, as a share of the pressure.
const ROUND_OFF: f64 = 1e-10;
/// The same if the constraints of both passes are nearly linearly dependent.
const DEPENDENT: f64 = 1e-7;

/// The contact patch test: the error of the stress by integration; it has no options
#[derive(Parser, Debug)]
struct Arguments {}

fn main() -> Result<ExitCode, Error> {
    let Arguments {} = Arguments::parse();
    let mut table = Table::default();
    for passes in [Passes::Both, Passes::FirstIsSlave] {
        println!("{passes:?}");
        print!("             cells ");
        POINTS.iter().for_each(|n| print!("{n:>9}"));
        println!("    exact");
        for order in [Order::Linear, Order::Quadratic] {
            for divisions in [[5, 7], [7, 5], [4, 9], [3, 21]] {
                let blocks = |integration| Blocks {
                    passes,
                    ..Blocks::new(divisions, order, integration)
                };
                table.line("plane", blocks, |blocks| errors(blocks.plane()?))?;
            }
        }
        for order in [Order::Linear, Order::Quadratic] {
            for divisions in [[2, 3], [3, 2], [3, 4], [1, 5]] {
                let blocks = |integration| Blocks {
                    passes,
                    ..Blocks::new(divisions, order, integration)
                };
                table.line("space", blocks, |blocks| errors(blocks.space()?))?;
            }
        }
    }
    Ok(ExitCode::from(u8::from(table.failed)))
}

#[derive(Default)]
struct Table {
    /// The error with exact integration exceeds its limit.
    failed: bool,
}

impl Table {
    /// Solves one case and prints a line.
    fn line(
        &mut self,
        name: &str,
        blocks: impl Fn(Integration) -> Blocks,
        solve: impl Fn(Blocks) -> Result<[f64; 2], Error>,
    ) -> Result<(), Error> {
        let exact = blocks(Integration::Exact);
        let (order, [lower, upper]) = (exact.orders[0], exact.divisions);
        print!("{name} P{} {lower:>4}:{upper:<4}", order.degree());
        for points in POINTS {
            print!("{:>9.0e}", solve(blocks(Integration::Gauss(points)))?[0]);
        }
        let [stress, _] = solve(exact)?;
        println!("{stress:>9.0e}");
        let dependent = name == "plane" && order == Order::Quadratic;
        let allowed = match exact.passes {
            Passes::Both if dependent => DEPENDENT,
            _ => ROUND_OFF,
        };
        self.failed |= stress.is_nan() || stress > allowed;
        Ok(())
    }
}

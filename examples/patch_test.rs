//! The contact patch test in numbers: how wrong the stress is with so many Gauss points, and exactly
//! integrated.
//!
//! ```text
//! cargo run --release --example patch_test
//! ```
//!
//! Two blocks with a flat interface and meshes that do not match are pressed on each other; the scene
//! is in `scenes/src/blocks.rs`. One line for each kind of elements and pair of meshes: the largest error
//! of a component of the stress in any cell, as a share of the pressure; first with both passes, then
//! with the lower block as slave. It ends with exit code 1 if exact integration leaves more than 1e-10,
//! or 1e-7 with both passes and quadratic elements in the plane, whose constraints all but depend on
//! each other, so that the solver resolves no less.

use std::process::ExitCode;

use clap::Parser;
use ipopt_contact::contact_fem::Error;
use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::prelude::*;
use ipopt_contact_scenes::blocks::{Blocks, errors};

/// Gauss points a facet and direction.
const POINTS: [usize; 8] = [2, 3, 4, 6, 8, 12, 16, 32];
/// What exact integration may leave.
const ROUND_OFF: f64 = 1e-10;
/// The same where the constraints of both passes all but depend on each other.
const DEPENDENT: f64 = 1e-7;

/// The contact patch test in numbers: the error of the stress by integration; it has no options
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
    /// Exact integration left more than it may.
    failed: bool,
}

impl Table {
    /// Solves and prints a line.
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

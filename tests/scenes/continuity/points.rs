//! Which integration points of a row change across a jump.

use std::fmt::Write;

use contact_core::gaps::RowKey;
use contact_fem::contact::stencil::projected;
use contact_fem::contact::{Master, Stencil};
use contact_fem::model::{Integration, Problem};
use contact_fem::tensor::Vector;

use super::line::{Jump, Line, Place};

/// An integration point: where it is, where its foot is, and its weight.
#[derive(Clone, Copy, Debug)]
struct Point<const D: usize> {
    x: Vector<D>,
    weight: f64,
    facet: usize,
    foot: Vector<D>,
    gap: f64,
}

/// The row of a jump, and its points that differ before and after.
pub fn told<const D: usize>(problem: &Problem<D>, line: &Line<'_, D>, jump: &Jump) -> String {
    let [before, after] = jump.between;
    let mut told = format!(
        "{:?} jumps by {:.2e} at t = {before}",
        jump.place, jump.size
    );
    let rows = match jump.place {
        Place::Force { node, .. } => line.rows_with(node),
        Place::Gap(key) | Place::Coefficient(key, _) => vec![key],
    };
    for key in rows {
        let points =
            [before, after].map(|t| points_of(problem, key, &problem.positions(&line.state(t))));
        let differences = differences(&points);
        if differences.is_empty() {
            continue;
        }
        let pass = problem.passes()[key.pass as usize];
        let body = |k: usize| {
            problem
                .surfaces()
                .get(k)
                .map_or("an obstacle", |s| &problem.scene().names()[s.body()])
        };
        let X = problem.reference()[key.node as usize];
        let _ = write!(
            told,
            "\n  pass {}, {} on {}, row of node {} at X = {:?}",
            key.pass,
            body(pass.slave),
            body(pass.master),
            key.node,
            X.as_slice(),
        );
        differences.iter().for_each(|line| told.push_str(line));
    }
    told
}

/// The points in whose facets the row's node is.
fn points_of<const D: usize>(problem: &Problem<D>, key: RowKey, x: &[Vector<D>]) -> Vec<Point<D>> {
    let scene = problem.scene();
    let integration = scene.integration.unwrap_or(match D {
        2 => Integration::Exact,
        _ => Integration::Gauss(4),
    });
    let pass = problem.passes()[key.pass as usize];
    let (Some(slave), Some(master)) = (
        problem.surfaces().get(pass.slave),
        problem.surfaces().get(pass.master),
    ) else {
        return Vec::new();
    };
    let X = problem.reference();
    let [low, high] = [Vector::inf, Vector::sup].map(|f| X.iter().fold(X[0], |m, x| f(&m, x)));
    let reach = scene.reach.unwrap_or(0.1 * (high - low).norm());
    let master = Master::new(master, x, scene.projection);
    let points = projected(slave, &master, x, integration, reach);
    let stencils = points
        .into_iter()
        .map(|point| Stencil::new(slave, &master, point));
    let is_near = |s: &Stencil<'_, D>| {
        let mut nodes = s.test_functions().map(|(a, _)| slave.nodes()[a]);
        nodes.any(|node| node == key.node as usize)
    };
    let stencils = stencils.filter(is_near);
    let point = |s: Stencil<'_, D>| {
        let p = s.projection();
        Point {
            x: s.point(),
            weight: s.weight(),
            facet: p.facet,
            foot: p.foot,
            gap: p.gap,
        }
    };
    stencils.map(point).collect()
}

/// The points without a like one at the other state.
fn differences<const D: usize>([before, after]: &[Vec<Point<D>>; 2]) -> Vec<String> {
    let like = |a: &Point<D>, b: &Point<D>| {
        let apart = (a.x - b.x).norm() + (a.foot - b.foot).norm();
        apart < 1e-6 && (a.weight - b.weight).abs() < 1e-6 * a.weight
    };
    let alone = |own: &[Point<D>], others: &[Point<D>], when: &str| -> Vec<String> {
        let own = own.iter().filter(|a| !others.iter().any(|b| like(a, b)));
        own.map(|a| {
            format!(
                "\n    {when}: x = {:.6?}, weight {:.4e}, foot {:.6?} on facet {}, gap {:.4e}",
                a.x.as_slice(),
                a.weight,
                a.foot.as_slice(),
                a.facet,
                a.gap,
            )
        })
        .collect()
    };
    let mut all = alone(before, after, "before");
    all.extend(alone(after, before, "after"));
    all
}

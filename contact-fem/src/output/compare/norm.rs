//! L² norms of displacements.

use super::outcome::{Fields, Point};
use super::{Quantity, Row, minus};
use crate::element::cell_rule::degree_5;
use crate::element::{Element, P1, P2};
use crate::tensor::{Matrix, Vector, determinant};

/// The row of the L² norm, over the cells of either result.
pub(super) fn row(pairs: &[(&Fields, Fields)], dimension: usize) -> Row {
    let sums = pairs.iter().map(|(a, b)| squares(a, b, dimension));
    let sums = sums.reduce(|all, more| {
        let (all, more) = (all?, more?);
        Some([0, 1, 2].map(|k| all[k] + more[k]))
    });
    let norm = |k: usize| sums.flatten().map(|sums| sums[k].sqrt());
    Row::of_field(Quantity::DisplacementL2, [norm(0), norm(1)], norm(2))
}

/// ∫|u|² over a body of A's displacements, B's and their difference.
fn squares(a: &Fields, b: &Fields, dimension: usize) -> Option<[f64; 3]> {
    let with_cells = [a, b].into_iter().find(|body| !body.cells.is_empty())?;
    let places = with_cells.places.as_ref()?;
    let off = a.displacements.iter().zip(&b.displacements);
    let off: Vec<Point> = off.map(|(a, b)| minus(a, b)).collect();
    let cells = &with_cells.cells;
    Some([&a.displacements, &b.displacements, &off].map(|field| {
        let integral = match (dimension, cells[0].len()) {
            (2, 3) => integral::<2, P1>,
            (2, _) => integral::<2, P2>,
            (_, 4) => integral::<3, P1>,
            _ => integral::<3, P2>,
        };
        integral(cells, places, field)
    }))
}

/// ∫|u|² over cells, which may be curved. The rule is exact to degree 5, on straight cells all is.
fn integral<const D: usize, E: Element<D>>(
    cells: &[Vec<usize>],
    places: &[Point],
    field: &[Point],
) -> f64 {
    let vector = |p: &Point| Vector::<D>::from_fn(|i, _| p[i]);
    let mut sum = 0.0;
    for (weight, xi) in degree_5::<D>() {
        let (shapes, slopes) = (E::shapes(&xi), E::shape_gradients(&xi));
        for cell in cells {
            let mut map = Matrix::<D>::zeros();
            let mut value = Vector::<D>::zeros();
            let nodes = cell.iter().zip(shapes.as_ref()).zip(slopes.as_ref());
            for ((&node, N), dN) in nodes {
                map += vector(&places[node]) * dN.transpose();
                value += vector(&field[node]) * *N;
            }
            sum += weight * determinant(&map).abs() * value.norm_squared();
        }
    }
    sum
}

//! Which node of one result is which of the other.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::outcome::{Fields, Point};
use super::{Error, Matching, Side};

/// The distance within which two nodes are one, as a share of the body's diagonal: above the digits that mesh files keep.
const AT: f64 = 1e-9;

/// B's node at each node of A, and how it was found.
pub(super) fn matched(
    a: &Fields,
    b: &Fields,
    dimension: usize,
) -> Result<(Vec<usize>, Matching), Error> {
    let (nodes, others) = (a.displacements.len(), b.displacements.len());
    let same: Vec<usize> = (0..nodes).collect();
    let (Some(of_a), Some(of_b)) = (&a.places, &b.places) else {
        return match nodes == others {
            true => Ok((same, Matching::ByNumberUnchecked)),
            false => Err(Error::NodeCounts {
                body: a.name.clone(),
                a: nodes,
                b: others,
            }),
        };
    };
    let within = AT * diagonal(of_a);
    let is_near = |(x, y): (&Point, &Point)| distance(x, y) <= within;
    if nodes == others && of_a.iter().zip(of_b).all(is_near) {
        return Ok((same, Matching::ByNumber));
    }
    // the side whose cells tell which nodes are middles goes first
    let swapped = a.cells.is_empty() && !b.cells.is_empty();
    let (side, from, to) = match swapped {
        true => (Side::B, b, a),
        false => (Side::A, a, b),
    };
    let found = by_place(side, from, to, within, dimension)?;
    // and back: no two nodes have the same counterpart, and none of the other is left over
    let other = match side {
        Side::A => Side::B,
        Side::B => Side::A,
    };
    by_place(other, to, from, within, dimension)?;
    let found = match swapped {
        true => inverse(&found, nodes),
        false => found,
    };
    Ok((found, Matching::ByPlace))
}

/// The node of `to` at each node of `from`.
fn by_place(
    side: Side,
    from: &Fields,
    to: &Fields,
    within: f64,
    dimension: usize,
) -> Result<Vec<usize>, Error> {
    let places = |fields: &Fields| fields.places.clone().unwrap_or_default();
    let (own, theirs) = (places(from), places(to));
    let leaves = theirs.iter().enumerate();
    let leaves = leaves.map(|(node, &place)| GeomWithData::new(place, node));
    let tree = RTree::bulk_load(leaves.collect());
    let (mut found, mut missing) = (Vec::new(), Vec::new());
    for (node, &place) in own.iter().enumerate() {
        let mut near = tree.locate_within_distance(place, within * within);
        match (near.next(), near.count()) {
            (Some(leaf), 0) => found.push(leaf.data),
            (Some(_), others) => {
                return Err(Error::Ambiguous {
                    body: from.name.clone(),
                    side,
                    node,
                    place: place[..dimension].to_vec(),
                    found: others + 1,
                });
            }
            (None, _) => missing.push(node),
        }
    }
    let Some(&node) = missing.first() else {
        return Ok(found);
    };
    let nearest = tree.nearest_neighbor(own[node]);
    let distance = nearest.map(|leaf| distance(leaf.geom(), &own[node]));
    Err(Error::Unmatched {
        body: from.name.clone(),
        side,
        unmatched: missing.len(),
        nodes: own.len(),
        others: theirs.len(),
        node,
        place: own[node][..dimension].to_vec(),
        distance: distance.unwrap_or(f64::INFINITY),
        only_middles: own.len() == theirs.len() && are_middles(from, &missing, dimension),
    })
}

/// Whether these nodes are all middles of edges.
fn are_middles(fields: &Fields, nodes: &[usize], dimension: usize) -> bool {
    let mut is_middle = vec![false; fields.displacements.len()];
    for cell in &fields.cells {
        for &node in &cell[dimension + 1..] {
            is_middle[node] = true;
        }
    }
    nodes.iter().all(|&node| is_middle[node])
}

/// The inverse of a map onto as many nodes.
fn inverse(map: &[usize], nodes: usize) -> Vec<usize> {
    let mut inverse = vec![0; nodes];
    for (from, &to) in map.iter().enumerate() {
        inverse[to] = from;
    }
    inverse
}

fn diagonal(places: &[Point]) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for place in places {
        for i in 0..3 {
            low[i] = low[i].min(place[i]);
            high[i] = high[i].max(place[i]);
        }
    }
    match places.is_empty() {
        true => 0.0,
        false => distance(&low, &high),
    }
}

fn distance(a: &Point, b: &Point) -> f64 {
    let square = |i: usize| (a[i] - b[i]).powi(2);
    (square(0) + square(1) + square(2)).sqrt()
}

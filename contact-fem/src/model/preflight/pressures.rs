//! The rims of boundaries under pressures that follow them.

use std::collections::BTreeMap;

use crate::element::{Order, facet_edge};
use crate::error::Error;
use crate::model::{Body, Scene};

/// The nodes of an edge are in one plane up to this share of the edge's length.
const PLANE: f64 = 1e-9;

/// Checks that the pressures on all boundaries have a potential.
///
/// In ∂a/∂x, the vector areas by positions, what is not symmetric is left at the rim alone: for an edge along t and components
/// i ≠ j of its nodes it is proportional to t_k, with the third component k; in the plane, to 1.
pub(super) fn rims<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    for (body, name) in scene.bodies().iter().zip(scene.names()) {
        for pressure in body.pressures() {
            let edges = rim(body, &pressure.boundary)?;
            if let Some(edge) = edges.iter().find(|edge| !is_conservative(body, edge)) {
                return Err(Error::FreeRim {
                    body: name.clone(),
                    boundary: pressure.boundary.clone(),
                    at: body.mesh().nodes()[edge[0]].iter().copied().collect(),
                });
            }
        }
    }
    Ok(())
}

/// The nodes of each edge that one facet of a boundary has alone; in the plane, single nodes.
fn rim<const D: usize>(body: &Body<D>, boundary: &str) -> Result<Vec<Vec<usize>>, Error> {
    let mesh = body.mesh();
    let mut edges: BTreeMap<Vec<usize>, (usize, Vec<usize>)> = BTreeMap::new();
    for nodes in mesh.boundary(boundary)? {
        for e in 0..D {
            let mut corners = match D {
                2 => vec![nodes[e]],
                _ => facet_edge::<D>(e).map(|k| nodes[k]).to_vec(),
            };
            let mut all = corners.clone();
            if D == 3 && mesh.order() == Order::Quadratic {
                all.push(nodes[D + e]);
            }
            corners.sort_unstable();
            edges.entry(corners).or_insert((0, all)).0 += 1;
        }
    }
    let once = edges.into_values().filter(|(count, _)| *count == 1);
    Ok(once.map(|(_, nodes)| nodes).collect())
}

/// Whether no pair of free components of these nodes sees what is not symmetric.
fn is_conservative<const D: usize>(body: &Body<D>, edge: &[usize]) -> bool {
    // what slides along other planes is not looked into
    let is_tied = |dof: usize| body.ties().contains_key(&dof);
    if edge
        .iter()
        .any(|node| (D * node..D * (node + 1)).any(is_tied))
    {
        return false;
    }
    let is_free = |i: &usize| {
        let mut nodes = edge.iter();
        nodes.any(|node| body.prescribed()[D * node + i].is_none())
    };
    let free: Vec<usize> = (0..D).filter(is_free).collect();
    match (free.len(), D) {
        (0 | 1, _) => true,
        (2, 3) => stays_in_plane(body, edge, 3 - free[0] - free[1]),
        _ => false,
    }
}

/// Whether all nodes have the same, prescribed, position along an axis at all times.
fn stays_in_plane<const D: usize>(body: &Body<D>, edge: &[usize], axis: usize) -> bool {
    let (X, supports) = (body.mesh().nodes(), body.supports());
    let length = (X[edge[0]] - X[edge[1]]).norm();
    let along = |t: f64, node: usize| {
        let dof = D * node + axis;
        // where a support takes up a node on its way is not known
        let held = supports.values[dof].filter(|_| !supports.begun.contains_key(&dof));
        let value = held.map(|value| supports.value(dof, value, t));
        X[node][axis] + value.unwrap_or(f64::NAN)
    };
    let mut times = std::iter::once(0.0).chain(body.times());
    times.all(|t| {
        let first = along(t, edge[0]);
        let mut others = edge[1..].iter();
        others.all(|&node| (along(t, node) - first).abs() <= PLANE * length)
    })
}

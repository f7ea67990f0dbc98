//! Pieces of a body that only nodes or edges join, so that they can turn against each other.

use std::collections::BTreeMap;

use super::limits::{HOLDS, MOST_PIECES};
use super::supports::{mode_of, modes, null_space};
use super::{Finding, FindingKind, Report, Severity};
use crate::mesh::Mesh;
use crate::model::Body;
use crate::tensor::Vector;

/// Finds the parts of a body whose pieces can move against each other without strain.
pub(super) fn check<const D: usize>(
    body: &Body<D>,
    name: &String,
    parts: &[Vec<usize>],
    report: &mut Report,
) {
    let mesh = body.mesh();
    let piece_of = pieces(mesh);
    let count = piece_of.iter().max().map_or(0, |last| last + 1);
    if count <= parts.len() {
        return;
    }
    // the pieces of each node
    let mut around = vec![Vec::new(); mesh.nodes().len()];
    for (cell, &piece) in mesh.cells().zip(&piece_of) {
        cell.iter().for_each(|&node| around[node].push(piece));
    }
    for pieces in &mut around {
        pieces.sort_unstable();
        pieces.dedup();
    }
    for part in parts {
        let joint = part.iter().find(|&&node| around[node].len() > 1);
        let Some(&joint) = joint else { continue };
        let free = free_motions(body, part, &around);
        if free > 0 {
            let finding = Finding::new(Severity::Warning, FindingKind::Mechanism, &[name]);
            let finding = finding.at(&mesh.nodes()[joint]).measured(free as f64, 0.0);
            report.add(finding.says(
                format!(
                    "parts of body `{name}` that meet at node {joint} share no facet there and can turn \
                     against each other (free motions: {free})"
                ),
                "join them by cells that share facets, or hold each of them",
            ));
        }
    }
}

/// The number of independent motions of the pieces of a part against each other: those that leave the nodes that they
/// share together and the prescribed dofs at rest, without those of the part as a whole. 0 if there are too
/// many pieces to count.
fn free_motions<const D: usize>(body: &Body<D>, part: &[usize], around: &[Vec<usize>]) -> usize {
    let mut number = BTreeMap::new();
    for piece in part.iter().flat_map(|&node| &around[node]) {
        let next = number.len();
        number.entry(*piece).or_insert(next);
    }
    if number.len() > MOST_PIECES {
        return 0;
    }
    let is_revolved = body.mesh().is_of_revolution();
    let nodes = body.mesh().nodes();
    let centre = part.iter().map(|&a| nodes[a]).sum::<Vector<D>>() / part.len() as f64;
    let extents = part.iter().map(|&a| (nodes[a] - centre).norm());
    let extent = extents.fold(f64::MIN_POSITIVE, f64::max);
    let width = modes::<D>(is_revolved) * number.len();
    let equation = |node: usize, component: usize, pieces: &[(usize, f64)]| {
        let arm = (nodes[node] - centre) / extent;
        let mut row = vec![0.0; width];
        for (piece, sign) in pieces {
            let first = modes::<D>(is_revolved) * number.get(piece).copied().unwrap_or_default();
            (0..modes::<D>(is_revolved))
                .for_each(|k| row[first + k] = sign * mode_of(is_revolved, k, &arm, component));
        }
        row
    };
    let joints = part.iter().flat_map(|&node| {
        let pairs = around[node].windows(2);
        pairs
            .flat_map(move |pair| (0..D).map(move |i| (node, i, [(pair[0], 1.0), (pair[1], -1.0)])))
    });
    let joints = joints.map(|(node, i, pieces)| equation(node, i, &pieces));
    let dofs = part.iter().flat_map(|node| D * node..D * (node + 1));
    let held = dofs.filter(|&dof| body.prescribed()[dof].is_some());
    let held: Vec<_> = held
        .map(|dof| {
            let mut sum = vec![0.0; width];
            for (dof, c) in body.held_by(dof) {
                let own = equation(dof / D, dof % D, &[(around[dof / D][0], c)]);
                sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
            }
            sum
        })
        .collect();
    let of_all = null_space(joints.chain(held.iter().cloned()), width, HOLDS).ncols();
    // as a whole, the part moves as one piece does
    let whole = held.iter().map(|row| {
        let columns = row.chunks(modes::<D>(is_revolved));
        let sum = |k: usize| columns.clone().map(|of_piece| of_piece[k]).sum();
        (0..modes::<D>(is_revolved)).map(sum).collect()
    });
    let rigid = null_space(whole, modes::<D>(is_revolved), HOLDS).ncols();
    of_all.saturating_sub(rigid)
}

/// The piece of each cell: cells that share a facet are in one piece. Pieces are numbered from 0.
fn pieces<const D: usize>(mesh: &Mesh<D>) -> Vec<usize> {
    let mut facets: Vec<([usize; D], usize)> = Vec::with_capacity((D + 1) * mesh.len());
    for cell in 0..mesh.len() {
        let corners = mesh.corners(cell);
        for omitted in 0..=D {
            let mut facet = std::array::from_fn(|k| corners[if k < omitted { k } else { k + 1 }]);
            facet.sort_unstable();
            facets.push((facet, cell));
        }
    }
    facets.sort_unstable();
    // each cell points to itself or to a cell of its piece with a smaller number
    let mut parent: Vec<usize> = (0..mesh.len()).collect();
    fn root(parent: &mut [usize], mut cell: usize) -> usize {
        while parent[cell] != cell {
            parent[cell] = parent[parent[cell]];
            cell = parent[cell];
        }
        cell
    }
    for pair in facets.windows(2) {
        if pair[0].0 == pair[1].0 {
            let (a, b) = (root(&mut parent, pair[0].1), root(&mut parent, pair[1].1));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut number = vec![usize::MAX; mesh.len()];
    let mut count = 0;
    for cell in 0..mesh.len() {
        let root = root(&mut parent, cell);
        if root == cell {
            number[cell] = count;
            count += 1;
        } else {
            number[cell] = number[root];
        }
    }
    number
}

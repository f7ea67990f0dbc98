//! Joins the edges of a mesh to a few long lines, which make the files small.

use std::collections::{HashMap, HashSet};

/// The edges of cells, given by the nodes around them, joined to trails: every edge is in exactly
/// one trail.
pub(super) fn trails(cells: &[&[usize]]) -> Vec<Vec<usize>> {
    let mut seen = HashSet::new();
    let mut neighbours: HashMap<usize, Vec<usize>> = HashMap::new();
    let mut starts = Vec::new();
    for cell in cells {
        let next = cell.iter().cycle().skip(1);
        for (&p, &q) in cell.iter().zip(next) {
            if seen.insert((p.min(q), p.max(q))) {
                neighbours.entry(p).or_default().push(q);
                neighbours.entry(q).or_default().push(p);
                starts.push(p);
            }
        }
    }
    let mut trails = Vec::new();
    for start in starts {
        let mut trail = vec![start];
        while let Some(next) = take_edge(&mut neighbours, trail[trail.len() - 1]) {
            trail.push(next);
        }
        if trail.len() > 1 {
            trails.push(trail);
        }
    }
    trails
}

/// Removes an edge at `node` and returns its other end.
fn take_edge(neighbours: &mut HashMap<usize, Vec<usize>>, node: usize) -> Option<usize> {
    let other = neighbours.get_mut(&node)?.pop()?;
    let back = neighbours.get_mut(&other)?;
    back.retain(|&n| n != node);
    Some(other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_edge_once() {
        let cells = [[0, 1, 2], [0, 2, 3], [2, 4, 3], [5, 6, 7]];
        let cells: Vec<&[usize]> = cells.iter().map(|c| &c[..]).collect();
        let trails = trails(&cells);
        let mut edges: Vec<(usize, usize)> = trails
            .iter()
            .flat_map(|t| t.windows(2).map(|w| (w[0].min(w[1]), w[0].max(w[1]))))
            .collect();
        edges.sort_unstable();
        let expected = [
            (0, 1),
            (0, 2),
            (0, 3),
            (1, 2),
            (2, 3),
            (2, 4),
            (3, 4),
            (5, 6),
            (5, 7),
            (6, 7),
        ];
        assert_eq!(edges, expected);
        assert!(trails.len() <= 4, "long trails: {trails:?}");
    }
}

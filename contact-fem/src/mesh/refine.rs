//! Meshes with smaller cells: conforming, with the boundaries and regions of the coarse mesh.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::Mesh;
use crate::element::cell_rule::corner;
use crate::element::p2::{self, CELL_EDGES};
use crate::element::{Order, facet_edge};
use crate::error::Error;
use crate::tensor::{Matrix, Vector, determinant};

/// A corner of a new cell: the number that the node has in a quadratic cell, a corner or the middle of an edge.
type Local = usize;

impl<const D: usize> Mesh<D> {
    /// The mesh with all edges halved: four cells for each in the plane, eight in space.
    ///
    /// Boundaries, regions and their names stay what they are. The middle of a straight edge is half way between its corners. The middle of a quadratic
    /// edge is where its cell's shape functions have it, so that curved sides keep their shape; [`Mesh::curved`] moves it onto a curve.
    ///
    /// In the plane the four cells are similar to the old one. In space four are; the octahedron between them is cut along its shortest
    /// diagonal.
    ///
    /// # Errors
    /// If a new cell of a curved one is folded.
    pub fn refined(&self) -> Result<Self, Error> {
        self.cut(&self.all_halved(), &mut Vec::new())
    }

    fn all_halved(&self) -> Vec<Vec<[Local; 4]>> {
        (0..self.len()).map(|k| self.halved(k)).collect()
    }

    /// The cells of one whose edges are all halved; the first D + 1 entries of each are its corners.
    fn halved(&self, k: usize) -> Vec<[Local; 4]> {
        if D == 2 {
            return vec![[0, 3, 5, 0], [3, 1, 4, 0], [5, 4, 2, 0], [3, 4, 5, 0]];
        }
        let corners = self.corners(k);
        let middle = |e: usize| {
            let [a, b] = CELL_EDGES[e].map(|a| self.nodes[corners[a]]);
            (a + b) * 0.5
        };
        // the middles of opposite edges, and the other four around the line between them
        let diagonals = [
            ([0, 5], [1, 2, 3, 4]),
            ([1, 3], [0, 2, 5, 4]),
            ([2, 4], [0, 1, 5, 3]),
        ];
        let length = |[a, b]: [usize; 2]| (middle(a) - middle(b)).norm();
        let shorter =
            |x: &&([usize; 2], _), y: &&([usize; 2], _)| length(x.0).total_cmp(&length(y.0));
        let mut cells = vec![[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]];
        if let Some(([a, b], around)) = diagonals.iter().min_by(shorter) {
            let ring = (0..4).map(|i| [around[i], around[(i + 1) % 4]]);
            cells.extend(ring.map(|[c, d]| [4 + a, 4 + b, 4 + c, 4 + d]));
        }
        cells
    }

    /// The mesh of these cells, given for each old one. `field` has a value for each node, or none at all; the values of new nodes are added.
    fn cut(&self, cells: &[Vec<[Local; 4]>], field: &mut Vec<Vector<D>>) -> Result<Self, Error> {
        let has_field = !field.is_empty();
        let edges = D * (D + 1) / 2;
        let used = cells.iter().enumerate().flat_map(|(k, own)| {
            let corners = own.iter().flat_map(|cell| &cell[..=D]);
            let middles = corners.filter(|local| **local > D);
            middles.map(move |local| self.edge(k, *local))
        });
        let used: HashSet<[usize; 2]> = used.collect();
        let mut nodes = self.nodes.clone();
        let mut middles: HashMap<[usize; 2], usize> = HashMap::new();
        for k in 0..self.len() {
            for local in D + 1..=D + edges {
                let edge = self.edge(k, local);
                let new = || match self.order {
                    Order::Quadratic => self.cell(k)[local],
                    Order::Linear => {
                        nodes.push((nodes[edge[0]] + nodes[edge[1]]) * 0.5);
                        if has_field {
                            field.push((field[edge[0]] + field[edge[1]]) * 0.5);
                        }
                        nodes.len() - 1
                    }
                };
                if used.contains(&edge) {
                    middles.entry(edge).or_insert_with(new);
                }
            }
        }
        let node = |k: usize, local: Local| match local > D {
            true => middles[&self.edge(k, local)],
            false => self.corners(k)[local],
        };
        let (mut corners, mut parents) = (Vec::new(), Vec::new());
        for (k, own) in cells.iter().enumerate() {
            for cell in own {
                let mut cell: [Local; 4] = *cell;
                let X = |local: Local| nodes[node(k, local)];
                let sides = Matrix::<D>::from_fn(|i, j| (X(cell[j + 1]) - X(cell[0]))[i]);
                if determinant(&sides) < 0.0 {
                    cell.swap(D - 1, D);
                }
                corners.push(cell);
                parents.push(k);
            }
        }
        let per_cell = self.order.cell_nodes::<D>();
        let mut all = Vec::with_capacity(corners.len() * per_cell);
        // the middles of new edges of quadratic cells
        let mut between: HashMap<[usize; 2], usize> = HashMap::new();
        for (cell, &k) in corners.iter().zip(&parents) {
            let own: Vec<usize> = cell[..=D].iter().map(|&local| node(k, local)).collect();
            all.extend_from_slice(&own);
            if self.order == Order::Linear {
                continue;
            }
            for [a, b] in &CELL_EDGES[..edges] {
                let key = [own[*a].min(own[*b]), own[*a].max(own[*b])];
                let kept = (D + 1..=D + edges).find(|&local| self.edge(k, local) == key);
                let middle = match kept {
                    Some(local) => self.cell(k)[local],
                    None => *between.entry(key).or_insert_with(|| {
                        let ends = [cell[*a], cell[*b]];
                        nodes.push(self.between(k, ends, &self.nodes));
                        if has_field {
                            field.push(self.between(k, ends, field));
                        }
                        nodes.len() - 1
                    }),
                };
                all.push(middle);
            }
        }
        let nodes = nodes.into_iter().map(Into::into).collect();
        let mut mesh = Self::of_order(self.order, nodes, all)?;
        mesh.name_as(self, &corners, &parents, &middles);
        Ok(mesh)
    }

    /// The corners of the edge whose middle node is `local`, ascending.
    fn edge(&self, k: usize, local: Local) -> [usize; 2] {
        let [a, b] = CELL_EDGES[local - D - 1].map(|a| self.corners(k)[a]);
        [a.min(b), a.max(b)]
    }

    /// A field of the nodes half way between two of them, by the shape functions of a quadratic cell.
    fn between(&self, k: usize, ends: [Local; 2], field: &[Vector<D>]) -> Vector<D> {
        let xi = |local: Local| -> Vector<D> {
            let [a, b] = match local > D {
                true => CELL_EDGES[local - D - 1],
                false => [local; 2],
            };
            (corner(a) + corner(b)) * 0.5
        };
        let mut shapes = [0.0; 10];
        let own = self.cell(k);
        p2::shapes(
            &((xi(ends[0]) + xi(ends[1])) * 0.5),
            &mut shapes[..own.len()],
        );
        let terms = own.iter().zip(shapes);
        terms.map(|(&a, N)| field[a] * N).sum()
    }

    /// Takes over names, labels and what else holds for the mesh `of` whose cells are the `parents` of these.
    fn name_as(
        &mut self,
        of: &Self,
        corners: &[[Local; 4]],
        parents: &[usize],
        middles: &HashMap<[usize; 2], usize>,
    ) {
        // facets of old cells by their cell and the corner opposite
        let old = of.exterior().zip(&of.owners).enumerate();
        let opposite = |facet: &[usize], k: usize| {
            let mut corners = of.corners(k).iter();
            corners.position(|a| !facet[..D].contains(a))
        };
        let old: HashMap<(usize, Option<usize>), usize> = old
            .map(|(f, (facet, &k))| ((k, opposite(facet, k)), f))
            .collect();
        let is_on = |local: Local, side: usize| match local > D {
            true => !CELL_EDGES[local - D - 1].contains(&side),
            false => local != side,
        };
        let mut facets: Vec<Vec<usize>> = vec![Vec::new(); of.owners.len()];
        for (f, (facet, &cell)) in self.exterior().zip(&self.owners).enumerate() {
            let own = self.corners(cell).iter().zip(corners[cell]);
            let own = own.filter(|(a, _)| facet[..D].contains(a));
            let own: Vec<Local> = own.map(|(_, local)| local).collect();
            let side = (0..=D).find(|&side| own.iter().all(|&local| is_on(local, side)));
            if let Some(&parent) = old.get(&(parents[cell], side)) {
                facets[parent].push(f);
            }
        }
        let sorted = |mut all: Vec<usize>| {
            all.sort_unstable();
            all
        };
        let boundaries = of.boundaries.iter().map(|(name, own)| {
            let new = own.iter().flat_map(|&f| facets[f].iter().copied());
            (name.clone(), sorted(new.collect()))
        });
        let boundaries = boundaries.collect();
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); of.len()];
        parents
            .iter()
            .enumerate()
            .for_each(|(k, &parent)| children[parent].push(k));
        let regions = of.regions.iter().map(|(name, own)| {
            let new = own.iter().flat_map(|&k| children[k].iter().copied());
            (name.clone(), sorted(new.collect()))
        });
        let regions = regions.collect();
        let inner = of.inner.iter();
        let inner: BTreeMap<String, Vec<[usize; D]>> = inner
            .map(|(name, own)| {
                let new = own.iter().flat_map(|facet| pieces(facet, middles));
                (name.clone(), new.collect())
            })
            .collect();
        (self.boundaries, self.regions, self.inner) = (boundaries, regions, inner);
        (self.labels, self.region) = (of.labels.clone(), of.region);
        self.is_revolved = of.is_revolved;
    }

    /// The mesh in which all edges of the `marked` cells are halved, and as few further edges as keep the mesh conforming.
    ///
    /// Cells with a halved edge are cut along their longest edge first, after M.-C. Rivara, Algorithms for refining triangular grids suitable for
    /// adaptive and multigrid techniques, Int. J. Numer. Meth. Engng 20 (1984) 745–756: however often a mesh is refined, no angle becomes smaller than half the
    /// smallest one it had (I. G. Rosenberg and F. Stenger, SIAM J. Numer. Anal. 12 (1975) 390–395). The rest is as with
    /// [`Mesh::refined`].
    ///
    /// In space all cells are refined if one is marked.
    ///
    /// # Errors
    /// If there is not one mark for each cell; as [`Mesh::refined`].
    pub fn refined_where(&self, marked: &[bool]) -> Result<Self, Error> {
        self.cut(&self.cells_where(marked)?, &mut Vec::new())
    }

    /// As [`Mesh::refined_where`], with a `field` of the nodes, which has their values in the cells at the nodes of the new mesh afterwards.
    ///
    /// # Errors
    /// If there is not one value for each node; as [`Mesh::refined_where`].
    pub fn refined_with(&self, marked: &[bool], field: &mut Vec<Vector<D>>) -> Result<Self, Error> {
        contact_core::Error::check_length_of("field", field.len(), self.nodes.len())?;
        self.cut(&self.cells_where(marked)?, field)
    }

    /// The cells into which each is cut.
    fn cells_where(&self, marked: &[bool]) -> Result<Vec<Vec<[Local; 4]>>, Error> {
        contact_core::Error::check_length_of("marks", marked.len(), self.len())?;
        if D == 3 {
            return Ok(match marked.contains(&true) {
                true => self.all_halved(),
                false => vec![vec![[0, 1, 2, 3]]; self.len()],
            });
        }
        let longest: Vec<Local> = (0..self.len()).map(|k| self.longest_edge(k)).collect();
        let mut halved: HashSet<[usize; 2]> = HashSet::new();
        for (k, _) in marked.iter().enumerate().filter(|(_, marked)| **marked) {
            halved.extend((3..6).map(|local| self.edge(k, local)));
        }
        loop {
            let before = halved.len();
            for (k, &longest) in longest.iter().enumerate() {
                if (3..6).any(|local| halved.contains(&self.edge(k, local))) {
                    halved.insert(self.edge(k, longest));
                }
            }
            if halved.len() == before {
                break;
            }
        }
        let cells = longest.iter().enumerate().map(|(k, &longest)| {
            let is_halved = |local: Local| halved.contains(&self.edge(k, local));
            pieces_of_triangle(longest, is_halved)
        });
        Ok(cells.collect())
    }

    /// The middle node of the longest edge; of edges that are equally long, of the one with the lowest corners.
    fn longest_edge(&self, k: usize) -> Local {
        let square = |local: Local| {
            let [a, b] = self.edge(k, local);
            (self.nodes[a] - self.nodes[b]).norm_squared()
        };
        let longest = (3..6).map(square).fold(0.0, f64::max);
        let candidates = (3..6).filter(|&local| square(local) > (1.0 - 1e-9) * longest);
        let lowest = candidates.min_by_key(|&local| self.edge(k, local));
        lowest.unwrap_or(3)
    }
}

/// The cells of a triangle some of whose edges are halved, the longest among them.
fn pieces_of_triangle(longest: Local, is_halved: impl Fn(Local) -> bool) -> Vec<[Local; 4]> {
    if !is_halved(longest) {
        return vec![[0, 1, 2, 0]];
    }
    // counter-clockwise from a, where the longest edge begins
    let a = longest - 3;
    let [b, c] = [(a + 1) % 3, (a + 2) % 3];
    let half = |[from, to]: [usize; 2], edge: Local, tip: Local| match is_halved(edge) {
        // the third corner of both is the middle of the longest edge
        true => vec![[from, edge, tip, 0], [edge, to, tip, 0]],
        false => vec![[from, to, tip, 0]],
    };
    let mut cells = half([b, c], 3 + b, longest);
    cells.extend(half([c, a], 3 + c, longest));
    cells
}

/// The facets that are left of one whose edges are halved, if they are.
fn pieces<const D: usize>(
    facet: &[usize; D],
    middles: &HashMap<[usize; 2], usize>,
) -> Vec<[usize; D]> {
    let edges = (0..D * (D - 1) / 2).map(facet_edge::<D>);
    let middle = |[a, b]: [usize; 2]| {
        let [a, b] = [facet[a], facet[b]];
        middles.get(&[a.min(b), a.max(b)]).copied()
    };
    let middles: Option<Vec<usize>> = edges.map(middle).collect();
    let of = |corners: &[usize]| std::array::from_fn(|k| corners[k]);
    match middles.as_deref() {
        None => vec![*facet],
        Some(&[m]) => vec![of(&[facet[0], m]), of(&[m, facet[1]])],
        Some(m) => vec![
            of(&[facet[0], m[0], m[2]]),
            of(&[m[0], facet[1], m[1]]),
            of(&[m[2], m[1], facet[2]]),
            of(&[m[0], m[1], m[2]]),
        ],
    }
}

#[cfg(test)]
mod tests;

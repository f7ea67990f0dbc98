//! Meshes of quadratic cells with nodes in the middle of the edges.

use std::collections::HashMap;

use super::Mesh;
use crate::element::p2::{self, CELL_EDGES};
use crate::element::volume::{CellNodes, least_ratio};
use crate::element::{Order, facet_edge};
use crate::error::Error;
use crate::tensor::{Matrix, Vector, determinant};

impl<const D: usize> Mesh<D> {
    /// The mesh with a node in the middle of every edge. Boundaries keep their names; a quadratic
    /// mesh is returned unchanged.
    pub fn quadratic(mut self) -> Self {
        if self.order == Order::Quadratic {
            return self;
        }
        let mut middles = HashMap::new();
        let nodes = &mut self.nodes;
        let mut middle = |a: usize, b: usize| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                nodes.push((nodes[a] + nodes[b]) * 0.5);
                nodes.len() - 1
            })
        };
        let mut cells = Vec::new();
        for cell in self.cells.chunks_exact(D + 1) {
            cells.extend_from_slice(cell);
            let edges = CELL_EDGES[..D * (D + 1) / 2].iter();
            cells.extend(edges.map(|&[a, b]| middle(cell[a], cell[b])));
        }
        let mut facets = Vec::new();
        for facet in self.facets.chunks_exact(D) {
            facets.extend_from_slice(facet);
            let edges = (0..D * (D - 1) / 2).map(facet_edge::<D>);
            facets.extend(edges.map(|[a, b]| middle(facet[a], facet[b])));
        }
        Mesh {
            order: Order::Quadratic,
            cells,
            facets,
            ..self
        }
    }

    /// The mesh with every middle node half way between its corners, as those of FreeFEM's P2; a linear mesh is returned
    /// unchanged.
    pub fn straight(mut self) -> Self {
        if self.order == Order::Quadratic {
            let edges = &CELL_EDGES[..D * (D + 1) / 2];
            for cell in self.cells.chunks_exact(D + 1 + edges.len()) {
                for (&middle, &[a, b]) in cell[D + 1..].iter().zip(edges) {
                    self.nodes[middle] = (self.nodes[cell[a]] + self.nodes[cell[b]]) * 0.5;
                }
            }
        }
        self
    }

    /// Whether an edge is curved: its middle node is off the middle of its corners by more than this share of its length.
    pub fn is_curved(&self, share: f64) -> bool {
        let edges = &CELL_EDGES[..D * (D + 1) / 2];
        self.order == Order::Quadratic
            && self.cells().any(|cell| {
                cell[D + 1..].iter().zip(edges).any(|(&middle, &[a, b])| {
                    let [a, b] = [a, b].map(|corner| self.nodes[cell[corner]]);
                    let off = (a + b) * 0.5 - self.nodes[middle];
                    off.norm() > share * (b - a).norm()
                })
            })
    }

    /// Draws a boundary onto a curve or a surface: the corners of its facets move to `onto(X)`, and the middle nodes of quadratic cells by the mean of
    /// what the ends of their edges move by, so that straight edges stay straight. It is for the new corners of a refined polygon; middle nodes
    /// are moved by [`Mesh::curved`].
    ///
    /// # Errors
    /// If the boundary is unknown, or a point not finite; [`Error::MappedCell`] if a cell is folded.
    pub fn drawn(
        mut self,
        boundary: &str,
        onto: impl Fn(&Vector<D>) -> Vector<D>,
    ) -> Result<Self, Error> {
        let facets = self.boundary(boundary)?;
        let corners = facets.iter().flat_map(|facet| facet[..D].to_vec());
        let moves = corners.map(|node| (node, onto(&self.nodes[node]) - self.nodes[node]));
        let moves: HashMap<usize, Vector<D>> = moves.collect();
        Error::check_finite("drawn boundary point", moves.values().flatten())?;
        let mut middles = HashMap::new();
        if self.order == Order::Quadratic {
            let at = |node: usize| moves.get(&node).copied().unwrap_or_else(Vector::zeros);
            for cell in self.cells() {
                for (&middle, [a, b]) in cell[D + 1..].iter().zip(CELL_EDGES) {
                    middles.insert(middle, (at(cell[a]) + at(cell[b])) * 0.5);
                }
            }
        }
        for (node, by) in moves.into_iter().chain(middles) {
            self.nodes[node] += by;
        }
        self.check_moved_cells()?;
        Ok(self)
    }

    /// Curves a boundary: every middle node on it moves to `onto(X)`, usually the closest point of
    /// the curve or surface on which the corners lie.
    ///
    /// # Errors
    /// If the mesh is linear, the boundary unknown, a point not finite, or a cell is folded by its
    /// curved edge.
    pub fn curved(
        mut self,
        boundary: &str,
        onto: impl Fn(&Vector<D>) -> Vector<D>,
    ) -> Result<Self, Error> {
        if self.order == Order::Linear {
            return Err(Error::Setting {
                name: "order",
                value: 1.0,
                remedy: "linear meshes have nothing to curve: make it `quadratic()` first",
            });
        }
        let facets = self.boundary(boundary)?;
        let mut middles: Vec<usize> = facets.iter().flat_map(|f| f[D..].to_vec()).collect();
        middles.sort_unstable();
        middles.dedup();
        for node in middles {
            let moved = onto(&self.nodes[node]);
            Error::check_finite("curved boundary point", moved.iter())?;
            self.nodes[node] = moved;
        }
        self.check_cells()?;
        Ok(self)
    }

    /// Checks that all cells at an edge share its middle node, which is no corner and on no other
    /// edge.
    pub(super) fn check_edges(&self) -> Result<(), Error> {
        if self.order == Order::Linear {
            return Ok(());
        }
        let mut middles = HashMap::new();
        let mut edges = HashMap::new();
        let corners: std::collections::HashSet<usize> = (0..self.len())
            .flat_map(|k| self.corners(k).to_vec())
            .collect();
        for (cell, nodes) in self.cells().enumerate() {
            for (&node, [a, b]) in nodes[D + 1..].iter().zip(CELL_EDGES) {
                let edge = [nodes[a].min(nodes[b]), nodes[a].max(nodes[b])];
                let same = *middles.entry(edge).or_insert(node) == node
                    && *edges.entry(node).or_insert(edge) == edge;
                if !same || corners.contains(&node) {
                    return Err(Error::EdgeNode { cell, edge, node });
                }
            }
        }
        Ok(())
    }

    /// det ∂X/∂ξ at ξ, constant in a linear cell.
    pub(crate) fn jacobian(&self, cell: usize, xi: &Vector<D>) -> f64 {
        if self.order == Order::Linear {
            return self.straight_volume(cell) * Self::FACTORIAL;
        }
        let nodes = self.cell(cell);
        let mut gradients = [Vector::zeros(); 10];
        let gradients = &mut gradients[..nodes.len()];
        p2::shape_gradients(xi, gradients);
        let mut dX = Matrix::<D>::zeros();
        for (&a, dN) in nodes.iter().zip(gradients) {
            dX.ger(1.0, &self.nodes[a], dN, 1.0);
        }
        determinant(&dX)
    }

    /// A lower bound of det ∂X/∂ξ within a cell, divided by its value in the straight cell between the corners.
    pub(super) fn least_share(&self, cell: usize) -> f64 {
        if self.order == Order::Linear {
            return 1.0;
        }
        let nodes = self.cell(cell);
        let curved = std::array::from_fn(|k| self.nodes[*nodes.get(k).unwrap_or(&nodes[0])]);
        let mut straight: CellNodes<D> = curved;
        let middles = straight[D + 1..]
            .iter_mut()
            .zip(&CELL_EDGES[..D * (D + 1) / 2]);
        middles.for_each(|(middle, [a, b])| *middle = (curved[*a] + curved[*b]) * 0.5);
        least_ratio::<D>(&curved, &straight, f64::NEG_INFINITY).bound
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{Facet, FacetRule};
    use crate::mesh::generators::{disc, onto_sphere, sphere};

    #[test]
    fn straight_edges_are_those_of_the_linear_mesh() {
        let mesh = sphere(1.0, 2).expect("a ball").quadratic();
        assert!(!mesh.is_curved(1e-12));
        let curved = mesh.clone().curved("surface", onto_sphere(1.0));
        let curved = curved.expect("curved");
        assert!(curved.is_curved(1e-3) && !curved.is_curved(1.0));
        let volume = |mesh: &Mesh<3>| (0..mesh.len()).map(|k| mesh.volume(k)).sum::<f64>();
        assert!(volume(&curved) > 1.01 * volume(&mesh));
        let straight = curved.straight();
        assert!((volume(&straight) / volume(&mesh) - 1.0).abs() < 1e-14);
        let off = straight.nodes().iter().zip(mesh.nodes());
        let off = off.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(off < 1e-15);
    }

    #[test]
    fn a_curved_disc_has_nearly_the_area_of_the_circle() {
        let error = |sectors: usize| {
            let mesh = disc(2.0, sectors, sectors / 4, 0.0)
                .expect("a disc")
                .quadratic();
            let onto = |X: &Vector<2>| X * (2.0 / X.norm());
            let mesh = mesh.curved("boundary", onto).expect("curved");
            let area: f64 = (0..mesh.len()).map(|k| mesh.volume(k)).sum();
            (area - 4.0 * std::f64::consts::PI).abs()
        };
        let (coarse, fine) = (error(16), error(32));
        assert!(fine < 1e-4, "{fine}");
        assert!(coarse / fine > 14.0, "fourth order: {coarse} to {fine}");
    }

    #[test]
    fn middle_nodes_keep_the_names_and_the_area() {
        let mesh = disc(1.0, 12, 2, 0.0).expect("a disc");
        let before: f64 = (0..mesh.len()).map(|k| mesh.volume(k)).sum();
        let mesh = mesh.quadratic();
        let after: f64 = (0..mesh.len()).map(|k| mesh.volume(k)).sum();
        assert!((before - after).abs() < 1e-14);
        assert_eq!(mesh.boundary("boundary").expect("named").len(), 12);
        assert_eq!(mesh.boundary_nodes("boundary").expect("named").len(), 24);
    }

    /// ∫ div X = ∮ X·n, a polynomial of degree 4 over curved facets.
    fn volume_is_flux<const D: usize>(mesh: &Mesh<D>) {
        let rule = FacetRule::<D>::gauss(4);
        let flux = |nodes: &[usize]| -> f64 {
            let facet = Facet::gather(mesh.order(), nodes, mesh.nodes());
            let points = rule.points().iter();
            let at = |(w, l): &(f64, Vector<D>)| w * facet.point(l).dot(&facet.normal(l));
            points.map(at).sum()
        };
        let flux = mesh.exterior().map(flux).sum::<f64>() / D as f64;
        let volume: f64 = (0..mesh.len()).map(|k| mesh.volume(k)).sum();
        assert!((volume - flux).abs() < 1e-13 * flux, "{volume} {flux}");
    }

    #[test]
    fn volumes_of_curved_meshes_are_exact() {
        let plane = disc(2.0, 8, 2, 0.1).expect("a disc").quadratic();
        let plane = plane.curved("boundary", onto_sphere(2.0));
        volume_is_flux(&plane.expect("curved"));
        for shells in [1, 2, 3] {
            let ball = sphere(2.0, shells).expect("a ball").quadratic();
            let ball = ball.curved("surface", onto_sphere(2.0));
            volume_is_flux(&ball.expect("curved"));
        }
    }

    fn two_triangles(second: [usize; 3]) -> Result<Mesh<2>, Error> {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let middles = [[0.5, 0.0], [1.0, 0.5], [0.5, 0.5], [0.5, 1.0], [0.0, 0.5]];
        let mut nodes = corners.to_vec();
        nodes.extend(middles);
        let mut cells = vec![0, 1, 2, 4, 5, 6, 0, 2, 3];
        cells.extend(second);
        Mesh::of_order(Order::Quadratic, nodes, cells)
    }

    #[test]
    fn edges_share_their_middle_node() {
        let mesh = two_triangles([6, 7, 8]).expect("valid");
        assert_eq!(mesh.exterior().len(), 4);
        for bad in [[7, 6, 8], [6, 7, 3], [6, 8, 7]] {
            let error = two_triangles(bad).expect_err("not the middle");
            let expected = matches!(
                error,
                Error::EdgeNode { .. } | Error::CurvedCell { .. } | Error::OrphanNode { .. }
            );
            assert!(expected, "{error}");
        }
    }

    #[test]
    fn an_edge_bent_too_far_inverts_its_cell() {
        let mesh = two_triangles([6, 7, 8]).expect("valid");
        let mut mesh = mesh;
        mesh.name_boundary("bottom", |X| X[1] == 0.0);
        let bent = mesh.curved("bottom", |X| Vector::<2>::new(X[0], 0.9));
        let error = bent.expect_err("folded");
        assert!(matches!(error, Error::CurvedCell { .. }));
        let message = error.to_string();
        assert!(message.contains("middle nodes") && message.contains("refine"));
    }

    #[test]
    fn corners_in_the_wrong_order_are_told_from_bent_edges() {
        let mesh = two_triangles([6, 7, 8]).expect("valid");
        let nodes: Vec<[f64; 2]> = mesh.nodes().iter().map(|X| [X[0], X[1]]).collect();
        let cells = vec![0, 2, 1, 6, 5, 4, 0, 2, 3, 6, 7, 8];
        let error = Mesh::of_order(Order::Quadratic, nodes, cells).expect_err("clockwise");
        assert!(matches!(error, Error::InvertedCell { cell: 0, .. }));
    }
}

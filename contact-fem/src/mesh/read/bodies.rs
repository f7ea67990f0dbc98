//! From a file's contents to the meshes of bodies.

use std::collections::{BTreeMap, HashMap};

use super::parts::{Corners, Part, sorted};
use super::{Group, MeshFile, Place, Problem};
use crate::element::Order;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::tensor::{Matrix, determinant};

/// A facet with a label.
struct Labelled<'a> {
    corners: &'a [usize],
    /// Its groups, as indices; some may be of one name.
    groups: Vec<usize>,
    /// Whether a body has it on its boundary.
    met: bool,
}

impl MeshFile {
    /// The bodies in ℝᴰ by name: one for each group of cells, ascending by the groups' numbers, or
    /// one called `body` if no cell is in a group. Groups of one name are one.
    ///
    /// Cells are the elements of dimension D; those of negative orientation are turned around.
    /// Facets of dimension D − 1 that are in groups become the boundaries of the bodies they bound,
    /// under the names of their groups; a facet between two bodies becomes one of each. Facets with
    /// label 0 may lie anywhere, since that is how many programs say that there is no label.
    /// Vertices of no cell are dropped.
    ///
    /// # Errors
    /// [`Error::MeshFile`]: the mesh is of another dimension, is to be plane and is not, has cells
    /// in two bodies or twice in one, cells in no group beside cells in one, a labelled facet that
    /// bounds no body, or a body that is no [`Mesh`].
    pub fn bodies<const D: usize>(&self) -> Result<Vec<(String, Mesh<D>)>, Error> {
        self.all_bodies().map_err(|problem| self.error(problem))
    }

    /// The body of that name alone, which may share cells with others and have labelled facets
    /// inside; these are left out.
    ///
    /// # Errors
    /// As [`MeshFile::bodies`]; for a name that there is not.
    pub fn body<const D: usize>(&self, name: &str) -> Result<Mesh<D>, Error> {
        self.one_body(name).map_err(|problem| self.error(problem))
    }

    fn error(&self, problem: Problem) -> Error {
        let (path, place) = (self.path.clone(), Place::File);
        Error::MeshFile {
            path,
            place,
            problem,
        }
    }

    fn all_bodies<const D: usize>(&self) -> Result<Vec<(String, Mesh<D>)>, Problem> {
        let parts = self.parts(D)?;
        self.check_all_in_parts(D)?;
        self.check_cells_differ(&parts)?;
        let mut labelled = self.labelled_facets(D);
        let mut bodies = Vec::new();
        for part in &parts {
            let mesh = self.mesh(part, &mut labelled)?;
            bodies.push((part.name.to_string(), mesh));
        }
        self.check_met(&labelled)?;
        Ok(bodies)
    }

    fn one_body<const D: usize>(&self, name: &str) -> Result<Mesh<D>, Problem> {
        let mut parts = self.parts(D)?;
        let Some(index) = parts.iter().position(|part| part.name == name) else {
            return Err(Problem::UnknownBody {
                name: name.to_string(),
                known: parts.iter().map(|part| part.name.to_string()).collect(),
            });
        };
        let part = parts.swap_remove(index);
        self.check_cells_differ(std::slice::from_ref(&part))?;
        self.mesh(&part, &mut self.labelled_facets(D))
    }

    /// The facets in groups.
    fn labelled_facets(&self, dimension: usize) -> HashMap<Corners, Labelled<'_>> {
        let mut labelled: HashMap<Corners, Labelled> = HashMap::new();
        let blocks = self.of_dimension(dimension - 1);
        for block in blocks.filter(|block| !block.groups.is_empty()) {
            for facet in block.iter() {
                let corners = &facet[..dimension];
                let new = || Labelled {
                    corners,
                    groups: Vec::new(),
                    met: false,
                };
                let entry = labelled.entry(sorted(corners)).or_insert_with(new);
                entry.groups.extend(&block.groups);
            }
        }
        labelled
    }

    /// Checks that every labelled facet bounds some body.
    fn check_met(&self, labelled: &HashMap<Corners, Labelled>) -> Result<(), Problem> {
        let meant = |facet: &&Labelled| !facet.met && self.true_group(facet).is_some();
        let loose = labelled.values().filter(meant);
        let first = loose.min_by_key(|facet| (&facet.groups, facet.corners));
        let Some((facet, group)) = first.and_then(|f| Some((f, self.true_group(f)?))) else {
            return Ok(());
        };
        let n = facet.corners.len() as f64;
        let centre = |i: usize| facet.corners.iter().map(|&v| self.vertices[v][i] / n).sum();
        Err(Problem::LooseFacet {
            vertices: facet.corners.into(),
            at: std::array::from_fn(centre),
            boundary: group.name.clone(),
        })
    }

    /// The facet's first group that is more than a label 0.
    fn true_group(&self, facet: &Labelled) -> Option<&Group> {
        let groups = facet.groups.iter().map(|&g| &self.groups[g]);
        groups
            .filter(|group| group.number != 0)
            .min_by_key(|group| group.number)
    }

    /// The mesh of a body with its boundaries.
    fn mesh<const D: usize>(
        &self,
        part: &Part,
        labelled: &mut HashMap<Corners, Labelled>,
    ) -> Result<Mesh<D>, Problem> {
        let (order, mut cells) = self.cell_nodes::<D>(part)?;
        let mut used = cells.clone();
        used.sort_unstable();
        used.dedup();
        for node in &mut cells {
            *node = used.partition_point(|v| v < node);
        }
        let nodes = used.iter().map(|&v| self.coordinates(v)).collect();
        let mut mesh = Mesh::<D>::of_order(order, nodes, cells).map_err(|mut source| {
            if let Error::NonManifoldFacet { nodes, .. } = &mut source {
                nodes.iter_mut().for_each(|node| *node = used[*node]);
            }
            let (body, source) = (part.name.to_string(), Box::new(source));
            Problem::Body { body, source }
        })?;
        let mut by_group: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (f, facet) in mesh.exterior().enumerate() {
            let corners: Vec<usize> = facet[..D].iter().map(|&a| used[a]).collect();
            let Some(labelled) = labelled.get_mut(&sorted(&corners)) else {
                continue;
            };
            labelled.met = true;
            for &group in &labelled.groups {
                by_group.entry(group).or_default().push(f);
            }
        }
        for (group, facets) in by_group {
            let name = self.groups[group].name.clone();
            let boundary = mesh.boundaries.entry(name).or_default();
            boundary.extend(facets);
            boundary.sort_unstable();
            boundary.dedup();
        }
        Ok(mesh)
    }

    /// The order of a body's cells and all their nodes, flat, as [`Mesh::of_order`] takes them.
    fn cell_nodes<const D: usize>(&self, part: &Part) -> Result<(Order, Vec<usize>), Problem> {
        let blocks = || part.blocks.iter().map(|&b| &self.elements[b]);
        let linear = blocks().any(|block| block.kind.nodes() == D + 1);
        let order = if linear {
            Order::Linear
        } else {
            Order::Quadratic
        };
        let mut nodes = Vec::new();
        for block in blocks() {
            if block.kind.nodes() != order.cell_nodes::<D>() {
                return Err(Problem::CellOrder {
                    body: part.name.to_string(),
                    kind: block.kind,
                });
            }
            for cell in block.iter() {
                match self.volume::<D>(cell) < 0.0 {
                    true => nodes.extend(block.kind.mirrored().iter().map(|&k| cell[k])),
                    false => nodes.extend(cell),
                }
            }
        }
        Ok((order, nodes))
    }

    /// The signed volume of a cell, times D!.
    fn volume<const D: usize>(&self, cell: &[usize]) -> f64 {
        let x = |k: usize| self.vertices[cell[k]];
        determinant(&Matrix::<D>::from_fn(|i, j| x(j + 1)[i] - x(0)[i]))
    }

    fn coordinates<const D: usize>(&self, vertex: usize) -> [f64; D] {
        std::array::from_fn(|i| self.vertices[vertex][i])
    }
}

//! Builds the meshes of bodies from a file's contents.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::parts::{Corners, Part, sorted};
use super::{Group, MeshFile, Place, Problem};
use crate::element::Order;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::tensor::{Matrix, determinant};

/// A facet with a label.
struct Labelled<'a> {
    corners: &'a [usize],
    /// The indices of its groups; several groups may have one name.
    groups: Vec<usize>,
    /// Whether it is a facet of a body.
    met: bool,
}

/// A body that is being read.
struct Body<const D: usize> {
    mesh: Mesh<D>,
    /// The numbers of its nodes in the file.
    used: Vec<usize>,
}

impl MeshFile {
    /// The bodies in ℝᴰ by name: one for each group of cells, in ascending order of the groups'
    /// numbers, or one called `body` if no cell is in a group. Groups with the same name are
    /// merged.
    ///
    /// Cells are the elements of dimension D; cells of negative orientation are reversed. Facets of
    /// dimension D − 1 in groups become boundaries of the bodies that they bound, with the names of
    /// their groups; a facet between two bodies becomes a boundary facet of both. Facets in groups
    /// inside a body become [`Mesh::inner_facets`]. Facets with label 0 are ignored where they bound
    /// no body, since many programs write 0 for a facet without a label. Vertices without a cell are
    /// dropped.
    ///
    /// # Errors
    /// [`Error::MeshFile`] if the mesh has another dimension, is not plane for D = 2, has cells in
    /// two bodies or twice in one, has cells in no group beside cells in one, has a labelled facet
    /// that belongs to no body, or has a body that is not a valid [`Mesh`].
    pub fn bodies<const D: usize>(&self) -> Result<Vec<(String, Mesh<D>)>, Error> {
        self.all_bodies().map_err(|problem| self.error(problem))
    }

    /// The body with this name alone. It may share cells with other bodies. Facets of the others are
    /// left out.
    ///
    /// # Errors
    /// As [`MeshFile::bodies`]; also if the name does not exist.
    pub fn body<const D: usize>(&self, name: &str) -> Result<Mesh<D>, Error> {
        self.one_body(name).map_err(|problem| self.error(problem))
    }

    /// All cells as one body, whose regions are those of [`MeshFile::bodies`]: a body of several laws. A labelled facet between two
    /// regions is one of [`Mesh::inner_facets`].
    ///
    /// # Errors
    /// As [`MeshFile::bodies`]; also if regions have cells of different orders.
    pub fn with_regions<const D: usize>(&self) -> Result<Mesh<D>, Error> {
        self.whole().map_err(|problem| self.error(problem))
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
            bodies.push(self.body_of(part, &mut labelled)?);
        }
        self.name_inner(&mut bodies, &mut labelled);
        self.check_met(&labelled)?;
        let bodies = bodies.into_iter();
        let names = parts.iter().map(|part| part.name.to_string());
        Ok(names.zip(bodies.map(|body| body.mesh)).collect())
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
        let mut labelled = self.labelled_facets(D);
        let mut body = self.body_of(&part, &mut labelled)?;
        self.name_inner(std::slice::from_mut(&mut body), &mut labelled);
        Ok(body.mesh)
    }

    fn whole<const D: usize>(&self) -> Result<Mesh<D>, Problem> {
        let parts = self.parts(D)?;
        self.check_all_in_parts(D)?;
        self.check_cells_differ(&parts)?;
        let whole = Part {
            name: "body",
            region: None,
            blocks: parts.iter().flat_map(|part| part.blocks.clone()).collect(),
        };
        let mut labelled = self.labelled_facets(D);
        let mut body = self.body_of(&whole, &mut labelled)?;
        self.name_inner(std::slice::from_mut(&mut body), &mut labelled);
        self.check_met(&labelled)?;
        // cells are in the order of the parts
        let mut next = 0;
        for part in &parts {
            let cells = part.blocks.iter().map(|&b| self.elements[b].len());
            let end = next + cells.sum::<usize>();
            let regions = &mut body.mesh.regions;
            regions.insert(part.name.to_string(), (next..end).collect());
            next = end;
        }
        Ok(body.mesh)
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

    /// Checks that every labelled facet belongs to a body.
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

    /// The first group of the facet other than label 0.
    fn true_group(&self, facet: &Labelled) -> Option<&Group> {
        let groups = facet.groups.iter().map(|&g| &self.groups[g]);
        groups
            .filter(|group| group.number != 0)
            .min_by_key(|group| group.number)
    }

    /// The mesh of a body with its boundaries.
    fn body_of<const D: usize>(
        &self,
        part: &Part,
        labelled: &mut HashMap<Corners, Labelled>,
    ) -> Result<Body<D>, Problem> {
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
            let name = self.keep_label(&mut mesh, group);
            let boundary = mesh.boundaries.entry(name).or_default();
            boundary.extend(facets);
            boundary.sort_unstable();
            boundary.dedup();
        }
        mesh.region = part.region.and_then(|region| region.try_into().ok());
        Ok(Body { mesh, used })
    }

    /// The name of a group, whose number the mesh keeps as its label. Of several numbers the smallest is kept.
    fn keep_label<const D: usize>(&self, mesh: &mut Mesh<D>, group: usize) -> String {
        let Group { number, name, .. } = &self.groups[group];
        if let Ok(number) = i32::try_from(*number) {
            let label = mesh.labels.entry(name.clone()).or_insert(number);
            *label = number.min(*label);
        }
        name.clone()
    }

    /// Names the labelled facets between two cells of a body.
    fn name_inner<const D: usize>(
        &self,
        bodies: &mut [Body<D>],
        labelled: &mut HashMap<Corners, Labelled>,
    ) {
        if labelled.values().all(|facet| facet.met) {
            return;
        }
        for Body { mesh, used } in bodies {
            let mut found = BTreeSet::new();
            for corners in (0..mesh.len()).map(|cell| mesh.corners(cell)) {
                for omitted in 0..=D {
                    let facet = std::array::from_fn(|k| corners[k + usize::from(k >= omitted)]);
                    let key = sorted(&facet.map(|a: usize| used[a]));
                    let facets = labelled.get_mut(&key).filter(|facet| !facet.met);
                    let Some(labelled) = facets else { continue };
                    labelled.met = true;
                    let groups = labelled.groups.iter();
                    let groups = groups.filter(|&&group| self.groups[group].number != 0);
                    found.extend(groups.map(|&group| (group, facet)));
                }
            }
            for (group, facet) in found {
                let name = self.keep_label(mesh, group);
                mesh.inner.entry(name).or_default().push(facet);
            }
        }
    }

    /// The order of a body's cells and all their nodes, flat, as [`Mesh::of_order`] expects them.
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

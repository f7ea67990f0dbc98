//! An audit of states: what the bodies of a scene do to each other and to themselves, whether their
//! surfaces are declared for contact or not.
//!
//! It shares nothing with the contact search. Bodies are cut into flat simplices on their nodes, a
//! quadratic cell into 2ᴰ, a quadratic facet into 2ᴰ⁻¹. A node in a cell of another body, or in a
//! cell of its own body outside its neighbourhood, is inside material; an exterior edge through an
//! exterior facet is an intersection. Depths are shares of what the material allows there: of the
//! facets, or of the thickness where that is smaller. Volumes of quadratic cells are bounded between their nodes, too.
//!
//! Of an obstacle it takes the signed distance, and looks for points of the exterior where it is negative, on all sides of the
//! bodies that have a side on it. In their cells it looks for the obstacle's core, so that obstacles that are smaller than
//! the facets, and those wholly inside a body, are found, too.

mod bins;
mod fits;
mod measures;
mod obstacles;
mod sag;
mod simplex;
mod thickness;
mod topology;

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use crate::element::Order;
use crate::model::Scene;
use crate::tensor::{Matrix, Vector, facet_normal};
use bins::Bins;
pub(crate) use fits::Fit;
pub use measures::LeastVolume;
use measures::Measures;
use obstacles::Blocks;
use simplex::{distance, pierced};
use topology::{Cell, Topology};

/// The audit of a scene: the topology of its bodies in simplices.
pub struct Audit<const D: usize> {
    topology: Topology<D>,
    /// X (UL).
    reference: Vec<Vector<D>>,
    /// The inverse of each simplex's edges in the reference configuration (1/UL).
    inverses: Vec<Matrix<D>>,
    /// Whether the bodies are ones of revolution.
    is_revolved: bool,
    /// Whether a body's law is for small strains.
    is_linear: Vec<bool>,
    /// The order of each body's cells.
    orders: Vec<Order>,
    obstacles: Vec<Blocks<D>>,
    /// For each face of the topology, whether its nodes are held along its normal.
    is_held: Vec<bool>,
    /// The positions that were asked for last: a state is audited when it is accepted, and again by its certificate and its
    /// record.
    last: Mutex<Option<State<D>>>,
    /// The last positions of all nodes (UL) at which no boxes met that were larger by [`Audit::margin`] on all sides. Where no
    /// coordinate has changed by more than half of the margin since, the boxes themselves cannot meet.
    clear: Mutex<Option<Vec<Vector<D>>>>,
    /// A share of the smallest face (UL).
    margin: f64,
}

/// Positions of all nodes (UL), and what was found there so far.
struct State<const D: usize> {
    x: Vec<Vector<D>>,
    overlaps: Option<Vec<Overlap<D>>>,
    measures: Option<Measures<D>>,
}

/// The findings of an audit at one state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings<const D: usize> {
    /// The worst overlap of each two bodies, and of each body with itself, that overlap.
    pub overlaps: Vec<Overlap<D>>,
    /// The number of simplices whose volume is not positive, or that of quadratic cells in which the volume ratio is not
    /// positive everywhere if that is larger. Simplices of a body of revolution beyond the axis count, too.
    pub inverted: usize,
    /// The smallest volume ratio within the cells, and where it is; `None` without cells. Of a body of revolution it is the ratio of
    /// areas in the half-plane, without the stretch around the axis.
    pub least_volume: Option<LeastVolume<D>>,
    /// The largest norm of ½(∇u + ∇uᵀ) in bodies with a law for small strains; 0 without such.
    pub strain: f64,
    /// The largest rotation (radians) in bodies with a law for small strains: |½(∇u − ∇uᵀ)|/√2.
    pub rotation: f64,
}

/// Two exteriors that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap<const D: usize> {
    /// The indices of the bodies; they are equal where a body overlaps itself. Obstacles are numbered after the bodies, and
    /// are always the second.
    pub bodies: [usize; 2],
    /// A point of the first body inside the second (UL).
    pub at: Vector<D>,
    /// The distance of that point from the exterior of the second (UL). Where the core of an obstacle is inside a body, the
    /// distance of the core from the body's exterior is added: the obstacle's way out.
    pub depth: f64,
    /// The depth divided by the length of the facets there, or by the thickness of either body there if
    /// that is smaller.
    pub relative: f64,
    /// The depth divided by the thickness, or by twice the largest face if that is smaller.
    of_thickness: f64,
    /// How far the nearest flat piece of the second's exterior is from a round surface of which it is a chord (UL): a depth below it shows the mesh.
    pub(crate) sag: f64,
    /// The nodes of the nearest flat piece of the second's exterior, by their numbers in the scene; in an obstacle, of the
    /// piece of the first's that is inside.
    pub(crate) face: [usize; D],
}

/// The boxes of all cells and faces at one state.
struct Trees<const D: usize> {
    cells: Boxes<D>,
    faces: Boxes<D>,
}

impl<const D: usize> Overlap<D> {
    /// The largest relative depth of bodies that are in contact (no unit). It separates the project's own scenes: the deepest
    /// nodes of sound ones, at corners, are at 0.2, and bodies that pass through each other at 1 and more.
    pub const LIMIT: f64 = 0.3;
}

/// A search tree over boxes with the index of what is in each.
type Boxes<const D: usize> = RTree<GeomWithData<Rectangle<[f64; D]>, usize>>;

impl<const D: usize> Audit<D> {
    /// The audit of `scene` with reference positions `X` of all its nodes (UL), body by body.
    pub fn new(scene: &Scene<D>, X: &[Vector<D>]) -> Self {
        let topology = Topology::new(scene, X);
        let inverse = |cell: &Cell| crate::tensor::inverse_transpose(&edges(cell, X)).transpose();
        let sizes = topology.faces.iter().map(|face| face.size);
        let margin = Self::MARGIN * sizes.fold(f64::INFINITY, f64::min);
        let mut held = Vec::new();
        for body in scene.bodies() {
            let is_held = |value: &Option<f64>| value.is_some() && !body.is_rigid();
            held.extend(body.prescribed().iter().map(is_held));
        }
        let is_held = |face: &topology::Face<D>| {
            let normal = facet_normal(&face.nodes.map(|a| X[a])).normalize();
            let along = (0..D).filter(|&i| normal[i].abs() > Self::ALONG_AXIS);
            let mut nodes = along.map(|i| face.nodes.iter().all(|a| held[D * a + i]));
            nodes.any(|is_held| is_held)
        };
        let is_held = topology.faces.iter().map(is_held).collect();
        Audit {
            inverses: topology.cells.iter().map(inverse).collect(),
            topology,
            reference: X.to_vec(),
            is_revolved: scene.is_of_revolution(),
            is_linear: scene.bodies().iter().map(|b| b.is_small_strain()).collect(),
            orders: scene.bodies().iter().map(|b| b.mesh().order()).collect(),
            is_held,
            obstacles: scene
                .obstacles()
                .iter()
                .enumerate()
                .map(|(index, obstacle)| {
                    let mut bodies = vec![false; scene.bodies().len()];
                    let own = scene.obstructed().iter().filter(|(_, of)| *of == index);
                    own.for_each(|(side, _)| bodies[side.body.index()] = true);
                    Blocks {
                        obstacle: obstacle.clone(),
                        pose: obstacle.pose(0.0),
                        bodies,
                    }
                })
                .collect(),
            last: Mutex::new(None),
            clear: Mutex::new(None),
            margin,
        }
    }

    /// The smallest height of a body's simplices in the reference configuration (UL), and their volume.
    pub(crate) fn height_and_volume(&self, body: usize) -> [f64; 2] {
        let cells = self.topology.cells.iter().zip(&self.inverses);
        let own = cells.filter(|(cell, _)| cell.body == body);
        own.fold([f64::INFINITY, 0.0], |[least, volume], (_, inverse)| {
            // rows are the gradients of weights, which fall from 1 to 0 over a height
            let rows = inverse.row_iter().map(|row| row.norm());
            let height = 1.0 / rows.fold(inverse.row_sum().norm(), f64::max);
            let factorial = if D == 2 { 2.0 } else { 6.0 };
            let own = 1.0 / (factorial * crate::tensor::determinant(inverse).abs());
            [least.min(height), volume + own]
        })
    }

    /// Places obstacles where they are at pseudo-time `t`.
    pub(crate) fn set_load(&mut self, t: f64) {
        for blocks in &mut self.obstacles {
            let pose = blocks.obstacle.pose(t);
            if blocks.pose != pose {
                blocks.pose = pose;
                *self.last.get_mut().unwrap_or_else(PoisonError::into_inner) = None;
            }
        }
    }

    /// The flat pieces of all exteriors with another one behind them, at most twice the largest piece away: the nodes of
    /// both by their scene numbers, longest edge of the first (UL), and the thickness of the material between them (UL).
    pub(crate) fn opposites(&self) -> impl Iterator<Item = ([&[usize]; 2], f64, f64)> {
        let faces = &self.topology.faces;
        faces.iter().filter_map(|face| {
            let opposite = &faces[face.opposite?];
            Some((
                [&face.nodes[..], &opposite.nodes[..]],
                face.size,
                face.thickness,
            ))
        })
    }

    /// All findings at positions `x` of all nodes (UL).
    pub fn at(&self, x: &[Vector<D>]) -> Findings<D> {
        let measures = self.measures(x);
        Findings {
            overlaps: self.worst_overlaps(x),
            inverted: measures.inverted,
            least_volume: measures.least_volume,
            strain: measures.strain,
            rotation: measures.rotation,
        }
    }

    /// The smallest volume ratio at positions `x` of all nodes (UL).
    pub(crate) fn least_volume(&self, x: &[Vector<D>]) -> Option<LeastVolume<D>> {
        self.measures(x).least_volume
    }

    /// The measures at positions `x` of all nodes (UL), which are kept.
    fn measures(&self, x: &[Vector<D>]) -> Measures<D> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let measures = &mut Self::state(&mut last, x).measures;
        *measures.get_or_insert_with(|| self.measure(x))
    }

    /// F of a simplex: the gradient of x by X.
    fn deformation(&self, cell: usize, x: &[Vector<D>]) -> Matrix<D> {
        edges(&self.topology.cells[cell], x) * self.inverses[cell]
    }

    /// The overlap at positions `x` of all nodes (UL) that exceeds [`Overlap::LIMIT`] most, with what is `granted` to the two
    /// bodies in addition; `None` if there is none.
    pub fn deep_overlap(
        &self,
        x: &[Vector<D>],
        granted: impl Fn([usize; 2]) -> f64,
    ) -> Option<Overlap<D>> {
        let beyond = |overlap: &Overlap<D>| overlap.relative - granted(overlap.bodies);
        let deep = self.overlaps(x).into_iter();
        let deep = deep.filter(|overlap| beyond(overlap) > Overlap::<D>::LIMIT);
        deep.max_by(|a, b| beyond(a).total_cmp(&beyond(b)))
    }

    /// For each two bodies that overlap at positions `x` of all nodes (UL), the smaller index first, the largest depths:
    /// relative, and as a share of the thickness.
    pub(crate) fn depths(&self, x: &[Vector<D>]) -> BTreeMap<[usize; 2], [f64; 2]> {
        let mut depths = BTreeMap::new();
        for overlap in self.overlaps(x) {
            let [a, b] = overlap.bodies;
            let [relative, share] = depths.entry([a.min(b), a.max(b)]).or_insert([0.0_f64; 2]);
            *relative = relative.max(overlap.relative);
            *share = share.max(overlap.of_thickness);
        }
        depths
    }

    /// The worst overlap of each two bodies.
    fn worst_overlaps(&self, x: &[Vector<D>]) -> Vec<Overlap<D>> {
        let mut worst: BTreeMap<[usize; 2], Overlap<D>> = BTreeMap::new();
        for overlap in self.overlaps(x) {
            let [a, b] = overlap.bodies;
            let kept = worst.entry([a.min(b), a.max(b)]).or_insert(overlap);
            if overlap.relative > kept.relative {
                *kept = overlap;
            }
        }
        worst.into_values().collect()
    }

    /// All overlaps at positions `x` of all nodes (UL), which are kept.
    pub(crate) fn overlaps(&self, x: &[Vector<D>]) -> Vec<Overlap<D>> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let state = Self::state(&mut last, x);
        let overlaps = &mut state.overlaps;
        let find = || {
            let mut found = self.find_overlaps(x);
            found.extend(self.in_obstacles(x));
            for (index, blocks) in self.obstacles.iter().enumerate() {
                found.extend(self.around_obstacle(x, index, blocks));
            }
            found
        };
        overlaps.get_or_insert_with(find).clone()
    }

    /// What is known at positions `x` of all nodes (UL).
    fn state<'a>(last: &'a mut Option<State<D>>, x: &[Vector<D>]) -> &'a mut State<D> {
        let known = last.take().filter(|state| state.x == x);
        last.insert(known.unwrap_or_else(|| State {
            x: x.to_vec(),
            overlaps: None,
            measures: None,
        }))
    }

    /// The overlaps with obstacles at positions `x` of all nodes (UL), one for each face.
    fn in_obstacles(&self, x: &[Vector<D>]) -> Vec<Overlap<D>> {
        let obstacles = self.obstacles.iter().enumerate();
        let found = obstacles.flat_map(|(index, blocks)| {
            let faces = self.topology.faces.iter();
            let faces = faces.filter(|face| blocks.bodies[face.body]);
            faces.filter_map(move |face| {
                let corners = face.nodes.map(|a| x[a]);
                let (depth, at) = blocks.deepest(corners)?;
                let overlap = self.in_obstacle(face, index, (depth, at));
                (overlap.relative > Self::TOUCHES).then_some(overlap)
            })
        });
        found.collect()
    }

    /// The overlaps with an obstacle whose core is inside bodies, one for each cell, at positions `x` of all nodes (UL). Bodies are
    /// left through faces that are not held, as those on planes of symmetry are.
    fn around_obstacle<'a>(
        &'a self,
        x: &'a [Vector<D>],
        index: usize,
        blocks: &'a Blocks<D>,
    ) -> impl Iterator<Item = Overlap<D>> + 'a {
        let cells = self.topology.cells.iter();
        let cells = cells.filter(|cell| blocks.bodies[cell.body]);
        cells.filter_map(move |cell| {
            let (depth, at) = blocks.core(cell.nodes.map(|a| x[a]))?;
            let faces = self.topology.faces.iter().zip(&self.is_held);
            let free = faces.filter(|(face, is_held)| face.body == cell.body && !**is_held);
            let ways = free.map(|(face, _)| (distance(&at, &face.nodes.map(|a| x[a])), face));
            let (way, face) = ways.min_by(|a, b| a.0.total_cmp(&b.0))?;
            Some(self.in_obstacle(face, index, (depth + way, at)))
        })
    }

    /// The overlap of a body with an obstacle, so deep (UL) at a place near a face of the body.
    fn in_obstacle(
        &self,
        face: &topology::Face<D>,
        index: usize,
        (depth, at): (f64, Vector<D>),
    ) -> Overlap<D> {
        Overlap {
            bodies: [face.body, self.orders.len() + index],
            at,
            depth,
            relative: depth / face.size.min(face.thickness),
            of_thickness: depth / face.thickness.min(self.topology.thick),
            sag: 0.0,
            face: face.nodes,
        }
    }

    /// All overlaps of bodies at positions `x` of all nodes (UL).
    fn find_overlaps(&self, x: &[Vector<D>]) -> Vec<Overlap<D>> {
        let mut clear = self.clear.lock().unwrap_or_else(PoisonError::into_inner);
        if clear.as_ref().is_some_and(|clear| self.is_near(clear, x)) {
            return Vec::new();
        }
        let trees = self.trees(x);
        *clear = self.is_clear(x, &trees).then(|| x.to_vec());
        if clear.is_some() {
            return Vec::new();
        }
        drop(clear);
        let mut overlaps = self.nodes_inside(x, &trees);
        overlaps.extend(self.edges_inside(x, &trees));
        overlaps
    }

    /// Whether no coordinate differs by more than half of the margin.
    fn is_near(&self, clear: &[Vector<D>], x: &[Vector<D>]) -> bool {
        let is_near = |(a, b): (&Vector<D>, &Vector<D>)| {
            (0..D).all(|i| (b[i] - a[i]).abs() <= 0.5 * self.margin)
        };
        clear.iter().zip(x).all(is_near)
    }

    /// Whether no exterior edge or node comes within the margin of a cell or face outside its neighbourhood: whether none of their
    /// boxes meet.
    fn is_clear(&self, x: &[Vector<D>], trees: &Trees<D>) -> bool {
        let Topology { cells, faces, .. } = &self.topology;
        let edges = self.topology.edges.iter().all(|edge| {
            let mut near = trees
                .faces
                .locate_in_envelope_intersecting(self.around(edge, x));
            near.all(|leaf| self.is_own(edge, faces[leaf.data].body, &faces[leaf.data].nodes))
        });
        edges
            && self.topology.exterior_nodes.iter().all(|&a| {
                let mut near = trees
                    .cells
                    .locate_in_envelope_intersecting(self.around(&[a], x));
                near.all(|leaf| {
                    let cell = &cells[leaf.data];
                    self.is_own(&[a], cell.body, &cell.nodes[..=D])
                })
            })
    }

    /// The box of these nodes, larger by the margin on all sides.
    fn around(&self, nodes: &[usize], x: &[Vector<D>]) -> AABB<[f64; D]> {
        let own = aabb(nodes, x);
        let corner = |corner: [f64; D], by: f64| corner.map(|x| x + by);
        AABB::from_corners(
            corner(own.lower(), -self.margin),
            corner(own.upper(), self.margin),
        )
    }

    /// The search trees of the cells near exterior edges, and of all faces.
    fn trees(&self, x: &[Vector<D>]) -> Trees<D> {
        let Topology {
            cells,
            blocks,
            faces,
            edges,
            ..
        } = &self.topology;
        // all points that are looked for lie on exterior edges, and most cells lie away from them
        let bins = Bins::new(edges.iter().map(|edge| self.around(edge, x)));
        let blocks = blocks
            .iter()
            .filter(|block| bins.meet(&aabb(&block.nodes, x)));
        let cells = blocks
            .flat_map(|block| &block.cells)
            .map(|&k| (k, aabb(&cells[k].nodes[..=D], x)))
            .filter(|(_, cell)| bins.meet(cell));
        let faces = faces.iter().map(|face| aabb(&face.nodes, x));
        Trees {
            cells: tree(cells),
            faces: tree(faces.enumerate()),
        }
    }

    /// An overlap on the straight way of all nodes from `before` to `after` (UL) that is deeper than
    /// [`Overlap::LIMIT`] of the thickness and what is `granted` to the two bodies in addition, or `None`. Bodies that slide on each other do not move on
    /// straight lines, and overlap a little on the way; shares of the thickness leave that out. The way is
    /// examined at a fixed number of stops at most.
    pub fn passage(
        &self,
        before: &[Vector<D>],
        after: &[Vector<D>],
        granted: impl Fn([usize; 2]) -> f64,
    ) -> Option<Overlap<D>> {
        let mut stops = self.stops(before, after, |_| true);
        stops.find_map(|x| first_beyond(self.find_overlaps(&x), &granted))
    }

    /// The positions of all nodes (UL) at stops on their straight ways, which the longest of those that `counts` sets apart.
    fn stops<'a>(
        &self,
        before: &'a [Vector<D>],
        after: &'a [Vector<D>],
        counts: impl Fn(usize) -> bool,
    ) -> impl Iterator<Item = Vec<Vector<D>>> {
        let way = move || before.iter().zip(after);
        let ways = way().enumerate().filter(|(a, _)| counts(*a));
        let moved = ways.map(|(_, (a, b))| (b - a).norm()).fold(0.0, f64::max);
        let stops = (moved / (Self::STRIDE * self.topology.thinnest())).ceil();
        let stops = stops.min(Self::MOST_STOPS);
        (1..stops as usize).map(move |k| {
            let t = k as f64 / stops;
            way().map(|(a, b)| a * (1.0 - t) + b * t).collect()
        })
    }

    /// As [`Audit::passage`], of the cores of obstacles through bodies: on the way as the obstacles see it, which have moved from where
    /// they were at pseudo-time `from` to where they are.
    pub(crate) fn obstacle_passage(
        &self,
        before: &[Vector<D>],
        after: &[Vector<D>],
        from: f64,
        granted: impl Fn([usize; 2]) -> f64,
    ) -> Option<Overlap<D>> {
        let through = |(index, blocks): (usize, &Blocks<D>)| {
            let then = blocks.obstacle.pose(from);
            let is_own = |a: usize| blocks.bodies[self.topology.body_of[a]];
            let before = before.iter().map(|x| blocks.pose.place(&then.back(x)));
            let before: Vec<_> = before.collect();
            let mut stops = self.stops(&before, after, is_own);
            stops.find_map(|x| first_beyond(self.around_obstacle(&x, index, blocks), &granted))
        };
        self.obstacles.iter().enumerate().find_map(through)
    }

    /// The relative depth of bodies that touch, from round-off.
    const TOUCHES: f64 = 1e-9;
    /// The component of a normal that is along an axis.
    const ALONG_AXIS: f64 = 1.0 - 1e-9;
    /// The margin within which boxes are looked for, as a share of the smallest face. In regular meshes, cells outside the
    /// neighbourhood of a node are a face away. Its value changes how often is searched, not what is found; it was chosen by
    /// the time of one scene, a block in a hundred increments.
    const MARGIN: f64 = 0.75;
    /// The way between two stops, as a share of the smallest thickness. An edge that crosses a body of thickness 1 is at
    /// most ½ deep, and deeper than [`Overlap::LIMIT`] for 0.4 of its way.
    const STRIDE: f64 = 0.3;
    /// The largest number of stops on a way.
    const MOST_STOPS: f64 = 32.0;

    /// The overlaps of exterior nodes with other bodies, or with other parts of their own.
    fn nodes_inside(&self, x: &[Vector<D>], trees: &Trees<D>) -> Vec<Overlap<D>> {
        let exterior = self.topology.exterior_nodes.iter();
        exterior
            .flat_map(|&a| self.inside(x, trees, &[a], x[a]))
            .collect()
    }

    /// The overlaps of exterior edges that pass through exterior faces: of the middle of each part of an
    /// edge between two such points.
    fn edges_inside(&self, x: &[Vector<D>], trees: &Trees<D>) -> Vec<Overlap<D>> {
        let mut found = Vec::new();
        for edge in &self.topology.edges {
            let near = trees.faces.locate_in_envelope_intersecting(aabb(edge, x));
            let others = near.map(|leaf| &self.topology.faces[leaf.data]);
            let others = others.filter(|face| !self.is_own(edge, face.body, &face.nodes));
            let ends = edge.map(|a| x[a]);
            let cuts = others.filter_map(|face| pierced(&ends, &face.nodes.map(|b| x[b])));
            let mut cuts: Vec<f64> = cuts.collect();
            if cuts.is_empty() {
                continue;
            }
            cuts.extend([0.0, 1.0]);
            cuts.sort_by(f64::total_cmp);
            for part in cuts.windows(2) {
                let middle = 0.5 * (part[0] + part[1]);
                let point = ends[0] * (1.0 - middle) + ends[1] * middle;
                found.extend(self.inside(x, trees, edge, point));
            }
        }
        found
    }

    /// The overlaps of a point on these exterior nodes with each body in whose cells it is.
    fn inside(
        &self,
        x: &[Vector<D>],
        trees: &Trees<D>,
        owners: &[usize],
        point: Vector<D>,
    ) -> Vec<Overlap<D>> {
        let topology = &self.topology;
        let near = trees.cells.locate_all_at_point(point.into());
        let cells = near.map(|leaf| &topology.cells[leaf.data]);
        let holding = cells.filter(|cell| {
            !self.is_own(owners, cell.body, &cell.nodes) && simplex::holds(&cell.nodes, x, &point)
        });
        let mut bodies: Vec<usize> = holding.map(|cell| cell.body).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let overlap = |body: usize| {
            let counts = |face: &topology::Face<D>| {
                face.body == body && !self.is_own(owners, body, &face.nodes)
            };
            let (depth, face) = self.nearest(x, &trees.faces, point, counts)?;
            let (size, thickness) = topology.around(owners[0]);
            let face = &topology.faces[face];
            let thickness = thickness.min(face.thickness);
            let unit = size.max(face.size).min(thickness);
            let overlap = Overlap {
                bodies: [topology.body_of[owners[0]], body],
                at: point,
                depth,
                relative: depth / unit,
                of_thickness: depth / thickness.min(topology.thick),
                sag: face.sag,
                face: face.nodes,
            };
            (overlap.relative > Self::TOUCHES).then_some(overlap)
        };
        bodies.into_iter().filter_map(overlap).collect()
    }

    /// Whether `nodes` of `body` belong to the neighbourhood of `owners` on their own body.
    fn is_own(&self, owners: &[usize], body: usize, nodes: &[usize]) -> bool {
        let topology = &self.topology;
        body == topology.body_of[owners[0]] && owners.iter().any(|&a| topology.is_near(a, nodes))
    }

    /// The distance of a point from the exterior faces that count (UL), and the nearest one.
    fn nearest(
        &self,
        x: &[Vector<D>],
        faces: &Boxes<D>,
        point: Vector<D>,
        counts: impl Fn(&topology::Face<D>) -> bool,
    ) -> Option<(f64, usize)> {
        let mut nearest: Option<(f64, usize)> = None;
        let look = |index: usize, nearest: &mut Option<(f64, usize)>| {
            let face = &self.topology.faces[index];
            if counts(face) {
                let depth = distance(&point, &face.nodes.map(|b| x[b]));
                if nearest.is_none_or(|(least, _)| depth < least) {
                    *nearest = Some((depth, index));
                }
            }
        };
        // most points are close to a face: whose boxes meet a small one is found faster than which are the nearest
        let near = Vector::repeat(self.margin);
        let around = AABB::from_corners((point - near).into(), (point + near).into());
        for leaf in faces.locate_in_envelope_intersecting(around) {
            look(leaf.data, &mut nearest);
        }
        if nearest.is_some_and(|(depth, _)| depth <= self.margin) {
            return nearest;
        }
        // by the distance of their boxes, which is at most their own
        for (leaf, at_least_2) in faces.nearest_neighbor_iter_with_distance_2(point.into()) {
            if nearest.is_some_and(|(distance, _)| at_least_2 > distance * distance) {
                break;
            }
            look(leaf.data, &mut nearest);
        }
        nearest
    }
}

/// The first overlap that is deeper than [`Overlap::LIMIT`] of the thickness and what is `granted` to the two bodies in addition.
fn first_beyond<const D: usize>(
    overlaps: impl IntoIterator<Item = Overlap<D>>,
    granted: impl Fn([usize; 2]) -> f64,
) -> Option<Overlap<D>> {
    let limit = |bodies| Overlap::<D>::LIMIT + granted(bodies);
    let mut overlaps = overlaps.into_iter();
    overlaps.find(|overlap| overlap.of_thickness > limit(overlap.bodies))
}

/// The edges of a simplex from its first node, as columns (UL).
fn edges<const D: usize>(cell: &Cell, x: &[Vector<D>]) -> Matrix<D> {
    let columns: [_; D] = std::array::from_fn(|i| x[cell.nodes[i + 1]] - x[cell.nodes[0]]);
    Matrix::from_columns(&columns)
}

fn tree<const D: usize>(boxes: impl Iterator<Item = (usize, AABB<[f64; D]>)>) -> Boxes<D> {
    let leaf = |(k, envelope)| GeomWithData::new(Rectangle::from_aabb(envelope), k);
    RTree::bulk_load(boxes.map(leaf).collect())
}

fn aabb<const D: usize>(nodes: &[usize], x: &[Vector<D>]) -> AABB<[f64; D]> {
    let low = nodes.iter().fold(x[nodes[0]], |low, &a| low.inf(&x[a]));
    let high = nodes.iter().fold(x[nodes[0]], |high, &a| high.sup(&x[a]));
    AABB::from_corners(low.into(), high.into())
}

#[cfg(test)]
mod tests;

//! The contact surfaces and passes of a scene, and the search between them.

mod depths;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use contact_core::friction::SlipRows;
use contact_core::gaps::{LinearGaps, RowKey, Sampling};
use contact_core::{Error, Stop};

use super::extent::Extent;
use super::initial_gaps::{Depths, InitialOverlaps};
use super::kinematics::Kinematics;
use super::switches::Switches;
use super::{Geometry, InitialGaps, Integration, Pair, Passes, Scene, Side};
use crate::audit::{Audit, Fit};
use crate::contact::corner::{self, Corners, SharpCorners, sharp_nodes};
use crate::contact::edge::{self, sharp_edges};
use crate::contact::obstacle::Placed;
use crate::contact::rows::{PassRows, Unknowns};
use crate::contact::stencil::{Projected, on_obstacle, projected_unless};
use crate::contact::variation::Variation;
use crate::contact::{Against, Master, Obstacle, Pass, Projection, Surface};
use crate::tensor::Vector;

/// The default search radius in [`Geometry::Current`], as a share of the scene's diagonal. It decides
/// which integration points count.
const REACH: f64 = 0.1;
/// The largest distance that surfaces may keep, as a share of the search radius, towards which points lose their weight.
pub(super) const OFFSET: f64 = 0.25;
/// How much closer two points come at most, in units of the largest displacement: components, two bodies, and shape functions
/// that exceed 1.
pub(super) const WAY: f64 = 8.0;
/// Shape functions take displacements between nodes beyond those at nodes, and test functions that are not positive weigh
/// them beyond their values: together by less than this factor.
const BEYOND: f64 = 2.0;

/// Rows closed by more than this share of the scene's diagonal were not to be left out.
const TOUCHES: f64 = 1e-12;

/// The contact surfaces and passes of a scene.
pub(super) struct ContactSet<const D: usize> {
    pub surfaces: Vec<Arc<Surface<D>>>,
    /// The obstacles, which passes number after the surfaces, and the number of bodies, after which all else numbers them.
    pub obstacles: Vec<Placed<D>>,
    bodies: usize,
    /// The number of Gauss points on obstacles, for each facet and direction.
    obstacle_points: usize,
    pub passes: Vec<Pass>,
    /// For each pass, whether it exchanges the roles that its pair was declared with.
    reversed: Vec<bool>,
    /// The distances that the surfaces of passes keep, by slave and master in ascending order (UL); most have none.
    offsets: BTreeMap<[usize; 2], f64>,
    /// The coefficients of friction of passes, likewise; most have none.
    frictions: BTreeMap<[usize; 2], f64>,
    /// When passes count.
    switches: Switches,
    pub geometry: Geometry,
    integration: Integration,
    projection: Projection,
    /// The corners and edges that may have rows.
    corners: Option<SharpCorners<D>>,
    /// Whether they have rows from the start of a run, and whether they have at present.
    holds_from_start: bool,
    holds: AtomicBool,
    /// The search radius of integration points (UL).
    pub reach: f64,
    /// Whether the radius is the default.
    is_reach_free: bool,
    /// The extent of each surface at X.
    extents: Vec<Extent<D>>,
    /// [`WAY`], but for tests that plan wrongly.
    pub way: f64,
    /// Whether [`ContactSet::unplanned`] has found that the plan does not hold.
    is_refuted: AtomicBool,
    initial_gaps: InitialGaps,
    initial_overlaps: InitialOverlaps,
    /// How deep the bodies of pairs start inside each other, and bodies inside obstacles; empty if overlaps are refused.
    fits: BTreeMap<[usize; 2], Fit>,
    /// The surfaces at the most recent positions, and how many sets of positions there have been.
    located: Mutex<Option<Arc<Located<D>>>>,
    built: AtomicUsize,
    /// The request to stop of the solve under way.
    pub stop: Option<Stop>,
    /// The result of [`ContactSet::inside`] at the last positions that were asked for, and how many there have been.
    inside: Mutex<Option<Inside<D>>>,
    inside_searched: AtomicUsize,
}

/// Positions of all nodes (UL), and the nodes inside other surfaces there, pass by pass.
type Inside<const D: usize> = (Vec<Vector<D>>, Arc<Vec<Vec<(usize, f64)>>>);

/// All surfaces at the positions at which contact is searched, each with normals and a search tree.
pub(super) struct Located<const D: usize> {
    /// The positions of all nodes (UL): X in [`Geometry::Reference`], x in [`Geometry::Current`].
    pub x: Vec<Vector<D>>,
    surfaces: Vec<Arc<Surface<D>>>,
    projection: Projection,
    /// The depth of what each surface starts inside of, or has inside (UL).
    fits: Vec<f64>,
    /// One master for each surface, in the same order, once somebody has asked for it.
    masters: Vec<OnceLock<Master<D>>>,
    /// The integration points of each pass with their projections.
    projected: Vec<OnceLock<Vec<Projected<D>>>>,
}

impl<const D: usize> Located<D> {
    /// Surface `k`, with its normals and its search tree.
    pub fn master(&self, k: usize) -> &Master<D> {
        let known = &self.masters[k];
        match known.get() {
            Some(master) => master,
            None => {
                let master = Master::new(&self.surfaces[k], &self.x, self.projection);
                known.get_or_init(|| master.fitted(self.fits[k]))
            }
        }
    }
}

impl<const D: usize> ContactSet<D> {
    /// Builds each surface once, even where several pairs name it, and the passes over the
    /// surfaces.
    pub fn new(
        scene: &Scene<D>,
        pairs: &[Pair],
        geometry: Geometry,
        kinematics: &Kinematics<D>,
        audit: &Audit<D>,
    ) -> Self {
        let (mut sides, passes) = sides_and_passes(pairs);
        let offset = pairs.iter().filter(|pair| pair.offset != 0.0).map(|pair| {
            let places = [&pair.first, &pair.second].map(|side| place_of(side, &mut sides));
            (ascending(places), pair.offset)
        });
        let offsets = offset.collect();
        let rough = pairs.iter().filter(|pair| pair.friction != 0.0);
        let friction = rough.map(|pair| {
            let places = [&pair.first, &pair.second].map(|side| place_of(side, &mut sides));
            (ascending(places), pair.friction)
        });
        let mut frictions: BTreeMap<_, _> = friction.collect();
        let on_obstacles: Vec<_> = scene
            .obstructed()
            .iter()
            .map(|(side, obstacle)| (place_of(side, &mut sides), *obstacle))
            .collect();
        let (mut passes, mut reversed): (Vec<_>, Vec<_>) = passes.into_iter().unzip();
        let switches = Switches::new(scene.switched(), &mut sides);
        for &(slave, obstacle) in &on_obstacles {
            let master = sides.len() + obstacle;
            passes.push(Pass { slave, master });
            reversed.push(false);
            let friction = scene.obstacle_frictions()[obstacle];
            if friction != 0.0 {
                frictions.insert(ascending([slave, master]), friction);
            }
        }
        let surface = |side: &&Side| {
            let body = side.body.index();
            let mesh = scene.bodies()[body].mesh();
            // the side was checked when the pair was declared
            let facets = mesh.boundary(&side.boundary).unwrap_or_default();
            let offset = kinematics.nodes(body).start;
            let facet = |nodes: &[usize]| nodes.iter().map(|a| a + offset).collect();
            let facets: Vec<Vec<usize>> = facets.into_iter().map(facet).collect();
            let facets = facets.iter().map(Vec::as_slice);
            let body = (body, mesh.is_of_revolution());
            Arc::new(Surface::of_body(body, mesh.order(), facets, &kinematics.X))
        };
        let surfaces: Vec<_> = sides.iter().map(surface).collect();
        let may_hold = scene.corners != Corners::Weak
            && geometry == Geometry::Current
            && scene.projection == Projection::AlongNormals
            && scene.initial_gaps == InitialGaps::Refuse
            && !passes.is_empty();
        let sharp = |surface: &Arc<Surface<D>>| {
            let body = &scene.bodies()[surface.body()];
            let first = kinematics.nodes(surface.body()).start;
            let held = body.prescribed();
            // on a plane of symmetry, a body goes on; nodes of a rigid body follow its leaders
            let is_free =
                |a: &usize| body.is_rigid() || held[D * a..D * (a + 1)].iter().all(Option::is_none);
            let sharp = sharp_nodes(body.mesh()).into_iter().filter(is_free);
            let places = sharp.map(|a| surface.nodes().binary_search(&(a + first)));
            places.flatten().collect()
        };
        let corners = may_hold.then(|| SharpCorners {
            of_surfaces: surfaces.iter().map(sharp).collect(),
            edges: surfaces.iter().map(|own| sharp_edges(own)).collect(),
            of_obstacles: scene.obstacles().iter().map(Obstacle::corners).collect(),
        });
        let extent = |surface: &Arc<Surface<D>>| Extent::of(surface, &kinematics.X);
        let placed = |(index, obstacle)| {
            let own = on_obstacles.iter().filter(|(_, other)| *other == index);
            let sizes = own.map(|(slave, _): &(usize, usize)| surfaces[*slave].facet_size());
            Placed::new(obstacle, sizes.fold(f64::INFINITY, f64::min))
        };
        let mut set = ContactSet {
            obstacles: scene.obstacles().iter().enumerate().map(placed).collect(),
            bodies: scene.bodies().len(),
            obstacle_points: scene.obstacle_points(),
            extents: surfaces.iter().map(extent).collect(),
            surfaces,
            is_reach_free: scene.reach.is_none(),
            passes,
            reversed,
            offsets,
            frictions,
            switches,
            geometry,
            integration: scene.integration(),
            projection: scene.projection,
            corners,
            holds_from_start: scene.corners == Corners::Held,
            holds: AtomicBool::new(scene.corners == Corners::Held),
            reach: match (scene.reach, geometry) {
                (Some(reach), _) => reach,
                (None, Geometry::Reference) => kinematics.diagonal(),
                (None, Geometry::Current) => {
                    let offsets = pairs.iter().map(|pair| pair.offset / OFFSET);
                    offsets.fold(REACH * kinematics.diagonal(), f64::max)
                }
            },
            way: WAY,
            is_refuted: AtomicBool::new(false),
            initial_gaps: scene.initial_gaps,
            initial_overlaps: InitialOverlaps::default(),
            fits: BTreeMap::new(),
            located: Mutex::new(None),
            built: AtomicUsize::new(0),
            stop: None,
            inside: Mutex::new(None),
            inside_searched: AtomicUsize::new(0),
        };
        if set.initial_gaps != InitialGaps::Refuse {
            let mut fits = audit.fits();
            fits.retain(|bodies, _| set.is_pair(*bodies));
            set.fits = fits;
            set.initial_overlaps = set.overlaps_at_rest(kinematics);
        }
        set
    }

    /// The overlaps of all passes and of those with exchanged roles in the reference configuration.
    fn overlaps_at_rest(&self, kinematics: &Kinematics<D>) -> InitialOverlaps {
        let mut passes = self.passes.clone();
        for pass in &self.passes {
            if let Some(turned) = self.turned(*pass).filter(|turned| !passes.contains(turned)) {
                passes.push(turned);
            }
        }
        let located = self.located_at(&kinematics.X);
        let inside = self.inside(&passes, &located, &kinematics.X);
        let depths = passes
            .iter()
            .zip(inside)
            .enumerate()
            .map(|(k, (pass, inside))| {
                let slave = &self.surfaces[pass.slave];
                let places = slave.nodes().iter().enumerate();
                let places: HashMap<usize, usize> = places.map(|(k, &node)| (node, k)).collect();
                let none = vec![0.0; slave.nodes().len()];
                let (mut gaps, mut deepest, mut nodes) = (none.clone(), none.clone(), none);
                for (node, gap) in inside {
                    nodes[node] = -gap;
                }
                let rows = self.pass_rows(&located, (k, *pass), Sampling::Nodes, None);
                let rows = rows.iter().flat_map(PassRows::stencils);
                for (stencil, shares) in rows {
                    let gap = stencil.projection().gap - self.offset(*pass);
                    for (name, share) in shares {
                        let place = places[&name];
                        gaps[place] += share * gap;
                        deepest[place] = deepest[place].max(-gap);
                    }
                }
                // what touches up to round-off does not overlap
                let least = InitialGaps::TOUCHES * slave.facet_size();
                let overlap = |(gap, deepest): (f64, f64)| match -gap > least {
                    true => (-gap).min(deepest),
                    false => 0.0,
                };
                let rows = gaps.into_iter().zip(deepest).map(overlap).collect();
                ((pass.slave, pass.master), Depths { rows, nodes })
            });
        InitialOverlaps(depths.collect())
    }

    /// Checks where obstacles are at pseudo-time `t`.
    ///
    /// # Errors
    /// A place that is not finite.
    pub fn check(&self, scene: &Scene<D>, t: f64) -> Result<(), crate::Error> {
        let placed = self.obstacles.iter().zip(scene.obstacle_names());
        let mut lost = placed.filter(|(obstacle, _)| !obstacle.obstacle().pose(t).is_finite());
        match lost.next() {
            Some((_, name)) => Err(crate::Error::NotFinite {
                what: format!("the motion of obstacle `{name}` at load factor {t}"),
                index: 0,
                value: f64::NAN,
            }),
            None => Ok(()),
        }
    }

    /// Places obstacles where they are at pseudo-time `t`, and forgets what was found elsewhere.
    pub fn set_load(&mut self, t: f64) {
        let mut has_moved = self.switches.set_time(t);
        for obstacle in &mut self.obstacles {
            has_moved |= obstacle.set_time(t);
        }
        if has_moved {
            *self
                .inside
                .get_mut()
                .unwrap_or_else(PoisonError::into_inner) = None;
        }
    }

    /// Whether a pass, or the one with exchanged roles, counts at the present load factor.
    pub fn is_on(&self, pass: Pass) -> bool {
        self.switches.is_on(pass)
    }

    /// Whether there are passes between two bodies, or a body and an obstacle, and none of them counts at load factor `t`.
    pub fn lets_through(&self, [a, b]: [usize; 2], t: f64) -> bool {
        if self.switches.is_empty() {
            return false;
        }
        let is_own = |pass: &&Pass| {
            let [first, second] = self.bodies_of(**pass);
            [first, second] == [a, b] || [second, first] == [a, b]
        };
        let mut own = self.passes.iter().filter(is_own).peekable();
        own.peek().is_some() && own.all(|pass| !self.switches.is_on_at(*pass, t))
    }

    /// The obstacle of a pass, if it has one.
    pub fn obstacle_of(&self, pass: Pass) -> Option<(usize, &Placed<D>)> {
        let index = pass.master.checked_sub(self.surfaces.len())?;
        Some((index, self.obstacles.get(index)?))
    }

    /// The body of the slave, and that of the master. Obstacles are numbered after the bodies.
    pub fn bodies_of(&self, pass: Pass) -> [usize; 2] {
        let of = |surface: usize| match surface.checked_sub(self.surfaces.len()) {
            None => self.surfaces[surface].body(),
            Some(obstacle) => self.bodies + obstacle,
        };
        [pass.slave, pass.master].map(of)
    }

    /// The distance that the surfaces of a pass keep (UL).
    pub fn offset(&self, pass: Pass) -> f64 {
        let sides = ascending([pass.slave, pass.master]);
        self.offsets.get(&sides).copied().unwrap_or(0.0)
    }

    /// The coefficient of friction of a pass.
    pub fn friction(&self, pass: Pass) -> f64 {
        let sides = ascending([pass.slave, pass.master]);
        self.frictions.get(&sides).copied().unwrap_or(0.0)
    }

    /// Whether some pass has friction.
    pub fn has_friction(&self) -> bool {
        !self.frictions.is_empty()
    }

    /// The slips of the rows `gaps` made at `u`, where they have friction, since all nodes were at `before`, at the load
    /// factor `from`; `None` if a stop was requested meanwhile.
    pub fn slips(
        &self,
        kinematics: &Kinematics<D>,
        u: &[f64],
        gaps: &LinearGaps,
        (before, from): (&[Vector<D>], f64),
    ) -> Option<SlipRows> {
        let mut slips = SlipRows::default();
        let located = self.located(kinematics, u);
        let unknowns = Unknowns {
            dofs: &kinematics.dofs,
            supports: &kinematics.dofs,
            prescribed: &kinematics.prescribed,
        };
        let known: HashSet<RowKey> = gaps.keys().iter().copied().collect();
        for (k, &pass) in self.passes.iter().enumerate() {
            let friction = self.friction(pass);
            if friction == 0.0 || !self.is_on(pass) {
                continue;
            }
            let stop = self.stop.as_ref();
            let rows = self.pass_rows(&located, (k, pass), Sampling::Nodes, stop)?;
            let obstacle = self.obstacle_of(pass);
            let poses = obstacle.map(|(_, own)| (own.pose(), own.obstacle().pose(from)));
            let dragged = |x: &Vector<D>| match &poses {
                Some((now, then)) => x - then.place(&now.back(x)),
                None => Vector::zeros(),
            };
            let (number, since) = (k as u32, (before, dragged));
            let has_row = |node: usize| {
                let (pass, node) = (number, node as u32);
                known.contains(&RowKey { pass, node })
            };
            let into = (friction, &mut slips);
            rows.append_slips(number, &kinematics.X, since, &unknowns, has_row, into);
        }
        Some(slips)
    }

    /// The pass with exchanged roles, if there can be one.
    pub fn turned(&self, pass: Pass) -> Option<Pass> {
        self.obstacle_of(pass).is_none().then_some(Pass {
            slave: pass.master,
            master: pass.slave,
        })
    }

    /// How deep two bodies, or a body and an obstacle, may start inside each other by their thickness (UL); 0 where they do not.
    pub fn fit(&self, [a, b]: [usize; 2]) -> f64 {
        let fit = self.fits.get(&[a.min(b), a.max(b)]);
        fit.map_or(0.0, |fit| InitialGaps::OF_THICKNESS * fit.thickness)
    }

    /// How deep a body starts inside other bodies, or has them inside (UL).
    pub fn deepest_fit(&self, body: usize) -> f64 {
        let own = self
            .fits
            .iter()
            .filter(|([a, b], _)| *b < self.bodies && (*a == body || *b == body));
        own.map(|(_, fit)| fit.depth).fold(0.0, f64::max)
    }

    /// The deepest initial overlap (UL) that the load resolves.
    pub fn resolved_overlap(&self) -> f64 {
        match self.initial_gaps {
            InitialGaps::Resolve => self.initial_overlaps.largest(),
            _ => 0.0,
        }
    }

    /// The passes none of whose points has been projected in the reference geometry.
    pub fn unsearched(&self) -> usize {
        let last = self.located.lock().unwrap_or_else(PoisonError::into_inner);
        match (&*last, self.geometry) {
            (Some(located), Geometry::Reference) => {
                let passes = self.passes.iter().zip(&located.projected);
                // obstacles need no search
                let between = passes.filter(|(pass, _)| self.obstacle_of(**pass).is_none());
                between.filter(|(_, of)| of.get().is_none()).count()
            }
            _ => 0,
        }
    }

    /// Whether this pass counts now, and displacements of at most `moved` (UL) can close a row of it, as it is planned.
    pub fn is_near(&self, pass: Pass, moved: f64) -> bool {
        self.is_on(pass) && !(moved < self.open_below(pass))
    }

    /// Displacements below this (UL) close no row of this pass. In the reference geometry such are those by which points move
    /// less than the boxes of both surfaces are apart, curved facets and averages over nodes allowed for; elsewhere none.
    pub fn open_below(&self, pass: Pass) -> f64 {
        let refuses = self.initial_gaps == InitialGaps::Refuse;
        let may_be_far = self.geometry == Geometry::Reference && self.is_reach_free && refuses;
        let may_be_far = may_be_far && !self.is_refuted.load(Ordering::Relaxed);
        let [first, second] = self.bodies_of(pass);
        if !may_be_far || first == second || self.obstacle_of(pass).is_some() {
            return 0.0;
        }
        let apart = self.extents[pass.slave].apart(&self.extents[pass.master]);
        ((apart - self.offset(pass)) / self.way).max(0.0)
    }

    /// A pass with a closed row at `u` that was left out by plan: it is then left out no more, and neither is any other. What
    /// is looked at are the ways of the nodes themselves, and then the rows.
    pub fn unplanned(&self, kinematics: &Kinematics<D>, u: &[f64]) -> Option<Pass> {
        let moved = kinematics.largest(u);
        let left_out = self.passes.iter().copied().enumerate();
        let left_out =
            left_out.filter(|(_, pass)| self.is_on(*pass) && !self.is_near(*pass, moved));
        let left_out: Vec<_> = left_out.collect();
        if left_out.is_empty() {
            return None;
        }
        let U = kinematics.displacements(u);
        let ways = |surface: &Arc<Surface<D>>| {
            let own = surface.nodes().iter().map(|&node| U[node].abs());
            own.fold(Vector::<D>::zeros(), |way, u| way.sup(&u))
        };
        let ways: Vec<_> = self.surfaces.iter().map(ways).collect();
        let may_meet = |(_, pass): &(usize, Pass)| {
            let [a, b] = [pass.slave, pass.master];
            let apart = self.extents[a].apart(&self.extents[b]) - self.offset(*pass);
            !(apart > BEYOND * (ways[a] + ways[b]).norm())
        };
        let doubtful = left_out.into_iter().filter(may_meet);
        let rows = self.rows(doubtful, kinematics, u, Sampling::Nodes, None)?;
        let mut c = vec![0.0; rows.len()];
        rows.value(u, &mut c);
        let least = -TOUCHES * kinematics.diagonal();
        let closed = (0..c.len()).find(|&row| !(c[row] >= least))?;
        self.is_refuted.store(true, Ordering::Relaxed);
        self.passes.get(rows.keys()[closed].pass as usize).copied()
    }

    /// Whether a pass is between surfaces of these two bodies.
    pub fn is_pair(&self, [a, b]: [usize; 2]) -> bool {
        let mut passes = self.passes.iter();
        passes.any(|pass| {
            let bodies = self.bodies_of(*pass);
            bodies == [a, b] || bodies == [b, a]
        })
    }

    /// Whether the rows do not depend on the state at which they are linearised.
    pub fn is_exact(&self) -> bool {
        self.geometry == Geometry::Reference || self.passes.is_empty()
    }

    /// The number of nodes of slave surfaces that may have a row, over all passes.
    pub fn contact_nodes(&self) -> usize {
        let passes = self.passes.iter().filter(|pass| self.is_on(**pass));
        let slaves = passes.map(|pass| &self.surfaces[pass.slave]);
        slaves.map(|slave| slave.test_functions_len()).sum()
    }

    /// The length of the smallest facet, at most `unless` (UL).
    pub fn smallest_facet(&self, unless: f64) -> f64 {
        let smallest = self.surfaces.iter().map(|s| s.smallest_facet());
        smallest.fold(unless, f64::min)
    }

    /// Whether a row's key identifies the same row in every iteration and load step. The numbers of
    /// integration points do not where facets are cut.
    pub fn has_lasting_names(&self, sampling: Sampling) -> bool {
        let has_cuts = || {
            self.passes
                .iter()
                .any(|pass| self.obstacle_of(*pass).is_none())
        };
        sampling == Sampling::Nodes || self.integration != Integration::Exact || !has_cuts()
    }

    /// The number of times that normals and search trees were built.
    pub fn built(&self) -> usize {
        self.built.load(Ordering::Relaxed)
    }

    /// The surfaces at the positions at which contact is searched at `u`. Successive queries at one
    /// state share them; in the reference geometry, all queries do.
    pub fn located(&self, kinematics: &Kinematics<D>, u: &[f64]) -> Arc<Located<D>> {
        match self.geometry {
            Geometry::Reference => self.located_at(&kinematics.X),
            Geometry::Current => self.located_at(&kinematics.positions(u)),
        }
    }

    /// The surfaces at positions `x` of all nodes.
    pub fn located_at(&self, x: &[Vector<D>]) -> Arc<Located<D>> {
        let mut last = self.located.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(located) = last.as_ref().filter(|located| located.x == x) {
            return Arc::clone(located);
        }
        self.built.fetch_add(1, Ordering::Relaxed);
        let located = Arc::new(Located {
            x: x.to_vec(),
            surfaces: self.surfaces.clone(),
            projection: self.projection,
            fits: self
                .surfaces
                .iter()
                .map(|s| self.deepest_fit(s.body()))
                .collect(),
            masters: self.surfaces.iter().map(|_| OnceLock::new()).collect(),
            projected: self.passes.iter().map(|_| OnceLock::new()).collect(),
        });
        *last = Some(Arc::clone(&located));
        located
    }

    /// The passes with their numbers: those with the declared roles, or those with exchanged roles.
    pub fn passes_in(&self, reversed: bool) -> impl Iterator<Item = (usize, Pass)> {
        let passes = self.passes.iter().copied().enumerate().zip(&self.reversed);
        #[cfg(planted)]
        let passes = passes.filter(|((number, _), _)| {
            let is_second = number % 2 == 1;
            !(contact_core::planted!("the second pass is left out") && is_second
                || contact_core::planted!("the first pass is left out") && !is_second)
        });
        passes.filter_map(move |(pass, role)| (*role == reversed).then_some(pass))
    }

    /// The rows c(u) = C u + c₀ of the numbered passes that count, with projections and normals frozen at `u`; `None` if `stop`
    /// was requested meanwhile.
    pub fn rows(
        &self,
        passes: impl Iterator<Item = (usize, Pass)>,
        kinematics: &Kinematics<D>,
        u: &[f64],
        sampling: Sampling,
        stop: Option<&Stop>,
    ) -> Option<LinearGaps> {
        let mut gaps = LinearGaps::new(self.is_exact()).sampled_at(sampling);
        let mut passes = passes.filter(|(_, pass)| self.is_on(*pass)).peekable();
        if passes.peek().is_none() {
            return Some(gaps);
        }
        let located = self.located(kinematics, u);
        let unknowns = Unknowns {
            dofs: &kinematics.dofs,
            supports: &kinematics.dofs,
            prescribed: &kinematics.prescribed,
        };
        for (k, pass) in passes {
            let mut rows = self.pass_rows(&located, (k, pass), sampling, stop)?;
            if let Some(depths) = self.initial_overlaps.of(pass) {
                let left = self.initial_gaps.share_left(kinematics.factor);
                rows.widen(|k| left * depths.rows[k], |k| left * depths.nodes[k]);
            }
            rows.keep_off(self.offset(pass));
            rows.append(k as u32, &kinematics.X, &unknowns, &mut gaps);
        }
        Some(gaps)
    }

    /// The rows of the pass numbered `k`; `None` if `stop` was requested meanwhile. The points of one of [`Self::passes`]
    /// are projected once for all queries at these positions.
    fn pass_rows<'a>(
        &'a self,
        located: &'a Located<D>,
        (k, pass): (usize, Pass),
        sampling: Sampling,
        stop: Option<&Stop>,
    ) -> Option<PassRows<'a, D>> {
        let slave = &self.surfaces[pass.slave];
        if let Some((_, obstacle)) = self.obstacle_of(pass) {
            let points = on_obstacle(
                slave,
                obstacle,
                &located.x,
                self.obstacle_points,
                self.reach,
            );
            let rows = PassRows::new(slave, obstacle, &points, sampling);
            return Some(self.with_corners(rows, located, pass, obstacle));
        }
        let master = located.master(pass.master);
        let rule = (self.integration, self.reach);
        let project = || projected_unless(slave, master, &located.x, rule, || is_requested(stop));
        if self.passes.get(k) != Some(&pass) {
            let rows = PassRows::new(slave, master, &project()?, sampling);
            return Some(self.with_corners(rows, located, pass, master));
        }
        let known = &located.projected[k];
        let points = match known.get() {
            Some(points) => points,
            None => {
                // not within `get_or_init`: while a thread waits for others, rayon may give it work that comes here again
                let points = project()?;
                known.get_or_init(|| points)
            }
        };
        let rows = PassRows::new(slave, master, points, sampling);
        Some(self.with_corners(rows, located, pass, master))
    }

    /// At the start of a run: corners and edges have rows only if the scene asks for them.
    pub fn begin(&self) {
        self.holds.store(self.holds_from_start, Ordering::Relaxed);
    }

    /// Whether there are corners or edges without rows that may have rows.
    pub fn may_hold_corners(&self) -> bool {
        let has_any = self.corners.as_ref().is_some_and(|own| !own.is_empty());
        has_any && !self.holds.load(Ordering::Relaxed)
    }

    /// From now on, corners and edges have rows.
    pub fn hold_corners(&self) {
        self.holds.store(true, Ordering::Relaxed);
    }

    /// Whether a pass has the rows of edges that cross: it is between two bodies, and the only one between their surfaces or the first of two, since these rows have
    /// no slave.
    fn has_crossings(&self, pass: Pass) -> bool {
        let [first, second] = self.bodies_of(pass);
        let mut turned = self.turned(pass).into_iter();
        let is_second =
            turned.any(|turned| turned.slave < pass.slave && self.passes.contains(&turned));
        self.obstacle_of(pass).is_none() && first != second && !is_second
    }

    /// The same with the rows of corners and edges.
    fn with_corners<'a>(
        &'a self,
        rows: PassRows<'a, D>,
        located: &'a Located<D>,
        pass: Pass,
        against: impl Into<Against<'a, D>>,
    ) -> PassRows<'a, D> {
        let holds = self.holds.load(Ordering::Relaxed) && rows.is_of_nodes();
        let Some(corners) = self.corners.as_ref().filter(|_| holds) else {
            return rows;
        };
        let (own, x) = (located.master(pass.slave), &located.x[..]);
        let nodes = &corners.of_surfaces[pass.slave];
        let found = match self.obstacle_of(pass) {
            Some((index, obstacle)) => {
                let mut found = corner::on_obstacle(own.moving(), nodes, obstacle, x, self.reach);
                let tips = &corners.of_obstacles[index];
                found.extend(corner::of_obstacle(
                    (obstacle, tips),
                    own,
                    self.reach,
                    x.len(),
                ));
                found
            }
            None => {
                let master = located.master(pass.master);
                corner::on_surface(own.moving(), nodes, master, x, self.reach)
            }
        };
        let rows = rows.with_corners(own.moving(), against, &found);
        if !self.has_crossings(pass) {
            return rows;
        }
        let both = [pass.slave, pass.master];
        let crossings = edge::crossings(
            both.map(|k| located.master(k).moving()),
            both.map(|k| &corners.edges[k][..]),
            self.reach,
            x.len(),
        );
        rows.with_crossings(crossings)
    }

    /// The variation of the rows `gaps` of all passes, frozen at `u`; `None` if they do not depend on
    /// the state. `lambda` has the multipliers of the rows that matter.
    ///
    /// # Errors
    /// [`Error::Interrupted`] if a stop was requested meanwhile.
    pub fn variation(
        &self,
        kinematics: &Kinematics<D>,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[Option<f64>],
    ) -> Result<Option<Variation<D>>, Error> {
        if self.is_exact() {
            return Ok(None);
        }
        let stop = self.stop.as_ref();
        let located = self.located(kinematics, u);
        let mut has_rows = vec![false; self.passes.len()];
        for (key, _) in gaps.keys().iter().zip(lambda).filter(|(_, l)| l.is_some()) {
            has_rows[key.pass as usize] = true;
        }
        let matters = gaps.keys().iter().zip(lambda).enumerate();
        let matters: HashMap<RowKey, (usize, f64)> = matters
            .filter_map(|(row, (key, lambda))| Some((*key, (row, (*lambda)?))))
            .collect();
        let mut variation = Variation::new(gaps.len(), located.x.len());
        let passes = self.passes.iter().enumerate();
        for (k, pass) in passes.filter(|(k, _)| has_rows[*k]) {
            let rows = self.pass_rows(&located, (k, *pass), gaps.sampling(), stop);
            let rows = rows.ok_or(Error::Interrupted)?;
            let key = |node: usize| RowKey {
                pass: k as u32,
                node: node as u32,
            };
            let multiplier = |node| matters.get(&key(node)).copied();
            if !variation.add(&rows, *pass, &located.x, multiplier, || is_requested(stop)) {
                return Err(Error::Interrupted);
            }
        }
        Ok(Some(variation))
    }
}

fn ascending([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

fn is_requested(stop: Option<&Stop>) -> bool {
    stop.is_some_and(Stop::is_requested)
}

/// Every side that a pair names, once; and every pass with whether it exchanges the declared roles.
pub(super) fn sides_and_passes(pairs: &[Pair]) -> (Vec<&Side>, Vec<(Pass, bool)>) {
    let (mut sides, mut passes) = (Vec::<&Side>::new(), Vec::new());
    for pair in pairs {
        let [a, b] = [&pair.first, &pair.second].map(|side| place_of(side, &mut sides));
        let pass = |slave, master, reversed| (Pass { slave, master }, reversed);
        match pair.passes {
            _ if a == b => passes.push(pass(a, b, false)),
            Passes::Both => passes.extend([pass(a, b, false), pass(b, a, true)]),
            Passes::FirstIsSlave => passes.push(pass(a, b, false)),
            Passes::SecondIsSlave => passes.push(pass(b, a, true)),
        }
    }
    (sides, passes)
}

/// The position of a side, which is added where it is new.
pub(super) fn place_of<'a>(side: &'a Side, sides: &mut Vec<&'a Side>) -> usize {
    sides.iter().position(|s| *s == side).unwrap_or_else(|| {
        sides.push(side);
        sides.len() - 1
    })
}

#[cfg(test)]
mod varied;

#[cfg(test)]
mod tests;

//! How deep nodes are inside other surfaces, and whether bodies have passed through each other.

use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};

use super::{ContactSet, Located};
use crate::contact::motion::Motion;
use crate::contact::obstacle::Placed;
use crate::contact::search::{NodalGap, nodal_gaps, nodes_inside};
use crate::contact::{Pass, Surface};
use crate::element::facet_shapes;
use crate::model::Geometry;
use crate::model::kinematics::Kinematics;
use crate::tensor::Vector;

impl<const D: usize> ContactSet<D> {
    /// The largest depth of a contact node inside another surface at `u`, less what is left of its initial overlap (UL, ≥ 0).
    pub fn penetration(&self, kinematics: &Kinematics<D>, u: &[f64]) -> f64 {
        self.deepest(kinematics, u, |surface| vec![1.0; surface.nodes().len()])
    }

    /// As [`ContactSet::penetration`], each depth divided by the node's length in `units`.
    pub fn deepest(
        &self,
        kinematics: &Kinematics<D>,
        u: &[f64],
        units: impl Fn(&Surface<D>) -> Vec<f64>,
    ) -> f64 {
        if self.passes.is_empty() {
            return 0.0;
        }
        let moved = kinematics.largest(u);
        let inside = self.inside_at(kinematics.positions(u), moved, kinematics);
        let left = self.initial_gaps.share_left(kinematics.factor);
        let depth = |(pass, inside): (&Pass, &Vec<(usize, f64)>)| {
            if inside.is_empty() {
                return 0.0;
            }
            let units = units(&self.surfaces[pass.slave]);
            let initial = self.initial_overlaps.of(*pass);
            let granted = |k: usize| initial.map_or(0.0, |depths| left * depths.nodes[k]);
            let depths = inside
                .iter()
                .map(|(k, gap)| (-gap - granted(*k)) / units[*k]);
            depths.fold(0.0, f64::max)
        };
        self.passes
            .iter()
            .zip(inside.iter())
            .map(depth)
            .fold(0.0, f64::max)
    }

    /// The result of [`nodes_inside`] at positions `x` of all nodes, pass by pass, which is kept.
    fn inside_at(
        &self,
        x: Vec<Vector<D>>,
        moved: f64,
        kinematics: &Kinematics<D>,
    ) -> Arc<Vec<Vec<(usize, f64)>>> {
        let mut last = self.inside.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, inside)) = last.as_ref().filter(|(at, _)| *at == x) {
            return Arc::clone(inside);
        }
        self.inside_searched.fetch_add(1, Ordering::Relaxed);
        let located = match self.geometry {
            Geometry::Reference => self.located_at(&kinematics.X),
            Geometry::Current => self.located_at(&x),
        };
        let of_pass = |pass: &Pass| match self.is_near(*pass, moved) {
            true => self.inside_of(*pass, &located, &x),
            false => Vec::new(),
        };
        let inside = Arc::new(self.passes.iter().map(of_pass).collect::<Vec<_>>());
        *last = Some((x, Arc::clone(&inside)));
        inside
    }

    /// The number of states at which nodes inside other surfaces were looked for.
    pub fn inside_searched(&self) -> usize {
        self.inside_searched.load(Ordering::Relaxed)
    }

    /// The result of [`nodes_inside`] between positions `now`, pass by pass.
    pub fn inside(
        &self,
        passes: &[Pass],
        located: &Located<D>,
        now: &[Vector<D>],
    ) -> Vec<Vec<(usize, f64)>> {
        let of_pass = |pass: &Pass| self.inside_of(*pass, located, now);
        passes.iter().map(of_pass).collect()
    }

    fn inside_of(&self, pass: Pass, located: &Located<D>, now: &[Vector<D>]) -> Vec<(usize, f64)> {
        if let Some((_, obstacle)) = self.obstacle_of(pass) {
            let nodes = self.surfaces[pass.slave].nodes().iter().enumerate();
            let gap = |(k, &node): (usize, &usize)| {
                let gap = gap_on(obstacle, &located.x[node], &now[node]);
                (gap < 0.0).then_some((k, gap))
            };
            return nodes.filter_map(gap).collect();
        }
        let offset = self.offset(pass);
        if offset != 0.0 {
            let gaps = self
                .gaps_between(pass, located, now)
                .into_iter()
                .enumerate();
            let gaps = gaps.filter_map(|(k, gap)| Some((k, gap?.to_facet - offset)));
            return gaps.filter(|(_, gap)| *gap < 0.0).collect();
        }
        let [own, master] = [pass.slave, pass.master].map(|k| located.master(k));
        let slave = &self.surfaces[pass.slave];
        nodes_inside(slave, own.normals(), master, &located.x, now, self.reach)
    }

    /// The gaps of the nodes of one surface to another, or to an obstacle, at `u` (UL), less what is granted of initial
    /// overlaps, and the distance that they keep; `None` where no point of the other surface counts, or none can close.
    pub fn nodal_gaps(
        &self,
        [own, other]: [usize; 2],
        kinematics: &Kinematics<D>,
        u: &[f64],
    ) -> Vec<Option<NodalGap>> {
        let pass = Pass {
            slave: own,
            master: other,
        };
        if !self.is_near(pass, kinematics.largest(u)) {
            return vec![None; self.surfaces[own].nodes().len()];
        }
        let (located, now) = (self.located(kinematics, u), kinematics.positions(u));
        let mut gaps = self.gaps_between(pass, &located, &now);
        let offset = self.offset(pass);
        let all = gaps.iter_mut().flatten();
        all.for_each(|gap| gap.to_facet -= offset);
        if let Some(depths) = self.initial_overlaps.of(pass) {
            let left = self.initial_gaps.share_left(kinematics.factor);
            for (gap, &depth) in gaps.iter_mut().zip(&depths.nodes) {
                let Some(gap) = gap.as_mut().filter(|_| depth > 0.0) else {
                    continue;
                };
                gap.to_facet += left * depth;
                // the smooth surface was by its bulge deeper or less deep
                gap.bulge += left * (depth - (depth + gap.bulge).max(0.0));
            }
        }
        gaps
    }

    /// The gaps of the slave's nodes at positions `now`, found where the surfaces are `located`; overlaps that are granted are in them.
    pub fn gaps_between(
        &self,
        pass: Pass,
        located: &Located<D>,
        now: &[Vector<D>],
    ) -> Vec<Option<NodalGap>> {
        let surface = &self.surfaces[pass.slave];
        let normals = located.master(pass.slave).normals();
        match self.obstacle_of(pass) {
            Some((_, obstacle)) => {
                let gap = |&node: &usize| NodalGap {
                    to_facet: gap_on(obstacle, &located.x[node], &now[node]),
                    bulge: 0.0,
                };
                surface.nodes().iter().map(|node| Some(gap(node))).collect()
            }
            None => {
                let master = located.master(pass.master);
                nodal_gaps(surface, normals, master, &located.x, now, self.reach)
            }
        }
    }

    /// How far node `k` of the slave is beyond the rim of the master (UL), along it; `None` where it is above the master, or on the same
    /// surface.
    pub fn beyond_the_rim(&self, pass: Pass, located: &Located<D>, k: usize) -> Option<f64> {
        if self.obstacle_of(pass).is_some() || pass.slave == pass.master {
            return None;
        }
        let master = located.master(pass.master);
        let x = &located.x[self.surfaces[pass.slave].nodes()[k]];
        let p = master.project(x).filter(|p| p.off_the_end)?;
        let surface = master.surface();
        let inside = p.lambda.map(|part| part.max(0.0));
        let shapes = facet_shapes(surface.order(), &(inside / inside.sum()));
        let nodes = surface.facet(p.facet).iter().zip(shapes);
        let rim: Vector<D> = nodes.map(|(&b, N)| located.x[surface.nodes()[b]] * N).sum();
        let off = x - rim;
        Some((off - p.normal * off.dot(&p.normal)).norm())
    }

    /// How far bodies have passed through each other (UL), or `None` if they have not. They have if
    /// the penetration at `u` exceeds the facets around the node or the search radius, or if nodes
    /// went through a body on the way between the positions `before`, at load factor `from`, and `after`, those at `u`. Where
    /// contact is looked for at the reference positions, only obstacles are asked for that: normals on bodies do not turn there.
    /// On obstacles they do, if one moves through the reference position of a node.
    pub fn tunnels(
        &self,
        kinematics: &Kinematics<D>,
        u: &[f64],
        (before, after): (&[Vector<D>], &[Vector<D>]),
        from: f64,
    ) -> Option<f64> {
        let depth = self.penetration(kinematics, u);
        let in_facets = self.deepest(kinematics, u, Surface::node_sizes);
        if depth > self.reach || in_facets > 1.0 {
            return Some(depth);
        }
        let motion = Motion { before, after };
        let rest = Motion {
            before: &kinematics.X,
            after: &kinematics.X,
        };
        let is_reference = self.geometry == Geometry::Reference;
        let through = |pass: &Pass| {
            let slave = &self.surfaces[pass.slave];
            match self.obstacle_of(*pass) {
                Some((_, obstacle)) => {
                    let from = obstacle.obstacle().pose(from);
                    let through =
                        |motion: &Motion<'_, D>| motion.through_obstacle(slave, obstacle, &from);
                    let at_rest = is_reference.then(|| through(&rest)).flatten();
                    at_rest.or_else(|| through(&motion))
                }
                None if is_reference => None,
                None => motion.through(slave, &self.surfaces[pass.master]),
            }
        };
        let passes = self.passes.iter();
        let both = passes.filter(|pass| self.is_on(**pass) && self.switches.is_on_at(**pass, from));
        both.filter_map(through).reduce(f64::max)
    }
}

/// The gap between an obstacle and a point `now` (UL), which the search had at `x`: along the normal there.
fn gap_on<const D: usize>(obstacle: &Placed<D>, x: &Vector<D>, now: &Vector<D>) -> f64 {
    let (gap, way) = (obstacle.distance(x), now - x);
    match way.iter().all(|w| *w == 0.0) {
        true => gap,
        false => gap + obstacle.normal(x).dot(&way),
    }
}

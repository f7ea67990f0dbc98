//! Weak gaps of one pass, and the forces that multipliers mean.

use super::faces::{Faces, Placed, shapes};
use super::feet::Reach;
use super::rule::{Held, Places, Points, Slave};
use crate::tensor::Vector;

/// Rows lean on their neighbours where less than this share of their test function is opposite the master.
const LEANS: f64 = 0.25;

/// A pass: a slave's boundary against a master's.
pub(super) struct Pass<'a, const D: usize> {
    pub slave: &'a Faces<D>,
    pub master: &'a Placed<'a, D>,
    pub held: Vec<Held<D>>,
    /// For each point, the sine of the angle between the normal at its foot and that of the facet there.
    sines: Vec<f64>,
    /// Whether all points of a row were looked at.
    pub is_known: Vec<bool>,
    /// Whether all points of a row have a foot and count in full.
    pub is_whole: Vec<bool>,
    /// s_i of each row.
    own: Vec<f64>,
    /// The share of each test function that is opposite the master.
    covered: Vec<f64>,
    /// a_i of the test function that a row has, leaning allowed for.
    pub areas: Vec<f64>,
    neighbours: Vec<Vec<usize>>,
}

/// Where contact is looked for, how, and which rows carry forces.
pub(super) struct Search<'a, const D: usize> {
    /// Positions of all nodes of the scene (UL).
    pub x: &'a [Vector<D>],
    pub reach: Reach,
    pub is_one_body: bool,
    pub places: &'a Places<D>,
    /// For each node of the slave.
    pub has_force: &'a [bool],
}

impl<'a, const D: usize> Pass<'a, D> {
    /// The points of those facets that are near the master or share a node with one that is or that has a force.
    pub fn new(slave: &'a Faces<D>, master: &'a Placed<'a, D>, search: &Search<'_, D>) -> Self {
        let x: Vec<Vector<D>> = slave.nodes.iter().map(|&a| search.x[a]).collect();
        let is_doubtful = |f: &usize| {
            let own = slave.facet(*f);
            let middle = own.iter().map(|&a| x[a]).sum::<Vector<D>>() / own.len() as f64;
            let radius = own
                .iter()
                .map(|&a| (x[a] - middle).norm())
                .fold(0.0, f64::max);
            let near = (radius + 1.5 * search.reach.size).min(radius + search.reach.radius);
            own.iter().any(|&a| search.has_force[a])
                || master.boxes.within(&middle, near).next().is_some()
        };
        let mut is_near = vec![false; x.len()];
        for f in (0..slave.len()).filter(is_doubtful) {
            slave.facet(f).iter().for_each(|&a| is_near[a] = true);
        }
        let mut points = Points::default();
        let [mut is_known, mut is_whole] = [(); 2].map(|()| vec![true; x.len()]);
        for f in 0..slave.len() {
            if !slave.facet(f).iter().any(|&a| is_near[a]) {
                slave.facet(f).iter().for_each(|&a| is_known[a] = false);
                continue;
            }
            let facet = Slave {
                surfaces: (slave, master),
                facet: f,
                patch: slave.patch(f, &x),
                is_one_body: search.is_one_body,
                reach: search.reach,
                places: search.places,
            };
            if !facet.add(&mut points) {
                slave.facet(f).iter().for_each(|&a| is_whole[a] = false);
            }
        }
        for (is_whole, is_known) in is_whole.iter_mut().zip(&is_known) {
            *is_whole &= is_known;
        }
        let sines = points.held.iter().map(|point| {
            let [there, _] = master.patches(point.foot.facet);
            let normal = there.normal(&point.foot.lambda).normalize();
            (normal - point.foot.normal).norm()
        });
        let mut pass = Pass {
            slave,
            master,
            sines: sines.collect(),
            held: points.held,
            is_known,
            is_whole,
            own: Vec::new(),
            covered: Vec::new(),
            areas: Vec::new(),
            neighbours: neighbours(slave),
        };
        pass.lean();
        pass
    }

    /// Finds which rows lean on others, and by how much.
    fn lean(&mut self) {
        let areas = self.integrals(&vec![1.0; self.held.len()]);
        let wholes = wholes(self.slave);
        let shares = areas.iter().zip(&wholes);
        self.covered = shares.map(|(a, whole)| a / whole).collect();
        let leaning = self.covered.iter();
        self.own = leaning
            .map(|share| (share / LEANS).clamp(0.0, 1.0))
            .collect();
        self.areas = self.leant(&areas);
    }

    /// Σ w φ_i of values at the points, for each node.
    fn integrals(&self, values: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.slave.nodes.len()];
        for (point, value) in self.held.iter().zip(values) {
            let part = point.weight * value;
            let tests = self.slave.tests(point.facet).iter();
            let values = self.slave.test_values(&point.lambda);
            tests
                .zip(values)
                .for_each(|(&a, phi)| sums[a] += part * phi);
        }
        sums
    }

    /// Of integrals with φ_i, those with the test functions that rows have.
    fn leant(&self, integrals: &[f64]) -> Vec<f64> {
        let of = |(i, own): (usize, &f64)| {
            let others = self.neighbours[i]
                .iter()
                .map(|&j| self.own[j] * integrals[j]);
            match *own < 1.0 {
                true => own * integrals[i] + (1.0 - own) * others.sum::<f64>(),
                false => integrals[i],
            }
        };
        self.own.iter().enumerate().map(of).collect()
    }

    /// The gap of each point where the nodes of the scene are at `x`, with feet and normals as they were found (UL).
    pub fn point_gaps(&self, x: &[Vector<D>]) -> Vec<f64> {
        let own: Vec<Vector<D>> = self.slave.nodes.iter().map(|&a| x[a]).collect();
        let other: Vec<Vector<D>> = self.master.faces.nodes.iter().map(|&b| x[b]).collect();
        let gap = |point: &Held<D>| {
            let place = self.slave.patch(point.facet, &own).at(&point.lambda);
            let foot = self
                .master
                .faces
                .patch(point.foot.facet, &other)
                .at(&point.foot.lambda);
            (place - foot).dot(&point.foot.normal)
        };
        self.held.iter().map(gap).collect()
    }

    /// c_i of these gaps of the points (UL); NaN without support.
    pub fn gaps(&self, of_points: &[f64]) -> Vec<f64> {
        let sums = self.leant(&self.integrals(of_points));
        let gaps = sums.iter().zip(&self.areas);
        gaps.map(|(gap, area)| if *area > 0.0 { gap / area } else { f64::NAN })
            .collect()
    }

    /// The smallest and the largest of these gaps of the points, for each row (UL); without points they are infinite.
    pub fn ranges(&self, of_points: &[f64]) -> Vec<[f64; 2]> {
        let mut ranges = vec![[f64::INFINITY, -f64::INFINITY]; self.slave.nodes.len()];
        for (point, gap) in self.held.iter().zip(of_points) {
            for &a in self.slave.tests(point.facet) {
                let [least, most] = ranges[a];
                ranges[a] = [least.min(*gap), most.max(*gap)];
            }
        }
        ranges
    }

    /// Whether at least this share of a row's test function is opposite the master.
    pub fn is_covered(&self, i: usize, share: f64) -> bool {
        self.covered[i] >= share
    }

    /// The force of each point (UF), of one multiplier for each node.
    pub fn pushes(&self, lambda: &[f64]) -> Vec<f64> {
        let mut of_tests = vec![0.0; lambda.len()];
        for (i, l) in lambda.iter().enumerate().filter(|(_, l)| **l != 0.0) {
            let share = match self.areas[i] > 0.0 {
                true => l / self.areas[i],
                false => continue,
            };
            of_tests[i] += share * self.own[i];
            if self.own[i] < 1.0 {
                let others = self.neighbours[i].iter();
                others.for_each(|&j| of_tests[j] += share * (1.0 - self.own[i]) * self.own[j]);
            }
        }
        let push = |point: &Held<D>| {
            let tests = self.slave.tests(point.facet).iter();
            let values = self.slave.test_values(&point.lambda);
            let pressure: f64 = tests.zip(values).map(|(&a, phi)| phi * of_tests[a]).sum();
            pressure * point.weight
        };
        self.held.iter().map(push).collect()
    }

    /// Adds the forces on all nodes of the scene that point forces mean: each along the normal at its foot, and its opposite there.
    pub fn add_forces(&self, pushes: &[f64], forces: &mut [Vector<D>]) {
        for (point, push) in self
            .held
            .iter()
            .zip(pushes)
            .filter(|(_, push)| **push != 0.0)
        {
            let force = point.foot.normal * *push;
            let mut add = |faces: &Faces<D>, (f, lambda): (usize, &Vector<D>), sign: f64| {
                let nodes = faces.facet(f).iter().zip(shapes(faces.order(), lambda));
                nodes.for_each(|(&a, N)| forces[faces.nodes[a]] += force * (sign * N));
            };
            add(self.slave, (point.facet, &point.lambda), 1.0);
            add(
                self.master.faces,
                (point.foot.facet, &point.foot.lambda),
                -1.0,
            );
        }
    }

    /// The mean of the sines, weighted with the forces, as its two sums.
    pub fn tilt(&self, pushes: &[f64]) -> [f64; 2] {
        let sines = self.sines.iter().zip(pushes);
        sines.fold([0.0; 2], |[sum, all], (sine, push)| {
            [sum + push.abs() * sine, all + push.abs()]
        })
    }

    /// The largest of the sines around each node of the slave.
    pub fn node_sines(&self) -> Vec<f64> {
        let mut largest = vec![0.0_f64; self.slave.nodes.len()];
        for (point, &sine) in self.held.iter().zip(&self.sines) {
            for &a in self.slave.facet(point.facet) {
                largest[a] = largest[a].max(sine);
            }
        }
        largest
    }

    /// Raises the largest of the sines of points with a force, around each node of the scene.
    pub fn add_sines(&self, pushes: &[f64], largest: &mut [f64]) {
        let loaded = self.held.iter().zip(&self.sines).zip(pushes);
        for ((point, &sine), _) in loaded.filter(|(_, push)| **push != 0.0) {
            let mut raise = |faces: &Faces<D>, facet: usize| {
                for &a in faces.facet(facet) {
                    let own = &mut largest[faces.nodes[a]];
                    *own = own.max(sine);
                }
            };
            raise(self.slave, point.facet);
            raise(self.master.faces, point.foot.facet);
        }
    }
}

/// The other nodes with a test function on the facets around each node.
fn neighbours<const D: usize>(slave: &Faces<D>) -> Vec<Vec<usize>> {
    let mut neighbours = vec![Vec::new(); slave.nodes.len()];
    for f in 0..slave.len() {
        for &a in slave.facet(f) {
            let others = slave.tests(f).iter().copied().filter(|&b| b != a);
            neighbours[a].extend(others);
        }
    }
    for own in &mut neighbours {
        own.sort_unstable();
        own.dedup();
    }
    neighbours
}

/// ∫ φ_i of each node over the reference configuration.
fn wholes<const D: usize>(slave: &Faces<D>) -> Vec<f64> {
    let mut wholes = vec![0.0; slave.nodes.len()];
    let rule = super::rule::whole::<D>();
    for f in 0..slave.len() {
        for (weight, lambda) in &rule {
            let part = weight * slave.measure(f, lambda);
            let tests = slave.tests(f).iter().zip(slave.test_values(lambda));
            tests.for_each(|(&a, phi)| wholes[a] += part * phi);
        }
    }
    wholes
}

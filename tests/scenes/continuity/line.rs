//! Rows and their forces at states on a line, and the places where they jump.

use std::cmp::Reverse;
use std::collections::{BTreeSet, HashMap};

use contact_core::equilibrium::Solution;
use contact_core::gaps::{RowKey, Sampling};
use contact_fem::assembly::Dof;
use contact_fem::model::Problem;

/// Into so many intervals a line is divided at first.
const INTERVALS: usize = 100;
/// So many intervals, with the largest bends, are halved again.
const KEPT: usize = 8;
/// The length of the smallest intervals, as a share of the line's.
const SHORTEST: f64 = 1e-8;
/// A change falls with the length of its interval if it falls by 3 for every factor of 10. It is measured over 1024, since the change
/// across a kink need not fall with every halving.
const HALVINGS: usize = 10;
const FALLS: f64 = 27.0;
/// A smaller change is round-off, or as good as none.
const ROUND_OFF: f64 = 1e-9;

/// A row acts if its force is larger than this share of the largest one.
const ACTS: f64 = 1e-6;

/// What is looked at separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// The forces Cᵀλ on all nodes, with λ of the equilibrium, over the largest λ. A row that is left out leaves with its force.
    Forces,
    /// c(u) at u itself, over the size of facets. Of rows without a force, overlaps alone: min(c, 0).
    Gaps,
    /// The coefficients of rows with a force.
    Coefficients,
}

pub const KINDS: [Kind; 3] = [Kind::Forces, Kind::Gaps, Kind::Coefficients];

/// One number of a sample. A row that is not there has zeros.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    Force { node: usize, axis: usize },
    Gap(RowKey),
    Coefficient(RowKey, Unknown),
}

/// The number of an unknown among the free or the prescribed ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unknown {
    Free(usize),
    Prescribed(usize),
}

/// A discontinuity between two neighbouring states.
#[derive(Clone, Debug)]
pub struct Jump {
    pub place: Place,
    /// The change across it, in the unit of its [`Kind`].
    pub size: f64,
    /// t before and after.
    pub between: [f64; 2],
}

/// The states u + t d, −1 ≤ t ≤ 1.
pub struct Line<'a, const D: usize> {
    problem: &'a Problem<D>,
    u: &'a [f64],
    d: Vec<f64>,
    /// λ of the equilibrium over the largest one.
    lambda: HashMap<RowKey, f64>,
    /// The size of the smallest facet (UL).
    facet: f64,
    numbers: HashMap<Place, usize>,
    /// The places of each kind, by number.
    places: [Vec<Place>; 3],
    samples: Vec<Sample>,
    /// The number of each sample by the bits of its t.
    known: HashMap<u64, usize>,
}

/// The values at one t, kind by kind.
struct Sample {
    t: f64,
    values: [Vec<f64>; 3],
}

impl Sample {
    /// At the place of this number, 0 if there is no such row.
    fn value(&self, kind: Kind, number: usize) -> f64 {
        self.values[kind as usize]
            .get(number)
            .copied()
            .unwrap_or(0.0)
    }
}

/// An interval between two samples, with the samples before and after it.
#[derive(Clone)]
struct Interval {
    samples: [usize; 4],
    /// The changes across this interval and across the intervals that it is a half of, the longest first.
    changes: Vec<f64>,
}

impl<'a, const D: usize> Line<'a, D> {
    /// Through an equilibrium, in a random direction. No unknown moves by more than a tenth of the smallest facet.
    pub fn random(problem: &'a Problem<D>, equilibrium: &'a Solution, seed: u64) -> Self {
        let u = &equilibrium.state.u;
        let keys = equilibrium.gaps.keys().iter().copied();
        let most = equilibrium.lambda.iter().copied().fold(0.0, f64::max);
        let lambda = keys.zip(equilibrium.lambda.iter().map(|l| l / most));
        let surfaces = problem.surfaces().iter();
        let facet = surfaces.fold(f64::INFINITY, |h, s| h.min(s.smallest_facet()));
        let mut random = Random(seed);
        let d = u.iter().map(|_| 0.1 * facet * (2.0 * random.next() - 1.0));
        Line {
            problem,
            u,
            d: d.collect(),
            lambda: lambda.collect(),
            facet,
            numbers: HashMap::new(),
            places: [const { Vec::new() }; 3],
            samples: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// u + t d.
    pub fn state(&self, t: f64) -> Vec<f64> {
        self.u.iter().zip(&self.d).map(|(u, d)| u + t * d).collect()
    }

    /// The rows with a force whose coefficients reach a node, at the equilibrium.
    pub fn rows_with(&self, node: usize) -> Vec<RowKey> {
        let unknown = |axis| match self.problem.dofs().get(D * node + axis) {
            Dof::Free(j) => Unknown::Free(j),
            Dof::Prescribed(j) => Unknown::Prescribed(j),
        };
        let unknowns: Vec<Unknown> = (0..D).map(unknown).collect();
        let rows = self.places[Kind::Coefficients as usize].iter();
        let rows = rows.filter_map(|place| match place {
            Place::Coefficient(key, unknown) => unknowns.contains(unknown).then_some(*key),
            _ => None,
        });
        let rows: BTreeSet<RowKey> = rows.collect();
        rows.into_iter().collect()
    }

    /// The largest jump of each kind.
    pub fn jumps(&mut self) -> Vec<(Kind, Jump)> {
        let step = 2.0 / INTERVALS as f64;
        let coarse = (0..=INTERVALS).map(|k| self.sample(k as f64 * step - 1.0));
        let coarse: Vec<usize> = coarse.collect();
        let largest = |kind| Some((kind, self.largest_jump(kind, &coarse)?));
        KINDS.into_iter().filter_map(largest).collect()
    }

    fn largest_jump(&mut self, kind: Kind, coarse: &[usize]) -> Option<Jump> {
        let inner = coarse.windows(4).map(|samples| Interval {
            samples: [samples[0], samples[1], samples[2], samples[3]],
            changes: Vec::new(),
        });
        let mut intervals: Vec<Interval> = inner.collect();
        let mut length = 2.0 / INTERVALS as f64;
        loop {
            // of numbers that are not negative, bits are in the same order
            intervals.sort_by_cached_key(|i| Reverse(self.bend(kind, i).to_bits()));
            intervals.truncate(KEPT);
            for interval in &mut intervals {
                let change = self.change(kind, interval).1;
                interval.changes.push(change);
            }
            if length <= 2.0 * SHORTEST {
                break;
            }
            let halves = intervals.iter().flat_map(|interval| self.halved(interval));
            intervals = halves.collect();
            length *= 0.5;
        }
        let jumps = intervals.iter().filter_map(|interval| {
            let before = interval.changes[interval.changes.len() - 1 - HALVINGS];
            let (component, size) = self.change(kind, interval);
            let is_jump = size > ROUND_OFF && size > before / FALLS;
            is_jump.then(|| Jump {
                place: self.places[kind as usize][component],
                size,
                between: [1, 2].map(|k| self.samples[interval.samples[k]].t),
            })
        });
        jumps.max_by(|a, b| a.size.total_cmp(&b.size))
    }

    fn halved(&mut self, interval: &Interval) -> [Interval; 2] {
        let [before, first, last, after] = interval.samples;
        let middle = 0.5 * (self.samples[first].t + self.samples[last].t);
        let middle = self.sample(middle);
        [[before, first, middle, last], [first, middle, last, after]].map(|samples| Interval {
            samples,
            changes: interval.changes.clone(),
        })
    }

    /// The largest change across an interval, and the number of the place where it is.
    fn change(&self, kind: Kind, interval: &Interval) -> (usize, f64) {
        let [_, before, after, _] = interval.samples;
        let at = |sample: usize, i| self.samples[sample].value(kind, i);
        let changes = (0..self.places[kind as usize].len())
            .map(|i| (i, (at(after, i) - at(before, i)).abs()));
        changes.fold(
            (0, 0.0),
            |most, next| if next.1 > most.1 { next } else { most },
        )
    }

    /// The largest part of a change that the slopes on neither side of an interval explain. It is a jump's size, of a kink it is of the order
    /// of the interval's length, and of what is smooth it is of the order of its square.
    fn bend(&self, kind: Kind, interval: &Interval) -> f64 {
        let t = interval.samples.map(|k| self.samples[k].t);
        let of = |i: usize| {
            let f = interval.samples.map(|k| self.samples[k].value(kind, i));
            let slope = |k: usize| (f[k + 1] - f[k]) / (t[k + 1] - t[k]);
            let unexplained = [0, 2].map(|k| (slope(k) - slope(1)).abs());
            unexplained[0].min(unexplained[1]) * (t[2] - t[1])
        };
        (0..self.places[kind as usize].len())
            .map(of)
            .fold(0.0, f64::max)
    }

    /// Looks at u + t d, unless that was done, and returns the number of the sample.
    fn sample(&mut self, t: f64) -> usize {
        if let Some(known) = self.known.get(&t.to_bits()) {
            return *known;
        }
        let u = self.state(t);
        let gaps = self.problem.rows(&u, Sampling::Nodes).expect("a state");
        let keys = gaps.keys();
        let of = |key| self.lambda.get(key).copied().unwrap_or(0.0);
        let lambda: Vec<f64> = keys.iter().map(of).collect();
        let mut values = KINDS.map(|_| Vec::new());
        let mut note = |kind: Kind, place: Place, value: f64| {
            let (places, values) = (&mut self.places[kind as usize], &mut values[kind as usize]);
            let number = *self.numbers.entry(place).or_insert(places.len());
            if number == places.len() {
                places.push(place);
            }
            values.resize(values.len().max(number + 1), 0.0);
            values[number] = value;
        };
        for (node, force) in self
            .problem
            .contact_forces(&gaps, &lambda)
            .iter()
            .enumerate()
        {
            for axis in (0..D).filter(|axis| force[*axis] != 0.0) {
                note(Kind::Forces, Place::Force { node, axis }, force[axis]);
            }
        }
        let mut c = vec![0.0; gaps.len()];
        gaps.value(&u, &mut c);
        for (i, key) in keys.iter().enumerate() {
            let acts = lambda[i] > ACTS;
            let gap = if acts { c[i] } else { c[i].min(0.0) };
            note(Kind::Gaps, Place::Gap(*key), gap / self.facet);
            if acts {
                let row = gaps.row(i);
                let free = row.free.iter().map(|(j, a)| (Unknown::Free(*j), *a));
                let held = row
                    .prescribed
                    .iter()
                    .map(|(j, a)| (Unknown::Prescribed(*j), *a));
                for (unknown, a) in free.chain(held) {
                    note(Kind::Coefficients, Place::Coefficient(*key, unknown), a);
                }
            }
        }
        self.known.insert(t.to_bits(), self.samples.len());
        self.samples.push(Sample { t, values });
        self.samples.len() - 1
    }
}

/// A linear congruential generator (Knuth's MMIX), from 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        let step = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = step.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

//! When pairs and obstacles count, and supports hold.

use super::Side;
use super::contact_set::place_of;
use crate::contact::Pass;
use crate::error::Error;

/// What may be switched on and off.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Switched {
    /// The pairs of two boundaries, in any order.
    Pair(Side, Side),
    /// All contact with the obstacle of this number.
    Obstacle(usize),
}

/// Intervals of the load factor, without their beginnings and with their ends.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct During(Vec<[f64; 2]>);

/// Beginning and end of the phases that end at `ends`.
pub(super) fn phases(ends: &[f64]) -> impl Iterator<Item = [f64; 2]> {
    let begins = std::iter::once(0.0).chain(ends.iter().copied());
    begins.zip(ends).map(|(from, until)| [from, *until])
}

impl During {
    /// # Errors
    /// Intervals that are empty, and ends that are no numbers.
    pub fn new(intervals: &[[f64; 2]], name: &'static str) -> Result<Self, Error> {
        let is_sound = |[from, to]: &&[f64; 2]| from.is_finite() && to > from;
        match intervals.iter().find(|interval| !is_sound(interval)) {
            None => Ok(During(intervals.to_vec())),
            Some([from, to]) => Err(Error::Setting {
                name,
                value: if from.is_finite() { *to } else { *from },
                remedy: "give pairs of load factors, the end of each beyond its beginning; the end may be infinite",
            }),
        }
    }

    /// Whether `t` is in one of them. What counts within the first step is there at rest.
    pub fn has(&self, t: f64) -> bool {
        let mut all = self.0.iter();
        all.any(|[from, to]| (*from < t || (t == 0.0 && *from <= 0.0)) && t <= *to)
    }

    /// Where the interval begins that has `t`.
    pub fn beginning(&self, t: f64) -> Option<f64> {
        let mut all = self.0.iter();
        all.find(|[from, to]| *from < t && t <= *to)
            .map(|[from, _]| *from)
    }

    /// Its intervals.
    pub fn intervals(&self) -> impl Iterator<Item = [f64; 2]> {
        self.0.iter().copied()
    }

    /// The intervals that both have.
    pub fn common(&self, other: &Self) -> impl Iterator<Item = [f64; 2]> {
        let both = |a: [f64; 2]| {
            let common = move |b: [f64; 2]| [a[0].max(b[0]), a[1].min(b[1])];
            other.intervals().map(common)
        };
        let all = self.intervals().flat_map(both);
        all.filter(|[from, to]| from < to)
    }

    /// Whether some load factor of a run that ends at `end` is in one of them.
    pub fn begins_before(&self, end: f64) -> bool {
        self.0.iter().any(|[from, to]| *from < end && *to > 0.0)
    }

    /// A beginning or an end within a phase, away from its ends.
    pub fn within(&self, [from, until]: [f64; 2]) -> Option<f64> {
        let close = 1e-9 * (until - from);
        let mut times = self.0.iter().flatten().copied();
        times.find(|t| *t > from + close && *t < until - close)
    }
}

/// The passes of a scene that do not count at all times.
#[derive(Clone, Debug, Default)]
pub(super) struct Switches {
    all: Vec<Switch>,
    /// The present load factor.
    time: f64,
}

#[derive(Clone, Debug)]
struct Switch {
    /// Two surfaces, or an obstacle.
    what: Place,
    during: During,
}

#[derive(Clone, Copy, Debug)]
enum Place {
    Surfaces([usize; 2]),
    /// By its number as a master.
    Obstacle(usize),
}

impl Switches {
    /// `sides` are all sides of pairs and obstacles, in the order of surfaces.
    pub fn new<'a>(switched: &'a [(Switched, During)], sides: &mut Vec<&'a Side>) -> Self {
        let surfaces = sides.len();
        let switch = |(what, during): &'a (Switched, During)| Switch {
            what: match what {
                Switched::Pair(a, b) => Place::Surfaces([place_of(a, sides), place_of(b, sides)]),
                Switched::Obstacle(index) => Place::Obstacle(surfaces + index),
            },
            during: during.clone(),
        };
        Switches {
            all: switched.iter().map(switch).collect(),
            time: 0.0,
        }
    }

    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Sets the load factor, and tells whether other passes count than before.
    pub fn set_time(&mut self, t: f64) -> bool {
        let before = std::mem::replace(&mut self.time, t);
        let mut all = self.all.iter();
        all.any(|switch| switch.during.has(before) != switch.during.has(t))
    }

    /// Whether a pass, in either role, counts now.
    pub fn is_on(&self, pass: Pass) -> bool {
        self.is_on_at(pass, self.time)
    }

    /// Whether it counts at load factor `t`.
    pub fn is_on_at(&self, pass: Pass, t: f64) -> bool {
        let is_own = |switch: &&Switch| match switch.what {
            Place::Surfaces([a, b]) => {
                [pass.slave, pass.master] == [a, b] || [pass.master, pass.slave] == [a, b]
            }
            Place::Obstacle(master) => pass.master == master,
        };
        let mut own = self.all.iter().filter(is_own);
        own.all(|switch| switch.during.has(t))
    }
}

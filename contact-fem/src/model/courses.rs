//! How the prescribed displacements and the loads of a body change with the load factor, a pseudo-time.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Body;
use crate::error::Error;
use crate::program::{Amplitude, Motion};
use crate::tensor::Vector;

/// A displacement or a force by time and reference position.
pub(crate) type Path<const D: usize> = Arc<dyn Fn(f64, &Vector<D>) -> Vector<D> + Send + Sync>;

/// How a prescribed displacement changes with time.
#[derive(Clone)]
pub(crate) enum Course<const D: usize> {
    /// The value times an amplitude.
    Scaled(Amplitude),
    /// The component of a displacement, which may be that of a rigid motion.
    Along(Path<D>, Option<Motion<D>>),
    /// A sum of others, whatever the value.
    Sum(Vec<Part>),
}

/// A value of a dof along a course, times a factor.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    pub factor: f64,
    pub dof: usize,
    pub value: (f64, usize),
}

impl Part {
    pub fn times(self, factor: f64) -> Self {
        Part {
            factor: factor * self.factor,
            ..self
        }
    }
}

/// The prescribed displacements of a body.
#[derive(Clone)]
pub(crate) struct Supports<const D: usize> {
    /// X of all nodes (UL).
    pub X: Vec<Vector<D>>,
    /// For each dof the value at amplitude 1 (UL), and the number of its course.
    pub values: Vec<Option<(f64, usize)>>,
    /// The first is proportional.
    pub courses: Vec<Course<D>>,
    /// The dofs that are held from a later moment on: where they were then (UL), and the load factor.
    pub begun: BTreeMap<usize, (f64, f64)>,
}

impl<const D: usize> Supports<D> {
    pub fn new(X: Vec<Vector<D>>) -> Self {
        Supports {
            values: vec![None; D * X.len()],
            X,
            courses: vec![Course::Scaled(Amplitude::default())],
            begun: BTreeMap::new(),
        }
    }

    /// Whether all prescribed displacements are proportional.
    pub fn is_proportional(&self) -> bool {
        self.courses.len() == 1
    }

    /// The times of the tables of all courses.
    pub fn knots(&self) -> impl Iterator<Item = f64> + '_ {
        self.courses.iter().flat_map(|course| -> Vec<f64> {
            match course {
                Course::Scaled(amplitude) => amplitude.knots().collect(),
                Course::Along(_, Some(motion)) => motion.knots().collect(),
                Course::Along(_, None) | Course::Sum(_) => Vec::new(),
            }
        })
    }

    /// The value of one dof at time `t` (UL) along a course, from where it was when its support began.
    pub fn value(&self, dof: usize, value: (f64, usize), t: f64) -> f64 {
        let course = |t| self.course_at(dof, value, t);
        let Some(&(place, since)) = self.begun.get(&dof) else {
            return course(t);
        };
        match (&self.courses[value.1], self.begun_at(dof / D, since)) {
            (Course::Along(_, Some(motion)), Some(x)) => {
                let start = motion.pose(since).back(&x);
                (motion.at(t, &start) - self.X[dof / D])[dof % D]
            }
            _ => place + (course(t) - course(since)),
        }
    }

    /// Where a node was (UL) when a support of all its components began at the load factor `since`.
    fn begun_at(&self, node: usize, since: f64) -> Option<Vector<D>> {
        let mut x = self.X[node];
        for i in 0..D {
            let (place, own) = self.begun.get(&(D * node + i))?;
            x[i] += place;
            if *own != since {
                return None;
            }
        }
        Some(x)
    }

    /// The same of a support that holds from the beginning.
    pub fn course_at(&self, dof: usize, (value, course): (f64, usize), t: f64) -> f64 {
        match &self.courses[course] {
            Course::Scaled(amplitude) => value * amplitude.at(t),
            Course::Along(path, _) => path(t, &self.X[dof / D])[dof % D],
            Course::Sum(parts) => parts.iter().map(|part| self.part_at(part, t)).sum(),
        }
    }

    pub fn part_at(&self, part: &Part, t: f64) -> f64 {
        part.factor * self.course_at(part.dof, part.value, t)
    }

    /// The prescribed displacements at time `t` (UL), in ascending order of the dofs; none at 0, before the first step.
    pub fn at(&self, t: f64) -> Vec<f64> {
        let values = self.values.iter().enumerate();
        let held = values.filter_map(|(dof, value)| Some((dof, (*value)?)));
        match t == 0.0 {
            true => held.map(|_| 0.0).collect(),
            false => held.map(|(dof, value)| self.value(dof, value, t)).collect(),
        }
    }
}

/// Adds the forces at a time to those of all dofs (UF).
type AddForces = Arc<dyn Fn(f64, &mut [f64]) + Send + Sync>;

/// Nodal forces by time.
#[derive(Clone)]
pub(crate) enum Load<const D: usize> {
    /// Forces (all dofs, UF) times an amplitude.
    Scaled(Vec<f64>, Amplitude),
    /// Whatever is added to the forces of all dofs at a time.
    Given(AddForces),
}

/// Where a load comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// A traction on a boundary.
    Traction(String),
    /// A pressure on a boundary, under a law for small strains.
    Pressure(String),
    /// Forces on cells.
    BodyForce,
    /// Forces on nodes.
    NodalForce,
    /// What draws tied sides together, on a boundary.
    Preload(String),
}

impl Origin {
    /// What users call it.
    pub fn kind(&self) -> &'static str {
        match self {
            Origin::Traction(_) => "traction",
            Origin::Pressure(_) => "pressure",
            Origin::BodyForce => "body force",
            Origin::NodalForce => "nodal force",
            Origin::Preload(_) => "preload",
        }
    }
}

impl Origin {
    /// The boundary that it is on.
    pub fn boundary(&self) -> Option<&str> {
        match self {
            Origin::Traction(boundary) | Origin::Preload(boundary) => Some(boundary),
            _ => None,
        }
    }
}

impl<const D: usize> Load<D> {
    /// Whether it is its value at load factor 1 times the load factor.
    pub fn is_proportional(&self) -> bool {
        matches!(self, Load::Scaled(_, amplitude) if amplitude.is_proportional())
    }

    /// The times of the table of its amplitude.
    pub fn knots(&self) -> Vec<f64> {
        match self {
            Load::Scaled(_, amplitude) => amplitude.knots().collect(),
            Load::Given(_) => Vec::new(),
        }
    }

    /// Adds the forces at time `t` to those of all dofs (UF).
    pub fn add(&self, t: f64, forces: &mut [f64]) {
        match self {
            Load::Scaled(own, amplitude) => {
                let factor = amplitude.at(t);
                forces
                    .iter_mut()
                    .zip(own)
                    .for_each(|(sum, f)| *sum += factor * f);
            }
            Load::Given(add) => add(t, forces),
        }
    }
}

/// Checks the values of a body at time `t`.
pub(crate) fn check<const D: usize>(body: &Body<D>, name: &str, t: f64) -> Result<(), Error> {
    let what = |what: &str| format!("the {what} of body `{name}` at load factor {t}");
    if !body.has_program() {
        return Ok(());
    }
    Error::check_finite(&what("prescribed displacements"), &body.prescribed_at(t))?;
    Error::check_finite(&what("forces"), &body.forces_at(t))?;
    Error::check_finite(&what("pressures"), &body.pressures_at(t))
}

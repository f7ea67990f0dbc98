//! The settings of one run.

use std::fmt;

use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::prelude::*;
use serde::{Deserialize, Serialize};

/// How gaps are integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Points {
    /// The library's Gauss points.
    Gauss,
    /// Facets cut along the other mesh.
    Exact,
}

/// How step 5 is done, by the paper's equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Formulation {
    /// (7)
    InteriorPoint,
    /// (37)
    PenalizedSlack,
    /// (39)
    Penalty,
    /// None of them: the solver that the library takes by default, see [`Automatic`].
    Automatic,
}

/// How fixed-point iterates are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Variant {
    /// As in the paper.
    Plain,
    /// Anderson acceleration as deep as the library has it by default.
    Anderson,
}

/// Everything that decides what one run does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// The name of its family.
    pub family: String,
    /// The degree of its elements, 1 or 2.
    pub degree: usize,
    /// How fine the mesh is; what it counts is the family's.
    pub level: usize,
    /// How fine the mesh is where the level counts something else and the mesh is not the family's own.
    #[serde(default)]
    pub mesh: Option<usize>,
    /// How gaps are integrated.
    pub points: Points,
    /// The method for step 5.
    pub method: Formulation,
    /// The fixed point.
    pub variant: Variant,
    /// TOLER of the fixed point; [`Formulation::Automatic`] has its own.
    pub tolerance: f64,
    /// What (7) may leave of gap times force, [`InteriorPoint::complementarity`]. Larger ones than by default raise
    /// Ipopt's tolerance with them, which bounds it, too.
    pub complementarity: f64,
}

impl Case {
    /// All by default.
    pub fn new(family: &str, degree: usize, level: usize) -> Self {
        Case {
            family: family.into(),
            degree,
            level,
            mesh: None,
            points: Points::Gauss,
            method: Formulation::InteriorPoint,
            variant: Variant::Anderson,
            tolerance: FixedPoint::<InteriorPoint>::default().tolerance,
            complementarity: InteriorPoint::default().complementarity,
        }
    }

    /// The same with other points.
    pub fn with_points(self, points: Points) -> Self {
        Case { points, ..self }
    }

    /// The same with another method.
    pub fn with_method(self, method: Formulation) -> Self {
        Case { method, ..self }
    }

    /// Linear or quadratic.
    pub fn order(&self) -> Order {
        match self.degree {
            1 => Order::Linear,
            _ => Order::Quadratic,
        }
    }

    /// The integration asked for, if it is not the scene's own.
    pub fn integration(&self) -> Option<Integration> {
        (self.points == Points::Exact).then_some(Integration::Exact)
    }

    /// The method with its settings, where the paper's fixed point has one.
    fn method(&self) -> Option<Box<dyn Method>> {
        Some(match self.method {
            Formulation::InteriorPoint => {
                let default = InteriorPoint::default();
                let looser = (self.complementarity / default.complementarity).max(1.0);
                Box::new(InteriorPoint {
                    tolerance: default.tolerance * looser,
                    complementarity: self.complementarity,
                    ..default
                })
            }
            Formulation::PenalizedSlack => Box::new(PenalizedSlack::default()),
            Formulation::Penalty => Box::new(Penalty::default()),
            Formulation::Automatic => return None,
        })
    }

    /// So many load increments with the solver asked for.
    pub fn simulation(&self, increments: usize) -> Simulation<Box<dyn Equilibrium>> {
        let Some(method) = self.method() else {
            return Simulation::solved_by(Box::new(Automatic::default()), increments);
        };
        let mut solver = Retry::with(method);
        let fixed_point = &mut solver.fixed_point;
        fixed_point.tolerance = self.tolerance;
        fixed_point.acceleration = match self.variant {
            Variant::Plain => Acceleration::Plain,
            Variant::Anderson => fixed_point.acceleration,
        };
        Simulation::solved_by(Box::new(solver), increments)
    }

    /// What it has in common with the same settings on other meshes.
    pub fn setting(&self) -> Setting {
        Setting(Case {
            level: 0,
            ..self.clone()
        })
    }
}

/// A case but for its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting(Case);

impl Setting {
    /// The case that it was taken from, at level 0.
    pub fn case(&self) -> &Case {
        &self.0
    }
}

/// What is not by default is named.
impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let case = &self.0;
        let default = Case::new(&case.family, case.degree, 0);
        let points = match case.points {
            Points::Gauss => "Gauss",
            Points::Exact => "exact",
        };
        let method = match case.method {
            Formulation::InteriorPoint => "(7)",
            Formulation::PenalizedSlack => "(37)",
            Formulation::Penalty => "(39)",
            Formulation::Automatic => "default solver",
        };
        write!(f, "P{}, {points}, {method}", case.degree)?;
        if let Some(mesh) = case.mesh {
            write!(f, ", mesh {mesh}")?;
        }
        if case.variant != default.variant {
            write!(f, ", plain")?;
        }
        if case.tolerance != default.tolerance {
            write!(f, ", TOLER {:.0e}", case.tolerance)?;
        }
        if case.complementarity != default.complementarity {
            write!(f, ", gap × force {:.0e}", case.complementarity)?;
        }
        Ok(())
    }
}

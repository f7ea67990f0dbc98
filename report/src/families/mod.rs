//! The benchmark families: what each runs, measures and compares with.

mod ball;
mod beams;
mod block;
mod discs;
mod hertz;
mod manufactured;
mod patch;
mod work;

use crate::Failure;
use crate::case::Case;
use crate::record::Measured;
use crate::refined::Place;

/// How much is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// For continuous integration: few and coarse meshes.
    Quick,
    /// Everything.
    Full,
}

impl Scope {
    /// One of two choices.
    pub fn pick<T>(self, quick: T, full: T) -> T {
        match self {
            Scope::Quick => quick,
            Scope::Full => full,
        }
    }
}

/// What a user may ask accuracy of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A contact pressure.
    Pressure,
    /// A resultant force.
    Force,
    /// A displacement.
    Displacement,
    /// A strain or stress, ∇u for short.
    Gradient,
    /// An energy or a length of the contact zone.
    Other,
}

/// An error that a family measures.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Its name in the data.
    pub name: &'static str,
    /// Its name on the page.
    pub title: &'static str,
    /// What it is an error of.
    pub kind: Kind,
    /// The orders in h that theory lets P1 and P2 expect, where it says.
    pub orders: [Option<f64>; 2],
    /// If the error is taken against the refined solution, the name of the value.
    pub refined: Option<&'static str>,
}

impl Quantity {
    /// Without an order, against something exact.
    pub const fn new(name: &'static str, title: &'static str, kind: Kind) -> Self {
        Quantity {
            name,
            title,
            kind,
            orders: [None; 2],
            refined: None,
        }
    }

    /// With the orders of P1 and P2 by theory.
    pub const fn of_orders(self, p1: f64, p2: f64) -> Self {
        Quantity {
            orders: [Some(p1), Some(p2)],
            ..self
        }
    }

    /// Against the refined solution's value of this name.
    pub const fn against_refined(self, value: &'static str) -> Self {
        Quantity {
            refined: Some(value),
            ..self
        }
    }
}

/// What the numbers of a family have to show, on the page and to the command's exit code.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// The quantity.
    pub quantity: &'static str,
    /// P1 or P2.
    pub degree: usize,
    /// The bound.
    pub bound: Bound,
}

/// A bound on the series with default settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// The fitted order is at least this.
    Order(f64),
    /// The error on the finest mesh is at most this.
    Finest(f64),
}

/// A family of runs.
pub struct Family {
    /// Its name in the data.
    pub name: &'static str,
    /// Its name on the page.
    pub title: &'static str,
    /// What it is, what varies and what is measured.
    pub about: &'static str,
    /// What errors are taken against, and how that was obtained.
    pub reference: &'static str,
    /// What theory says, and why.
    pub theory: &'static str,
    /// Why curves bend and settings fail, as far as is known.
    pub causes: &'static str,
    /// What h is.
    pub size: &'static str,
    /// The errors, most important first.
    pub quantities: &'static [Quantity],
    /// What must hold.
    pub claims: &'static [Claim],
    /// The runs.
    pub cases: fn(Scope) -> Vec<Case>,
    /// The run that others are compared with, if they are.
    pub refined: Option<fn(Scope) -> Case>,
    /// Does one, with the place where the refined solution is, or is to be, kept.
    pub run: fn(&Case, &Place) -> Result<Measured, Failure>,
}

impl Family {
    /// The quantity of this name.
    pub fn quantity(&self, name: &str) -> Option<&Quantity> {
        self.quantities.iter().find(|q| q.name == name)
    }

    /// The refined run first, then the others.
    pub fn all_cases(&self, scope: Scope) -> Vec<Case> {
        let mut cases: Vec<Case> = self.refined.iter().map(|refined| refined(scope)).collect();
        for case in (self.cases)(scope) {
            if !cases.contains(&case) {
                cases.push(case);
            }
        }
        cases
    }
}

/// All families, in the order of the page.
pub fn all() -> Vec<Family> {
    let [smooth, zone] = manufactured::plane();
    let [hertz, published] = hertz::families();
    let [smooth_in_space, zone_in_space] = manufactured::space();
    let [discs_work, sliding_work] = work::families();
    vec![
        patch::family(),
        smooth,
        zone,
        smooth_in_space,
        zone_in_space,
        hertz,
        published,
        ball::family(),
        block::family(),
        discs::family(),
        discs_work,
        sliding_work,
        beams::family(),
    ]
}

/// The family of this name.
pub fn named(name: &str) -> Result<Family, Failure> {
    let found = all().into_iter().find(|family| family.name == name);
    found.ok_or_else(|| format!("no family is called {name}").into())
}

/// Default cases of a family at these levels, for P1 and P2.
fn ladder(family: &str, p1: &[usize], p2: &[usize]) -> Vec<Case> {
    let of = |degree: usize, levels: &[usize]| -> Vec<Case> {
        levels
            .iter()
            .map(|&level| Case::new(family, degree, level))
            .collect()
    };
    [of(1, p1), of(2, p2)].concat()
}

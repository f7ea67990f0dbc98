//! A comparison as text.

use std::fmt::{self, Display, Formatter};

use super::{Comparison, Matching, Note, Program, Quantity, Row, Source};

impl Display for Comparison {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "A: {}", self.a)?;
        writeln!(f, "B: {}", self.b)?;
        writeln!(f, "nodes: {}", self.matching)?;
        self.notes
            .iter()
            .try_for_each(|note| writeln!(f, "note: {note}"))?;
        writeln!(f)?;
        let [quantity, a, b, off, share] = ["", "A", "B", "absolute", "relative"];
        write!(f, "{quantity:<24} {a:>16} {b:>16} {off:>10} {share:>10}")?;
        self.rows.iter().try_for_each(|row| write!(f, "\n{row}"))
    }
}

impl Display for Row {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let name = match &self.body {
            Some(body) => format!("{} {body}", self.quantity),
            None => self.quantity.to_string(),
        };
        let number = |value: Option<f64>| match (value, self.quantity) {
            (None, _) => "-".into(),
            (Some(value), Quantity::Increments | Quantity::Iterations) => format!("{value}"),
            (Some(value), Quantity::InnerIterations) => format!("{value}"),
            (Some(value), Quantity::Seconds) => format!("{value:.3}"),
            (Some(value), _) => format!("{value:.9e}"),
        };
        let short = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.2e}"));
        let (a, b) = (number(self.a), number(self.b));
        let (off, share) = (short(self.absolute), short(self.relative));
        write!(f, "{name:<24} {a:>16} {b:>16} {off:>10} {share:>10}")
    }
}

impl Display for Quantity {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Quantity::Energy => "energy",
            Quantity::Reaction => "reaction",
            Quantity::Displacement => "displacement, largest",
            Quantity::DisplacementL2 => "displacement, L²",
            Quantity::ContactForce => "contact force, largest",
            Quantity::Pressure => "pressure, largest",
            Quantity::Increments => "increments",
            Quantity::Iterations => "iterations",
            Quantity::InnerIterations => "inner iterations",
            Quantity::Seconds => "seconds of processor",
        })
    }
}

impl Display for Source {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let folder = self.folder.display();
        match &self.program {
            Program::Recorded { solver } => write!(f, "{folder}, recorded, solved by {solver}")?,
            Program::Script => write!(f, "{folder}, of a script")?,
        }
        write!(f, ", {} nodes", self.nodes)
    }
}

impl Display for Matching {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Matching::ByNumber => "the same numbers at the same places",
            Matching::ByPlace => "matched by their places",
            Matching::ByNumberUnchecked => {
                "matched by their numbers; one side has no `nodes_BODY.txt` to check their places"
            }
        })
    }
}

impl Display for Note {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Note::Unfinished { side, status } => write!(f, "{side}: {status}"),
            Note::Increments { a, b } => write!(f, "{a} increments in A, {b} in B"),
            Note::Tolerances { a, b } => write!(f, "the tolerance is {a:e} in A, {b:e} in B"),
            Note::Relieved { side, factor } => write!(
                f,
                "{side} ends less strained than it was at time {factor}: relative differences are over the largest values of its run"
            ),
            Note::OppositeForces => f.write_str(
                "the contact forces of A and B have opposite signs: they are Cᵀλ, that is -C'*lm of ff-Ipopt",
            ),
            Note::Unknown { side, keys } => write!(
                f,
                "{side} has keys that are not compared: {}; docs/freefem.md lists those that are",
                keys.join(", ")
            ),
        }
    }
}

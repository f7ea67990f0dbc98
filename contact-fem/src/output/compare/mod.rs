//! The differences between two results: of recorded runs, or of scripts of FreeFEM.
//!
//! [`compare`] reads two folders. One with `summary.json` is that of a [recorded run](super::record); one with `result.txt`
//! is that of a script, whose files docs/freefem.md describes. Nodes are matched by their places, so that their numbers may
//! differ.
//!
//! ```
//! use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
//! use contact_fem::output::compare::{Quantity, Tolerances, compare};
//! use contact_fem::{Body, LinearElastic, Scene, Simulation};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let folder = std::env::temp_dir().join(format!("compare-{}", std::process::id()));
//! for (name, young) in [("soft", 100.0), ("stiff", 101.0)] {
//!     let sides = linspace(0.0, 1.0, 4);
//!     let mut block = Body::new(rectangle(&sides, &sides, Diagonals::Rising)?, LinearElastic::new(young, 0.3)?);
//!     block.prescribe("bottom", [Some(0.0), Some(0.0)])?;
//!     block.prescribe("top", [Some(0.0), Some(-0.1)])?;
//!     let mut scene = Scene::new();
//!     scene.add("block", block);
//!     Simulation::with_increments(1).record(folder.join(name)).run(&mut scene.problem()?)?;
//! }
//! let comparison = compare(&folder.join("soft"), &folder.join("stiff"))?;
//! println!("{comparison}");
//! // both are displaced alike, reactions at top and bottom cancel, and energies differ by 1 %
//! let beyond = comparison.beyond(&Tolerances::all(1e-8));
//! let quantities: Vec<Quantity> = beyond.iter().map(|row| row.quantity).collect();
//! assert_eq!(quantities, [Quantity::Energy]);
//! assert!(comparison.beyond(&Tolerances::all(0.011)).is_empty());
//! # std::fs::remove_dir_all(&folder)?;
//! # Ok(())
//! # }
//! ```

mod error;
mod nodes;
mod norm;
mod outcome;
mod recorded;
mod script;
mod table;

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

pub use error::Error;
use outcome::{Fields, Outcome, Peak, Point, finite};

/// Contact forces whose sum is below this share of the largest are opposite.
const OPPOSITE: f64 = 0.1;

/// One of the two results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The first one.
    A,
    /// The second one.
    B,
}

/// What wrote a result.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Program {
    /// A recorded run of this library.
    Recorded {
        /// The solver that the problem got first.
        solver: String,
    },
    /// A script.
    Script,
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Quantity {
    /// The energy E (UF·UL).
    Energy,
    /// The reaction on a body (UF), by its length; of the components that both results have, if there are such.
    Reaction,
    /// The largest displacement of a node (UL).
    Displacement,
    /// The L² norm of the displacement (UL² in the plane, UL^5/2 in space) over all bodies. A result needs cells for it,
    /// as those of recorded runs have; one of the two is enough.
    DisplacementL2,
    /// The largest contact force Cᵀλ on a node (UF).
    ContactForce,
    /// The largest contact pressure at a node that has one in both (UF/UL in the plane, UF/UL² in space).
    Pressure,
    /// Load increments.
    Increments,
    /// Iterations of the fixed point or of Newton's method.
    Iterations,
    /// Iterations within them.
    InnerIterations,
    /// Seconds of the processor, of a script by its own clock.
    Seconds,
}

/// A quantity in both results.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What is compared.
    pub quantity: Quantity,
    /// The body of a reaction; `None` is the sum that a script chose.
    pub body: Option<String>,
    /// Its size in A; `None` if A does not have it.
    pub a: Option<f64>,
    /// Its size in B; `None` if B does not have it.
    pub b: Option<f64>,
    /// The size of the difference, if both have it: of a field's difference, not of the sizes.
    pub absolute: Option<f64>,
    /// The difference over `scale`. 0 if there is no difference.
    pub relative: Option<f64>,
    /// The larger size; of a reaction, the largest reaction of a body, or energy by largest displacement if that is more. Where a
    /// recorded run ends less strained than it was before ([`Note::Relieved`]), the largest of the run, if that is more.
    pub scale: f64,
}

/// How the nodes were matched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Matching {
    /// Nodes of the same number are at the same place.
    ByNumber,
    /// Nodes at the same place have different numbers.
    ByPlace,
    /// Nodes of the same number were compared: one result does not say where they are.
    ByNumberUnchecked,
}

/// What else is not the same in the two results, or not as it should be.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// Not all increments converged, or the certificate of a recorded run does not hold.
    Unfinished {
        /// Whose.
        side: Side,
        /// What it says.
        status: String,
    },
    /// The load was applied in different numbers of increments.
    Increments {
        /// A's.
        a: f64,
        /// B's.
        b: f64,
    },
    /// The iterations stopped at different tolerances, as both say.
    Tolerances {
        /// A's.
        a: f64,
        /// B's.
        b: f64,
    },
    /// A recorded run ends less strained than it was before. Sizes of that state count as scales of relative differences, and so do the
    /// largest energy and reaction of all increments.
    Relieved {
        /// Whose.
        side: Side,
        /// The load factor at which it was strained most.
        factor: f64,
    },
    /// The contact forces of one are those of the other with the opposite sign.
    OppositeForces,
    /// A script's values that are not compared under these keys.
    Unknown {
        /// Whose.
        side: Side,
        /// The keys, alphabetically.
        keys: Vec<String>,
    },
}

/// A result that was compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Its folder.
    pub folder: PathBuf,
    /// What wrote it.
    pub program: Program,
    /// The number of nodes of all bodies.
    pub nodes: usize,
}

/// The differences between two results.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The first result.
    pub a: Source,
    /// The second one.
    pub b: Source,
    /// How nodes were matched, of the bodies the one with the least certainty.
    pub matching: Matching,
    /// The quantities that at least one of the results has.
    pub rows: Vec<Row>,
    /// What else is not the same.
    pub notes: Vec<Note>,
}

/// The largest relative difference of each quantity. What a run costs has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Of the energy.
    pub energy: f64,
    /// Of reactions.
    pub reaction: f64,
    /// Of displacements, in both norms.
    pub displacement: f64,
    /// Of contact forces on nodes.
    pub force: f64,
    /// Of contact pressures.
    pub pressure: f64,
}

impl Tolerances {
    /// The same for all quantities.
    pub fn all(tolerance: f64) -> Self {
        Tolerances {
            energy: tolerance,
            reaction: tolerance,
            displacement: tolerance,
            force: tolerance,
            pressure: tolerance,
        }
    }

    /// The tolerance of a quantity; `None` of what a run costs.
    pub fn of(&self, quantity: Quantity) -> Option<f64> {
        match quantity {
            Quantity::Energy => Some(self.energy),
            Quantity::Reaction => Some(self.reaction),
            Quantity::Displacement | Quantity::DisplacementL2 => Some(self.displacement),
            Quantity::ContactForce => Some(self.force),
            Quantity::Pressure => Some(self.pressure),
            _ => None,
        }
    }
}

/// 1e-6 for all quantities.
impl Default for Tolerances {
    fn default() -> Self {
        Tolerances::all(1e-6)
    }
}

impl Comparison {
    /// The rows whose relative difference is above the tolerance. What only one result has is not among them.
    pub fn beyond(&self, tolerances: &Tolerances) -> Vec<&Row> {
        let is_beyond = |row: &&Row| {
            let limit = tolerances.of(row.quantity);
            // NaN is beyond, too
            limit
                .zip(row.relative)
                .is_some_and(|(limit, off)| !(off <= limit))
        };
        self.rows.iter().filter(is_beyond).collect()
    }
}

/// Compares the results in two folders.
///
/// # Errors
/// [`Error`], if a folder has no result, a file is missing, damaged or has numbers that are not finite, if both are one
/// folder, or if the two are not results of the same bodies on the same nodes.
pub fn compare(a: &Path, b: &Path) -> Result<Comparison, Error> {
    if let (Ok(of_a), Ok(of_b)) = (a.canonicalize(), b.canonicalize()) {
        if of_a == of_b {
            return Err(Error::Same { folder: a.into() });
        }
    }
    let (a, b) = (Outcome::read(a)?, Outcome::read(b)?);
    if a.dimension != b.dimension {
        return Err(Error::Dimensions {
            a: a.dimension,
            b: b.dimension,
        });
    }
    check_finite(&a)?;
    check_finite(&b)?;
    let mut pairs = Vec::new();
    let mut matching = Matching::ByNumber;
    for of_a in &a.bodies {
        let of_b = b.body(&of_a.name).ok_or_else(|| bodies_differ(&a, &b))?;
        let (nodes, how) = nodes::matched(of_a, of_b, a.dimension)?;
        matching = matching.max(how);
        pairs.push((of_a, renumbered(of_b, &nodes)));
    }
    if a.bodies.len() != b.bodies.len() {
        return Err(bodies_differ(&a, &b));
    }
    let mut rows = vec![scalar(&a, &b, Quantity::Energy, "energy")];
    let fields = fields(&pairs, a.dimension);
    rows.extend(reactions(&a, &b, force_scale(&rows[0], &fields)));
    rows.extend(fields);
    rows.extend([
        scalar(&a, &b, Quantity::Increments, "increments"),
        scalar(&a, &b, Quantity::Iterations, "fixed_point_iterations"),
        scalar(&a, &b, Quantity::InnerIterations, "ipopt_iterations"),
        scalar(&a, &b, Quantity::Seconds, "seconds_total"),
    ]);
    rows.retain(|row| row.a.is_some() || row.b.is_some());
    for peak in [&a, &b].into_iter().filter_map(|own| own.peak.as_ref()) {
        let sizes = peak_sizes(peak, a.dimension);
        rows.iter_mut().for_each(|row| row.scaled(&sizes));
    }
    let mut notes = notes(&a, &b);
    if are_opposite(&pairs) {
        notes.push(Note::OppositeForces);
    }
    Ok(Comparison {
        notes,
        a: source(a),
        b: source(b),
        matching,
        rows,
    })
}

/// The nodes of a body that have fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Nodes {
    /// The name of the body.
    pub body: String,
    /// Where they are at rest (UL); the third coordinate is 0 in the plane.
    pub places: Vec<[f64; 3]>,
}

/// The fields of a result at given nodes of a body; third components are 0 in the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// The name of the body.
    pub body: String,
    /// The displacement of each node (UL).
    pub displacements: Vec<[f64; 3]>,
    /// The contact force Cᵀλ on each node (UF), if the result has it.
    pub forces: Option<Vec<[f64; 3]>>,
}

/// The dimension and the nodes of all bodies, in the order of the files `nodes_BODY.txt` in a folder.
///
/// # Errors
/// No such file, or a damaged one.
pub fn nodes_of(folder: &Path) -> Result<(usize, Vec<Nodes>), Error> {
    script::nodes(folder)
}

/// The fields of the result in a folder at these nodes, which are found by their places.
///
/// # Errors
/// As [`compare`], if the result has another dimension or lacks a body or a node.
pub fn fields_at(folder: &Path, dimension: usize, nodes: &[Nodes]) -> Result<Vec<Field>, Error> {
    let result = Outcome::read(folder)?;
    if result.dimension != dimension {
        return Err(Error::Dimensions {
            a: dimension,
            b: result.dimension,
        });
    }
    let of_body = |nodes: &Nodes| {
        let target = Fields {
            name: nodes.body.clone(),
            places: Some(nodes.places.clone()),
            displacements: vec![[0.0; 3]; nodes.places.len()],
            ..Fields::default()
        };
        let own = result.body(&nodes.body).ok_or_else(|| Error::Bodies {
            a: vec![nodes.body.clone()],
            b: result.names(),
        })?;
        let (found, _) = nodes::matched(&target, own, dimension)?;
        let fields = renumbered(own, &found);
        Ok(Field {
            body: fields.name,
            displacements: fields.displacements,
            forces: fields.forces,
        })
    };
    nodes.iter().map(of_body).collect()
}

fn bodies_differ(a: &Outcome, b: &Outcome) -> Error {
    Error::Bodies {
        a: a.names(),
        b: b.names(),
    }
}

fn source(outcome: Outcome) -> Source {
    let nodes = outcome.bodies.iter().map(|body| body.displacements.len());
    Source {
        nodes: nodes.sum(),
        folder: outcome.folder,
        program: outcome.program,
    }
}

/// Checks the values that decide.
fn check_finite(outcome: &Outcome) -> Result<(), Error> {
    let decides = |key: &str| key == "energy" || key.starts_with("reaction");
    let mut values = outcome.values.iter().filter(|(key, _)| decides(key));
    values.try_for_each(|(key, &value)| {
        let path = match outcome.program {
            Program::Script => script::RESULT,
            Program::Recorded { .. } => recorded::SUMMARY,
        };
        finite(&outcome.folder.join(path), || key.clone(), value).map(drop)
    })
}

/// The fields of a body by the nodes of the other result.
fn renumbered(body: &Fields, nodes: &[usize]) -> Fields {
    let pick = |all: &Vec<Point>| nodes.iter().map(|&node| all[node]).collect();
    let mut back = vec![0; nodes.len()];
    for (mine, &theirs) in nodes.iter().enumerate() {
        back[theirs] = mine;
    }
    let pressures = body.pressures.iter().flatten();
    let cells = body.cells.iter();
    Fields {
        name: body.name.clone(),
        places: body.places.as_ref().map(pick),
        cells: cells
            .map(|cell| cell.iter().map(|&node| back[node]).collect())
            .collect(),
        displacements: pick(&body.displacements),
        forces: body.forces.as_ref().map(pick),
        pressures: body
            .pressures
            .is_some()
            .then(|| pressures.map(|(&node, &p)| (back[node], p)).collect()),
    }
}

fn scalar(a: &Outcome, b: &Outcome, quantity: Quantity, key: &str) -> Row {
    let (a, b) = (a.value(key), b.value(key));
    let off = a.zip(b).map(|(a, b)| (a - b).abs());
    let size = a.unwrap_or(0.0).abs().max(b.unwrap_or(0.0).abs());
    Row::new(quantity, None, [a, b], off, size)
}

/// A row for each body, and one for the sum that scripts may give instead.
fn reactions(a: &Outcome, b: &Outcome, scale: f64) -> Vec<Row> {
    let names = a.names().into_iter().map(Some).chain([None]);
    let pairs: Vec<_> = names
        .map(|body| {
            let key = match &body {
                Some(body) => format!("reaction_{body}"),
                None => "reaction".into(),
            };
            let (a, b) = (a.vector(&key), b.vector(&key));
            let both = [0, 1, 2].map(|i| a[i].is_some() && b[i].is_some());
            let shared = both.contains(&true);
            let of = |own: [Option<f64>; 3]| {
                let own = [0, 1, 2].map(|i| own[i].filter(|_| both[i] || !shared));
                let known = own.iter().any(Option::is_some);
                known.then(|| own.map(Option::unwrap_or_default))
            };
            (body, of(a), of(b), shared)
        })
        .collect();
    let sizes = pairs.iter().flat_map(|(_, a, b, _)| [a, b]).flatten();
    let largest = sizes.map(length).fold(scale, f64::max);
    type Pair = (Option<String>, Option<Point>, Option<Point>, bool);
    let row = |(body, a, b, shared): Pair| {
        let off = a.zip(b).filter(|_| shared);
        let off = off.map(|(a, b)| length(&minus(&a, &b)));
        let sizes = [a, b].map(|r| r.as_ref().map(length));
        Row::new(Quantity::Reaction, body, sizes, off, largest)
    };
    pairs.into_iter().map(row).collect()
}

/// The sizes of what a run went through before its end.
fn peak_sizes(peak: &Peak, dimension: usize) -> BTreeMap<Quantity, f64> {
    let bodies = peak.bodies.iter();
    let itself: Vec<(&Fields, Fields)> = bodies.map(|own| (own, own.clone())).collect();
    let fields = fields(&itself, dimension).into_iter();
    let sizes = fields.filter_map(|row| Some((row.quantity, row.a?)));
    let of_all = [
        (Quantity::Energy, peak.energy),
        (Quantity::Reaction, peak.reaction),
    ];
    sizes.chain(of_all).collect()
}

/// Energy over displacement, a force: the reactions of a body that is held on two sides may cancel.
fn force_scale(energy: &Row, fields: &[Row]) -> f64 {
    let size = |row: &Row| row.a.unwrap_or(0.0).abs().max(row.b.unwrap_or(0.0).abs());
    let displacement = fields
        .iter()
        .find(|row| row.quantity == Quantity::Displacement);
    match displacement.map(size) {
        Some(displacement) if displacement > 0.0 => size(energy) / displacement,
        _ => 0.0,
    }
}

/// The rows of displacements, contact forces and pressures.
fn fields(pairs: &[(&Fields, Fields)], dimension: usize) -> Vec<Row> {
    let of_fields = |quantity, of: fn(&Fields) -> Option<&Vec<Point>>| {
        let a: Option<Vec<&Vec<Point>>> = pairs.iter().map(|(a, _)| of(a)).collect();
        let b: Option<Vec<&Vec<Point>>> = pairs.iter().map(|(_, b)| of(b)).collect();
        let size = |all: &Vec<&Vec<Point>>| largest(all.iter().copied().flatten().map(length));
        let sizes = [a.as_ref().map(size), b.as_ref().map(size)];
        let off = a.zip(b).map(|(a, b)| {
            let pairs = a.into_iter().flatten().zip(b.into_iter().flatten());
            largest(pairs.map(|(a, b)| length(&minus(a, b))))
        });
        Row::of_field(quantity, sizes, off)
    };
    vec![
        of_fields(Quantity::Displacement, |body| Some(&body.displacements)),
        norm::row(pairs, dimension),
        of_fields(Quantity::ContactForce, |body| body.forces.as_ref()),
        pressures(pairs),
    ]
}

/// Pressures, at nodes that have one in both results if both give pressures.
fn pressures(pairs: &[(&Fields, Fields)]) -> Row {
    type OfBody = fn(&(&Fields, Fields)) -> BTreeMap<usize, f64>;
    let of_all = |of: OfBody| {
        let bodies = pairs.iter().map(of).enumerate();
        let values = bodies.flat_map(|(body, all)| {
            let all = all.into_iter();
            all.map(move |(node, p)| ((body, node), p))
        });
        values.collect::<BTreeMap<_, _>>()
    };
    let a = of_all(|(a, _)| a.pressures.clone().unwrap_or_default());
    let b = of_all(|(_, b)| b.pressures.clone().unwrap_or_default());
    let both: Vec<(f64, f64)> = a
        .iter()
        .filter_map(|(node, &p)| Some((p, *b.get(node)?)))
        .collect();
    if both.is_empty() {
        let size = |all: BTreeMap<_, f64>| all.into_values().map(f64::abs).reduce(f64::max);
        return Row::of_field(Quantity::Pressure, [size(a), size(b)], None);
    }
    let sizes = [
        largest(both.iter().map(|(p, _)| p.abs())),
        largest(both.iter().map(|(_, q)| q.abs())),
    ];
    let off = largest(both.iter().map(|(p, q)| (p - q).abs()));
    Row::of_field(Quantity::Pressure, sizes.map(Some), Some(off))
}

impl Row {
    fn new(
        quantity: Quantity,
        body: Option<String>,
        [a, b]: [Option<f64>; 2],
        absolute: Option<f64>,
        size: f64,
    ) -> Self {
        Row {
            quantity,
            body,
            a,
            b,
            absolute,
            relative: absolute.map(|off| share(off, size)),
            scale: size,
        }
    }

    /// Scales by the size of its quantity among these, if that is larger.
    fn scaled(&mut self, sizes: &BTreeMap<Quantity, f64>) {
        let size = sizes.get(&self.quantity).copied().unwrap_or(0.0);
        self.scale = self.scale.max(size);
        self.relative = self.absolute.map(|off| share(off, self.scale));
    }

    fn of_field(quantity: Quantity, sizes: [Option<f64>; 2], off: Option<f64>) -> Self {
        let size = sizes.iter().flatten().copied().fold(0.0, f64::max);
        Row::new(quantity, None, sizes, off, size)
    }
}

/// 0 of no difference, whatever its scale is.
fn share(off: f64, size: f64) -> f64 {
    if off == 0.0 { 0.0 } else { off / size }
}

/// What the results say of themselves, as far as it differs.
fn notes(a: &Outcome, b: &Outcome) -> Vec<Note> {
    let status = |side, outcome: &Outcome| {
        let stopped = outcome
            .value("converged")
            .filter(|&converged| converged != 1.0);
        let status = outcome.status.clone();
        let status = status.or(stopped.map(|_| "not all increments converged".into()));
        status.map(|status| Note::Unfinished { side, status })
    };
    let different = |key: &str| {
        let (a, b) = (a.value(key)?, b.value(key)?);
        (a != b).then_some((a, b))
    };
    let increments = different("increments").map(|(a, b)| Note::Increments { a, b });
    let tolerances = different("tolerance").map(|(a, b)| Note::Tolerances { a, b });
    let unknown = |side, outcome: &Outcome| {
        let keys = match outcome.program {
            Program::Script => script::unknown(outcome),
            Program::Recorded { .. } => Vec::new(),
        };
        (!keys.is_empty()).then_some(Note::Unknown { side, keys })
    };
    let unknown = unknown(Side::A, a).into_iter().chain(unknown(Side::B, b));
    let statuses = status(Side::A, a).into_iter().chain(status(Side::B, b));
    let relieved = [(Side::A, a), (Side::B, b)];
    let relieved = relieved.into_iter().filter_map(|(side, own)| {
        let factor = own.peak.as_ref()?.factor;
        Some(Note::Relieved { side, factor })
    });
    let all = statuses.chain(increments).chain(tolerances).chain(relieved);
    let all = all.chain(unknown);
    all.collect()
}

/// Whether both have contact forces whose sum is small.
fn are_opposite(pairs: &[(&Fields, Fields)]) -> bool {
    let forces = pairs.iter().flat_map(|(a, b)| {
        let both = a.forces.iter().zip(&b.forces);
        both.flat_map(|(a, b)| a.iter().zip(b))
    });
    let (mut size, mut sum) = (0.0_f64, 0.0_f64);
    for (a, b) in forces {
        size = size.max(length(a)).max(length(b));
        sum = sum.max(length(&[0, 1, 2].map(|i| a[i] + b[i])));
    }
    sum < OPPOSITE * size
}

fn length(v: &Point) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn minus(a: &Point, b: &Point) -> Point {
    [0, 1, 2].map(|i| a[i] - b[i])
}

/// The largest of finite values, 0 if there are none.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Side::A => "A",
            Side::B => "B",
        })
    }
}

//! Why two results cannot be compared.

use std::fmt;
use std::path::PathBuf;

use super::Side;

/// Why two results cannot be compared. Each contains what is wrong, its value and the remedy.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A folder without a result.
    #[error(
        "{folder} has no result: neither `summary.json` of a recorded run nor `result.txt` of a script"
    )]
    NoResult {
        /// Which folder.
        folder: PathBuf,
    },
    /// One folder given twice, whose comparison could not fail.
    #[error("A and B are the same folder, {folder}: name two results")]
    Same {
        /// Which folder.
        folder: PathBuf,
    },
    /// A file that is missing or that the system does not read.
    #[error("cannot read {path}: {source}")]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that does not hold what it should.
    #[error("{path}: {what}")]
    Malformed {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it, and the remedy.
        what: String,
    },
    /// A number in a file that is NaN or infinite.
    #[error("{path}: {what} is {value}: the run that wrote it has failed")]
    NotFinite {
        /// Which file.
        path: PathBuf,
        /// Which number.
        what: String,
        /// Its value.
        value: f64,
    },
    /// Results in the plane and in space.
    #[error("A has {a} dimensions and B has {b}")]
    Dimensions {
        /// Components of A's displacements.
        a: usize,
        /// Components of B's displacements.
        b: usize,
    },
    /// Bodies of different names.
    #[error(
        "A has the bodies {a:?} and B has {b:?}: call them the same, in the scene or in the script's files"
    )]
    Bodies {
        /// The names of A's bodies.
        a: Vec<String>,
        /// The names of B's bodies.
        b: Vec<String>,
    },
    /// Bodies of different numbers of nodes, one of which does not say where its nodes are.
    #[error(
        "body {body}: A has {a} nodes and B has {b}: compare runs on the same mesh with elements of the same order"
    )]
    NodeCounts {
        /// The name of the body.
        body: String,
        /// The number of A's nodes.
        a: usize,
        /// The number of B's nodes.
        b: usize,
    },
    /// Nodes of one result at places where the other has none.
    #[error(
        "body {body}: {unmatched} of {nodes} nodes of {side} are at no node of the other, which has {others}; \
         the first is node {node} at {place:?}, {distance:.3e} from the nearest: {}", remedy(*only_middles)
    )]
    Unmatched {
        /// The name of the body.
        body: String,
        /// The result whose nodes these are.
        side: Side,
        /// How many have no counterpart.
        unmatched: usize,
        /// The number of nodes of this result.
        nodes: usize,
        /// The number of nodes of the other result.
        others: usize,
        /// The first node without a counterpart, from 0.
        node: usize,
        /// Its place (UL).
        place: Vec<f64>,
        /// Its distance from the nearest node of the other result (UL).
        distance: f64,
        /// Whether the results have equally many nodes, and only middles of edges are without a counterpart: the sides
        /// of one are straight, those of the other curved.
        only_middles: bool,
    },
    /// More than one node at a place, such as on the sides of a crack.
    #[error(
        "body {body}: node {node} of {side} at {place:?} is at {found} nodes of the other: \
         give the nodes of both the same numbers"
    )]
    Ambiguous {
        /// The name of the body.
        body: String,
        /// The result whose node this is.
        side: Side,
        /// The node, from 0.
        node: usize,
        /// Its place (UL).
        place: Vec<f64>,
        /// How many nodes of the other result are there.
        found: usize,
    },
}

/// The `Display` message: `main` and `unwrap` print an error by `Debug`.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

fn remedy(only_middles: bool) -> &'static str {
    match only_middles {
        true => {
            "only middles of edges are elsewhere, the sides of one are straight and of the other curved"
        }
        false => "compare runs on the same mesh with elements of the same order",
    }
}

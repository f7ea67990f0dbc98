//! The files that a script leaves: text, as docs/freefem.md says.

use std::collections::BTreeMap;
use std::path::Path;

use super::outcome::{AXES, Fields, Outcome, Point, finite, malformed, text};
use super::{Error, Nodes, Program};

/// The file of the values, a key and a number a line.
pub(super) const RESULT: &str = "result.txt";

/// Its keys without a body, but for reactions and `seconds_…`.
const KEYS: [&str; 6] = [
    "energy",
    "increments",
    "tolerance",
    "fixed_point_iterations",
    "ipopt_iterations",
    "converged",
];

pub(super) fn read(folder: &Path) -> Result<Outcome, Error> {
    let values = values(&folder.join(RESULT))?;
    let mut dimension = None;
    let bodies: Result<Vec<Fields>, Error> = names(folder, "displacement_")?
        .into_iter()
        .map(|name| fields(folder, name, &mut dimension))
        .collect();
    let Some(dimension) = dimension else {
        let why = "it has no file `displacement_BODY.txt` with a node a line";
        return Err(malformed(folder, why));
    };
    Ok(Outcome {
        folder: folder.into(),
        program: Program::Script,
        dimension,
        values,
        status: None,
        bodies: bodies?,
        peak: None,
    })
}

fn values(path: &Path) -> Result<BTreeMap<String, f64>, Error> {
    let mut values = BTreeMap::new();
    for line in text(path)?.lines().filter(|line| !line.trim().is_empty()) {
        let Some((key, value)) = line.trim().split_once(char::is_whitespace) else {
            let why = format!("the line `{line}` needs a key and a number");
            return Err(malformed(path, why));
        };
        let value = number(path, value.trim())?;
        // a key that nobody asks for may have any value
        if values.insert(key.to_string(), value).is_some() {
            let why = format!("`{key}` is there twice: let the script begin a new file");
            return Err(malformed(path, why));
        }
    }
    Ok(values)
}

/// The keys of a script's result that nothing reads, without those that docs/freefem.md names.
pub(super) fn unknown(outcome: &Outcome) -> Vec<String> {
    let of_body = |key: &str| {
        let names = outcome
            .bodies
            .iter()
            .map(|body| format!("reaction_{}", body.name));
        let mut names = names.chain(["reaction".to_string()]);
        let axes = &AXES[..outcome.dimension];
        names.any(|name| axes.iter().any(|axis| key == format!("{name}_{axis}")))
    };
    let is_known = |key: &str| KEYS.contains(&key) || key.starts_with("seconds_") || of_body(key);
    let keys = outcome.values.keys();
    keys.filter(|key| !is_known(key)).cloned().collect()
}

/// The dimension and the nodes in the files of their places.
pub(super) fn nodes(folder: &Path) -> Result<(usize, Vec<Nodes>), Error> {
    let mut dimension = None;
    let of_body = |body: String| {
        let path = folder.join(format!("nodes_{body}.txt"));
        let places = vectors(&path, &mut dimension)?;
        Ok(Nodes { body, places })
    };
    let nodes: Result<Vec<Nodes>, Error> =
        names(folder, "nodes_")?.into_iter().map(of_body).collect();
    let nodes = nodes?;
    match dimension {
        Some(dimension) => Ok((dimension, nodes)),
        None => {
            let why = "it has no file `nodes_BODY.txt` with a node a line";
            Err(malformed(folder, why))
        }
    }
}

/// The bodies that have a file that begins so, alphabetically.
fn names(folder: &Path, begin: &str) -> Result<Vec<String>, Error> {
    let entries = std::fs::read_dir(folder).map_err(|source| Error::Unreadable {
        path: folder.into(),
        source,
    })?;
    let name = |entry: std::fs::DirEntry| {
        let name = entry.file_name().into_string().ok()?;
        let name = name.strip_prefix(begin)?.strip_suffix(".txt")?;
        Some(name.to_string())
    };
    let mut names: Vec<String> = entries.flatten().filter_map(name).collect();
    names.sort();
    Ok(names)
}

/// Reads the files of a body. All bodies have the components of the first one.
fn fields(folder: &Path, name: String, dimension: &mut Option<usize>) -> Result<Fields, Error> {
    let file = |what: &str| folder.join(format!("{what}_{name}.txt"));
    let displacements = vectors(&file("displacement"), dimension)?;
    let others = |path: &Path, dimension: &mut Option<usize>| match path.exists() {
        true => counted(path, vectors(path, dimension)?, displacements.len()).map(Some),
        false => Ok(None),
    };
    let places = others(&file("nodes"), dimension)?;
    let forces = others(&file("force"), dimension)?;
    let pressures = file("pressure");
    let pressures = match pressures.exists() {
        true => Some(by_node(&pressures, displacements.len())?),
        false => None,
    };
    Ok(Fields {
        name,
        places,
        cells: Vec::new(),
        displacements,
        forces,
        pressures,
    })
}

/// A vector a line.
fn vectors(path: &Path, dimension: &mut Option<usize>) -> Result<Vec<Point>, Error> {
    let mut all = Vec::new();
    for (line, content) in text(path)?.lines().enumerate() {
        let numbers: Vec<&str> = content.split_whitespace().collect();
        if numbers.is_empty() {
            continue;
        }
        let components = *dimension.get_or_insert(numbers.len());
        if numbers.len() != components || ![2, 3].contains(&components) {
            let why = format!(
                "line {} has {} numbers: give each node 2 in the plane, 3 in space",
                line + 1,
                numbers.len()
            );
            return Err(malformed(path, why));
        }
        let mut vector = [0.0; 3];
        for (value, word) in vector.iter_mut().zip(numbers) {
            *value = finite(
                path,
                || format!("a number in line {}", line + 1),
                number(path, word)?,
            )?;
        }
        all.push(vector);
    }
    Ok(all)
}

fn counted(path: &Path, all: Vec<Point>, nodes: usize) -> Result<Vec<Point>, Error> {
    match all.len() == nodes {
        true => Ok(all),
        false => {
            let why = format!(
                "it has {} nodes, and the displacements have {nodes}",
                all.len()
            );
            Err(malformed(path, why))
        }
    }
}

/// A node's number from 0 and its value a line.
fn by_node(path: &Path, nodes: usize) -> Result<BTreeMap<usize, f64>, Error> {
    let mut all = BTreeMap::new();
    for (line, content) in text(path)?.lines().enumerate() {
        let words: Vec<&str> = content.split_whitespace().collect();
        let (node, value) = match words[..] {
            [] => continue,
            [node, value] => (node, value),
            _ => {
                let why = format!("line {} needs a node's number and its pressure", line + 1);
                return Err(malformed(path, why));
            }
        };
        let known = node.parse().ok().filter(|&node: &usize| node < nodes);
        let node = known.ok_or_else(|| {
            let why = format!("`{node}` is no number of a node: they go from 0 to below {nodes}");
            malformed(path, why)
        })?;
        let value = number(path, value)?;
        let value = finite(path, || format!("the pressure of node {node}"), value)?;
        all.insert(node, value);
    }
    Ok(all)
}

fn number(path: &Path, word: &str) -> Result<f64, Error> {
    let parsed = word.parse();
    parsed.map_err(|_| malformed(path, format!("`{word}` is no number")))
}

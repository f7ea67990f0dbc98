//! The files that a recorded run leaves: its summary and the last state of its series.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::outcome::{AXES, Fields, Outcome, Peak, Point, finite, malformed, text};
use super::{Error, Program};
use crate::mesh::read::vtu_arrays::{Piece, Section, pieces};

pub(super) const SUMMARY: &str = "summary.json";

/// What of the summary is compared. Before a run has ended, the summary does not have it all.
#[derive(Deserialize)]
struct Summary {
    scene: String,
    solver: String,
    increments: f64,
    status: String,
    reason: Option<String>,
    converged: bool,
    #[serde(default)]
    bodies: Vec<String>,
    #[serde(default)]
    load_factor: f64,
    energy: Option<f64>,
    #[serde(default)]
    reactions: Vec<Vec<f64>>,
    #[serde(default)]
    iterations: f64,
    #[serde(default)]
    inner_iterations: f64,
    cpu_seconds: Option<f64>,
}

pub(super) fn read(folder: &Path) -> Result<Outcome, Error> {
    let path = folder.join(SUMMARY);
    let summary: Summary = serde_json::from_str(&text(&path)?)
        .map_err(|why| malformed(&path, format!("not a summary of a run: {why}")))?;
    let (Some(_), Some(first)) = (summary.energy, summary.reactions.first()) else {
        let why = format!(
            "the run has no converged step, its status is `{}`",
            summary.status
        );
        return Err(malformed(&path, why));
    };
    let dimension = first.len();
    let listing = Listing::read(folder, &summary)?;
    let grid = last_state(&listing, &summary)?;
    Ok(Outcome {
        folder: folder.into(),
        program: Program::Recorded {
            solver: summary.solver.clone(),
        },
        dimension,
        bodies: bodies(&grid.0, &grid.1, &summary.bodies)?,
        values: values(&summary),
        // older runs may lack files, and scale by their last states alone
        peak: peak(folder, &listing, &summary, dimension),
        status: match summary.status == "complete" {
            true => summary.reason,
            false => Some(summary.reason.unwrap_or(summary.status)),
        },
    })
}

/// The end strains the bodies by less than this share of the largest stored energy, where an increment before is looked at, too.
const LESS: f64 = 0.99;

/// The increment with the largest stored energy among those whose fields are there, if the run ends with less.
fn peak(folder: &Path, listing: &Listing, summary: &Summary, dimension: usize) -> Option<Peak> {
    let path = folder.join(format!("{}.csv", summary.scene));
    let steps = steps(&path)?;
    let value = |step: &BTreeMap<String, f64>, key: &str| step.get(key).copied();
    let stored = |step: &BTreeMap<String, f64>| value(step, "stored_energy").unwrap_or(0.0);
    let file = |step: &BTreeMap<String, f64>| {
        let factor = value(step, "load_factor")?;
        let mut all = listing.states.iter();
        all.find(|(time, _)| (time - factor).abs() <= SAME_TIME)
    };
    let with_fields = steps.iter().filter(|step| file(step).is_some());
    let most = with_fields.max_by(|a, b| stored(a).total_cmp(&stored(b)))?;
    if stored(steps.last()?) >= LESS * stored(most) {
        return None;
    }
    let reaction = |step: &BTreeMap<String, f64>, body: &String| {
        let axes = AXES.iter().take(dimension);
        let components = axes.filter_map(|axis| value(step, &format!("reaction_{body}_{axis}")));
        components.map(|r| r * r).sum::<f64>().sqrt()
    };
    let reactions = steps
        .iter()
        .flat_map(|step| summary.bodies.iter().map(move |body| reaction(step, body)));
    let energies = steps.iter().filter_map(|step| value(step, "energy"));
    let (factor, file) = file(most)?;
    let path = folder.join(file);
    Some(Peak {
        factor: *factor,
        energy: energies.map(f64::abs).fold(0.0, f64::max),
        reaction: reactions.fold(0.0, f64::max),
        bodies: bodies(&path, &state(&path).ok()?, &summary.bodies).ok()?,
    })
}

/// The numbers of the converged increments, by the names of their columns.
fn steps(path: &Path) -> Option<Vec<BTreeMap<String, f64>>> {
    let mut table = csv::Reader::from_path(path).ok()?;
    let names = table.headers().ok()?.clone();
    let numbers = |line: csv::StringRecord| {
        let words = names.iter().zip(line.iter());
        let numbers = words.filter_map(|(name, word)| Some((name.to_string(), word.parse().ok()?)));
        numbers.collect::<BTreeMap<String, f64>>()
    };
    let lines: Option<Vec<_>> = table.records().map(|line| line.ok().map(numbers)).collect();
    let mut lines = lines?;
    lines.retain(|line| line.contains_key("increment") && line.contains_key("load_factor"));
    Some(lines)
}

/// The summary under the keys of a script.
fn values(summary: &Summary) -> BTreeMap<String, f64> {
    let mut values = BTreeMap::from([
        ("increments".into(), summary.increments),
        ("fixed_point_iterations".into(), summary.iterations),
        ("ipopt_iterations".into(), summary.inner_iterations),
        ("converged".into(), f64::from(u8::from(summary.converged))),
    ]);
    values.extend(summary.energy.map(|energy| ("energy".into(), energy)));
    let seconds = summary.cpu_seconds;
    values.extend(seconds.map(|seconds| ("seconds_total".into(), seconds)));
    for (body, reaction) in summary.bodies.iter().zip(&summary.reactions) {
        let components = AXES.iter().zip(reaction);
        values.extend(components.map(|(axis, r)| (format!("reaction_{body}_{axis}"), *r)));
    }
    values
}

/// Load factors of one state, written by two programs, differ by less.
const SAME_TIME: f64 = 1e-12;

/// The states of a series: load factors and files.
struct Listing {
    path: PathBuf,
    states: Vec<(f64, String)>,
}

impl Listing {
    fn read(folder: &Path, summary: &Summary) -> Result<Self, Error> {
        let path = folder.join(format!("{}.pvd", summary.scene));
        let all = text(&path)?;
        let state = |line: &str| {
            let attribute = |name: &str| {
                let (_, rest) = line.split_once(&format!("{name}=\""))?;
                rest.split('"').next()
            };
            let time = attribute("timestep")?.parse().ok()?;
            Some((time, attribute("file")?.to_string()))
        };
        // the other part of a step is that of its obstacles
        let is_of_bodies = |line: &&str| line.contains("<DataSet") && !line.contains("part=\"1\"");
        let lines = all.lines().filter(is_of_bodies);
        let states = lines.filter_map(state).collect();
        Ok(Listing { path, states })
    }
}

/// The last file of the series, which must be the state that the summary tells of.
fn last_state(listing: &Listing, summary: &Summary) -> Result<(PathBuf, Piece), Error> {
    let Listing { path, states } = listing;
    let Some((time, file)) = states.last() else {
        return Err(malformed(
            path,
            "it lists no state: do the run again with files for ParaView, `vtu-every = 1` in a scene file",
        ));
    };
    if (time - summary.load_factor).abs() > SAME_TIME {
        let why = format!(
            "the last state is at the load factor {time}, the result at {}: do the run again, which writes its last state",
            summary.load_factor
        );
        return Err(malformed(path, why));
    }
    let path = path.with_file_name(file);
    let state = state(&path)?;
    Ok((path, state))
}

/// What a file of the series holds.
fn state(path: &Path) -> Result<Piece, Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::Unreadable {
        path: path.into(),
        source,
    })?;
    let all = pieces(&bytes, |_, _| true)
        .map_err(|fault| malformed(path, format!("{}{}", fault.problem, fault.place)))?;
    all.into_iter()
        .next()
        .ok_or_else(|| malformed(path, "it has no data"))
}

/// The fields of the bodies, whose nodes follow each other.
fn bodies(path: &Path, grid: &Piece, names: &[String]) -> Result<Vec<Fields>, Error> {
    let missing = |what: &str| malformed(path, format!("it has no {what}"));
    let places = checked(path, "points", grid.array(Section::Points, ""))?;
    let places = places.ok_or_else(|| missing("points"))?;
    let nodes = places.len() / 3;
    let field = |name: &str, components: usize| match checked(
        path,
        name,
        grid.array(Section::PointData, name),
    )? {
        Some(values) if values.len() != components * nodes => {
            let why = format!("`{name}` has {} values at {nodes} nodes", values.len());
            Err(malformed(path, why))
        }
        found => Ok(found),
    };
    let required = |name, components| {
        let found: Option<&[f64]> = field(name, components)?;
        found.ok_or_else(|| missing(name))
    };
    let (places, displacements) = (in_space(places), in_space(required("displacement", 3)?));
    // scripts write the consistent one
    let pressures = required("contact_pressure_consistent", 1)?;
    let of_nodes = required("body", 1)?;
    let forces = field("contact_force", 3)?.map(in_space);
    let cells = cells(grid, nodes);
    let cells = cells.ok_or_else(|| missing("cells of this library"))?;
    let body = |(k, name): (usize, &String)| {
        let is_own = |&body: &f64| body == k as f64;
        let first = of_nodes.iter().position(is_own);
        let first = first.ok_or_else(|| missing(&format!("nodes of body {name}")))?;
        let count = of_nodes[first..].iter().take_while(|body| is_own(body));
        let own = first..first + count.count();
        let inside = |cell: &&Vec<usize>| cell.iter().all(|node| own.contains(node));
        let moved = |cell: &Vec<usize>| cell.iter().map(|node| node - first).collect();
        let pressures = pressures[own.clone()].iter().copied();
        Ok(Fields {
            name: name.clone(),
            places: Some(places[own.clone()].to_vec()),
            cells: cells.iter().filter(inside).map(moved).collect(),
            displacements: displacements[own.clone()].to_vec(),
            forces: forces.as_ref().map(|all| all[own.clone()].to_vec()),
            pressures: Some(pressures.enumerate().collect()),
        })
    };
    names.iter().enumerate().map(body).collect()
}

/// The values, if all are finite.
fn checked<'a>(
    path: &Path,
    name: &str,
    values: Option<&'a [f64]>,
) -> Result<Option<&'a [f64]>, Error> {
    for (k, &value) in values.unwrap_or_default().iter().enumerate() {
        finite(path, || format!("value {k} of `{name}`"), value)?;
    }
    Ok(values)
}

fn in_space(components: &[f64]) -> Vec<Point> {
    let chunks = components.chunks_exact(3);
    chunks.map(|c| [c[0], c[1], c[2]]).collect()
}

/// The nodes of each cell, if all are simplices of nodes that there are.
fn cells(grid: &Piece, nodes: usize) -> Option<Vec<Vec<usize>>> {
    let array = |name| grid.array(Section::Cells, name);
    let whole = |&value: &f64| (value.fract() == 0.0 && value >= 0.0).then_some(value as usize);
    let (connectivity, types) = (array("connectivity")?, array("types")?);
    let mut cells = Vec::with_capacity(types.len());
    let mut begin = 0;
    for (end, &kind) in array("offsets")?.iter().zip(types) {
        let cell = connectivity.get(begin..whole(end)?)?;
        // VTK's numbers of simplices
        let count = match kind {
            5.0 => 3,
            22.0 => 6,
            10.0 => 4,
            24.0 => 10,
            _ => return None,
        };
        let cell: Option<Vec<usize>> = cell.iter().map(whole).collect();
        let cell = cell.filter(|cell| cell.len() == count && cell.iter().all(|&a| a < nodes))?;
        cells.push(cell);
        begin += count;
    }
    Some(cells)
}

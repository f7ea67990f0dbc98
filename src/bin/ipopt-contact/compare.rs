//! `ipopt-contact compare A B`: the differences between two results.

use std::path::Path;
use std::process::ExitCode;

use ipopt_contact::contact_fem::output::compare::{
    Comparison, Note, Quantity, Row, Tolerances, compare,
};
use ipopt_contact::contact_fem::output::record::print;

use crate::help;

/// What the command line asks for.
#[derive(Debug, PartialEq)]
struct Request {
    folders: [String; 2],
    tolerances: Tolerances,
    /// The quantities that have a tolerance of their own.
    asked: Vec<Quantity>,
}

/// Compares two results and prints the table.
pub fn command(words: &[String]) -> Result<ExitCode, String> {
    run(request(words)?)
}

fn request(arguments: &[String]) -> Result<Request, String> {
    let (mut folders, mut tolerances) = (Vec::new(), Tolerances::default());
    let mut asked = Vec::new();
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        let (name, given) = match word.split_once('=') {
            Some(("--tolerance", value)) => ("--tolerance", Some(value.to_string())),
            _ => (word.as_str(), None),
        };
        match name {
            "--tolerance" => {
                let value = given.or_else(|| words.next().cloned());
                asked.extend(tolerate(&mut tolerances, &value.unwrap_or_default())?);
            }
            _ if name.starts_with('-') => {
                let see = help::see("compare");
                return Err(format!("compare has no option {name}: {see}"));
            }
            _ => folders.push(word.clone()),
        }
    }
    let folders = folders.try_into();
    let folders = folders.map_err(|given: Vec<String>| {
        let (count, see) = (given.len(), help::see("compare"));
        format!("compare needs two folders, and {count} are given: {see}")
    })?;
    Ok(Request {
        folders,
        tolerances,
        asked,
    })
}

/// Takes `1e-8`, of all quantities, or `force=1e-6`, of one, which is returned.
fn tolerate(tolerances: &mut Tolerances, text: &str) -> Result<Option<Quantity>, String> {
    let (name, number) = match text.split_once('=') {
        Some((name, number)) => (Some(name), number),
        None => (None, text),
    };
    let value = number.parse().ok();
    let value = value.filter(|value: &f64| *value >= 0.0 && value.is_finite());
    let value =
        value.ok_or_else(|| format!("--tolerance needs a finite number from 0, not `{number}`"))?;
    let (own, quantity) = match name {
        None => {
            *tolerances = Tolerances::all(value);
            return Ok(None);
        }
        Some("energy") => (&mut tolerances.energy, Quantity::Energy),
        Some("reaction") => (&mut tolerances.reaction, Quantity::Reaction),
        Some("displacement") => (&mut tolerances.displacement, Quantity::Displacement),
        Some("force") => (&mut tolerances.force, Quantity::ContactForce),
        Some("pressure") => (&mut tolerances.pressure, Quantity::Pressure),
        Some(name) => {
            return Err(format!(
                "there is no quantity {name}: there are energy, reaction, displacement, force and pressure"
            ));
        }
    };
    *own = value;
    Ok(Some(quantity))
}

fn run(request: Request) -> Result<ExitCode, String> {
    let [a, b] = request.folders.each_ref().map(Path::new);
    let comparison = compare(a, b).map_err(|why| why.to_string())?;
    let beyond = comparison.beyond(&request.tolerances);
    let mut verdict = verdict(&comparison, &beyond, &request.tolerances);
    let missing = missing(&comparison, &request.asked);
    if !missing.is_empty() {
        let names: Vec<String> = missing.iter().map(ToString::to_string).collect();
        let names = names.join("; ");
        verdict += &format!("\nnot compared, although a tolerance is given: {names}");
    }
    let is_unfinished = |note: &Note| matches!(note, Note::Unfinished { .. });
    let unfinished = comparison.notes.iter().any(is_unfinished);
    if unfinished {
        verdict += "\na result is not complete, or its certificate does not hold: see above";
    }
    print(format!("{comparison}\n\n{verdict}"));
    let within = beyond.is_empty() && missing.is_empty() && !unfinished;
    Ok(ExitCode::from(u8::from(!within)))
}

/// The quantities asked for that the two results do not share.
fn missing(comparison: &Comparison, asked: &[Quantity]) -> Vec<Quantity> {
    let is_compared = |quantity: &Quantity| {
        let mut rows = comparison.rows.iter();
        rows.any(|row| row.quantity == *quantity && row.relative.is_some())
    };
    let missing = asked.iter().filter(|quantity| !is_compared(quantity));
    missing.copied().collect()
}

/// What is beyond its tolerance, and what only one result has.
fn verdict(comparison: &Comparison, beyond: &[&Row], tolerances: &Tolerances) -> String {
    let name = |row: &&Row| match &row.body {
        Some(body) => format!("{} {body}", row.quantity),
        None => row.quantity.to_string(),
    };
    let rows = comparison.rows.iter();
    let alone = rows.filter(|row| row.relative.is_none() && tolerances.of(row.quantity).is_some());
    let alone: Vec<String> = alone.map(|row| name(&row)).collect();
    let verdict = match beyond {
        [] => "all compared are within their tolerances".to_string(),
        _ => {
            let names: Vec<String> = beyond.iter().map(name).collect();
            format!("beyond the tolerance: {}", names.join("; "))
        }
    };
    match alone[..] {
        [] => verdict,
        _ => format!("{verdict}\nin one result only: {}", alone.join("; ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Request, String> {
        let words: Vec<String> = line.split_whitespace().map(String::from).collect();
        request(&words)
    }

    #[test]
    fn tolerances_are_of_all_or_of_one() {
        let all = parsed("a b --tolerance 1e-8").expect("a request");
        assert_eq!(all.tolerances, Tolerances::all(1e-8));
        assert_eq!(all.folders, ["a", "b"]);
        assert_eq!(all.asked, []);
        let one = parsed("--tolerance=1e-8 a --tolerance force=1e-3 b").expect("a request");
        assert_eq!(one.asked, [Quantity::ContactForce]);
        let force = Tolerances {
            force: 1e-3,
            ..Tolerances::all(1e-8)
        };
        assert_eq!(one.tolerances, force);
    }

    #[test]
    fn odd_command_lines_are_refused() {
        for line in [
            "",
            "a",
            "a b c",
            "a b --tolerance",
            "a b --tolerance x",
            "a b --tolerance -1",
            "a b --tolerance NaN",
            "a b --tolerance inf",
            "a b --tolerance force=inf",
            "a b --tolerance mass=1",
            "a b --colour",
        ] {
            assert!(parsed(line).is_err(), "{line}");
        }
    }
}

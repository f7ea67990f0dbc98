//! `ipopt-contact solve DIR`: the matrices of a script, solved by the library.

use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

use ipopt_contact::contact_core::equilibrium::Solution;
use ipopt_contact::contact_core::quadratic::QuadraticProgram;
use ipopt_contact::contact_core::{Automatic, Equilibrium, Outcome};
use ipopt_contact::contact_fem::freefem::{array_text, read_problem};
use ipopt_contact::contact_fem::output::record::{cpu_seconds, print};

use crate::Words;

/// Solves the problem in a folder and writes its result as a script would.
pub fn command(words: &[String]) -> Result<ExitCode, String> {
    let words = Words::parse("solve", words, &["out"], &[])?;
    let folder = Path::new(words.only("one folder of matrices")?);
    let out = Path::new(words.needed("out")?);
    if same(folder, out) {
        return Err(format!(
            "--out is the folder of the matrices, {}, whose files would be overwritten: choose another",
            out.display()
        ));
    }
    let problem = read_problem(folder).map_err(|why| why.to_string())?;
    let bodies = bodies(folder, problem.is_prescribed().len())?;
    let mut solver = Automatic::default();
    print(format!("solver: {}", solver.choice(&problem)));
    let before = cpu_seconds();
    let solution = solver.solve_from(&problem, problem.start());
    let solution = solution.map_err(|why| why.to_string())?;
    let seconds = cpu_seconds().zip(before).map(|(now, before)| now - before);
    let is_solved = solution.outcome == Outcome::Converged;
    print(format!(
        "{}, energy {:.9e}",
        solution.outcome, solution.energy
    ));
    record(&problem, &solution, &bodies, seconds, (folder, out))?;
    Ok(ExitCode::from(u8::from(!is_solved)))
}

fn same(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| path.canonicalize().ok();
    real(a).is_some() && real(a) == real(b)
}

/// A body's name, the components of a displacement, and how many unknowns it has.
struct Part {
    name: String,
    components: usize,
    count: usize,
}

/// The bodies in the order of their unknowns; without `bodies.txt` there are none.
fn bodies(folder: &Path, unknowns: usize) -> Result<Vec<Part>, String> {
    let path = folder.join("bodies.txt");
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(&path);
    let text = text.map_err(|why| format!("cannot read {}: {why}", path.display()))?;
    let wrong = |line: &str| {
        let path = path.display();
        format!("{path}: `{line}` is not a name, 2 or 3 components, and a number of unknowns")
    };
    let mut bodies = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [name, components, count] = words[..] else {
            return Err(wrong(line));
        };
        let components = components.parse().ok().filter(|c| [2, 3].contains(c));
        let count = count.parse().ok();
        let (Some(components), Some(count)) = (components, count) else {
            return Err(wrong(line));
        };
        let fits = |count: usize| count > 0 && count % components == 0;
        if !fits(count) || name.contains(['/', '\\']) {
            return Err(wrong(line));
        }
        let name = name.to_string();
        bodies.push(Part {
            name,
            components,
            count,
        });
    }
    let sum: Option<usize> = bodies
        .iter()
        .try_fold(0usize, |sum, body| sum.checked_add(body.count));
    match sum {
        Some(sum) if sum == unknowns => Ok(bodies),
        _ => Err(format!(
            "{}: the bodies do not have the {unknowns} unknowns of K: let the script write them in the order of K",
            path.display()
        )),
    }
}

fn record(
    problem: &QuadraticProgram,
    solution: &Solution,
    bodies: &[Part],
    seconds: Option<f64>,
    (folder, out): (&Path, &Path),
) -> Result<(), String> {
    let v = problem.unknowns(&solution.state.u);
    let contact = problem.contact_forces(&solution.gaps, &solution.lambda);
    let left = problem.reactions(&v, &contact);
    let left = left.map_err(|why| why.to_string())?;
    let held = problem.is_prescribed();
    let cost = solution.cost();
    let mut result = String::new();
    let mut value = |key: &str, value: f64| {
        // writing to a string cannot fail
        let _ = writeln!(result, "{key} {value:e}");
    };
    value("energy", solution.energy);
    let mut first = 0;
    for Part {
        name,
        components,
        count,
    } in bodies
    {
        let of_body = first..first + count;
        first += count;
        for (c, axis) in ["x", "y", "z"].into_iter().enumerate().take(*components) {
            let own = of_body.clone().skip(c).step_by(*components);
            let reaction = own.filter(|&i| held[i]).map(|i| left[i]).sum();
            value(&format!("reaction_{name}_{axis}"), reaction);
        }
        let lines = |values: &[f64]| -> String {
            let line = |node: &[f64]| {
                let words: Vec<String> = node.iter().map(|x| format!("{x:e}")).collect();
                words.join(" ") + "\n"
            };
            values[of_body.clone()]
                .chunks(*components)
                .map(line)
                .collect()
        };
        write(out, &format!("displacement_{name}.txt"), &lines(&v))?;
        write(out, &format!("force_{name}.txt"), &lines(&contact))?;
        let nodes = format!("nodes_{name}.txt");
        if let Ok(text) = std::fs::read_to_string(folder.join(&nodes)) {
            write(out, &nodes, &text)?;
        }
    }
    value("increments", 1.0);
    value("fixed_point_iterations", cost.outer_iterations as f64);
    value("ipopt_iterations", cost.inner_iterations as f64);
    if let Some(seconds) = seconds {
        value("seconds_total", seconds);
    }
    value(
        "converged",
        f64::from(u8::from(solution.outcome == Outcome::Converged)),
    );
    let mut lambda = vec![0.0; problem.rows()];
    for (key, value) in solution.gaps.keys().iter().zip(&solution.lambda) {
        lambda[key.node as usize] = *value;
    }
    write(out, "u.txt", &array_text(&v))?;
    write(out, "lambda.txt", &array_text(&lambda))?;
    let path = write(out, "result.txt", &result)?;
    print(path);
    Ok(())
}

/// Writes a file of a folder, which is made, and returns its path.
pub fn write(folder: &Path, name: &str, text: &str) -> Result<String, String> {
    let path = folder.join(name);
    let written = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, text));
    written.map_err(|why| format!("cannot write {}: {why}", path.display()))?;
    Ok(path.display().to_string())
}

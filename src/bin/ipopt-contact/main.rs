//! The program `ipopt-contact`: scenes and problems from files, and results compared.
#![forbid(unsafe_code)]

mod accuracy;
mod causes;
mod compare;
mod fields;
mod run;
mod solve;

use std::process::ExitCode;

use ipopt_contact::contact_fem::output::record::{exit, print};

const USAGE: &str = "\
Contact problems from files, without a line of Rust (docs/scene_files.md, docs/freefem.md)

usage:
  ipopt-contact run SCENE.toml --out DIR [--solver NAME] [--literal] [--increments N] [--start DIR]
                    [--resume]
  ipopt-contact run SCENE.toml --out DIR --accuracy 1% [--seconds S] [--path] [--solver NAME] [--increments N]
  ipopt-contact run SCENE.toml --check [--solver NAME]
      Solves the scene in a file and records the run in a folder. It starts from rest, or from the result in a folder.
      --accuracy refines the meshes until the estimated error is at most this share of the energy norm, or until another mesh would take
      more than S seconds in all (600). All increments are walked on the first mesh; finer ones begin at its end, unless --path is given. DIR has a folder for each mesh, and the error against the time (docs/error.md).
      --resume keeps the solver's answers in DIR/run.resume, and goes on where an earlier run with it ended.
      --check prints what is wrong with the scene, or may not be meant, and solves nothing.
      --literal does what the paper's script does: its points, stopping rule and settings of Ipopt, and nothing else.
  ipopt-contact solve DIR --out DIR
      Solves the matrices that a script of FreeFEM has left in a folder.
  ipopt-contact compare A B [--tolerance [QUANTITY=]VALUE]...
      Compares two results: folders of recorded runs, of `solve`, or of scripts of FreeFEM. A tolerance is the largest
      relative difference, 1e-6 by default, of all quantities or of one: energy, reaction, displacement, force or
      pressure. Iterations and seconds are shown only.
  ipopt-contact causes SCENE.toml RESULT --out DIR
      Solves the scene as it is and with one thing otherwise at a time (points, passes, geometry, tolerance, increments,
      straight sides), compares each with a result, and tells which change brings them together.
  ipopt-contact fields RESULT --nodes DIR --out DIR
      Writes the displacements and contact forces of a result for `file >> u[]` in FreeFEM, in the order of the files
      `nodes_BODY.txt` of a folder.
  ipopt-contact --version
      Prints the version.

exit codes: 0 done, of compare all within the tolerances; 1 not converged, of compare some beyond or a result not complete, of --check warnings; 2 error;
3 of run a certificate that does not hold; 130 stopped";

fn main() -> ExitCode {
    let arguments = std::env::args_os().skip(1);
    let arguments: Result<Vec<String>, _> = arguments.map(|word| word.into_string()).collect();
    let arguments = match arguments {
        Ok(arguments) => arguments,
        Err(word) => {
            return exit::<ExitCode>(Err(format!("{word:?} is not UTF-8: rename the file")));
        }
    };
    let asks = |word: &String| word == "--help" || word == "-h";
    if arguments.iter().any(asks) {
        print(USAGE);
        return ExitCode::SUCCESS;
    }
    if matches!(
        arguments.first().map(String::as_str),
        Some("--version" | "-V")
    ) {
        print(concat!("ipopt-contact ", env!("CARGO_PKG_VERSION")));
        return ExitCode::SUCCESS;
    }
    let Some((command, words)) = arguments.split_first() else {
        return exit::<ExitCode>(Err(format!("a command is missing\n\n{USAGE}")));
    };
    exit(match command.as_str() {
        "causes" => causes::command(words),
        "compare" => compare::command(words),
        "run" => run::command(words),
        "solve" => solve::command(words),
        "fields" => fields::command(words),
        _ => Err(format!("there is no command {command}\n\n{USAGE}")),
    })
}

/// The words of a command: those without a name, and the values of options, each of which is given once at most.
struct Words {
    plain: Vec<String>,
    options: Vec<(String, String)>,
}

impl Words {
    /// `known` have a value each, `flags` have none.
    fn parse(words: &[String], known: &[&str], flags: &[&str]) -> Result<Self, String> {
        let (mut plain, mut options) = (Vec::new(), Vec::<(String, String)>::new());
        let mut words = words.iter();
        while let Some(word) = words.next() {
            let Some(option) = word.strip_prefix("--") else {
                plain.push(word.clone());
                continue;
            };
            let (name, given) = match option.split_once('=') {
                Some((name, value)) => (name, Some(value.to_string())),
                None => (option, None),
            };
            let is_flag = flags.contains(&name);
            if !known.contains(&name) && !is_flag {
                return Err(format!("there is no option --{name}\n\n{USAGE}"));
            }
            if options.iter().any(|(other, _)| other == name) {
                return Err(format!("--{name} is given twice"));
            }
            if let (true, Some(value)) = (is_flag, &given) {
                return Err(format!("--{name} has no value, and `{value}` is given"));
            }
            let value = match is_flag {
                true => Some(String::new()),
                false => given.or_else(|| words.next().cloned()),
            };
            let value = value.ok_or_else(|| format!("--{name} needs a value"))?;
            options.push((name.to_string(), value));
        }
        Ok(Words { plain, options })
    }

    /// The one word without a name.
    fn only(&self, what: &str) -> Result<&str, String> {
        match &self.plain[..] {
            [word] => Ok(word),
            _ => Err(format!("give {what}\n\n{USAGE}")),
        }
    }

    fn option(&self, name: &str) -> Option<&str> {
        let mut options = self.options.iter();
        let found = options.find(|(other, _)| other == name);
        found.map(|(_, value)| value.as_str())
    }

    fn needed(&self, name: &str) -> Result<&str, String> {
        let value = self.option(name);
        value.ok_or_else(|| format!("--{name} is missing\n\n{USAGE}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Words, String> {
        let words: Vec<String> = line.split_whitespace().map(String::from).collect();
        Words::parse(&words, &["out", "start"], &["literal"])
    }

    #[test]
    fn options_have_a_value_each() {
        let words = parsed("scene.toml --out a --start=b").expect("words");
        assert_eq!(words.only("a scene"), Ok("scene.toml"));
        assert_eq!(
            (words.option("out"), words.option("start")),
            (Some("a"), Some("b"))
        );
        assert!(words.needed("increments").is_err());
        let words = parsed("--literal scene.toml").expect("words");
        assert_eq!(words.only("a scene"), Ok("scene.toml"));
        assert_eq!(
            (words.option("literal"), words.option("out")),
            (Some(""), None)
        );
        for line in [
            "--out",
            "--out a --out b",
            "--colour red",
            "--literal=no",
            "--literal --literal",
        ] {
            assert!(parsed(line).is_err(), "{line}");
        }
        assert!(parsed("a b").expect("words").only("a scene").is_err());
    }
}

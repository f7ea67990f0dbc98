//! The program `ipopt-contact`: scenes and problems from files, and results compared.
#![forbid(unsafe_code)]

mod accuracy;
mod causes;
mod compare;
mod fields;
mod help;
mod mesh;
mod run;
mod solve;

use std::process::ExitCode;

use ipopt_contact::contact_fem::output::record::{exit, print};

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
        print(help::of(arguments.first().map(String::as_str)));
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
        let why = format!("a command is missing: take {}", help::commands());
        return exit::<ExitCode>(Err(why));
    };
    exit(match command.as_str() {
        "causes" => causes::command(words),
        "compare" => compare::command(words),
        "run" => run::command(words),
        "solve" => solve::command(words),
        "fields" => fields::command(words),
        "mesh" => mesh::command(words),
        _ => Err(format!(
            "there is no command {command}: take {}",
            help::commands()
        )),
    })
}

/// The words of a command: those without a name, and the values of options, each of which is given once at most.
struct Words {
    command: &'static str,
    plain: Vec<String>,
    options: Vec<(String, String)>,
}

impl Words {
    /// `known` have a value each, `flags` have none.
    fn parse(
        command: &'static str,
        words: &[String],
        known: &[&str],
        flags: &[&str],
    ) -> Result<Self, String> {
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
                let see = help::see(command);
                return Err(format!("{command} has no option --{name}: {see}"));
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
        Ok(Words {
            command,
            plain,
            options,
        })
    }

    /// The one word without a name.
    fn only(&self, what: &str) -> Result<&str, String> {
        match &self.plain[..] {
            [word] => Ok(word),
            given => {
                let (command, count, see) = (self.command, given.len(), help::see(self.command));
                Err(format!(
                    "{command} needs {what}, and {count} are given: {see}"
                ))
            }
        }
    }

    fn option(&self, name: &str) -> Option<&str> {
        let mut options = self.options.iter();
        let found = options.find(|(other, _)| other == name);
        found.map(|(_, value)| value.as_str())
    }

    fn needed(&self, name: &str) -> Result<&str, String> {
        let value = self.option(name);
        value.ok_or_else(|| format!("--{name} is missing: {}", help::see(self.command)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Words, String> {
        let words: Vec<String> = line.split_whitespace().map(String::from).collect();
        Words::parse("run", &words, &["out", "start"], &["literal"])
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

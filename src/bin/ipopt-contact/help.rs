//! What the program can be asked for: of a command by itself, or of all.

/// A command and its help.
const COMMANDS: [(&str, &str); 6] = [
    (
        "run",
        "  \
  ipopt-contact run SCENE.toml --out DIR [--solver NAME] [--literal] [--increments N] [--start DIR] [--resume]
                    [--verbose]
  ipopt-contact run SCENE.toml --out DIR --accuracy 1% [--seconds S] [--path] [--solver NAME] [--increments N]
  ipopt-contact run SCENE.toml --check [--solver NAME]
      Solves the scene in a file and records the run in a folder. It starts from rest, or from the result in a folder.
      --accuracy refines the meshes until the estimated error is at most this share of the energy norm, or until another
      mesh would take more than S seconds in all (600). All increments are walked on the first mesh; finer ones begin at
      its end, unless --path is given. DIR has a folder for each mesh, and the error against the time (docs/error.md).
      --resume keeps the solver's answers in DIR/run.resume, and goes on where an earlier run with it ended.
      --verbose prints at the end all conditions of the certificate, what was left out, and what the time was spent on.
      --check prints what is wrong with the scene, or may not be meant, and solves nothing.
      --literal does what the paper's script does: its points, stopping rule and settings of Ipopt, and nothing else.
      --solver takes automatic, ipopt, newton, condensed or literal.",
    ),
    (
        "solve",
        "  \
  ipopt-contact solve DIR --out DIR
      Solves the matrices that a script of FreeFEM has left in a folder.",
    ),
    (
        "compare",
        "  \
  ipopt-contact compare A B [--tolerance [QUANTITY=]VALUE]...
      Compares two results: folders of recorded runs, of `solve`, or of scripts of FreeFEM. A tolerance is the largest
      relative difference, 1e-6 by default, of all quantities or of one: energy, reaction, displacement, force or
      pressure. Iterations and seconds are shown only.",
    ),
    (
        "causes",
        "  \
  ipopt-contact causes SCENE.toml RESULT --out DIR
      Solves the scene as it is and with one thing otherwise at a time (points, passes, geometry, tolerance, increments,
      straight sides), compares each with a result, and tells which change brings them together.",
    ),
    (
        "fields",
        "  \
  ipopt-contact fields RESULT --nodes DIR --out DIR
      Writes the displacements and contact forces of a result for `file >> u[]` in FreeFEM, in the order of the files
      `nodes_BODY.txt` of a folder.",
    ),
    (
        "mesh",
        "  \
  ipopt-contact mesh FILE [--to FILE]
      Tells what a mesh file has: bodies, sizes, the worst cell, boundaries with their names, and the lines that a scene
      begins with. --to writes its bodies for FreeFEM, .msh in the plane, or for Medit, .mesh in space.",
    ),
];

const ABOUT: &str =
    "Contact problems from files, without a line of Rust (docs/scene_files.md, docs/freefem.md)";

const VERSION: &str = "  \
  ipopt-contact --version
      Prints the version.";

const CODES: &str = "\
exit codes: 0 done, of compare all within the tolerances; 1 not converged, of compare some beyond or a result not
complete, of --check warnings; 2 error; 3 of run a certificate that does not hold; 130 stopped";

/// The help of a command, or of all if there is no such.
pub fn of(command: Option<&str>) -> String {
    let own = COMMANDS.iter().find(|(name, _)| command == Some(name));
    match own {
        Some((_, text)) => format!("usage:\n{text}\n\n{CODES}"),
        None => {
            let all = COMMANDS.map(|(_, text)| text).join("\n");
            format!("{ABOUT}\n\nusage:\n{all}\n{VERSION}\n\n{CODES}")
        }
    }
}

/// The names of all commands, and what tells more of them.
pub fn commands() -> String {
    let [others @ .., last] = COMMANDS.map(|(name, _)| name);
    let others = others.join(", ");
    format!("{others} or {last}; `ipopt-contact --help` tells more")
}

/// What tells more of a command.
pub fn see(command: &str) -> String {
    format!("see `ipopt-contact {command} --help`")
}

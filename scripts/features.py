#!/usr/bin/env python3
"""Measures what cargo features cost to compile: processor seconds and crates of a clean release build.

scripts/features.py [--before CHECKOUT] [NAME ...] builds the cases with these names, or all, each in an empty folder, and puts each result
into the table of docs/needs.md once it is known. Processor seconds are those of cargo and all it starts. With --before, another checkout
is built, and what it took goes into the columns "before".
"""

import os
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "needs.md"
BEGIN, END = "<!-- features -->", "<!-- end of features -->"

PLANE = """
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::{Body, Error, LinearElastic, Scene, Simulation};

fn main() -> Result<(), Error> {
    let block = |low: f64| -> Result<Body<2>, Error> {
        let mesh = rectangle(&linspace(0.0, 1.0, 8), &linspace(low, low + 1.0, 8), Diagonals::Rising)?;
        Ok(Body::new(mesh, LinearElastic::new(1000.0, 0.3)?))
    };
    let (mut lower, mut upper) = (block(0.0)?, block(1.0)?);
    lower.prescribe("bottom", [Some(0.0); 2])?;
    upper.prescribe("top", [Some(0.0), Some(-0.01)])?;
    let mut scene = Scene::new();
    let [lower, upper] = [scene.add("lower", lower), scene.add("upper", upper)];
    scene.contact(lower.on("top"), upper.on("bottom"))?;
    let history = Simulation::with_increments(1).run(&mut scene.problem()?)?;
    println!("{:?}", history.last().map(|step| step.energy));
    Ok(())
}
"""

# name, what it gives, goal in seconds, arguments of cargo build, or a program
CASES = [
    ("default", "everything below: `bindgen` and `record`", None, ["-p", "ipopt-contact"]),
    ("none", "`--no-default-features`: scenes and solvers, no files", None, ["-p", "ipopt-contact", "--no-default-features"]),
    ("record", "files, progress, Ctrl-C; kept bindings", None, ["-p", "ipopt-contact", "--no-default-features", "--features", "record"]),
    ("all", "`--all-features`", None, ["-p", "ipopt-contact", "--all-features"]),
    ("fem", "`contact-fem` without features: meshes, scenes, the library's own solvers", None, ["-p", "contact-fem"]),
    ("vtk", "`.vtu` files alone", None, ["-p", "contact-fem", "--features", "vtk"]),
    ("csv", "tables alone", None, ["-p", "contact-fem", "--features", "csv"]),
    ("plot", "pictures alone", None, ["-p", "contact-fem", "--features", "plot"]),
    ("ipopt", "`contact-core` with `ipopt`: the safe driver, kept bindings", 15, ["-p", "contact-core", "--no-default-features", "--features", "ipopt"]),
    ("ipopt-bindgen", "the same with `bindgen`: bindings from the headers found", None, ["-p", "contact-core", "--no-default-features", "--features", "ipopt,bindgen"]),
    ("plane", "a program with a linear 2D contact scene, by `contact-fem` without features", 100, PLANE),
]


def children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def built(case, checkout, folder):
    """Processor seconds and the number of crates."""
    arguments, where = case[3], checkout
    if isinstance(arguments, str):
        where = Path(folder) / "program"
        (where / "src").mkdir(parents=True)
        (where / "src" / "main.rs").write_text(arguments)
        (where / "Cargo.toml").write_text(
            "[package]\nname = \"program\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\n"
            f"contact-fem = {{ path = \"{checkout}/contact-fem\" }}\n\n[workspace]\n"
        )
        (where / "Cargo.lock").write_text((checkout / "Cargo.lock").read_text())
        arguments = []
    # what profiles say elsewhere does not count
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("CARGO_PROFILE", "CARGO_INCREMENTAL", "RUSTFLAGS"))}
    target = Path(folder) / "target"
    before = children()
    command = ["cargo", "build", "--release", "--color=never", *arguments]
    run = subprocess.run(command, cwd=where, env={**kept, "CARGO_TARGET_DIR": str(target)}, capture_output=True, text=True)
    seconds = children() - before
    if run.returncode != 0:
        sys.exit(f"{case[0]}:\n{run.stderr}")
    crates = len(re.findall(r"^ *Compiling ", run.stderr, re.M))
    if isinstance(case[3], str):
        subprocess.run([target / "release" / "program"], check=True, stdout=subprocess.DEVNULL)
    return seconds, crates


def main():
    wanted = sys.argv[1:]
    is_before = wanted[:1] == ["--before"]
    checkout = Path(wanted[1]).resolve() if is_before else ROOT
    wanted = wanted[2:] if is_before else wanted
    unknown = set(wanted) - {case[0] for case in CASES}
    if unknown:
        sys.exit(f"no case {', '.join(sorted(unknown))}; there are {', '.join(case[0] for case in CASES)}")
    for case in CASES:
        if wanted and case[0] not in wanted:
            continue
        with tempfile.TemporaryDirectory() as folder:
            seconds, crates = built(case, checkout, folder)
        print(f"{case[0]}: {seconds:.0f} s, {crates} crates", flush=True)
        note(case, [f"{seconds:.0f}", f"{crates}"], is_before)


def note(case, measured, is_before):
    """Puts what was measured of a case into the table."""
    page = PAGE.read_text()
    if BEGIN not in page or END not in page:
        sys.exit(f"{PAGE} has no place for the table: {BEGIN} and {END}")
    head, rest = page.split(BEGIN)
    table, tail = rest.split(END)
    known = {}
    for line in table.splitlines()[3:]:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        known[cells[0]] = cells[2:4] + cells[5:7]
    cells = known.setdefault(case[0], [""] * 4)
    known[case[0]] = cells[:2] + measured if is_before else measured + cells[2:]
    lines = []
    for name, what, goal, _ in CASES:
        if name in known:
            now, then = known[name][:2], known[name][2:]
            lines.append("| " + " | ".join([name, what, *now, "" if goal is None else f"{goal}", *then]) + " |")
    heading = "| case | what | s | crates | goal s | before s | crates |\n|---|---|---:|---:|---:|---:|---:|"
    PAGE.write_text("\n".join([head + BEGIN, heading, *lines, END + tail]))


main()

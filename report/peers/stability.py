#!/usr/bin/python3
"""Solves the scenes at the limits by this library, GetFEM and CalculiX, each run in a process of its own, one at a time.

    report/peers/stability.py --out out/stability [--filter NAME] [--programs GetFEM,CalculiX] [--extremes target/release/extremes]

The cases are in OUT/cases, as `extremes --export OUT/cases` writes them. One file a run goes to OUT/runs; a run whose file is there is not
computed again. OUT/stability.json has all runs.
"""

import argparse
import hashlib
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile

os.environ["OMP_NUM_THREADS"] = "1"
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import calculix_cases
import getfem_cases
import processes
from cases import LIMIT, Case, result


class Ours:
    """This library, which has the cases itself."""

    NAME = "ipopt-contact"
    SETTINGS = {"default": None}

    def __init__(self, extremes):
        self.extremes = extremes.resolve()

    def version(self):
        manifest = pathlib.Path(__file__).parents[2] / "Cargo.toml"
        lines = manifest.read_text().splitlines()
        return "ipopt-contact " + next(line.split('"')[1] for line in lines if line.startswith("version"))

    def solve(self, case, setting, folder):
        try:
            run = subprocess.run([self.extremes, "--only", case.name], capture_output=True, text=True, cwd=folder, timeout=LIMIT)
        except subprocess.TimeoutExpired:
            return result("killed", f"not done after {LIMIT} s", None)
        try:
            entry = json.loads(run.stdout)
        except json.JSONDecodeError:
            return result("crashed", f"exit code {run.returncode}: {run.stderr.strip()}", None)
        share = 1.0 if entry["outcome"] == "complete" else None
        return result(entry["outcome"], entry["reason"], share, entry.get("reactions") or None, certificate=entry["certificate"])


def in_a_folder(program, case, setting):
    """How a run went, in a process and a folder of its own, with its processor time (s)."""

    def call():
        with tempfile.TemporaryDirectory(prefix="stability-") as folder:
            try:
                return program.solve(case, setting, pathlib.Path(folder))
            except Exception as error:  # a peer that stops is a result
                return result("crashed", f"{type(error).__name__}: {error}", 0.0)

    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    # a program that runs in a process below this one is given up there, first
    found, why = processes.in_a_process(call, LIMIT + 3 if program.NAME != getfem_cases.NAME else LIMIT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if found is None:
        found = result("killed", f"not done after {LIMIT} s", None) if why == "late" else result("crashed", why, None)
    return found, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def identity(*parts):
    """The name of a run's file: another case, version, setting or binary of this library has another one."""
    return hashlib.sha256(b"\0".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()[:16]


def rounded(record):
    """A record with as many digits as matter."""
    reactions = record["reactions"] and [[float(f"{force:.9g}") for force in row] for row in record["reactions"]]
    return {**record, "reactions": reactions, "seconds": round(record["seconds"], 2)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/stability"))
    parser.add_argument("--filter", default="", help="only cases whose name contains this")
    parser.add_argument("--programs", default="", help="names of programs, with commas between them, in place of all")
    parser.add_argument("--extremes", type=pathlib.Path, default=pathlib.Path("target/release/extremes"))
    arguments = parser.parse_args()
    names = [name for name in arguments.programs.split(",") if name]
    programs = [Ours(arguments.extremes), getfem_cases, calculix_cases]
    programs = [program for program in programs if not names or program.NAME in names]
    versions = {program.NAME: program.version() for program in programs}
    # what a run is done by: the version, and of this library the binary
    by = {program.NAME: versions[program.NAME].encode() for program in programs}
    if Ours.NAME in by:
        by[Ours.NAME] += arguments.extremes.read_bytes()
    records = []
    runs = arguments.out / "runs"
    runs.mkdir(parents=True, exist_ok=True)
    for path in sorted((arguments.out / "cases").glob("*.json")):
        case = Case(path)
        if arguments.filter not in case.name:
            continue
        for program in programs:
            for setting in program.SETTINGS:
                kept = runs / f"{identity(path.read_bytes(), program.NAME.encode(), by[program.NAME], setting.encode())}.json"
                applies = getattr(program, "applies", lambda *_: True)
                if not applies(case, setting):
                    continue
                if kept.exists():
                    records.append(json.loads(kept.read_text()))
                    continue
                found, seconds = in_a_folder(program, case, setting)
                record = {
                    "case": case.name, "program": program.NAME, "version": versions[program.NAME], "setting": setting,
                    "certificate": None, **found, "seconds": seconds,
                }
                part = kept.with_suffix(".part")
                part.write_text(json.dumps(record))
                part.rename(kept)
                records.append(record)
                print(f"{case.name}, {program.NAME}, {setting}: {found['outcome']}, {seconds:.1f} s. {found['reason']}", flush=True)
    lines = ",\n".join(json.dumps(rounded(record)) for record in records)
    (arguments.out / "stability.json").write_text(f"[\n{lines}\n]\n")


if __name__ == "__main__":
    sys.exit(main())

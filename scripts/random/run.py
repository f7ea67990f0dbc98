#!/usr/bin/env python3
"""Writes random scenes, runs them, and tells for each kind how many come to their end and are certified.

    scripts/random/run.py PROGRAM [--count 220] [--seed 1] [--kinds cylinders,neutral] [--out out/random]

PROGRAM runs scene files. Runs that are not certified are listed with the conditions that do not hold, or with what the program said. The scenes are
sound, so that each of these is a false alarm, a mesh that is too coarse, or a state that is wrong: none of them is counted as right. The exit code
is 1 if the program panics or is stopped after a minute.
"""
import argparse
import collections
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys

CONDITION = re.compile(r"^\s+(\w+)\s+(\S+) of\s+(\S+)\s+<- too large", re.MULTILINE)
LONGEST = 60


def run(program, scene):
    """The exit code of a run, None where it was stopped, and what it said."""
    command = [program, "run", str(scene), "--out", str(scene.with_suffix(""))]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        return None, ""
    text = done.stdout + done.stderr
    scene.with_suffix(".txt").write_text(text)
    return done.returncode, text


def verdict(code, text):
    """What came of a run, and what there is to say of it."""
    last = text.strip().splitlines()[-1] if text.strip() else ""
    broken = ", ".join(f"{name} {value} of {limit}" for name, value, limit in CONDITION.findall(text))
    if code is None:
        return "stopped", f"after {LONGEST} s"
    if code not in (0, 1, 2, 3):
        return "panicked", last
    if code == 0:
        return "certified", ""
    if code == 3:
        return "complete", broken
    reason = [line for line in text.splitlines() if "not converged" in line or line.startswith("error")]
    return ("refused" if code == 2 else "not complete"), (reason or [last])[0][:200]


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("program")
    options.add_argument("--count", default="220")
    options.add_argument("--seed", default="1")
    options.add_argument("--kinds", default="")
    options.add_argument("--out", default="out/random")
    given = options.parse_args()
    writer = pathlib.Path(__file__).with_name("scenes.py")
    chosen = ["--seed", given.seed, "--count", given.count, "--kinds", given.kinds, "--out", given.out]
    folder = pathlib.Path(given.out)
    for old in folder.glob("*.toml"):
        old.unlink()
    subprocess.run([sys.executable, writer, *chosen], check=True)
    scenes = sorted(folder.glob("*.toml"))
    counts = collections.defaultdict(collections.Counter)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        runs = pool.map(lambda scene: run(given.program, scene), scenes)
        for scene, (code, text) in zip(scenes, runs):
            outcome, reason = verdict(code, text)
            kind = scene.name.split("-")[0]
            counts[kind][outcome] += 1
            if outcome != "certified":
                print(f"{scene}: {outcome} {reason}", flush=True)
    outcomes = ["certified", "complete", "not complete", "refused", "stopped", "panicked"]
    print(f"\n| kind | runs | {' | '.join(outcomes)} |")
    print(f"|---|---:|{'---:|' * len(outcomes)}")
    total = collections.Counter()
    for kind, own in sorted(counts.items()) + [("all", total)]:
        if own is not total:
            total += own
        cells = [str(own[outcome]) for outcome in outcomes]
        print(f"| {kind} | {sum(own.values())} | {' | '.join(cells)} |")
    sys.exit(1 if total["stopped"] + total["panicked"] else 0)


if __name__ == "__main__":
    main()

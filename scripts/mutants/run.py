#!/usr/bin/env python3
"""Plants the faults of faults.txt one at a time in a copy of the workspace, and tells which of them the tests notice.

    make mutants                               all faults; goes on where it was interrupted
    scripts/mutants/run.py --check             only whether every fault can be planted
    scripts/mutants/run.py certificate rows    those whose area or name has one of these words
    scripts/mutants/run.py --survivors         again those that nothing noticed
    scripts/mutants/run.py --units             without the tests that take longer to build
    scripts/mutants/run.py --keep-caught       what was caught in earlier sources counts as caught
    scripts/mutants/run.py --table             the table of what is known, without planting anything
    scripts/mutants/run.py --beside b method   in a second copy, beside another run

The copy, its build and results.jsonl are in `mutants` in the target folder. A result belongs to the fault and to the
sources that it was planted in. Needs Python 3.9 or later, and nothing but its standard library.
"""

import argparse
import hashlib
import json
import os
import re
import resource
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target")
ASIDE = (TARGET if TARGET.is_absolute() else ROOT / TARGET) / "mutants"
RESULTS = ASIDE / "results.jsonl"
# Runs side by side have names, and each a copy and a build of its own.
COPY, BUILD = ASIDE / "source", ASIDE / "build"

# The share of the faults of each area that tests must notice.
BOUND = 0.95
# Tests may take so many times as long as without a fault, and these seconds more; what takes longer hangs.
SLOWER, GRACE = 5.0, 60.0
# A build that takes longer than this does not end (s).
BUILD_LIMIT = 1800.0
# No test may take more memory than this (bytes).
MEMORY = 12 << 30
# What no test depends on.
WITHOUT_CODE = ("docs/", "scripts/", ".ci/", "freefem/", "report/", "benches/")


def fail(message):
    sys.exit(f"error: {message}")


class Fault:
    """One entry of faults.txt."""

    def __init__(self, name, line):
        self.name, self.line = name, line
        self.area = self.file = self.equivalent = None
        self.old, self.new, self.tests = [], [], []

    def check(self):
        missing = [key for key in ("area", "file", "old") if not getattr(self, key)]
        if missing:
            fail(f"faults.txt:{self.line}: `{self.name}` has no {', '.join(missing)}")

    def pattern(self):
        """Matches the original lines with any indentation."""
        return re.compile(r"\s*\n\s*".join(re.escape(line) for line in self.old))

    def planted(self, text):
        found = list(self.pattern().finditer(text))
        if len(found) != 1:
            fail(
                f"faults.txt:{self.line}: `{self.name}` is out of date: "
                f"{self.file} has its original {len(found)} times, not once"
            )
        (match,) = found
        return text[: match.start()] + "\n".join(self.new) + text[match.end() :]

    def key(self, plan):
        parts = [self.file, *self.old, "->", *self.new, *map(repr, plan)]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


def read_faults():
    """The faults, and the tests of each crate as {crate: {"unit": [...], "wider": [...]}}."""
    faults, tests = [], {}
    for number, line in enumerate((HERE / "faults.txt").read_text().splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        if line.startswith("== "):
            faults.append(Fault(line[3:].strip(), number))
        elif line[:2] in ("- ", "+ ") or line in ("-", "+"):
            lines = faults[-1].old if line[0] == "-" else faults[-1].new
            lines.append(line[2:].strip())
        elif match := re.fullmatch(r"(unit|wider) ([\w-]+): (.*)", line):
            kind, crate, command = match.groups()
            tests.setdefault(crate, {"unit": [], "wider": []})[kind].append(command.strip())
        elif match := re.fullmatch(r"(area|file|test|equivalent): (.*)", line):
            key, value = match.group(1), match.group(2).strip()
            if key == "test":
                faults[-1].tests.append(value)
            else:
                setattr(faults[-1], key, value)
        else:
            fail(f"faults.txt:{number}: not understood: {line}")
    for fault in faults:
        fault.check()
    names = [fault.name for fault in faults]
    for name in names:
        if names.count(name) > 1:
            fail(f"faults.txt: `{name}` is there twice")
    return faults, tests


def plan(fault, tests):
    """The commands in their order, as (kind, arguments of `cargo test`)."""
    crate = fault.file.split("/")[0]
    if crate not in tests:
        fail(f"faults.txt:{fault.line}: there are no tests of {crate}")
    steps = [("wider" if " --test " in f" {t}" else "unit", t) for t in fault.tests]
    parts = fault.file.removesuffix(".rs").removesuffix("/mod").split("/")[2:]
    places = {"{file}": "::".join(parts), "{module}": parts[0]}
    for kind in ("unit", "wider"):
        for command in tests[crate][kind]:
            for place, name in places.items():
                command = command.replace(place, name)
            if (kind, command) not in steps:
                steps.append((kind, command))
    return steps


def copy_sources():
    """Brings the copy up to date, without touching what is the same, and returns a hash of the sources."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, check=True, capture_output=True,
    )
    names = sorted(set(filter(None, listed.stdout.decode().split("\0"))))
    names = [name for name in names if (ROOT / name).is_file()]
    digest = hashlib.sha256()
    for name in names:
        data = (ROOT / name).read_bytes()
        if not name.startswith(WITHOUT_CODE) and not name.endswith(".md"):
            digest.update(f"{name} {len(data)}\n".encode() + data)
        place = COPY / name
        if place.is_file() and place.read_bytes() == data:
            continue
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(data)
    # what has gone from the checkout
    known = set(names)
    for place in COPY.rglob("*"):
        if place.is_file() and str(place.relative_to(COPY)) not in known:
            place.unlink()
    return digest.hexdigest()[:16]


SWITCH = """
/// The number of the fault that is to act; 0 for none.
pub(crate) fn planted() -> usize {
    static PLANTED: std::sync::OnceLock<usize> = std::sync::OnceLock::new();
    *PLANTED.get_or_init(|| std::env::var("PLANTED").map_or(0, |n| n.parse().unwrap_or(0)))
}
"""


def body_around(text, at):
    """The body of the outermost function around a place, as (first, last) of its braces; None if it cannot be doubled."""
    for head in re.finditer(r"^[ \t]*((?:pub(?:\([^)]*\))? )?(?:const )?(?:unsafe )?(?:extern \"C\" )?fn \w+)", text, re.M):
        first = text.find("{", head.end())
        if first < 0 or first > at:
            continue
        depth = 0
        for last in range(first, len(text)):
            depth += {"{": 1, "}": -1}.get(text[last], 0)
            if depth == 0:
                break
        if at < last:
            signature = text[head.start() : first]
            is_fixed = "const " in head.group(1) or "-> impl" in signature or ";" in re.sub(r"\[[^\]]*\]", "", signature)
            return None if is_fixed else (first, last)
    return None


def plant_together(numbered, command):
    """Plants all faults that can be switched on and off at run time, and builds; returns those that are planted.

    The body of a function becomes `match planted()` with one arm for each fault and one for none.
    """
    numbered = dict(numbered)
    originals = {}
    for fault in numbered.values():
        originals.setdefault(fault.file, (COPY / fault.file).read_text())
    root = {file.split("/src/")[0] + "/src/lib.rs" for file in originals}
    for file in root:
        originals.setdefault(file, (COPY / file).read_text())
    while numbered:
        active, arms = {}, {}
        for file, text in originals.items():
            bodies = {}
            for number, fault in numbered.items():
                if fault.file != file:
                    continue
                start = fault.pattern().search(text).start()
                if body := body_around(text, start):
                    bodies.setdefault(body, []).append((number, fault))
                    active[number] = fault
            planted = text
            for (first, last), own in sorted(bodies.items(), reverse=True):
                before, after = text[:first], text[last + 1 :]
                arms_of = []
                for number, fault in own:
                    whole = fault.planted(text)
                    arms_of.append(f"{number} => /* fault {number} */ {whole[first : len(whole) - len(after)]}")
                arms_of.append(f"_ => {text[first : last + 1]}")
                planted = planted[:first] + "{ match crate::planted() {\n" + ",\n".join(arms_of) + "\n} }" + planted[last + 1 :]
            arms[file] = planted + (SWITCH if file in root else "")
        for file, planted in arms.items():
            (COPY / file).write_text(planted)
        status, output = build(command)
        if status == 0:
            break
        wrong = set()
        for file, line in re.findall(r"^error.*\n\s*--> (\S+?):(\d+):", output, re.M):
            lines = (COPY / file).read_text().splitlines()[: int(line)]
            marks = re.findall(r"/\* fault (\d+) \*/", "\n".join(lines))
            wrong.update(int(number) for number in marks[-1:])
        if not wrong & set(active):
            print(f"faults cannot be planted together:\n{output[-3000:]}", flush=True)
            active = {}
            break
        numbered = {number: fault for number, fault in active.items() if number not in wrong}
    else:
        active = {}
    return active, originals


def limit_memory():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def cargo(arguments, seconds, limit=False, number=0):
    """(exit status or None after a timeout, output) of `cargo test`; ends all of its processes."""
    environment = {
        **os.environ,
        "CARGO_TARGET_DIR": str(BUILD),
        "CARGO_INCREMENTAL": "1",
        "CARGO_PROFILE_DEV_DEBUG": "0",
        "CARGO_TERM_COLOR": "never",
        "PLANTED": str(number),
    }
    environment.setdefault("OPENBLAS_NUM_THREADS", "1")
    process = subprocess.Popen(
        [os.environ.get("CARGO", "cargo"), "test", *arguments],
        cwd=COPY, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        start_new_session=True, preexec_fn=limit_memory if limit else None,
    )
    try:
        output, _ = process.communicate(timeout=seconds)
        return process.returncode, output.decode(errors="replace")
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return None, ""
    except BaseException:
        os.killpg(process.pid, signal.SIGKILL)
        raise


def build(command):
    arguments = shlex.split(command)
    if "--" in arguments:
        arguments = arguments[: arguments.index("--")]
    return cargo([*arguments, "--no-run"], BUILD_LIMIT)


def tests_passed(output):
    return sum(int(n) for n in re.findall(r"^test result: ok\. (\d+) passed", output, re.M))


def failed_tests(output):
    return re.findall(r"^test (\S+) .*FAILED$", output, re.M)


class Baseline:
    """How long each command takes without a fault; None if it runs no test."""

    def __init__(self):
        self.seconds = {}

    def of(self, command):
        if command not in self.seconds:
            status, output = build(command)
            if status != 0:
                fail(f"without a fault, this does not compile: cargo test {command}\n{output[-3000:]}")
            start = time.monotonic()
            status, output = cargo(shlex.split(command), BUILD_LIMIT, limit=True)
            self.seconds[command] = time.monotonic() - start
            if status != 0:
                fail(f"without a fault, this fails: cargo test {command}\n{output[-3000:]}")
            if tests_passed(output) == 0:
                self.seconds[command] = None
                return None
            print(f"    {self.seconds[command]:5.1f} s, {tests_passed(output)} tests: cargo test {command}", flush=True)
        return self.seconds[command]


def attempt(fault, steps, baseline):
    """Plants the fault and runs these tests until one notices: the outcome, by what, and which tests."""
    place = COPY / fault.file
    original = place.read_text()
    planted = fault.planted(original)
    usual = {command: baseline.of(command) for _, command in steps}
    try:
        place.write_text(planted)
        for kind, command in steps:
            if usual[command] is None:
                continue
            status, output = build(command)
            if status != 0:
                return "does not compile", command, re.findall(r"^error.*", output, re.M)[:3]
            status, output = cargo(shlex.split(command), SLOWER * usual[command] + GRACE, limit=True)
            if status is None:
                return f"caught by {kind}", command, ["a test that hangs"]
            if status != 0:
                return f"caught by {kind}", command, failed_tests(output)[:5] or ["a test program that ends"]
        return "survived", "", []
    finally:
        place.write_text(original)


def attempt_together(number, steps, baseline):
    """As `attempt`, of a fault that is built in already."""
    usual = {command: baseline.of(command) for _, command in steps}
    for kind, command in steps:
        if usual[command] is None:
            continue
        status, output = cargo(shlex.split(command), SLOWER * usual[command] + GRACE, limit=True, number=number)
        if status is None:
            return f"caught by {kind}", command, ["a test that hangs"]
        if status != 0:
            return f"caught by {kind}", command, failed_tests(output)[:5] or ["a test program that ends"]
    return "survived", "", []


def known_results():
    if not RESULTS.exists():
        return []
    lines = RESULTS.read_text().splitlines()
    return [json.loads(line) for line in lines if line.strip()]


def summary(faults, results):
    """Prints the table and the survivors; whether every area is above the bound."""
    areas = list(dict.fromkeys(fault.area for fault in faults))
    print(f"\n| area | faults | caught by unit tests | by wider tests | by nothing | equivalent | caught |")
    print("|---|---|---|---|---|---|---|")
    good, survivors, open_faults = True, [], 0
    total = [0] * 5
    for area in areas:
        count = {"caught by unit": 0, "caught by wider": 0, "survived": 0}
        own = [fault for fault in faults if fault.area == area]
        equivalent = 0
        for fault in own:
            result = results.get(fault.name)
            if fault.equivalent:
                equivalent += 1
                if result and result["outcome"].startswith("caught"):
                    print(f"`{fault.name}` is said to be equivalent, but was {result['outcome']}", file=sys.stderr)
                    good = False
            elif result is None or result["outcome"] == "no unit test":
                open_faults += 1
                if result:
                    print(f"no unit test: {fault.name}")
            elif result["outcome"] == "does not compile":
                fail(f"faults.txt:{fault.line}: `{fault.name}` does not compile: {result['tests']}")
            else:
                count[result["outcome"]] += 1
                if result["outcome"] == "survived":
                    survivors.append(fault)
        unit, wider, survived = count.values()
        viable = unit + wider + survived
        share = (unit + wider) / viable if viable else 1.0
        good &= share >= BOUND
        print(f"| {area} | {viable + equivalent} | {unit} | {wider} | {survived} | {equivalent} | {share:.0%} |")
        total = [a + b for a, b in zip(total, [viable + equivalent, unit, wider, survived, equivalent])]
    viable = total[0] - total[4]
    share = (total[1] + total[2]) / viable if viable else 1.0
    print(f"| all | {total[0]} | {total[1]} | {total[2]} | {total[3]} | {total[4]} | {share:.0%} |")
    for fault in survivors:
        print(f"survived: {fault.name} ({fault.file}: {' '.join(fault.old)} -> {' '.join(fault.new)})")
    if open_faults:
        print(f"{open_faults} faults have not been tried in these sources")
    return good and not open_faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", help="only faults whose area or name has one of these words")
    parser.add_argument("--check", action="store_true", help="only whether every fault can be planted")
    parser.add_argument("--table", action="store_true", help="only the table of what is known")
    parser.add_argument("--survivors", action="store_true", help="only what nothing noticed when it was last tried")
    parser.add_argument("--keep-caught", action="store_true", help="results of earlier sources count if caught")
    parser.add_argument("--units", action="store_true", help="unit tests alone")
    parser.add_argument("--one-by-one", action="store_true", help="one build a fault")
    parser.add_argument("--beside", metavar="NAME", help="in a copy of its own, for runs side by side")
    options = parser.parse_args()
    if options.beside:
        global COPY, BUILD
        COPY, BUILD = ASIDE / options.beside / "source", ASIDE / options.beside / "build"

    faults, tests = read_faults()
    for fault in faults:
        plan(fault, tests)
        fault.planted((ROOT / fault.file).read_text())
    print(f"{len(faults)} faults can be planted", flush=True)
    if options.check:
        return 0

    sources = copy_sources()
    results, last = {}, {}
    keys = {fault.name: fault.key(plan(fault, tests)) for fault in faults}
    for result in known_results():
        if keys.get(result["name"]) != result["fault"]:
            continue
        last[result["name"]] = result
        caught = result["outcome"].startswith("caught")
        if result["sources"] == sources or options.keep_caught and caught:
            results[result["name"]] = result
        elif options.keep_caught and not caught:
            results.pop(result["name"], None)
    chosen = [
        fault for fault in faults
        if not options.words or any(word in fault.area or word in fault.name for word in options.words)
    ]
    if options.survivors:
        chosen = [fault for fault in chosen if last.get(fault.name, {}).get("outcome") in ("survived", "no unit test")]
    def record(fault, kind, start, outcome, command, noticed):
        if kind == "unit" and outcome == "survived":
            outcome = "no unit test"
        result = {
            "name": fault.name, "fault": keys[fault.name], "sources": sources, "outcome": outcome,
            "command": command, "tests": noticed, "seconds": round(time.monotonic() - start, 1),
        }
        with RESULTS.open("a") as file:
            file.write(json.dumps(result) + "\n")
        results[fault.name] = result
        by = f": {', '.join(noticed)}" if noticed else ""
        print(f"{outcome:16} {result['seconds']:4.0f} s  {fault.name}{by}", flush=True)

    # all unit tests before the others, which take longer to build
    kinds = [] if options.table else ["unit"] if options.units else ["unit", "wider"]
    for kind in kinds:
        def open_faults():
            wanted = {"unit": None, "wider": "no unit test"}[kind]
            is_open = lambda fault: results.get(fault.name, {}).get("outcome") == wanted
            return [fault for fault in chosen if is_open(fault) and not fault.equivalent]

        def steps(fault):
            return [step for step in plan(fault, tests) if step[0] == kind]

        for crate in tests:
            own = [(1 + faults.index(fault), fault) for fault in open_faults() if fault.file.startswith(f"{crate}/")]
            if len(own) < 2 or options.one_by_one:
                continue
            commands = list(dict.fromkeys(command for _, fault in own for _, command in steps(fault)))
            print(f"{crate}: {len(own)} faults together", flush=True)
            active, originals = plant_together(own, commands[-1])
            try:
                baseline = Baseline()
                for number, fault in active.items():
                    start = time.monotonic()
                    record(fault, kind, start, *attempt_together(number, steps(fault), baseline))
            finally:
                for file, text in originals.items():
                    (COPY / file).write_text(text)
        baseline = Baseline()
        for fault in open_faults():
            start = time.monotonic()
            record(fault, kind, start, *attempt(fault, steps(fault), baseline))
    good = summary(chosen, results)
    return 0 if good else 1


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)

#!/usr/bin/python3
"""Solves scenes by this library, GetFEM, CalculiX and FreeFEM, on the same meshes and on this machine, one run at a time.

    report/peers/campaign.py [--quick] [--out out/report-peers]

`make report-peers` installs the programs, runs this, and lets the report compute all errors by one function from the pressures, the
displacements of a loaded face, or the forces that are written here, one file a run. A file that is there is not computed again.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import calculix_peer
import freefem_peer
import getfem_peer
import ours_peer
import processes
import scenes

PROGRAMS = [ours_peer, getfem_peer, calculix_peer, freefem_peer]
# short runs are repeated, and the least time counts
REPETITIONS, SHORT = 3, 3.0


def busy_seconds():
    """What all processors have worked since the machine began (s)."""
    words = pathlib.Path("/proc/stat").read_text().splitlines()[0].split()[1:]
    user, nice, system, _idle, _wait, irq, soft = (int(word) for word in words[:7])
    return (user + nice + system + irq + soft) / os.sysconf("SC_CLK_TCK")


def own_seconds():
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


def failed(why):
    return {"cpu": None, "unknowns": None, "failure": why[:300], "values": None}


def in_a_process(program, scene, mesh, setting):
    """A run in a process of its own."""

    def run():
        try:
            return program.solve(scene, mesh, setting)
        except subprocess.TimeoutExpired:
            return failed(f"not done after {scenes.LIMIT} s")
        except Exception as error:  # a peer that stops is a result
            return failed(f"{type(error).__name__}: {error}")

    result, why = processes.in_a_process(run, scenes.LIMIT + 10)
    return result or failed(f"not done after {scenes.LIMIT} s" if why == "late" else why)


def measured(program, scene, mesh, setting):
    """A run with its repetitions: all processor times, and how much else the machine did meanwhile, in processors."""
    times, others = [], []
    while True:
        began, own, busy = time.time(), own_seconds(), busy_seconds()
        result = in_a_process(program, scene, mesh, setting)
        wall = time.time() - began
        own, busy = own_seconds() - own, busy_seconds() - busy
        # both are known to a tick of the clock
        others.append(max(0.0, busy - own - 2 / os.sysconf("SC_CLK_TCK")) / max(wall, 0.1))
        times.append(result["cpu"])
        is_short = result["cpu"] is not None and result["cpu"] < SHORT
        if not is_short or len(times) >= REPETITIONS:
            return result, times, others


def written(result, mesh, label):
    """The fields of a result, of the boundary alone that they are measured on."""
    if result.get("scalar") is not None:
        return {"nodes": [], "facets": [], "values": [], "scalar": result["scalar"]}
    if result["values"] is None:
        return {"nodes": [], "facets": [], "values": []}
    facets = result.get("facets", mesh.facets[label])
    nodes = result.get("nodes", mesh.nodes)
    own = sorted({int(a) for facet in facets for a in facet})
    place = {a: k for k, a in enumerate(own)}
    return {
        "nodes": [[float(f"{x:.12g}") for x in nodes[a]] for a in own],
        "facets": [[place[int(a)] for a in facet] for facet in facets],
        "values": [float(f"{result['values'][a]:.10g}") for a in own],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="the coarsest mesh of each scene alone")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/report-peers"))
    parser.add_argument("--scenes", default="", help="names of scenes, with commas between them, in place of all")
    parser.add_argument("--programs", default="", help="names of programs, with commas between them, in place of all")
    arguments = parser.parse_args()
    meshes = arguments.out / "meshes"
    meshes.mkdir(parents=True, exist_ok=True)
    own = [name for name in arguments.scenes.split(",") if name]
    chosen = [scene for scene in scenes.ALL if not own or scene.name in own]
    names = [name for name in arguments.programs.split(",") if name]
    programs = [program for program in PROGRAMS if not names or program.NAME in names]
    versions = {program.NAME: program.version() for program in programs}
    for name, version in versions.items():
        print(f"{name}: {version}", flush=True)
    for scene in chosen:
        sizes = list(scene.sizes.items())
        for fineness, size in sizes[:1] if arguments.quick else sizes:
            for degree in (1, 2):
                mesh = scene.mesh(meshes.resolve(), fineness, degree)
                for program in programs:
                    for number, setting in enumerate(program.SETTINGS):
                        name = f"{scene.name}_{fineness}_P{degree}_{program.NAME}_{number}"
                        path = arguments.out / f"{name}.json"
                        applies = getattr(program, "applies", lambda *_: True)
                        if path.exists() or not applies(scene, mesh, setting):
                            continue
                        result, times, others = measured(program, scene, mesh, setting)
                        record = {
                            "scene": scene.name,
                            "program": program.NAME,
                            "version": versions[program.NAME],
                            "setting": setting,
                            "mesh": result.get("mesh", size),
                            "degree": degree,
                            "unknowns": result["unknowns"],
                            "seconds": [spent for spent in times if spent is not None],
                            "others": max(others),
                            "failure": result["failure"],
                            **written(result, mesh, scene.measured),
                        }
                        part = path.with_suffix(".part")
                        part.write_text(json.dumps(record))
                        part.rename(path)
                        spent = min(record["seconds"], default=float("nan"))
                        print(f"{name}: {setting}, {spent:.2f} s, {result['failure'] or 'solved'}", flush=True)


if __name__ == "__main__":
    sys.exit(main())

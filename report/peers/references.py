#!/usr/bin/python3
"""References of scenes without a closed form: quadratic cells of this library on finer meshes than the campaign has.

    report/peers/references.py [--out out/report-references]

prints a line a mesh. report/src/peers.rs has what follows from them, and says how.
"""

import argparse
import pathlib
import sys

import numpy as np

import ours_peer
import scenes

FINER = {"blocks": [8, 16, 32, 48], "finite_beams": [4, 5, 6, 7], "discs": [16, 24, 32, 40], "ironing": [14, 20, 28, 40]}
ASKED = {"blocks": [0.2, 0.1], "discs": [0.1], "ironing": [0.2]}


def mean(result):
    """The mean of the values over the boundary that is measured, by the rule of Simpson, or that of the middles of sides, of quadratic facets."""
    whole = area = 0.0
    for facet in result["facets"]:
        x, values = result["nodes"][facet], result["values"][facet]
        if len(facet) == 3:
            own = np.linalg.norm(x[1] - x[0])
            whole += own * (values[0] + values[1] + 4 * values[2]) / 6
        else:
            own = np.linalg.norm(np.cross(x[1] - x[0], x[2] - x[0])) / 2
            whole += own * values[3:].mean()
        area += own
    return whole / area


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/report-references"))
    folder = parser.parse_args().out.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    scenes.LIMIT = ours_peer.LIMIT = 1200

    def told(scene, setting, mesh):
        result = ours_peer.solve(scene, mesh, setting)
        if result["unknowns"] is None:
            return print(f"{scene.name}: {result['failure']}", flush=True)
        value = result.get("scalar")
        value = mean(result) if value is None else value
        of = result.get("mesh", scene.sizes[mesh.fineness])
        print(f"{scene.name}, {of}: {value:.7g}, {result['unknowns']} unknowns, {result['failure'] or 'certified'}", flush=True)

    for scene in scenes.ALL:
        for fineness in FINER.get(scene.name, []):
            scene.sizes = {fineness: f"1/{fineness}"}
            told(scene, "as it comes", scene.mesh(folder, fineness, 2))
        for asked in ASKED.get(scene.name, []):
            mesh = scene.coarse(folder, 2)
            scene.sizes, ours_peer.ACCURACIES[scene.name] = {mesh.fineness: "coarse"}, [asked]
            told(scene, "accuracy asked", mesh)


if __name__ == "__main__":
    sys.exit(main())

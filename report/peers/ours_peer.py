"""This library, by its program and a scene file: a rigid half-space, feet and rows by default, and what the program chooses as its solver.

The processor time is that of the whole program: it reads the mesh, solves, certifies, estimates the error, and writes its results.
"""

import base64
import json
import re
import resource
import subprocess

import numpy as np

from scenes import LIMIT

NAME = "ipopt-contact"
SETTINGS = {"recovered": "contact_pressure", "consistent": "contact_pressure_consistent"}
PROGRAM = "target/release/ipopt-contact"

PLANE = """
supports = [{{ at = [[0, 0], [0, 1]], x = 0 }}]
tractions = [{{ on = "top", force = [0, {traction!r}] }}]
"""
SPACE = """
supports = [{{ on = "x0", x = 0 }}, {{ on = "y0", y = 0 }}, {{ on = "top", z = {lowered!r} }}]
"""
SCENE = """
increments = 1
[[body]]
name = "body"
mesh = "{mesh}"
law = "linear-elastic"
young = {young!r}
poisson = {poisson!r}
{held}
[[obstacle]]
name = "plane"
half-space = {{ point = {origin}, normal = {normal} }}
on = [["body", "contact"]]
[output]
name = "run"
picture = ""
"""


def arrays(path):
    """The arrays of a VTU file by name."""
    text = path.read_text(encoding="latin1")
    kinds = {"Float64": np.float64, "Int64": np.int64, "Int32": np.int32, "UInt8": np.uint8}
    found = {}
    for head, body in re.findall(r"<DataArray ([^>]*)>([^<]*)<", text):
        attributes = dict(re.findall(r'(\w+)="([^"]*)"', head))
        if attributes["format"] == "binary":
            own = np.frombuffer(base64.b64decode(body)[8:], dtype=kinds[attributes["type"]])
            count = int(attributes.get("NumberOfComponents", "1"))
            found.setdefault(attributes["Name"], own.reshape(-1, count) if count > 1 else own)
    return found


def solve(scene, mesh, setting):
    """Processor time (s) of the whole program, unknowns, and the pressure at the nodes of the contact boundary."""
    plane = mesh.dimension == 2
    held = (PLANE if plane else SPACE).format(
        traction=-getattr(scene, "force", 0.0) / 2, lowered=-getattr(scene, "descent", 0.0)
    )
    zero = [0] * mesh.dimension
    path = mesh.path.with_name(mesh.path.stem + "_ours.toml")
    names = dict(young=scene.young, poisson=scene.poisson, held=held, mesh=mesh.path.name, origin=zero, normal=[*zero[1:], 1])
    path.write_text(SCENE.format(**names))
    out = path.with_suffix("")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run([PROGRAM, "run", str(path), "--out", str(out)], capture_output=True, text=True, timeout=LIMIT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    files = sorted(out.glob("run_*.vtu"))
    if run.returncode not in (0, 3) or not files:
        return {"cpu": spent, "unknowns": None, "failure": (run.stderr or run.stdout).strip()[-300:], "pressure": None}
    summary = json.loads((out / "summary.json").read_text())
    found = arrays(files[-1])
    places = found["Points"][:, : mesh.dimension]
    own = mesh.on(1)
    pressure = np.zeros(len(mesh.nodes))
    same = [np.linalg.norm(places - mesh.nodes[a], axis=1).argmin() for a in own]
    pressure[own] = found[SETTINGS[setting]][same]
    failure = None if run.returncode == 0 else "not certified"
    return {"cpu": spent, "unknowns": summary["mesh"]["free_dofs"], "failure": failure, "pressure": pressure}


def version():
    text = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True).stdout
    return text.strip()

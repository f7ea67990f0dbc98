"""This library, by its program and a scene file: a rigid half-space or a second body, feet and rows by default, and what the program chooses.

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
# the pressure that is read; None where a displacement is
SETTINGS = {"recovered": "contact_pressure", "consistent": "contact_pressure_consistent", "as it comes": None}


def applies(scene, mesh, setting):
    """Whether the scene measures what a setting reads."""
    return (scene.name == "beams") == (SETTINGS[setting] is None)


PROGRAM = "target/release/ipopt-contact"

PLANE = """
supports = [{{ at = [[0, 0], [0, 1]], x = 0 }}]
tractions = [{{ on = "top", force = [0, {traction!r}] }}]
"""
SPACE = """
supports = [{{ on = "x0", x = 0 }}, {{ on = "y0", y = 0 }}, {{ on = "top", z = {lowered!r} }}]
"""
RING = """
supports = [{ on = "x0", x = 0 }, { on = "y0", y = 0 }]
"""
BODY = """
[[body]]
name = "{name}"
mesh = "{mesh}"
law = "linear-elastic"
young = {young!r}
poisson = {poisson!r}
{held}
"""
CLAMPED = """
supports = [{ on = "left", x = 0, y = 0, z = 0 }]
"""
PULLED = """
tractions = [{{ on = "top", force = [0, 0, {traction!r}] }}]
"""
STACKED = """
[[contact]]
first = ["{lower}", "top"]
second = ["{upper}", "bottom"]
"""
PLANE_BELOW = """
[[obstacle]]
name = "plane"
half-space = {{ point = {origin}, normal = {normal} }}
on = [["body", "contact"]]
"""
FITTED = """
[[contact]]
first = ["body", "contact"]
second = ["other", "contact"]
"""
OUTPUT = """
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


def scene_file(scene, mesh):
    """The text of a scene file."""

    def body(name, mesh, held):
        return BODY.format(name=name, mesh=mesh.path.name, young=scene.young, poisson=scene.poisson, held=held)

    if scene.name == "press_fit":
        bodies = body("body", mesh, RING) + body("other", mesh.other, RING)
        return 'increments = 1\ninitial-gaps = "resolve"\n' + bodies + FITTED + OUTPUT
    if scene.name == "beams":
        upper, middle, lower = mesh.all()
        bodies = body("upper", upper, CLAMPED + PULLED.format(traction=-scene.traction))
        bodies += body("middle", middle, CLAMPED) + body("lower", lower, CLAMPED)
        pairs = STACKED.format(lower="lower", upper="middle") + STACKED.format(lower="middle", upper="upper")
        return "increments = 1\n" + bodies + pairs + OUTPUT
    held = PLANE.format(traction=-scene.force / 2) if mesh.dimension == 2 else SPACE.format(lowered=-scene.descent)
    zero = [0] * mesh.dimension
    below = PLANE_BELOW.format(origin=zero, normal=[*zero[1:], 1])
    return "increments = 1\n" + body("body", mesh, held) + below + OUTPUT


def solve(scene, mesh, setting):
    """Processor time (s) of the whole program, unknowns, and the pressure at the nodes of the contact boundary, or how far a face comes down."""
    path = mesh.path.with_name(mesh.path.stem + "_ours.toml")
    path.write_text(scene_file(scene, mesh))
    out = path.with_suffix("")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run([PROGRAM, "run", str(path), "--out", str(out)], capture_output=True, text=True, timeout=LIMIT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    files = sorted(out.glob("run_[0-9]*.vtu"))
    if run.returncode not in (0, 3) or not files:
        return {"cpu": spent, "unknowns": None, "failure": (run.stderr or run.stdout).strip()[-300:], "values": None}
    summary = json.loads((out / "summary.json").read_text())
    found = arrays(files[-1])
    places = found["Points"][:, : mesh.dimension]
    own = mesh.on(scene.measured)
    values = np.zeros(len(mesh.nodes))
    same = [np.linalg.norm(places - mesh.nodes[a], axis=1).argmin() for a in own]
    pressure = SETTINGS[setting]
    values[own] = found[pressure][same] if pressure else -found["displacement"][same, 2]
    failure = None if run.returncode == 0 else "not certified"
    return {"cpu": spent, "unknowns": summary["mesh"]["free_dofs"], "failure": failure, "values": values}


def version():
    text = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True).stdout
    return text.strip()

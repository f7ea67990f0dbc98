"""This library, by its program and a scene file: a rigid half-space or a second body, feet and rows by default, and what the program chooses.

The processor time is that of the whole program: it reads the mesh, solves, certifies, estimates the error, and writes its results.
"""

import base64
import csv
import json
import re
import resource
import shutil
import subprocess

import numpy as np

from scenes import LIMIT

NAME = "ipopt-contact"
# the pressure that is read where the scene measures one
PRESSURES = {"consistent": "contact_pressure_consistent"}
# what the command line has in addition
SETTINGS = {"recovered": [], "consistent": [], "as it comes": [], "by Ipopt": ["--solver", "ipopt"], "accuracy asked": ["--accuracy"]}
HAVE_PRESSURES = ("half_disc", "ball", "press_fit")
# the accuracy that is asked for (%), for each mesh of the other programs from the coarsest on
ACCURACIES = {
    "half_disc": [5, 2, 0.7, 0.3],
    "ball": [10, 5, 3],
    "press_fit": [1, 0.3, 0.1, 0.03],
    "blocks": [5, 2, 1, 0.5],
    "beams": [10, 5, 2],
    "finite_beams": [10, 5, 2],
    "discs": [1, 0.3, 0.1],
    "ironing": [5, 1, 0.5],
}


def applies(scene, mesh, setting):
    """Whether the scene measures what a setting reads."""
    if setting == "accuracy asked":
        return mesh.degree == 2 and list(scene.sizes).index(mesh.fineness) < len(ACCURACIES[scene.name])
    return setting == "by Ipopt" or (scene.name in HAVE_PRESSURES) != (setting == "as it comes")


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
law = "{law}"
young = {young!r}
poisson = {poisson!r}
{held}
"""
CURVED = """
curved = [{{ on = "contact", radius = {radius!r}, centre = {centre} }}]
"""
CLAMPED = """
supports = [{ on = "left", x = 0, y = 0, z = 0 }]
"""
SYMMETRIC = """
supports = [{ on = "left", x = 0 }]
"""
SYMMETRIC_AND_HELD = """
supports = [{ on = "left", x = 0 }, { on = "bottom", y = 0 }]
"""
PULLED = """
tractions = [{{ on = "top", force = {force} }}]
"""
LOWERED = """
supports = [{{ x = 0, y = {lowered!r} }}]
"""
HELD_OUTSIDE = """
supports = [{ on = "outside", x = 0, y = 0 }]
"""
HELD_BELOW = """
supports = [{ on = "bottom", x = 0, y = 0 }]
"""
IRONED = """
[[body.supports]]
on = "top"
motion = [
    {{ translation = [0, {lowered!r}], amplitude = [[0, 0], [1, 1]] }},
    {{ translation = [{slide!r}, 0], amplitude = [[1, 0], [2, 1]] }},
]
"""
PHASES = """
[[phase]]
name = "press"
until = 1
increments = 5

[[phase]]
name = "slide"
until = 2
increments = {places}
"""
PAIR = """
[[contact]]
first = ["{first}", "{of_first}"]
second = ["{second}", "{of_second}"]
"""
PLANE_BELOW = """
[[obstacle]]
name = "plane"
half-space = {{ point = {origin}, normal = {normal} }}
on = [["body", "contact"]]
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
    law = "neo-hookean" if scene.name in ("finite_beams", "discs", "ironing") else "linear-elastic"

    def body(name, mesh, held, young=scene.young):
        return BODY.format(name=name, mesh=mesh.path.name, law=law, young=young, poisson=scene.poisson, held=held)

    def curved(radius, *centre):
        return CURVED.format(radius=radius, centre=list(centre)) if mesh.degree == 2 else ""

    def pair(first, of_first, second, of_second):
        return PAIR.format(first=first, of_first=of_first, second=second, of_second=of_second)

    if scene.name == "press_fit":
        middle = scene.radii[1]
        bodies = body("inner", mesh, RING + curved(middle + scene.interference, 0, 0))
        bodies += body("outer", mesh.other, RING + curved(middle, 0, 0))
        return 'increments = 1\ninitial-gaps = "resolve"\n' + bodies + pair("inner", "contact", "outer", "contact") + OUTPUT
    if scene.name in ("beams", "finite_beams", "blocks"):
        upper, middle, lower = mesh.all()
        held, below = (SYMMETRIC, SYMMETRIC_AND_HELD) if scene.name == "blocks" else (CLAMPED, CLAMPED)
        force = [0] * (mesh.dimension - 1) + [-scene.traction]
        bodies = body("upper", upper, held + PULLED.format(force=force)) + body("middle", middle, held) + body("lower", lower, below)
        pairs = pair("lower", "top", "middle", "bottom") + pair("middle", "top", "upper", "bottom")
        return "increments = 1\n" + bodies + pairs + OUTPUT
    if scene.name == "discs":
        radius, inside, _ = scene.radii
        bodies = body("disc", mesh, LOWERED.format(lowered=-scene.descent) + curved(radius, 0, 0))
        bodies += body("ring", mesh.other, HELD_OUTSIDE + curved(inside, 0, 0))
        return "increments = 5\n" + bodies + pair("ring", "contact", "disc", "contact") + OUTPUT
    if scene.name == "ironing":
        bodies = body("slab", mesh.other, HELD_BELOW)
        bodies += body("die", mesh, IRONED.format(lowered=-scene.press, slide=scene.slide), scene.stiff)
        return PHASES.format(places=scene.places) + bodies + pair("slab", "top", "die", "bottom") + OUTPUT
    if mesh.dimension == 2:
        held = PLANE.format(traction=-scene.force / 2) + curved(1, 0, 1)
    else:
        held = SPACE.format(lowered=-scene.descent) + curved(50, 0, 0, 50)
    zero = [0] * mesh.dimension
    below = PLANE_BELOW.format(origin=zero, normal=[*zero[1:], 1])
    return "increments = 1\n" + body("body", mesh, held) + below + OUTPUT


def force_of(scene, table):
    """The force that presses the moved body down: at the end, or as the mean of its places along the way."""
    rows = list(csv.DictReader(table.open()))
    if scene.name == "discs":
        return -float(rows[-1]["reaction_disc_y"])
    places = [1 + k / scene.places for k in range(1, scene.places + 1)]
    at = [min(rows, key=lambda row: abs(float(row["load_factor"]) - place)) for place in places]
    if any(abs(float(row["load_factor"]) - place) > 1e-9 for row, place in zip(at, places)):
        raise ValueError("a place of the way is missing")
    return -sum(float(row["reaction_die_y"]) for row in at) / len(at)


def boundary(scene, places, cells):
    """The facets that are measured, of a mesh of quadratic cells: sides of one cell alone, with all corners on the boundary."""
    corners = places.shape[1] + 1
    edges = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    # nodes of the sides within a cell: corners, then middles
    sides = {3: [(0, 1), (1, 2), (2, 0)], 4: [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)]}[corners]
    middles = {frozenset(edge): corners + k for k, edge in enumerate(edges)}
    around = {2: [(0, 1)], 3: [(0, 1), (1, 2), (2, 0)]}[corners - 1]
    whole = [[*side, *(middles[frozenset((side[i], side[j]))] for i, j in around)] for side in sides]
    seen = {}
    for cell in cells:
        for side in whole:
            own = cell[side]
            seen.setdefault(frozenset(own[: corners - 1].tolist()), []).append(own)
    alone = [of[0] for of in seen.values() if len(of) == 1]
    return np.array([own for own in alone if scene.is_measured(places[own[: corners - 1]]).all()])


def solve(scene, mesh, setting):
    """Processor time (s) of the whole program, unknowns, and the pressure at the nodes of the contact boundary, how far a face comes down, or a force."""
    asked = ACCURACIES[scene.name][list(scene.sizes).index(mesh.fineness)] if setting == "accuracy asked" else None
    if asked:
        mesh = scene.coarse(mesh.path.parent, mesh.degree)
    path = mesh.path.with_name(f"{mesh.path.stem}_ours_{asked or list(SETTINGS).index(setting)}.toml")
    path.write_text(scene_file(scene, mesh))
    out = path.with_name(path.stem)
    shutil.rmtree(out, ignore_errors=True)
    command = [PROGRAM, "run", str(path), "--out", str(out), *SETTINGS[setting], *([f"{asked}%", "--seconds", str(LIMIT)] if asked else [])]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run(command, capture_output=True, text=True, timeout=2 * LIMIT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    result = {"cpu": spent, "unknowns": None, "failure": None, "values": None}
    if asked:
        result["mesh"] = f"asked {asked:g} %"
        out = max(out.glob("level_*"), key=lambda level: int(level.name[6:]), default=out)
    files = sorted(out.glob("run_[0-9]*.vtu"))
    if run.returncode not in (0, 3) or not files:
        return {**result, "failure": (run.stderr or run.stdout).strip()[-300:]}
    summary = json.loads((out / "summary.json").read_text())
    result["unknowns"] = summary["mesh"]["free_dofs"]
    result["failure"] = None if run.returncode == 0 else "not certified"
    if scene.measured is None:
        return {**result, "scalar": force_of(scene, out / "run.csv")}
    found = arrays(files[-1])
    places = found["Points"][:, : mesh.dimension]
    if asked:
        cells = np.split(found["connectivity"], found["offsets"][:-1])
        own = [cell for cell in cells if len(cell) == len(cells[0])]
        facets, nodes = boundary(scene, places, np.array(own)), places
        same = np.arange(len(nodes))
    else:
        facets, nodes = mesh.facets[scene.measured], mesh.nodes
        own = mesh.on(scene.measured)
        same = np.zeros(len(nodes), dtype=int)
        same[own] = [np.linalg.norm(places - nodes[a], axis=1).argmin() for a in own]
    if scene.name in HAVE_PRESSURES:
        values = found[PRESSURES.get(setting, "contact_pressure")]
    else:
        values = -found["displacement"][:, mesh.dimension - 1]
    return {**result, "facets": facets, "nodes": nodes, "values": values[same]}


def version():
    text = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True).stdout
    return text.strip()

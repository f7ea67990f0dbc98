"""CalculiX: surface-to-surface penalty contact with a rigid block of one layer of cells, or between bodies, by input decks.

K is the slope of pressure against overclosure, in units of E over the size of facets in the contact zone. Small strains.
"""

import re
import resource
import subprocess

import numpy as np

from scenes import CONTACT, LIMIT

NAME = "CalculiX"
SETTINGS = {"K = E/h": 1.0, "K = 10 E/h": 10.0, "K = 100 E/h": 100.0}

# faces of CalculiX's cells by the places of their corners
FACES = {2: [{0, 1}, {1, 2}, {2, 0}], 3: [{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}]}
# Gmsh's order of the nodes of a quadratic tetrahedron has the last two exchanged
ORDER = {10: [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]}


def deck(scene, mesh, stiffness):
    """The input of a run, and the number of its free displacements."""
    dimension, quadratic = mesh.dimension, mesh.degree == 2
    count = len(mesh.nodes)
    wide = 1.2 if dimension == 2 else 60.0
    depth = 0.1 if dimension == 2 else 5.0
    if dimension == 2:
        low = -wide
        block = [[low, -depth], [wide, -depth], [wide, 0.0], [low, 0.0]]
        top = "S3"
    else:
        low = -5.0
        block = [[x, y, z] for z in (-depth, 0.0) for x, y in ((low, low), (wide, low), (wide, wide), (low, wide))]
        top = "S2"
    kind = {(2, False): "CPE3", (2, True): "CPE6", (3, False): "C3D4", (3, True): "C3D10"}[dimension, quadratic]
    rigid = "CPE4" if dimension == 2 else "C3D8"
    out = ["*NODE, NSET=NALL"]
    for k, x in enumerate([*mesh.nodes.tolist(), *block], 1):
        out.append(f"{k}, " + ", ".join(f"{c:.15g}" for c in x))
    out.append(f"*ELEMENT, TYPE={kind}, ELSET=BODY")
    for k, cell in enumerate(mesh.cells, 1):
        cell = cell[ORDER.get(len(cell), range(len(cell)))] + 1
        out.append(f"{k}, " + ", ".join(map(str, cell)))
    last = len(mesh.cells) + 1
    out += [f"*ELEMENT, TYPE={rigid}, ELSET=BLOCK", f"{last}, " + ", ".join(str(count + k + 1) for k in range(len(block)))]
    faces = {}
    for k, cell in enumerate(mesh.cells):
        for f, places in enumerate(FACES[dimension]):
            faces[frozenset(int(cell[p]) for p in places)] = (k + 1, f + 1)

    def own(label):
        return [faces[frozenset(int(a) for a in facet[:dimension])] for facet in mesh.facets[label]]

    out += ["*SURFACE, NAME=SLAVE, TYPE=ELEMENT"] + [f"{k}, S{f}" for k, f in own(1)]
    out += ["*SURFACE, NAME=MASTER, TYPE=ELEMENT", f"{last}, {top}"]
    out += ["*MATERIAL, NAME=SOFT", "*ELASTIC", f"{scene.young}, {scene.poisson}"]
    out += ["*SOLID SECTION, ELSET=BODY, MATERIAL=SOFT" + ("\n1." if dimension == 2 else "")]
    out += ["*SOLID SECTION, ELSET=BLOCK, MATERIAL=SOFT" + ("\n1." if dimension == 2 else "")]
    out += ["*SURFACE INTERACTION, NAME=CONTACT", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
    out += [f"{stiffness:.10g}, {1e-6 * scene.young:.10g}, {1e-3 * scene.zone:.10g}"]
    out += ["*CONTACT PAIR, INTERACTION=CONTACT, TYPE=SURFACE TO SURFACE", "SLAVE, MASTER"]
    out += ["*BOUNDARY"]
    out += [f"{count + k + 1}, 1, {dimension}" for k in range(len(block))]
    held = len(block) * dimension
    if scene.name == "half_disc":
        axis = [k for k, x in enumerate(mesh.nodes) if np.allclose(x, [0, 0]) or np.allclose(x, [0, 1])]
        out += [f"{k + 1}, 1, 1" for k in axis]
        held = len(axis)
    else:
        sets = [(mesh.on(3), 1), (mesh.on(2), 2)]
        out += [f"{k + 1}, {i}, {i}" for nodes, i in sets for k in nodes]
        held = sum(len(nodes) for nodes, _ in sets) + len(mesh.on(scene.top))
    out += ["*STEP, INC=1000", "*STATIC", "1., 1."]
    if scene.name == "half_disc":
        out += ["*DLOAD"] + [f"{k}, P{f}, {scene.force / 2:.15g}" for k, f in own(scene.top)]
    else:
        out += ["*BOUNDARY"] + [f"{k + 1}, 3, 3, {-scene.descent}" for k in mesh.on(scene.top)]
    out += ["*CONTACT FILE", "CDIS, CSTR", "*END STEP"]
    return "\n".join(out) + "\n", dimension * count - held


def several(scene, mesh, stiffness):
    """The same of several bodies, each in contact with the next: overlaps at the start are resolved in the first step."""
    dimension, beams = mesh.dimension, scene.name == "beams"
    kind = {(2, 1): "CPE3", (2, 2): "CPE6", (3, 1): "C3D4", (3, 2): "C3D10"}[dimension, mesh.degree]
    upper, lower = (scene.bottom, scene.top) if beams else (CONTACT, CONTACT)
    held = [(scene.left, axis) for axis in (1, 2, 3)] if beams else [(3, 1), (2, 2)]
    out, surfaces, boundary, load = [], [], ["*BOUNDARY"], []
    first = cells = fixed = 0
    bodies = mesh.all()
    for place, own in enumerate(bodies):
        out.append("*NODE, NSET=NALL")
        out += [f"{first + k}, " + ", ".join(f"{c:.15g}" for c in x) for k, x in enumerate(own.nodes, 1)]
        out.append(f"*ELEMENT, TYPE={kind}, ELSET=BODY")
        faces = {}
        for k, cell in enumerate(own.cells, cells + 1):
            for f, places in enumerate(FACES[dimension], 1):
                faces[frozenset(int(cell[p]) for p in places)] = (k, f)
            out.append(f"{k}, " + ", ".join(str(first + a + 1) for a in cell[ORDER.get(len(cell), range(len(cell)))]))

        def on(label):
            return [faces[frozenset(int(a) for a in facet[:dimension])] for facet in own.facets[label]]

        for name, label, is_there in (("SLAVE", upper, place + 1 < len(bodies)), ("MASTER", lower, place > 0)):
            if is_there:
                surfaces += [f"*SURFACE, NAME={name}{place + (name == 'SLAVE')}, TYPE=ELEMENT"] + [f"{k}, S{f}" for k, f in on(label)]
        if place == 0 and beams:
            load = ["*DLOAD"] + [f"{k}, P{f}, {scene.traction}" for k, f in on(scene.top)]
        for label, axis in held:
            boundary += [f"{first + a + 1}, {axis}, {axis}" for a in own.on(label)]
            fixed += len(own.on(label))
        first, cells = first + len(own.nodes), cells + len(own.cells)
    out += surfaces
    out += ["*MATERIAL, NAME=SOFT", "*ELASTIC", f"{scene.young}, {scene.poisson}"]
    out += ["*SOLID SECTION, ELSET=BODY, MATERIAL=SOFT" + ("\n1." if dimension == 2 else "")]
    out += ["*SURFACE INTERACTION, NAME=CONTACT", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
    out += [f"{stiffness:.10g}, {1e-6 * scene.young:.10g}, {1e-3 * scene.zone:.10g}"]
    for place in range(1, len(bodies)):
        out += ["*CONTACT PAIR, INTERACTION=CONTACT, TYPE=SURFACE TO SURFACE", f"SLAVE{place}, MASTER{place}"]
    out += [*boundary, "*STEP, INC=1000", "*STATIC", "1., 1.", *load, "*NODE FILE", "U", "*CONTACT FILE", "CDIS, CSTR", "*END STEP"]
    return "\n".join(out) + "\n", dimension * first - fixed


def descents(path, mesh, label):
    """How far the nodes of a boundary of the first body come down, by the last result of a file of CalculiX."""
    values, block = np.zeros(len(mesh.nodes)), None
    number = re.compile(r"[ -]\d\.\d+E[+-]\d+")
    on = set(mesh.on(label).tolist())
    for line in path.read_text().splitlines():
        if line.startswith(" -4"):
            block = line.split()[1]
        elif line.startswith(" -3"):
            block = None
        elif line.startswith(" -1") and block == "DISP" and int(line[3:13]) - 1 in on:
            values[int(line[3:13]) - 1] = -float(number.findall(line[13:])[2])
    return values


def pressures(path, mesh):
    """The contact pressure at the nodes, of the last result of a file of CalculiX."""
    places, found = {}, {}
    block = None
    number = re.compile(r"[ -]\d\.\d+E[+-]\d+")
    column = 3
    for line in path.read_text().splitlines():
        if line.startswith("    2C"):
            block = "nodes"
        elif line.startswith(" -4"):
            block, components = line.split()[1], []
            if block == "CONTACT":
                found = {}
        elif line.startswith(" -5") and block == "CONTACT":
            components.append(line.split()[1])
            column = components.index("CPRESS") if "CPRESS" in components else column
        elif line.startswith(" -3"):
            block = None
        elif line.startswith(" -1") and block in ("nodes", "CONTACT"):
            node, values = int(line[3:13]), [float(x) for x in number.findall(line[13:])]
            if block == "nodes":
                places[node] = values
            else:
                found[node] = values[column]
    own = mesh.on(1)
    pressure = np.zeros(len(mesh.nodes))
    nodes = np.array(list(found), dtype=int)
    if len(nodes) == 0:
        return pressure
    x = np.array([places[k][: mesh.dimension] for k in nodes])
    values = np.array([found[k] for k in nodes])
    size = np.ptp(mesh.nodes[own], axis=0).max()
    for a in own:
        near = np.linalg.norm(x - mesh.nodes[a], axis=1) < 1e-5 * size
        if near.any():
            pressure[a] = values[near].mean()
    return pressure


def solve(scene, mesh, setting):
    """Processor time (s) of the whole program, unknowns, and the pressure at the nodes of the contact boundary, or how far a face comes down."""
    own = mesh.nodes[mesh.facets[scene.measured][:, : mesh.dimension]]
    sizes = np.linalg.norm(own[:, 1] - own[:, 0], axis=1)
    near = np.linalg.norm(own.mean(axis=1), axis=1) < scene.zone if mesh.other is None else slice(None)
    stiffness = SETTINGS[setting] * scene.young / sizes[near].mean()
    text, unknowns = (several if mesh.other else deck)(scene, mesh, stiffness)
    path = mesh.path.with_name(mesh.path.stem + "_ccx")
    path.with_suffix(".inp").write_text(text)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run(
        ["ccx", "-i", path.name], cwd=path.parent, capture_output=True, text=True, timeout=LIMIT,
        env={"OMP_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"},
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    log = run.stdout + run.stderr
    failure = None if run.returncode == 0 and "Job finished" in log else "no convergence"
    for line in log.splitlines():
        if "*ERROR" in line:
            failure = failure or line.strip()
    iterations = len(re.findall(r"iteration +\d+", log))
    result = path.with_suffix(".frd")
    return {
        "cpu": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
        "unknowns": unknowns,
        "iterations": iterations,
        "failure": failure,
        "values": descents(result, mesh, scene.top) if scene.name == "beams" else pressures(result, mesh),
    }


def version():
    text = subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout
    return "CalculiX " + text.strip().split()[-1]

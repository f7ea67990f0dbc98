"""CalculiX: surface-to-surface penalty contact with a rigid block of one layer of cells, or between bodies, by input decks.

K is the slope of pressure against overclosure, in units of E over the size of facets in the contact zone. Strains are small, or large
with a neo-Hookean law.
"""

import re
import resource
import subprocess

import numpy as np

from scenes import CONTACT, LIMIT

NAME = "CalculiX"
SETTINGS = {"K = E/h": 1.0, "K = 10 E/h": 10.0, "K = 100 E/h": 100.0, "K = 1000 E/h": 1000.0}
# the slopes of scenes where not the first three apply
SLOPES = {"blocks": (10.0, 100.0, 1000.0), "finite_beams": (10.0, 100.0), "discs": (100.0, 1000.0), "ironing": (100.0, 1000.0)}

# scenes with a traction on the top of the upper body, and scenes at large strains
STACKED = ("blocks", "beams", "finite_beams")
FINITE = ("finite_beams", "discs", "ironing")
# the first increment and the time of a ramp, the same for each further place of the die, and the number of increments that hold the load after it
RAMPS = {"finite_beams": "1., 1.", "discs": "0.05, 1., 1e-5, 0.05", "ironing": "0.1, 1."}
SLIDE = "1., 1."
HELD = {"finite_beams": 3, "discs": 3, "ironing": 2}
# the greatest slope of the disc's ramp; that of the setting comes with the first increment after it
SOFTER = 30.0

# faces of CalculiX's cells by the places of their corners
FACES = {2: [{0, 1}, {1, 2}, {2, 0}], 3: [{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}]}
# Gmsh's order of the nodes of a quadratic tetrahedron has the last two exchanged
ORDER = {10: [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]}


def applies(scene, mesh, setting):
    """Whether the slope of a setting is one for the scene."""
    return SETTINGS[setting] in SLOPES.get(scene.name, (1.0, 10.0, 100.0))


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


def short(c):
    """A coordinate in the 20 characters that CalculiX reads."""
    text = f"{c:.15g}"
    return text if len(text) <= 20 else f"{c:.12g}"


def anticlockwise(mesh):
    """What puts the nodes of a plane cell in anticlockwise order."""

    def turned(cell):
        a, b, c = mesh.nodes[cell[:3]]
        if mesh.dimension == 3 or (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0]):
            return cell
        return cell[[0, 2, 1, 5, 4, 3][: len(cell)]]

    return turned


def put_together(bodies, kinds, sets):
    """Nodes and cells of several bodies, each with its set of cells; for each, the nodes before its own, and faces by label; all nodes."""
    dimension = bodies[0].dimension
    out, places = [], []
    first = cells = 0
    for own, kind, name in zip(bodies, kinds, sets):
        out.append("*NODE, NSET=NALL")
        out += [f"{first + k}, " + ", ".join(map(short, x)) for k, x in enumerate(own.nodes, 1)]
        out.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        faces = {}
        for k, cell in enumerate(map(anticlockwise(own), own.cells), cells + 1):
            for f, corners in enumerate(FACES[dimension], 1):
                faces[frozenset(int(cell[p]) for p in corners)] = (k, f)
            out.append(f"{k}, " + ", ".join(str(first + a + 1) for a in cell[ORDER.get(len(cell), range(len(cell)))]))
        on = {label: [faces[frozenset(int(a) for a in facet[:dimension])] for facet in facets] for label, facets in own.facets.items()}
        places.append((first, on))
        first, cells = first + len(own.nodes), cells + len(own.cells)
    return out, places, first


def surface(name, faces):
    return [f"*SURFACE, NAME={name}, TYPE=ELEMENT"] + [f"{k}, S{f}" for k, f in faces]


def law(scene, name, young):
    """A material: linear elastic, or neo-Hookean by Ciarlet's law, which with nu = 0 is psi = mu/2 (tr C - 3 - 2 ln J)."""
    kind = "*USER MATERIAL, CONSTANTS=2" if scene.name in FINITE else "*ELASTIC"
    return [f"*MATERIAL, NAME={name}", kind, f"{young}, {scene.poisson}"]


def dead_load(mesh, label, traction):
    """Consistent forces, by nodes, of a traction per area at rest on the flat facets of a label, straight triangles."""
    forces = np.zeros(len(mesh.nodes))
    for facet in mesh.facets[label]:
        a, b, c = mesh.nodes[facet[:3]]
        # forces on corners of quadratic triangles are zero
        forces[facet[3:] if len(facet) == 6 else facet] += traction * np.linalg.norm(np.cross(b - a, c - a)) / 6
    return forces


def share(path, text):
    """The share of all ramps that a run has done, by its list of increments; ramps are the odd steps, or the only one."""
    rows = [line.split() for line in path.read_text().splitlines()[2:]] if path.exists() else []
    done = {int(row[0]): float(row[5]) for row in rows if len(row) == 7 and not row[2].endswith("U")}
    steps = text.count("*STEP")
    return sum(done.get(k, 0.0) for k in range(1, steps + 1, 2)) / max(steps // 2, 1)


def step(load, times, asked, direct=False):
    """A step at large displacements. CalculiX takes pairs of facets and normals from the start of an increment. A few
    increments that hold the load follow each ramp, so that pairs and normals fit the state."""
    return ["*STEP, INC=1000, NLGEOM", "*STATIC" + (", DIRECT" if direct else ""), times, *load, *asked, "*END STEP"]


def several(scene, mesh, stiffness):
    """The same of several bodies, each in contact with the next: overlaps at the start are resolved in the first step."""
    dimension, stacked, finite = mesh.dimension, scene.name in STACKED, scene.name in FINITE
    kind = {(2, 1): "CPE3", (2, 2): "CPE6", (3, 1): "C3D4", (3, 2): "C3D10"}[dimension, mesh.degree]
    upper, lower = (scene.bottom, scene.top) if stacked else (CONTACT, CONTACT)
    held = [(3, 1), (2, 2)]
    if stacked:
        held = [(scene.left, axis) for axis in ((1, 2, 3) if dimension == 3 else (1,))]
    bodies = mesh.all()
    out, places, count = put_together(bodies, [kind] * len(bodies), ["BODY"] * len(bodies))
    surfaces, boundary, load = [], ["*BOUNDARY"], []
    fixed = 0
    for place, (own, (first, on)) in enumerate(zip(bodies, places)):
        last = place + 1 == len(bodies)
        if not last:
            surfaces += surface(f"SLAVE{place + 1}", on[upper])
        if place > 0:
            surfaces += surface(f"MASTER{place}", on[lower])
        if place == 0 and finite:
            forces = dead_load(own, scene.top, scene.traction)
            load = ["*CLOAD"] + [f"{a + 1}, 3, {-forces[a]:.15g}" for a in np.flatnonzero(forces)]
        elif place == 0 and stacked:
            load = ["*DLOAD"] + [f"{k}, P{f}, {scene.traction}" for k, f in on[scene.top]]
        for label, axis in held + ([(scene.bottom, 2)] if stacked and dimension == 2 and last else []):
            boundary += [f"{first + a + 1}, {axis}, {axis}" for a in own.on(label)]
            fixed += len(own.on(label))
    name = "CIARLET_EL" if finite else "SOFT"
    out += surfaces
    out += law(scene, name, scene.young)
    out += [f"*SOLID SECTION, ELSET=BODY, MATERIAL={name}" + ("\n1." if dimension == 2 else "")]
    out += ["*SURFACE INTERACTION, NAME=CONTACT", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
    out += [f"{stiffness:.10g}, {1e-6 * scene.young:.10g}, {1e-3 * scene.zone:.10g}"]
    for place in range(1, len(bodies)):
        out += ["*CONTACT PAIR, INTERACTION=CONTACT, TYPE=SURFACE TO SURFACE", f"SLAVE{place}, MASTER{place}"]
    out += boundary
    asked = ["*NODE FILE" + (", OUTPUT=2D" if dimension == 2 else ""), "U"]
    if finite:
        out += step(load, RAMPS[scene.name], []) + step([], f"{1 / HELD[scene.name]:.15g}, 1.", asked, direct=True)
    else:
        asked = asked if scene.name == "blocks" else ["*NODE FILE", "U", "*CONTACT FILE", "CDIS, CSTR"]
        out += ["*STEP, INC=1000", "*STATIC", "1., 1.", *load, *asked, "*END STEP"]
    return "\n".join(out) + "\n", dimension * count - fixed


def moved(scene, mesh, stiffness, softer):
    """The same of a body that moves by given displacements against another one, whose reactions are printed after each ramp. The disc's
    ramp has the slope `softer`."""
    disc = scene.name == "discs"
    kind = {1: "CPE3", 2: "CPE6"}[mesh.degree]
    bodies = mesh.all()
    out, ((_, on), (first, below)), count = put_together(bodies, [kind] * 2, ["UPPER", "LOWER"])
    face, facing, support = (CONTACT, CONTACT, scene.outside) if disc else (scene.bottom, scene.top, scene.bottom)
    held = [first + a + 1 for a in mesh.other.on(support)]
    led = list(range(1, len(mesh.nodes) + 1)) if disc else [a + 1 for a in mesh.on(scene.top)]
    for name, nodes in (("HELD", held), ("LED", led)):
        out += [f"*NSET, NSET={name}"] + [f"{a}" for a in nodes]
    out += surface("SLAVE", below[facing]) + surface("MASTER", on[face])
    out += law(scene, "CIARLET_EL1", scene.young if disc else scene.stiff) + law(scene, "CIARLET_EL2", scene.young)
    out += ["*SOLID SECTION, ELSET=UPPER, MATERIAL=CIARLET_EL1\n1.", "*SOLID SECTION, ELSET=LOWER, MATERIAL=CIARLET_EL2\n1."]
    slopes = [["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{slope:.10g}, {1e-6 * scene.young:.10g}, {1e-3 * scene.zone:.10g}"]
              for slope in (softer if disc else stiffness, stiffness)]
    out += ["*SURFACE INTERACTION, NAME=CONTACT", *slopes[0]]
    out += ["*CONTACT PAIR, INTERACTION=CONTACT, TYPE=SURFACE TO SURFACE", "SLAVE, MASTER"]
    out += ["*BOUNDARY", "HELD, 1, 2"]
    path = [(0, -scene.descent)] if disc else [(scene.slide * k / scene.places, -scene.press) for k in range(scene.places + 1)]
    stiffer = ["*CHANGE SURFACE BEHAVIOR, INTERACTION=CONTACT", *slopes[1]] if disc else []
    asked = ["*NODE PRINT, NSET=HELD, TOTALS=ONLY, FREQUENCY=1000", "RF"]
    for k, (x, y) in enumerate(path):
        lead = ["*BOUNDARY", f"LED, 1, 1, {x:.15g}", f"LED, 2, 2, {y:.15g}"]
        out += step(lead, RAMPS[scene.name] if k == 0 else SLIDE, [])
        out += step(stiffer, f"{1 / HELD[scene.name]:.15g}, 1.", asked, direct=True)
    return "\n".join(out) + "\n", 2 * (count - len(held) - len(led))


def totals(path):
    """The total forces that are printed: the name of the set, the total time and the components."""
    lines = [line for line in path.read_text().splitlines() if line.strip()]
    for head, row in zip(lines, lines[1:]):
        if head.startswith(" total force"):
            words = head.split()
            yield words[words.index("set") + 1], float(words[-1]), [float(word) for word in row.split()]


def reactions(path):
    """The total vertical reactions that are printed, by whole total times."""
    found = {time: forces[1] for _, time, forces in totals(path)}
    return {round(time): force for time, force in found.items() if abs(time - round(time)) < 1e-6}


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
            values[int(line[3:13]) - 1] = -float(number.findall(line[13:])[mesh.dimension - 1])
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
    """Processor time (s) of the whole program, unknowns, and the pressure at the nodes of the contact boundary, how far a face comes
    down, or a force."""
    forces = scene.measured is None
    contact = scene.measured if not forces else CONTACT if scene.name == "discs" else scene.top
    body = mesh.other if forces else mesh
    own = body.nodes[body.facets[contact][:, : mesh.dimension]]
    sizes = np.linalg.norm(own[:, 1] - own[:, 0], axis=1)
    near = np.linalg.norm(own.mean(axis=1), axis=1) < scene.zone if mesh.other is None else slice(None)
    stiffness = SETTINGS[setting] * scene.young / sizes[near].mean()
    if forces:
        text, unknowns = moved(scene, mesh, stiffness, stiffness * min(1.0, SOFTER / SETTINGS[setting]))
    else:
        text, unknowns = (several if mesh.other else deck)(scene, mesh, stiffness)
    path = mesh.path.with_name(mesh.path.stem + "_ccx")
    path.with_suffix(".inp").write_text(text)
    for kind in (".sta", ".dat", ".frd"):
        path.with_suffix(kind).unlink(missing_ok=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        run = subprocess.run(
            ["ccx", "-i", path.name], cwd=path.parent, capture_output=True, text=True, timeout=LIMIT,
            env={"OMP_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"},
        )
        log = run.stdout + run.stderr
        failure = None if run.returncode == 0 and "Job finished" in log else "no convergence"
    except subprocess.TimeoutExpired:
        if scene.name not in FINITE:
            raise
        log, failure = "", f"not done after {LIMIT} s"
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    for line in log.splitlines():
        if "*ERROR" in line:
            failure = failure or line.strip()
    if failure and scene.name in FINITE:
        failure += f", at {share(path.with_suffix('.sta'), text):.0%} of the load"
    iterations = len(re.findall(r"iteration +\d+", log))
    result = path.with_suffix(".frd")
    values = scalar = None
    if forces and not failure:
        found = reactions(path.with_suffix(".dat"))
        scalar = float(np.mean([found[time] for time in range(2, max(found) + 1, 2)][0 if scene.name == "discs" else 1:]))
    elif not forces and not (failure and scene.name in FINITE):
        values = descents(result, mesh, scene.top) if scene.name in STACKED else pressures(result, mesh)
    return {
        "cpu": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
        "unknowns": unknowns,
        "iterations": iterations,
        "failure": failure,
        "values": values,
        **({"scalar": scalar} if forces else {}),
    }


def version():
    text = subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout
    return "CalculiX " + text.strip().split()[-1]

"""CalculiX on the scenes at the limits: surface-to-surface penalty contact, by input decks without units.

K is the slope of pressure against overclosure in units of E/h of the softer body, where h is the size of facets of the slave. Bodies that
supports do not hold have tiny springs to the ground. The neo-Hookean law is Ciarlet's, S = mu (1 - C^-1) + lambda/2 (J^2 - 1) C^-1, which
is the case's own only if nu = 0; a run with it has "law": "ciarlet". So one tetrahedron under a general deformation has it, to all digits.

Its mortar contact (ccx 2.20) takes no plane elements, whose slave nodes depend on those of a layer in space. In space it finds the matrix
singular, or does not end, where slave nodes have supports, as they have in the stacks.
"""

import copy
import os
import re
import subprocess

import numpy as np

from calculix_peer import put_together, share, step, surface, totals, version  # noqa: F401
from cases import LIMIT, result

NAME = "CalculiX"
SETTINGS = {"K = 100 E/h": 1e2, "K = 1e4 E/h": 1e4, "K = 1e6 E/h": 1e6}
KINDS = {(2, 1): "CPE3", (2, 2): "CPE6", (3, 1): "C3D4", (3, 2): "C3D10"}
# the stiffness of all springs to the ground of a body together
SPRING = 1e-9
# the largest share of the largest reaction that they may take: forces are printed with seven digits
SPRINGS_SHARE = 1e-5
# the overlap at the start of a body that contact alone holds
START = 1e-6
# increments that hold the load after the ramp at large strains, so that pairs and normals fit the state
HELD = 3
# the greatest residual, as a share of the mean force, the most iterations and the most cuts
CONTROLS = ["*CONTROLS, PARAMETERS=FIELD", "1.e-7, 1.e-2", "*CONTROLS, PARAMETERS=TIME INCREMENTATION", "8, 16, 18, 40, 20, 4, , 12"]


def number(x):
    """A number in the 20 characters that CalculiX reads."""
    return f"{x:.12e}"


def way_to(nodes, facets, along):
    """The shortest way of nodes along a direction to facets, given by the places of their corners: infinite if no node meets one."""
    shortest = np.inf
    for corners in facets:
        edges = np.column_stack([-along, *(corners[1:] - corners[0])])
        if abs(np.linalg.det(edges)) < 1e-12 * np.prod(np.linalg.norm(edges, axis=0)):
            continue
        way, *shares = np.linalg.solve(edges, (nodes - corners[0]).T)
        inside = (np.min(shares, axis=0) > -1e-9) & (np.sum(shares, axis=0) < 1 + 1e-9) & (way > -1e-3)
        shortest = min(shortest, way[inside].min(initial=np.inf))
    return shortest


def pushed_into_contact(case):
    """The nodes of all bodies. A body that supports do not hold is moved by its load until it touches another one, and a little further."""
    nodes = [body.nodes.copy() for body in case.bodies]
    for k, body in enumerate(case.bodies):
        force = np.zeros(case.dimension)
        for _, i, value in body.forces:
            force[i] += value
        if body.is_held() or np.linalg.norm(force) == 0.0:
            continue
        along, way = force / np.linalg.norm(force), np.inf
        for pair in case.pairs:
            for (own, label), (other, facing) in ((pair.slave, pair.master), (pair.master, pair.slave)):
                if own == k and other != k:
                    mine, its = body.facets[label], case.bodies[other].facets[facing]
                    way = min(way, way_to(nodes[k][np.unique(mine)], nodes[other][its], along))
                    way = min(way, way_to(nodes[other][np.unique(its)], nodes[k][mine], -along))
        if np.isfinite(way):
            nodes[k] += (way + START) * along
    return nodes


def prescribed(case, firsts):
    """Supports at rest, and supports that move."""
    rest, moved = ["*BOUNDARY"], ["*BOUNDARY"]
    for body, first in zip(case.bodies, firsts):
        for a, i, value in body.prescribed:
            line = f"{first + a + 1}, {i + 1}, {i + 1}"
            if value == 0.0:
                rest.append(line)
            else:
                moved.append(f"{line}, {number(value)}")
    return rest if len(rest) > 1 else [], moved if len(moved) > 1 else []


def deck(case, setting):
    """The input of a run."""
    plane = "\n1." if case.dimension == 2 else ""
    kinds = [KINDS[case.dimension, body.degree] for body in case.bodies]
    bodies = []
    for body, nodes in zip(case.bodies, pushed_into_contact(case)):
        bodies.append(copy.copy(body))
        bodies[-1].nodes = nodes
    out, places, _ = put_together(bodies, kinds, [f"BODY{k}" for k in range(len(case.bodies))])
    firsts = [first for first, _ in places]
    last = sum(len(body.cells) for body in case.bodies)
    for k, body in enumerate(case.bodies):
        name = f"ELASTIC{k}" if body.is_linear else f"CIARLET_EL{k}"
        law = "*ELASTIC" if body.is_linear else "*USER MATERIAL, CONSTANTS=2"
        out += [f"*MATERIAL, NAME={name}", law, f"{number(body.young)}, {number(body.poisson)}"]
        out += [f"*SOLID SECTION, ELSET=BODY{k}, MATERIAL={name}{plane}"]
        for i in range(case.dimension):
            nodes = sorted({a for a, axis, _ in body.prescribed if axis == i})
            if nodes:
                out += [f"*NSET, NSET=HELD{k}AXIS{i}"] + [f"{firsts[k] + a + 1}" for a in nodes]
        if not body.is_held():
            for i in range(case.dimension):
                out += [f"*ELEMENT, TYPE=SPRING1, ELSET=GROUND{k}AXIS{i}"]
                out += [f"{last + a + 1}, {firsts[k] + a + 1}" for a in range(len(body.nodes))]
                out += [f"*SPRING, ELSET=GROUND{k}AXIS{i}", f"{i + 1}", f"{number(SPRING / len(body.nodes))}"]
                last += len(body.nodes)
    for k, pair in enumerate(case.pairs):
        for name, (body, label) in (("SLAVE", pair.slave), ("MASTER", pair.master)):
            out += surface(f"{name}{k}", places[body][1][label])
        out += [f"*SURFACE INTERACTION, NAME=CONTACT{k}", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
        out += [f"{number(SETTINGS[setting] * pair.stiffness)}, {number(1e-6 * pair.young)}, 1.e-3"]
        out += [f"*CONTACT PAIR, INTERACTION=CONTACT{k}, TYPE=SURFACE TO SURFACE", f"SLAVE{k}, MASTER{k}"]
        if case.initial_gaps == "adjust":
            out += [f"*CLEARANCE, SLAVE=SLAVE{k}, MASTER=MASTER{k}, VALUE=0."]
    rest, load = prescribed(case, firsts)
    out += rest
    dead = [f"{first + a + 1}, {i + 1}, {number(value)}" for body, first in zip(case.bodies, firsts) for a, i, value in body.forces]
    load += ["*CLOAD", *dead] if dead else []
    asked = []
    for k, body in enumerate(case.bodies):
        for i in sorted({axis for _, axis, _ in body.prescribed}):
            asked += [f"*NODE PRINT, NSET=HELD{k}AXIS{i}, TOTALS=ONLY, FREQUENCY=1000", "RF"]
    if case.is_linear():
        out += ["*STEP, INC=1000", "*STATIC", "1., 1.", *CONTROLS, *load, *asked, "*END STEP"]
    else:
        longest = number(1 / case.steps())
        out += step(CONTROLS + load, f"{longest}, 1., 1.e-7, {longest}", [])
        out += step(CONTROLS, f"{number(1 / HELD)}, 1., 1.e-7, {number(1 / HELD)}", asked)
    return "\n".join(out) + "\n"


def reactions(case, path):
    """The sums of the forces of the supports on each body: forces on nodes less dead loads."""
    found = [[0.0] * case.dimension for _ in case.bodies]
    for name, _, forces in totals(path):
        k, i = map(int, re.fullmatch(r"HELD(\d+)AXIS(\d+)", name).groups())
        body = case.bodies[k]
        held = {a for a, axis, _ in body.prescribed if axis == i}
        # the last one that is printed counts
        found[k][i] = forces[i] - sum(value for a, axis, value in body.forces if axis == i and a in held)
    return found


def of_springs(case, found):
    """What springs to the ground carry, as a share of the largest reaction: what reactions lack to balance dead loads."""
    if all(body.is_held() for body in case.bodies):
        return 0.0
    lacking = np.sum(found, axis=0)
    for body in case.bodies:
        for _, i, value in body.forces:
            lacking[i] += value
    return np.linalg.norm(lacking) / max(np.linalg.norm(found, axis=1).max(), 1e-300)


def solve(case, setting, folder):
    """How a run of a case went."""
    path = folder / "case"
    path.with_suffix(".inp").write_text(deck(case, setting))
    law = {} if all(body.is_linear or body.poisson == 0 for body in case.bodies) else {"law": "ciarlet"}
    try:
        run = subprocess.run(
            ["ccx", "-i", path.name], cwd=folder, capture_output=True, text=True, timeout=LIMIT,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )
    except subprocess.TimeoutExpired:
        return result("killed", f"not done after {LIMIT} s", share(path.with_suffix(".sta"), deck(case, setting)), **law)
    log = run.stdout + run.stderr
    errors = [line.strip() for line in log.splitlines() if "*ERROR" in line]
    if run.returncode == 0 and "Job finished" in log and not errors:
        found = reactions(case, path.with_suffix(".dat"))
        taken = of_springs(case, found)
        if taken > SPRINGS_SHARE:
            return result("not converged", f"springs to the ground take {taken:.1e} of the largest reaction", 1.0, **law)
        return result("complete", "", 1.0, case.with_units(found), **law)
    outcome = "crashed" if run.returncode < 0 else "not converged"
    reason = errors[0] if errors else f"signal {-run.returncode}" if run.returncode < 0 else "no convergence"
    solver = path.with_name("spooles.out")
    if outcome != "crashed" and solver.exists() and "singular" in solver.read_text():
        reason += ", matrix found to be singular"
    return result(outcome, reason, share(path.with_suffix(".sta"), deck(case, setting)), **law)

"""Cases of the catalogue of scenes at the limits, as `extremes --export` writes them, without units.

Lengths are divided by the size of the largest body and stresses by the least Young's modulus. So units do not strain absolute tolerances
of a program, and all programs solve the same numbers.
"""

import json
import math
from collections import Counter

import numpy as np

# seconds after which a run is given up
LIMIT = 60
# a body counts as softer than another where its modulus is less than this share of the other's
SOFTER = 0.1
# steps of prescribed displacements are shorter than this share of the distance in which contact is looked for, up to so many steps
STRIDE, STEPS = 0.5, 200
# the largest cosine between normals of facets that face each other, and the depth that counts as an overlap, in thicknesses of bodies
OPPOSED, OVERLAP = -0.1, 0.8
# the edges of triangles and tetrahedra in Gmsh's order of midside nodes
EDGES = {2: [(0, 1), (1, 2), (2, 0)], 3: [(0, 1), (1, 2), (2, 0), (0, 3), (2, 3), (1, 3)]}


def sorted_cells(nodes, cells, degree):
    """Cells with positive orientation and midside nodes in Gmsh's order, and whether all edges are straight."""
    dimension = nodes.shape[1]
    cells = np.array(cells)
    corners = cells[:, : dimension + 1].copy()
    edges = nodes[corners[:, 1:]] - nodes[corners[:, :1]]
    turned = np.linalg.det(edges) < 0
    corners[turned, -2:] = corners[turned, -2:][:, ::-1]
    if degree == 1:
        return corners, True
    pairs = np.array(EDGES[dimension])
    middles = nodes[corners[:, pairs]].mean(axis=2)
    given = cells[:, dimension + 1 :]
    apart = np.linalg.norm(middles[:, :, None, :] - nodes[given][:, None, :, :], axis=3)
    found = np.take_along_axis(given, apart.argmin(axis=2), axis=1)
    if any(len(set(row)) < len(pairs) for row in found.tolist()):
        raise ValueError("midside nodes are not at the middles of edges")
    lengths = np.linalg.norm(np.diff(nodes[corners[:, pairs]], axis=2)[:, :, 0], axis=2)
    return np.hstack([corners, found]), bool((apart.min(axis=2) < 1e-9 * lengths).all())


class Body:
    """A body without units: nodes, cells, and for each label of a contact surface the corners of its facets."""

    def __init__(self, data, dimension, length, modulus):
        self.name, self.degree, self.dimension = data["name"], data["degree"], dimension
        self.nodes = np.array(data["nodes"], dtype=float) / length
        self.cells, self.is_straight = sorted_cells(self.nodes, data["cells"], self.degree)
        self.is_linear = data["law"] == "linear"
        self.young, self.poisson = data["young"] / modulus, data["poisson"]
        self.prescribed = [(int(a), int(i), value / length) for a, i, value in data["prescribed"]]
        force = modulus * length ** (dimension - 1)
        self.forces = [(int(a), int(i), value / force) for a, i, value in data["forces"]]
        self.facets = {}

    def label(self, facets):
        """The label of a surface, a new one where it has none."""
        key = {frozenset(facet) for facet in facets.tolist()}
        for label, own in self.facets.items():
            if {frozenset(facet) for facet in own.tolist()} == key:
                return label
        label = len(self.facets) + 1
        self.facets[label] = facets
        return label

    def normals(self, facets):
        """The outward normals of facets."""
        x = self.nodes[facets]
        if self.dimension == 2:
            along = x[:, 1] - x[:, 0]
            normals = np.stack([along[:, 1], -along[:, 0]], axis=1)
        else:
            normals = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        opposite = {}
        for cell in self.cells[:, : self.dimension + 1].tolist():
            for node in cell:
                opposite[frozenset(cell) - {node}] = node
        inside = self.nodes[[opposite[frozenset(facet)] for facet in facets.tolist()]] - x[:, 0]
        return np.where((inside * normals).sum(axis=1, keepdims=True) > 0, -normals, normals)

    def lame(self):
        """Lamé's first parameter and the shear modulus."""
        E, nu = self.young, self.poisson
        return E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))

    def is_rigid(self):
        """Whether all displacements are prescribed."""
        return len({(a, i) for a, i, _ in self.prescribed}) == self.nodes.size

    def is_held(self):
        """Whether prescribed displacements leave no rigid motion."""
        if self.dimension == 2:
            turns = [np.stack([-self.nodes[:, 1], self.nodes[:, 0]], axis=1)]
        else:
            turns = [np.cross(np.eye(3)[i], self.nodes) for i in range(3)]
        shifts = [np.tile(np.eye(self.dimension)[i], (len(self.nodes), 1)) for i in range(self.dimension)]
        modes = np.stack(shifts + turns)
        at = np.array([(a, i) for a, i, _ in self.prescribed], dtype=int).reshape(-1, 2)
        return np.linalg.matrix_rank(modes[:, at[:, 0], at[:, 1]], tol=1e-9) == len(modes) if len(at) else False

    def size(self, label):
        """The mean size of the facets of a surface."""
        own = self.nodes[self.facets[label]]
        if len(own) == 0:
            return math.inf
        return float(np.mean([np.linalg.norm(own[:, i] - own[:, j], axis=1) for i, j in EDGES[2][: 2 * self.dimension - 3]]))

    def thickness(self):
        """Twice the volume over the area of the boundary: the thickness of a slab or a wall."""
        corners = self.cells[:, : self.dimension + 1]
        volume = np.linalg.det(self.nodes[corners[:, 1:]] - self.nodes[corners[:, :1]]).sum() / math.factorial(self.dimension)
        sides = [tuple(sorted(np.delete(cell, k).tolist())) for cell in corners for k in range(self.dimension + 1)]
        outer = np.array([side for side, count in Counter(sides).items() if count == 1])
        x = self.nodes[outer]
        if self.dimension == 2:
            area = np.linalg.norm(x[:, 1] - x[:, 0], axis=1).sum()
        else:
            area = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum() / 2
        return 2 * volume / area


def facing(one, two, facets):
    """The facets of two surfaces that another one of the other surface faces at rest, or overlaps with by less than bodies are thick. A
    surface that is declared with the whole boundary has facets that never touch."""
    most = OVERLAP * min(one.thickness(), two.thickness())
    normals = [body.normals(own) for body, own in zip((one, two), facets)]
    nodes = [body.nodes[own] for body, own in zip((one, two), facets)]
    face = normals[0] @ normals[1].T < OPPOSED

    def before(k, other):
        """For each facet of the surface k and of the other one, whether the other facet lies before it."""
        heights = np.einsum("jnx,ix->ijn", nodes[other], normals[k]) - np.einsum("ix,ix->i", nodes[k][:, 0], normals[k])[:, None, None]
        return heights.max(axis=2) > -most

    face &= before(0, 1) & before(1, 0).T
    return facets[0][face.any(axis=1)], facets[1][face.any(axis=0)]


class Pair:
    """Two surfaces: the slave, a body and a label, and the master; and E/h, with the modulus of the softer body."""

    def __init__(self, bodies, data):
        given = [data["first"], data["second"]]
        one, two = (bodies[side["body"]] for side in given)
        facets = [np.array([facet[: one.dimension] for facet in side["facets"]]) for side in given]
        if one is not two:
            facets = facing(one, two, facets)
        sides = [(side["body"], bodies[side["body"]].label(own)) for side, own in zip(given, facets)]
        if self.leads(bodies, *sides):
            sides.reverse()
        self.slave, self.master = sides
        self.young = min([bodies[k].young for k, _ in sides if not bodies[k].is_rigid()], default=1.0)
        # facets of the slave carry the pressure, on bodies that may be thinner than these are long
        self.stiffness = self.young / min(bodies[self.slave[0]].size(self.slave[1]), one.thickness(), two.thickness())

    @staticmethod
    def leads(bodies, first, second):
        """Whether the second surface is the better slave: not rigid, or much softer, or finer."""
        one, other = bodies[first[0]], bodies[second[0]]
        if one.is_rigid() != other.is_rigid():
            return one.is_rigid()
        if other.young < SOFTER * one.young or one.young < SOFTER * other.young:
            return other.young < one.young
        return other.size(second[1]) < 0.999 * one.size(first[1])


class Case:
    """A case without units."""

    def __init__(self, path):
        data = json.loads(path.read_text())
        self.name, self.dimension, self.increments = data["name"], data["dimension"], data["increments"]
        self.initial_gaps, self.checks = data["initial_gaps"], data["checks"]
        extents = [np.ptp(np.array(body["nodes"], dtype=float), axis=0).max() for body in data["bodies"]]
        self.length, self.modulus = float(max(extents)), float(min(body["young"] for body in data["bodies"]))
        self.bodies = [Body(body, self.dimension, self.length, self.modulus) for body in data["bodies"]]
        pairs = [Pair(self.bodies, pair) for pair in data["pairs"]]
        self.pairs = [pair for pair in pairs if all(len(self.bodies[k].facets[label]) > 0 for k, label in (pair.slave, pair.master))]

    def is_linear(self):
        return all(body.is_linear for body in self.bodies)

    def with_units(self, forces):
        """Forces without units, in the units of the case."""
        return [[float(x) * self.modulus * self.length ** (self.dimension - 1) for x in row] for row in forces]

    def reach(self, pair):
        """The distance in which contact may be looked for: less than a body is thick."""
        return OVERLAP * min(self.bodies[k].thickness() for k, _ in (pair.slave, pair.master))

    def steps(self):
        """The number of steps: one at small strains, and at large strains as many more that bodies do not pass each other in one."""
        if self.is_linear():
            return 1
        travel = max((abs(value) for body in self.bodies for _, _, value in body.prescribed), default=0.0)
        shortest = min((self.reach(pair) for pair in self.pairs), default=math.inf)
        count = self.increments
        return count * max(1, min(math.ceil(travel / count / (STRIDE * shortest)), STEPS // count))


def result(outcome, reason="", share=1.0, reactions=None, **more):
    """How a run went."""
    return {"outcome": outcome, "reason": reason[:200], "share": share, "reactions": reactions, **more}

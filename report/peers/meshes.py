"""The meshes of the comparison, by Gmsh, and what is read of them.

The half disc and the eighth of a ball on a rigid plane have a known contact zone, about which the meshes are fine. Quarters of rings, and beams,
have facets of one size.
"""

import pathlib
import subprocess

import numpy as np

HALF_DISC = """
a = {zone}; hc = {size}; far = 0.12;
Point(1) = {{0, 0, 0}}; Point(2) = {{Sin(2*a), 1 - Cos(2*a), 0}}; Point(3) = {{1, 1, 0}}; Point(4) = {{0, 1, 0}};
Point(5) = {{-1, 1, 0}}; Point(6) = {{-Sin(2*a), 1 - Cos(2*a), 0}};
Circle(1) = {{6, 4, 1}}; Circle(2) = {{1, 4, 2}}; Circle(3) = {{2, 4, 3}}; Circle(4) = {{5, 4, 6}};
Line(5) = {{3, 4}}; Line(6) = {{4, 5}}; Line(7) = {{1, 4}};
Line Loop(1) = {{2, 3, 5, -7}}; Plane Surface(1) = {{1}};
Line Loop(2) = {{4, 1, 7, 6}}; Plane Surface(2) = {{2}};
Physical Line("contact", 1) = {{1, 2, 3, 4}}; Physical Line("top", 3) = {{5, 6}}; Physical Surface("body", 10) = {{1, 2}};
Physical Point("axis", 20) = {{1, 4}};
Field[1] = MathEval; Field[1].F = "{size} + 0.12*Max(0, Sqrt(x*x + y*y) - 2.2*{zone})";
"""

BALL = """
far = 12;
Point(1) = {{0, 0, 0}}; Point(2) = {{50, 0, 50}}; Point(3) = {{0, 50, 50}}; Point(4) = {{0, 0, 50}};
Circle(1) = {{1, 4, 2}}; Circle(2) = {{2, 4, 3}}; Circle(3) = {{3, 4, 1}};
Line(4) = {{4, 1}}; Line(5) = {{4, 2}}; Line(6) = {{4, 3}};
Line Loop(1) = {{1, 2, 3}}; Surface(1) = {{1}} In Sphere{{4}};
Line Loop(2) = {{4, 1, -5}}; Plane Surface(2) = {{2}};
Line Loop(3) = {{4, -3, -6}}; Plane Surface(3) = {{3}};
Line Loop(4) = {{5, 2, -6}}; Plane Surface(4) = {{4}};
Surface Loop(1) = {{1, 2, 3, 4}}; Volume(1) = {{1}};
Physical Surface("contact", 1) = {{1}}; Physical Surface("y0", 2) = {{2}}; Physical Surface("x0", 3) = {{3}};
Physical Surface("top", 4) = {{4}}; Physical Volume("body", 10) = {{1}};
Field[1] = MathEval; Field[1].F = "{size} + 0.18*Max(0, Sqrt(x*x + y*y + z*z) - 1.35*{zone})";
"""

RING = """
far = {size};
Point(1) = {{{inside}, 0, 0}}; Point(2) = {{{outside}, 0, 0}}; Point(3) = {{0, {outside}, 0}}; Point(4) = {{0, {inside}, 0}}; Point(5) = {{0, 0, 0}};
Line(1) = {{1, 2}}; Circle(2) = {{2, 5, 3}}; Line(3) = {{3, 4}}; Circle(4) = {{4, 5, 1}};
Line Loop(1) = {{1, 2, 3, 4}}; Plane Surface(1) = {{1}};
Physical Line("contact", 1) = {{{contact}}}; Physical Line("y0", 2) = {{1}}; Physical Line("x0", 3) = {{3}}; Physical Surface("body", 10) = {{1}};
Field[1] = MathEval; Field[1].F = "{size}";
"""

BEAM = """
far = 25;
Point(1) = {{0, 0, {low}}}; Point(2) = {{200, 0, {low}}}; Point(3) = {{200, 25, {low}}}; Point(4) = {{0, 25, {low}}};
Line(1) = {{1, 2}}; Line(2) = {{2, 3}}; Line(3) = {{3, 4}}; Line(4) = {{4, 1}};
Line Loop(1) = {{1, 2, 3, 4}}; Plane Surface(1) = {{1}};
Transfinite Line {{1, 3}} = {along} + 1; Transfinite Line {{2, 4}} = {across} + 1; Transfinite Surface {{1}};
out[] = Extrude {{0, 0, 25}} {{ Surface{{1}}; Layers{{{across}}}; }};
Physical Surface("bottom", 2) = {{1}}; Physical Surface("left", 4) = {{out[5]}}; Physical Surface("top", 6) = {{out[0]}};
Physical Volume("body", 10) = {{out[1]}};
Field[1] = MathEval; Field[1].F = "{size}";
"""

BLOCK = """
far = {size};
Point(1) = {{0, {low}, 0}}; Point(2) = {{{wide}, {low}, 0}}; Point(3) = {{{wide}, {high}, 0}}; Point(4) = {{0, {high}, 0}};
Line(1) = {{1, 2}}; Line(2) = {{2, 3}}; Line(3) = {{3, 4}}; Line(4) = {{4, 1}};
Line Loop(1) = {{1, 2, 3, 4}}; Plane Surface(1) = {{1}};
Transfinite Line {{1, 3}} = {along} + 1; Transfinite Line {{2, 4}} = {up} + 1; Transfinite Surface {{1}} Alternated;
Physical Line("bottom", 2) = {{1}}; Physical Line("right", 5) = {{2}}; Physical Line("top", 6) = {{3}}; Physical Line("left", 4) = {{4}};
Physical Surface("body", 10) = {{1}};
Field[1] = MathEval; Field[1].F = "{size}";
"""

ANNULUS = """
far = 1;
Point(1) = {{0, 0, 0}};
Point(2) = {{{inside}, 0, 0}}; Point(3) = {{0, {inside}, 0}}; Point(4) = {{-{inside}, 0, 0}}; Point(5) = {{0, -{inside}, 0}};
Point(6) = {{{outside}, 0, 0}}; Point(7) = {{0, {outside}, 0}}; Point(8) = {{-{outside}, 0, 0}}; Point(9) = {{0, -{outside}, 0}};
Circle(1) = {{2, 1, 3}}; Circle(2) = {{3, 1, 4}}; Circle(3) = {{4, 1, 5}}; Circle(4) = {{5, 1, 2}};
Circle(5) = {{6, 1, 7}}; Circle(6) = {{7, 1, 8}}; Circle(7) = {{8, 1, 9}}; Circle(8) = {{9, 1, 6}};
Line Loop(1) = {{1, 2, 3, 4}}; Line Loop(2) = {{5, 6, 7, 8}}; Plane Surface(1) = {{2, 1}};
Physical Line("contact", 1) = {{1, 2, 3, 4}}; Physical Line("outside", 3) = {{5, 6, 7, 8}}; Physical Surface("body", 10) = {{1}};
Field[1] = MathEval; Field[1].F = "{size} * (1 + 1.5*(Sqrt(x*x + y*y) - {inside}))";
"""

DISC = """
far = {size}; t = 0.3;
Point(1) = {{0, 0, 0}};
Point(2) = {{{radius}*Cos(t), {radius}*Sin(t), 0}}; Point(3) = {{-{radius}*Sin(t), {radius}*Cos(t), 0}};
Point(4) = {{-{radius}*Cos(t), -{radius}*Sin(t), 0}}; Point(5) = {{{radius}*Sin(t), -{radius}*Cos(t), 0}};
Circle(1) = {{2, 1, 3}}; Circle(2) = {{3, 1, 4}}; Circle(3) = {{4, 1, 5}}; Circle(4) = {{5, 1, 2}};
Line Loop(1) = {{1, 2, 3, 4}}; Plane Surface(1) = {{1}};
Physical Line("contact", 1) = {{1, 2, 3, 4}}; Physical Surface("body", 10) = {{1}};
Field[1] = MathEval; Field[1].F = "{size}";
"""

DIE = """
far = {size};
Point(1) = {{{middle}, {low} + {radius}, 0}};
Point(2) = {{{middle} - {half}, {low} + {radius} - Sqrt({radius}^2 - {half}^2), 0}}; Point(3) = {{{middle}, {low}, 0}};
Point(4) = {{{middle} + {half}, {low} + {radius} - Sqrt({radius}^2 - {half}^2), 0}};
Point(5) = {{{middle} + {half}, {high}, 0}}; Point(6) = {{{middle} - {half}, {high}, 0}};
Circle(1) = {{2, 1, 3}}; Circle(2) = {{3, 1, 4}}; Line(3) = {{4, 5}}; Line(4) = {{5, 6}}; Line(5) = {{6, 2}};
Line Loop(1) = {{1, 2, 3, 4, 5}}; Plane Surface(1) = {{1}};
Physical Line("bottom", 2) = {{1, 2}}; Physical Line("top", 6) = {{4}}; Physical Surface("body", 10) = {{1}};
Field[1] = MathEval; Field[1].F = "{size}";
"""

OPTIONS = """
Background Field = 1;
Mesh.CharacteristicLengthExtendFromBoundary = 0; Mesh.CharacteristicLengthFromPoints = 0; Mesh.CharacteristicLengthMax = far;
Mesh.MshFileVersion = 2.2; Mesh.Algorithm = 6; Mesh.ElementOrder = {degree}; Mesh.HighOrderOptimize = 0;
"""

# Gmsh's element types: dimension and number of nodes
TYPES = {15: (0, 1), 1: (1, 2), 8: (1, 3), 2: (2, 3), 9: (2, 6), 4: (3, 4), 11: (3, 10)}


def write(path, geometry, dimension, size, degree, **places):
    """Makes a mesh whose facets in the contact zone have the length `size`."""
    source = path.with_suffix(".geo")
    source.write_text((geometry + OPTIONS).format(size=size, degree=degree, **places))
    command = ["gmsh", f"-{dimension}", "-v", "1", "-nt", "1", str(source), "-o", str(path)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


class Mesh:
    """Nodes (UL), cells and the facets of each label, with Gmsh's order of nodes. `other` is the mesh of the next body, if there is one."""

    def __init__(self, path, fineness, other=None):
        self.path, self.fineness, self.other = pathlib.Path(path), fineness, other
        lines = iter(self.path.read_text().splitlines())
        next(line for line in lines if line == "$Nodes")
        count = int(next(lines))
        rows = [next(lines).split() for _ in range(count)]
        number = {int(row[0]): k for k, row in enumerate(rows)}
        nodes = np.array([[float(x) for x in row[1:4]] for row in rows])
        next(line for line in lines if line == "$Elements")
        of = {}
        for _ in range(int(next(lines))):
            row = [int(word) for word in next(lines).split()]
            own = [number[k] for k in row[3 + row[2]:]]
            of.setdefault((TYPES[row[1]][0], row[3]), []).append(own)
        self.dimension = max(dimension for dimension, _ in of)
        self.nodes = nodes[:, : self.dimension]
        self.cells = np.array(of[self.dimension, 10])
        self.facets = {
            label: np.array(own) for (dimension, label), own in of.items() if dimension == self.dimension - 1
        }
        self.degree = 2 if len(self.cells[0]) in (6, 10) else 1

    def all(self):
        """This mesh and the meshes of all next bodies."""
        return [self, *(self.other.all() if self.other else [])]

    def on(self, label):
        """The nodes of a label's facets, ascending."""
        return np.unique(self.facets[label])

"""FreeFEM: the energy is minimised by its Ipopt with bounds on the displacements of nodes, which is exact for a rigid plane.

Cells have straight sides, since FreeFEM reads no curved ones. The forces on nodes are K u − f; pressures are their projection on the facets'
shape functions, or forces over the integrals of these.
"""

import subprocess

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

from scenes import LIMIT

NAME = "FreeFEM"
SETTINGS = {"projected": False, "lumped": True}

COMMON = """
load "ff-Ipopt"
real E = {young}, nu = {poisson};
real start = clock();
"""

FINISH = """
real[int] b = -f;
real[int] u(Vh.ndof), low(Vh.ndof), high(Vh.ndof);
u = 0;
for (int i = 0; i < Vh.ndof; i++) {{
    low[i] = held[i] > 0 ? prescribed[i] : (touches[i] > 0 ? -height[][i] : -1e19);
    high[i] = held[i] > 0 ? prescribed[i] : 1e19;
}}
int status = IPOPT([K, b], u, lb = low, ub = high, optfile = "{options}");
real[int] R = K * u;
R -= f;
real spent = clock() - start;
ofstream out("{out}");
out.precision(17);
out << status << " " << spent << " " << Vh.ndof - held.sum << endl;
for (int i = 0; i < Vh.ndof; i++) if (touches[i] > 0)
    out << across[][i] << " " << aside[][i] << " " << height[][i] << " " << (held[i] > 0 ? 0. : E * R[i]) << endl;
"""

PLANE = (
    COMMON
    + """
load "gmsh"
mesh Th = gmshload("{mesh}");
fespace Vh(Th, [P{degree}, P{degree}]);
macro strain(u, v) [dx(u), dy(v), (dy(u) + dx(v)) / sqrt(2.)] //
macro div(u, v) (dx(u) + dy(v)) //
varf stiffness([u1, u2], [v1, v2]) = int2d(Th)((strain(u1, u2)' * strain(v1, v2)) / (1 + nu) + nu / ((1 + nu) * (1 - 2 * nu)) * div(u1, u2) * div(v1, v2));
varf pull([u1, u2], [v1, v2]) = int1d(Th, 3)(-{force} / 2 / E * v2);
varf contact([u1, u2], [v1, v2]) = on(1, u2 = 1);
matrix K = stiffness(Vh, Vh);
real[int] f = pull(0, Vh), touches = contact(0, Vh, tgv = 1), held(Vh.ndof), prescribed(Vh.ndof);
Vh [across, across2] = [x, x], [aside, aside2] = [0, 0], [height, height2] = [y, y];
held = 0; prescribed = 0;
Vh [first, first2] = [1, 0];
for (int i = 0; i < Vh.ndof; i++) {{
    bool isEnd = abs(height[][i]) < 1e-9 || abs(height[][i] - 1) < 1e-9;
    if (abs(across[][i]) < 1e-9 && isEnd && first[][i] > 0.5) held[i] = 1;
}}
"""
    + FINISH
)

SPACE = (
    COMMON
    + """
load "msh3"
load "gmsh"
mesh3 Th = gmshload3("{mesh}");
fespace Vh(Th, [P{degree}, P{degree}, P{degree}]);
macro strain(u, v, w) [dx(u), dy(v), dz(w), (dy(u) + dx(v)) / sqrt(2.), (dz(u) + dx(w)) / sqrt(2.), (dz(v) + dy(w)) / sqrt(2.)] //
macro div(u, v, w) (dx(u) + dy(v) + dz(w)) //
varf stiffness([u1, u2, u3], [v1, v2, v3]) = int3d(Th)((strain(u1, u2, u3)' * strain(v1, v2, v3)) / (1 + nu) + nu / ((1 + nu) * (1 - 2 * nu)) * div(u1, u2, u3) * div(v1, v2, v3));
varf contact([u1, u2, u3], [v1, v2, v3]) = on(1, u3 = 1);
varf supports([u1, u2, u3], [v1, v2, v3]) = on(3, u1 = 1) + on(2, u2 = 1) + on(4, u3 = 1);
varf down([u1, u2, u3], [v1, v2, v3]) = on(4, u3 = -{descent});
matrix K = stiffness(Vh, Vh);
real[int] f(Vh.ndof), touches = contact(0, Vh, tgv = 1), held = supports(0, Vh, tgv = 1), prescribed = down(0, Vh, tgv = 1);
f = 0;
Vh [across, across2, across3] = [x, x, x], [aside, aside2, aside3] = [y, y, y], [height, height2, height3] = [z, z, z];
"""
    + FINISH
)


def pressures(nodes, facets, forces, lumped):
    """The pressure whose products with the shape functions of flat facets are the forces on nodes, or the same with a lumped mass."""
    line = facets.shape[1] in (2, 3)
    if line:
        t, w = np.polynomial.legendre.leggauss(6)
        rule = [((1 - s) / 2, (1 + s) / 2, v / 2) for s, v in zip(t, w)]
    else:
        t, w = np.polynomial.legendre.leggauss(6)
        rule = [
            ((1 - a) / 2 * 1.0, (1 + a) / 2 * (1 - b) / 2, (1 + a) / 2 * (1 + b) / 2, va * vb / 4 * (1 + a))
            for a, va in zip(t, w)
            for b, vb in zip(t, w)
        ]
    own = np.unique(facets)
    place = {a: k for k, a in enumerate(own)}
    rows, columns, values = [], [], []
    for facet in facets:
        x = nodes[facet]
        if line:
            measure = np.linalg.norm(x[1] - x[0])
        else:
            measure = np.linalg.norm(np.cross(x[1] - x[0], x[2] - x[0])) / 2
        mass = np.zeros((len(facet), len(facet)))
        for *l, weight in rule:
            shapes = shape(l, len(facet))
            mass += weight * measure * np.outer(shapes, shapes)
        k = [place[a] for a in facet]
        rows += np.repeat(k, len(k)).tolist()
        columns += k * len(k)
        values += mass.ravel().tolist()
    mass = scipy.sparse.csc_matrix((values, (rows, columns)))
    pressure = np.zeros(len(nodes))
    sums = np.asarray(mass.sum(axis=1)).ravel()
    if lumped and not (sums > 1e-9 * sums.max()).all():
        return None
    pressure[own] = forces[own] / sums if lumped else scipy.sparse.linalg.spsolve(mass, forces[own])
    return pressure


def shape(l, count):
    """Shape functions of a facet at barycentric coordinates: corners, then the middles of the sides 01, 12, 20."""
    corners = len(l)
    if count == corners:
        return np.array(l)
    sides = [(0, 1)] if corners == 2 else [(0, 1), (1, 2), (2, 0)]
    return np.array([c * (2 * c - 1) for c in l] + [4 * l[i] * l[j] for i, j in sides])


def solve(scene, mesh, setting):
    """Processor time (s) of the script, unknowns, and the pressure at the nodes of the contact boundary."""
    straight = mesh if mesh.degree == 1 else scene.mesh(mesh.path.parent, mesh.fineness, 1)
    out = mesh.path.with_name(mesh.path.stem + "_freefem.txt")
    options = out.with_suffix(".opt")
    options.write_text("tol 1e-10\nprint_level 0\nsb yes\nhessian_constant yes\n")
    names = dict(
        young=scene.young, poisson=scene.poisson, mesh=straight.path, degree=mesh.degree, out=out, options=options,
        force=getattr(scene, "force", 0.0), descent=getattr(scene, "descent", 0.0),
    )
    script = out.with_suffix(".edp")
    script.write_text((PLANE if mesh.dimension == 2 else SPACE).format(**names))
    out.unlink(missing_ok=True)
    run = subprocess.run(
        ["FreeFem++", "-nw", "-ne", "-v", "0", str(script)], cwd=out.parent, capture_output=True, text=True, timeout=LIMIT,
        env={"FF_LOADPATH": "/usr/lib/freefem++", "OMP_NUM_THREADS": "1", "PATH": "/usr/bin:/bin", "HOME": "/tmp"},
    )
    if not out.exists():
        return {"cpu": None, "unknowns": None, "failure": "the script failed", "pressure": None, "log": run.stdout[-2000:]}
    first, *lines = out.read_text().splitlines()
    status, spent, unknowns = first.split()
    rows = np.array([[float(word) for word in line.split()] for line in lines])
    facets, nodes = straight.facets[1], straight.nodes
    if mesh.degree == 2:
        sides = [(0, 1)] if mesh.dimension == 2 else [(0, 1), (1, 2), (2, 0)]
        middles = {}
        for facet in facets:
            for i, j in sides:
                middles.setdefault(frozenset((int(facet[i]), int(facet[j]))), len(nodes) + len(middles))
        added = [nodes[list(side)].mean(axis=0) for side in middles]
        quadratic = [[*facet, *(middles[frozenset((int(facet[i]), int(facet[j])))] for i, j in sides)] for facet in facets]
        facets, nodes = np.array(quadratic), np.vstack([nodes, added])
    own = np.unique(facets)
    places = rows[:, [0, 2]] if mesh.dimension == 2 else rows[:, :3]
    apart = np.linalg.norm(nodes[own][:, None, :] - places[None, :, :], axis=2)
    forces = np.zeros(len(nodes))
    forces[own] = rows[apart.argmin(axis=1), 3]
    pressure = pressures(nodes, facets, forces, SETTINGS[setting])
    if pressure is None:
        return {"cpu": float(spent), "unknowns": int(float(unknowns)), "failure": NOT_LUMPED, "pressure": None}
    return {
        "cpu": float(spent),
        "unknowns": int(float(unknowns)),
        "failure": None if int(status) == 0 else f"Ipopt's status {status}",
        "nodes": nodes,
        "facets": facets,
        "pressure": pressure,
    }


NOT_LUMPED = "the integrals of a quadratic triangle's functions of corners are zero"


def version():
    text = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", "freefem++"], capture_output=True, text=True).stdout
    return "FreeFEM " + text.split("+")[0]

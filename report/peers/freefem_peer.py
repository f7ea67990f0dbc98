"""FreeFEM: the energy is minimised by its Ipopt with bounds on the displacements of nodes, which is exact for a rigid plane. Between two rings,
rows are the mean gaps of both passes, weighted by shape functions, with radial normals.

Cells have straight sides, since FreeFEM reads no curved ones. The forces on nodes are K u − f, or those of the multipliers; pressures are their
projection on the facets' shape functions, or forces over the integrals of these.

The setting "adaptmesh" starts from a coarse mesh that knows nothing of the contact and adapts it in rounds to von Mises's stress; its time is
that of all rounds. Large strains are solved by the project's own scripts, tuned or as the paper has them.
"""

import pathlib
import subprocess

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

from scenes import CONTACT, LIMIT

NAME = "FreeFEM"
# whether pressures are lumped, and whether the gap at the start is that of the circles in place of the polygons
SETTINGS = {
    "projected": (False, False),
    "lumped": (True, False),
    "projected, gap of the circles": (False, True),
    "lumped, gap of the circles": (True, True),
    "one pass": (False, False),
    "adaptmesh": (True, True),
    "tuned": None,
    "as the paper": None,
}
# the project's scripts for large strains, by scene and setting
SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "freefem"
LARGE = {
    ("finite_beams", "tuned"): "three_beams.edp",
    ("discs", "tuned"): "disc_in_disc.edp",
    ("discs", "as the paper"): "disc_in_disc_literal.edp",
}

# the height of the circle or the sphere over the plane at a node
CIRCLES = {"half_disc": "(1 - sqrt(1 - across[][i]^2))", "ball": "(50 - sqrt(2500 - across[][i]^2 - aside[][i]^2))"}

# increments, and the change of displacements in an iteration, over the largest of them, that ends an increment. The paper's plain fixed
# point ends in cycles of up to 5e-4 in some increments, and is stopped at 1e-3.
INCREMENTS = {("finite_beams", "tuned"): (1, 1e-8), ("discs", "tuned"): (5, 1e-8), ("discs", "as the paper"): (5, 1e-3)}


def applies(scene, mesh, setting):
    """Circles are known of round bodies, displacements are the same with all settings, and scripts for large strains have linear cells.
    With one pass, rows between blocks are means by the functions of the upper side's nodes alone."""
    if SETTINGS[setting] is None:
        return mesh.degree == 1 and (scene.name, setting) in LARGE
    if setting == "adaptmesh":
        return scene.name in TARGETS
    if scene.name not in SMALL:
        return False
    if setting == "one pass":
        return scene.name == "blocks"
    if scene.name in CIRCLES and SETTINGS[setting][1]:
        return mesh.degree == 2
    return scene.measured == CONTACT or setting == "projected"


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
    low[i] = held[i] > 0 ? prescribed[i] : (touches[i] > 0 ? -{gap} : -1e19);
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

# Ipopt's options: the smallest forces on nodes are below its own tolerances. In the stack of beams it comes to no end with these.
OPTIONS = "tol 1e-10\nprint_level 0\nsb yes\nhessian_constant yes\n"
TIGHT = OPTIONS.replace("1e-10", "1e-13") + """compl_inf_tol 1e-14
constr_viol_tol 1e-14
acceptable_iter 0
max_iter 300
nlp_scaling_method none
bound_relax_factor 0
"""

VON_MISES = """
// von Mises's stress of [u, v] over E, from the stresses in the plane, which are averages about vertices
NewMacro VonMises(Th, u, v, result)
    fespace Q#result(Th, P1);
    Q#result result, sxx#result, syy#result, sxy#result;
    {{
        varf weight(p, q) = int2d(Th)(q);
        varf xx(p, q) = int2d(Th)((nu / ((1 + nu) * (1 - 2 * nu)) * (dx(u) + dy(v)) + dx(u) / (1 + nu)) * q);
        varf yy(p, q) = int2d(Th)((nu / ((1 + nu) * (1 - 2 * nu)) * (dx(u) + dy(v)) + dy(v) / (1 + nu)) * q);
        varf xy(p, q) = int2d(Th)((dx(v) + dy(u)) / (2 * (1 + nu)) * q);
        real[int] area = weight(0, Q#result), rxx = xx(0, Q#result), ryy = yy(0, Q#result), rxy = xy(0, Q#result);
        sxx#result[] = rxx ./ area; syy#result[] = ryy ./ area; sxy#result[] = rxy ./ area;
        result = sqrt(sxx#result^2 + syy#result^2 - sxx#result * syy#result + 3 * sxy#result^2);
    }}
EndMacro
"""

# The target of adaptmesh grows by `GROWTH` from a round to the one before it; the last mesh has the target itself.
ROUNDS, GROWTH = 8, 1.5
# the fineness of a scene's coarsest mesh, its target, and the power of the fineness by which it falls
TARGETS = {"half_disc": (4, 0.04, 1.5), "blocks": (4, 0.04, 1.5)}

ADAPTED_DISC = (
    COMMON
    + VON_MISES
    + """
border left(t = pi, 3 * pi / 2) {{ x = cos(t); y = 1 + sin(t); label = 2; }}
border right(t = 3 * pi / 2, 2 * pi) {{ x = cos(t); y = 1 + sin(t); label = 1; }}
border east(t = 1, 0) {{ x = t; y = 1; label = 3; }}
border west(t = 0, -1) {{ x = t; y = 1; label = 4; }}
mesh Th = buildmesh(left(12) + right(12) + east(6) + west(6));
macro strain(u, v) [dx(u), dy(v), (dy(u) + dx(v)) / sqrt(2.)] //
macro div(u, v) (dx(u) + dy(v)) //
real scale = 100;
for (int round = 1; round <= {rounds}; round++) {{
    fespace Vh(Th, [P{degree}, P{degree}]);
    varf stiffness([u1, u2], [v1, v2]) = int2d(Th)(scale * ((strain(u1, u2)' * strain(v1, v2)) / (1 + nu)
        + nu / ((1 + nu) * (1 - 2 * nu)) * div(u1, u2) * div(v1, v2)));
    varf pull([u1, u2], [v1, v2]) = int1d(Th, 3, 4)(-scale * {force} / 2 / E * v2);
    varf contact([u1, u2], [v1, v2]) = on(1, 2, u2 = 1);
    matrix K = stiffness(Vh, Vh);
    real[int] f = pull(0, Vh), touches = contact(0, Vh, tgv = 1), low(Vh.ndof), high(Vh.ndof);
    Vh [across, across2] = [x, x], [height, height2] = [y, y], [first, first2] = [1, 0], [u1, u2] = [0, 0];
    low = -1e19; high = 1e19;
    int held = 0;
    for (int i = 0; i < Vh.ndof; i++) {{
        bool isEnd = abs(height[][i]) < 1e-9 || abs(height[][i] - 1) < 1e-9;
        if (abs(across[][i]) < 1e-9 && isEnd && first[][i] > 0.5) {{ low[i] = 0; high[i] = 0; held++; }}
        // the gap of the circle
        if (touches[i] > 0) low[i] = sqrt(max(0., 1 - across[][i]^2)) - 1;
    }}
    real[int] b = -f;
    int status = IPOPT([K, b], u1[], lb = low, ub = high, optfile = "{options}");
    if (round == {rounds}) {{
        real[int] R = K * u1[];
        R -= f;
        real spent = clock() - start;
        ofstream out("{out}"), facets("{facets}");
        out.precision(17); facets.precision(17);
        out << (held == 2 ? status : 99) << " " << spent << " " << Vh.ndof - held << endl;
        for (int i = 0; i < Vh.ndof; i++) if (touches[i] > 0) out << across[][i] << " 0 " << height[][i] << " " << E / scale * R[i] << endl;
        for (int k = 0; k < Th.nbe; k++) if (Th.be(k).label < 3) {{
            for (int j = 0; j < 2; j++) facets << Th.be(k)[j].x << " " << Th.be(k)[j].y << " ";
            facets << endl;
        }}
        break;
    }}
    VonMises(Th, u1, u2, stress)
    real err = {target} * {growth}^({rounds} - 1 - round);
    Th = adaptmesh(Th, stress, err = err, iso = 1, hmin = 1e-6, nbvx = 500000, ratio = 1.8, abserror = 1);
    // nodes of the arc onto the circle
    fespace Mh(Th, P1);
    varf arc(p, q) = on(1, 2, p = 1);
    real[int] isOn = arc(0, Mh, tgv = 1);
    Mh toX = x, toY = y;
    for (int i = 0; i < Mh.ndof; i++) if (isOn[i] > 0) {{
        real r = hypot(toX[][i], toY[][i] - 1);
        toX[][i] /= r; toY[][i] = 1 + (toY[][i] - 1) / r;
    }}
    Th = movemesh(Th, [toX, toY]);
}}
"""
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


RINGS = (
    COMMON
    + """
load "gmsh"
mesh ThI = gmshload("{mesh}"), ThO = gmshload("{other}");
fespace VI(ThI, [P{degree}, P{degree}]);
fespace VO(ThO, [P{degree}, P{degree}]);
fespace SI(ThI, P{degree});
fespace SO(ThO, P{degree});
int nI = VI.ndof, n = nI + VO.ndof;
macro strain(u, v) [dx(u), dy(v), (dy(u) + dx(v)) / sqrt(2.)] //
macro div(u, v) (dx(u) + dy(v)) //
macro elastic(u, v, p, q) ((strain(u, v)' * strain(p, q)) / (1 + nu) + nu / ((1 + nu) * (1 - 2 * nu)) * div(u, v) * div(p, q)) //
varf inner([u, v], [p, q]) = int2d(ThI)(elastic(u, v, p, q));
varf outer([u, v], [p, q]) = int2d(ThO)(elastic(u, v, p, q));
matrix KI = inner(VI, VI), KO = outer(VO, VO);
matrix K = [[KI, 0], [0, KO]];
varf supports([u, v], [p, q]) = on(3, u = 1) + on(2, v = 1);
real[int] held(n), low(n), high(n);
held(0:nI - 1) = supports(0, VI, tgv = 1);
held(nI:n - 1) = supports(0, VO, tgv = 1);
low = -1e19; high = 1e19;
for (int i = 0; i < n; i++) if (held[i] > 0) {{ low[i] = 0; high[i] = 0; }}

real[int] gaussAt = [-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526];
real[int] gaussWeight = [0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538];
// the points of a slave's facets, and where the radius through them meets the other ring's polygon, whose nodes divide the quarter evenly
func int points(mesh & Th, mesh & Other, real[int] & px, real[int] & py, real[int] & qx, real[int] & qy, real[int] & w)
{{
    int count = 0, others = 0;
    real radius = 0;
    for (int k = 0; k < Other.nbe; k++) if (Other.be(k).label == 1) {{ others++; radius = hypot(Other(Other.be(k)[0]).x, Other(Other.be(k)[0]).y); }}
    px.resize(4 * Th.nbe); py.resize(4 * Th.nbe); qx.resize(4 * Th.nbe); qy.resize(4 * Th.nbe); w.resize(4 * Th.nbe);
    real step = pi / 2 / others;
    for (int k = 0; k < Th.nbe; k++)
        if (Th.be(k).label == 1)
            for (int g = 0; g < 4; g++)
            {{
                real ax = Th(Th.be(k)[0]).x, ay = Th(Th.be(k)[0]).y, bx = Th(Th.be(k)[1]).x, by = Th(Th.be(k)[1]).y;
                real t = (1 + gaussAt[g]) / 2;
                px[count] = ax + t * (bx - ax); py[count] = ay + t * (by - ay);
                w[count] = hypot(bx - ax, by - ay) / 2 * gaussWeight[g];
                real angle = atan2(py[count], px[count]);
                real middle = (floor(angle / step) + 0.5) * step;
                real r = radius * cos(step / 2) / cos(angle - middle);
                qx[count] = r * cos(angle); qy[count] = r * sin(angle);
                count++;
            }}
    px.resize(count); py.resize(count); qx.resize(count); qy.resize(count); w.resize(count);
    return count;
}}
real[int] pxI(1), pyI(1), qxI(1), qyI(1), wI(1), pxO(1), pyO(1), qxO(1), qyO(1), wO(1);
points(ThI, ThO, pxI, pyI, qxI, qyI, wI);
points(ThO, ThI, pxO, pyO, qxO, qyO, wO);
int rows = SI.ndof + SO.ndof;
int[int] I(0), J(0);
real[int] V(0), c0(rows), clow(rows);
c0 = 0; clow = -1e19;
int entry = 0;
// A row for each node of the slave: the mean of n.(x_outer - x_inner). The inner ring's places are (ix, iy), the outer one's (ox, oy).
NewMacro Pass(name, Slave, ix, iy, ox, oy, w, row)
{{
    matrix LI = interpolate(SI, ix, iy), LO = interpolate(SO, ox, oy);
    real[int] sx = ix, sy = iy, radius(w.n), gap(w.n), area(Slave.ndof), over(Slave.ndof), c(Slave.ndof);
    for (int k = 0; k < w.n; k++) {{
        radius[k] = hypot(sx[k], sy[k]); sx[k] /= radius[k]; sy[k] /= radius[k];
        gap[k] = ({circles} ? -{interference} : hypot(ox[k], oy[k]) - radius[k]) * w[k];
    }}
    matrix S = interpolate(Slave, name#x, name#y);
    area = S * w;
    for (int i = 0; i < Slave.ndof; i++) over[i] = abs(area[i]) > 1e-12 ? 1 / area[i] : 0.;
    c = S * gap;
    for (int i = 0; i < Slave.ndof; i++) if (over[i] != 0) {{ c0[row + i] = c[i] * over[i]; clow[row + i] = 0; }}
    matrix A = over;
    for (int axis = 0; axis < 2; axis++) {{
        real[int] own = sx;
        if (axis) own = sy;
        own = own .* w;
        matrix W = own;
        matrix T = S * W;
        T = A * T;
        matrix CI = T * LI', CO = T * LO';
        int[int] a(1), b(1); real[int] v(1);
        [a, b, v] = CI;
        I.resize(entry + a.n); J.resize(entry + a.n); V.resize(entry + a.n);
        for (int k = 0; k < a.n; k++) if (v[k] != 0) {{ I[entry] = row + a[k]; J[entry] = 2 * b[k] + axis; V[entry++] = -v[k]; }}
        [a, b, v] = CO;
        I.resize(entry + a.n); J.resize(entry + a.n); V.resize(entry + a.n);
        for (int k = 0; k < a.n; k++) if (v[k] != 0) {{ I[entry] = row + a[k]; J[entry] = nI + 2 * b[k] + axis; V[entry++] = v[k]; }}
    }}
}}
EndMacro
real[int] firstx = pxI, firsty = pyI, secondx = pxO, secondy = pyO;
Pass(first, SI, pxI, pyI, qxI, qyI, wI, 0)
Pass(second, SO, qxO, qyO, pxO, pyO, wO, SI.ndof)
// the last entry gives the matrix its size
I.resize(entry + 1); J.resize(entry + 1); V.resize(entry + 1);
I[entry] = rows - 1; J[entry] = n - 1; V[entry] = 0;
matrix C = [I, J, V];
real[int] b(n), lm(rows), u(n);
b = 0; lm = 0; u = 0;
int status = IPOPT([K, b], [C, c0], u, lb = low, ub = high, clb = clow, lm = lm, optfile = "{options}");
// its multipliers of lower bounds are negative
real[int] force = C' * lm;
real spent = clock() - start;
ofstream out("{out}");
out.precision(17);
out << status << " " << spent << " " << n - held.sum << endl;
varf contact([u, v], [p, q]) = on(1, u = 1, v = 1);
real[int] touches = contact(0, VI, tgv = 1);
VI [across, across2] = [x, x], [height, height2] = [y, y];
for (int i = 0; i < nI; i += 2) if (touches[i] > 0) {{
    real r = hypot(across[][i], height[][i]);
    out << across[][i] << " 0 " << height[][i] << " " << E * (force[i] * across[][i] + force[i + 1] * height[][i]) / r << endl;
}}
"""
)


BEAMS = (
    COMMON
    + """
load "msh3"
load "gmsh"
mesh3 Th0 = gmshload3("{mesh}"), Th1 = gmshload3("{second}"), Th2 = gmshload3("{third}");
fespace V0(Th0, [P{degree}, P{degree}, P{degree}]); fespace V1(Th1, [P{degree}, P{degree}, P{degree}]); fespace V2(Th2, [P{degree}, P{degree}, P{degree}]);
fespace S0(Th0, P{degree}); fespace S1(Th1, P{degree}); fespace S2(Th2, P{degree});
fespace L0(Th0, P1); fespace L1(Th1, P1); fespace L2(Th2, P1);
int first1 = V0.ndof, first2 = first1 + V1.ndof, n = first2 + V2.ndof;
macro strain(u, v, w) [dx(u), dy(v), dz(w), (dy(u) + dx(v)) / sqrt(2.), (dz(u) + dx(w)) / sqrt(2.), (dz(v) + dy(w)) / sqrt(2.)] //
macro div(u, v, w) (dx(u) + dy(v) + dz(w)) //
macro elastic(Th) int3d(Th)((strain(u, v, w)' * strain(p, q, r)) / (1 + nu) + nu / ((1 + nu) * (1 - 2 * nu)) * div(u, v, w) * div(p, q, r)) //
varf stiff0([u, v, w], [p, q, r]) = elastic(Th0);
varf stiff1([u, v, w], [p, q, r]) = elastic(Th1);
varf stiff2([u, v, w], [p, q, r]) = elastic(Th2);
varf clamp([u, v, w], [p, q, r]) = on(4, u = 1, v = 1, w = 1);
varf pull([u, v, w], [p, q, r]) = int2d(Th0, 6)(-{force} / E * r);
matrix K0 = stiff0(V0, V0), K1 = stiff1(V1, V1), K2 = stiff2(V2, V2);
matrix K = [[K0, 0, 0], [0, K1, 0], [0, 0, K2]];
real[int] held(n), low(n), high(n), f(n);
f = 0;
f(0:first1 - 1) = pull(0, V0);
held(0:first1 - 1) = clamp(0, V0, tgv = 1);
held(first1:first2 - 1) = clamp(0, V1, tgv = 1);
held(first2:n - 1) = clamp(0, V2, tgv = 1);
low = -1e19; high = 1e19;
for (int i = 0; i < n; i++) if (held[i] > 0) {{ low[i] = 0; high[i] = 0; }}
int[int] I(0), J(0);
real[int] V(0);
int entry = 0, rows = 0;
// Rows of both passes between an upper and a lower beam: the mean of w_upper - w_lower by the linear functions of the slave's nodes
func int enter(matrix & A, int column, real sign)
{{
    int[int] a(1), b(1); real[int] v(1);
    [a, b, v] = A;
    I.resize(entry + a.n); J.resize(entry + a.n); V.resize(entry + a.n);
    for (int k = 0; k < a.n; k++) if (abs(v[k]) > 1e-14) {{ I[entry] = rows + a[k]; J[entry] = column + 3 * b[k] + 2; V[entry++] = sign * v[k]; }}
    return 0;
}}
NewMacro Pass(Slave, label, SSlave, LSlave, SMaster, columnSlave, columnMaster, sign)
{{
    varf mass(w, r) = int2d(Slave, label, qforder = 6)(w * r);
    matrix M = mass(SSlave, LSlave);
    varf weight(w, r) = int2d(Slave, label, qforder = 6)(r);
    real[int] area = weight(0, LSlave), over(LSlave.ndof);
    for (int i = 0; i < over.n; i++) over[i] = area[i] > 1e-12 ? 1 / area[i] : 0.;
    matrix A = over;
    M = A * M;
    matrix T = interpolate(SSlave, SMaster);
    matrix MT = M * T;
    enter(M, columnSlave, sign);
    enter(MT, columnMaster, -1. * (sign));
    rows += LSlave.ndof;
}}
EndMacro
Pass(Th0, 2, S0, L0, S1, 0, first1, 1)
Pass(Th1, 6, S1, L1, S0, first1, 0, -1)
Pass(Th1, 2, S1, L1, S2, first1, first2, 1)
Pass(Th2, 6, S2, L2, S1, first2, first1, -1)
I.resize(entry + 1); J.resize(entry + 1); V.resize(entry + 1);
I[entry] = rows - 1; J[entry] = n - 1; V[entry] = 0;
matrix C = [I, J, V];
real[int] b = -f, c0(rows), clow(rows), lm(rows), u(n);
c0 = 0; clow = -1e19; lm = 0; u = 0;
for (int k = 0; k < entry; k++) clow[I[k]] = 0;
int status = IPOPT([K, b], [C, c0], u, lb = low, ub = high, clb = clow, lm = lm, optfile = "{options}");
real spent = clock() - start;
ofstream out("{out}");
out.precision(17);
out << status << " " << spent << " " << n - held.sum << endl;
varf loaded([u, v, w], [p, q, r]) = on(6, w = 1);
real[int] touches = loaded(0, V0, tgv = 1);
V0 [ax, ax2, ax3] = [x, x, x], [ay, ay2, ay3] = [y, y, y], [az, az2, az3] = [z, z, z];
for (int i = 0; i < first1; i++) if (touches[i] > 0) out << ax[][i] << " " << ay[][i] << " " << az[][i] << " " << -u[i] << endl;
"""
)

BLOCKS = (
    COMMON
    + VON_MISES
    + """
load "gmsh"
int[int] sides = [2, 5, 6, 4];
mesh Th0 = {first_mesh}, Th1 = {second_mesh}, Th2 = {third_mesh};
macro strain(u, v) [dx(u), dy(v), (dy(u) + dx(v)) / sqrt(2.)] //
macro div(u, v) (dx(u) + dy(v)) //
macro elastic(Th) int2d(Th)(scale * ((strain(u, v)' * strain(p, q)) / (1 + nu) + nu / ((1 + nu) * (1 - 2 * nu)) * div(u, v) * div(p, q))) //
real scale = 100;
int[int] I(0), J(0);
real[int] V(0), clow(0);
int entry = 0, rows = 0;
real[int] gaussAt = [-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526];
real[int] gaussWeight = [0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538];
// Gauss points of the common part of an upper block's bottom and a lower block's top, between the nodes of both
func int points(mesh & Upper, mesh & Lower, real[int] & px, real[int] & py, real[int] & w)
{{
    real[int] cut(2 * Upper.nbe + 2 * Lower.nbe);
    int count = 0;
    real wide = 0, widest = 0;
    for (int k = 0; k < Upper.nbe; k++) if (Upper.be(k).label == 2) for (int j = 0; j < 2; j++) {{
        cut[count++] = Upper.be(k)[j].x; py[0] = Upper.be(k)[j].y; wide = max(wide, Upper.be(k)[j].x);
    }}
    for (int k = 0; k < Lower.nbe; k++) if (Lower.be(k).label == 6) for (int j = 0; j < 2; j++) {{
        cut[count++] = Lower.be(k)[j].x; widest = max(widest, Lower.be(k)[j].x);
    }}
    wide = min(wide, widest);
    real height = py[0];
    cut.resize(count);
    cut.sort;
    px.resize(4 * count); py.resize(4 * count); w.resize(4 * count);
    int found = 0;
    for (int k = 0; k + 1 < count; k++) if (cut[k + 1] - cut[k] > 1e-10 && cut[k + 1] < wide + 1e-10) for (int g = 0; g < 4; g++) {{
        px[found] = cut[k] + (1 + gaussAt[g]) / 2 * (cut[k + 1] - cut[k]);
        py[found] = height;
        w[found++] = (cut[k + 1] - cut[k]) / 2 * gaussWeight[g];
    }}
    px.resize(found); py.resize(found); w.resize(found);
    return found;
}}
func int enter(matrix & A, int column, real sign)
{{
    int[int] a(1), b(1); real[int] v(1);
    [a, b, v] = A;
    I.resize(entry + a.n); J.resize(entry + a.n); V.resize(entry + a.n);
    for (int k = 0; k < a.n; k++) if (abs(v[k]) > 1e-14) {{
        I[entry] = rows + a[k]; J[entry] = column + 2 * b[k] + 1; V[entry++] = sign * v[k];
    }}
    return 0;
}}
// Rows of a pass: the mean of v_upper - v_lower by the linear functions of the slave's nodes
NewMacro Rows(LSlave)
{{
    matrix B = interpolate(LSlave, px, py), D = w;
    real[int] area = B * w, over(area.n);
    for (int i = 0; i < area.n; i++) {{ over[i] = area[i] > 1e-9 ? 1 / area[i] : 0.; if (over[i] != 0) clow[rows + i] = 0; }}
    matrix A = over, M = B * D;
    M = A * M;
    matrix CU = M * PU', CL = M * PL';
    enter(CU, columnUpper, 1);
    enter(CL, columnLower, -1);
    rows += area.n;
}}
EndMacro
NewMacro Pair(Upper, SUpper, LUpper, kUpper, Lower, SLower, LLower, kLower)
{{
    real[int] px(1), py(1), w(1);
    points(Upper, Lower, px, py, w);
    matrix PU = interpolate(SUpper, px, py), PL = interpolate(SLower, px, py);
    int columnUpper = kUpper, columnLower = kLower;
    Rows(LUpper)
    if ({both}) Rows(LLower)
}}
EndMacro
for (int round = 1; round <= {rounds}; round++) {{
    fespace V0(Th0, [P{degree}, P{degree}]); fespace V1(Th1, [P{degree}, P{degree}]); fespace V2(Th2, [P{degree}, P{degree}]);
    fespace S0(Th0, P{degree}); fespace S1(Th1, P{degree}); fespace S2(Th2, P{degree});
    fespace L0(Th0, P1); fespace L1(Th1, P1); fespace L2(Th2, P1);
    int first1 = V0.ndof, first2 = first1 + V1.ndof, n = first2 + V2.ndof;
    varf stiff0([u, v], [p, q]) = elastic(Th0);
    varf stiff1([u, v], [p, q]) = elastic(Th1);
    varf stiff2([u, v], [p, q]) = elastic(Th2);
    varf symmetry([u, v], [p, q]) = on(4, u = 1);
    varf supports([u, v], [p, q]) = on(4, u = 1) + on(2, v = 1);
    varf pull([u, v], [p, q]) = int1d(Th0, 6)(-scale * {force} / E * q);
    matrix K0 = stiff0(V0, V0), K1 = stiff1(V1, V1), K2 = stiff2(V2, V2);
    matrix K = [[K0, 0, 0], [0, K1, 0], [0, 0, K2]];
    real[int] held(n), low(n), high(n), f(n);
    f = 0;
    f(0:first1 - 1) = pull(0, V0);
    held(0:first1 - 1) = symmetry(0, V0, tgv = 1);
    held(first1:first2 - 1) = symmetry(0, V1, tgv = 1);
    held(first2:n - 1) = supports(0, V2, tgv = 1);
    low = -1e19; high = 1e19;
    for (int i = 0; i < n; i++) if (held[i] > 0) {{ low[i] = 0; high[i] = 0; }}
    I.resize(0); J.resize(0); V.resize(0); clow.resize(L0.ndof + 2 * L1.ndof + L2.ndof);
    entry = 0; rows = 0;
    clow = -1e19;
    Pair(Th0, S0, L0, 0, Th1, S1, L1, first1)
    Pair(Th1, S1, L1, first1, Th2, S2, L2, first2)
    rows = clow.n;
    I.resize(entry + 1); J.resize(entry + 1); V.resize(entry + 1);
    I[entry] = rows - 1; J[entry] = n - 1; V[entry] = 0;
    matrix C = [I, J, V];
    real[int] b = -f, c0(rows), lm(rows), u(n);
    c0 = 0; lm = 0; u = 0;
    int status = IPOPT([K, b], [C, c0], u, lb = low, ub = high, clb = clow, lm = lm, optfile = "{options}");
    if (round == {rounds}) {{
        real spent = clock() - start;
        ofstream out("{out}"), facets("{facets}");
        out.precision(17); facets.precision(17);
        out << status << " " << spent << " " << n - held.sum << endl;
        varf loaded([u, v], [p, q]) = on(6, v = 1);
        real[int] touches = loaded(0, V0, tgv = 1);
        V0 [ax, ax2] = [x, x], [ay, ay2] = [y, y];
        for (int i = 0; i < first1; i++) if (touches[i] > 0) out << ax[][i] << " 0 " << ay[][i] << " " << -u[i] << endl;
        for (int k = 0; k < Th0.nbe; k++) if (Th0.be(k).label == 6) {{
            for (int j = 0; j < 2; j++) facets << Th0.be(k)[j].x << " " << Th0.be(k)[j].y << " ";
            facets << endl;
        }}
        break;
    }}
    V0 [u0, v0]; V1 [u1, v1]; V2 [u2, v2];
    u0[] = u(0:first1 - 1); u1[] = u(first1:first2 - 1); u2[] = u(first2:n - 1);
    VonMises(Th0, u0, v0, stress0)
    VonMises(Th1, u1, v1, stress1)
    VonMises(Th2, u2, v2, stress2)
    real err = {target} * {growth}^({rounds} - 1 - round);
    Th0 = adaptmesh(Th0, stress0, err = err, iso = 1, hmin = 1e-6, nbvx = 500000, ratio = 1.8, abserror = 1);
    Th1 = adaptmesh(Th1, stress1, err = err, iso = 1, hmin = 1e-6, nbvx = 500000, ratio = 1.8, abserror = 1);
    Th2 = adaptmesh(Th2, stress2, err = err, iso = 1, hmin = 1e-6, nbvx = 500000, ratio = 1.8, abserror = 1);
}}
"""
)


# the scripts for small strains, by scene
SMALL = {"half_disc": PLANE, "ball": SPACE, "press_fit": RINGS, "beams": BEAMS, "blocks": BLOCKS}
ENVIRONMENT = {
    "FF_LOADPATH": "/usr/lib/freefem++", "FF_INCLUDEPATH": str(SCRIPTS), "OMP_NUM_THREADS": "1", "PATH": "/usr/bin:/bin", "HOME": "/tmp",
}


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


def write_medit(path, mesh, labels):
    """Writes a linear mesh in Medit's format. Of its facets the labels in `labels` are written, each with the new label that it leads to."""
    kinds = {2: ("Edges", "Triangles"), 3: ("Triangles", "Tetrahedra")}[mesh.dimension]
    facets = [[*(facet + 1), own] for label, own in labels.items() for facet in mesh.facets[label]]
    x = mesh.nodes[mesh.cells]
    turned = np.linalg.det(x[:, 1:] - x[:, :1]) < 0
    cells = mesh.cells.copy()
    cells[turned, :2] = cells[turned, 1::-1]
    parts = [("Vertices", [[*node, 0] for node in mesh.nodes]), (kinds[0], facets), (kinds[1], [[*(cell + 1), 10] for cell in cells])]
    text = f"MeshVersionFormatted 2\nDimension {mesh.dimension}\n"
    for name, rows in parts:
        lines = [" ".join(f"{word:.17g}" for word in row) for row in rows]
        text += "\n".join([name, str(len(rows)), *lines]) + "\n"
    path.write_text(text + "End\n")


def solve_large(scene, mesh, setting):
    """Processor time (s) of one of the project's scripts, by its own clock, unknowns, and how far a face comes down or a force."""
    script = SCRIPTS / LARGE[scene.name, setting]
    increments, tolerance = INCREMENTS[scene.name, setting]
    folder = mesh.path.with_name(f"{mesh.path.stem}_{script.stem}")
    folder.mkdir(exist_ok=True)
    result = folder / "result.txt"
    result.unlink(missing_ok=True)
    if scene.name == "discs":
        write_medit(folder / "ring.msh", mesh.other, {CONTACT: 1, scene.outside: 2})
        write_medit(folder / "disc.msh", mesh, {CONTACT: 1})
        free = 2 * (len(mesh.other.nodes) - len(mesh.other.on(scene.outside)))
        arguments = []
    else:
        for number, own in enumerate(reversed(mesh.all())):
            write_medit(folder / f"beam{number + 1}.mesh", own, {label: label for label in (scene.bottom, scene.left, scene.top)})
        free = sum(3 * (len(own.nodes) - len(own.on(scene.left))) for own in mesh.all())
        arguments = ["-law", "neo_hookean", "-young", str(scene.young), "-nu", str(scene.poisson), "-pressure", str(scene.traction)]
    arguments += ["-meshes", ".", "-out", ".", "-increments", str(increments), "-tolerance", str(tolerance)]
    command = ["FreeFem++", "-nw", "-ne", "-v", "0", str(script)]
    run = subprocess.run(command + arguments, cwd=folder, capture_output=True, text=True, timeout=LIMIT, env=ENVIRONMENT)
    if not result.exists():
        return {"cpu": None, "unknowns": free, "failure": "the script failed", "values": None, "log": run.stdout[-2000:]}
    found = dict(line.split() for line in result.read_text().splitlines())
    answer = {"cpu": float(found["seconds_total"]), "unknowns": free, "failure": None, "values": None}
    if found["converged"] != "1":
        return {**answer, "failure": "increments did not converge"}
    if scene.name == "discs":
        return {**answer, "scalar": abs(float(found["reaction_y"]))}
    moved = np.loadtxt(folder / f"displacement_beam{len(mesh.all())}.txt")
    return {**answer, "values": -moved[:, 2]}


def solve(scene, mesh, setting):
    """Processor time (s) of the script, unknowns, and the pressure on the contact boundary, or how far a loaded face comes down."""
    if (scene.name, setting) in LARGE:
        return solve_large(scene, mesh, setting)
    straight = mesh if mesh.degree == 1 else scene.mesh(mesh.path.parent, mesh.fineness, 1)
    out = mesh.path.with_name(mesh.path.stem + "_freefem.txt")
    options = out.with_suffix(".opt")
    is_adapted = setting == "adaptmesh"
    facets_file = out.with_suffix(".facets")
    options.write_text(OPTIONS if scene.name == "beams" else TIGHT)
    names = dict(
        young=scene.young, poisson=scene.poisson, mesh=straight.path, degree=mesh.degree, out=out, options=options,
        force=getattr(scene, "force", getattr(scene, "traction", 0.0)), descent=getattr(scene, "descent", 0.0), other=straight.other and straight.other.path,
        circles=int(SETTINGS[setting][1]), interference=getattr(scene, "interference", 0.0), both=int(setting == "projected"),
        gap=CIRCLES[scene.name] if SETTINGS[setting][1] and scene.name in CIRCLES else "height[][i]",
        facets=facets_file, rounds=ROUNDS if is_adapted else 1, growth=GROWTH, target=0.0,
    )
    names.update(zip(("mesh", "second", "third"), (own.path for own in straight.all())))
    for number, own in enumerate(straight.all()):
        names[("first_mesh", "second_mesh", "third_mesh")[number]] = f'gmshload("{own.path}")'
    if is_adapted:
        coarsest, target, power = TARGETS[scene.name]
        names["target"] = target * (coarsest / mesh.fineness) ** power
    if is_adapted and scene.name == "blocks":
        for key, low, wide in zip(("third_mesh", "second_mesh", "first_mesh"), range(3), scene.widths):
            names[key] = f"square({max(2, round(4 * wide))}, 4, [{wide} * x, y + {low}], label = sides)"
    script = out.with_suffix(".edp")
    text = ADAPTED_DISC if is_adapted and scene.name == "half_disc" else SMALL[scene.name]
    script.write_text(text.format(**names))
    out.unlink(missing_ok=True)
    facets_file.unlink(missing_ok=True)
    run = subprocess.run(
        ["FreeFem++", "-nw", "-ne", "-v", "0", str(script)], cwd=out.parent, capture_output=True, text=True, timeout=LIMIT,
        env=ENVIRONMENT,
    )
    if not out.exists():
        return {"cpu": None, "unknowns": None, "failure": "the script failed", "values": None, "log": run.stdout[-2000:]}
    first, *lines = out.read_text().splitlines()
    status, spent, unknowns = first.split()
    rows = np.array([[float(word) for word in line.split()] for line in lines])
    facets, nodes = straight.facets[scene.measured], straight.nodes
    if is_adapted:
        corners = np.array([[float(word) for word in line.split()] for line in facets_file.read_text().splitlines()])
        nodes, place = np.unique(corners.reshape(-1, mesh.dimension), axis=0, return_inverse=True)
        facets = place.reshape(-1, 2)
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
    # the last column has forces, or how far nodes come down
    values = forces if scene.measured != CONTACT else pressures(nodes, facets, forces, SETTINGS[setting][0])
    if values is None:
        return {"cpu": float(spent), "unknowns": int(float(unknowns)), "failure": NOT_LUMPED, "values": None}
    return {
        "cpu": float(spent),
        "unknowns": int(float(unknowns)),
        "failure": None if int(status) == 0 else f"Ipopt's status {status}",
        **({"mesh": f"asked {names['target']:.2g}"} if is_adapted else {}),
        "nodes": nodes,
        "facets": facets,
        "values": values,
    }


NOT_LUMPED = "the integrals of a quadratic triangle's functions of corners are zero"


def version():
    text = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", "freefem++"], capture_output=True, text=True).stdout
    return "FreeFEM " + text.split("+")[0]

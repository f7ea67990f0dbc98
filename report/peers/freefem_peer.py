"""FreeFEM: the energy is minimised by its Ipopt with bounds on the displacements of nodes, which is exact for a rigid plane. Between two rings,
rows are the mean gaps of both passes, weighted by shape functions, with radial normals.

Cells have straight sides, since FreeFEM reads no curved ones. The forces on nodes are K u − f, or those of the multipliers; pressures are their
projection on the facets' shape functions, or forces over the integrals of these.

The setting "adaptmesh" starts from a coarse mesh that knows nothing of the contact and adapts it in rounds to von Mises's stress; its time is
that of all rounds. Large strains are solved by the project's own scripts, tuned or as the paper has them, or, of two bodies in the plane with
linear or quadratic cells, by `SLIDING`, in both forms.
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
# the same of `SLIDING`, with the most iterations of an increment; of `ironing` the increments until it slides
SLIDES = {
    ("discs", "tuned"): (3, 1e-5, 60),
    ("discs", "as the paper"): (5, 1e-3, 30),
    ("ironing", "tuned"): (1, 1e-5, 60),
    ("ironing", "as the paper"): (1, 1e-3, 30),
}


def applies(scene, mesh, setting):
    """Circles are known of round bodies, displacements are the same with all settings, and the scripts for large strains in space have linear cells.
    With one pass, rows between blocks are means by the functions of the upper side's nodes alone."""
    if SETTINGS[setting] is None:
        return (scene.name, setting) in SLIDES or mesh.degree == 1 and (scene.name, setting) in LARGE
    if setting == "adaptmesh":
        return scene.name in TARGETS
    if scene.name not in SMALL:
        return False
    if setting == "one pass":
        return scene.name == "blocks"
    if scene.name in CIRCLES and SETTINGS[setting][1]:
        return mesh.degree == 2
    return scene.measured == CONTACT or setting == "projected"


# small strains
STRAIN_2D = """
macro strain(u, v) [dx(u), dy(v), (dy(u) + dx(v)) / sqrt(2.)] //
macro div(u, v) (dx(u) + dy(v)) //
"""
STRAIN_3D = """
macro strain(u, v, w) [dx(u), dy(v), dz(w), (dy(u) + dx(v)) / sqrt(2.), (dz(u) + dx(w)) / sqrt(2.), (dz(v) + dy(w)) / sqrt(2.)] //
macro div(u, v, w) (dx(u) + dy(v) + dz(w)) //
"""
# four points of a side
GAUSS = """
real[int] gaussAt = [-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526];
real[int] gaussWeight = [0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538];
"""
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
"""
    + STRAIN_2D
    + """
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
NewMacro Adapted(Th, stress)
    Th = adaptmesh(Th, stress, err = err, iso = 1, hmin = 1e-6, nbvx = 500000, ratio = 1.8, abserror = 1);
EndMacro
"""

# The target of adaptmesh grows by `GROWTH` from a round to the one before it; the last mesh has the target itself.
ROUNDS, GROWTH = 8, 1.5
# the fineness of a scene's coarsest mesh, its target, and the power of the fineness by which it falls
TARGETS = {"half_disc": (4, 0.04, 1.5), "blocks": (4, 0.04, 1.5), "press_fit": (8, 0.08, 1)}

ADAPTED_DISC = (
    COMMON
    + VON_MISES
    + """
border left(t = pi, 3 * pi / 2) {{ x = cos(t); y = 1 + sin(t); label = 2; }}
border right(t = 3 * pi / 2, 2 * pi) {{ x = cos(t); y = 1 + sin(t); label = 1; }}
border east(t = 1, 0) {{ x = t; y = 1; label = 3; }}
border west(t = 0, -1) {{ x = t; y = 1; label = 4; }}
mesh Th = buildmesh(left(12) + right(12) + east(6) + west(6));
"""
    + STRAIN_2D
    + """
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
    Adapted(Th, stress)
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
"""
    + STRAIN_3D
    + """
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
    + VON_MISES
    + """
load "gmsh"
int[int] sidesI = [2, 1, 3, 4], sidesO = [2, 4, 3, 1];
mesh ThI = {first_mesh}, ThO = {second_mesh};
"""
    + STRAIN_2D
    + """
macro elastic(u, v, p, q) ((strain(u, v)' * strain(p, q)) / (1 + nu) + nu / ((1 + nu) * (1 - 2 * nu)) * div(u, v) * div(p, q)) //
"""
    + GAUSS
    + """
// the points of a slave's facets, and where the radius through them meets the other ring's polygon
func int points(mesh & Th, mesh & Other, real[int] & px, real[int] & py, real[int] & qx, real[int] & qy, real[int] & w)
{{
    int count = 0, others = 1;
    real radius = 0;
    real[int] ends(Other.nbe + 1);
    ends[0] = 0;
    for (int k = 0; k < Other.nbe; k++) if (Other.be(k).label == 1) {{
        real a = atan2(Other.be(k)[0].y, Other.be(k)[0].x), b = atan2(Other.be(k)[1].y, Other.be(k)[1].x);
        radius = hypot(Other.be(k)[0].x, Other.be(k)[0].y);
        ends[others++] = max(a, b);
    }}
    ends.resize(others);
    ends.sort;
    px.resize(4 * Th.nbe); py.resize(4 * Th.nbe); qx.resize(4 * Th.nbe); qy.resize(4 * Th.nbe); w.resize(4 * Th.nbe);
    for (int k = 0; k < Th.nbe; k++)
        if (Th.be(k).label == 1)
            for (int g = 0; g < 4; g++)
            {{
                real ax = Th(Th.be(k)[0]).x, ay = Th(Th.be(k)[0]).y, bx = Th(Th.be(k)[1]).x, by = Th(Th.be(k)[1]).y;
                real t = (1 + gaussAt[g]) / 2;
                px[count] = ax + t * (bx - ax); py[count] = ay + t * (by - ay);
                w[count] = hypot(bx - ax, by - ay) / 2 * gaussWeight[g];
                real angle = atan2(py[count], px[count]);
                int from = 0, to = others - 1;
                while (to > from + 1) {{ int half = (from + to) / 2; if (ends[half] <= angle) from = half; else to = half; }}
                real r = radius * cos((ends[to] - ends[from]) / 2) / cos(angle - (ends[from] + ends[to]) / 2);
                qx[count] = r * cos(angle); qy[count] = r * sin(angle);
                count++;
            }}
    px.resize(count); py.resize(count); qx.resize(count); qy.resize(count); w.resize(count);
    return count;
}}
int[int] I(0), J(0);
real[int] V(0), c0(0), clow(0);
int entry = 0, nI = 0;
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
// nodes of arcs onto their circles
NewMacro Rounded(Th, radius, contact)
{{
    fespace Mh(Th, P1);
    varf ofArc(p, q) = on(4, p = 1);
    varf ofContact(p, q) = on(1, p = 1);
    real[int] isArc = ofArc(0, Mh, tgv = 1), isContact = ofContact(0, Mh, tgv = 1);
    Mh toX = x, toY = y;
    for (int i = 0; i < Mh.ndof; i++) if (isArc[i] > 0 || isContact[i] > 0) {{
        real r = hypot(toX[][i], toY[][i]) / (isArc[i] > 0 ? radius : contact);
        toX[][i] /= r; toY[][i] /= r;
    }}
    Th = movemesh(Th, [toX, toY]);
}}
EndMacro
for (int round = 1; round <= {rounds}; round++) {{
    fespace VI(ThI, [P{degree}, P{degree}]);
    fespace VO(ThO, [P{degree}, P{degree}]);
    fespace SI(ThI, P{degree});
    fespace SO(ThO, P{degree});
    nI = VI.ndof;
    int n = nI + VO.ndof;
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
    real[int] pxI(1), pyI(1), qxI(1), qyI(1), wI(1), pxO(1), pyO(1), qxO(1), qyO(1), wO(1);
    points(ThI, ThO, pxI, pyI, qxI, qyI, wI);
    points(ThO, ThI, pxO, pyO, qxO, qyO, wO);
    int rows = SI.ndof + SO.ndof;
    I.resize(0); J.resize(0); V.resize(0); c0.resize(rows); clow.resize(rows);
    c0 = 0; clow = -1e19;
    entry = 0;
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
    if (round == {rounds}) {{
        real spent = clock() - start;
        ofstream out("{out}"), facets("{facets}");
        out.precision(17); facets.precision(17);
        out << status << " " << spent << " " << n - held.sum << endl;
        varf contact([u, v], [p, q]) = on(1, u = 1, v = 1);
        real[int] touches = contact(0, VI, tgv = 1);
        VI [across, across2] = [x, x], [height, height2] = [y, y];
        for (int i = 0; i < nI; i += 2) if (touches[i] > 0) {{
            real r = hypot(across[][i], height[][i]);
            out << across[][i] << " 0 " << height[][i] << " " << E * (force[i] * across[][i] + force[i + 1] * height[][i]) / r << endl;
        }}
        for (int k = 0; k < ThI.nbe; k++) if (ThI.be(k).label == 1) {{
            for (int j = 0; j < 2; j++) facets << ThI.be(k)[j].x << " " << ThI.be(k)[j].y << " ";
            facets << endl;
        }}
        break;
    }}
    VI [uI, vI]; VO [uO, vO];
    uI[] = u(0:nI - 1); uO[] = u(nI:n - 1);
    VonMises(ThI, uI, vI, stressI)
    VonMises(ThO, uO, vO, stressO)
    real err = {target} * {growth}^({rounds} - 1 - round);
    Adapted(ThI, stressI)
    Adapted(ThO, stressO)
    Rounded(ThI, {inside}, {middle} + {interference})
    Rounded(ThO, {outside}, {middle})
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
"""
    + STRAIN_3D
    + """
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
"""
    + STRAIN_2D
    + """
macro elastic(Th) int2d(Th)(scale * ((strain(u, v)' * strain(p, q)) / (1 + nu) + nu / ((1 + nu) * (1 - 2 * nu)) * div(u, v) * div(p, q))) //
real scale = 100;
int[int] I(0), J(0);
real[int] V(0), clow(0);
int entry = 0, rows = 0;
"""
    + GAUSS
    + """
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
    Adapted(Th0, stress0)
    Adapted(Th1, stress1)
    Adapted(Th2, stress2)
}}
"""
)

# energies of the bodies, over the lower one's modulus: by weak forms, as the paper has them,
WEAK_FORMS = """
int order = {degree} == 1 ? 1 : 5;
EnergyNeoHookean2(lower, Th0, V0, 1., {poisson}, order)
{upper_energy}
func real energy(real[int] & u)
{{
    real[int] u0 = u(0:n0 - 1), u1 = u(n0:n - 1);
    return lowerE(u0) + upperE(u1);
}}
func real[int] gradient(real[int] & u)
{{
    real[int] u0 = u(0:n0 - 1), u1 = u(n0:n - 1), g(n);
    g(0:n0 - 1) = lowerG(u0);
    g(n0:n - 1) = upperG(u1);
    return g;
}}
matrix H;
func matrix hessian(real[int] & u)
{{
    real[int] u0 = u(0:n0 - 1), u1 = u(n0:n - 1);
    lowerH(u0);
    upperH(u1);
    H = [[lowerK, 0], [0, upperK]];
    return H;
}}
func real smallestJ(real[int] & u) {{ return 1.; }}
"""
RIGID = """
NewMacro EnergyNone(name, Vh)
    real[int] name#Zero(Vh.ndof), name#One(Vh.ndof);
    name#Zero = 0; name#One = 1;
    func real name#E(real[int] & u) {{ return 0.; }}
    func real[int] name#G(real[int] & u) {{ return name#Zero; }}
    matrix name#K = name#One;
    func matrix name#H(real[int] & u) {{ return name#K; }}
EndMacro
EnergyNone(upper, V1)
"""
# or tuned, by array operations over the points of integration of all cells, one after another by the number of the point in its cell; nu = 0
ARRAYS = """
int isSoft = {is_rigid} ? 0 : 1, cells = Th0.nt + isSoft * Th1.nt;
int shapes = {degree} == 1 ? 3 : 6, rule = {degree} == 1 ? 1 : 6, points = rule * cells;
real[int, int] corner = [[0.445948490915965, 0.223381589678011], [0.091576213509771, 0.109951743655322]];
// the last entries of arrays for matrices give these their sizes
int[int] node(shapes * cells), pointOf(shapes * points + 1), nodeOf(shapes * points + 1);
real[int] slopeX(shapes * points + 1), slopeY(shapes * points + 1), weight(points);
pointOf[shapes * points] = points - 1; nodeOf[shapes * points] = n / 2 - 1;
slopeX[shapes * points] = 0; slopeY[shapes * points] = 0;
NewMacro Cells(Th, Sh, first, from, modulus)
    for (int k = 0; k < Th.nt; k++) {{
        real[int] gx(3), gy(3), l(3);
        for (int a = 0; a < shapes; a++) node[a * cells + first + k] = from + Sh(k, a);
        for (int a = 0; a < 3; a++) {{
            gx[a] = (Th[k][(a + 1) % 3].y - Th[k][(a + 2) % 3].y) / (2 * Th[k].area);
            gy[a] = (Th[k][(a + 2) % 3].x - Th[k][(a + 1) % 3].x) / (2 * Th[k].area);
        }}
        for (int q = 0; q < rule; q++) {{
            int p = q * cells + first + k;
            l = corner(q / 3, 0);
            l[q % 3] = 1 - 2 * corner(q / 3, 0);
            weight[p] = (modulus) / 2 * Th[k].area * (rule == 1 ? 1. : corner(q / 3, 1));
            for (int a = 0; a < shapes; a++) {{
                int i = (a + 1) % 3, j = (a + 2) % 3, e = a * points + p;
                real own = shapes == 3 ? 1. : 4 * l[a % 3] - 1;
                slopeX[e] = a < 3 ? own * gx[a] : 4 * (l[i] * gx[j] + l[j] * gx[i]);
                slopeY[e] = a < 3 ? own * gy[a] : 4 * (l[i] * gy[j] + l[j] * gy[i]);
                pointOf[e] = p; nodeOf[e] = node[a * cells + first + k];
            }}
        }}
    }}
EndMacro
Cells(Th0, S0, 0, 0, 1.)
if (isSoft) Cells(Th1, S1, Th0.nt, n0 / 2, {stiff})
matrix DX = [pointOf, nodeOf, slopeX], DY = [pointOf, nodeOf, slopeY];

// the state at u, kept until the next u: F, J, B = F^-T
real[int] uNow(n), F11(points), F12(points), F21(points), F22(points), J(points), t1(points), t2(points);
real[int] B11(points), B12(points), B21(points), B22(points);
bool isKnown = false;
real lastJ = -1;
func int state(real[int] & u)
{{
    if (isKnown) {{ real[int] d = u - uNow; if (d.linfty == 0) return 0; }}
    isKnown = true;
    uNow = u;
    real[int] ux = u(0:n - 1:2), uy = u(1:n:2);
    F11 = DX * ux; F12 = DY * ux; F21 = DX * uy; F22 = DY * uy;
    F11 += 1.; F22 += 1.;
    J = F11 .* F22; t1 = F12 .* F21; J -= t1;
    B11 = F22 ./ J; B22 = F11 ./ J; B12 = F21 ./ J; B21 = F12 ./ J;
    B12 *= -1.; B21 *= -1.;
    return 0;
}}
func real smallestJ(real[int] & u) {{ state(u); return J.min; }}
// no number for trials that nearly turn a cell inside out, by the last accepted iterate, where Ipopt asks for the gradient
func real energy(real[int] & u)
{{
    state(u);
    if (J.min <= 0 || J.min < 0.1 * lastJ) return NaN();
    t1 = F11 .* F11; t2 = F12 .* F12; t1 += t2; t2 = F21 .* F21; t1 += t2; t2 = F22 .* F22; t1 += t2;
    t1 -= 2.; t2 = log(J); t2 *= 2.; t1 -= t2; t1 *= 0.5;
    return weight' * t1;
}}
func real[int] gradient(real[int] & u)
{{
    state(u);
    lastJ = J.min;
    real[int] gx(n / 2), gy(n / 2), part(n / 2), g(n);
    t1 = F11 - B11; t1 .*= weight; gx = DX' * t1;
    t1 = F12 - B12; t1 .*= weight; part = DY' * t1; gx += part;
    t1 = F21 - B21; t1 .*= weight; gy = DX' * t1;
    t1 = F22 - B22; t1 .*= weight; part = DY' * t1; gy += part;
    g(0:n - 1:2) = gx;
    g(1:n:2) = gy;
    return g;
}}
// The lower triangle: of functions (a, i) and (c, k) the sum of weight [delta_ik g_a.g_c + b_c,i b_a,k], b_a = B g_a.
int local = 2 * shapes, entries = local * (local + 1) / 2 * cells;
matrix H, sum;
real[int] constant(entries), entryOf(entries), values(1);
{{
    int[int] I(entries + 1), K(entries + 1), at(entries + 1), all = 0:entries, I2(1), K2(1);
    real[int] one(entries + 1), V2(1);
    I[entries] = n - 1; K[entries] = n - 1;
    one = 1;
    constant = 0;
    int e = 0;
    for (int s = 0; s < local; s++) for (int t = 0; t <= s; t++) {{
        int a = s / 2, c = t / 2;
        for (int k = 0; k < cells; k++) {{
            int row = 2 * node[a * cells + k] + s % 2, column = 2 * node[c * cells + k] + t % 2;
            I[e + k] = max(row, column); K[e + k] = min(row, column);
        }}
        if (s % 2 == t % 2) for (int q = 0; q < rule; q++) {{
            int p = a * points + q * cells, r = c * points + q * cells;
            real[int] own = slopeX(p:p + cells - 1) .* slopeX(r:r + cells - 1), other = slopeY(p:p + cells - 1) .* slopeY(r:r + cells - 1);
            own += other;
            own .*= weight(q * cells:(q + 1) * cells - 1);
            constant(e:e + cells - 1) += own;
        }}
        e += cells;
    }}
    H = [I, K, one];
    // once more by rows: ff-Ipopt sorts a matrix that it is given, and coefficients set later would be misplaced
    [I2, K2, V2] = H;
    H = [I2, K2, V2];
    int size = H.nbcoef;
    values.resize(size);
    for (int c = 0; c < size; c++) values[c] = c + 1;
    H.coef = values;
    for (int c = 0; c <= entries; c++) at[c] = int(H(I[c], K[c]) + 0.5) - 1;
    all[entries] = entries - 1; one[entries] = 0;
    sum = [at, all, one];
}}
func matrix hessian(real[int] & u)
{{
    state(u);
    real[int, int] b(points, local), wb(points, local);
    for (int a = 0; a < shapes; a++) {{
        real[int] gx = slopeX(a * points:(a + 1) * points - 1), gy = slopeY(a * points:(a + 1) * points - 1);
        t1 = B11 .* gx; t2 = B12 .* gy; t1 += t2; b(:, 2 * a) = t1; t1 .*= weight; wb(:, 2 * a) = t1;
        t1 = B21 .* gx; t2 = B22 .* gy; t1 += t2; b(:, 2 * a + 1) = t1; t1 .*= weight; wb(:, 2 * a + 1) = t1;
    }}
    entryOf = constant;
    int e = 0;
    for (int s = 0; s < local; s++) for (int t = 0; t <= s; t++) {{
        t1 = b(:, t / 2 * 2 + s % 2) .* wb(:, s / 2 * 2 + t % 2);
        for (int q = 0; q < rule; q++) entryOf(e:e + cells - 1) += t1(q * cells:(q + 1) * cells - 1);
        e += cells;
    }}
    values = sum * entryOf;
    H.coef = values;
    return H;
}}
"""

# Two neo-Hookean bodies, or one and a rigid one, by the project's weak forms and rows. The boundary of quadratic cells is cut into pieces, whose rows
# are summed with the linear functions of corners; middles of sides are on the circles, but cells keep straight sides.
SLIDING = """
include "run.idp"
include "energies.idp"
include "contact2d.idp"
load "gmsh"
real start = clock();
mesh Th0 = gmshload("{lower}"), Th1 = gmshload("{upper}");
fespace V0(Th0, [P{degree}, P{degree}]); fespace V1(Th1, [P{degree}, P{degree}]);
fespace S0(Th0, P{degree}); fespace S1(Th1, P{degree});
int n0 = V0.ndof, n = n0 + V1.ndof, pieces = {degree} == 1 ? 1 : 4;
{energy}
// places of all nodes, with those of the rounded sides on their circles
real[int] places(n);
NewMacro Places(Vh, Th, label, from, mx, my, radius)
{{
    Vh [px, py] = [x, y];
    varf sides([u, v], [p, q]) = on(label, u = 1, v = 1);
    real[int] isOn = sides(0, Vh, tgv = 1);
    for (int i = 0; i < Vh.ndof; i += 2) {{
        real r = hypot(px[][i] - (mx), px[][i + 1] - (my));
        if (isOn[i] > 0 && (radius) > 0) {{
            px[][i] = (mx) + (px[][i] - (mx)) * (radius) / r;
            px[][i + 1] = (my) + (px[][i + 1] - (my)) * (radius) / r;
        }}
        places[from + i] = px[][i]; places[from + i + 1] = px[][i + 1];
    }}
}}
EndMacro
Places(V0, Th0, {lower_label}, 0, 0., 0., {lower_radius})
Places(V1, Th1, {upper_label}, n0, {middle}, {height}, {upper_radius})

// Cuts the segments of a label into pieces, whose ends have numbers from `first` on, in the order of the rows of `ContactPair`. Returns the number
// after the last one, places of the ends at rest, and the values of the linear functions of corners at the ends, a row a corner from `corner` on.
func int cut(mesh & Th, int label, int first, real[int] & ex, real[int] & ey, int[int] & a, int[int] & b,
    int & corner, int[int] & I, int[int] & J, real[int] & V)
{{
    int[int] ca(1), cb(1), ra(1), rb(1);
    contactPolygon(Th, label, 0, ca, cb);
    // Gmsh's curves may have the body on the right
    int side = 0;
    for (int k = 0; k < Th.nbe; k++) if (Th.be(k).label == label) {{
        int p = ca[side], q = cb[side], cell = Th.be(k).Element;
        real turn = 0;
        for (int j = 0; j < 3; j++) turn += (Th(q).x - Th(p).x) * (Th[cell][j].y - Th(p).y) - (Th(q).y - Th(p).y) * (Th[cell][j].x - Th(p).x);
        if (turn < 0) {{ ca[side] = q; cb[side] = p; }}
        side++;
    }}
    int corners = contactPolygonRows(ca, cb, Th.nv, 0, ra, rb), next = first, entry = I.n;
    int[int] number(corners);
    number = -1;
    a.resize(ca.n * pieces); b.resize(ca.n * pieces);
    ex.resize(corners + ca.n * pieces); ey.resize(ex.n);
    I.resize(entry + 2 * ca.n * pieces + corners); J.resize(I.n); V.resize(I.n);
    for (int k = 0; k < ca.n; k++) for (int j = 0; j <= pieces; j++) {{
        real t = real(j) / pieces;
        bool isEnd = j == 0 || j == pieces;
        int own = j == 0 ? ra[k] : rb[k], at = isEnd ? number[own] : -1;
        if (at < 0) {{
            at = next++;
            ex[at - first] = (1 - t) * Th(ca[k]).x + t * Th(cb[k]).x;
            ey[at - first] = (1 - t) * Th(ca[k]).y + t * Th(cb[k]).y;
            if (isEnd) {{ number[own] = at; I[entry] = corner + own; J[entry] = at; V[entry++] = 1; }}
            else {{
                I[entry] = corner + ra[k]; J[entry] = at; V[entry++] = 1 - t;
                I[entry] = corner + rb[k]; J[entry] = at; V[entry++] = t;
            }}
        }}
        if (j < pieces) a[k * pieces + j] = at;
        if (j > 0) b[k * pieces + j - 1] = at;
    }}
    corner += corners;
    ex.resize(next - first); ey.resize(next - first);
    I.resize(entry); J.resize(entry); V.resize(entry);
    return next;
}}
int corners = 0;
int[int] a0(1), b0(1), a1(1), b1(1), gI(0), gJ(0), tI(0), tJ(0);
real[int] x0(1), y0(1), x1(1), y1(1), gV(0), tV(0);
int ends0 = cut(Th0, {lower_label}, 0, x0, y0, a0, b0, corners, gI, gJ, gV);
int ends = cut(Th1, {upper_label}, ends0, x1, y1, a1, b1, corners, gI, gJ, gV);
matrix G = [gI, gJ, gV];
// from displacements to those of ends
func int enter(matrix & A, int row, int column)
{{
    int[int] i(1), j(1); real[int] v(1);
    [i, j, v] = A;
    int entry = tI.n;
    tI.resize(entry + 2 * i.n); tJ.resize(tI.n); tV.resize(tI.n);
    for (int k = 0; k < i.n; k++) if (abs(v[k]) > 1e-12) for (int c = 0; c < 2; c++) {{
        tI[entry] = row + 2 * j[k] + c; tJ[entry] = column + 2 * i[k] + c; tV[entry++] = v[k];
    }}
    tI.resize(entry); tJ.resize(entry); tV.resize(entry);
    return 0;
}}
matrix at0 = interpolate(S0, x0, y0), at1 = interpolate(S1, x1, y1);
enter(at0, 0, 0);
enter(at1, 2 * ends0, n0);
// the last entry gives the matrix its size
tI.resize(tI.n + 1); tJ.resize(tI.n); tV.resize(tI.n);
tI[tI.n - 1] = 2 * ends - 1; tJ[tI.n - 1] = n - 1; tV[tI.n - 1] = 0;
matrix T = [tI, tJ, tV];
real[int] X = T * places;
ContactPair(both, a0, b0, a1, b1, X, {reach})

real[int] held(n), low(n), high(n), prescribed(n), u(n), before(n), last(n), change(n), lastChange(n), lastFound(n);
real[int] c0(corners), clow(corners), lm(corners), lz(n), uz(n), area(1);
varf holds0([u, v], [p, q]) = on({lower_held}, u = 1, v = 1);
varf holds1([u, v], [p, q]) = on({upper_held}, u = 1, v = 1);
held(0:n0 - 1) = holds0(0, V0, tgv = 1);
held(n0:n - 1) = holds1(0, V1, tgv = 1);
if ({is_rigid}) held(n0:n - 1) = 1.;
matrix C, R;
// rows with the projections of the displacements
func int linearise()
{{
    real[int] now = u + places, at = T * now;
    bothRows(at, R, area);
    real[int] whole = G * area, over(corners);
    for (int i = 0; i < corners; i++) {{ over[i] = whole[i] > 0 ? 1 / whole[i] : 1.; clow[i] = whole[i] > 0 ? 0. : -1.; }}
    matrix A = area, O = over;
    C = R * T;
    C = A * C;
    C = G * C;
    C = O * C;
    c0 = C * places;
    return 0;
}}
string cold = "cold.opt", guess = "guess.opt", warm = "warm.opt";
runIpoptOptions(cold, 1e-10, false, 0);
runIpoptOptions(guess, 1e-10, true, 1e-4);
runIpoptOptions(warm, 1e-10, true, 1e-9);
func int minimise(string options, int isWarm)
{{
    int status = -1;
    if (isWarm) {{
        status = IPOPT(energy, gradient, hessian, [C, c0], u, lb = low, ub = high, clb = clow, lm = lm, lz = lz, uz = uz, warmstart = 1,
            checkindex = 0, optfile = options);
        runIpoptCount();
        if (status == 0) return 0;
        u = last;
    }}
    lm = 0; lz = 0; uz = 0;
    status = IPOPT(energy, gradient, hessian, [C, c0], u, lb = low, ub = high, clb = clow, lm = lm, lz = lz, uz = uz, checkindex = 0, optfile = cold);
    runIpoptCount();
    return status;
}}
real[int, int] way = {way};
int converged = 1, fixedPoints = 0;
real mean = 0;
u = 0; before = 0; lm = 0; lz = 0; uz = 0;
for (int step = 0; step < way.n; step++)
{{
    real dx = way(step, 0) - (step > 0 ? way(step - 1, 0) : 0.), dy = way(step, 1) - (step > 0 ? way(step - 1, 1) : 0.);
    real[int] old = u;
    // the upper body moves as it is held; if the way is straight and states are extrapolated, so do the rest
    bool isStraight = step > 0 && {is_tuned};
    if (isStraight) {{
        real ex = way(step - 1, 0) - (step > 1 ? way(step - 2, 0) : 0.), ey = way(step - 1, 1) - (step > 1 ? way(step - 2, 1) : 0.);
        isStraight = abs(ex * dy - ey * dx) < 1e-12 && ex * dx + ey * dy > 0;
    }}
    real was = smallestJ(u);
    if (isStraight) {{ u = 2 * old - before; isStraight = smallestJ(u) > 0.1 * was; }}
    if (!isStraight) u = old;
    if (!isStraight) for (int i = n0; i < n; i += 2) {{ u[i] += dx; u[i + 1] += dy; }}
    before = old;
    prescribed = 0;
    for (int i = n0; i < n; i += 2) {{ prescribed[i] = way(step, 0); prescribed[i + 1] = way(step, 1); }}
    for (int i = 0; i < n; i++) {{ low[i] = held[i] > 0 ? prescribed[i] : -1e19; high[i] = held[i] > 0 ? prescribed[i] : 1e19; }}
    real error = 1;
    int k = 0, status = 0;
    for (k = 0; k < {iterations} && error >= {tolerance}; k++)
    {{
        linearise();
        last = u;
        string options = warm;
        if (error > 1e-4) options = guess;
        status = minimise(options, {is_tuned} && step + k > 0);
        change = u - last;
        error = status == 0 ? change.linfty / max(u.linfty, last.linfty) : 1.;
        // Anderson's acceleration of depth 1
        real[int] now = u;
        if ({is_tuned} && k > 0 && error >= {tolerance}) {{
            real[int] other = change - lastChange, move = u - lastFound;
            real share = other' * change;
            share /= other' * other;
            u -= share * move;
            if (smallestJ(u) < 0.1 * smallestJ(now)) u = now;
        }}
        lastChange = change; lastFound = now;
    }}
    fixedPoints += k;
    if (error >= {tolerance}) converged = 0;
    real[int] r = gradient(u);
    real force = 0;
    for (int i = 1; i < n0; i += 2) if (held[i] > 0) force += {young} * r[i];
    if (step >= way.n - {places}) mean += force / {places};
    cout << "increment " << step + 1 << ": " << k << " iterations, change " << error << ", force " << force << endl;
}}
ofstream result("{out}");
result.precision(17);
result << "seconds_total " << clock() - start << endl << "reaction_y " << mean << endl << "unknowns " << n - held.sum << endl;
result << "converged " << converged << endl;
result << "fixed_point_iterations " << fixedPoints << endl << "ipopt_iterations " << runIpoptIterations << endl;
"""

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


def solve_sliding(scene, mesh, setting):
    """Processor time (s) of `SLIDING`, by its own clock, unknowns, and the mean of the forces that are measured."""
    increments, tolerance, iterations = SLIDES[scene.name, setting]
    straight = mesh if mesh.degree == 1 else scene.mesh(mesh.path.parent, mesh.fineness, 1)
    folder = mesh.path.with_name(f"{mesh.path.stem}_{setting.replace(' ', '_')}")
    folder.mkdir(exist_ok=True)
    out = folder / "result.txt"
    out.unlink(missing_ok=True)
    names = dict(
        lower=straight.other.path, upper=straight.path, degree=mesh.degree, poisson=scene.poisson, out=out, is_tuned=int(setting == "tuned"),
        tolerance=tolerance, iterations=iterations, young=scene.young, stiff=1.0,
    )
    if scene.name == "discs":
        radius, inside, _ = scene.radii
        names |= dict(
            lower_label=CONTACT, upper_label=CONTACT, lower_held=scene.outside, upper_held=CONTACT, is_rigid=1, places=1,
            lower_radius=inside, upper_radius=radius, middle=0.0, height=0.0, upper_energy=RIGID.format(), reach=scene.descent / 2,
        )
        way = [(0.0, -scene.descent * k / increments) for k in range(1, increments + 1)]
    else:
        names |= dict(
            lower_label=scene.top, upper_label=scene.bottom, lower_held=scene.bottom, upper_held=scene.top, is_rigid=0, places=scene.places,
            lower_radius=0.0, upper_radius=scene.radius, middle=scene.middle, height=scene.zone + scene.radius, reach=scene.zone / 3,
        )
        names["stiff"] = scene.stiff / scene.young
        names["upper_energy"] = "EnergyNeoHookean2(upper, Th1, V1, {stiff}, {poisson}, order)".format(**names)
        way = [(0.0, -scene.press * k / increments) for k in range(1, increments + 1)]
        way += [(scene.slide * k / scene.places, -scene.press) for k in range(1, scene.places + 1)]
    names["way"] = "[" + ", ".join(f"[{across!r}, {up!r}]" for across, up in way) + "]"
    names["energy"] = (ARRAYS if setting == "tuned" else WEAK_FORMS).format(**names)
    script = folder / "script.edp"
    script.write_text(SLIDING.format(**names))
    command = ["FreeFem++", "-nw", "-ne", "-v", "0", str(script)]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=LIMIT, env=ENVIRONMENT)
    if not out.exists():
        return {"cpu": None, "unknowns": None, "failure": "the script failed", "values": None, "log": run.stdout[-2000:]}
    found = dict(line.split() for line in out.read_text().splitlines())
    return {
        "cpu": float(found["seconds_total"]),
        "unknowns": int(float(found["unknowns"])),
        "failure": None if found["converged"] == "1" else "increments did not converge",
        "values": None,
        **({"scalar": abs(float(found["reaction_y"]))} if found["converged"] == "1" else {}),
    }


def solve(scene, mesh, setting):
    """Processor time (s) of the script, unknowns, and the pressure on the contact boundary, or how far a loaded face comes down."""
    if mesh.degree == 1 and (scene.name, setting) in LARGE:
        return solve_large(scene, mesh, setting)
    if (scene.name, setting) in SLIDES:
        return solve_sliding(scene, mesh, setting)
    straight = mesh if mesh.degree == 1 else scene.mesh(mesh.path.parent, mesh.fineness, 1)
    out = mesh.path.with_name(mesh.path.stem + "_freefem.txt")
    options = out.with_suffix(".opt")
    is_adapted = setting == "adaptmesh"
    facets_file = out.with_suffix(".facets")
    options.write_text(OPTIONS if scene.name == "beams" else TIGHT)
    names = dict(
        young=scene.young, poisson=scene.poisson, mesh=straight.path, degree=mesh.degree, out=out, options=options,
        force=getattr(scene, "force", getattr(scene, "traction", 0.0)), descent=getattr(scene, "descent", 0.0),
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
    names.update(zip(("inside", "middle", "outside"), getattr(scene, "radii", ())))
    if is_adapted and scene.name == "blocks":
        for key, low, wide in zip(("third_mesh", "second_mesh", "first_mesh"), range(3), scene.widths):
            names[key] = f"square({max(2, round(4 * wide))}, 4, [{wide} * x, y + {low}], label = sides)"
    if is_adapted and scene.name == "press_fit":
        for key, low, high, around, sides in (
            ("first_mesh", scene.radii[0], scene.radii[1] + scene.interference, 12, "sidesI"), ("second_mesh", *scene.radii[1:], 10, "sidesO"),
        ):
            radius = f"({low} + {high - low} * x)"
            names[key] = f"square(4, {around}, [{radius} * cos(pi / 2 * y), {radius} * sin(pi / 2 * y)], label = {sides})"
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

"""GetFEM on the scenes at the limits: the augmented Lagrangian and the semismooth Newton method, the slave is the softer or the finer body.

Points that face each other are found by GetFEM's raytracing transformation, at small strains once for all, at rest. The setting with the
brick takes the integral contact brick between meshes in place of this where strains are small. Prescribed displacements have multipliers,
which are the reactions. A body that supports do not hold has tiny springs to the ground everywhere, and its contacts start closed.

In space, GetFEM takes nodes for one that are closer than 2e-4 of the size of their cells.
"""

import getfem as gf
import numpy as np
from scipy.spatial import cKDTree

from cases import result
from getfem_peer import Pair, followed, version  # noqa: F401

NAME = "GetFEM"
# the parameter of the augmentation in units of E/h of the softer body, and whether small strains have the brick
SETTINGS = {"r = E/h": (1.0, False), "r = 10 E/h": (10.0, False), "r = E/h, brick": (1.0, True)}
# the stiffness of the springs to the ground per volume, at small and at large strains
SPRING = {True: 1e-10, False: 1e-7}
# the largest shares of the largest reaction that they may take, along the load of a body and across it
SPRINGS_SHARE = {"along": 1e-6, "across": 1e-4}
# the pieces of an edge for the integration of contact terms
PIECES = {2: 4, 3: 1}
# what a start presses, in units of E
START = 1e-6


def applies(case, setting):
    """Whether a setting differs from the settings before it."""
    return not SETTINGS[setting][1] or case.is_linear()


def grid_of(body):
    """A body's mesh with a region for each label."""
    dimension = body.dimension
    is_curved = body.degree == 2 and not body.is_straight
    grid = gf.Mesh("empty", dimension)
    shape = gf.GeoTrans(f"GT_PK({dimension},{2 if is_curved else 1})")
    count = dimension + 1
    # where GetFEM has the nodes of a cell: corners, or its rows of a lattice
    order = list(range(count))
    if is_curved:
        order = {2: [0, 3, 1, 5, 4, 2], 3: [0, 4, 1, 6, 5, 2, 7, 9, 8, 3]}[dimension]
    corners = [k for k, node in enumerate(order) if node < count]
    sides = {}
    for cell in body.cells:
        convex = int(np.ravel(grid.add_convex(shape, body.nodes[cell[order]].T))[0])
        for face, nodes in enumerate(faces(grid, convex, count, corners)):
            sides[frozenset(int(cell[order[k]]) for k in nodes)] = (convex, face)
    for label, facets in body.facets.items():
        grid.set_region(label, np.array([sides[frozenset(facet)] for facet in facets.tolist()]).T)
    return grid


def faces(grid, convex, count, corners, known={}):
    """For each face of a cell, which of the places in the cell are its corners."""
    key = (count, len(corners), tuple(corners))
    if key not in known:
        own = grid.pid_in_cvids(convex).tolist()
        found = []
        for face in range(count):
            on = set(np.ravel(grid.pid_in_faces(np.array([[convex], [face]]))).tolist())
            found.append([k for k in corners if own[k] in on])
        known[key] = found
    return known[key]


class Merged(ValueError):
    """GetFEM takes nodes of flat cells for one."""


class Body:
    """A body in a model, with what a pair asks of it."""

    def __init__(self, model, name, body):
        self.name, self.body, self.dimension = name, body, body.dimension
        self.grid = grid_of(body)
        self.fem, self.pressures = gf.MeshFem(self.grid, self.dimension), gf.MeshFem(self.grid, 1)
        for fem in (self.fem, self.pressures):
            fem.set_fem(gf.Fem(f"FEM_PK({self.dimension},{body.degree})"))
        rule = "IM_TRIANGLE(6)" if self.dimension == 2 else "IM_TETRAHEDRON(6)"
        self.inside = gf.MeshIm(self.grid, gf.Integ(rule))
        # of contact terms: nodes of the other surface lie between the nodes of a facet
        self.points = gf.MeshIm(self.grid, gf.Integ(f"IM_STRUCTURED_COMPOSITE({rule},{PIECES[self.dimension]})"))
        self.jacobians = gf.MeshFem(self.grid, 1)
        self.jacobians.set_fem(gf.Fem(f"FEM_PK_DISCONTINUOUS({self.dimension},{body.degree - 1})"))
        model.add_fem_variable(name, self.fem)
        self.gradient = f"(Id({self.dimension}) + Grad_{name})"
        first, shear = body.lame()
        model.add_initialized_data(f"first_{name}", [first])
        model.add_initialized_data(f"shear_{name}", [shear])
        if body.is_linear:
            model.add_isotropic_linearized_elasticity_brick(self.inside, name, f"first_{name}", f"shear_{name}")
        else:
            inverse = f"Inv({self.gradient})'"
            model.add_nonlinear_term(
                self.inside,
                f"(shear_{name} * ({self.gradient} - {inverse}) + first_{name} * log(Det({self.gradient})) * {inverse}):Grad_Test_{name}",
                -1, 1, 1,
            )
        places = cKDTree(self.fem.basic_dof_nodes()[:, :: self.dimension].T)
        apart, found = places.query(body.nodes)
        if apart.max() > 1e-6 or len(set(found.tolist())) < len(found):
            raise Merged(f"GetFEM has {len(set(found.tolist()))} places for {len(found)} nodes")
        self.first_dof = self.dimension * found
        self.is_free = not body.is_held()
        if self.is_free:
            model.add_initialized_data(f"spring_{name}", [SPRING[body.is_linear]])
            model.add_linear_term(self.inside, f"spring_{name} * {name}.Test_{name}")
        self.prepare_supports(model)
        self.dead = np.zeros(self.fem.nbdof())
        for a, i, value in body.forces:
            self.dead[self.first_dof[a] + i] += value
        if body.forces:
            self.brick = model.add_explicit_rhs(name, 0 * self.dead)

    def prepare_supports(self, model):
        """Gives each prescribed displacement a multiplier."""
        given = {(self.first_dof[a] + i): (i, value) for a, i, value in self.body.prescribed}
        self.axes = np.array([i for i, _ in given.values()], dtype=int)
        self.way = np.array([value for _, value in given.values()])
        if given:
            whole = gf.Spmat("identity", self.fem.nbdof())
            chosen = gf.Spmat("copy", whole, np.array(list(given)), np.arange(self.fem.nbdof()))
            model.add_variable(f"support_{self.name}", len(given))
            model.add_initialized_data(f"way_{self.name}", 0 * self.way)
            model.add_constraint_with_multipliers(self.name, f"support_{self.name}", chosen, f"way_{self.name}")

    def load(self, model, place):
        """Sets a share of the load."""
        if len(self.way):
            model.set_variable(f"way_{self.name}", place * self.way)
        if self.body.forces:
            model.set_private_rhs(self.brick, place * self.dead)

    def reaction(self, model):
        """The sum of the forces of the supports."""
        if len(self.way) == 0:
            return np.zeros(self.dimension)
        return -np.bincount(self.axes, weights=model.variable(f"support_{self.name}"), minlength=self.dimension)

    def of_springs(self, model):
        """The forces of the springs along the load of the body and across it."""
        if not self.is_free:
            return {"along": 0.0, "across": 0.0}
        force = gf.asm_generic(self.inside, 0, f"spring_{self.name} * {self.name}", -1, model)
        load = self.dead.reshape(-1, self.dimension).sum(axis=0)
        along = load @ force / max(np.linalg.norm(load), 1e-300)
        return {"along": abs(along), "across": np.sqrt(max(0.0, force @ force - along**2))}

    def intact(self, model):
        """Whether no cell is turned inside out."""
        return self.body.is_linear or model.interpolation(f"Det({self.gradient})", self.jacobians).min() > 0


def reach(case, pair):
    """The distance in which contact is found: less than a body is thick; at small strains as far as bodies are apart."""
    most = case.reach(pair)
    if not case.is_linear():
        return most
    one, two = (case.bodies[b].nodes[np.unique(case.bodies[b].facets[own])] for b, own in (pair.slave, pair.master))
    return max(most, 1.5 * cKDTree(two).query(one)[0].min())


def gaps_at_rest(model, name, slave, multiplier, region):
    """The gaps of a pair at rest, where something faces it, by degrees of freedom of its multiplier; and the least mean gap about one."""
    first, count = (int(x) for x in model.interval_of_variable(name))
    rays = f"rays_{name}"
    means, facing = (
        gf.asm_generic(slave.points, 1, f"Interpolate_filter({rays}, {term}*Test_{name}, 1)", region, model)[first : first + count]
        for term in (f"((Interpolate(X, {rays}) - X).Normal)", "1")
    )
    gaps = np.linalg.solve(gf.asm_mass_matrix(slave.points, multiplier, multiplier, region).full(), means)
    seen = facing > 1e-6 * abs(facing).max(initial=0.0)
    return gaps, (means[seen] / facing[seen]).min(initial=np.inf)


def newton(case):
    """Newton's method by full steps, unless the residual becomes very large; the tolerance is above rounding where moduli differ."""
    stiff = max(body.young for body in case.bodies)
    tolerance = max(1e-9, 1e-14 * stiff)
    most = 100 if case.is_linear() else 30

    def solved(model):
        solved.why = ""
        try:
            return model.solve(
                "max_res", tolerance, "max_iter", most, "lsolver", "mumps", "lsearch", "simplest", "alpha max ratio", 1e3
            )
        except RuntimeError as error:
            solved.why = " ".join(str(error).split())
            return 0, False

    return solved


def solve(case, setting, folder):
    """How a run of a case went."""
    gf.util("trace level", 0)
    gf.util("warning level", 0)
    parameter, is_brick = SETTINGS[setting]
    if case.is_linear() != any(body.is_linear for body in case.bodies):
        return result("not expressed", "both laws in one case", 0.0)
    if is_brick and case.initial_gaps == "adjust":
        return result("not expressed", "the brick knows no overlap that stays", 0.0)
    model = gf.Model("real")
    try:
        bodies = [Body(model, f"u{k}", body) for k, body in enumerate(case.bodies)]
    except Merged as error:
        return result("not expressed", str(error), 0.0)
    if case.is_linear():
        for body in bodies:
            model.add_initialized_fem_data(f"zero_{body.name}", body.fem, np.zeros(body.fem.nbdof()))
    # the share of an overlap at the start that is not to be pushed apart
    model.add_initialized_data("spared", [1.0])
    for k, pair in enumerate(case.pairs):
        in_contact(case, model, f"p{k}", pair, bodies, parameter, is_brick)
    return run(case, model, bodies)


def in_contact(case, model, name, pair, bodies, parameter, is_brick):
    """Adds the contact of a pair of surfaces."""
    (slave, region), (master, facing) = pair.slave, pair.master
    a, b, r = bodies[slave], bodies[master], f"r_{name}"
    model.add_initialized_data(r, [parameter * pair.stiffness])
    multiplier = gf.MeshFem("partial", a.pressures, a.pressures.basic_dof_on_region(region))
    pressed = START * pair.young * np.ones(multiplier.nbdof())
    if is_brick:
        model.add_fem_variable(name, multiplier)
        model.add_integral_contact_between_nonmatching_meshes_brick(a.points, a.name, b.name, name, r, region, facing)
    else:
        still = (f"zero_{a.name}", f"zero_{b.name}") if case.is_linear() else None
        overlaps = case.initial_gaps in ("resolve", "adjust")
        if overlaps:
            model.add_initialized_fem_data(f"overlap_{name}", multiplier, np.zeros(multiplier.nbdof()))
        spared = f"spared*overlap_{name}" if overlaps else ""
        Pair(model, name, a, region, b, facing, reach(case, pair), still, spared, r, is_balanced=True)
        gaps, least = gaps_at_rest(model, name, a, multiplier, region)
        if overlaps:
            model.set_variable(f"overlap_{name}", np.minimum(gaps, 0.0))
        if a.is_free or b.is_free:
            # closed where it is closest
            pressed += 1.1 * parameter * pair.stiffness * (max(0.0, least) if np.isfinite(least) else 0.0)
    model.set_variable(name, -pressed)


def run(case, model, bodies):
    """Goes to the full load."""

    def load(place):
        for body in bodies:
            body.load(model, place)
        model.set_variable("spared", [1.0 if case.initial_gaps == "adjust" else 1.0 - place])

    steps = case.steps()
    solved, done = newton(case), 0.0
    try:
        for done, _ in followed(model, bodies, load, [(k + 1) / steps for k in range(steps)], solved=solved):
            pass
    except ArithmeticError as error:
        return result("not converged", f"{error} {solved.why}", done)
    reactions = [body.reaction(model) for body in bodies]
    largest = max(float(np.linalg.norm(force)) for force in reactions)
    for body in bodies:
        for way, force in body.of_springs(model).items():
            if force > SPRINGS_SHARE[way] * largest:
                taken = f"springs to the ground take {force / max(largest, 1e-300):.1e} of the reaction {way} the load"
                return result("not converged", taken)
    return result("complete", "", 1.0, case.with_units(reactions))

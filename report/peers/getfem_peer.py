"""GetFEM: the integral augmented Lagrangian against a rigid obstacle or between two meshes, by the semismooth Newton method.

The multiplier has the degree of the displacement, or is linear with quadratic cells. r is the parameter of the augmentation. At large
strains GetFEM's raytracing transformation finds the points that face each other.
"""

import time

import getfem as gf
import numpy as np

from scenes import CONTACT

NAME = "GetFEM"
# the parameter of the augmentation in units of E (of stacks and at large strains of E / scene.zone), the largest degree of the multiplier
SETTINGS = {"r = E/10": (0.1, 2), "r = E": (1.0, 2), "r = 10 E": (10.0, 2), "r = E, linear multiplier": (1.0, 1)}
# settings that gain nothing in a scene
SPARED = {
    "blocks": ("r = E/10",),
    "finite_beams": ("r = E/10",),
    "discs": ("r = E/10",),
    "ironing": ("r = E/10",),
}


def applies(scene, mesh, setting):
    """Whether a setting differs from the settings before it, and is of use in a scene."""
    return setting not in SPARED.get(scene.name, ()) and (mesh.degree == 2 or SETTINGS[setting][1] == 2)


def solve(scene, mesh, setting):
    """Processor time (s), unknowns, and what a scene measures: pressures or displacements at nodes, or a force."""
    gf.util("trace level", 0)
    gf.util("warning level", 0)
    began = time.process_time()
    if scene.name in ("beams", "blocks"):
        return stacked(scene, mesh, setting, began)
    if scene.name in ("finite_beams", "discs", "ironing"):
        return sliding(scene, mesh, setting, began)
    dimension, degree, label = mesh.dimension, mesh.degree, CONTACT
    grid = gf.Mesh("import", "gmsh", str(mesh.path))
    displacement, scalar, pressures = gf.MeshFem(grid, dimension), gf.MeshFem(grid, 1), gf.MeshFem(grid, 1)
    for fem in (displacement, scalar):
        fem.set_fem(gf.Fem(f"FEM_PK({dimension},{degree})"))
    pressures.set_fem(gf.Fem(f"FEM_PK({dimension},{min(degree, SETTINGS[setting][1])})"))
    kept = pressures.basic_dof_on_region(label)
    multiplier = gf.MeshFem("partial", pressures, kept)
    rule = "IM_TRIANGLE(6)" if dimension == 2 else "IM_TETRAHEDRON(6)"
    points = gf.MeshIm(grid, gf.Integ(rule))
    E, nu = scene.young, scene.poisson
    if mesh.other:
        return fitted(scene, mesh, setting, (began, grid, displacement, pressures, kept, multiplier, points))
    model = gf.Model("real")
    model.add_fem_variable("u", displacement)
    model.add_fem_variable("p", multiplier)
    model.add_initialized_data("lame", [E * nu / ((1 + nu) * (1 - 2 * nu))])
    model.add_initialized_data("shear", [E / (2 * (1 + nu))])
    model.add_isotropic_linearized_elasticity_brick(points, "u", "lame", "shear")
    if scene.name == "half_disc":
        model.add_initialized_data("traction", [0, -scene.force / 2])
        model.add_source_term_brick(points, "u", "traction", scene.top)
        model.add_initialized_data("held", [0, 0, 0, 1])
        model.add_initialized_data("sideways", [1, 0, 1, 0])
        model.add_pointwise_constraints_with_multipliers("u", "held", "sideways")
    else:
        for axis, region, value in ((1, 2, 0.0), (0, 3, 0.0), (2, scene.top, -scene.descent)):
            held = np.zeros((3, 3))
            held[axis, axis] = 1
            model.add_initialized_data(f"held{axis}", held)
            model.add_initialized_data(f"value{axis}", value * np.eye(3)[axis])
            model.add_generalized_Dirichlet_condition_with_multipliers(
                points, "u", displacement, region, f"value{axis}", f"held{axis}"
            )
    heights = scalar.basic_dof_nodes()[dimension - 1]
    model.add_initialized_fem_data("height", scalar, heights)
    model.add_initialized_data("r", [SETTINGS[setting][0] * E])
    model.add_integral_contact_with_rigid_obstacle_brick(points, "u", "p", "height", "r", label, 1)
    # a start a little inside, so that the first step has something to push against
    start = np.zeros((displacement.nbdof() // dimension, dimension))
    start[:, -1] = -1e-3 * scene.zone
    model.set_variable("u", start.ravel())
    iterations = model.solve("max_res", 1e-9, "max_iter", 100, "lsolver", "mumps")[0]
    return found(mesh, model, (pressures, kept), iterations, time.process_time() - began)


def fitted(scene, mesh, setting, parts):
    """The same of two rings, of which the inner one has the multiplier."""
    began, grid, displacement, pressures, kept, multiplier, points = parts
    E, nu = scene.young, scene.poisson
    around = gf.Mesh("import", "gmsh", str(mesh.other.path))
    other = gf.MeshFem(around, 2)
    other.set_fem(gf.Fem(f"FEM_PK(2,{mesh.degree})"))
    model = gf.Model("real")
    model.add_initialized_data("lame", [E * nu / ((1 + nu) * (1 - 2 * nu))])
    model.add_initialized_data("shear", [E / (2 * (1 + nu))])
    model.add_initialized_data("r", [SETTINGS[setting][0] * E])
    for name, fem, own in (("u", displacement, points), ("w", other, gf.MeshIm(around, gf.Integ("IM_TRIANGLE(6)")))):
        model.add_fem_variable(name, fem)
        model.add_isotropic_linearized_elasticity_brick(own, name, "lame", "shear")
        for axis, region in ((1, 2), (0, 3)):
            held = np.zeros((2, 2))
            held[axis, axis] = 1
            model.add_initialized_data(f"{name}held{axis}", held)
            model.add_initialized_data(f"{name}value{axis}", np.zeros(2))
            model.add_generalized_Dirichlet_condition_with_multipliers(own, name, fem, region, f"{name}value{axis}", f"{name}held{axis}")
    model.add_fem_variable("p", multiplier)
    model.add_integral_contact_between_nonmatching_meshes_brick(points, "u", "w", "p", "r", CONTACT, CONTACT)
    iterations = model.solve("max_res", 1e-9, "max_iter", 100, "lsolver", "mumps")[0]
    return found(mesh, model, (pressures, kept), iterations, time.process_time() - began)


def stacked(scene, mesh, setting, began):
    """The same of a stack of bodies, of which each has the multiplier of its lower side; and how far the face under the load comes down."""
    parameter, most = SETTINGS[setting]
    E, nu, dimension = scene.young, scene.poisson, mesh.dimension
    down = -np.eye(dimension)[-1]
    model = gf.Model("real")
    model.add_initialized_data("lame", [E * nu / ((1 + nu) * (1 - 2 * nu))])
    model.add_initialized_data("shear", [E / (2 * (1 + nu))])
    model.add_initialized_data("r", [parameter * E / scene.zone])
    model.add_initialized_data("traction", scene.traction * down)
    bodies = []
    for k, own in enumerate(mesh.all()):
        grid = gf.Mesh("import", "gmsh", str(own.path))
        fem, pressures = gf.MeshFem(grid, dimension), gf.MeshFem(grid, 1)
        fem.set_fem(gf.Fem(f"FEM_PK({dimension},{own.degree})"))
        pressures.set_fem(gf.Fem(f"FEM_PK({dimension},{min(own.degree, most)})"))
        points = gf.MeshIm(grid, gf.Integ("IM_TRIANGLE(6)" if dimension == 2 else "IM_TETRAHEDRON(6)"))
        model.add_fem_variable(f"u{k}", fem)
        model.add_isotropic_linearized_elasticity_brick(points, f"u{k}", "lame", "shear")
        if scene.name == "blocks":
            sides = [(0, scene.left)] if k < 2 else [(0, scene.left), (1, scene.bottom)]
            for axis, region in sides:
                model.add_initialized_data(f"held{k}{axis}", np.diag(np.eye(2)[axis]))
                model.add_initialized_data(f"value{k}{axis}", np.zeros(2))
                model.add_generalized_Dirichlet_condition_with_multipliers(
                    points, f"u{k}", fem, region, f"value{k}{axis}", f"held{k}{axis}"
                )
            # a start a little inside the body below, so that the first step has something to push against
            model.set_variable(f"u{k}", np.tile(1e-3 * (2 - k) * scene.zone * down, fem.nbdof() // 2))
        else:
            model.add_Dirichlet_condition_with_simplification(f"u{k}", scene.left)
        if k > 0:
            of_above, points_above = bodies[-1][1:]
            multiplier = gf.MeshFem("partial", of_above, of_above.basic_dof_on_region(scene.bottom))
            model.add_fem_variable(f"p{k}", multiplier)
            model.add_integral_contact_between_nonmatching_meshes_brick(
                points_above, f"u{k - 1}", f"u{k}", f"p{k}", "r", scene.bottom, scene.top
            )
        else:
            model.add_source_term_brick(points, "u0", "traction", scene.top)
        bodies.append((fem, pressures, points))
    iterations, converged = model.solve("max_res", 1e-9, "max_iter", 100, "lsolver", "mumps")
    spent = time.process_time() - began
    failure = None if converged else "no convergence in 100 iterations"
    values = lowered(scene, mesh, model, bodies[0][0])
    return {"cpu": spent, "unknowns": model.nbdof(), "iterations": int(iterations), "failure": failure, "values": values}


def lowered(scene, mesh, model, fem):
    """How far the nodes of the face under the load come down."""
    own, dimension = mesh.on(scene.top), mesh.dimension
    kept = fem.basic_dof_on_region(scene.top)[dimension - 1 :: dimension]
    places, moved = fem.basic_dof_nodes()[:, kept].T, model.variable("u0")[kept]
    values = np.zeros(len(mesh.nodes))
    # dofs are where nodes are, in another order
    values[own] = -moved[np.linalg.norm(mesh.nodes[own][:, None, :] - places[None, :, :], axis=2).argmin(axis=1)]
    return values


class Body:
    """A neo-Hookean body at large strains: psi = mu/2 (tr C - 3 - 2 ln J). Without a modulus it is rigid, its displacement given."""

    def __init__(self, model, name, mesh, young, most):
        self.name, self.dimension = name, mesh.dimension
        self.grid = gf.Mesh("import", "gmsh", str(mesh.path))
        self.fem, self.pressures = gf.MeshFem(self.grid, self.dimension), gf.MeshFem(self.grid, 1)
        self.fem.set_fem(gf.Fem(f"FEM_PK({self.dimension},{mesh.degree})"))
        self.pressures.set_fem(gf.Fem(f"FEM_PK({self.dimension},{min(mesh.degree, most)})"))
        self.points = gf.MeshIm(self.grid, gf.Integ("IM_TRIANGLE(6)" if self.dimension == 2 else "IM_TETRAHEDRON(6)"))
        self.jacobians = gf.MeshFem(self.grid, 1)
        self.jacobians.set_fem(gf.Fem(f"FEM_PK_DISCONTINUOUS({self.dimension},{mesh.degree - 1})"))
        model.add_fem_variable(name, self.fem)
        self.gradient = f"(Id({self.dimension}) + Grad_{name})"
        if young is None:
            model.disable_variable(name)
            return
        model.add_initialized_data(f"shear_{name}", [young / 2])
        model.add_nonlinear_term(
            self.points, f"shear_{name} * ({self.gradient} - Inv({self.gradient})'):Grad_Test_{name}", -1, 1, 1
        )

    def intact(self, model):
        """Whether no cell is turned inside out."""
        return model.interpolation(f"Det({self.gradient})", self.jacobians).min() > 0


class Pair:
    """Large sliding of the boundary of a body, which has the multiplier p, on another body, that is found along the deformed normals. With
    names of fields that are zero, `still`, points that face each other are found at rest, once for all: contact at small strains. What is
    not to be closed of the gap is `spared`, an expression. Where nothing is found, `is_balanced` leaves out the slave's force, too."""

    def __init__(self, model, name, slave, of_slave, master, of_master, reach, still=None, spared="", r="r", is_balanced=False):
        self.slave, self.region = slave, of_slave
        rays, a, b = f"rays_{name}", slave.name, master.name
        kept = slave.pressures.basic_dof_on_region(of_slave)
        model.add_fem_variable(name, gf.MeshFem("partial", slave.pressures, kept))
        model.add_raytracing_transformation(rays, reach)
        of_a, of_b = still or (a, b)
        model.add_slave_contact_boundary_to_raytracing_transformation(rays, slave.grid, of_a, of_slave)
        model.add_master_contact_boundary_to_raytracing_transformation(rays, master.grid, of_b, of_master)
        normal = "Normal" if still else f"Transformed_unit_vector(Grad_{a}, Normal)"
        on_slave = f"-{name}*(Test_{a}.{normal})"
        if is_balanced:
            on_slave = f"Interpolate_filter({rays}, {on_slave}, 1)"
        gap = f"((Interpolate({b}, {rays}) + Interpolate(X, {rays}) - X - {a}).{normal})"
        gap = f"({gap} - {spared})" if spared else gap
        model.add_nonlinear_term(
            slave.points,
            f"{on_slave} + Interpolate_filter({rays}, {name}*(Interpolate(Test_{b}, {rays}).{normal}), 1)"
            f" - (1/{r})*{name}*Test_{name} - Interpolate_filter({rays}, (1/{r})*neg_part({name} + {r}*{gap})*Test_{name}, 1)",
            of_slave,
        )
        self.upward = f"{name}*([0;1].{normal})"

    def force(self, model):
        """The vertical force on the slave, in the plane."""
        return float(gf.asm_generic(self.slave.points, 0, self.upward, self.region, model))


def newton(model):
    """Iterations of Newton's method by full steps, unless the residual becomes very large, and whether they converge."""
    return model.solve("max_res", 1e-9, "max_iter", 15, "lsolver", "mumps", "lsearch", "simplest", "alpha max ratio", 1e3)


def followed(model, bodies, load, places, cuts=6, solved=newton):
    """Goes by load(place) through all places, with cuts where Newton's method fails. Yields the place and the number of iterations."""
    done = 0.0
    for place in places:
        step = whole = place - done
        while done < place:
            to = place if step > 0.999 * (place - done) else done + step
            kept = model.from_variables()
            load(to)
            iterations, converged = solved(model)
            if converged and all(body.intact(model) for body in bodies):
                done = to
            else:
                model.to_variables(kept)
                load(done)
                step /= 2
                if step < whole / 2**cuts:
                    raise ArithmeticError(f"no convergence beyond {done:.4g} of the load")
            yield done, int(iterations)


def sliding(scene, mesh, setting, began):
    """A scene at large strains."""
    parameter, most = SETTINGS[setting]
    model, force = gf.Model("real"), None
    model.add_initialized_data("r", [parameter * scene.young / scene.zone])
    if scene.name == "finite_beams":
        bodies, load, places = hanging(scene, mesh, model, most)
    elif scene.name == "discs":
        bodies, load, places, force = disc_in_ring(scene, mesh, model, most)
    else:
        bodies, load, places, force = die_on_slab(scene, mesh, model, most)
    iterations, failure, forces = 0, None, {}
    try:
        for place, count in followed(model, [body for body in bodies if body.name != "rigid"], load, places):
            iterations += count
            if force:
                forces[place] = force()
    except ArithmeticError as error:
        failure = str(error)
    result = {"cpu": time.process_time() - began, "unknowns": model.nbdof(), "iterations": iterations, "failure": failure, "values": None}
    if failure is None and force:
        result["scalar"] = float(np.mean([forces[place] for place in places[-getattr(scene, "places", 1):]]))
    elif failure is None:
        result["values"] = lowered(scene, mesh, model, bodies[0].fem)
    return result


def hanging(scene, mesh, model, most):
    """The beams."""
    bodies = [Body(model, f"u{k}", own, scene.young, most) for k, own in enumerate(mesh.all())]
    for body in bodies:
        model.add_Dirichlet_condition_with_simplification(body.name, scene.left)
    for k in range(1, len(bodies)):
        Pair(model, f"p{k}", bodies[k - 1], scene.bottom, bodies[k], scene.top, scene.zone / 2)
    model.add_initialized_data("traction", np.zeros(3))
    model.add_source_term_brick(bodies[0].points, "u0", "traction", scene.top)
    return bodies, lambda place: model.set_variable("traction", [0, 0, -scene.traction * place]), [1.0]


def disc_in_ring(scene, mesh, model, most):
    """The rigid disc, which is prescribed, and the ring, which is the slave."""
    disc = Body(model, "rigid", mesh, None, most)
    ring = Body(model, "u", mesh.other, scene.young, most)
    model.add_Dirichlet_condition_with_simplification("u", scene.outside)
    pair = Pair(model, "p", ring, CONTACT, disc, CONTACT, scene.zone / 2)
    count = disc.fem.nbdof() // 2

    def load(place):
        model.set_variable("rigid", np.tile([0, -scene.descent * place], count))

    return [disc, ring], load, [0.25, 0.5, 0.75, 1.0], lambda: -pair.force(model)


def die_on_slab(scene, mesh, model, most):
    """The die, which is moved at its top, and the slab, which is the slave. Until 1 the die is pressed, then it slides."""
    die = Body(model, "u", mesh, scene.stiff, most)
    slab = Body(model, "w", mesh.other, scene.young, most)
    model.add_initialized_data("moved", [0, 0])
    model.add_Dirichlet_condition_with_simplification("u", scene.top, "moved")
    model.add_Dirichlet_condition_with_simplification("w", scene.bottom)
    pair = Pair(model, "p", slab, scene.top, die, scene.bottom, scene.zone / 3)

    def load(place):
        model.set_variable("moved", [scene.slide * max(place - 1, 0), -scene.press * min(place, 1)])

    return [die, slab], load, [1.0] + [1 + k / scene.places for k in range(1, scene.places + 1)], lambda: -pair.force(model)


def found(mesh, model, parts, iterations, spent):
    """What a run gives."""
    (pressures, kept), label, values = parts, CONTACT, -model.variable("p")
    failure = "no convergence in 100 iterations" if iterations >= 100 else None
    places = pressures.basic_dof_nodes()[:, kept].T
    pressure = np.zeros(len(mesh.nodes))
    own = mesh.on(label)
    # dofs are where nodes are, in another order
    apart = np.linalg.norm(mesh.nodes[own][:, None, :] - places[None, :, :], axis=2)
    pressure[own] = values[apart.argmin(axis=1)]
    if len(kept) < len(own):
        # a linear multiplier is linear along sides
        for facet in mesh.facets[label]:
            for side, middle in enumerate(facet[mesh.dimension:]):
                pressure[middle] = (pressure[facet[side]] + pressure[facet[(side + 1) % mesh.dimension]]) / 2
    return {
        "cpu": spent,
        "unknowns": model.nbdof(),
        "iterations": int(iterations),
        "failure": failure,
        "values": pressure,
    }


def version():
    return f"GetFEM {gf.getfem_env('version')}"

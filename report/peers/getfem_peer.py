"""GetFEM: the integral augmented Lagrangian against a rigid obstacle or between two meshes, by the semismooth Newton method.

The multiplier has the degree of the displacement, or is linear with quadratic cells. r is the parameter of the augmentation.
"""

import time

import getfem as gf
import numpy as np

from scenes import CONTACT

NAME = "GetFEM"
# the parameter of the augmentation in units of E (of beams, of E over their thickness), and the largest degree of the multiplier
SETTINGS = {"r = E/10": (0.1, 2), "r = E": (1.0, 2), "r = 10 E": (10.0, 2), "r = E, linear multiplier": (1.0, 1)}


def applies(scene, mesh, setting):
    """Whether a setting differs from the settings before it."""
    return mesh.degree == 2 or SETTINGS[setting][1] == 2


def solve(scene, mesh, setting):
    """Processor time (s), unknowns, and the pressure at the nodes of the contact boundary."""
    gf.util("trace level", 0)
    gf.util("warning level", 0)
    began = time.process_time()
    if scene.name == "beams":
        return stacked(scene, mesh, setting, began)
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
    """The same of beams, of which each has the multiplier of its lower side; and how far the face under the load comes down."""
    parameter, most = SETTINGS[setting]
    E, nu = scene.young, scene.poisson
    model = gf.Model("real")
    model.add_initialized_data("lame", [E * nu / ((1 + nu) * (1 - 2 * nu))])
    model.add_initialized_data("shear", [E / (2 * (1 + nu))])
    model.add_initialized_data("r", [parameter * E / 25])
    model.add_initialized_data("traction", [0, 0, -scene.traction])
    beams = []
    for k, own in enumerate(mesh.all()):
        grid = gf.Mesh("import", "gmsh", str(own.path))
        fem, pressures = gf.MeshFem(grid, 3), gf.MeshFem(grid, 1)
        fem.set_fem(gf.Fem(f"FEM_PK(3,{own.degree})"))
        pressures.set_fem(gf.Fem(f"FEM_PK(3,{min(own.degree, most)})"))
        points = gf.MeshIm(grid, gf.Integ("IM_TETRAHEDRON(6)"))
        model.add_fem_variable(f"u{k}", fem)
        model.add_isotropic_linearized_elasticity_brick(points, f"u{k}", "lame", "shear")
        model.add_Dirichlet_condition_with_simplification(f"u{k}", scene.left)
        if k > 0:
            above, of_above = beams[-1][:2]
            multiplier = gf.MeshFem("partial", of_above, of_above.basic_dof_on_region(scene.bottom))
            model.add_fem_variable(f"p{k}", multiplier)
            model.add_integral_contact_between_nonmatching_meshes_brick(
                beams[-1][2], f"u{k - 1}", f"u{k}", f"p{k}", "r", scene.bottom, scene.top
            )
        else:
            model.add_source_term_brick(points, "u0", "traction", scene.top)
        beams.append((fem, pressures, points))
    iterations = model.solve("max_res", 1e-9, "max_iter", 100, "lsolver", "mumps")[0]
    spent = time.process_time() - began
    fem = beams[0][0]
    own = mesh.on(scene.top)
    kept = fem.basic_dof_on_region(scene.top)[2::3]
    places, moved = fem.basic_dof_nodes()[:, kept].T, model.variable("u0")[kept]
    values = np.zeros(len(mesh.nodes))
    values[own] = -moved[np.linalg.norm(mesh.nodes[own][:, None, :] - places[None, :, :], axis=2).argmin(axis=1)]
    failure = "no convergence in 100 iterations" if iterations >= 100 else None
    return {"cpu": spent, "unknowns": model.nbdof(), "iterations": int(iterations), "failure": failure, "values": values}


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

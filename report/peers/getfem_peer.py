"""GetFEM: the integral augmented Lagrangian against a rigid obstacle, by the semismooth Newton method.

The multiplier has the degree of the displacement. r is the parameter of the augmentation.
"""

import time

import getfem as gf
import numpy as np

from scenes import CONTACT

NAME = "GetFEM"
SETTINGS = {"r = E/10": 0.1, "r = E": 1.0, "r = 10 E": 10.0}


def solve(scene, mesh, setting):
    """Processor time (s), unknowns, and the pressure at the nodes of the contact boundary."""
    gf.util("trace level", 0)
    gf.util("warning level", 0)
    began = time.process_time()
    dimension, degree, label = mesh.dimension, mesh.degree, CONTACT
    grid = gf.Mesh("import", "gmsh", str(mesh.path))
    displacement, scalar = gf.MeshFem(grid, dimension), gf.MeshFem(grid, 1)
    for fem in (displacement, scalar):
        fem.set_fem(gf.Fem(f"FEM_PK({dimension},{degree})"))
    kept = scalar.basic_dof_on_region(label)
    multiplier = gf.MeshFem("partial", scalar, kept)
    rule = "IM_TRIANGLE(6)" if dimension == 2 else "IM_TETRAHEDRON(6)"
    points = gf.MeshIm(grid, gf.Integ(rule))
    E, nu = scene.young, scene.poisson
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
    model.add_initialized_data("r", [SETTINGS[setting] * E])
    model.add_integral_contact_with_rigid_obstacle_brick(points, "u", "p", "height", "r", label, 1)
    # a start a little inside, so that the first step has something to push against
    start = np.zeros((displacement.nbdof() // dimension, dimension))
    start[:, -1] = -1e-3 * scene.zone
    model.set_variable("u", start.ravel())
    iterations = model.solve("max_res", 1e-9, "max_iter", 100)[0]
    spent = time.process_time() - began
    failure = "no convergence in 100 iterations" if iterations >= 100 else None
    places = scalar.basic_dof_nodes()[:, kept].T
    values = -model.variable("p")
    pressure = np.zeros(len(mesh.nodes))
    own = mesh.on(label)
    # dofs are where nodes are, in another order
    apart = np.linalg.norm(mesh.nodes[own][:, None, :] - places[None, :, :], axis=2)
    pressure[own] = values[apart.argmin(axis=1)]
    return {
        "cpu": spent,
        "unknowns": model.nbdof(),
        "iterations": int(iterations),
        "failure": failure,
        "pressure": pressure,
    }


def version():
    return f"GetFEM {gf.getfem_env('version')}"

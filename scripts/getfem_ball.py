#!/usr/bin/env python3
"""Hertz's contact of a ball on a rigid plane by GetFEM's augmented Lagrangian, on the meshes that `make pressures` leaves.

    scripts/getfem_ball.py out/pressures [r/E ...]

Prints the relative errors in L² of GetFEM's multiplier against Hertz's pressure, for each r/E (0.1 and 1 by default), beside those
of the library on the same mesh. Multipliers have the degree of the displacement. Needs Debian's python3-getfem and python3-numpy.
"""

import json
import pathlib
import sys

import getfem as gf
import numpy as np

CONTACT, HELD_X, HELD_Y, LOADED = 1, 2, 3, 4
# places in the files' cells (corners, then edges 01 12 20 03 13 23) of the nodes of GetFEM's quadratic tetrahedron
QUADRATIC = [0, 4, 1, 6, 5, 2, 7, 8, 9, 3]


def mesh_of(scene):
    """The mesh with its regions, and its degree."""
    nodes = np.array(scene["nodes"])
    degree = 2 if len(scene["cells"][0]) == 10 else 1
    order = QUADRATIC if degree == 2 else range(4)
    mesh = gf.Mesh("empty", 3)
    for cell in scene["cells"]:
        mesh.add_convex(gf.GeoTrans(f"GT_PK(3,{degree})"), nodes[[cell[k] for k in order]].T)
    number = {tuple(np.round(X, 9)): a for a, X in enumerate(nodes)}
    of_point = [number[tuple(np.round(x, 9))] for x in mesh.pts().T]
    top = nodes[:, 2].max()
    contact = {frozenset(facet) for facet in scene["below"]}
    sets = {HELD_X: set(scene["held_x"]), HELD_Y: set(scene["held_y"])}
    sets[LOADED] = {a for a, X in enumerate(nodes) if abs(X[2] - top) < 1e-9}
    regions = {CONTACT: [], HELD_X: [], HELD_Y: [], LOADED: []}
    for cell, face in mesh.outer_faces().T:
        on = frozenset(of_point[p] for p in mesh.pid_in_faces(np.array([[cell], [face]])))
        if on in contact:
            regions[CONTACT].append((cell, face))
        for region, members in sets.items():
            if on <= members:
                regions[region].append((cell, face))
    for region, faces in regions.items():
        mesh.set_region(region, np.array(faces).T)
    return mesh, degree


def solve(scene, r):
    """The error, the least pressure over p0, the multipliers' resultant over the force, the iterations."""
    mesh, degree = mesh_of(scene)
    displacement, multiplier, quadratic = gf.MeshFem(mesh, 3), gf.MeshFem(mesh, 1), gf.MeshFem(mesh, 1)
    displacement.set_fem(gf.Fem(f"FEM_PK(3,{degree})"))
    multiplier.set_fem(gf.Fem(f"FEM_PK(3,{degree})"))
    quadratic.set_fem(gf.Fem("FEM_PK(3,2)"))
    points = gf.MeshIm(mesh, gf.Integ("IM_TETRAHEDRON(6)"))
    fine = gf.MeshIm(mesh, gf.Integ("IM_TETRAHEDRON(8)"))
    E, nu = scene["young"], scene["poisson"]
    a, p0 = scene["contact_radius"], scene["peak_pressure"]
    force = np.array(scene["forces"])[2::3].sum()
    model = gf.Model("real")
    model.add_fem_variable("u", displacement)
    model.add_filtered_fem_variable("p", multiplier, CONTACT)
    model.add_initialized_data("lame", [E * nu / ((1 + nu) * (1 - 2 * nu))])
    model.add_initialized_data("shear", [E / (2 * (1 + nu))])
    model.add_isotropic_linearized_elasticity_brick(points, "u", "lame", "shear")
    model.add_initialized_data("traction", [0, 0, force / gf.asm_generic(fine, 0, "1", LOADED)])
    model.add_source_term_brick(points, "u", "traction", LOADED)
    for axis, region in enumerate((HELD_X, HELD_Y)):
        held = np.zeros((3, 3))
        held[axis, axis] = 1
        model.add_initialized_data(f"held{axis}", held)
        model.add_initialized_data(f"zero{axis}", [0, 0, 0])
        model.add_generalized_Dirichlet_condition_with_multipliers(
            points, "u", displacement, region, f"zero{axis}", f"held{axis}"
        )
    model.add_initialized_fem_data("height", quadratic, quadratic.basic_dof_nodes()[2])
    model.add_initialized_data("r", [r * E])
    model.add_integral_contact_with_rigid_obstacle_brick(points, "u", "p", "height", "r", CONTACT, 1)
    # a start a little inside, so that the first step has something to push against
    start = np.zeros((displacement.nbdof() // 3, 3))
    start[:, 2] = -0.05
    model.set_variable("u", start.ravel())
    iterations = model.solve("max_res", 1e-9, "max_iter", 60)[0]
    exact = f"{p0}*sqrt(max(0, 1 - (X(1)*X(1) + X(2)*X(2))/{a * a}))"
    off = gf.asm_generic(fine, 0, f"sqr(p + {exact})", CONTACT, model)
    whole = gf.asm_generic(fine, 0, f"sqr({exact})", CONTACT, model)
    resultant = gf.asm_generic(fine, 0, "p", CONTACT, model)
    return (off / whole) ** 0.5, -model.variable("p").max() / p0, resultant / force, iterations


def main():
    gf.util("trace level", 0)
    gf.util("warning level", 0)
    factors = [float(text) for text in sys.argv[2:]] or [0.1, 1.0]
    print("mesh, error of the recovered and of the consistent pressure; GetFEM's r/E, error, least/p0, resultant, iterations")
    for path in sorted(pathlib.Path(sys.argv[1]).glob("P?_*.json")):
        scene = json.loads(path.read_text())
        for r in factors:
            error, least, resultant, iterations = solve(scene, r)
            own = " ".join(f"{error:.4f}" for error in scene["errors"])
            print(f"{path.stem} {own} {r:g} {error:.4f} {least:.3f} {resultant:.6f} {iterations}", flush=True)


main()

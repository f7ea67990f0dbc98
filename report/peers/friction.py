#!/usr/bin/python3
"""Coulomb's friction by GetFEM and by this library, on the same meshes: one table.

    python3 report/peers/friction.py [--scene A|B|all] [--program getfem|ours|all] [--sizes 8,16] [--degrees 1,2]
        [--settings brick/10,rays/10] [--ours "default,one pass"] [--repeats 3] [--seconds 300] [--binary FILE] [--details]

Scene A: two blocks in plane strain at small strains, the upper one is pressed on the lower one and drawn aside. Scene B: the campaign's
ironing, with friction. Each solve of GetFEM is a process of its own, whose processor time counts from the import of the meshes to the last
increment, without the start of Python; that of this library is the time of the whole program. Solves run one after the other. Each setting
runs once; the fastest complete one of a mesh, and this library, run again up to --repeats times while there is time (the least counts).
"""

import argparse
import csv
import json
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import time

import numpy as np

import ours_peer
import scenes

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target" / "release" / "ipopt-contact"
WORK = ROOT / "out" / "friction-peers"
# the longest run (s)
LIMIT = 60
MU = 0.3

# scene A
YOUNG, POISSON = 1.0, 0.3
PRESS, DRAW = 0.02, 0.02
BOTTOM, TOP = 2, 6
SIZES_A = {1: [8, 16, 32, 64], 2: [8, 16, 32]}
# scene B
SIZES_B = {1: [6, 9, 14], 2: [6, 9, 14]}
# the method, and the parameter of the augmentation: of scene A in units of E / side, of scene B in units of E / scene.zone
SETTINGS_A = ["brick/0.3", "brick/1", "brick/10", "rays/1"]
SETTINGS_B = ["rays/1", "rays/3", "rays/10"]
SETTINGS_OURS = {"A": ["default"], "B": ["default", "one pass"]}
# on these meshes, GetFEM has only so many settings: the fastest ones of the mesh before
FEWER_SETTINGS = {("A", 1, 32): 2, ("A", 1, 64): 1, ("A", 2, 16): 2, ("A", 2, 32): 1, ("B", 2, 14): 1}
# what took longer (s) is repeated once
LONG = 15


# meshes of scene A


def rectangle(path, low, high, along, up, degree):
    """A file of Gmsh (2.2) of triangles, whose diagonals alternate."""
    nx, ny = degree * along, degree * up
    number = lambda i, j: 1 + i + (nx + 1) * j  # noqa: E731
    x, y = np.linspace(low[0], high[0], nx + 1), np.linspace(low[1], high[1], ny + 1)
    nodes = [f"{number(i, j)} {x[i]!r} {y[j]!r} 0" for j in range(ny + 1) for i in range(nx + 1)]
    rows = []

    def element(corners, label):
        own = [number(degree * i, degree * j) for i, j in corners]
        if degree == 2:
            ends = list(zip(corners, corners[1:] + corners[:1]))[: len(corners) if len(corners) > 2 else 1]
            own += [number(a[0] + b[0], a[1] + b[1]) for a, b in ends]
        kind = {(2, 1): 1, (2, 2): 8, (3, 1): 2, (3, 2): 9}[len(corners), degree]
        rows.append(f"{len(rows) + 1} {kind} 2 {label} {label} {' '.join(map(str, own))}")

    for i in range(along):
        element([(i, 0), (i + 1, 0)], BOTTOM)
        element([(i + 1, up), (i, up)], TOP)
    for j in range(up):
        for i in range(along):
            a, b, c, d = (i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)
            for corners in ([a, b, c], [a, c, d]) if (i + j) % 2 else ([a, b, d], [b, c, d]):
                element(corners, 10)
    text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "3", f'1 {BOTTOM} "bottom"', f'1 {TOP} "top"', '2 10 "body"']
    text += ["$EndPhysicalNames", "$Nodes", str(len(nodes)), *nodes, "$EndNodes", "$Elements", str(len(rows)), *rows, "$EndElements", ""]
    path.write_text("\n".join(text).replace("np.float64(", "").replace(")", ""))


def meshes_of(scene, size, degree):
    """The meshes of the upper body, and of the lower one."""
    WORK.mkdir(parents=True, exist_ok=True)
    if scene == "A":
        upper, lower = (WORK / f"A_{name}_{size}_P{degree}.msh" for name in ("upper", "lower"))
        rectangle(upper, (0, 0), (1, 1), size, size, degree)
        coarser = 13 / 15 * size
        rectangle(lower, (-1, -1), (2, 0), round(3 * coarser), round(coarser), degree)
        return upper, lower
    die = scenes.Ironing.mesh(WORK, size, degree)
    return die.path, die.other.path


def steps():
    """The places of the load at which increments end: until 1 it presses, until 2 it draws."""
    return [(k + 1) / 5 for k in range(5)] + [1 + (k + 1) / 10 for k in range(10)]


# GetFEM


def getfem(scene, size, degree, setting):
    """A solve, in this process."""
    import getfem as gf

    gf.util("trace level", 0)
    gf.util("warning level", 0)
    method, parameter = setting.split("/")
    upper, lower = meshes_of(scene, size, degree)
    began = time.process_time()
    model = gf.Model("real")
    if scene == "A":
        length, moduli = 1.0, {"u": YOUNG, "w": YOUNG}
    else:
        length, moduli = scenes.Ironing.zone, {"u": scenes.Ironing.stiff, "w": scenes.Ironing.young}
    model.add_initialized_data("r", [float(parameter) * 1.0 / length])
    model.add_initialized_data("mu", [MU])
    model.add_initialized_data("alpha", [1.0])
    bodies, energies = {}, {}
    for name, path in (("u", upper), ("w", lower)):
        grid = gf.Mesh("import", "gmsh", str(path))
        fem, forces = gf.MeshFem(grid, 2), gf.MeshFem(grid, 2)
        for one in (fem, forces):
            one.set_fem(gf.Fem(f"FEM_PK(2,{degree})"))
        points = gf.MeshIm(grid, gf.Integ("IM_TRIANGLE(6)"))
        model.add_fem_variable(name, fem)
        model.add_initialized_fem_data(f"{name}_before", fem, np.zeros(fem.nbdof()))
        E = moduli[name]
        if scene == "A":
            first, shear = E * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), E / (2 * (1 + POISSON))
            model.add_initialized_data(f"first_{name}", [first])
            model.add_initialized_data(f"shear_{name}", [shear])
            model.add_isotropic_linearized_elasticity_brick(points, name, f"first_{name}", f"shear_{name}")
            energies[name] = f"first_{name}/2*sqr(Trace(Grad_{name})) + shear_{name}*Norm_sqr(Sym(Grad_{name}))"
        else:
            gradient = f"(Id(2) + Grad_{name})"
            model.add_initialized_data(f"shear_{name}", [E / 2])
            model.add_nonlinear_term(points, f"shear_{name} * ({gradient} - Inv({gradient})'):Grad_Test_{name}", -1, 1, 1)
            energies[name] = f"shear_{name}/2*(Norm_sqr({gradient}) - 2 - 2*log(Det({gradient})))"
        bodies[name] = (grid, fem, forces, points)
    model.add_initialized_data("moved", [0.0, 0.0])
    model.add_Dirichlet_condition_with_simplification("u", TOP, "moved")
    model.add_Dirichlet_condition_with_simplification("w", BOTTOM)
    # the slave has the multiplier: in scene A the upper block, in B the slab, as in the campaign
    slave, region, master, facing = ("u", BOTTOM, "w", TOP) if scene == "A" else ("w", TOP, "u", BOTTOM)
    grid, fem, forces, points = bodies[slave]
    multiplier = gf.MeshFem("partial", forces, forces.basic_dof_on_region(region))
    model.add_fem_variable("p", multiplier)
    a, b = slave, master
    if method.startswith("brick"):
        # brick, brick2, ...: the number is GetFEM's option
        option = int(method[5:] or 1)
        model.add_integral_contact_between_nonmatching_meshes_brick(
            points, a, b, "p", "r", "mu", region, facing, option, "alpha", f"{a}_before", f"{b}_before"
        )
    else:
        is_small = scene == "A"
        model.add_raytracing_transformation("rays", 0.5 if is_small else scenes.Ironing.zone / 3)
        if is_small:
            for name in bodies:
                model.add_initialized_fem_data(f"{name}_zero", bodies[name][1], np.zeros(bodies[name][1].nbdof()))
        suffix = "_zero" if is_small else ""
        model.add_slave_contact_boundary_to_raytracing_transformation("rays", grid, a + suffix, region)
        model.add_master_contact_boundary_to_raytracing_transformation("rays", bodies[b][0], b + suffix, facing)
        normal = "Normal" if is_small else f"Transformed_unit_vector(Grad_{a}, Normal)"
        gap = f"((Interpolate(X, rays) + Interpolate({b}, rays) - X - {a}).{normal})"
        slip = f"({a} - Interpolate({b}, rays) - {a}_before + Interpolate({b}_before, rays))"
        model.add_nonlinear_term(
            points,
            f"-p.Test_{a} + Interpolate_filter(rays, p.Interpolate(Test_{b}, rays), 1) - (1/r)*p.Test_p"
            f" + Interpolate_filter(rays, (1/r)*Coulomb_friction_coupled_projection(p, {normal}, {slip}, {gap}, mu, r).Test_p, 1)",
            region,
        )
    # a start that is pressed and sticks
    down = np.zeros(multiplier.nbdof())
    if scene == "A":
        # multipliers are tractions on the slave
        down[1::2] = 0.003 * YOUNG
        model.set_variable("p", down)

    press, draw = (PRESS, DRAW) if scene == "A" else (scenes.Ironing.press, scenes.Ironing.slide)

    def load(place):
        model.set_variable("moved", [draw * max(place - 1, 0), -press * min(place, 1)])

    def is_intact():
        if scene == "A":
            return True
        return all(model.interpolation(f"Det(Id(2)+Grad_{name})", gf_jacobians[name]).min() > 0 for name in bodies)

    gf_jacobians = {}
    for name in bodies:
        gf_jacobians[name] = gf.MeshFem(bodies[name][0], 1)
        gf_jacobians[name].set_fem(gf.Fem(f"FEM_PK_DISCONTINUOUS(2,{degree - 1})"))

    def force():
        """The force on the upper body by the lower one."""
        total = np.array([float(gf.asm_generic(points, 0, f"p.[{x};{1 - x}]", region, model)) for x in (1, 0)])
        return total if scene == "A" else -total

    done, increments, cuts, iterations, failure, history = 0.0, 0, 0, 0, None, []
    measuring = 0.0
    for place in steps():
        step = whole = place - done
        while done < place:
            to = place if step > 0.999 * (place - done) else done + step
            kept = model.from_variables()
            load(to)
            try:
                count, converged = model.solve(
                    "max_res", 1e-9, "max_iter", 30, "lsolver", "mumps", "lsearch", "simplest", "alpha max ratio", 1e3
                )
            except RuntimeError as error:
                count, converged = 0, False
                print(" ".join(str(error).split())[-200:], file=sys.stderr)
            iterations += int(count)
            if converged and is_intact():
                done = to
                increments += 1
                for name in bodies:
                    model.set_variable(f"{name}_before", model.variable(name))
            else:
                cuts += 1
                model.to_variables(kept)
                load(done)
                step /= 2
                if step < whole / 2**6:
                    failure = f"no convergence beyond {done:.4g}"
                    break
        if failure:
            break
        before = time.process_time()
        history.append([place, *force().tolist()])
        measuring += time.process_time() - before
    spent = time.process_time() - began - measuring
    energy = sum(float(gf.asm_generic(bodies[name][3], 0, energies[name], -1, model)) for name in bodies)
    return {
        "cpu": spent, "unknowns": int(model.nbdof()), "increments": increments, "cuts": cuts, "iterations": iterations,
        "failure": failure, "history": history, "energy": energy,
    }


# this library

BODY = """
[[body]]
name = "{name}"
mesh = "{mesh}"
law = "{law}"
young = {young!r}
poisson = {poisson!r}
"""
HELD = 'supports = [{ on = "bottom", x = 0, y = 0 }]\n'
REST = """
[[contact]]
first = ["lower", "top"]
second = ["upper", "bottom"]
friction = {mu!r}
passes = "{passes}"

[output]
name = "run"
picture = ""
vtu-every = 0
"""

def ours(scene, size, degree, setting):
    """A solve, by a child process."""
    upper, lower = meshes_of(scene, size, degree)
    if scene == "A":
        law, poisson, moduli, press, draw = "linear-elastic", POISSON, (YOUNG, YOUNG), PRESS, DRAW
    else:
        ironing = scenes.Ironing
        law, poisson, moduli, press, draw = "neo-hookean", 0.0, (ironing.stiff, ironing.young), ironing.press, ironing.slide
    text = ours_peer.PHASES.format(places=10) + BODY.format(name="lower", mesh=lower.name, law=law, young=moduli[1], poisson=poisson) + HELD
    text += BODY.format(name="upper", mesh=upper.name, law=law, young=moduli[0], poisson=poisson)
    text += ours_peer.IRONED.format(lowered=-press, slide=draw) + REST.format(mu=MU, passes="first-is-slave" if setting == "one pass" else "both")
    path = WORK / f"{scene}_{size}_P{degree}_{setting.replace(' ', '_')}.toml"
    path.write_text(text)
    out = path.with_suffix("")
    shutil.rmtree(out, ignore_errors=True)
    command = [str(PROGRAM), "run", str(path), "--out", str(out)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        whole = [row for row in csv.DictReader((out / "run.csv").open()) if row["increment"]] if (out / "run.csv").exists() else []
        where = f"at {whole[-1]['load_factor']} by {whole[-1]['solver']}" if whole else "before the first increment's end"
        return {"failure": f"more than {LIMIT} s, {where}"}
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if not (out / "summary.json").exists():
        return {"cpu": spent, "failure": (run.stderr or run.stdout).strip()[-300:]}
    summary = json.loads((out / "summary.json").read_text())
    rows = list(csv.DictReader((out / "run.csv").open()))
    good = [row for row in rows if row["outcome"] == "converged" or row["increment"]]
    history = [[float(row["load_factor"]), float(row["reaction_upper_x"]), float(row["reaction_upper_y"])] for row in good]
    failure = {0: None, 3: "not certified"}.get(run.returncode, f"exit code {run.returncode}: {(run.stderr or run.stdout).strip()[-200:]}")
    # the supports hold the upper body against the force of the lower one
    return {
        "cpu": spent, "unknowns": summary["mesh"]["free_dofs"], "increments": len(good), "cuts": len(rows) - len(good),
        "iterations": sum(int(row["iterations"] or 0) for row in rows), "failure": failure,
        "history": [[place, -x, -y] for place, x, y in history], "energy": float(good[-1]["stored_energy"]),
        "solvers": sorted({row["solver"] for row in rows}),
    }


# the table


def at(history, place):
    """The force on the upper body at a place."""
    return next(((x, y) for where, x, y in history if abs(where - place) < 1e-9), (float("nan"), float("nan")))


def apart(one, other):
    """The largest difference of forces at the same place, of the largest force (%)."""
    pairs = [(np.array(force), np.array(at(one.get("history") or [], place))) for place, *force in other.get("history") or []]
    most = max((np.linalg.norm(force) for force, _ in pairs), default=1.0)
    return 100 * max((np.linalg.norm(a - b) / most for a, b in pairs), default=float("nan"))


def line(program, scene, size, degree, setting, result, repeats, away):
    """A line of the table."""
    head = f"{scene} P{degree} {size:3d} {program:<13} {setting:<10}"
    if not result.get("history"):
        return f"{head} {result.get('cpu', float('nan')):8.2f} {result.get('failure')}"
    half, end = at(result["history"], 1 + 0.2 if scene == "A" else 1.5), at(result["history"], 2)
    pressed = at(result["history"], 1)
    return (
        f"{head} {result['unknowns']:7d} {result['increments']:3d}+{result['cuts']:<2d} {result['iterations']:4d} {result['cpu']:8.2f} ({repeats})"
        f" {pressed[1]:9.6f} {half[1]:9.6f} {-half[0]:9.6f} {end[1]:9.6f} {-end[0]:9.6f} {result['energy']:11.5e} {away:5.2f}  {result['failure'] or 'complete'}"
    )


HEAD = (
    "sc deg  n program       setting    unknowns inc+cuts its  CPU s (runs)  N(press)   N(mid)    T(mid)    N(end)    T(end)   energy      apart  outcome\n"
    "mid: scene A at a fifth of the way aside, B at half of it; N presses the upper body up, T is the drag against its motion;\n"
    "apart: the largest difference of the force vector from that of the fastest setting of GetFEM at all increments, % of the largest force"
)


def run(program, scene, size, degree, setting):
    """A solve, within the limit of time."""
    if program == "here":
        return ours(scene, size, degree, setting)
    command = [sys.executable, __file__, "--one", scene, str(size), str(degree), setting]
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, env=environment)
    except subprocess.TimeoutExpired:
        return {"failure": f"more than {LIMIT} s"}
    lines = [own for own in found.stdout.splitlines() if own.startswith("{")]
    if not lines:
        return {"failure": f"exit code {found.returncode}: {found.stderr.strip()[-300:]}"}
    return json.loads(lines[-1])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--one", nargs=4)
    parser.add_argument("--scene", default="all")
    parser.add_argument("--program", default="all")
    parser.add_argument("--sizes")
    parser.add_argument("--degrees", default="1,2")
    parser.add_argument("--settings")
    parser.add_argument("--ours", help="settings of this library: default, one pass (the lower body is the slave)")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=300)
    parser.add_argument("--binary", help="the program of this library, in place of the release build")
    parser.add_argument("--details", action="store_true")
    arguments = parser.parse_args()
    global PROGRAM
    PROGRAM = pathlib.Path(arguments.binary).resolve() if arguments.binary else PROGRAM
    if arguments.one:
        scene, size, degree, setting = arguments.one
        print(json.dumps(getfem(scene, int(size), int(degree), setting)))
        return
    began = time.monotonic()
    print(HEAD, flush=True)
    for scene in ("B", "A") if arguments.scene == "all" else arguments.scene:
        for degree in map(int, arguments.degrees.split(",")):
            fastest = []
            sizes = [int(size) for size in arguments.sizes.split(",")] if arguments.sizes else (SIZES_A if scene == "A" else SIZES_B)[degree]
            for size in sizes:
                of_getfem = arguments.settings.split(",") if arguments.settings else (SETTINGS_A if scene == "A" else SETTINGS_B)
                if not arguments.settings and fastest:
                    of_getfem = fastest[: FEWER_SETTINGS.get((scene, degree, size), len(of_getfem))] or of_getfem
                jobs = []
                if arguments.program in ("all", "ours"):
                    jobs += [("here", setting) for setting in (arguments.ours.split(",") if arguments.ours else SETTINGS_OURS[scene])]
                if arguments.program in ("all", "getfem"):
                    jobs += [("GetFEM", setting) for setting in of_getfem]
                results = {}
                for job in jobs:
                    results[job] = [run(job[0], scene, size, degree, job[1])]
                complete = [job for job in jobs if job[0] == "GetFEM" and results[job][0].get("failure") is None]
                ranks = sorted(complete, key=lambda job: results[job][0]["cpu"])
                fastest = [setting for _, setting in ranks]
                again = [job for job in jobs if job[0] != "GetFEM" and "cpu" in results[job][0]] + ranks[:1]
                for job in again:
                    most = arguments.repeats if results[job][0]["cpu"] < LONG else min(2, arguments.repeats)
                    while len(results[job]) < most and time.monotonic() - began < arguments.seconds:
                        results[job].append(run(job[0], scene, size, degree, job[1]))
                for job, own in results.items():
                    best = min(own, key=lambda result: result.get("cpu", np.inf))
                    away = apart(results[(ranks or jobs)[0]][0], best)
                    print(line(job[0], scene, size, degree, job[1], best, len(own), away), flush=True)
                    if arguments.details:
                        print(json.dumps({key: value for key, value in best.items()}), flush=True)
    print(f"{time.monotonic() - began:.0f} s in all")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Random scenes of contact that are physically sound, as TOML files of 22 kinds, from a few coarse cells to moderately fine meshes.

    scripts/random/scenes.py --seed 7 --count 400 --out out/random [--kinds cylinders,neutral]

Each file begins with a comment: its kind, order, and what was chosen. They were written from the documents of scene files alone, without a look
at the solver. scripts/random/run.py runs them.
"""
import argparse
import math
import os
import random

PI = math.pi


class S:
    """A scene: text of the file as a whole, then tables."""

    def __init__(s, r, dim=2):
        s.r, s.dim, s.top, s.tab, s.note, s.files = r, dim, [], [], [], {}
        s.names, s.mix = [], random.Random(r.getstate()[1][0])

    def key(s, k, v):
        s.top.append(f"{k} = {v}")

    def body(s, name, mesh, law, quad=False, **kw):
        # one of two bodies of mixed order, now and then
        if quad and not kw.get("curved") and name in ("block", "base", "lower", "low", "up", "upper") and s.mix.random() < 0.2:
            quad = False
            s.note.append(f"{name}-linear")
        s.names.append(name)
        t = ["[[body]]", f'name = "{name}"', f"mesh = {mesh}"]
        t += law
        if quad:
            t.append("quadratic = true")
        for k, v in kw.items():
            if v is not None:
                t.append(f"{k.replace('_', '-')} = {v}")
        s.tab.append("\n".join(t))

    def contact(s, a, b, passes=None):
        t = ["[[contact]]", f'first = ["{a[0]}", "{a[1]}"]', f'second = ["{b[0]}", "{b[1]}"]']
        if passes:
            t.append(f'passes = "{passes}"')
        s.tab.append("\n".join(t))

    def tie(s, a, b):
        s.tab.append("\n".join(["[[tie]]", f'first = ["{a[0]}", "{a[1]}"]', f'second = ["{b[0]}", "{b[1]}"]']))

    def text(s, head):
        return "\n".join([f"# {head}"] + s.top + [""] + ["\n\n".join(s.tab)] + ["", "[output]", "vtu-every = 0", 'picture = ""', ""])


def f(x):
    return repr(float(x))


def rect(x0, x1, nx, y0, y1, ny, diag=None):
    d = f', diagonals = "{diag}"' if diag else ""
    return f"{{ rectangle = {{ x = {{ from = {f(x0)}, to = {f(x1)}, count = {nx} }}, y = {{ from = {f(y0)}, to = {f(y1)}, count = {ny} }}{d} }} }}"


def box(lo, size, n):
    return f"{{ cuboid = {{ low = {[float(v) for v in lo]}, size = {[float(v) for v in size]}, divisions = {list(n)} }} }}"


def annulus(r0, r1, nr, ns):
    return f"{{ annulus = {{ radii = {{ from = {f(r0)}, to = {f(r1)}, count = {nr} }}, segments = {ns} }} }}"


def halfdisc(R, nr, na):
    return f"{{ half-disc = {{ radii = {{ from = 0, to = {f(R)}, count = {nr} }}, angles = {{ from = {f(PI)}, to = {f(2*PI)}, count = {na} }} }} }}"


def quarter(R, nr, na):
    return f"{{ quarter-disc = {{ radii = {{ from = 0, to = {f(R)}, count = {nr} }}, angles = {{ from = {f(1.5*PI)}, to = {f(2*PI)}, count = {na} }} }} }}"


def law(r, small=None, E=None, nu=None, soft=None):
    """(lines, small?, E, nu)"""
    if small is None:
        small = r.random() < 0.35
    E = E if E is not None else 10 ** r.uniform(0, 4)
    nu = nu if nu is not None else r.choice([0.0, 0.2, 0.3, 0.3, 0.4, 0.45])
    if small:
        return ['law = "linear-elastic"', f"young = {f(E)}", f"poisson = {f(nu)}"]
    k = r.choice(["neo-hookean", "neo-hookean", "mooney-rivlin", "st-venant-kirchhoff"])
    t = [f'law = "{k}"', f"young = {f(E)}", f"poisson = {f(nu)}"]
    if k == "mooney-rivlin":
        t.append(f"share = {f(r.uniform(0.1, 0.6))}")
    return t


def two(r, s, ratio=2.0):
    """laws of two bodies of one kind of strain, whether small, moduli"""
    small = r.random() < 0.35
    E = 10 ** r.uniform(0, 4)
    E2 = E * 10 ** r.uniform(-ratio, ratio)
    s.note.append("small" if small else "large")
    if small and r.random() < 0.3:
        s.key("geometry", '"current"')
        s.note.append("current")
    return law(r, small, E), law(r, small, E2), small, E, E2


def incs(s, lo=1, hi=4):
    s.key("increments", s.r.randint(lo, hi))


def common(s, r, closest=True):
    if closest and r.random() < 0.08:
        s.key("projection", '"closest"')
        s.note.append("closest")


def passes(r):
    return r.choice([None, None, None, "first-is-slave", "second-is-slave"])


def lowest(R, na, curved):
    return -R if curved or na % 2 == 0 else -R * math.cos(PI / na / 2)


def mesh2(s, name, pts, tris, edges):
    """a .msh file of version 2.2: pts, triangles, edges (a, b, label)"""
    lab = sorted({e[2] for e in edges})
    out = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(lab) + 1)]
    out += [f'1 {i+1} "{n}"' for i, n in enumerate(lab)] + [f'2 {len(lab)+1} "all"', "$EndPhysicalNames"]
    out += ["$Nodes", str(len(pts))] + [f"{i+1} {p[0]!r} {p[1]!r} 0" for i, p in enumerate(pts)] + ["$EndNodes"]
    el = [f"1 2 {lab.index(l)+1} 1 {a+1} {b+1}" for a, b, l in edges]
    el += [f"2 2 {len(lab)+1} 1 {a+1} {b+1} {c+1}" for a, b, c in tris]
    out += ["$Elements", str(len(el))] + [f"{i+1} {e}" for i, e in enumerate(el)] + ["$EndElements", ""]
    s.files[name] = "\n".join(out)
    return f'"@{name}"'


def grid2(s, name, nx, ny, fn):
    """a mapped rectangle: fn(a, b), a and b from 0 to 1; boundaries bottom, top, left, right"""
    P = [fn(i / nx, j / ny) for j in range(ny + 1) for i in range(nx + 1)]
    k = lambda i, j: j * (nx + 1) + i
    T = []
    for j in range(ny):
        for i in range(nx):
            T += [(k(i, j), k(i + 1, j), k(i + 1, j + 1)), (k(i, j), k(i + 1, j + 1), k(i, j + 1))]
    E = [(k(i, 0), k(i + 1, 0), "bottom") for i in range(nx)] + [(k(nx, j), k(nx, j + 1), "right") for j in range(ny)]
    E += [(k(i + 1, ny), k(i, ny), "top") for i in range(nx)] + [(k(0, j + 1), k(0, j), "left") for j in range(ny)]
    return mesh2(s, name, P, T, E)


def grid3(s, name, n, fn):
    """a mapped cuboid of tetrahedra (6 a cell)"""
    nx, ny, nz = n
    k = lambda i, j, l: (l * (ny + 1) + j) * (nx + 1) + i
    P = [fn(i / nx, j / ny, l / nz) for l in range(nz + 1) for j in range(ny + 1) for i in range(nx + 1)]
    perms = [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]
    T, F = [], {}
    for l in range(nz):
        for j in range(ny):
            for i in range(nx):
                for p in perms:
                    c, v = [i, j, l], [k(i, j, l)]
                    for a in p:
                        c[a] += 1
                        v.append(k(*c))
                    odd = p in [(0, 2, 1), (1, 0, 2), (2, 1, 0)]
                    if odd:
                        v[2], v[3] = v[3], v[2]
                    T.append(v)
                    for q in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)):
                        t = tuple(sorted(v[a] for a in q))
                        F[t] = F.get(t, 0) + 1
    back = {}
    for l in range(nz + 1):
        for j in range(ny + 1):
            for i in range(nx + 1):
                back[k(i, j, l)] = (i, j, l)
    names = [("left", 0, 0), ("right", 0, nx), ("front", 1, 0), ("back", 1, ny), ("bottom", 2, 0), ("top", 2, nz)]
    B = []
    for t, c in F.items():
        if c == 1:
            for m, (nm, ax, v) in enumerate(names):
                if all(back[q][ax] == v for q in t):
                    B.append((t, m))
    out = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "7"]
    out += [f'2 {m+1} "{nm}"' for m, (nm, _, _) in enumerate(names)] + ['3 7 "all"', "$EndPhysicalNames"]
    out += ["$Nodes", str(len(P))] + [f"{i+1} {p[0]!r} {p[1]!r} {p[2]!r}" for i, p in enumerate(P)] + ["$EndNodes"]
    el = [f"2 2 {m+1} 1 {t[0]+1} {t[1]+1} {t[2]+1}" for t, m in B] + [f"4 2 7 1 {v[0]+1} {v[1]+1} {v[2]+1} {v[3]+1}" for v in T]
    out += ["$Elements", str(len(el))] + [f"{i+1} {e}" for i, e in enumerate(el)] + ["$EndElements", ""]
    s.files[name] = "\n".join(out)
    return f'"@{name}"'


# ---------------------------------------------------------------- kinds in the plane

def half_disc_on_block(r, s, ratio=2.0, closest=None):
    q, na, R = r.random() < 0.4, r.choice([4, 5, 6, 8, 12, 16, 24, 32]), 10 ** r.uniform(-1, 1)
    curved = q and r.random() < 0.7
    la, lb, small, *_ = two(r, s, ratio)
    incs(s)
    if closest:
        s.key("projection", '"closest"')
    else:
        common(s, r)
    W, nx = R * r.uniform(1.2, 3), r.choice([4, 6, 8, 12, 20, 30])
    H = R * r.uniform(0.4, 2)
    d = R * (r.uniform(0.003, 0.02) if small else r.uniform(0.01, 0.1))
    gap = r.choice([0, 0, 1e-3 * R])
    off = r.choice([0, r.uniform(-0.2, 0.2) * R])
    s.note.append(f"q{int(q)} curved{int(curved)} na{na} nx{nx} d{d/R:.3g}R")
    s.body("block", rect(-W, W, nx, -H, 0, max(2, int(nx * H / W / 2)), r.choice([None, "falling", "alternating"])), la, q, supports='[{ on = "bottom", x = 0, y = 0 }]')
    s.body("disc", halfdisc(R, r.randint(1, max(2, na // 2)), na), lb, q, curved=f'[{{ on = "arc", radius = {f(R)} }}]' if curved else None,
           translated=[off, gap - lowest(R, na, curved)], supports=f'[{{ on = "flat", x = 0, y = {f(-d)} }}]')
    s.contact(("block", "top"), ("disc", "arc"), passes(r))


def stiff_on_soft(r, s):
    half_disc_on_block(r, s, 5.0)


def closest_points(r, s):
    half_disc_on_block(r, s, 2.0, True)


def pin_in_hole(r, s):
    q, R = r.random() < 0.4, 10 ** r.uniform(-1, 1)
    curved = q and r.random() < 0.8
    same = r.random() < 0.3
    n1 = r.choice([8, 12, 16, 24, 32, 48])
    n2 = n1 if same else r.choice([8, 12, 16, 20, 28, 40])
    if curved:
        n1, n2 = max(n1, 12), max(n2, 12)
    la, lb, small, *_ = two(r, s)
    c = R * 10 ** r.uniform(-3.5, -1.3)
    sag = 0 if (same or curved) else R * (1 - math.cos(PI / n2))
    Rh = R + c + 1.05 * sag
    d = (Rh - R) * r.choice([1.0, 1.2, 1.5, 2.0]) + R * (r.uniform(0.002, 0.01) if small else r.uniform(0.005, 0.05))
    incs(s, 2, 5)
    common(s, r)
    s.note.append(f"q{int(q)} curved{int(curved)} pin{n1} hole{n2} c{(Rh-R)/R:.3g}R d{d/R:.3g}R")
    ro = Rh * r.uniform(1.3, 3)
    s.body("ring", annulus(Rh, ro, r.randint(1, 5), n2), la, q, supports='[{ on = "outer", x = 0, y = 0 }]', curved=f'[{{ on = "inner", radius = {f(Rh)} }}]' if curved else None)
    s.body("pin", annulus(R * r.uniform(0.2, 0.6), R, r.randint(1, 5), n1), lb, q, supports=f'[{{ on = "inner", x = 0, y = {f(-d)} }}]', curved=f'[{{ on = "outer", radius = {f(R)} }}]' if curved else None)
    s.contact(("ring", "inner"), ("pin", "outer"), passes(r))


def press_fit(r, s):
    q = r.random() < 0.4
    curved = q and r.random() < 0.8
    n = r.choice([8, 12, 16, 24, 32])
    n2 = n if r.random() < 0.5 else r.choice([8, 12, 16, 20, 28])
    if curved:
        n, n2 = max(n, 12), max(n2, 12)
    la, lb, small, E, E2 = two(r, s)
    dl = r.uniform(0.002, 0.01) if small else r.uniform(0.005, 0.05)
    s.key("initial-gaps", '"resolve"')
    incs(s, 1, 4)
    s.note.append(f"q{int(q)} curved{int(curved)} n{n},{n2} overlap{dl:.3g}")
    mode = r.choice(["fixed", "spring"])
    s.body("ring", annulus(1, r.uniform(1.5, 3), r.randint(2, 5), n2), la, q, curved='[{ on = "inner", radius = 1.0 }]' if curved else None,
           supports='[{ on = "outer", x = 0, y = 0 }]' if mode == "fixed" else None, foundations=f'[{{ on = "outer", stiffness = {f(E*r.uniform(0.01, 1))} }}]' if mode == "spring" else None)
    s.body("plug", annulus(r.uniform(0.3, 0.6), 1 + dl, r.randint(2, 5), n), lb, q, curved=f'[{{ on = "outer", radius = {f(1+dl)} }}]' if curved else None,
           foundations=f'[{{ on = "inner", stiffness = {f(E2*r.uniform(0.001, 0.1))} }}]')
    s.contact(("ring", "inner"), ("plug", "outer"), passes(r))


def block_on_block(r, s):
    q = r.random() < 0.4
    la, lb, small, E, E2 = two(r, s)
    n1, n2 = r.choice([1, 2, 3, 5, 8, 13, 20]), r.choice([1, 2, 3, 4, 7, 11, 17])
    incs(s)
    common(s, r)
    h1, h2 = r.uniform(0.3, 1.2), r.uniform(0.3, 1.2)
    load = r.choice(["move", "traction"])
    e = r.uniform(0.002, 0.02) if small else r.uniform(0.01, 0.15)
    w = r.choice([2, 2, r.uniform(0.5, 1.5)])
    s.note.append(f"q{int(q)} n{n1},{n2} {load} e{e:.3g} w{w:.3g}")
    s.body("lower", rect(0, 2, n1, -h1, 0, r.randint(1, 6)), la, q, supports='[{ on = "bottom", x = 0, y = 0 }]')
    x0 = (2 - w) / 2
    up = rect(x0, x0 + w, n2, 0, h2, r.randint(1, 6))
    if load == "move":
        s.body("upper", up, lb, q, supports=f'[{{ on = "top", x = 0, y = {f(-e*(h1+h2))} }}]')
    else:
        s.body("upper", up, lb, q, supports='[{ on = "left", x = 0 }, { on = "right", x = 0 }]', tractions=f'[{{ on = "top", force = [0, {f(-e*min(E, E2))}] }}]')
    s.contact(("lower", "top"), ("upper", "bottom"), passes(r))


def overhang(r, s):
    q = r.random() < 0.4
    la, lb, small, E, E2 = two(r, s, 1.0)
    n1, n2 = r.choice([2, 4, 6, 10, 16]), r.choice([2, 3, 5, 9, 15])
    incs(s)
    common(s, r)
    over = r.uniform(0.1, 1.0)
    h = r.uniform(0.3, 1)
    e = r.uniform(0.002, 0.015) if small else r.uniform(0.01, 0.08)
    s.note.append(f"q{int(q)} n{n1},{n2} over{over:.3g} e{e:.3g}")
    s.body("lower", rect(0, 2, n1, -1, 0, r.randint(1, 5)), la, q, supports='[{ on = "bottom", x = 0, y = 0 }]')
    shift = r.choice([0, over])
    s.body("upper", rect(-over + shift, 2 + over + shift, n2, 0, h, r.randint(1, 4)), lb, q, supports=f'[{{ on = "top", x = 0, y = {f(-e)} }}]')
    s.contact(("lower", "top"), ("upper", "bottom"), passes(r))


def arc_punch(r, s):
    """an arc of 2 to 6 facets on a flat or curved foundation"""
    q = r.random() < 0.5
    la, lb, small, *_ = two(r, s)
    na, R, half = r.randint(2, 6), 1.0, r.uniform(0.25, 0.9)
    curved = q and r.random() < 0.7
    t = r.uniform(0.2, 0.6)
    incs(s)
    common(s, r)

    def arc(u, v):
        a = -half + 2 * half * u
        rr = R - t * v
        return (rr * math.sin(a), -rr * math.cos(a))
    low = -R if curved or na % 2 == 0 else -R * math.cos(half / na)
    m = grid2(s, "punch", na, r.randint(1, 4), arc)
    d = r.uniform(0.003, 0.015) if small else r.uniform(0.01, 0.06)
    fnd = r.choice(["flat", "flat", "bowl", "hill"])
    nb = r.choice([2, 3, 4, 6, 10, 16])
    s.note.append(f"q{int(q)} curved{int(curved)} na{na} half{half:.3g} {fnd}{nb} d{d:.3g}")
    cv = None
    if fnd == "flat":
        mb, c = rect(-1.2, 1.2, nb, -0.8, 0, r.randint(1, 4)), 0
    else:
        Rb = r.uniform(1.3, 4)
        sg = 1 if fnd == "bowl" else -1
        hb = min(1.2, 0.8 * Rb) / Rb
        # arc with its lowest (bowl) or highest (hill) point at y = 0
        mb = grid2(s, "found", nb, 3, lambda u, v: ((Rb + sg * 0.8 * (1 - v)) * math.sin(hb * (2 * u - 1)), sg * (Rb - (Rb + sg * 0.8 * (1 - v)) * math.cos(hb * (2 * u - 1)))) if sg > 0 or 0.8 < Rb else None)
        cq = q and curved
        if cq:
            cv = f'[{{ on = "top", radius = {f(Rb)}, centre = [0.0, {f(sg*Rb)}] }}]'
        # height of the chords at x = 0
        c = 0 if cq or nb % 2 == 0 else sg * Rb * (1 - math.cos(hb / nb))
        c = max(c, 0)
    s.body("found", mb, la, q, curved=cv, supports='[{ on = "bottom", x = 0, y = 0 }]')
    s.body("punch", m, lb, q, curved=f'[{{ on = "bottom", radius = {f(R)} }}]' if curved else None, translated=[0.0, c - low], supports=f'[{{ on = "top", x = 0, y = {f(-d)} }}]')
    if fnd == "bowl":
        s.key("overlap-tolerance", 0.2)
    s.contact(("found", "top"), ("punch", "bottom"), r.choice([None, None, "first-is-slave", "second-is-slave"]))


def cylinders(r, s):
    q = r.random() < 0.4
    curved = q and r.random() < 0.7
    la, lb, small, *_ = two(r, s)
    n1, n2 = r.choice([8, 12, 16, 24, 32]), r.choice([8, 12, 20, 28, 40])
    R2 = r.uniform(0.5, 2)
    incs(s)
    common(s, r)
    d = r.uniform(0.003, 0.02) if small else r.uniform(0.01, 0.1)
    off = r.choice([0, 0, r.uniform(-0.3, 0.3)])
    s.note.append(f"q{int(q)} curved{int(curved)} n{n1},{n2} off{off:.3g} d{d:.3g}")
    y = math.sqrt((1 + R2) ** 2 - off ** 2)
    for nm, R, n, l, t, sup in (("lower", 1.0, n1, la, None, "x = 0, y = 0"), ("upper", R2, n2, lb, [off, y], f"x = 0, y = {f(-d)}")):
        s.body(nm, annulus(R * 0.4, R, r.randint(1, 5), n), l, q, curved=f'[{{ on = "outer", radius = {f(R)} }}]' if curved else None, translated=t, supports=f'[{{ on = "inner", {sup} }}]')
    s.contact(("lower", "outer"), ("upper", "outer"), passes(r))


def ironing(r, s):
    q = r.random() < 0.3
    curved = q and r.random() < 0.7
    na, nx = r.choice([6, 8, 12, 16]), r.choice([8, 12, 20, 30])
    E = 10 ** r.uniform(0, 4)
    k = r.choice([1, 3, 30])
    la, lb = law(r, False, E), law(r, False, E * k)
    s.note.append(f"large q{int(q)} curved{int(curved)} na{na} nx{nx} k{k}")
    common(s, r)
    d = r.uniform(0.01, 0.06)
    way = r.uniform(0.1, 1.2)
    s.tab.append(f"[[phase]]\nname = \"press\"\nuntil = 1\nincrements = {r.randint(1, 3)}\n\n[[phase]]\nname = \"slide\"\nuntil = 2\nincrements = {r.randint(2, 8)}")
    s.body("block", rect(-1, 2.5, nx, -1, 0, r.randint(2, 6)), la, q, supports='[{ on = "bottom", x = 0, y = 0 }]')
    s.body("die", halfdisc(0.5, r.randint(2, 4), na), lb, q, curved='[{ on = "arc", radius = 0.5 }]' if curved else None, translated=[0.0, 0.5],
           supports=f'[{{ on = "flat", motion = [{{ translation = [0.0, {f(-d)}], amplitude = [[0, 0], [1, 1]] }}, {{ translation = [{f(way)}, 0.0], amplitude = [[1, 0], [2, 1]] }}] }}]')
    s.contact(("block", "top"), ("die", "arc"), passes(r))


def sandwich(r, s):
    """three bodies: a disc (hollow or half) between blocks, or three blocks"""
    q = r.random() < 0.4
    small = r.random() < 0.35
    E = 10 ** r.uniform(0, 4)
    L = [law(r, small, E * 10 ** r.uniform(-1, 1)) for _ in range(3)]
    incs(s)
    common(s, r)
    d = r.uniform(0.003, 0.015) if small else r.uniform(0.01, 0.08)
    if r.random() < 0.5:
        n = r.choice([8, 12, 16, 24, 32])
        curved = q and r.random() < 0.7
        s.note.append(f"{'small' if small else 'large'} q{int(q)} disc{n}")
        s.body("low", rect(-1, 1, r.choice([4, 7, 12]), -0.6, 0, 3), L[0], q, supports='[{ on = "bottom", x = 0, y = 0 }]')
        s.body("mid", annulus(0.25, 0.5, r.randint(1, 4), n), L[1], q, translated=[0.0, 0.5], curved='[{ on = "outer", radius = 0.5 }]' if curved else None, foundations=f'[{{ on = "inner", stiffness = {f(E*0.01)} }}]')
        s.body("up", rect(-1, 1, r.choice([3, 6, 11]), 1, 1.6, 3), L[2], q, supports=f'[{{ on = "top", x = 0, y = {f(-d)} }}]')
        s.contact(("low", "top"), ("mid", "outer"), passes(r))
        s.contact(("mid", "outer"), ("up", "bottom"), passes(r))
    else:
        n = [r.choice([1, 2, 3, 5, 9]) for _ in range(3)]
        s.note.append(f"{'small' if small else 'large'} q{int(q)} blocks{n}")
        s.body("low", rect(0, 2, n[0], -0.6, 0, 3), L[0], q, supports='[{ on = "bottom", x = 0, y = 0 }]')
        s.body("mid", rect(0.3, 1.7, n[1], 0, 0.5, 2), L[1], q, symmetry=None, supports='[{ on = "left", x = 0 }]')
        s.body("up", rect(0.1, 1.9, n[2], 0.5, 1.1, 3), L[2], q, supports=f'[{{ on = "top", x = 0, y = {f(-d)} }}]')
        s.contact(("low", "top"), ("mid", "bottom"), passes(r))
        s.contact(("mid", "top"), ("up", "bottom"), passes(r))


def tied(r, s):
    """a half disc that is tied to a block above it, on a block below"""
    q = r.random() < 0.4
    la, lb, small, E, E2 = two(r, s, 1.0)
    na = r.choice([6, 8, 12, 20])
    incs(s)
    d = r.uniform(0.003, 0.02) if small else r.uniform(0.01, 0.08)
    s.note.append(f"q{int(q)} na{na}")
    s.body("base", rect(-2, 2, r.choice([5, 8, 15, 24]), -1, 0, r.randint(2, 6)), la, q, supports='[{ on = "bottom", x = 0, y = 0 }]')
    curved = q and r.random() < 0.6
    s.body("disc", halfdisc(1, r.randint(2, 5), na), lb, q, translated=[0.0, 1.0 if curved or na % 2 == 0 else math.cos(PI / na / 2)], curved='[{ on = "arc", radius = 1.0 }]' if curved else None)
    s.body("head", rect(-1, 1, r.choice([3, 5, 8]), 1, 1.5, r.randint(1, 3)), law(r, small, E), q, supports=f'[{{ on = "top", x = 0, y = {f(-d)} }}]')
    s.tie(("disc", "flat"), ("head", "bottom"))
    s.contact(("base", "top"), ("disc", "arc"), passes(r))


def column(r, s):
    """a column clamped below, whose flat end is pressed by a stiff head that is guided: below its buckling load"""
    q = r.random() < 0.6
    sl = r.uniform(3, 12)
    h = 1 / sl
    # sway with both ends guided: e = pi^2/12 (h/L)^2
    fr = r.uniform(0.1, 0.7)
    e = fr * PI ** 2 / 12 * h * h
    E = 10 ** r.uniform(0, 4)
    nx = r.choice([1, 2, 3, 4]) if q else r.choice([3, 4, 6])
    ny = max(4, int(nx * sl * r.uniform(0.4, 0.8)))
    incs(s, 1, 3)
    s.note.append(f"large q{int(q)} L/h{sl:.3g} P/Pcr~{fr:.3g} n{nx}x{ny}")
    s.body("column", rect(-h / 2, h / 2, nx, 0, 1, ny, "alternating"), law(r, False, E, 0.3), q, supports='[{ on = "bottom", x = 0, y = 0 }]')
    W = h * r.uniform(1, 3)
    Hh = 0.3
    if r.random() < 0.5:
        s.body("head", rect(-W / 2, W / 2, r.choice([1, 3, 4, 7]), 1, 1 + Hh, 2), law(r, False, E * 10 ** r.uniform(0, 3), 0.3), q, supports=f'[{{ on = "top", x = 0, y = {f(-e)} }}]')
    else:
        Ep = E / (1 - 0.09)
        s.body("head", rect(-W / 2, W / 2, r.choice([1, 3, 4, 7]), 1, 1 + Hh, 2), law(r, False, E * 10 ** r.uniform(1, 3), 0.3), q, supports='[{ on = "left", x = 0 }, { on = "right", x = 0 }]',
               tractions=f'[{{ on = "top", force = [0, {f(-Ep*e*h/W)}] }}]')
    s.contact(("column", "top"), ("head", "bottom"), passes(r))


def heavy_head(r, s):
    """a stiff heavy head, tied to or standing on a stocky column; stable"""
    q = r.random() < 0.6
    sl = r.uniform(1, 3)
    h = 1 / sl
    E = 10 ** r.uniform(0, 4)
    Ep = E / (1 - 0.09)
    H = r.uniform(0.3, 1)
    # the load acts at the head's body: a rigid link of H/2 above a cantilever lowers the load; 1/4 of the cantilever's at most
    fr = r.uniform(0.05, 0.4)
    P = fr * PI ** 2 / 4 * Ep * h ** 3 / 12 / (1 + H / 2) ** 2
    P = min(P, 0.1 * Ep * h)
    W = h * r.uniform(1, 3)
    tie = r.random() < 0.5
    s.note.append(f"large q{int(q)} L/h{sl:.3g} {'tied' if tie else 'contact'} P/Pcr<{fr:.3g}")
    incs(s, 1, 3)
    nx = r.choice([2, 3, 4])
    s.body("column", rect(-h / 2, h / 2, nx, 0, 1, max(3, int(nx * sl)), "alternating"), law(r, False, E, 0.3), q, supports='[{ on = "bottom", x = 0, y = 0 }]')
    s.body("head", rect(-W / 2, W / 2, r.choice([2, 3, 5]), 1, 1 + H, 3), law(r, False, E * 10 ** r.uniform(2, 4), 0.3), q,
           supports=None if tie else '[{ on = "left", x = 0 }]', body_force=f"[0.0, {f(-P/(W*H))}]")
    if tie:
        s.tie(("column", "top"), ("head", "bottom"))
        s.body("floor", rect(-1, 1, 5, -1, -0.5, 1), law(r, False, E, 0.3), q, supports='[{ on = "bottom", x = 0, y = 0 }]')
        s.body("foot", rect(-0.5, 0.5, 4, -0.5, 0.0, 1), law(r, False, E, 0.3), q, supports=f'[{{ on = "top", x = 0, y = {f(-0.001)} }}]')
        s.contact(("floor", "top"), ("foot", "bottom"))
    else:
        s.contact(("column", "top"), ("head", "bottom"), passes(r))


def neutral(r, s):
    """stacks whose middle slides, rollers between plates"""
    q = r.random() < 0.4
    E = 10 ** r.uniform(0, 4)
    L = [law(r, False, E * 10 ** r.uniform(-0.5, 0.5), 0.3) for _ in range(3)]
    incs(s, 1, 3)
    d = r.uniform(0.005, 0.05)
    W = 1.5
    roller = r.random() < 0.5
    s.body("low", rect(-W, W, r.choice([4, 9, 16]), -0.6, 0, 3), L[0], q, supports='[{ on = "bottom", x = 0, y = 0 }]')
    if roller:
        n = r.choice([8, 12, 16, 24, 32])
        curved = q and r.random() < 0.7
        s.note.append(f"large q{int(q)} roller{n} d{d:.3g}")
        s.body("mid", f"{{ disc = {{ radius = 0.5, segments = {n}, rings = {max(2, n//6)} }} }}", L[1], q, translated=[0.0, 0.5], curved='[{ on = "boundary", radius = 0.5 }]' if curved else None)
        a = b = "boundary"
    else:
        n = r.choice([2, 3, 5, 9])
        s.note.append(f"large q{int(q)} slider{n} d{d:.3g}")
        s.body("mid", rect(-0.6, 0.6, n, 0, 1, max(2, n)), L[1], q)
        a, b = "bottom", "top"
    s.body("up", rect(-W, W, r.choice([3, 6, 14]), 1, 1.6, 3), L[2], q, supports=f'[{{ on = "top", x = 0, y = {f(-d)} }}]')
    s.contact(("low", "top"), ("mid", a))
    s.contact(("mid", b), ("up", "bottom"))


# ---------------------------------------------------------------- revolution

def ball_on_block(r, s):
    q = r.random() < 0.5
    la, lb, small, *_ = two(r, s)
    na = r.choice([2, 3, 4, 6, 10, 16])
    curved = q and r.random() < 0.7
    incs(s)
    d = r.uniform(0.003, 0.02) if small else r.uniform(0.01, 0.08)
    s.note.append(f"q{int(q)} curved{int(curved)} na{na}")
    nx = r.choice([3, 5, 8, 14])
    s.body("block", rect(0, r.uniform(0.8, 2), nx, -1, 0, r.randint(2, 6)), la, q, revolution="true", supports='[{ on = "bottom", x = 0, y = 0 }]')
    s.body("ball", quarter(1, r.randint(2, 6), na), lb, q, revolution="true", translated=[0.0, 1.0], curved='[{ on = "arc", radius = 1.0 }]' if curved else None, supports=f'[{{ on = "flat", x = 0, y = {f(-d)} }}]')
    s.contact(("block", "top"), ("ball", "arc"), passes(r))


def ball_in_cup(r, s):
    q = r.random() < 0.5
    la, lb, small, *_ = two(r, s)
    na, nc = r.choice([2, 3, 5, 8, 14]), r.choice([2, 3, 4, 7, 12])
    curved = q and r.random() < 0.7
    c = 10 ** r.uniform(-2.5, -0.7)
    R2 = 1 + c + (0 if curved else 1 - math.cos(PI / 4 / nc))
    incs(s, 2, 5)
    d = (R2 - 1) + (r.uniform(0.003, 0.01) if small else r.uniform(0.01, 0.06))
    s.note.append(f"q{int(q)} curved{int(curved)} na{na} nc{nc} c{c:.3g}")
    t = r.uniform(0.3, 1)

    def cup(u, v):
        a, rr = u * PI / 2, R2 + t * (1 - v)
        x = rr * math.sin(a)
        return (0.0 if u == 0 else x, -rr * math.cos(a))
    s.body("cup", grid2(s, "cup", nc, r.randint(1, 4), cup), la, q, revolution="true", curved=f'[{{ on = "top", radius = {f(R2)} }}]' if curved else None, supports='[{ on = "bottom", x = 0, y = 0 }]')
    s.body("ball", quarter(1, r.randint(2, 5), na), lb, q, revolution="true", curved='[{ on = "arc", radius = 1.0 }]' if curved else None, supports=f'[{{ on = "flat", x = 0, y = {f(-d)} }}]')
    s.contact(("cup", "top"), ("ball", "arc"), passes(r))


def rings(r, s):
    q = r.random() < 0.5
    la, lb, small, E, E2 = two(r, s)
    n1, n2 = r.choice([1, 2, 4, 7]), r.choice([1, 3, 5, 8])
    fit = r.random() < 0.6
    incs(s)
    e = r.uniform(0.001, 0.01) if small else r.uniform(0.005, 0.03)
    s.note.append(f"q{int(q)} n{n1},{n2} {'fit' if fit else 'pressure'} e{e:.3g}")
    ri = r.uniform(0.4, 0.8)
    if fit:
        s.key("initial-gaps", '"resolve"')
    ov = e if fit else 0.0
    s.body("outer", rect(1, r.uniform(1.3, 2), r.randint(1, 4), 0, 1, n1), la, q, revolution="true", supports='[{ on = "bottom", y = 0 }]')
    s.body("inner", rect(ri, 1 + ov, r.randint(1, 4), 0, 1, n2), lb, q, revolution="true", supports='[{ on = "bottom", y = 0 }]',
           tractions=None if fit else f'[{{ on = "left", force = [{f(e*E2)}, 0.0] }}]')
    s.contact(("outer", "left"), ("inner", "right"), passes(r))


# ---------------------------------------------------------------- space

def integ(r, s):
    if r.random() < 0.4:
        s.key("integration", '"exact"')
        s.note.append("exact")
    elif r.random() < 0.1:
        s.key("projection", '"closest"')
        s.note.append("closest")


def blocks_in_space(r, s):
    q = r.random() < 0.3
    la, lb, small, E, E2 = two(r, s)
    integ(r, s)
    incs(s, 1, 2)
    m = 3 if q else 5
    n1, n2 = [r.randint(1, m), r.randint(1, m), r.randint(1, 3)], [r.randint(1, m), r.randint(1, m), r.randint(1, 3)]
    e = r.uniform(0.002, 0.015) if small else r.uniform(0.01, 0.1)
    sx = r.choice([1.0, 0.6, 1.3])
    s.note.append(f"q{int(q)} n{n1},{n2} sx{sx}")
    s.body("lower", box([0, 0, -0.7], [1, 1, 0.7], n1), la, q, supports='[{ on = "bottom", x = 0, y = 0, z = 0 }]')
    s.body("upper", box([(1 - sx) / 2, r.choice([0, 0.15]), 0], [sx, 0.8, 0.6], n2), lb, q, supports=f'[{{ on = "top", x = 0, y = 0, z = {f(-e)} }}]')
    s.contact(("lower", "top"), ("upper", "bottom"), passes(r))


def ball_in_space(r, s):
    q = r.random() < 0.25
    la, lb, small, *_ = two(r, s)
    integ(r, s)
    incs(s, 1, 3)
    curved = q and r.random() < 0.7
    sh = r.choice([2, 3]) if q else r.choice([2, 3, 4])
    d = r.uniform(0.005, 0.02) if small else r.uniform(0.02, 0.1)
    m = 3 if q else 6
    n = [r.randint(2, m), r.randint(2, m), r.randint(1, 3)]
    g = r.choice(["hemisphere", "eighth-sphere"])
    s.note.append(f"q{int(q)} curved{int(curved)} {g}{sh} n{n}")
    cv = '[{ on = "surface", radius = 1.0 }]' if curved else None
    lo = [-1.2, -1.2, -0.8] if g == "hemisphere" else [0, 0, -0.8]
    sz = [2.4, 2.4, 0.8] if g == "hemisphere" else [1.2, 1.2, 0.8]
    sym = None if g == "hemisphere" else '["left", "front"]'
    s.body("block", box(lo, sz, n), la, q, symmetry=sym, supports='[{ on = "bottom", x = 0, y = 0, z = 0 }]')
    s.body("ball", f"{{ {g} = {{ radius = 1.0, shells = {sh} }} }}", lb, q, symmetry=sym, curved=cv, translated=[0.0, 0.0, 1.0], supports=f'[{{ on = "flat", x = 0, y = 0, z = {f(-d)} }}]')
    s.contact(("block", "top"), ("ball", "surface"), passes(r))


def cylinder_on_block(r, s):
    q = r.random() < 0.25
    la, lb, small, *_ = two(r, s)
    integ(r, s)
    incs(s, 1, 2)
    na = r.choice([4, 6, 8] if q else [4, 6, 8, 12])
    curved = q and r.random() < 0.7
    d = r.uniform(0.005, 0.02) if small else r.uniform(0.02, 0.1)
    n = [r.randint(2, 4 if q else 7), 2, r.randint(1, 2 if q else 4)]
    nz = r.randint(1, 2 if q else 4)
    over = r.choice([0, 0, 0.3])
    s.note.append(f"q{int(q)} curved{int(curved)} na{na} n{n} nz{nz} over{over}")
    s.body("block", box([-1.3, -0.8, 0 - over], [2.6, 0.8, 1 + 2 * over], n), la, q, supports='[{ on = "front", x = 0, y = 0, z = 0 }]')
    s.body("cyl", f"{{ extrude = {{ plane = {halfdisc(1, 2, na)}, z = {{ from = 0, to = 1, count = {nz} }}, caps = [\"c0\", \"c1\"] }} }}", lb, q, translated=[0.0, 1.0, 0.0],
           curved='[{ on = "arc", radius = 1.0, axis = [0, 0, 1] }]' if curved else None, supports=f'[{{ on = "flat", x = 0, y = {f(-d)}, z = 0 }}]')
    s.contact(("block", "back"), ("cyl", "arc"), passes(r))


def crossed_beams(r, s):
    """beams with arched faces that cross; each is clamped at its ends"""
    q = r.random() < 0.2
    la, lb, small, *_ = two(r, s, 1.0)
    integ(r, s)
    incs(s, 1, 3)
    R = r.uniform(0.4, 2)
    w, H, L = 0.3, 0.4, 1.0
    n = (r.randint(4, 6), 2, 2) if q else (r.randint(5, 10), r.choice([2, 4]), r.randint(2, 3))
    m = (r.randint(4, 6), 2, 2) if q else (r.randint(5, 10), r.choice([2, 4]), r.randint(2, 3))
    d = r.uniform(0.005, 0.02) if small else r.uniform(0.02, 0.15)
    s.note.append(f"q{int(q)} n{n},{m} R{R:.3g} d{d:.3g}")

    def low(a, b, c):
        x, y = L * (2 * a - 1), w * (2 * b - 1)
        return (x, y, -H + c * (H - y * y / (2 * R)))

    def up(a, b, c):
        y, x = L * (2 * a - 1), -w * (2 * b - 1)
        z0 = x * x / (2 * R)
        return (x, y, z0 + c * (H - z0))
    s.body("lower", grid3(s, "lower", n, low), la, q, supports='[{ on = "left", x = 0, y = 0, z = 0 }, { on = "right", x = 0, y = 0, z = 0 }]')
    s.body("upper", grid3(s, "upper", m, up), lb, q, supports=f'[{{ on = "left", x = 0, y = 0, z = {f(-d)} }}, {{ on = "right", x = 0, y = 0, z = {f(-d)} }}]')
    s.contact(("lower", "top"), ("upper", "bottom"), passes(r))


KINDS = {k.__name__: k for k in (half_disc_on_block, stiff_on_soft, closest_points, pin_in_hole, press_fit, block_on_block, overhang, arc_punch, cylinders,
                                 ironing, sandwich, tied, column, heavy_head, neutral, ball_on_block, ball_in_cup, rings, blocks_in_space, ball_in_space,
                                 cylinder_on_block, crossed_beams)}


def main():
    p = argparse.ArgumentParser()
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--count", type=int, default=100)
    p.add_argument("--out", required=True)
    p.add_argument("--kinds", default="")
    a = p.parse_args()
    os.makedirs(a.out, exist_ok=True)
    kinds = [k for k in a.kinds.split(",") if k] or list(KINDS)
    for i in range(a.count):
        kind = kinds[i % len(kinds)]
        s = S(random.Random(f"{a.seed}/{i}/{kind}"))
        KINDS[kind](s.r, s)
        name = f"{kind}-{a.seed}-{i:04}"
        text = s.text(f"{kind}: {' '.join(s.note)}")
        for m, c in s.files.items():
            text = text.replace(f'"@{m}"', f'"{name}-{m}.msh"')
            open(os.path.join(a.out, f"{name}-{m}.msh"), "w").write(c)
        open(os.path.join(a.out, name + ".toml"), "w").write(text)


if __name__ == "__main__":
    main()

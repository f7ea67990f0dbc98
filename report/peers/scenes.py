"""The two scenes of the comparison. Units are the scene's own."""

import math

import meshes

CONTACT = 1
# seconds after which a run is given up
LIMIT = 150


class HalfDisc:
    """The lower half of a disc of radius 1 on a rigid line, in plane strain, pressed by a traction on its flat top. Hertz: a = 0.05."""

    name = "half_disc"
    young, poisson, zone = 1000.0, 0.3, 0.05
    top = 3
    sizes = {4: "a/4", 8: "a/8", 16: "a/16", 32: "a/32"}
    force = math.pi * young / (1 - poisson**2) * zone**2 / 4

    @classmethod
    def mesh(cls, folder, fineness, degree):
        path = folder / f"{cls.name}_{fineness}_P{degree}.msh"
        meshes.write(path, meshes.HALF_DISC, 2, cls.zone, cls.zone / fineness, degree)
        return meshes.Mesh(path, fineness)


class Ball:
    """An eighth of a ball of radius 50 on a rigid plane, whose flat top comes down by 2."""

    name = "ball"
    young, poisson, zone = 20000.0, 0.3, 10.0
    top, descent = 4, 2.0
    sizes = {2: "a/2", 3: "a/3", 4: "a/4", 6: "a/6"}

    @classmethod
    def mesh(cls, folder, fineness, degree):
        path = folder / f"{cls.name}_{fineness}_P{degree}.msh"
        meshes.write(path, meshes.BALL, 3, cls.zone, cls.zone / fineness, degree)
        return meshes.Mesh(path, fineness)


ALL = [HalfDisc, Ball]

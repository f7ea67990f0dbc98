"""The scenes of the comparison. Units are the scene's own."""

import math

import meshes

# the label of the boundary in contact, where there is one
CONTACT = 1
# seconds after which a run is given up
LIMIT = 150


class HalfDisc:
    """The lower half of a disc of radius 1 on a rigid line, in plane strain, pressed by a traction on its flat top. Hertz: a = 0.05."""

    name = "half_disc"
    young, poisson, zone = 1000.0, 0.3, 0.05
    top, measured = 3, CONTACT
    sizes = {4: "a/4", 8: "a/8", 16: "a/16", 32: "a/32"}
    force = math.pi * young / (1 - poisson**2) * zone**2 / 4

    @classmethod
    def mesh(cls, folder, fineness, degree):
        path = folder / f"{cls.name}_{fineness}_P{degree}.msh"
        meshes.write(path, meshes.HALF_DISC, 2, cls.zone / fineness, degree, zone=cls.zone)
        return meshes.Mesh(path, fineness)


class Ball:
    """An eighth of a ball of radius 50 on a rigid plane, whose flat top comes down by 2."""

    name = "ball"
    young, poisson, zone = 20000.0, 0.3, 10.0
    top, descent, measured = 4, 2.0, CONTACT
    sizes = {2: "a/2", 3: "a/3", 4: "a/4", 6: "a/6"}

    @classmethod
    def mesh(cls, folder, fineness, degree):
        path = folder / f"{cls.name}_{fineness}_P{degree}.msh"
        meshes.write(path, meshes.BALL, 3, cls.zone / fineness, degree, zone=cls.zone)
        return meshes.Mesh(path, fineness)


class PressFit:
    """Two rings of radii 0.5, 1 and 1.5 in plane strain, a quarter of each, of which the inner one is larger by a thousandth of its radius."""

    name = "press_fit"
    young, poisson, zone = 1000.0, 0.3, 1.0
    interference, measured = 1e-3, CONTACT
    radii = 0.5, 1.0, 1.5
    sizes = {8: "R/8", 16: "R/16", 32: "R/32", 64: "R/64"}

    @classmethod
    def mesh(cls, folder, fineness, degree):
        size = cls.zone / fineness
        least, middle, most = cls.radii
        # facets of the outer ring are larger, so that nodes do not meet
        rings = {"inner": (least, middle + cls.interference, 2, 1.0), "outer": (middle, most, 4, 1.27)}
        other = None
        for name in ("outer", "inner"):
            inside, outside, contact, larger = rings[name]
            path = folder / f"{cls.name}_{name}_{fineness}_P{degree}.msh"
            meshes.write(path, meshes.RING, 2, larger * size, degree, inside=inside, outside=outside, contact=contact)
            other = meshes.Mesh(path, fineness, other)
        return other


class Beams:
    """Three cantilevers in a stack, clamped at one end, the upper one pulled down by a traction of 100 on its top: section 6.2 of the paper, linear."""

    name = "beams"
    young, poisson, zone = 2e5, 0.0, 25.0
    bottom, left, top, measured = 2, 4, 6, 6
    traction = 100.0
    sizes = {2: "H/2", 3: "H/3", 4: "H/4"}

    @classmethod
    def mesh(cls, folder, fineness, degree):
        """The upper beam and those below it."""
        other = None
        for number in range(3):
            # the beam in the middle has one cell more along, so that nodes do not meet
            divisions = {"along": 4 * fineness + (number == 1), "across": fineness, "low": 25 * number}
            path = folder / f"{cls.name}_{number + 1}_{fineness}_P{degree}.msh"
            meshes.write(path, meshes.BEAM, 3, 25 / fineness, degree, **divisions)
            other = meshes.Mesh(path, fineness, other)
        return other


ALL = [HalfDisc, Ball, PressFit, Beams]

"""The scenes of the comparison. Units are the scene's own."""

import math

import numpy as np

import meshes

# the label of the boundary in contact, where there is one
CONTACT = 1
# seconds after which a run is given up
LIMIT = 120


class Scene:
    """What scenes have in common. Each has `mesh(folder, fineness, degree)`, the mesh of its first body, which leads to the meshes of the next bodies."""

    @classmethod
    def coarse(cls, folder, degree):
        """The mesh that refining programs begin with. It knows nothing of the contact."""
        return cls.mesh(folder, cls.coarsest, degree)


class HalfDisc(Scene):
    """The lower half of a disc of radius 1 on a rigid line, in plane strain, pressed by a traction on its flat top. Hertz: a = 0.05."""

    name = "half_disc"
    young, poisson, zone = 1000.0, 0.3, 0.05
    top, measured = 3, CONTACT
    sizes = {4: "a/4", 8: "a/8", 16: "a/16", 32: "a/32"}
    coarsest = 1 / 2.4
    force = math.pi * young / (1 - poisson**2) * zone**2 / 4

    @classmethod
    def mesh(cls, folder, fineness, degree):
        path = folder / f"{cls.name}_{fineness:.3g}_P{degree}.msh"
        meshes.write(path, meshes.HALF_DISC, 2, cls.zone / fineness, degree, zone=cls.zone)
        return meshes.Mesh(path, fineness)

    @staticmethod
    def is_measured(x):
        """Which places are on the boundary that is measured."""
        return abs(np.hypot(x[:, 0], x[:, 1] - 1) - 1) < 1e-6


class Ball(Scene):
    """An eighth of a ball of radius 50 on a rigid plane, whose flat top comes down by 2."""

    name = "ball"
    young, poisson, zone = 20000.0, 0.3, 10.0
    top, descent, measured = 4, 2.0, CONTACT
    sizes = {2: "a/2", 3: "a/3", 4: "a/4", 6: "a/6"}
    coarsest = 1 / 1.2

    @classmethod
    def mesh(cls, folder, fineness, degree):
        path = folder / f"{cls.name}_{fineness:.3g}_P{degree}.msh"
        meshes.write(path, meshes.BALL, 3, cls.zone / fineness, degree, zone=cls.zone)
        return meshes.Mesh(path, fineness)

    @staticmethod
    def is_measured(x):
        """Which places are on the boundary that is measured."""
        return abs(np.linalg.norm(x - [0, 0, 50], axis=1) - 50) < 5e-5


class PressFit(Scene):
    """Two rings of radii 0.5, 1 and 1.5 in plane strain, a quarter of each, of which the inner one is larger by a thousandth of its radius."""

    name = "press_fit"
    young, poisson, zone = 1000.0, 0.3, 1.0
    interference, measured = 1e-3, CONTACT
    radii = 0.5, 1.0, 1.5
    sizes = {8: "R/8", 16: "R/16", 32: "R/32", 64: "R/64"}
    coarsest = 8

    @classmethod
    def mesh(cls, folder, fineness, degree):
        size = cls.zone / fineness
        least, middle, most = cls.radii
        # facets of the outer ring are larger, so that nodes do not meet
        rings = {"inner": (least, middle + cls.interference, 2, 1.0), "outer": (middle, most, 4, 1.27)}
        other = None
        for name in ("outer", "inner"):
            inside, outside, contact, larger = rings[name]
            path = folder / f"{cls.name}_{name}_{fineness:.3g}_P{degree}.msh"
            meshes.write(path, meshes.RING, 2, larger * size, degree, inside=inside, outside=outside, contact=contact)
            other = meshes.Mesh(path, fineness, other)
        return other

    @classmethod
    def is_measured(cls, x):
        """Which places are on the boundary that is measured."""
        return abs(np.hypot(x[:, 0], x[:, 1]) - cls.radii[1] - cls.interference) < 1e-7


class Beams(Scene):
    """Three cantilevers in a stack, clamped at one end, the upper one pulled down by a traction of 100 on its top: section 6.2 of the paper, linear."""

    name = "beams"
    young, poisson, zone = 2e5, 0.0, 25.0
    bottom, left, top, measured = 2, 4, 6, 6
    traction = 100.0
    sizes = {2: "H/2", 3: "H/3", 4: "H/4"}
    coarsest = 1

    @classmethod
    def mesh(cls, folder, fineness, degree):
        """The upper beam and the beams below it."""
        other = None
        for number in range(3):
            # the beam in the middle has one cell more along, so that nodes do not meet
            divisions = {"along": 4 * fineness + (number == 1), "across": fineness, "low": 25 * number}
            path = folder / f"{cls.name}_{number + 1}_{fineness:.3g}_P{degree}.msh"
            meshes.write(path, meshes.BEAM, 3, 25 / fineness, degree, **divisions)
            other = meshes.Mesh(path, fineness, other)
        return other

    @staticmethod
    def is_measured(x):
        """Which places are on the boundary that is measured."""
        return abs(x[:, 2] - 75) < 1e-9


class FiniteBeams(Beams):
    """The same beams, neo-Hookean: psi = mu/2 (tr C - 3 - 2 ln J), since nu = 0. The traction keeps its direction and is per area at rest."""

    name = "finite_beams"


class Blocks(Scene):
    """Three blocks of height 1 in a stack, in plane strain, of half-widths 3, 2.5 and 0.5 from below, of which the halves x > 0 are meshed: free of
    friction, held below, and under a traction of 1 on the top of the upper one. Corners press into flat sides, and the one in the middle
    lifts off beyond 1.3. Small strains."""

    name = "blocks"
    young, poisson, zone = 1000.0, 0.3, 1.0
    # the plane of symmetry has the label `left`; the lower block's bottom is held in y
    bottom, left, top, measured = 2, 4, 6, 6
    traction = 1.0
    widths = 3.0, 2.5, 0.5
    sizes = {4: "H/4", 8: "H/8", 16: "H/16", 32: "H/32"}
    coarsest = 4

    @classmethod
    def mesh(cls, folder, fineness, degree):
        """The upper block and the blocks below it."""
        other = None
        for number, wide in enumerate(cls.widths):
            # one more cell along the block in the middle, so that nodes do not meet
            along = round(wide * fineness) + (number == 1)
            path = folder / f"{cls.name}_{number + 1}_{fineness:.3g}_P{degree}.msh"
            places = {"low": number, "high": number + 1, "wide": wide, "along": along, "up": fineness}
            meshes.write(path, meshes.BLOCK, 2, 1 / fineness, degree, **places)
            other = meshes.Mesh(path, fineness, other)
        return other

    @staticmethod
    def is_measured(x):
        """Which places are on the boundary that is measured."""
        return abs(x[:, 1] - 3) < 1e-9


class Discs(Scene):
    """Section 6.1 of the paper: a rigid disc of radius 0.6 comes down by 1.125 inside a neo-Hookean ring of radii 0.7 and 2, held at its outside, in
    plane strain: psi = mu/2 (tr C - 3 - 2 ln J), since nu = 0. Measured is the force that presses the disc down, at the end."""

    name = "discs"
    young, poisson, zone = 1000.0, 0.0, 0.7
    outside, measured = 3, None
    descent = 1.125
    radii = 0.6, 0.7, 2.0
    sizes = {6: "R/6", 10: "R/10", 16: "R/16"}
    coarsest = 6

    @classmethod
    def mesh(cls, folder, fineness, degree):
        """The disc, and the ring around it."""
        radius, inside, outside = cls.radii
        size = inside / fineness
        path = folder / f"{cls.name}_ring_{fineness:.3g}_P{degree}.msh"
        meshes.write(path, meshes.ANNULUS, 2, size, degree, inside=inside, outside=outside)
        ring = meshes.Mesh(path, fineness)
        path = folder / f"{cls.name}_disc_{fineness:.3g}_P{degree}.msh"
        meshes.write(path, meshes.DISC, 2, 1.1 * size, degree, radius=radius)
        return meshes.Mesh(path, fineness, ring)


class Ironing(Scene):
    """A stiff die with a round bottom of radius 3 is pressed by 0.75 into a soft slab of 9 x 3, which is held below, and slid along by 2, in plane
    strain; both are neo-Hookean: psi = mu/2 (tr C - 3 - 2 ln J), since nu = 0. Measured is the force that presses the die down, as the mean of ten
    places 0.2, 0.4, ... 2 of the way along the slab."""

    name = "ironing"
    young, poisson, zone = 1.0, 0.0, 3.0
    stiff = 1000.0
    bottom, top, measured = 2, 6, None
    press, slide, places = 0.75, 2.0, 10
    # of the round bottom, and where its middle is across
    radius, middle = 3.0, 2.5
    sizes = {6: "H/6", 9: "H/9", 14: "H/14"}
    coarsest = 6

    @classmethod
    def mesh(cls, folder, fineness, degree):
        """The die, and the slab below it."""
        size = 3 / fineness
        path = folder / f"{cls.name}_slab_{fineness:.3g}_P{degree}.msh"
        places = {"low": 0, "high": 3, "wide": 9, "along": 3 * fineness, "up": fineness}
        meshes.write(path, meshes.BLOCK, 2, size, degree, **places)
        slab = meshes.Mesh(path, fineness)
        path = folder / f"{cls.name}_die_{fineness:.3g}_P{degree}.msh"
        places = {"middle": cls.middle, "low": 3, "high": 4.8, "radius": cls.radius, "half": 2.25}
        meshes.write(path, meshes.DIE, 2, 0.9 * size, degree, **places)
        return meshes.Mesh(path, fineness, slab)


ALL = [HalfDisc, Ball, PressFit, Blocks, Beams, FiniteBeams, Discs, Ironing]

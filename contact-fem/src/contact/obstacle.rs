//! Rigid obstacles without a mesh: where they begin is told by a signed distance.
//!
//! The gap of a point is the signed distance d there, its normal n = ∇d, and ∇²d tells how the normal turns as the
//! point moves. Rows on an obstacle are those of a pass whose master has no nodes.

#[cfg(any(feature = "plot", feature = "vtk"))]
pub(crate) mod outline;

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use super::closed_surface::ClosedSurface;
use crate::error::Error;
use crate::mesh::{Mesh, read::MeshFile};
use crate::program::{Motion, Pose, axis_of, direction, samples_with};
use crate::tensor::{Matrix, Vector};

/// A signed distance (UL) by position (UL).
type Distance<const D: usize> = Arc<dyn Fn(&Vector<D>) -> f64 + Send + Sync>;

/// A rigid obstacle, which bodies must not penetrate: a half-space, a disc or ball, a cylinder, a box, a cavity, a closed
/// surface of facets, or anything else with a signed distance.
///
/// ```
/// use contact_fem::Obstacle;
///
/// # fn main() -> Result<(), contact_fem::Error> {
/// let floor = Obstacle::half_space([0.0, 0.0, -1.0], [0.0, 0.0, 2.0])?;
/// assert_eq!(floor.distance(&[3.0, 4.0, 5.0].into()), 6.0);
/// let cup = Obstacle::cavity([0.0; 3], 2.0)?;
/// assert_eq!(cup.distance(&[0.0, 0.5, 0.0].into()), 1.5);
/// assert!(Obstacle::ball([0.0; 3], -1.0).is_err());
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Obstacle<const D: usize> {
    shape: Shape<D>,
    motion: Option<Motion<D>>,
}

#[derive(Clone)]
enum Shape<const D: usize> {
    HalfSpace {
        point: Vector<D>,
        normal: Vector<D>,
    },
    /// The points whose distance from a centre, or from an axis through it, is less than the radius; with `sign` −1 those
    /// whose distance is more.
    Round {
        centre: Vector<D>,
        axis: Vector<D>,
        radius: f64,
        sign: f64,
    },
    Cuboid {
        centre: Vector<D>,
        half: Vector<D>,
    },
    Surface(Arc<ClosedSurface<D>>),
    Given(Distance<D>),
}

impl<const D: usize> fmt::Debug for Shape<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Shape::HalfSpace { point, normal } => f
                .debug_struct("HalfSpace")
                .field("point", &point.as_slice())
                .field("normal", &normal.as_slice())
                .finish(),
            Shape::Round {
                centre,
                axis,
                radius,
                sign,
            } => f
                .debug_struct(if *sign > 0.0 { "Round" } else { "Cavity" })
                .field("centre", &centre.as_slice())
                .field("axis", &axis.as_slice())
                .field("radius", radius)
                .finish(),
            Shape::Cuboid { centre, half } => f
                .debug_struct("Cuboid")
                .field("centre", &centre.as_slice())
                .field("half", &half.as_slice())
                .finish(),
            Shape::Surface(surface) => {
                write!(f, "Surface {{ facets: {} }}", surface.len())
            }
            Shape::Given(_) => f.write_str("SignedDistance"),
        }
    }
}

impl<const D: usize> Obstacle<D> {
    /// The half-space behind the plane (in the plane, the line) through `point` (UL); `normal`, of any length, points out
    /// of it, towards the bodies.
    ///
    /// # Errors
    /// Values that are not finite, and a normal of length 0.
    pub fn half_space(point: [f64; D], normal: [f64; D]) -> Result<Self, Error> {
        Error::check_finite("the obstacle's point", &point)?;
        Ok(Self::of(Shape::HalfSpace {
            point: point.into(),
            normal: direction("obstacle's normal", normal)?,
        }))
    }

    /// A disc or ball (UL), with bodies outside.
    ///
    /// # Errors
    /// Values that are not finite, and a radius that is not positive.
    pub fn ball(centre: [f64; D], radius: f64) -> Result<Self, Error> {
        Self::round(centre, Vector::zeros(), radius, 1.0)
    }

    /// All that is outside a disc or ball (UL), with bodies inside: a cup, or a hole in the plane.
    ///
    /// # Errors
    /// As [`Obstacle::ball`].
    pub fn cavity(centre: [f64; D], radius: f64) -> Result<Self, Error> {
        Self::round(centre, Vector::zeros(), radius, -1.0)
    }

    /// A cylinder as [`Obstacle::cylinder`] in space, a [disc](Obstacle::ball) in the plane: `axis` has no components in the plane,
    /// and three in space.
    ///
    /// # Errors
    /// As these, and an axis of another length.
    pub fn cylinder_along(axis: &[f64], point: [f64; D], radius: f64) -> Result<Self, Error> {
        Self::round(point, Self::axis(axis)?, radius, 1.0)
    }

    /// A bore as [`Obstacle::bore`] in space, a [hole](Obstacle::cavity) in the plane, with an axis as of
    /// [`Obstacle::cylinder_along`].
    ///
    /// # Errors
    /// As [`Obstacle::cylinder_along`].
    pub fn bore_along(axis: &[f64], point: [f64; D], radius: f64) -> Result<Self, Error> {
        Self::round(point, Self::axis(axis)?, radius, -1.0)
    }

    fn axis(axis: &[f64]) -> Result<Vector<D>, Error> {
        axis_of("components of the obstacle's axis", "obstacle's axis", axis)
    }

    /// The box between two corners (UL), with bodies outside. For a box with bodies inside, take a half-space for each
    /// wall: walls that meet in a corner then push at once. Its corners may have rows of their own
    /// ([`Corners`](super::Corners)); in space, its edges dig into softer bodies by a share of their facets, since gaps are means over facets.
    ///
    /// # Errors
    /// Values that are not finite, and a `high` that is not above `low` along each axis.
    pub fn cuboid(low: [f64; D], high: [f64; D]) -> Result<Self, Error> {
        Error::check_finite("the obstacle's corner", low.iter().chain(&high))?;
        let (low, high) = (Vector::from(low), Vector::from(high));
        let half = (high - low) * 0.5;
        if let Some(value) = half.iter().copied().find(|half| !(*half > 0.0)) {
            return Err(Error::Setting {
                name: "obstacle's edge",
                value: 2.0 * value,
                remedy: "let the second corner have the larger coordinate along each axis",
            });
        }
        let centre = (low + high) * 0.5;
        Ok(Self::of(Shape::Cuboid { centre, half }))
    }

    /// The inside of a closed surface of flat facets, with bodies outside: `facets` are the numbers of their corners among
    /// `points` (UL). In the plane, segments go around the inside counter-clockwise; in space, triangles do so seen from outside.
    /// It may have several parts and holes. Distances and normals are those of the facets themselves: a polyhedron of chords is
    /// its own shape, with corners and edges that dig in as those of [`Obstacle::cuboid`].
    ///
    /// ```
    /// use contact_fem::Obstacle;
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let corners = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]];
    /// let wedge = Obstacle::surface(&corners, &[[0, 1], [1, 2], [2, 0]])?;
    /// assert_eq!(wedge.distance(&[3.0, 0.0].into()), 1.0);
    /// assert_eq!(wedge.distance(&[0.5, 0.25].into()), -0.25);
    /// assert!(Obstacle::surface(&corners, &[[0, 1], [1, 2]]).is_err());
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`Error::ObstacleSurface`] if the surface is open, branches, is inside out, crosses itself or has a facet without extent;
    /// also if a number or a coordinate is none.
    pub fn surface(points: &[[f64; D]], facets: &[[usize; D]]) -> Result<Self, Error> {
        let points = points.iter().map(|&x| x.into()).collect();
        Self::closed(ClosedSurface::new(points, facets.to_vec()))
    }

    /// The obstacle that has the shape of a mesh, as [`Obstacle::surface`]. Curved facets become flat ones through their nodes.
    ///
    /// # Errors
    /// As [`Obstacle::surface`].
    pub fn of_mesh(mesh: &Mesh<D>) -> Result<Self, Error> {
        Self::closed(ClosedSurface::of_mesh(mesh))
    }

    /// The obstacle within the surface in a file, as [`Obstacle::surface`]: the triangles of an STL file or of any file that
    /// [`MeshFile`] reads, in the plane the segments; or the boundary of the cells of the file's one body.
    ///
    /// # Errors
    /// As [`MeshFile::read`] and [`Obstacle::surface`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::closed(ClosedSurface::of_file(&MeshFile::read(path)?))
    }

    fn closed(surface: Result<ClosedSurface<D>, Error>) -> Result<Self, Error> {
        Ok(Self::of(Shape::Surface(Arc::new(surface?))))
    }

    /// The obstacle with this signed distance (UL) from its surface: positive outside, where the bodies are, negative
    /// inside. Normals are differences of it, exact to about 1e-10 where the distance is smooth over a tenth of a facet; their
    /// derivatives, on which only the speed of Newton's method depends, to about 1e-6.
    ///
    /// A function with the right sign alone does not do: gaps are lengths. The slope of a distance is 1, which is
    /// checked at the contact nodes before a solve, and so is that values are finite.
    pub fn signed_distance(distance: impl Fn(&Vector<D>) -> f64 + Send + Sync + 'static) -> Self {
        Self::of(Shape::Given(Arc::new(distance)))
    }

    fn of(shape: Shape<D>) -> Self {
        let motion = None;
        Obstacle { shape, motion }
    }

    /// The same obstacle on the move: what is said of it holds for it at rest, from where `motion` takes it.
    #[must_use]
    pub fn moving(self, motion: Motion<D>) -> Self {
        Obstacle {
            motion: Some(motion),
            ..self
        }
    }

    /// Where it is at pseudo-time `t`.
    pub(crate) fn pose(&self, t: f64) -> Pose<D> {
        self.motion
            .as_ref()
            .map_or(Pose::rest(), |motion| motion.pose(t))
    }

    /// The pseudo-times at which its ways are estimated before a run: to the end of its amplitudes' tables, and to 1 at least.
    pub(crate) fn times(&self) -> Vec<f64> {
        samples_with(self.knots())
    }

    /// The times of the tables of its motion's amplitudes.
    pub(crate) fn knots(&self) -> impl Iterator<Item = f64> + '_ {
        self.motion.iter().flat_map(Motion::knots)
    }

    /// The centre of a ball whose first coordinate is not 0.
    pub(crate) fn ring(&self) -> Option<Vector<D>> {
        match &self.shape {
            Shape::Round { centre, .. } if centre[0] != 0.0 => Some(*centre),
            _ => None,
        }
    }

    /// Whether it moves otherwise than along the last axis.
    pub(crate) fn leaves_axis(&self) -> bool {
        let is_axial = |pose: &Pose<D>| pose.R == Matrix::<D>::identity() && pose.c[0] == 0.0;
        self.times().iter().any(|&t| !is_axial(&self.pose(t)))
    }

    fn round(centre: [f64; D], axis: Vector<D>, radius: f64, sign: f64) -> Result<Self, Error> {
        Error::check_finite("the obstacle's centre", &centre)?;
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(Error::Setting {
                name: "obstacle's radius",
                value: radius,
                remedy: "choose a positive, finite length",
            });
        }
        Ok(Self::of(Shape::Round {
            centre: centre.into(),
            axis,
            radius,
            sign,
        }))
    }

    /// The signed distance of `x` from the surface (UL), before it moves: positive outside, where bodies may be.
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        match &self.shape {
            Shape::HalfSpace { point, normal } => (x - point).dot(normal),
            Shape::Round {
                centre,
                axis,
                radius,
                sign,
            } => sign * (across(x, centre, axis).norm() - radius),
            Shape::Cuboid { centre, half } => {
                let beyond = (x - centre).abs() - half;
                match beyond.max() {
                    most if most > 0.0 => beyond.sup(&Vector::zeros()).norm(),
                    most => most,
                }
            }
            Shape::Surface(surface) => surface.distance(x),
            Shape::Given(distance) => distance(x),
        }
    }

    /// The sharp corners that point outwards, each with the unit bisector of its outward normals, before it moves.
    pub(crate) fn corners(&self) -> Vec<(Vector<D>, Vector<D>)> {
        match &self.shape {
            Shape::Cuboid { centre, half } => {
                let sign = |corner: usize, i: usize| [1.0, -1.0][corner >> i & 1];
                let outward = |corner| Vector::<D>::from_fn(|i, _| sign(corner, i));
                let all = (0..1 << D).map(outward);
                all.map(|out| (centre + half.component_mul(&out), out.normalize()))
                    .collect()
            }
            Shape::Surface(surface) => surface.sharp_corners(),
            Shape::HalfSpace { .. } | Shape::Round { .. } | Shape::Given(_) => Vec::new(),
        }
    }

    /// Whether the distance is a function that the user gave.
    pub(crate) fn is_given(&self) -> bool {
        matches!(self.shape, Shape::Given(_))
    }

    /// ∇d at `x`, of length 1 where it is smooth; 0 in the centre of a ball. `step` (UL) is that of differences.
    fn slope(&self, x: &Vector<D>, step: f64) -> Vector<D> {
        match &self.shape {
            Shape::HalfSpace { normal, .. } => *normal,
            Shape::Round {
                centre, axis, sign, ..
            } => {
                let arm = across(x, centre, axis);
                match arm.norm() {
                    0.0 => Vector::zeros(),
                    length => arm * (sign / length),
                }
            }
            Shape::Cuboid { centre, half } => {
                let arm = x - centre;
                let beyond = arm.abs() - half;
                let sign = |i: usize| if arm[i] < 0.0 { -1.0 } else { 1.0 };
                let nearest = beyond.imax();
                match beyond[nearest] > 0.0 {
                    true => {
                        let out = beyond.sup(&Vector::zeros());
                        Vector::from_fn(|i, _| sign(i) * out[i]) / out.norm()
                    }
                    false => Vector::from_fn(|i, _| if i == nearest { sign(i) } else { 0.0 }),
                }
            }
            Shape::Surface(surface) => surface.slope(x),
            Shape::Given(distance) => Vector::from_fn(|i, _| {
                let [near, far] = [step, 2.0 * step].map(|h| {
                    let at = |h: f64| {
                        let mut x = *x;
                        x[i] += h;
                        distance(&x)
                    };
                    (at(h) - at(-h)) / (2.0 * h)
                });
                (4.0 * near - far) / 3.0
            }),
        }
    }

    /// ∇²d at `x` (1/UL), likewise.
    fn curvature(&self, x: &Vector<D>, step: f64) -> Matrix<D> {
        match &self.shape {
            Shape::HalfSpace { .. } => Matrix::zeros(),
            Shape::Round {
                centre, axis, sign, ..
            } => {
                let arm = across(x, centre, axis);
                match arm.norm() {
                    0.0 => Matrix::zeros(),
                    length => {
                        let n = arm / length;
                        let along = n * n.transpose() + axis * axis.transpose();
                        (Matrix::identity() - along) * (sign / length)
                    }
                }
            }
            Shape::Cuboid { centre, half } => {
                // beyond an edge or a corner, the distance is that from it
                let beyond = (x - centre).abs() - half;
                let out = beyond.map(|b| f64::from(u8::from(b > 0.0)));
                if out.sum() < 2.0 {
                    return Matrix::zeros();
                }
                let n = self.slope(x, step);
                let length = beyond.sup(&Vector::zeros()).norm();
                (Matrix::from_diagonal(&out) - n * n.transpose()) / length
            }
            Shape::Surface(surface) => surface.curvature(x),
            Shape::Given(distance) => {
                // the fourth order, on every line through two axes
                let along = |v: Vector<D>| {
                    let second = |h: f64| {
                        let ends = distance(&(x + v * h)) + distance(&(x - v * h));
                        (ends - 2.0 * distance(x)) / (h * h)
                    };
                    let h = 5.0 * step;
                    (4.0 * second(h) - second(2.0 * h)) / 3.0
                };
                let axis = crate::tensor::unit_vector::<D>;
                let own = Vector::<D>::from_fn(|i, _| along(axis(i)));
                Matrix::from_fn(|i, j| match i == j {
                    true => own[i],
                    false => {
                        let both = along(axis(i) + axis(j));
                        (both - own[i] - own[j]) * 0.5
                    }
                })
            }
        }
    }
}

/// The way to `x` from the nearest point of the axis through `centre`, or from `centre` where the axis is zero.
fn across<const D: usize>(x: &Vector<D>, centre: &Vector<D>, axis: &Vector<D>) -> Vector<D> {
    let arm = x - centre;
    arm - axis * axis.dot(&arm)
}

impl Obstacle<3> {
    /// The endless cylinder about the axis through `point` (UL) along `axis`, of any length, with bodies outside.
    ///
    /// # Errors
    /// Values that are not finite, an axis of length 0, and a radius that is not positive.
    pub fn cylinder(point: [f64; 3], axis: [f64; 3], radius: f64) -> Result<Self, Error> {
        Self::round(point, direction("obstacle's axis", axis)?, radius, 1.0)
    }

    /// All that is outside such a cylinder, with bodies inside: a bore.
    ///
    /// # Errors
    /// As [`Obstacle::cylinder`].
    pub fn bore(point: [f64; 3], axis: [f64; 3], radius: f64) -> Result<Self, Error> {
        Self::round(point, direction("obstacle's axis", axis)?, radius, -1.0)
    }
}

/// An obstacle among the bodies of a scene.
#[derive(Clone, Debug)]
pub struct Placed<const D: usize> {
    obstacle: Obstacle<D>,
    pose: Pose<D>,
    /// The step of differences (UL).
    step: f64,
}

impl<const D: usize> Placed<D> {
    /// The step of differences, as a share of the facet size.
    const STEP: f64 = 0.01;

    /// Where it is at pseudo-time 0; surfaces with facets of this size (UL) meet it.
    pub fn new(obstacle: &Obstacle<D>, facet_size: f64) -> Self {
        Placed {
            pose: obstacle.pose(0.0),
            obstacle: obstacle.clone(),
            step: Self::STEP * facet_size,
        }
    }

    /// The obstacle.
    pub fn obstacle(&self) -> &Obstacle<D> {
        &self.obstacle
    }

    /// Places it where it is at pseudo-time `t`, and tells whether it was elsewhere.
    pub(crate) fn set_time(&mut self, t: f64) -> bool {
        let before = std::mem::replace(&mut self.pose, self.obstacle.pose(t));
        before != self.pose
    }

    /// Where it is.
    pub(crate) fn pose(&self) -> &Pose<D> {
        &self.pose
    }

    /// The signed distance of `x` (UL).
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        self.obstacle.distance(&self.pose.back(x))
    }

    /// ∇d at `x`; its length is 1 where d is a distance and smooth.
    pub fn slope(&self, x: &Vector<D>) -> Vector<D> {
        self.pose.R * self.obstacle.slope(&self.pose.back(x), self.step)
    }

    /// The unit normal at `x`; 0 where there is none.
    pub fn normal(&self, x: &Vector<D>) -> Vector<D> {
        let slope = self.slope(x);
        match self.obstacle.is_given() && slope.norm() > 0.0 {
            true => slope.normalize(),
            false => slope,
        }
    }

    /// ∇²d at `x` (1/UL): the derivative of the normal.
    pub fn curvature(&self, x: &Vector<D>) -> Matrix<D> {
        let R = &self.pose.R;
        R * self.obstacle.curvature(&self.pose.back(x), self.step) * R.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::stencil::on_obstacle;
    use crate::contact::{MovingGap, Stencil, Surface};
    use crate::element::Order;

    /// ∇g and ∇²g of a point on a quadratic segment above a disc, against differences of the distance at
    /// the point.
    #[test]
    fn gaps_move_with_the_nodes_of_the_facet() {
        // the outward normal is to the right of the way
        let x = [[-0.4, 1.1], [0.5, 1.2], [0.1, 1.05]].map(Vector::<2>::from);
        let disc = Obstacle::ball([0.0; 2], 1.0).expect("a disc");
        let placed = Placed::new(&disc, 1.0);
        let gaps = |x: &[Vector<2>]| {
            let facets = [&[0, 1, 2][..]];
            let surface = Surface::new(0, Order::Quadratic, facets.into_iter(), x);
            let points = on_obstacle(&surface, &placed, x, 3, 1.0);
            assert_eq!(points.len(), 3);
            let mut all = Vec::new();
            for point in points {
                let stencil = Stencil::new(&surface, &placed, point);
                let mut gap = MovingGap::default();
                gap.second(&stencil);
                all.push((stencil.projection().gap, gap));
            }
            all
        };
        let h = 1e-5;
        let moved = |l: usize, i: usize, h: f64| {
            let mut x = x;
            x[l][i] += h;
            gaps(&x)
        };
        for (q, (_, gap)) in gaps(&x).iter().enumerate() {
            let place = |node: usize| gap.nodes().iter().position(|n| *n == node);
            for (l, i) in (0..3).flat_map(|l| [(l, 0), (l, 1)]) {
                let [ahead, behind] = [h, -h].map(|h| moved(l, i, h));
                let at = place(l).expect("its own node");
                let slope = (ahead[q].0 - behind[q].0) / (2.0 * h);
                assert!((slope - gap.gradient()[at][i]).abs() < 1e-9);
                for m in 0..3 {
                    let turn = (ahead[q].1.gradient()[m] - behind[q].1.gradient()[m]) / (2.0 * h);
                    let [column, frozen] = [gap.hessian(m, at), gap.frozen_jacobian(m, at)];
                    assert!((turn - column.column(i)).amax() < 1e-8);
                    // the frozen gradient is the gradient
                    assert!((turn - frozen.column(i)).amax() < 1e-8);
                }
            }
        }
    }

    fn shapes() -> Vec<(Obstacle<3>, Vector<3>)> {
        let closure = |x: &Vector<3>| {
            // a torus about z
            let ring = x[0].hypot(x[1]) - 2.0;
            ring.hypot(x[2]) - 0.5
        };
        let ok = |shape: Result<Obstacle<3>, Error>| shape.expect("a shape");
        let wedge = crate::mesh::generators::cuboid([-1.0; 3], [2.0; 3], [3; 3]);
        let lean = |x: &Vector<3>| Vector::from([x[0] + 0.3 * x[2], x[1] - 0.1 * x[2], x[2]]);
        let wedge = wedge.and_then(|mesh| mesh.mapped(lean)).expect("a mesh");
        let x = |x: [f64; 3]| Vector::<3>::from(x);
        vec![
            (
                ok(Obstacle::half_space([0.0, 0.1, 0.0], [1.0, 2.0, -2.0])),
                x([0.3, -0.4, 0.5]),
            ),
            (
                ok(Obstacle::ball([0.1, 0.2, 0.3], 0.7)),
                x([1.0, 0.5, -0.4]),
            ),
            (ok(Obstacle::ball([0.1, 0.2, 0.3], 0.7)), x([0.3, 0.1, 0.2])),
            (
                ok(Obstacle::cavity([0.1, 0.2, 0.3], 3.0)),
                x([1.0, 0.5, -0.4]),
            ),
            (
                ok(Obstacle::cylinder([0.1, 0.0, 0.0], [0.0, 3.0, 4.0], 0.2)),
                x([0.5, 0.6, -0.1]),
            ),
            (
                ok(Obstacle::bore([0.1, 0.0, 0.0], [0.0, 3.0, 4.0], 2.0)),
                x([0.5, 0.6, -0.1]),
            ),
            // beyond a face, an edge and a corner, and inside
            (
                ok(Obstacle::cuboid([-1.0; 3], [1.0; 3])),
                x([0.3, 1.5, 0.2]),
            ),
            (
                ok(Obstacle::cuboid([-1.0; 3], [1.0; 3])),
                x([0.3, 1.5, -1.2]),
            ),
            (
                ok(Obstacle::cuboid([-1.0; 3], [1.0; 3])),
                x([-1.3, 1.5, -1.2]),
            ),
            (
                ok(Obstacle::cuboid([-1.0; 3], [1.0; 3])),
                x([0.1, -0.8, 0.3]),
            ),
            // of facets, beyond an edge and a face
            (ok(Obstacle::of_mesh(&wedge)), x([0.3, 1.5, -1.2])),
            (ok(Obstacle::of_mesh(&wedge)), x([0.4, 0.3, 1.7])),
            (Obstacle::signed_distance(closure), x([2.1, 1.2, 0.6])),
        ]
    }

    /// Normals and their derivatives against central differences of distances and of normals.
    #[test]
    fn derivatives_are_those_of_the_distance() {
        let h = 1e-5;
        for (obstacle, x) in shapes() {
            let placed = Placed::new(&obstacle, 0.2);
            let n = placed.normal(&x);
            assert!((n.norm() - 1.0).abs() < 1e-14, "{obstacle:?}");
            let H = placed.curvature(&x);
            for i in 0..3 {
                let e = crate::tensor::unit_vector::<3>(i) * h;
                let slope = (obstacle.distance(&(x + e)) - obstacle.distance(&(x - e))) / (2.0 * h);
                assert!((slope - n[i]).abs() < 1e-9, "{obstacle:?} {slope} {}", n[i]);
                let turn = (placed.normal(&(x + e)) - placed.normal(&(x - e))) / (2.0 * h);
                let apart = (turn - H.column(i)).amax();
                assert!(apart < 1e-6, "{obstacle:?} {apart:.1e}");
            }
        }
    }

    /// Distances of points that are known by hand.
    #[test]
    fn distances() {
        let at = |k: usize, x: [f64; 3]| shapes()[k].0.distance(&x.into());
        assert!((at(0, [3.0, 0.1, 0.0]) - 1.0).abs() < 1e-15);
        assert!((at(1, [0.1, 0.2, 1.3]) - 0.3).abs() < 1e-15);
        assert!((at(3, [0.1, 0.2, 1.3]) - 2.0).abs() < 1e-15);
        assert!((at(4, [1.1, 3.0, 4.0]) - 0.8).abs() < 1e-15);
        assert!((at(5, [1.1, 3.0, 4.0]) - 1.0).abs() < 1e-15);
        for (x, expected) in [
            ([0.0, 1.5, 0.0], 0.5),
            ([4.0, 5.0, 0.0], 5.0),
            ([2.0, -3.0, 3.0], 3.0),
            ([0.0, 0.9, -0.5], -0.1),
        ] {
            assert!((at(6, x) - expected).abs() < 1e-15, "{x:?}");
        }
    }

    #[test]
    fn wrong_shapes_are_refused() {
        let nan = f64::NAN;
        for (error, says) in [
            (
                Obstacle::half_space([0.0; 2], [0.0; 2]).err(),
                "`obstacle's normal` = 0",
            ),
            (
                Obstacle::half_space([0.0; 2], [nan, 0.0]).err(),
                "obstacle's normal [0] = NaN",
            ),
            (
                Obstacle::half_space([0.0, nan], [0.0, 1.0]).err(),
                "point [1] = NaN",
            ),
            (
                Obstacle::ball([0.0; 2], -1.0).err(),
                "`obstacle's radius` = -1",
            ),
            (
                Obstacle::ball([0.0; 2], nan).err(),
                "`obstacle's radius` = NaN",
            ),
            (
                Obstacle::cavity([f64::INFINITY, 0.0], 1.0).err(),
                "centre [0] = inf",
            ),
            (
                Obstacle::cuboid([0.0; 2], [1.0, -1.0]).err(),
                "`obstacle's edge` = -1",
            ),
            (
                Obstacle::cuboid([0.0; 2], [1.0, nan]).err(),
                "corner [3] = NaN",
            ),
        ] {
            let message = error.expect("refused").to_string();
            assert!(message.contains(says), "{message}");
        }
        let error = Obstacle::cylinder([0.0; 3], [0.0; 3], 1.0).expect_err("refused");
        assert!(
            error.to_string().contains("`obstacle's axis` = 0"),
            "{error}"
        );
        // directions of any length
        let tiny = Obstacle::half_space([0.0; 2], [0.0, 1e-300]).expect("a direction");
        assert_eq!(tiny.distance(&[0.0, 2.0].into()), 2.0);
    }
}

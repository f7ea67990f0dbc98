//! Programs: amplitudes and rigid motions by load factor, which is a pseudo-time.

use std::fmt;
use std::sync::Arc;

use crate::error::Error;
use crate::tensor::{Matrix, Vector};

/// A factor by pseudo-time t, which multiplies a load, a prescribed displacement or an angle.
///
/// ```
/// use contact_fem::Amplitude;
///
/// # fn main() -> Result<(), contact_fem::Error> {
/// let up_and_down = Amplitude::table(&[(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)])?;
/// assert_eq!([0.5, 1.5, 7.0].map(|t| up_and_down.at(t)), [0.5, 0.5, 0.0]);
/// assert_eq!(Amplitude::constant(3.0).at(0.2), 3.0);
/// assert_eq!(Amplitude::of(|t| t * t).at(3.0), 9.0);
/// assert_eq!(Amplitude::default().at(0.25), 0.25, "proportional");
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Default)]
pub struct Amplitude(Kind);

#[derive(Clone, Default)]
enum Kind {
    #[default]
    Proportional,
    Constant(f64),
    Table(Arc<[(f64, f64)]>),
    Given(Arc<dyn Fn(f64) -> f64 + Send + Sync>),
}

impl fmt::Debug for Amplitude {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Kind::Proportional => f.write_str("Proportional"),
            Kind::Constant(value) => f.debug_tuple("Constant").field(value).finish(),
            Kind::Table(table) => f.debug_tuple("Table").field(table).finish(),
            Kind::Given(_) => f.write_str("Given"),
        }
    }
}

impl Amplitude {
    /// t itself: what a load without an amplitude has.
    pub fn proportional() -> Self {
        Self::default()
    }

    /// The same at all times, from the start on.
    pub fn constant(value: f64) -> Self {
        Amplitude(Kind::Constant(value))
    }

    /// Straight lines between these pairs of time and value; constant before the first and after the last.
    ///
    /// # Errors
    /// An empty table, values that are not finite, and times that do not ascend.
    pub fn table(pairs: &[(f64, f64)]) -> Result<Self, Error> {
        let values = pairs.iter().flat_map(|(t, value)| [t, value]);
        Error::check_finite("the amplitude's table", values)?;
        let wrong = |name, value, remedy| {
            Err(Error::Setting {
                name,
                value,
                remedy,
            })
        };
        if pairs.is_empty() {
            let remedy = "give one pair of time and value at least";
            return wrong("number of pairs of an amplitude", 0.0, remedy);
        }
        if let Some(pair) = pairs.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
            let remedy = "it follows a time that is not less: let the times ascend";
            return wrong("time of an amplitude", pair[1].0, remedy);
        }
        Ok(Amplitude(Kind::Table(pairs.into())))
    }

    /// A function of t.
    pub fn of(function: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Self {
        Amplitude(Kind::Given(Arc::new(function)))
    }

    /// The factor at time `t`.
    pub fn at(&self, t: f64) -> f64 {
        match &self.0 {
            Kind::Proportional => t,
            Kind::Constant(value) => *value,
            Kind::Table(table) => {
                let next = table.partition_point(|(time, _)| *time <= t);
                match (next.checked_sub(1).map(|last| table[last]), table.get(next)) {
                    (Some((t_0, a)), Some((t_1, b))) => a + (b - a) * ((t - t_0) / (t_1 - t_0)),
                    (Some((_, value)), None) | (None, Some(&(_, value))) => value,
                    (None, None) => 0.0,
                }
            }
            Kind::Given(function) => function(t),
        }
    }

    /// The times of its table.
    pub(crate) fn knots(&self) -> impl Iterator<Item = f64> + '_ {
        let table = match &self.0 {
            Kind::Table(table) => &table[..],
            _ => &[],
        };
        table.iter().map(|(time, _)| *time)
    }

    /// Whether it is t itself.
    pub(crate) fn is_proportional(&self) -> bool {
        matches!(self.0, Kind::Proportional)
    }
}

impl From<f64> for Amplitude {
    /// A constant.
    fn from(value: f64) -> Self {
        Amplitude::constant(value)
    }
}

/// A rigid motion by pseudo-time: points go along circles and lines, not along chords.
///
/// ```
/// use contact_fem::Motion;
///
/// # fn main() -> Result<(), contact_fem::Error> {
/// let quarter = std::f64::consts::FRAC_PI_2;
/// let turn = Motion::<2>::rotation([1.0, 0.0], quarter)?.then(Motion::translation([0.0, 3.0])?);
/// let x = turn.at(1.0, &[2.0, 0.0].into());
/// assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 4.0).abs() < 1e-15);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Motion<const D: usize>(Vec<(Part<D>, Amplitude)>);

/// A motion at amplitude 1.
#[derive(Clone, Debug)]
enum Part<const D: usize> {
    Translation(Vector<D>),
    /// About the centre, along the axis in space, by an angle (radians).
    Rotation {
        centre: Vector<D>,
        axis: Vector<D>,
        angle: f64,
    },
}

impl<const D: usize> Motion<D> {
    /// A translation by `by` (UL), times t unless it is [driven](Motion::driven_by).
    ///
    /// # Errors
    /// Values that are not finite.
    pub fn translation(by: [f64; D]) -> Result<Self, Error> {
        Error::check_finite("the translation", &by)?;
        Ok(Self::new(Part::Translation(by.into())))
    }

    /// A rotation as [`Motion::<2>::rotation`](Motion#method.rotation) and [`Motion::<3>::rotation`](Motion#method.rotation-1),
    /// in either: `axis` has no components in the plane, and three in space.
    ///
    /// # Errors
    /// As these, and an axis of another length.
    pub fn rotation_along(axis: &[f64], centre: [f64; D], angle: f64) -> Result<Self, Error> {
        Error::check_finite("the rotation", centre.iter().chain([&angle]))?;
        Ok(Self::new(Part::Rotation {
            centre: centre.into(),
            axis: axis_of("components of the rotation's axis", "rotation's axis", axis)?,
            angle,
        }))
    }

    fn new(part: Part<D>) -> Self {
        Motion(vec![(part, Amplitude::default())])
    }

    /// This motion followed by another one, whose centre and axis do not move along.
    #[must_use]
    pub fn then(mut self, next: Motion<D>) -> Self {
        self.0.extend(next.0);
        self
    }

    /// The same motion with this amplitude, in place of t, on each of its ways and angles.
    #[must_use]
    pub fn driven_by(mut self, amplitude: impl Into<Amplitude>) -> Self {
        let amplitude = amplitude.into();
        for (_, own) in &mut self.0 {
            own.clone_from(&amplitude);
        }
        self
    }

    /// Where the point `X` (UL) is at time `t`.
    pub fn at(&self, t: f64, X: &Vector<D>) -> Vector<D> {
        self.pose(t).place(X)
    }

    /// The times of the tables of its amplitudes.
    pub(crate) fn knots(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().flat_map(|(_, amplitude)| amplitude.knots())
    }

    /// x = R X + c at time `t`.
    pub(crate) fn pose(&self, t: f64) -> Pose<D> {
        let all = self.0.iter();
        all.fold(Pose::rest(), |before, (part, amplitude)| {
            let next = part.pose(amplitude.at(t));
            Pose {
                R: next.R * before.R,
                c: next.place(&before.c),
            }
        })
    }
}

impl Motion<2> {
    /// A rotation about `centre` (UL) by `angle` (radians, counter-clockwise), times t unless it is
    /// [driven](Motion::driven_by).
    ///
    /// # Errors
    /// Values that are not finite.
    pub fn rotation(centre: [f64; 2], angle: f64) -> Result<Self, Error> {
        Self::rotation_along(&[], centre, angle)
    }
}

impl Motion<3> {
    /// A rotation about the line through `centre` (UL) along `axis`, of any length, by `angle` (radians, counter-clockwise
    /// seen from where the axis points to), times t unless it is [driven](Motion::driven_by).
    ///
    /// # Errors
    /// Values that are not finite, and an axis of length 0.
    pub fn rotation(axis: [f64; 3], centre: [f64; 3], angle: f64) -> Result<Self, Error> {
        Self::rotation_along(&axis, centre, angle)
    }
}

impl<const D: usize> Part<D> {
    fn pose(&self, amplitude: f64) -> Pose<D> {
        match self {
            Part::Translation(by) => Pose {
                R: Matrix::identity(),
                c: by * amplitude,
            },
            Part::Rotation {
                centre,
                axis,
                angle,
            } => {
                let (sin, cos) = (angle * amplitude).sin_cos();
                // the matrix of the vector product with the axis, which in the plane is normal to it
                let cross = Matrix::<D>::from_fn(|i, j| match (D, (3 + j - i) % 3) {
                    _ if i == j => 0.0,
                    (2, _) if i < j => -1.0,
                    (2, _) => 1.0,
                    (_, 1) => -axis[3 - i - j],
                    _ => axis[3 - i - j],
                });
                // I + sin K + (1 − cos) K²
                let R = Matrix::identity() + cross * sin + cross * cross * (1.0 - cos);
                Pose {
                    R,
                    c: centre - R * centre,
                }
            }
        }
    }
}

/// A rigid placement: x = R X + c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose<const D: usize> {
    pub R: Matrix<D>,
    pub c: Vector<D>,
}

impl<const D: usize> Pose<D> {
    /// X itself.
    pub fn rest() -> Self {
        Pose {
            R: Matrix::identity(),
            c: Vector::zeros(),
        }
    }

    pub fn place(&self, X: &Vector<D>) -> Vector<D> {
        self.R * X + self.c
    }

    /// X of a point at `x`.
    pub fn back(&self, x: &Vector<D>) -> Vector<D> {
        self.R.tr_mul(&(x - self.c))
    }

    pub fn is_finite(&self) -> bool {
        self.R.iter().chain(&self.c).all(|value| value.is_finite())
    }
}

/// The unit vector along an axis that has no components in the plane, where it is zero, and three in space.
pub(crate) fn axis_of<const D: usize>(
    components: &'static str,
    name: &'static str,
    axis: &[f64],
) -> Result<Vector<D>, Error> {
    match (D, axis) {
        (2, []) => Ok(Vector::zeros()),
        (3, &[x, y, z]) => {
            let axis = direction(name, [x, y, z])?;
            Ok(Vector::from_fn(|i, _| axis[i]))
        }
        _ => Err(Error::Setting {
            name: components,
            value: axis.len() as f64,
            remedy: "give the axis three components in space, and leave it out in the plane",
        }),
    }
}

/// The unit vector along `v`.
pub(crate) fn direction<const D: usize>(
    name: &'static str,
    v: [f64; D],
) -> Result<Vector<D>, Error> {
    Error::check_finite(name, &v)?;
    // scaled first: squares overflow and underflow
    let v = Vector::from(v);
    let largest = v.amax();
    if !(largest > 0.0) {
        return Err(Error::Setting {
            name,
            value: largest,
            remedy: "give a direction, a vector that is not zero",
        });
    }
    Ok((v / largest).normalize())
}

/// The times at which the sizes of loads and motions are estimated before a run, whose end is not known then.
pub(crate) fn samples() -> impl DoubleEndedIterator<Item = f64> {
    (1..=16).map(|k| f64::from(k) / 16.0)
}

/// The same where the times of tables are known: they tell how far a program goes, which is to 1 at least.
pub(crate) fn samples_with(knots: impl Iterator<Item = f64>) -> Vec<f64> {
    let knots: Vec<f64> = knots.filter(|t| *t > 0.0).collect();
    let end = knots.iter().copied().fold(1.0, f64::max);
    let even = samples().map(|share| share * end);
    even.chain([1.0]).chain(knots).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// R is orthogonal, keeps its axis, and turns by the right angle in the right sense.
    #[test]
    fn rotations() {
        let turn = Motion::<3>::rotation(
            [0.0, 0.0, 2.0],
            [1.0, 0.0, 0.0],
            std::f64::consts::FRAC_PI_2,
        );
        let x = turn.expect("a turn").at(1.0, &[2.0, 0.0, 5.0].into());
        assert!((x - Vector::<3>::new(1.0, 1.0, 5.0)).norm() < 1e-15, "{x}");
        let motion =
            Motion::<3>::rotation([1.0, -2.0, 0.5], [0.3, 0.1, -0.2], 1.3).expect("a turn");
        let R = motion.pose(0.7).R;
        assert!((R * R.transpose() - Matrix::identity()).norm() < 1e-15);
        assert!((R.trace() - (1.0 + 2.0 * (0.91f64).cos())).abs() < 1e-15);
        let on_axis = Vector::<3>::new(0.3 + 2.0, 0.1 - 4.0, -0.2 + 1.0);
        assert!((motion.at(0.7, &on_axis) - on_axis).norm() < 1e-14);
        let pose = motion.pose(0.4);
        assert!((pose.back(&pose.place(&on_axis)) - on_axis).norm() < 1e-14);
    }

    /// Parts follow each other in their order, and an amplitude drives them all.
    #[test]
    fn motions_that_follow_each_other() {
        let turn = || Motion::<2>::rotation([0.0; 2], std::f64::consts::PI).expect("a turn");
        let way = || Motion::<2>::translation([1.0, 0.0]).expect("a way");
        let x = [1.0, 0.0].into();
        let first_turned = turn().then(way()).at(1.0, &x);
        assert!(first_turned.norm() < 1e-15, "{first_turned}");
        let first_moved = way().then(turn()).at(1.0, &x);
        assert!((first_moved - Vector::<2>::new(-2.0, 0.0)).norm() < 1e-15);
        let held = turn().then(way()).driven_by(0.0).at(1.0, &x);
        assert_eq!(held, x);
    }

    #[test]
    fn tables() {
        for (table, says) in [
            (&[][..], "one pair"),
            (&[(0.0, 1.0), (0.0, 2.0)][..], "ascend"),
            (&[(0.0, f64::NAN)][..], "[1] = NaN"),
        ] {
            let error = Amplitude::table(table).expect_err("refused").to_string();
            assert!(error.contains(says), "{error}");
        }
        let table = Amplitude::table(&[(1.0, 2.0), (3.0, -2.0)]).expect("a table");
        let values = [0.0, 1.0, 1.5, 3.0, 9.0].map(|t| table.at(t));
        assert_eq!(values, [2.0, 2.0, 1.0, -2.0, -2.0]);
    }
}

//! Projections on curved boundaries, for the middle nodes of quadratic meshes.

use crate::tensor::Vector;

/// Projects a point along its radius on the sphere of this radius (UL) around the origin, in the
/// plane on the circle. The origin has no unique projection and stays.
pub fn onto_sphere<const D: usize>(radius: f64) -> impl Fn(&Vector<D>) -> Vector<D> {
    move |X| match X.norm() {
        0.0 => *X,
        norm => X * (radius / norm),
    }
}

/// Projects a point perpendicular to the z axis on the cylinder of this radius (UL) around it. A
/// point on the axis has no unique projection and stays.
pub fn onto_cylinder(radius: f64) -> impl Fn(&Vector<3>) -> Vector<3> {
    let circle = onto_sphere::<2>(radius);
    move |X| {
        let x = circle(&Vector::from([X[0], X[1]]));
        Vector::from([x[0], x[1], X[2]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_move_straight_out() {
        let X = Vector::<3>::new(0.3, -0.4, 1.2);
        let sphere = onto_sphere(2.0)(&X);
        assert!((sphere - X * (2.0 / 1.3)).norm() < 1e-15);
        let cylinder = onto_cylinder(1.0)(&X);
        assert!((cylinder - Vector::from([0.6, -0.8, 1.2])).norm() < 1e-15);
        let circle = onto_sphere(1.0)(&Vector::<2>::new(0.0, -3.0));
        assert_eq!(circle, Vector::<2>::new(0.0, -1.0));
        let axis = Vector::<3>::new(0.0, 0.0, 0.7);
        assert_eq!(onto_cylinder(1.0)(&axis), axis);
        let origin = Vector::<3>::zeros();
        assert_eq!(onto_sphere(1.0)(&origin), origin);
    }
}

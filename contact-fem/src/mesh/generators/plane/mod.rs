//! Generators of triangle meshes.

mod disc;
mod rectangle;

pub use disc::{annulus, disc, equilateral_disc, half_disc, quarter_disc};
pub use rectangle::{Diagonals, rectangle};

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::error::Error;
    use crate::mesh::Mesh;
    use crate::mesh::generators::{graded, linspace};

    fn area(mesh: &Mesh<2>) -> f64 {
        (0..mesh.len()).map(|k| mesh.volume(k)).sum()
    }

    /// Area of a regular polygon with `n` corners on a circle of radius `r`.
    fn polygon(n: usize, r: f64) -> f64 {
        0.5 * n as f64 * r * r * (TAU / n as f64).sin()
    }

    #[test]
    fn areas_and_boundaries() {
        let mesh = rectangle(
            &linspace(0.0, 2.0, 4),
            &graded(-1.0, 0.5, 0.1, 5).expect("grading"),
            Diagonals::Rising,
        )
        .expect("mesh");
        assert!((area(&mesh) - 3.0).abs() < 1e-14);
        assert_eq!(mesh.boundary("top").expect("named").len(), 4);
        assert_eq!(mesh.boundary_nodes("left").expect("named").len(), 6);

        let mesh = annulus(&[0.7, 1.0, 2.0], 64, Diagonals::Alternating).expect("mesh");
        assert!((area(&mesh) - polygon(64, 2.0) + polygon(64, 0.7)).abs() < 1e-12);
        assert_eq!(mesh.boundary("inner").expect("named").len(), 64);
        assert_eq!(mesh.exterior().len(), 128);

        let mesh = disc(0.6, 52, 3, 0.03).expect("mesh");
        assert!((area(&mesh) - polygon(52, 0.6)).abs() < 1e-12);
        assert_eq!(mesh.boundary("boundary").expect("named").len(), 52);
        assert_eq!(mesh.len(), 52 * 5);

        let mesh = equilateral_disc(0.6, 7).expect("mesh");
        assert!((area(&mesh) - polygon(42, 0.6)).abs() < 1e-12);
        assert_eq!(mesh.boundary("boundary").expect("named").len(), 42);
        assert_eq!((mesh.len(), mesh.exterior().len()), (6 * 49, 42));

        let mesh = half_disc(
            &linspace(0.0, 1.0, 3),
            &linspace(PI, TAU, 16),
            Diagonals::Alternating,
        )
        .expect("mesh");
        assert!((area(&mesh) - 0.5 * polygon(32, 1.0)).abs() < 1e-12);
        assert_eq!(mesh.boundary("flat").expect("named").len(), 6);
        assert_eq!(mesh.boundary("arc").expect("named").len(), 16);

        let mesh = quarter_disc(
            &linspace(0.0, 1.0, 3),
            &linspace(1.5 * PI, TAU, 8),
            Diagonals::Rising,
        )
        .expect("mesh");
        assert_eq!(mesh.boundary("axis").expect("named").len(), 3);
        assert_eq!(mesh.boundary("flat").expect("named").len(), 3);

        // π as files have it
        let mut angles = linspace(1.5 * PI, TAU, 8);
        for angle in &mut angles {
            *angle = (1e12 * *angle).round() / 1e12;
        }
        let rounded = quarter_disc(&linspace(0.0, 1.0, 3), &angles, Diagonals::Rising);
        let rounded = rounded.expect("mesh");
        for side in ["axis", "flat"] {
            assert_eq!(rounded.boundary(side).expect("named").len(), 3, "{side}");
        }
    }

    #[test]
    fn unknown_names_list_the_known_ones() {
        let mesh = disc(1.0, 8, 1, 0.0).expect("mesh");
        let message = mesh.boundary("rim").expect_err("unknown").to_string();
        assert!(
            message.contains("rim") && message.contains("boundary"),
            "{message}"
        );
    }

    #[test]
    fn bad_cells_are_named() {
        let nodes = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [2.0, 0.0]];
        let error = |cells| Mesh::<2>::new(nodes.clone(), cells).expect_err("bad");
        assert!(matches!(
            error(vec![0, 1, 2, 1, 2, 3]),
            Error::InvertedCell { cell: 1, .. }
        ));
        assert!(matches!(
            error(vec![0, 1, 2, 0, 1, 3]),
            Error::DegenerateCell { cell: 1, .. }
        ));
        assert!(matches!(
            error(vec![0, 1, 7]),
            Error::NodeOutOfRange {
                cell: 0,
                node: 7,
                nodes: 4
            }
        ));
        assert!(matches!(
            error(vec![0, 1, 2]),
            Error::OrphanNode { node: 3 }
        ));
        assert!(matches!(error(vec![]), Error::EmptyMesh));
        let far = vec![[0.0, 0.0], [1e200, 0.0], [0.0, 1e200]];
        assert!(matches!(
            Mesh::<2>::new(far, vec![0, 1, 2]),
            Err(Error::CellSize { cell: 0, .. })
        ));
        let nan = vec![[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]];
        assert!(matches!(
            Mesh::<2>::new(nan, vec![0, 1, 2]),
            Err(Error::NotFinite { .. })
        ));
    }
}

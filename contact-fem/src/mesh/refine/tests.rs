//! Refined meshes fill the same space, with the same names, and keep the quality of their cells.

use std::collections::BTreeSet;

use super::*;
use crate::mesh::generators::{Diagonals, annulus, cuboid, disc, onto_sphere, rectangle, sphere};
use crate::tensor::Matrix;

fn volume<const D: usize>(mesh: &Mesh<D>) -> f64 {
    (0..mesh.len()).map(|k| mesh.volume(k)).sum()
}

/// The length or area of straight facets.
fn measure<'a, const D: usize>(
    mesh: &Mesh<D>,
    facets: impl IntoIterator<Item = &'a [usize]>,
) -> f64 {
    let one = |facet: &[usize]| {
        let side = |i: usize| mesh.nodes()[facet[i]] - mesh.nodes()[facet[0]];
        let [a, b] = [side(1), side(D - 1)];
        match D {
            2 => a.norm(),
            // Lagrange's identity
            _ => 0.5 * (a.norm_squared() * b.norm_squared() - a.dot(&b).powi(2)).sqrt(),
        }
    };
    facets.into_iter().map(one).sum()
}

/// All names have what they had.
fn assert_same<const D: usize>(new: &Mesh<D>, old: &Mesh<D>) {
    let is_same = |a: f64, b: f64| (a - b).abs() < 1e-12 * b.abs().max(1.0);
    assert!(is_same(volume(new), volume(old)));
    // a node that hangs on a facet would make it an exterior one
    let [new_outside, outside] = [new, old].map(|mesh| measure(mesh, mesh.exterior()));
    assert!(is_same(new_outside, outside), "{new_outside} {outside}");
    for name in old.boundary_names() {
        let of = |mesh: &Mesh<D>| measure(mesh, mesh.boundary(name).expect("kept"));
        assert!(is_same(of(new), of(old)), "{name}");
    }
    for name in old.region_names() {
        let of = |mesh: &Mesh<D>| {
            let cells = mesh.region_cells(name).expect("kept").iter();
            cells.map(|&k| mesh.volume(k)).sum::<f64>()
        };
        assert!(is_same(of(new), of(old)), "{name}");
    }
    assert!(new.boundary_names().eq(old.boundary_names()));
    assert!(new.region_names().eq(old.region_names()));
}

fn smallest_angle(mesh: &Mesh<2>) -> f64 {
    let of_cell = |k: usize| {
        let x = [0, 1, 2].map(|a| mesh.nodes()[mesh.corners(k)[a]]);
        let at = |a: usize| {
            let [b, c] = [x[(a + 1) % 3] - x[a], x[(a + 2) % 3] - x[a]];
            (b.dot(&c) / (b.norm() * c.norm())).acos()
        };
        (0..3).map(at).fold(f64::INFINITY, f64::min)
    };
    (0..mesh.len()).map(of_cell).fold(f64::INFINITY, f64::min)
}

/// 6√2 V / h³ of the worst cell: 1 if it is regular.
fn quality(mesh: &Mesh<3>) -> f64 {
    let of_cell = |k: usize| {
        let x = [0, 1, 2, 3].map(|a| mesh.nodes()[mesh.corners(k)[a]]);
        let pairs = CELL_EDGES.map(|[a, b]| (x[a] - x[b]).norm());
        let h = pairs.into_iter().fold(0.0, f64::max);
        6.0 * 2f64.sqrt() * mesh.volume(k) / (h * h * h)
    };
    (0..mesh.len()).map(of_cell).fold(f64::INFINITY, f64::min)
}

fn plate() -> Mesh<2> {
    let mesh = rectangle(
        &[0.0, 0.7, 1.0, 2.0],
        &[0.0, 0.3, 1.0],
        Diagonals::Alternating,
    );
    let mut mesh = mesh.expect("a mesh");
    mesh.name_region("one", |X| X[0] < 1.0);
    mesh.name_region("other", |X| X[0] > 0.7);
    mesh
}

#[test]
fn halved_cells_fill_the_same_space() {
    for mesh in [plate(), plate().quadratic()] {
        let finer = mesh.refined().expect("sound cells");
        assert_eq!(finer.len(), 4 * mesh.len());
        assert_same(&finer, &mesh);
        assert!((smallest_angle(&finer) / smallest_angle(&mesh) - 1.0).abs() < 1e-9);
        assert_same(&finer.refined().expect("sound cells"), &mesh);
    }
    let mut block = cuboid([0.0; 3], [1.0, 2.0, 1.0], [2, 3, 2]).expect("a mesh");
    block.name_region("half", |X| X[1] < 1.0);
    for mesh in [block.clone(), block.quadratic()] {
        let finer = mesh.refined().expect("sound cells");
        assert_eq!(finer.len(), 8 * mesh.len());
        assert_same(&finer, &mesh);
    }
}

/// Four times, every cell of a distorted block.
#[test]
fn tetrahedra_keep_their_quality() {
    let block = cuboid([0.0; 3], [1.0; 3], [1; 3]).expect("a mesh");
    let skew = Matrix::<3>::new(1.0, 0.4, -0.3, 0.0, 0.8, 0.5, 0.1, 0.0, 1.3);
    let mut mesh = block.mapped(|X| skew * X).expect("sound cells");
    let first = quality(&mesh);
    for _ in 0..4 {
        mesh = mesh.refined().expect("sound cells");
        assert!(quality(&mesh) > 0.5 * first, "{} {first}", quality(&mesh));
    }
}

fn skewed() -> Mesh<3> {
    let block = cuboid([0.0; 3], [1.0; 3], [2, 1, 1]).expect("a mesh");
    let skew = Matrix::<3>::new(1.0, 0.4, -0.3, 0.0, 0.8, 0.5, 0.1, 0.0, 1.3);
    let mut mesh = block.mapped(|X| skew * X).expect("sound cells");
    mesh.name_region("half", |X| X[0] < 0.9);
    let inner: Vec<[usize; 3]> = (0..2)
        .map(|k| [0, 1, 2].map(|a| mesh.corners(k)[a]))
        .collect();
    mesh.inner.insert("sheet".into(), inner);
    mesh
}

/// The cells of a mesh whose corners enclose a point.
fn around<const D: usize>(mesh: &Mesh<D>, at: &Vector<D>) -> Vec<bool> {
    let encloses = |cell: &[usize]| {
        let lambda = mesh.barycentric(cell, at);
        lambda.iter().all(|l| *l > -1e-9) && lambda.sum() < 1.0 + 1e-9
    };
    mesh.cells().map(encloses).collect()
}

/// The shape of a tetrahedron: the lengths of its six edges as shares of their sum, for the order of its corners that makes the list smallest.
fn shape(mesh: &Mesh<3>, k: usize, orders: &[[usize; 4]]) -> [i64; 6] {
    let x = [0, 1, 2, 3].map(|a| mesh.nodes()[mesh.corners(k)[a]]);
    let edges = |order: [usize; 4]| CELL_EDGES.map(|[a, b]| (x[order[a]] - x[order[b]]).norm());
    let sum: f64 = edges([0, 1, 2, 3]).iter().sum();
    let rounded = |l: f64| (1e7 * l / sum).round() as i64;
    let lists = orders.iter().map(|order| edges(*order).map(rounded));
    lists.min().expect("an order")
}

/// A single tetrahedron, ever so irregular, has no more than 72 shapes of descendants (Arnold, Mukherjee and Pouly, theorem 4.1), all of which are
/// there after four rounds.
#[test]
fn bisection_has_few_shapes() {
    let orders = (0..256).map(|n| [n % 4, n / 4 % 4, n / 16 % 4, n / 64]);
    let orders = orders.filter(|order| order.iter().collect::<BTreeSet<_>>().len() == 4);
    let orders: Vec<[usize; 4]> = orders.collect();
    let mut most = 0;
    for seed in 0..8 {
        let random = |k: usize| ((seed * 12 + k + 1) as f64 * 12.9898).sin().abs();
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.2, 1.0, 0.0], [0.1, 0.3, 1.0]];
        let moved = |a: usize| std::array::from_fn(|i| corners[a][i] + 0.6 * random(3 * a + i));
        let nodes: Vec<[f64; 3]> = (0..4).map(moved).collect();
        let mut mesh = Mesh::<3>::new(nodes, vec![0, 1, 2, 3]).expect("a cell");
        let mut shapes = BTreeSet::new();
        let mut before = 0;
        for _ in 0..4 {
            before = shapes.len();
            mesh = mesh
                .refined_where(&vec![true; mesh.len()])
                .expect("sound cells");
            shapes.extend((0..mesh.len()).map(|k| shape(&mesh, k, &orders)));
        }
        assert_eq!(shapes.len(), before, "{seed}: the last round adds none");
        assert!(shapes.len() <= 72, "{seed}: {}", shapes.len());
        most = most.max(shapes.len());
    }
    assert!(most > 8, "{most}");
}

/// Twelve times the cells around a corner, and around a point inside: no cell is worse than the worst that descends from one of the first mesh, all of
/// whose shapes come up when all cells are refined.
#[test]
fn bisected_tetrahedra_keep_their_quality() {
    let mut all = skewed();
    let mut bound = f64::INFINITY;
    for _ in 0..4 {
        all = all
            .refined_where(&vec![true; all.len()])
            .expect("sound cells");
        bound = bound.min(quality(&all));
    }
    assert!(bound > 0.15 * quality(&skewed()), "{bound}");
    for at in [skewed().nodes()[0], Vector::<3>::new(0.913, 0.377, 0.61)] {
        for mesh in [skewed(), skewed().quadratic()] {
            let mut finer = mesh.clone();
            for level in 1..=12 {
                let marked = around(&finer, &at);
                assert!(marked.contains(&true));
                let before = finer.len();
                finer = finer.refined_where(&marked).expect("sound cells");
                assert!(quality(&finer) > bound - 1e-9, "{level}");
                assert!(
                    finer.len() < before + 700,
                    "{level}: {before} {}",
                    finer.len()
                );
            }
            assert_same(&finer, &mesh);
            let smallest = (0..finer.len()).map(|k| finer.volume(k).cbrt());
            assert!(smallest.fold(1.0, f64::min) < 1e-3);
            let area = |facets: &[[usize; 3]]| {
                measure(&finer, facets.iter().map(|facet| facet.as_slice()))
            };
            let (_, new) = finer.inner_facets().next().expect("kept");
            let (_, old) = mesh.inner_facets().next().expect("named");
            assert!((area(new) / area(old) - 1.0).abs() < 1e-12);
        }
    }
}

/// Cells of random marks, round after round, in a ball whose new corners are drawn onto the sphere.
#[test]
fn balls_can_be_refined_anywhere() {
    for quadratic in [false, true] {
        let mut mesh = sphere(1.0, 2).expect("a ball");
        if quadratic {
            mesh = mesh.quadratic();
            mesh = mesh.curved("surface", onto_sphere(1.0)).expect("sound");
        }
        let volume_of = |mesh: &Mesh<3>| (volume(mesh) - 4.0 / 3.0 * std::f64::consts::PI).abs();
        let (first, worst) = (volume_of(&mesh), quality(&mesh));
        for round in 0..4 {
            let random = |k: usize| (((k + 1) * (round + 3)) as f64 * 78.233).sin().abs() < 0.08;
            let marked: Vec<bool> = (0..mesh.len()).map(random).collect();
            mesh = mesh.refined_where(&marked).expect("sound cells");
            mesh = mesh.drawn("surface", onto_sphere(1.0)).expect("sound");
            if quadratic {
                mesh = mesh.curved("surface", onto_sphere(1.0)).expect("sound");
            }
            assert!(quality(&mesh) > 0.15 * worst, "{round}");
        }
        assert!(volume_of(&mesh) < 0.4 * first);
        let outside: BTreeSet<usize> = mesh.exterior().flatten().copied().collect();
        let off = outside
            .iter()
            .map(|&a| (mesh.nodes()[a].norm() - 1.0).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12);
    }
}

/// Ten times the cells around a corner, and around a point inside.
#[test]
fn no_angle_becomes_smaller_than_half_the_smallest() {
    for at in [[0.0, 0.0], [0.913, 0.377]].map(Vector::<2>::from) {
        for mesh in [plate(), plate().quadratic()] {
            let (first, mut finer) = (smallest_angle(&mesh), mesh.clone());
            for level in 1..=10 {
                let marked = around(&finer, &at);
                assert!(marked.contains(&true));
                finer = finer.refined_where(&marked).expect("sound cells");
                assert!(smallest_angle(&finer) > 0.5 * first - 1e-9, "{level}");
            }
            assert_same(&finer, &mesh);
            assert!(finer.len() < 1000, "{}", finer.len());
            let size = |k: usize| finer.volume(k).sqrt();
            let smallest = (0..finer.len()).map(size).fold(1.0, f64::min);
            assert!(smallest < 2e-3, "{smallest}");
        }
    }
}

/// The quadratic map of a cell is that of its pieces, and a curve can be drawn again.
#[test]
fn curved_cells_keep_their_shape() {
    let onto = |X: &Vector<2>| X / X.norm();
    let mesh = disc(1.0, 12, 2, 0.0).expect("a mesh").quadratic();
    let mesh = mesh.curved("boundary", onto).expect("sound cells");
    let marked: Vec<bool> = (0..mesh.len()).map(|k| k % 3 == 0).collect();
    let finer = mesh.refined_where(&marked).expect("sound cells");
    assert!((volume(&finer) - volume(&mesh)).abs() < 1e-13);
    let finer = mesh.refined().expect("sound cells");
    assert!((volume(&finer) - volume(&mesh)).abs() < 1e-13);
    let drawn = finer.curved("boundary", onto).expect("sound cells");
    let area = std::f64::consts::PI;
    assert!((volume(&drawn) - area).abs() < 0.1 * (volume(&mesh) - area).abs());
    let ring = annulus(&[1.0, 1.5, 2.0], 8, Diagonals::Rising).expect("a mesh");
    assert_same(&ring.refined().expect("sound cells"), &ring);
}

/// A field that the cells of a mesh represent, on those of a finer one.
fn check<const D: usize>(mesh: Mesh<D>, of: &dyn Fn(&Vector<D>) -> Vector<D>) {
    let marked: Vec<bool> = (0..mesh.len()).map(|k| k % 4 == 1).collect();
    let mut field: Vec<Vector<D>> = mesh.nodes().iter().map(of).collect();
    let finer = mesh.refined_with(&marked, &mut field).expect("sound cells");
    assert!(field.len() > mesh.nodes().len());
    assert_eq!(field.len(), finer.nodes().len());
    for (value, X) in field.iter().zip(finer.nodes()) {
        assert!((value - of(X)).norm() < 1e-13, "{value} {X}");
    }
}

/// A field that cells represent is the same on their pieces.
#[test]
fn fields_are_carried_exactly() {
    let linear = |X: &Vector<2>| Vector::<2>::new(0.3 + X[0] - 2.0 * X[1], 0.7 * X[1]);
    let bent = |X: &Vector<2>| linear(X) + Vector::<2>::new(X[0] * X[1], X[1] * X[1] - X[0]);
    check(plate(), &linear);
    check(plate().quadratic(), &bent);
    let linear = |X: &Vector<3>| Vector::<3>::new(X[0] - 2.0 * X[1], 0.7 * X[2], 0.3 + X[1]);
    let bent = |X: &Vector<3>| linear(X) + Vector::<3>::new(X[0] * X[1], X[2] * X[2], X[1] * X[2]);
    check(skewed(), &linear);
    check(skewed().quadratic(), &bent);
    let marked = vec![true; plate().len()];
    let refused = plate().refined_with(&marked, &mut vec![Vector::zeros()]);
    let refused = refused.expect_err("one value").to_string();
    assert!(refused.contains("field"), "{refused}");
}

/// A line within the mesh that has a name.
#[test]
fn names_within_are_kept() {
    let mut mesh = plate();
    let corners = |k: usize| [mesh.corners(k)[0], mesh.corners(k)[1]];
    let line = vec![corners(0), corners(3)];
    let length = |mesh: &Mesh<2>, line: &[[usize; 2]]| -> f64 {
        let one = |[a, b]: &[usize; 2]| (mesh.nodes()[*a] - mesh.nodes()[*b]).norm();
        line.iter().map(one).sum()
    };
    mesh.inner.insert("seam".into(), line.clone());
    let finer = mesh.refined().expect("sound cells");
    let (name, found) = finer.inner_facets().next().expect("kept");
    assert_eq!((name, found.len()), ("seam", 4));
    assert!((length(&finer, found) - length(&mesh, &line)).abs() < 1e-14);
}

#[test]
fn marks_are_one_a_cell() {
    let refused = plate().refined_where(&[true]).expect_err("one mark");
    assert!(refused.to_string().contains("marks"), "{refused}");
    let same = plate().refined_where(&vec![false; plate().len()]);
    assert_eq!(same.expect("the same").len(), plate().len());
}

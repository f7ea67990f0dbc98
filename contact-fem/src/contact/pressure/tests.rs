//! The recovered field on single surfaces.

use super::*;
use crate::element::Order;

/// What nodal forces give without gaps, all in passes of the surface.
fn recovered(surface: &Surface<2>, forces: &[Vector<2>], gaps: &[Option<f64>]) -> Vec<f64> {
    let pressed = Pressed {
        surface,
        x: surface.reference_nodes(),
        normals: surface.reference_normals(),
        forces,
        own: forces,
        gaps,
        facing: &[],
        moduli: &vec![1.0; gaps.len()],
    };
    pressed.pressures()
}

/// A surface with nodes at distances 1 whose every other node carries the force of two, on one with nodes at distances 2.
#[test]
fn what_the_other_surface_cannot_resolve_is_averaged() {
    let x: Vec<Vector<2>> = (0..=12)
        .map(|k| Vector::<2>::new(f64::from(k), 0.0))
        .collect();
    let surface = polyline(&x);
    let force = |a: usize| if a % 2 == 0 { 2.0 } else { 1e-3 };
    let inside = |a: usize| (3..=9).contains(&a);
    let forces = |a: usize| Vector::<2>::new(0.0, if inside(a) { force(a) } else { 0.0 });
    let forces: Vec<Vector<2>> = (0..x.len()).map(forces).collect();
    let at = |spacing: f64| {
        let facing: Vec<_> = (1..7)
            .map(|k| (Vector::<2>::new(2.0 * f64::from(k), 0.0), spacing))
            .collect();
        let pressed = Pressed {
            surface: &surface,
            x: &x,
            normals: surface.reference_normals(),
            forces: &forces,
            own: &forces,
            gaps: &vec![None; x.len()],
            facing: &facing,
            moduli: &vec![1.0; x.len()],
        };
        pressed.pressures()
    };
    let own = at(1.0);
    assert!(own[6] > 1.9 && own[7] < 0.1, "{own:?}");
    let wider = at(2.0);
    // by hand: a half of the node and a quarter of each of its neighbours
    let middle = wider[6];
    assert!((middle - 1.0005).abs() < 0.05, "{wider:?}");
    assert!(
        (4..9).all(|a| (wider[a] - middle).abs() < 1e-2),
        "{wider:?}"
    );
    assert!((wider.iter().sum::<f64>() - forces.iter().map(|f| f[1]).sum::<f64>()).abs() < 1e-9);
    assert_eq!(wider[2], 0.0);
}

fn polyline(x: &[Vector<2>]) -> Surface<2> {
    let facets: Vec<[usize; 2]> = (1..x.len()).map(|k| [k - 1, k]).collect();
    Surface::new(0, Order::Linear, facets.iter().map(|f| &f[..]), x)
}

/// Half of the normal times the length of each segment goes to either end.
#[test]
fn a_constant_pressure_on_a_polygon_is_exact() {
    let x = [0.0, 0.2, 0.5, 0.6, 1.0].map(|t: f64| Vector::<2>::new(t.cos(), t.sin()));
    let surface = polyline(&x);
    let mut forces = [Vector::<2>::zeros(); 5];
    for (facet, reference) in surface.facets().zip(surface.reference()) {
        let half = reference.normal(&Vector::<2>::repeat(0.5)) * 0.5;
        facet.iter().for_each(|&a| forces[a] -= half * 3.0);
    }
    for gap in [None, Some(0.0)] {
        for p in recovered(&surface, &forces, &[gap; 5]) {
            assert!((p - 3.0).abs() < 1e-12, "{p}");
        }
    }
    let none = recovered(&surface, &[Vector::zeros(); 5], &[None; 5]);
    assert_eq!(none, [0.0; 5]);
}

/// The force of one node is no number: its pressure is none, too, and those of others are what they are.
#[test]
fn a_force_that_is_no_number() {
    let x: Vec<Vector<2>> = (0..=6)
        .map(|k| Vector::<2>::new(f64::from(k), 0.0))
        .collect();
    let surface = polyline(&x);
    let force = |k: usize| match k {
        1 => f64::NAN,
        3..=5 => 2.0,
        _ => 0.0,
    };
    let forces: Vec<_> = (0..7).map(|k| Vector::<2>::new(0.0, force(k))).collect();
    let p = recovered(&surface, &forces, &[None; 7]);
    let expected = [0.0, f64::NAN, 0.0, 2.0, 2.0, 2.0, 0.0];
    for (p, expected) in p.iter().zip(expected) {
        assert!((p - expected).abs() < 1e-12 || p.is_nan() && expected.is_nan());
    }
}

/// A constant pressure over a part of a fine surface: facets of the other one that are four times as large leave it what it is.
#[test]
fn a_constant_pressure_on_a_part_stays_constant() {
    let x: Vec<Vector<2>> = (0..=20)
        .map(|k| Vector::<2>::new(f64::from(k), 0.0))
        .collect();
    let surface = polyline(&x);
    let inside = |a: usize| (5..=15).contains(&a);
    let forces: Vec<_> = (0..x.len())
        .map(|a| Vector::<2>::new(0.0, if inside(a) { 3.0 } else { 0.0 }))
        .collect();
    let facing: Vec<_> = (0..=5)
        .map(|k| (Vector::<2>::new(4.0 * f64::from(k), 0.0), 4.0))
        .collect();
    let pressed = Pressed {
        surface: &surface,
        x: &x,
        normals: surface.reference_normals(),
        forces: &forces,
        own: &forces,
        gaps: &vec![None; x.len()],
        facing: &facing,
        moduli: &vec![1.0; x.len()],
    };
    for (a, p) in pressed.pressures().iter().enumerate() {
        let expected = if inside(a) { 3.0 } else { 0.0 };
        assert!((p - expected).abs() < 1e-12, "{p} at {a}");
    }
}

/// Forces that are not along a curved surface's normals, without a moment about its centre: the field has their resultant.
#[test]
fn a_curved_surface_bears_whole_forces() {
    let angle = |k: usize| -0.6 + 0.1 * k as f64;
    let x: Vec<Vector<2>> = (0..=12)
        .map(|k| Vector::<2>::new(angle(k).sin(), -angle(k).cos()))
        .collect();
    let surface = polyline(&x);
    let forces: Vec<_> = (0..=12)
        .map(|k| Vector::<2>::new(0.0, 1.0 + 0.1 * k.min(12 - k) as f64))
        .collect();
    let p = recovered(&surface, &forces, &[None; 13]);
    let mut resultant = Vector::<2>::zeros();
    for (facet, reference) in surface.facets().zip(surface.reference()) {
        let n = reference.normal(&Vector::<2>::repeat(0.5));
        resultant -= n * (0.5 * (p[facet[0]] + p[facet[1]]));
    }
    let wanted: Vector<2> = forces.iter().sum();
    assert!((resultant - wanted).norm() < 1e-9, "{resultant} {wanted}");
}

/// A ring under an alternating pressure of mean 1.25: some of it is taken away by gaps, and given back as a whole.
#[test]
fn a_closed_surface_keeps_the_sum_of_its_forces() {
    let x: Vec<Vector<2>> = (0..16)
        .map(|k| f64::from(k) * std::f64::consts::PI / 8.0)
        .map(|t| Vector::<2>::new(t.cos(), t.sin()))
        .collect();
    let facets: Vec<[usize; 2]> = (0..16).map(|k| [k, (k + 1) % 16]).collect();
    let surface = Surface::new(0, Order::Linear, facets.iter().map(|f| &f[..]), &x);
    let push = |a: usize| if a % 2 == 0 { 1.0 } else { 1.5 };
    let normals = surface.reference_normals();
    let forces: Vec<_> = (0..16).map(|a| normals[a] * -push(a)).collect();
    let gaps: Vec<_> = (0..16)
        .map(|a| Some(if a % 2 == 0 { 0.4 } else { -0.4 }))
        .collect();
    let p = recovered(&surface, &forces, &gaps);
    assert!(p[0] < 0.9 * p[1], "{p:?}");
    // half of the normals times the lengths of the segments beside each node, along its own
    let area = 2.0 * (std::f64::consts::PI / 16.0).sin() * (std::f64::consts::PI / 16.0).cos();
    let sum: f64 = p.iter().map(|p| p * area).sum();
    assert!((sum - 16.0 * 1.25).abs() < 1e-9, "{sum}");
}

/// Gaps that are worth more than all pressure, everywhere: the forces press all the same.
#[test]
fn gaps_do_not_take_all_pressure_of_a_surface() {
    let x = [0.0, 1.0, 2.0, 3.0].map(|x| Vector::<2>::new(x, 0.0));
    let surface = polyline(&x);
    let n = surface.reference_normals()[0];
    let forces = [0.5, 1.0, 1.0, 0.5].map(|push| n * -3.0 * push);
    for p in recovered(&surface, &forces, &[Some(1e3); 4]) {
        assert!((p - 3.0).abs() < 1e-12, "{p}");
    }
}

/// Rows of a polygon around a circle of radius 1 + d, beside a circle of radius 1: nodes have the gap d, rows a mean that is less by a
/// twelfth of the square of a facet, and so does each row's offset tell. Rows that have a part alone tell nothing.
#[test]
fn rows_have_less_gap_than_nodes_around_a_circle() {
    let count = 64;
    let angle = std::f64::consts::TAU / f64::from(count);
    let (d, radius) = (1e-3, 1.001);
    let x: Vec<_> = (0..count)
        .map(|k| {
            Vector::<2>::new((angle * f64::from(k)).cos(), (angle * f64::from(k)).sin()) * radius
        })
        .collect();
    // the bore of a body, whose outward side is the circle's
    let facets: Vec<[usize; 2]> = (0..x.len()).map(|k| [(k + 1) % x.len(), k]).collect();
    let surface = Surface::new(0, Order::Linear, facets.iter().map(|f| &f[..]), &x);
    let facet = 2.0 * radius * (0.5 * angle).sin();
    // the mean of a hat function over both facets of |x| − 1, by fine sums
    let fine = 2000;
    let mean = (0..fine).map(|k| {
        let s = (f64::from(k) + 0.5) / f64::from(fine);
        let x = x[0] * (1.0 - s) + x[1] * s;
        2.0 * (1.0 - s) / f64::from(fine) * (x.norm() - 1.0)
    });
    let mean: f64 = mean.sum();
    let offsets =
        |size: f64| row_offsets(&surface, &vec![Some(d); x.len()], |_| Some((mean, size)));
    for offset in offsets(facet) {
        assert!(
            (offset / (-facet * facet / 12.0) - 1.0).abs() < 1e-2,
            "{offset}"
        );
    }
    assert!(offsets(0.9 * facet).iter().all(|offset| *offset == 0.0));
}

/// Linear multipliers on quadratic triangles: corners and middles of edges without a force have no pressure.
#[test]
fn quadratic_triangles_are_open_where_nothing_presses() {
    let n = 8;
    let at = |i: usize, j: usize| i * (2 * n + 1) + j;
    let x: Vec<Vector<3>> = (0..=2 * n)
        .flat_map(|i| (0..=2 * n).map(move |j| Vector::<3>::new(i as f64, j as f64, 0.0)))
        .collect();
    let mut facets = Vec::new();
    for i in (0..2 * n).step_by(2) {
        for j in (0..2 * n).step_by(2) {
            let corners = |k: [[usize; 2]; 3]| k.map(|[a, b]| [i + 2 * a, j + 2 * b]);
            for [a, b, c] in [
                corners([[0, 0], [1, 0], [1, 1]]),
                corners([[0, 0], [1, 1], [0, 1]]),
            ] {
                let middle =
                    |p: [usize; 2], q: [usize; 2]| at((p[0] + q[0]) / 2, (p[1] + q[1]) / 2);
                let [p, q, r] = [a, b, c].map(|[i, j]| at(i, j));
                facets.push([p, q, r, middle(a, b), middle(b, c), middle(c, a)]);
            }
        }
    }
    let surface = Surface::new(0, Order::Quadratic, facets.iter().map(|f| &f[..]), &x);
    // a multiplier of 1 at corners within 5 of the middle
    let centre = Vector::<3>::new(n as f64, n as f64, 0.0);
    let lambda = |a: usize| {
        if (x[a] - centre).norm() < 5.0 {
            1.0
        } else {
            0.0
        }
    };
    let mut forces = vec![Vector::<3>::zeros(); x.len()];
    for facet in &facets {
        for (w, l) in FacetRule::<3>::gauss(4).points() {
            let p: f64 = (0..3).map(|k| lambda(facet[k]) * l[k]).sum();
            let shapes = facet_shapes(Order::Quadratic, l);
            for (&a, N) in facet.iter().zip(shapes) {
                forces[a][2] += 2.0 * w * p * N;
            }
        }
    }
    let normals: Vec<_> = vec![Vector::<3>::new(0.0, 0.0, -1.0); x.len()];
    let facing = [(centre, 4.0)];
    for facing in [&facing[..0], &facing[..]] {
        let pressed = Pressed {
            surface: &surface,
            x: &x,
            normals: &normals,
            forces: &forces,
            own: &forces,
            gaps: &vec![None; x.len()],
            facing,
            moduli: &vec![1.0; x.len()],
        };
        for (a, p) in pressed.pressures().iter().enumerate() {
            let is_corner = (x[a][0] as usize % 2, x[a][1] as usize % 2) == (0, 0);
            // the multiplier of a corner reaches to the next ones
            let is_open = is_corner && lambda(a) == 0.0 || forces[a].norm() < 1e-12 && !is_corner;
            assert!(!is_open || *p == 0.0, "{p} at {:?}", x[a]);
        }
    }
}

/// Forces whose sums overflow end the search for balance.
#[test]
fn forces_beyond_all_bounds() {
    let x = [0.0, 1.0, 2.0].map(|x| Vector::<2>::new(x, 0.0));
    let forces = [Vector::<2>::new(0.0, 1e308); 3];
    assert_eq!(recovered(&polyline(&x), &forces, &[None; 3]).len(), 3);
}

/// Forces of which one pulls: the field does not, and has their resultant and moment, by hand for segments of length 1.
#[test]
fn the_field_does_not_pull_and_keeps_resultant_and_moment() {
    let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|x| Vector::<2>::new(x, 0.0));
    let surface = polyline(&x);
    let n = surface.reference_normals()[0];
    let pushes = [0.5, 1.0, 0.6, 0.4, -0.1, 0.0];
    let forces = pushes.map(|push| n * -push);
    let areas = [0.5, 1.0, 1.0, 1.0, 1.0, 0.5];
    let sums = |of: &dyn Fn(usize) -> f64| -> [f64; 2] {
        [0, 1].map(|power| (0..6).map(|a| of(a) * x[a][0].powi(power)).sum())
    };
    let wanted = sums(&|a| pushes[a]);
    for gap in [0.0, 0.05] {
        // the gap of one node is worth something
        let gaps = [None, Some(gap), None, None, None, None];
        let p = recovered(&surface, &forces, &gaps);
        assert!(p.iter().all(|p| *p >= 0.0) && p[4..] == [0.0; 2], "{p:?}");
        let found = sums(&|a| areas[a] * p[a]);
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
        }
    }
    let at = |gap: f64| {
        recovered(
            &surface,
            &forces,
            &[None, Some(gap), None, None, None, None],
        )[1]
    };
    assert!(at(0.05) < at(0.0) && at(-0.05) > at(0.0));
}

/// The force of a node beside the loaded ones grows from nothing: no pressure jumps, though one gap takes much of what presses
/// and all nodes are moved for it.
#[test]
fn pressures_begin_without_a_jump() {
    let x: Vec<Vector<2>> = (0..=8)
        .map(|k| Vector::<2>::new(f64::from(k), 0.0))
        .collect();
    let surface = polyline(&x);
    let mut gaps = vec![Some(0.0); x.len()];
    gaps[3] = Some(2.0);
    let coarse = [(Vector::<2>::new(4.0, 0.0), 3.0)];
    for facing in [&coarse[..0], &coarse[..]] {
        let at = |force: f64| {
            let push = |a: usize| match a {
                2..=5 => 2.0,
                6 => force,
                _ => 0.0,
            };
            let forces: Vec<_> = (0..x.len())
                .map(|a| Vector::<2>::new(0.0, push(a)))
                .collect();
            let pressed = Pressed {
                surface: &surface,
                x: &x,
                normals: surface.reference_normals(),
                forces: &forces,
                own: &forces,
                gaps: &gaps,
                facing,
                moduli: &vec![1.0; x.len()],
            };
            pressed.pressures()
        };
        let apart = |a: &[f64], b: &[f64]| {
            let pairs = a.iter().zip(b).map(|(a, b)| (a - b).abs());
            pairs.fold(0.0, f64::max)
        };
        let none = at(0.0);
        assert!((none[3] - 2.0).abs() > 0.05, "{none:?}");
        for force in [-1e-9, 1e-15, 1e-12, 1e-9] {
            let off = apart(&at(force), &none);
            assert!(off < 1e-5, "{off} under {force}");
        }
        for step in 0..1000 {
            let [force, next] = [step, step + 1].map(|k| 1e-6 * f64::from(k));
            let off = apart(&at(force), &at(next));
            assert!(off < 1e-2, "{off} from {force}");
        }
    }
}

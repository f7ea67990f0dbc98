use std::fs;
use std::path::Path;

use nalgebra::DVector;

use super::faces::middle;
use super::feet::{self, Point};
use super::*;
use crate::LinearElastic;
use crate::Simulation;
use crate::certificate::Condition;
use crate::mesh::Mesh;
use crate::mesh::generators::{Diagonals, annulus, cuboid, disc, linspace, rectangle};
use crate::model::{Body, Scene};

/// The sources name nothing of the solver's contact, nor of solvers.
#[test]
fn the_sources_share_nothing_with_the_solver() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/certificate");
    let mut files = vec![folder.join("slope.rs")];
    let own = fs::read_dir(folder.join("remeasured")).expect("a folder");
    files.extend(own.map(|entry| entry.expect("an entry").path()));
    assert!(files.len() > 6);
    for file in files.iter().filter(|file| !file.ends_with("tests.rs")) {
        let text = fs::read_to_string(file).expect("a source");
        let code = text
            .lines()
            .map(|line| line.split("//").next().unwrap_or_default());
        for line in code {
            for shared in [
                "::contact::",
                "contact::{",
                "facet_shapes",
                "FacetRule",
                "Facet::",
                "condensed",
                "newton",
                "equilibrium",
                "rows_at",
                "rows_of",
                "linearize",
                "vary_gaps",
                "located",
                "rstar",
            ] {
                assert!(!line.contains(shared), "{}: {line}", file.display());
            }
        }
    }
}

fn faces<const D: usize>(mesh: &Mesh<D>, boundary: &str) -> Faces<D> {
    Faces::new(mesh, (0, 0), boundary).expect("named")
}

/// Averaged normals of regular polygons and of a block point away from the bodies, and have length 1.
#[test]
fn normals_point_outward() {
    let mesh = disc(2.0, 24, 2, 0.1).expect("mesh");
    let own = faces(&mesh, "boundary");
    let placed = Placed::new(&own, mesh.nodes());
    for f in 0..own.len() {
        let [places, normals] = placed.patches(f);
        for lambda in [[1.0, 0.0], [0.0, 1.0]].map(Vector::<2>::from) {
            let radial = places.at(&lambda) / 2.0;
            assert!((normals.at(&lambda) - radial).norm() < 1e-12);
        }
        assert!(places.normal(&middle()).dot(&places.at(&middle())) > 0.0);
    }
    for order in [Order::Linear, Order::Quadratic] {
        let mesh = cuboid([0.0; 3], [1.0; 3], [2, 3, 2]).expect("mesh");
        let mesh = if order == Order::Linear {
            mesh
        } else {
            mesh.quadratic()
        };
        let own = faces(&mesh, "top");
        let placed = Placed::new(&own, mesh.nodes());
        let area: f64 = (0..own.len()).map(|f| own.measure(f, &middle())).sum();
        assert!((area - 1.0).abs() < 1e-12);
        let up = Vector::<3>::new(0.0, 0.0, 1.0);
        for f in 0..own.len() {
            let [_, normals] = placed.patches(f);
            assert!((normals.at(&middle()) - up).norm() < 1e-12);
        }
    }
}

/// The foot of a point above a flat side is below it; beyond the side's end there is none, and none behind a surface that faces the
/// same way.
#[test]
fn feet_on_a_flat_side() {
    let mesh = rectangle(
        &linspace(0.0, 3.0, 7),
        &linspace(0.0, 1.0, 2),
        Diagonals::Rising,
    );
    let mesh = mesh.expect("mesh");
    let own = faces(&mesh, "top");
    let placed = Placed::new(&own, mesh.nodes());
    let foot = |x: [f64; 2], facing: f64| {
        let [x, facing] = [x, [0.0, facing]].map(Vector::<2>::from);
        let point = Point {
            x,
            facing,
            X: x,
            N: facing,
            own: None,
        };
        feet::foot(
            (&own, &placed),
            &point,
            Reach {
                radius: 1.0,
                size: 0.5,
                fit: 0.0,
            },
        )
    };
    for (x, gap) in [([1.1, 1.2], 0.2), ([2.9, 0.97], -0.03), ([0.0, 1.9], 0.9)] {
        let found = foot(x, -1.0).expect("a foot");
        assert!((found.gap - gap).abs() < 1e-12, "{x:?}: {}", found.gap);
    }
    assert!(foot([3.1, 1.1], -1.0).is_none(), "beyond the end");
    assert!(foot([1.0, 2.1], -1.0).is_none(), "out of reach");
    assert!(foot([1.0, 1.1], 1.0).is_none(), "turned away");
}

/// A straight strip is bent into a hairpin. A point of the outer side of one arm does not meet the outer side of the other arm from behind: the strip is
/// in between, twice, and no path along the straight strip leads through it.
#[test]
fn arms_of_a_bent_strip_do_not_meet_from_behind() {
    let bend = std::f64::consts::PI;
    let mesh = rectangle(
        &linspace(0.0, 4.0 + bend, 60),
        &linspace(0.0, 0.1, 1),
        Diagonals::Rising,
    );
    let mut mesh = mesh.expect("mesh");
    mesh.name_boundary("skin", |X| X[1] == 0.0 || X[1] == 0.1);
    let own = faces(&mesh, "skin");
    // the strip's lower side is outside
    let bent = mesh.nodes().iter().map(|X| match X[0] - 2.0 {
        before if before < 0.0 => Vector::<2>::new(X[0], X[1]),
        angle if angle < bend => {
            let radius = 1.0 - X[1];
            Vector::<2>::new(2.0 + radius * angle.sin(), 1.0 - radius * angle.cos())
        }
        after => Vector::<2>::new(2.0 - (after - bend), 2.0 - X[1]),
    });
    let bent: Vec<Vector<2>> = bent.collect();
    let placed = Placed::new(&own, &bent);
    let reach = Reach {
        radius: 3.0,
        size: own.size(),
        fit: 0.0,
    };
    let search = Search {
        x: &bent,
        reach,
        places: &Places::pieces(&own, &own),
        is_one_body: true,
        has_force: &vec![true; own.nodes.len()],
    };
    let pass = Pass::new(&own, &placed, &search);
    let deepest = pass.held.iter().map(|point| point.foot.gap);
    let deepest = deepest.fold(f64::INFINITY, f64::min);
    // points of the inner sides see each other
    assert!((deepest - 1.8).abs() < 1e-4, "{deepest}");
}

/// Rows of a disc in a ring of the same centre: each weak gap is between those of the polygons' corners and of their middles.
#[test]
fn weak_gaps_of_a_disc_in_a_ring() {
    let ring = annulus(&[1.0, 1.5], 48, Diagonals::Rising).expect("mesh");
    let disc = disc(0.9, 37, 2, 0.05).expect("mesh");
    let (inner, outer) = (faces(&disc, "boundary"), faces(&ring, "inner"));
    let master = Placed::new(&outer, ring.nodes());
    let search = Search {
        x: disc.nodes(),
        reach: Reach {
            radius: 1.0,
            size: outer.size(),
            fit: 0.0,
        },
        places: &Places::pieces(&inner, &outer),
        is_one_body: false,
        has_force: &vec![false; inner.nodes.len()],
    };
    let pass = Pass::new(&inner, &master, &search);
    let of_points: Vec<f64> = pass.held.iter().map(|point| point.foot.gap).collect();
    let flat = |n: f64| 1.0 - (std::f64::consts::PI / n).cos();
    let bounds = [0.1 - flat(48.0), 0.1 + 0.9 * flat(37.0)];
    for c in pass.gaps(&of_points) {
        assert!(bounds[0] < c && c < bounds[1], "{c} {bounds:?}");
    }
    let length: f64 = pass.held.iter().map(|point| point.weight).sum();
    let perimeter = 2.0 * 0.9 * 37.0 * (std::f64::consts::PI / 37.0).sin();
    assert!((length - perimeter).abs() < 1e-9 * perimeter);
}

/// The depth inside the end of a side of three squares by two: 0 at its rim, 1 in the middle of facets and at inner corners, and nowhere larger than
/// six times the distance from the rim in squares.
#[test]
fn depths_inside_the_end() {
    let mesh = cuboid([0.0; 3], [3.0, 2.0, 1.0], [3, 2, 1]).expect("mesh");
    let own = faces(&mesh, "top");
    let placed = Placed::new(&own, mesh.nodes());
    for f in 0..own.len() {
        let [places, _] = placed.patches(f);
        assert!((own.depth(f, &middle()) - 1.0).abs() < 1e-14);
        for k in 0..=20 {
            for l in 0..=20 - k {
                let [k, l] = [k, l].map(|n| f64::from(n) / 20.0);
                let lambda = Vector::<3>::new(k, l, 1.0 - k - l);
                let x = places.at(&lambda);
                let sides = [x[0], x[1], 3.0 - x[0], 2.0 - x[1]];
                let from_rim = sides.into_iter().fold(f64::INFINITY, f64::min);
                let depth = own.depth(f, &lambda);
                assert!(depth <= 6.0 * from_rim + 1e-13, "{x:?}: {depth}");
                assert!(depth >= from_rim.min(0.5) - 1e-13 && depth <= 1.0 + 1e-13);
            }
        }
    }
}

/// Blocks whose facets do not match, of which the upper one is smaller: at Gauss points, both measurements are the same but for
/// round-off, rows at rims included.
#[test]
fn gauss_points_leave_round_off() {
    let body = |mesh: Mesh<3>, side: &str, by: f64| {
        let mut body = Body::new(mesh, LinearElastic::new(1.0, 0.3).expect("a law"));
        let held = [Some(0.0), Some(0.0), Some(by)];
        body.prescribe(side, held).expect("a side");
        body
    };
    for quadratic in [false, true] {
        let lower = cuboid([0.0; 3], [1.0; 3], [4, 3, 2]).expect("mesh");
        let upper = cuboid([0.15, 0.1, 1.0], [0.83, 0.9, 1.5], [2, 3, 1]).expect("mesh");
        let [lower, upper] = [lower, upper].map(|mesh| match quadratic {
            true => mesh.quadratic(),
            false => mesh,
        });
        let mut scene = Scene::new();
        let lower = scene.add("lower", body(lower, "bottom", 0.0));
        let upper = scene.add("upper", body(upper, "top", -0.05));
        let sides = (lower.on("top"), upper.on("bottom"));
        scene.contact(sides.0, sides.1).expect("a pair");
        let mut problem = scene.problem().expect("a problem");
        let history = Simulation::with_increments(1).run(&mut problem);
        let history = history.expect("a run");
        let certificate = history.certificate().expect("a step");
        for condition in [
            Condition::RemeasuredPenetration,
            Condition::RemeasuredComplementarity,
            Condition::RemeasuredAreas,
            Condition::RemeasuredForces,
        ] {
            let left = certificate.left(condition).expect("computed");
            assert!(left < 1e-6, "{condition:?}: {left:.1e}\n{certificate}");
        }
    }
}

/// A block overhangs another one, whose last facet is a ten-thousandth of the others: no halving of a facet of the former finds on both sides of the
/// end what it found before.
#[test]
fn facets_beside_a_tiny_one_are_cut() {
    for last in [2.0, 5e-5, 1e-5, 1e-6] {
        let places = [0.0, 0.5, 1.0, 1.5, 2.0 - last, 2.0];
        let lower = rectangle(&places, &[0.0, 1.0], Diagonals::Rising);
        let lower = match last < 0.5 {
            true => lower,
            false => rectangle(&[0.0, 2.0], &[0.0, 1.0], Diagonals::Rising),
        };
        let lower = lower.expect("mesh");
        let upper = rectangle(&linspace(0.1, 4.0, 9), &[1.001, 1.5], Diagonals::Rising);
        let upper = upper.expect("mesh");
        let (slave, master) = (faces(&upper, "bottom"), faces(&lower, "top"));
        let placed = Placed::new(&master, lower.nodes());
        let search = Search {
            x: upper.nodes(),
            reach: Reach {
                radius: 1.0,
                size: 0.5,
                fit: 0.0,
            },
            is_one_body: false,
            places: &Places::pieces(&slave, &master),
            has_force: &vec![true; slave.nodes.len()],
        };
        let pass = Pass::new(&slave, &placed, &search);
        let opposite: f64 = pass.held.iter().map(|point| point.weight).sum();
        assert!((opposite - 1.9).abs() < 1e-4, "{last}: {opposite}");
    }
}

/// The slopes of point forces along a random motion are differences of these forces with feet that are looked for again: of polygons in each
/// other, of curved facets, and in space.
#[test]
fn slopes_of_forces_are_differences() {
    let plane = |order: Order| {
        let ring = annulus(&[1.0, 1.5], 24, Diagonals::Rising).expect("mesh");
        let disc = disc(0.9, 19, 2, 0.05).expect("mesh");
        match order {
            Order::Linear => [disc, ring],
            Order::Quadratic => [disc.quadratic(), ring.quadratic()],
        }
    };
    for order in [Order::Linear, Order::Quadratic] {
        let [disc, ring] = plane(order);
        differences([&disc, &ring], ["boundary", "inner"]);
        let lower = cuboid([0.0; 3], [1.0; 3], [4, 3, 1]).expect("mesh");
        let upper = cuboid([0.15, 0.1, 1.02], [0.83, 0.9, 1.5], [2, 3, 1]).expect("mesh");
        let [mut lower, upper] = [lower, upper].map(|mesh| match order {
            Order::Linear => mesh,
            Order::Quadratic => mesh.quadratic(),
        });
        // waves, so that facets and normals are inclined
        lower = lower
            .mapped(|x| [x[0], x[1], x[2] + 0.02 * (7.0 * x[0] + 5.0 * x[1]).sin()].into())
            .expect("mesh");
        differences([&upper, &lower], ["bottom", "top"]);
    }
}

fn differences<const D: usize>(meshes: [&Mesh<D>; 2], sides: [&str; 2]) {
    let own = Faces::new(meshes[0], (0, 0), sides[0]).expect("named");
    let first = meshes[0].nodes().len();
    let other = Faces::new(meshes[1], (1, first), sides[1]).expect("named");
    let nodes = meshes.map(Mesh::nodes).into_iter().flatten();
    let x: Vec<Vector<D>> = nodes.copied().collect();
    let master = Placed::new(&other, &x);
    let search = Search {
        x: &x,
        reach: Reach {
            radius: 1.0,
            size: other.size(),
            fit: 0.0,
        },
        places: &Places::pieces(&own, &other),
        is_one_body: false,
        has_force: &vec![true; own.nodes.len()],
    };
    let pass = Pass::new(&own, &master, &search);
    let lambda: Vec<f64> = (0..own.nodes.len()).map(|i| 1.0 + (i % 3) as f64).collect();
    let pushes = pass.pushes(&lambda);
    let wave = |k: usize, i: usize| (1.0 + 12.9 * k as f64 + 78.2 * i as f64).sin();
    let v: Vec<Vector<D>> = (0..x.len())
        .map(|k| Vector::from_fn(|i, _| wave(k, i)))
        .collect();
    let mut slopes = vec![Vector::<D>::zeros(); x.len()];
    pass.slopes_of_forces(&pass.loaded(&pushes, &x), |nodes, own| {
        let motion = nodes.iter().flat_map(|&a| v[a].iter().copied());
        let rates = own * DVector::from_iterator(D * nodes.len(), motion);
        for (k, &a) in nodes.iter().enumerate() {
            slopes[a] += rates.fixed_rows::<D>(D * k);
        }
    });
    const STEP: f64 = 1e-6;
    for sign in [1.0, -1.0] {
        let moved = x.iter().zip(&v).map(|(x, v)| x + v * (sign * STEP));
        let moved: Vec<Vector<D>> = moved.collect();
        let there = Placed::unsorted(&other, &moved, |_| true);
        let slave: Vec<Vector<D>> = own.nodes.iter().map(|&a| moved[a]).collect();
        let mut after = Pass::new(&own, &master, &search);
        for point in &mut after.held {
            let place = own.patch(point.facet, &slave).at(&point.lambda);
            let patches = there.patches(point.foot.facet);
            let start = (&point.foot.lambda, point.foot.gap);
            let found = feet::solve(&patches, &place, start).expect("a foot");
            point.foot = feet::at(point.foot.facet, &patches, found);
        }
        let opposite = pushes.iter().map(|push| -sign * push / (2.0 * STEP));
        after.add_forces(&opposite.collect::<Vec<f64>>(), &mut slopes);
    }
    let largest = pushes.iter().map(|push| push.abs()).fold(0.0, f64::max);
    let size = own.size().min(other.size());
    for (node, rest) in slopes.iter().enumerate() {
        assert!(rest.norm() * size < 1e-4 * largest, "{node}: {rest}");
    }
}

/// A straight column between clamps: below Euler's load, no motion releases energy, and beyond it, the softest bow as much as Euler's beam.
#[test]
fn a_straight_column_releases_energy() {
    const HEIGHT: f64 = 10.0;
    const WIDTH: f64 = 0.4;
    const YOUNG: f64 = 1e3;
    use std::f64::consts::PI;
    let stiffness = YOUNG * WIDTH.powi(3) / 12.0;
    let euler = 4.0 * PI * PI * stiffness / HEIGHT.powi(2);
    let block = |x: [f64; 2], y: [f64; 2], cells: [usize; 2]| {
        let lines = [(x, cells[0]), (y, cells[1])].map(|([a, b], n)| linspace(a, b, n));
        let mesh = rectangle(&lines[0], &lines[1], Diagonals::Alternating);
        mesh.expect("mesh").quadratic()
    };
    let law = || crate::NeoHookean::new(YOUNG, 0.0).expect("a law");
    for times in [0.9, 1.5, 2.5] {
        let push = times * euler * HEIGHT / (YOUNG * WIDTH);
        let mesh = block([-0.5 * WIDTH, 0.5 * WIDTH], [0.0, HEIGHT], [2, 24]);
        let mut column = Body::new(mesh, law());
        column.prescribe("bottom", [Some(0.0); 2]).expect("a side");
        let top = [Some(0.0), Some(-push)];
        column.prescribe("top", top).expect("a side");
        let mut wall = Body::new(block([2.0, 3.0], [2.0, 8.0], [1, 4]), law());
        wall.prescribe("right", [Some(0.0); 2]).expect("a side");
        let mut scene = Scene::new();
        let (column, wall) = (scene.add("column", column), scene.add("wall", wall));
        let pair = (column.on("right"), wall.on("left"));
        scene.contact(pair.0, pair.1).expect("a pair");
        let mut problem = scene.problem().expect("a problem");
        let begun = contact_core::Phase::new("begun", 1e-3, 1);
        let history = Simulation::in_phases([begun])
            .run(&mut problem)
            .expect("a run");
        let mut solution = history.run.solution.expect("a step");
        // the same straight column at the whole load
        contact_core::LoadStepped::set_load(&mut problem, 1.0).expect("a load");
        for node in problem.nodes(0) {
            for i in 0..2 {
                let X = problem.reference()[node];
                if let Dof::Free(k) = problem.dofs().get(2 * node + i) {
                    solution.state.u[k] = [0.0, -push * X[1] / HEIGHT][i];
                }
            }
        }
        let certificate = crate::Certificate::new(&problem, &solution);
        let found = certificate.left(Condition::Inertia).expect("known");
        // w = Σ a_k (1 − cos 2πk y/h): the smallest of ∫ EI w''² − P w'² over ∫ w² times the sum 2 P of both reactions over h²
        let wave = |k: usize| 2.0 * PI * k as f64 / HEIGHT;
        let curvature = nalgebra::Matrix4::from_fn(|i, j| match i == j {
            true => {
                let wave = wave(i + 1);
                0.5 * HEIGHT * (stiffness * wave.powi(4) - times * euler * wave.powi(2))
            }
            false => 0.0,
        });
        let unit = nalgebra::Matrix4::from_fn(|i, j| match i == j {
            true => 3.0 * times * euler / HEIGHT,
            false => 2.0 * times * euler / HEIGHT,
        });
        let factor = unit.cholesky().expect("positive").l();
        let inverse = factor.try_inverse().expect("positive");
        let shares = (inverse * curvature * inverse.transpose()).symmetric_eigenvalues();
        let euler = (-shares.min()).max(0.0);
        assert!(
            (found - euler).abs() <= 0.06 * euler,
            "{times}: {found} {euler}"
        );
        let limit = crate::certificate::Limits::default().of(Condition::Inertia);
        assert_eq!(found > limit, times > 1.0, "{certificate}");
    }
}

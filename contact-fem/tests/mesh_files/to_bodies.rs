//! Which bodies and boundaries come of what files hold.

use contact_fem::element::Order;
use contact_fem::mesh::read::Problem;
use contact_fem::{Error, Mesh, MeshFile};

/// A plane MSH 2.2 file of a unit square: nodes 10 to 40 at its corners, counter-clockwise, 50 in
/// its middle; elements as type, group and nodes.
fn square(elements: &[(u8, i32, &str)]) -> String {
    let mut text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n\
        1 1 \"rim\"\n1 2 \"rim\"\n2 8 \"all\"\n$EndPhysicalNames\n\
        $Nodes\n6\n40 0 1 0\n10 0 0 0\n20 1 0 0\n30 1 1 0\n99 7 7 7\n50 0.5 0.5 0\n$EndNodes\n"
        .to_string();
    text += &format!("$Elements\n{}\n", elements.len());
    for (k, (kind, group, nodes)) in elements.iter().enumerate() {
        text += &format!("{} {kind} 2 {group} 1 {nodes}\n", k + 1);
    }
    text + "$EndElements\n"
}

const LOWER: (u8, i32, &str) = (2, 5, "10 20 50");
const RIGHT: (u8, i32, &str) = (2, 5, "20 30 50");
const UPPER: (u8, i32, &str) = (2, 6, "30 50 40"); // clockwise
const LEFT: (u8, i32, &str) = (2, 6, "10 50 40");

fn bodies(elements: &[(u8, i32, &str)]) -> Result<Vec<(String, Mesh<2>)>, Problem> {
    let file = MeshFile::parse(square(elements).as_bytes()).expect("a mesh file");
    file.bodies::<2>().map_err(problem)
}

fn problem(error: Error) -> Problem {
    match error {
        Error::MeshFile { problem, .. } => problem,
        other => panic!("{other}"),
    }
}

fn names<const D: usize>(mesh: &Mesh<D>) -> Vec<&str> {
    mesh.boundary_names().collect()
}

fn area(mesh: &Mesh<2>) -> f64 {
    (0..mesh.len()).map(|k| mesh.volume(k)).sum()
}

#[test]
fn bodies_ascend_by_number_and_have_their_vertices_only() {
    let bodies = bodies(&[UPPER, LEFT, LOWER, RIGHT]).expect("bodies");
    assert_eq!((bodies[0].0.as_str(), bodies[1].0.as_str()), ("5", "6"));
    for (_, mesh) in &bodies {
        assert_eq!((mesh.len(), mesh.nodes().len()), (2, 4));
        assert_eq!(area(mesh), 0.5);
    }
}

#[test]
fn cells_without_groups_are_one_body() {
    let free = [LOWER, RIGHT, UPPER, LEFT].map(|(kind, _, nodes)| (kind, 0, nodes));
    let bodies = bodies(&free).expect("bodies");
    assert_eq!((bodies.len(), bodies[0].0.as_str()), (1, "body"));
    assert_eq!(area(&bodies[0].1), 1.0);
    assert_eq!(bodies[0].1.exterior().len(), 4);
}

#[test]
fn facets_between_bodies_bound_both() {
    let diagonal = (1, 4, "50 10");
    let bodies = bodies(&[LOWER, RIGHT, UPPER, LEFT, (1, 3, "30 50"), diagonal]).expect("bodies");
    assert_eq!(names(&bodies[0].1), ["3", "4"]);
    assert_eq!(names(&bodies[1].1), ["3", "4"]);
}

#[test]
fn facets_inside_a_body_are_named() {
    let edge = (1, 3, "50 20");
    let bodies = bodies(&[LOWER, RIGHT, UPPER, LEFT, edge]).expect("bodies");
    let (lower, upper) = (&bodies[0].1, &bodies[1].1);
    let inner: Vec<_> = lower.inner_facets().collect();
    let &[(name, &[facet])] = &inner[..] else {
        panic!("{inner:?}");
    };
    let mut ends = facet.map(|a| <[f64; 2]>::from(lower.nodes()[a]));
    ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
    assert_eq!((name, ends), ("3", [[0.5, 0.5], [1.0, 0.0]]));
    assert!(lower.boundary("3").is_err());
    assert_eq!(upper.inner_facets().count(), 0);
}

#[test]
fn facets_of_no_cell_are_refused() {
    let error = bodies(&[LOWER, RIGHT, UPPER, LEFT, (1, 3, "10 30")]).expect_err("no edge");
    let Problem::LooseFacet {
        vertices,
        at,
        boundary,
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!((&*vertices, at), (&[1, 3][..], [0.5, 0.5, 0.0]));
    assert_eq!(boundary, "3");
}

#[test]
fn facets_of_others_are_left_out_of_bodies_taken_alone() {
    let edges = [(1, 3, "50 40"), (1, 1, "10 20")];
    let text = square(&[&[LOWER, RIGHT, UPPER, LEFT], &edges[..]].concat());
    let file = MeshFile::parse(text.as_bytes()).expect("a mesh file");
    assert_eq!(names(&file.body::<2>("5").expect("a body")), ["rim"]);
    assert!(names(&file.body::<2>("6").expect("a body")).is_empty());
    let error = problem(file.body::<2>("7").expect_err("no such body"));
    assert!(matches!(error, Problem::UnknownBody { known, .. } if known == ["5", "6"]));
    let error = problem(file.body::<2>("rim").expect_err("no body"));
    assert!(matches!(error, Problem::UnknownBody { .. }));
}

#[test]
fn groups_of_one_name_are_one_and_repeated_facets_count_once() {
    let edges = [
        (1, 1, "10 20"),
        (1, 2, "20 30"),
        (1, 2, "30 20"),
        (1, 1, "20 30"),
    ];
    let bodies = bodies(&[&[LOWER, RIGHT], &edges[..]].concat()).expect("bodies");
    assert_eq!(names(&bodies[0].1), ["rim"]);
    let rim = bodies[0].1.boundary("rim").expect("named");
    assert_eq!(rim.len(), 2);
}

#[test]
fn label_0_may_lie_anywhere() {
    let medit = |label: i32| {
        let text = format!(
            "MeshVersionFormatted 1 Dimension 2 Vertices 4 0 0 0 1 0 0 1 1 0 0 1 0 \
             Edges 3 1 3 {label} 1 2 {label} 4 2 {label} Triangles 2 1 2 3 0 1 3 4 0 End"
        );
        let file = MeshFile::parse(text.as_bytes()).expect("a mesh file");
        file.bodies::<2>().map_err(problem)
    };
    let bodies = medit(0).expect("bodies");
    assert_eq!(
        (bodies[0].0.as_str(), names(&bodies[0].1)),
        ("0", vec!["0"])
    );
    assert_eq!(bodies[0].1.boundary("0").expect("named"), [[0, 1]]);
    assert_eq!(bodies[0].1.inner_facets().count(), 0);
    let error = medit(2).expect_err("an edge of no cell");
    assert!(matches!(error, Problem::LooseFacet { .. }), "{error}");
}

#[test]
fn bodies_that_share_cells_come_one_at_a_time() {
    let all = [LOWER, RIGHT, UPPER, LEFT].map(|(kind, _, nodes)| (kind, 8, nodes));
    let elements = [&[LOWER, RIGHT, UPPER, LEFT], &all[..]].concat();
    let error = bodies(&elements).expect_err("shared");
    assert!(
        matches!(&error, Problem::SharedCell { first, second, .. }
            if (first.as_str(), second.as_str()) == ("5", "all")),
        "{error}"
    );
    let file = MeshFile::parse(square(&elements).as_bytes()).expect("a mesh file");
    assert_eq!(area(&file.body::<2>("all").expect("a body")), 1.0);
    assert_eq!(area(&file.body::<2>("5").expect("a body")), 0.5);
}

#[test]
fn cells_that_make_no_body_are_refused() {
    let error = bodies(&[LOWER, RIGHT, (2, 5, "50 10 20")]).expect_err("a cell twice");
    assert!(matches!(error, Problem::RepeatedCell { .. }), "{error}");
    let error = bodies(&[LOWER, (2, 0, "20 30 50")]).expect_err("a cell in no group");
    assert!(matches!(error, Problem::Ungrouped { cells: 1 }), "{error}");
    let error = bodies(&[LOWER, (2, 5, "10 30 50")]).expect_err("no area");
    assert!(
        matches!(&error, Problem::Body { body, source } if body == "5"
            && matches!(**source, Error::DegenerateCell { cell: 1, .. })),
        "{error}"
    );
    let error = bodies(&[LOWER, (2, 5, "20 20 30")]).expect_err("a node twice");
    assert!(matches!(error, Problem::Body { .. }), "{error}");
    let error = bodies(&[LOWER, RIGHT, (2, 5, "20 40 50")]).expect_err("three cells at an edge");
    assert!(
        matches!(&error, Problem::Body { source, .. }
            if matches!(&**source, Error::NonManifoldFacet { nodes, cells: 3 } if *nodes == [2, 5])),
        "{error}"
    );
    let error = bodies(&[LOWER, (2, 5, "20 30 99")]).expect_err("not plane");
    let expected = |vertex, z| (vertex, z) == (4, 7.0);
    assert!(
        matches!(error, Problem::NotPlane { vertex, z, plane: 0.0 } if expected(vertex, z)),
        "{error}"
    );
}

#[test]
fn dimensions_have_to_agree() {
    let plane = MeshFile::parse(square(&[LOWER]).as_bytes()).expect("a mesh file");
    let error = problem(plane.bodies::<3>().expect_err("plane"));
    assert!(matches!(error, Problem::Dimension { asked: 3, found: 2 }));
    let mixed = square(&[(2, 5, "10 20 30"), (4, 5, "10 20 30 99")]);
    let mixed = MeshFile::parse(mixed.as_bytes()).expect("a mesh file");
    let error = problem(mixed.bodies::<2>().expect_err("a tetrahedron"));
    assert!(matches!(error, Problem::Dimension { asked: 2, found: 3 }));
    let bodies = mixed.bodies::<3>().expect("a body");
    assert_eq!((bodies[0].1.len(), bodies[0].0.as_str()), (1, "5"));
    assert_eq!(names(&bodies[0].1), ["5"]);
}

/// The same bricks with straight cells of order 1 and 2: volumes and boundaries agree, and the
/// quadratic boundaries have the nodes in the middle of their edges as well.
#[test]
fn cells_of_order_2_make_quadratic_meshes() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/meshes/");
    for format in ["v41.msh", "v22.msh", "v41.bin.msh", "v22.bin.msh", "mesh"] {
        let bodies = |order: u32| {
            let file = MeshFile::read(format!("{folder}bricks.{order}.{format}"));
            file.and_then(|file| file.bodies::<3>()).expect("bodies")
        };
        let (linear, quadratic) = (bodies(1), bodies(2));
        assert_eq!(linear.len(), quadratic.len());
        for ((name, coarse), (other, fine)) in linear.iter().zip(&quadratic) {
            assert_eq!((name, fine.order()), (other, Order::Quadratic));
            let volume = |mesh: &Mesh<3>| (0..mesh.len()).map(|k| mesh.volume(k)).sum::<f64>();
            assert!((volume(coarse) / volume(fine) - 1.0).abs() < 1e-12);
            assert_eq!(names(coarse), names(fine));
            for boundary in fine.boundary_names() {
                for facet in fine.boundary(boundary).expect("named") {
                    let x: Vec<_> = facet.iter().map(|&a| fine.nodes()[a]).collect();
                    for (middle, [a, b]) in x[3..].iter().zip([[0, 1], [1, 2], [2, 0]]) {
                        assert!((middle - (x[a] + x[b]) * 0.5).norm() < 1e-9);
                    }
                }
            }
        }
    }
}

#[test]
fn a_body_has_cells_of_one_order() {
    let quadratic = (9, 5, "20 40 50 30 10 10");
    let error = bodies(&[LOWER, quadratic]).expect_err("two orders");
    assert!(matches!(error, Problem::CellOrder { .. }), "{error}");
    assert!(error.to_string().contains("6-node triangle"), "{error}");
}

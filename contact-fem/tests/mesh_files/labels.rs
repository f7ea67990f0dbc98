//! Labels and regions are kept from file to file, whichever whole numbers they are.

use std::collections::BTreeMap;

use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::mesh::write::{boundary_labels, to_freefem};
use contact_fem::tensor::facet_normal;
use contact_fem::{Error, Mesh, MeshFile};

use crate::support;

fn read<const D: usize>(name: &str) -> Vec<Mesh<D>> {
    let file = MeshFile::read(support::folder().join(name));
    bodies(&file.unwrap_or_else(|error| panic!("{error}")))
}

fn bodies<const D: usize>(file: &MeshFile) -> Vec<Mesh<D>> {
    let bodies = file.bodies::<D>().unwrap_or_else(|error| panic!("{error}"));
    bodies.into_iter().map(|(_, mesh)| mesh).collect()
}

fn written<const D: usize>(bodies: &[Mesh<D>]) -> MeshFile {
    let bodies: Vec<&Mesh<D>> = bodies.iter().collect();
    let text = to_freefem(&bodies).unwrap_or_else(|error| panic!("{error}"));
    MeshFile::parse(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

/// Areas or volumes of regions, and lengths or areas of labels, from the elements that a file lists.
type Measures = (BTreeMap<i64, f64>, BTreeMap<i64, f64>);

fn measures<const D: usize>(file: &MeshFile) -> Measures {
    let (mut regions, mut labels) = Measures::default();
    let x = |v: usize| contact_fem::tensor::Vector::<D>::from_fn(|i, _| file.vertices()[v][i]);
    for elements in file.elements() {
        let label = file.groups()[elements.groups[0]].number;
        for nodes in elements.iter() {
            let area = facet_normal::<D>(&std::array::from_fn(|k| x(nodes[k])));
            if elements.kind.dimension() < D {
                *labels.entry(label).or_default() += area.norm();
            } else {
                // a third or half of base times height
                let height = area.dot(&(x(nodes[D]) - x(nodes[0])));
                *regions.entry(label).or_default() += height.abs() / D as f64;
            }
        }
    }
    (regions, labels)
}

fn check(found: &BTreeMap<i64, f64>, expected: &[(i64, f64)]) {
    let numbers = expected.iter().map(|(number, _)| number);
    assert!(found.keys().eq(numbers), "{found:?}");
    for (number, size) in expected {
        assert!((found[number] - size).abs() < 1e-12, "{number}: {found:?}");
    }
}

/// The same cells, boundaries and inner facets under the same names, all at the same places to the last bit.
fn same<const D: usize>(first: &Mesh<D>, second: &Mesh<D>) {
    assert_eq!(first.region(), second.region());
    assert_eq!(first.nodes().len(), second.nodes().len());
    let places = |mesh: &Mesh<D>, nodes: &[usize]| -> Vec<_> {
        nodes.iter().map(|&a| mesh.nodes()[a]).collect()
    };
    assert_eq!(first.len(), second.len());
    for (a, b) in first.cells().zip(second.cells()) {
        assert_eq!(places(first, a), places(second, b));
    }
    assert!(first.boundary_names().eq(second.boundary_names()));
    for name in first.boundary_names() {
        let facets = |mesh: &Mesh<D>| -> Vec<_> {
            let facets = mesh.boundary(name).expect("named").into_iter();
            facets.map(|facet| places(mesh, facet)).collect()
        };
        assert_eq!(facets(first), facets(second), "{name}");
    }
    let inner = |mesh: &Mesh<D>| -> Vec<(String, Vec<_>)> {
        let inner = mesh.inner_facets();
        let places = |facets: &[[usize; D]]| facets.iter().map(|f| places(mesh, f)).collect();
        inner
            .map(|(n, facets)| (n.into(), places(facets)))
            .collect()
    };
    assert_eq!(inner(first), inner(second));
    assert!(first.boundary_labels().eq(second.boundary_labels()));
}

fn comes_back<const D: usize>(name: &str) -> MeshFile {
    let bodies = read::<D>(name);
    let file = written(&bodies);
    let again = self::bodies::<D>(&file);
    assert_eq!(bodies.len(), again.len());
    bodies.iter().zip(&again).for_each(|(a, b)| same(a, b));
    for mesh in bodies {
        let alone = &self::bodies::<D>(&written(std::slice::from_ref(&mesh)))[0];
        same(&mesh, alone);
        assert_eq!(mesh.nodes(), alone.nodes());
    }
    file
}

/// The rectangle of `labels.edp`; its bodies share vertices and the line between them.
#[test]
fn any_label_and_region_comes_back_in_the_plane() {
    let names: Vec<Vec<(String, i32)>> = read::<2>("labels.msh")
        .iter()
        .map(|mesh| mesh.boundary_labels().map(|(n, l)| (n.into(), l)).collect())
        .collect();
    let expected = |labels: &[i32]| labels.iter().map(|&l| (l.to_string(), l)).collect();
    let right: Vec<_> = expected(&[10, 2, 20, 3]);
    let left: Vec<_> = expected(&[-1, 0, 2, 20, 3, 5]);
    assert_eq!(names, [right, left]);
    let (regions, labels) = measures::<2>(&comes_back::<2>("labels.msh"));
    check(&regions, &[(1, 1.0), (7, 1.0)]);
    let expected = [
        (-1, 0.5),
        (0, 0.5),
        (2, 1.0),
        (3, 2.0),
        (5, 1.0),
        (10, 1.0),
        (20, 2.0),
    ];
    check(&labels, &expected);
}

/// Facets between the bodies have no label there, and get none, as 0 is one.
#[test]
fn any_label_and_region_comes_back_in_space() {
    let (regions, labels) = measures::<3>(&comes_back::<3>("labels_3d.mesh"));
    check(&regions, &[(1, 1.5), (7, 1.5)]);
    let expected = [
        (-1, 1.5),
        (0, 2.0),
        (2, 2.0),
        (3, 3.0),
        (10, 1.5),
        (20, 3.0),
    ];
    check(&labels, &expected);
}

#[test]
fn groups_of_gmsh_keep_their_numbers() {
    let bodies = read::<2>("blocks.1.v41.msh");
    let regions: Vec<Option<i32>> = bodies.iter().map(Mesh::region).collect();
    assert_eq!(regions, [Some(1), Some(2)]);
    let groups = MeshFile::read(support::folder().join("blocks.1.v41.msh")).expect("a file");
    let mut count = 0;
    for (name, label) in bodies.iter().flat_map(|mesh| mesh.boundary_labels()) {
        let mut groups = groups.groups().iter();
        let group = groups.find(|group| group.dimension == 1 && group.name == name);
        assert_eq!(group.map(|g| g.number), Some(label.into()), "{name}");
        count += 1;
    }
    assert_eq!(count, 7);
}

#[test]
fn names_without_a_label_get_none_in_use() {
    let sides = linspace(0.0, 1.0, 2);
    let mut mesh = square(0.0, "-7", "007");
    mesh.name_boundary("2", |x| x[0] == 1.0);
    mesh.name_boundary("bottom", |_| false);
    mesh.name_boundary("3000000000", |x| x[0] == 0.0);
    let labels: Vec<(&str, i32)> = mesh.boundary_labels().collect();
    let expected = [
        ("-7", -7),
        ("007", 1),
        ("2", 2),
        ("3000000000", 3),
        ("bottom", 4),
    ];
    assert_eq!(labels, expected);
    let other = rectangle(&sides, &sides, Diagonals::Rising).expect("a square");
    let both = boundary_labels(&[&mesh, &other]);
    assert_eq!(both[0]["bottom"], both[1]["bottom"]);
    assert_eq!((both[0]["bottom"], both[1]["left"]), (4, 5));
    let other = other.translated([0.0, 5.0]).expect("moved");
    let regions: Vec<i32> = bodies::<2>(&written(&[mesh, other]))
        .iter()
        .filter_map(Mesh::region)
        .collect();
    assert_eq!(regions, [1, 2]);
}

/// A square of two triangles, its lower left corner at (0, y), with `below` and `above`.
fn square(y: f64, below: &str, above: &str) -> Mesh<2> {
    let nodes = vec![[0.0, y], [1.0, y], [1.0, y + 1.0], [0.0, y + 1.0]];
    let mut mesh = Mesh::new(nodes, vec![0, 1, 2, 0, 2, 3]).expect("a square");
    for (name, y) in [(below, y), (above, y + 1.0)] {
        if !name.is_empty() {
            mesh.name_boundary(name, |x| x[1] == y);
        }
    }
    mesh
}

#[test]
fn bodies_in_one_file_share_vertices_and_facets() {
    let text =
        |above: &str, below: &str| to_freefem(&[&square(0.0, "", above), &square(1.0, below, "")]);
    for (above, below, edges) in [("4", "4", 7), ("4", "", 7), ("", "4", 7), ("", "", 6)] {
        let text = text(above, below).expect("one name a facet");
        assert!(text.starts_with(&format!("6 4 {edges}\n")), "{text}");
        let has_label = text.contains("\n3 4 4\n") || text.contains("\n4 3 4\n");
        assert_eq!(has_label, edges == 7, "{text}");
    }
    let error = text("4", "5").expect_err("two names");
    let expected = |first: &str, second: &str| (first, second) == ("4", "5");
    assert!(
        matches!(&error, Error::SharedFacet { first, second, .. } if expected(first, second)),
        "{error}"
    );
}

#[test]
fn bodies_without_a_region_get_none_in_use() {
    let sides = linspace(0.0, 1.0, 2);
    let mut bodies = read::<2>("labels.msh");
    let new = rectangle(&sides, &sides, Diagonals::Rising).expect("a square");
    bodies.insert(0, new.translated([0.0, 5.0]).expect("moved"));
    let (regions, _) = measures::<2>(&written(&bodies));
    check(&regions, &[(1, 1.0), (2, 1.0), (7, 1.0)]);
    assert!(matches!(to_freefem::<2>(&[]), Err(Error::EmptyMesh)));
}

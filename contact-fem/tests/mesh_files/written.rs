//! Meshes written for FreeFEM come back as they were.

use contact_fem::mesh::generators::{
    Diagonals, annulus, cuboid, disc, linspace, onto_sphere, sphere,
};
use contact_fem::mesh::read::Format;
use contact_fem::{Error, Mesh, MeshFile};

fn read_back<const D: usize>(mesh: &Mesh<D>, format: Format) -> Mesh<D> {
    let text = mesh.to_freefem().expect("one name a facet");
    let file = MeshFile::parse(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(file.format(), format);
    let mut bodies = file.bodies::<D>().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(bodies.len(), 1);
    bodies.remove(0).1
}

/// The same nodes to the last bit, the same cells, and the same facets under labels for names.
fn comes_back<const D: usize>(mesh: &Mesh<D>, format: Format) {
    let read = read_back(mesh, format);
    assert_eq!(read.nodes(), mesh.nodes());
    assert!(read.cells().eq(mesh.cells()));
    assert!(read.exterior().eq(mesh.exterior()));
    for (name, label) in mesh.boundary_labels() {
        let facets = mesh.boundary(name).expect("named");
        assert!(!facets.is_empty(), "{name}");
        let label = label.to_string();
        assert_eq!(read.boundary(&label).expect("labelled"), facets, "{name}");
    }
}

#[test]
fn plane_meshes_come_back() {
    let ring = annulus(&linspace(0.7, 2.0, 4), 17, Diagonals::Alternating).expect("a ring");
    comes_back(&ring, Format::FreeFem);
    let turned = disc(0.6, 13, 3, 0.03).expect("a disc");
    comes_back(&turned, Format::FreeFem);
    let far = turned.translated([1e7 / 3.0, -1e-9]).expect("moved");
    comes_back(&far, Format::FreeFem);
}

#[test]
fn meshes_in_space_come_back() {
    let block = cuboid([0.1, 0.0, -1.0], [3.0, 1.0, 1.0 / 7.0], [5, 2, 3]).expect("a block");
    comes_back(&block, Format::Medit);
    comes_back(&sphere(2.0, 3).expect("a ball"), Format::Medit);
}

#[test]
fn of_quadratic_meshes_the_corners_are_written() {
    let linear = disc(2.0, 12, 3, 0.0).expect("a disc");
    let curved = linear.clone().quadratic();
    let curved = curved.curved("boundary", onto_sphere(2.0)).expect("curved");
    assert_eq!(
        curved.to_freefem().expect("named"),
        linear.to_freefem().expect("named")
    );
    comes_back(&linear, Format::FreeFem);
    let linear = cuboid([0.0; 3], [1.0; 3], [2, 3, 1]).expect("a cube");
    let quadratic = linear.clone().quadratic();
    assert_eq!(
        quadratic.to_freefem().expect("named"),
        linear.to_freefem().expect("named")
    );
}

#[test]
fn corners_that_are_not_the_first_nodes_are_numbered_anew() {
    // one quadratic triangle whose corners are the last nodes
    let nodes = vec![
        [0.5, 0.0],
        [0.5, 0.5],
        [0.0, 0.5],
        [0.0, 0.0],
        [1.0, 0.0],
        [0.0, 1.0],
    ];
    let order = contact_fem::element::Order::Quadratic;
    let mesh = Mesh::<2>::of_order(order, nodes, vec![3, 4, 5, 0, 1, 2]).expect("a triangle");
    let read = read_back(&mesh, Format::FreeFem);
    assert_eq!(read.nodes(), &mesh.nodes()[3..]);
    assert_eq!(read.cell(0), [0, 1, 2]);
}

#[test]
fn a_facet_on_two_boundaries_is_refused() {
    let mut mesh = cuboid([0.0; 3], [1.0; 3], [1; 3]).expect("a cube");
    mesh.name_boundary("glued", |x| x[2] == 0.0);
    let error = mesh.to_freefem().expect_err("two names");
    assert!(matches!(error, Error::SharedFacet { .. }));
    let message = error.to_string();
    assert!(
        message.contains("`bottom`") && message.contains("`glued`"),
        "{message}"
    );
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let mesh = disc(1.0, 8, 1, 0.0).expect("a disc");
    let error = mesh.save_freefem("no such folder/disc.msh");
    let error = error.expect_err("no folder");
    assert!(matches!(error, Error::Write { .. }));
    assert!(error.to_string().contains("no such folder"), "{error}");
}

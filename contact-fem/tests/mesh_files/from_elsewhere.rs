//! Meshes that Gmsh and FreeFEM made, against the geometry they were made of, and surfaces by hand.

use std::collections::BTreeMap;

use contact_fem::mesh::read::{ElementKind, Format};
use contact_fem::tensor::facet_normal;
use contact_fem::{Mesh, MeshFile, Obstacle};

use crate::support;

fn read(name: &str) -> MeshFile {
    MeshFile::read(support::folder().join(name)).unwrap_or_else(|error| panic!("{error}"))
}

/// The body's area or volume, and the length or area of each boundary.
fn measures<const D: usize>(mesh: &Mesh<D>) -> (f64, Vec<(&str, f64)>) {
    let volume = (0..mesh.len()).map(|k| mesh.volume(k)).sum();
    let corners = |facet: &[usize]| std::array::from_fn(|k| mesh.nodes()[facet[k]]);
    let of_facet = |facet: &&[usize]| facet_normal::<D>(&corners(facet)).norm();
    let of = |name| -> f64 {
        let facets = mesh.boundary(name).expect("named");
        facets.iter().map(of_facet).sum()
    };
    (volume, mesh.boundary_names().map(|n| (n, of(n))).collect())
}

/// Bodies by name with their measures and those of their boundaries.
type Expected<'a> = &'a [(&'a str, f64, &'a [(&'a str, f64)])];

fn check<const D: usize>(what: &str, file: &MeshFile, expected: Expected) {
    let bodies = file.bodies::<D>().unwrap_or_else(|e| panic!("{what}: {e}"));
    assert_eq!(bodies.len(), expected.len(), "{what}");
    let close = |a: f64, b: f64| (a - b).abs() < 1e-9;
    for ((name, mesh), (expected, volume, boundaries)) in bodies.iter().zip(expected) {
        let measured = measures(mesh);
        assert_eq!(name, expected, "{what}");
        assert!(close(measured.0, *volume), "{what}: {name} {measured:?}");
        assert_eq!(measured.1.len(), boundaries.len(), "{what}: {measured:?}");
        for (found, expected) in measured.1.iter().zip(*boundaries) {
            let same = found.0 == expected.0 && close(found.1, expected.1);
            assert!(same, "{what}: {name} {found:?}");
        }
        let alone = file.body::<D>(name).expect("a body");
        assert_eq!(measures(&alone), measured, "{what}");
    }
}

const BLOCKS: Expected = &[
    (
        "lower",
        2.0,
        &[
            ("42", 1.0),
            ("bottom", 2.0),
            ("interface", 2.0),
            ("support", 3.0),
        ],
    ),
    (
        "upper part",
        1.0,
        &[("42", 0.5), ("interface", 2.0), ("top", 2.0)],
    ),
];

const BRICKS: Expected = &[
    (
        "base",
        2.0,
        &[("bottom", 2.0), ("front", 1.0), ("interface", 2.0)],
    ),
    (
        "block",
        1.0,
        &[("front", 0.5), ("interface", 2.0), ("top", 2.0)],
    ),
];

const VERSIONS: [(&str, Format); 4] = [
    ("v41", Format::Gmsh41),
    ("v41.bin", Format::Gmsh41),
    ("v22", Format::Gmsh22),
    ("v22.bin", Format::Gmsh22),
];

#[test]
fn physical_groups_of_gmsh_are_bodies_and_boundaries() {
    for (version, format) in VERSIONS {
        let blocks = read(&format!("blocks.1.{version}.msh"));
        assert_eq!(blocks.format(), format);
        check::<2>(version, &blocks, BLOCKS);
        let bricks = read(&format!("bricks.1.{version}.msh"));
        assert_eq!(bricks.format(), format);
        check::<3>(version, &bricks, BRICKS);
        let named = |name| {
            let groups = [blocks.groups(), bricks.groups()].concat();
            let group = groups.into_iter().find(|group| group.name == name);
            group.map(|group| (group.dimension, group.number))
        };
        assert_eq!(named("upper part"), Some((2, 2)));
        assert_eq!(named("42"), Some((1, 42)));
        assert_eq!(named("corner"), Some((0, 43)));
        assert_eq!(named("block"), Some((3, 9)));
    }
}

#[test]
fn parameters_of_nodes_are_passed_over() {
    for name in ["v41.msh", "v22.msh", "v22.bin.msh"] {
        check::<2>(name, &read(&format!("parametric.{name}")), BLOCKS);
    }
    let binary = read("parametric.v41.bin.msh");
    check::<3>("v41.bin", &binary, BRICKS);
}

#[test]
fn what_is_saved_without_a_group_is_no_boundary() {
    check::<2>("saved_all", &read("saved_all.v41.msh"), BLOCKS);
}

#[test]
fn labels_of_medit_files_are_bodies_and_boundaries() {
    let expected: Expected = &[
        ("1", 2.0, &[("1", 2.0), ("2", 1.0), ("3", 2.0), ("4", 1.0)]),
        ("2", 1.0, &[("3", 2.0), ("5", 0.5), ("6", 2.0)]),
    ];
    let file = read("blocks.1.mesh");
    assert_eq!(file.format(), Format::Medit);
    check::<2>("blocks", &file, expected);
    let expected: Expected = &[
        ("1", 2.0, &[("1", 2.0), ("13", 1.0), ("26", 2.0)]),
        ("2", 1.0, &[("26", 2.0), ("35", 0.5), ("48", 2.0)]),
    ];
    check::<3>("bricks", &read("bricks.1.mesh"), expected);
}

#[test]
fn regions_and_labels_of_freefem_are_bodies_and_boundaries() {
    let expected: Expected = &[
        ("0", 1.0, &[("3", 2.0), ("4", 1.0), ("5", 2.0)]),
        ("3", 2.0, &[("1", 2.0), ("2", 2.0), ("3", 2.0)]),
    ];
    for (name, format) in [
        ("freefem.msh", Format::FreeFem),
        ("freefem.mesh", Format::Medit),
    ] {
        let file = read(name);
        assert_eq!(file.format(), format);
        check::<2>(name, &file, expected);
    }
    let lower: &[(&str, f64)] = &[("1", 1.0), ("2", 2.0), ("3", 1.0), ("4", 2.0), ("5", 2.0)];
    let upper: &[(&str, f64)] = &[("1", 0.5), ("2", 1.0), ("3", 0.5), ("4", 1.0), ("6", 2.0)];
    let expected: Expected = &[("7", 2.0, lower), ("9", 1.0, upper)];
    for name in ["freefem_3d.mesh", "freefem_3d.meshb"] {
        let file = read(name);
        assert_eq!(file.format(), Format::Medit);
        check::<3>(name, &file, expected);
    }
}

/// Their coordinates are in single precision, and as text with six digits.
#[test]
#[cfg(feature = "vtk")]
fn labels_of_vtk_files_are_bodies_and_boundaries() {
    let same = |name: &str, text: &str| {
        let (file, text) = (read(name), read(text));
        assert_eq!(file.format(), Format::Vtu);
        assert_eq!(file.vertices().len(), text.vertices().len(), "{name}");
        for (x, y) in file.vertices().iter().zip(text.vertices()) {
            assert!(
                (0..3).all(|i| (x[i] - y[i]).abs() <= 6e-7),
                "{name}: {x:?} {y:?}"
            );
        }
        assert_eq!(labelled(&file), labelled(&text), "{name}");
    };
    same("freefem.vtu", "freefem.msh");
    same("freefem_text.vtu", "freefem.msh");
    same("freefem_3d.vtu", "freefem_3d.mesh");
}

/// VTK 9.7 and meshio 5.3 wrote these, as `write_vtu.py` tells them: in text, inline, appended in base64 and raw, compressed and not, in one block and
/// in several, with notes about the range of arrays in their midst.
#[test]
#[cfg(feature = "vtk")]
fn vtk_files_in_each_mode_have_the_same_mesh() {
    let modes = ["inline", "appended", "raw"];
    let of = |mode: &str| ["none", "zlib", "lz4"].map(|codec| format!("vtk.{mode}.{codec}.vtu"));
    let names = modes.iter().flat_map(|mode| of(mode));
    let others = ["vtk.text.vtu", "vtk.blocks.vtu", "meshio.vtu"];
    let expected: Expected = &[("3", 2.0, &[("1", 2.0), ("7", 2.0)])];
    for name in names.chain(others.map(String::from)) {
        check::<2>(&name, &read(&name), expected);
    }
    // 1/6, and the determinant of the edges at (1, 1, 1) over 6: 2/6
    check::<3>(
        "space",
        &read("vtk.space.vtu"),
        &[("2", 0.5, &[("5", 0.5)])],
    );
    let refused = MeshFile::read(support::folder().join("vtk.inline.lzma.vtu"));
    let why = refused.expect_err("LZMA").to_string();
    assert!(
        why.contains("`vtkLZMADataCompressor`") && why.contains("zlib"),
        "{why}"
    );
}

/// VTK 9.7 and meshio 5.3 wrote these, as `write_vtk.py` tells them: in both versions, in text and in binary, with other data before, between
/// and behind. What Gmsh writes has the numbers of its geometry for labels: its physical groups are lost.
#[test]
fn legacy_vtk_files_have_the_same_mesh() {
    let expected: Expected = &[("3", 2.0, &[("1", 2.0), ("7", 2.0)])];
    for kind in ["text", "binary"] {
        for version in ["42", "51", "more"] {
            let name = format!("vtk.{version}.{kind}.vtk");
            let file = read(&name);
            assert_eq!(file.format(), Format::Vtk);
            check::<2>(&name, &file, expected);
        }
    }
    for name in ["meshio.42.vtk", "meshio.51.vtk", "meshio.physical.vtk"] {
        check::<2>(name, &read(name), expected);
    }
    check::<3>(
        "space",
        &read("vtk.space.vtk"),
        &[("2", 0.5, &[("5", 0.5)])],
    );
    fn areas<const D: usize>(name: &str) -> Vec<(usize, f64)> {
        let bodies = read(name).bodies::<D>();
        let bodies = bodies.unwrap_or_else(|why| panic!("{name}: {why}"));
        let of = |(_, mesh): &(String, Mesh<D>)| (mesh.len(), measures(mesh).0);
        bodies.iter().map(of).collect()
    }
    let same = |name: &str, found: Vec<(usize, f64)>, expected: Vec<(usize, f64)>| {
        assert_eq!(found.len(), expected.len(), "{name}");
        for (found, expected) in found.iter().zip(&expected) {
            let close = (found.1 - expected.1).abs() < 1e-9;
            assert!(
                found.0 == expected.0 && close,
                "{name}: {found:?} {expected:?}"
            );
        }
    };
    for order in [1, 2] {
        for kind in ["vtk", "bin.vtk"] {
            let name = format!("blocks.{order}.{kind}");
            same(
                &name,
                areas::<2>(&name),
                areas::<2>(&format!("blocks.{order}.v41.msh")),
            );
            let name = format!("bricks.{order}.{kind}");
            same(
                &name,
                areas::<3>(&name),
                areas::<3>(&format!("bricks.{order}.v41.msh")),
            );
        }
    }
}

/// Components without a name are empty lines among the notes; words may be in other cases; labels are the first cell data that are whole
/// numbers, whatever VTK has made of the characters of their names.
#[test]
fn legacy_vtk_files_as_other_writers_have_them() {
    let file = |data: &str| {
        format!(
            "# vtk DataFile Version 4.2\na title\nascii\ndataset unstructured_grid\nfield f 1\nNULL_ARRAY\n\
            points 4 Float\n0 0 0 2 0 0 2 1 0 0 1 0\nMETADATA\nCOMPONENT_NAMES\nX\n\nZ\nINFORMATION 0\n\n\
            cells 2 8\n3 0 1 2 3 0 2 3\ncell_types 2\n5 5\ncell_data 2\n{data}"
        )
    };
    let label = "scalars %4Cabel INT\nlookup_table default\n3 3\n";
    let entity = "scalars CellEntityIds int 1\nlookup_table default\n4 4\n";
    let field = "field f 2\ngmsh%3Aphysical 1 2 long\n5 5\nLabel 1 2 double\n0.5 3\n";
    for (data, expected) in [
        (label.to_string(), "3"),
        (format!("{entity}{label}"), "3"),
        (format!("{entity}{field}"), "5"),
        (String::new(), "body"),
    ] {
        let file = MeshFile::parse(file(&data).as_bytes());
        let file = file.unwrap_or_else(|why| panic!("{data}: {why}"));
        check::<2>(&data, &file, &[(expected, 2.0, &[])]);
    }
}

/// Gmsh writes its physical groups as sets of elements, with other names where these have spaces or none.
#[test]
fn decks_of_gmsh_are_bodies_and_boundaries() {
    let other = |name: &'static str| match name {
        "upper part" => "upper_part",
        "42" => "PhysicalLine42",
        same => same,
    };
    let named = |boundaries: &[(&'static str, f64)]| {
        let named = boundaries.iter().map(|&(name, size)| (other(name), size));
        // in alphabetical order
        named
            .collect::<BTreeMap<_, _>>()
            .into_iter()
            .collect::<Vec<_>>()
    };
    let blocks = [&BLOCKS[0], &BLOCKS[1]].map(|own| (other(own.0), own.1, named(own.2)));
    let blocks = [0, 1].map(|k| (blocks[k].0, blocks[k].1, &blocks[k].2[..]));
    for order in [1, 2] {
        let deck = read(&format!("blocks.{order}.inp"));
        assert_eq!(deck.format(), Format::Inp);
        check::<2>("blocks", &deck, &blocks);
        check::<3>("bricks", &read(&format!("bricks.{order}.inp")), BRICKS);
    }
}

/// Sections are bodies, surfaces and sets of nodes boundaries; steps are not read.
#[test]
fn a_deck_by_hand() {
    let deck = read("calculix.inp");
    let root = f64::sqrt(3.0);
    // the equilateral triangle between the tetrahedra has the side √2, as the three free ones of the second have
    let side = 0.5 * root;
    // the set of all nodes has the face between the bodies as well
    let expected: Expected = &[
        (
            "First",
            1.0 / 6.0,
            &[("Nall", 1.5 + side), ("foot", 0.5), ("side", 1.0)],
        ),
        (
            "second",
            1.0 / 3.0,
            &[("Free", 3.0 * side), ("Nall", 4.0 * side)],
        ),
    ];
    check::<3>("deck", &deck, expected);
}

/// Many programs leave Medit's last keyword out.
#[test]
fn medit_files_may_lack_their_last_keyword() {
    let text = std::fs::read_to_string(support::folder().join("freefem.mesh")).expect("a file");
    let text = text.trim_end();
    let without = text.strip_suffix("End").expect("the last keyword");
    let [with, without] = [text, without].map(|text| MeshFile::parse(text.as_bytes()));
    let [with, without] = [with, without].map(|file| file.expect("a mesh"));
    assert_eq!(labelled(&with), labelled(&without));
}

/// The field (x², x y) of FreeFEM's P2, whose nodes are told by their coordinates.
#[test]
fn nodes_of_freefem_are_found_by_their_places() {
    let mesh = read("freefem_p2.msh")
        .bodies::<2>()
        .expect("a body")
        .remove(0)
        .1
        .quadratic();
    let text = std::fs::read_to_string(support::folder().join("freefem_p2.txt")).expect("a file");
    let numbers = text
        .split_whitespace()
        .map(|word| word.parse().expect("a number"));
    let lines: Vec<[f64; 4]> = numbers
        .collect::<Vec<f64>>()
        .chunks_exact(4)
        .map(|line| [line[0], line[1], line[2], line[3]])
        .collect();
    let points: Vec<[f64; 2]> = lines.iter().map(|&[x, y, ..]| [x, y]).collect();
    let nodes = mesh.nodes_at(&points).expect("nodes");
    let mut sorted = nodes.clone();
    sorted.sort_unstable();
    assert!(sorted.iter().copied().eq(0..mesh.nodes().len()));
    assert!(nodes != sorted, "FreeFEM has an order of its own");
    for (&node, [.., u, v]) in nodes.iter().zip(&lines) {
        let x = mesh.nodes()[node];
        // the file has 12 digits of the corners
        assert!((x[0] * x[0] - u).abs() < 1e-9 && (x[0] * x[1] - v).abs() < 1e-9);
    }
    let error = mesh
        .nodes_at(&[[0.0, 0.0], [0.1, 0.0]])
        .expect_err("no node");
    assert!(error.to_string().contains("0 nodes are within"), "{error}");
}

/// All elements with their labels, in order.
fn labelled(file: &MeshFile) -> Vec<(ElementKind, i64, Vec<usize>)> {
    let elements = file.elements().iter().flat_map(|elements| {
        let label = file.groups()[elements.groups[0]].number;
        let nodes = elements.iter().map(<[usize]>::to_vec);
        nodes.map(move |mut nodes| {
            if elements.kind == ElementKind::Segment {
                // of either direction
                nodes.sort_unstable();
            }
            (elements.kind, label, nodes)
        })
    });
    let mut elements: Vec<_> = elements.collect();
    elements.sort();
    elements
}

/// Files of FreeFEM and of libMeshb, which was given the text.
#[test]
fn binary_files_of_medit_hold_what_the_text_holds() {
    let files = [
        ("freefem_3d.mesh", "freefem_3d.meshb", 1e-12),
        ("blocks.2.mesh", "blocks.2.v1.meshb", 1e-7),
        ("blocks.2.mesh", "blocks.2.v3.meshb", 0.0),
        ("blocks.2.mesh", "blocks.2.v4.meshb", 0.0),
        ("bricks.2.mesh", "bricks.2.v1.meshb", 1e-7),
    ];
    for (text, binary, round_off) in files {
        let (text, file) = (read(text), read(binary));
        assert_eq!(file.format(), Format::Medit);
        assert_eq!(file.vertices().len(), text.vertices().len(), "{binary}");
        for (x, y) in file.vertices().iter().zip(text.vertices()) {
            let is_close = |i: usize| (x[i] - y[i]).abs() <= round_off;
            assert!((0..3).all(is_close), "{binary}: {x:?} {y:?}");
        }
        assert_eq!(labelled(&file), labelled(&text), "{binary}");
    }
}

/// Edges in VTK's order.
fn edges(kind: ElementKind) -> &'static [[usize; 2]] {
    const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
    &EDGES[..kind.nodes() - kind.corners()]
}

#[test]
fn nodes_amid_edges_come_in_the_order_of_vtk() {
    let versions = VERSIONS.map(|(version, _)| format!("2.{version}.msh"));
    for ending in versions.into_iter().chain(["2.mesh".to_string()]) {
        for (name, counts) in [("blocks", [26, 0]), ("bricks", [32, 86])] {
            let file = read(&format!("{name}.{ending}"));
            let x = |node: usize| nalgebra::Vector3::from(file.vertices()[node]);
            let mut found = [0; 4];
            for elements in file.elements().iter().filter(|e| e.kind.dimension() > 0) {
                let kind = elements.kind;
                assert_eq!(
                    kind.nodes() - kind.corners(),
                    [1, 3, 6][kind.dimension() - 1]
                );
                found[kind.dimension()] += elements.len();
                for element in elements.iter() {
                    let mirrored = kind.mirrored().iter().map(|&k| element[k]);
                    for nodes in [element.to_vec(), mirrored.collect()] {
                        for (&[a, b], &amid) in edges(kind).iter().zip(&nodes[kind.corners()..]) {
                            let off = x(amid) - 0.5 * (x(nodes[a]) + x(nodes[b]));
                            assert!(off.norm() < 1e-9, "{name}.{ending}: {nodes:?}");
                        }
                    }
                }
            }
            assert!(found[1] > 0 && found[2..] == counts, "{ending} {found:?}");
        }
    }
}

#[test]
fn line_ends_byte_order_marks_and_comments_do_not_matter() {
    for (path, bytes) in support::mesh_files() {
        let path = path.display().to_string();
        let text = String::from_utf8(bytes);
        let (Ok(text), false) = (text, path.contains("found")) else {
            continue;
        };
        let Ok(file) = MeshFile::parse(text.as_bytes()) else {
            continue;
        };
        // line ends are bytes of numbers there
        if file.format() == Format::Vtk && text.contains("\nBINARY\n") {
            continue;
        }
        let comment = match file.format() {
            Format::Gmsh41 | Format::Gmsh22 => "$Comments\nNodes, $Nodes and é\n$EndComments\n",
            Format::Medit => "# comment\n",
            Format::FreeFem | Format::Stl | Format::Vtu | Format::Vtk | Format::Inp => "",
        };
        let variants = [
            text.replace('\n', "\r\n"),
            format!("\u{feff}\n  {text}\n\n"),
            format!("{comment}{text}"),
            text.replace("$Nodes", &format!("{comment}$Nodes")),
            text.replace("Vertices", &format!("{comment}Vertices")),
            text.trim_end().to_string(),
        ];
        for variant in variants {
            let variant = MeshFile::parse(variant.as_bytes());
            let variant = variant.unwrap_or_else(|error| panic!("{path}: {error}"));
            assert_eq!(variant.vertices(), file.vertices(), "{path}");
            assert_eq!(variant.groups(), file.groups(), "{path}");
            assert_eq!(variant.elements(), file.elements(), "{path}");
        }
    }
}

/// A wedge of triangles, as a text and binary: points are merged, and it is closed.
#[test]
fn surfaces_of_stl_files() {
    for name in ["wedge.stl", "wedge.bin.stl"] {
        let file = read(name);
        assert_eq!(file.format(), Format::Stl);
        assert_eq!((file.vertices().len(), file.elements()[0].len()), (6, 8));
        let wedge = Obstacle::<3>::read(support::folder().join(name)).expect("closed");
        for (x, expected) in [
            ([0.5, 0.5, 3.0], 2.0),
            ([0.2, 0.3, 0.5], -0.2),
            ([-3.0, -4.0, 0.5], 5.0),
        ] {
            assert_eq!(wedge.distance(&x.into()), expected);
        }
    }
}

//! Wrong and foreign files: each is refused with its place and the reason.

use crate::support::{self, mutation::Random};
use contact_fem::mesh::read::{Place, Problem};
use contact_fem::{Error, MeshFile};

use Place::{File, Line};
use Problem::*;

/// A piece of a good file, what it is replaced by, the line of the problem, its kind, and what the
/// message has to contain.
type Case<'a> = (&'a str, &'a str, usize, fn(&Problem) -> bool, &'a str);

/// Whether a problem is of this kind.
macro_rules! is {
    ($kind:ident) => {
        |problem| matches!(problem, Problem::$kind { .. })
    };
}

fn refusal(bytes: &[u8]) -> (Place, Problem) {
    match MeshFile::parse(bytes) {
        Err(Error::MeshFile { place, problem, .. }) => (place, problem),
        other => panic!("{other:?}"),
    }
}

fn check(good: &str, cases: &[Case]) {
    MeshFile::parse(good.as_bytes()).unwrap_or_else(|error| panic!("{error}\n{good}"));
    for (piece, replacement, line, is_kind, part) in cases {
        assert!(good.contains(piece), "{piece}");
        let bad = good.replacen(piece, replacement, 1);
        let (place, problem) = refusal(bad.as_bytes());
        let what = format!("{piece:?} -> {replacement:?}: {place:?} {problem}");
        assert_eq!(place, Line(*line), "{what}");
        assert!(is_kind(&problem), "{what}");
        assert!(problem.to_string().contains(part), "{what}");
    }
}

#[test]
fn gmsh_2_2() {
    let good = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \"plate\"\n\
        $EndPhysicalNames\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n30 0 1 0\n$EndNodes\n$Elements\n1\n\
        1 2 2 7 1 1 2 30\n$EndElements\n";
    #[rustfmt::skip]
    let cases: &[Case] = &[
        ("2.2 0", "2.1 0", 2, is!(Unsupported), ""),
        ("2.2 0", "5 0", 2, is!(Unsupported), ""),
        ("2.2 0", "two 0", 2, is!(Expected), ""),
        ("2.2 0", "2.2 2", 2, is!(Expected), ""),
        ("$EndMeshFormat", "$Nodes", 3, is!(Expected), "found `$Nodes`"),
        ("$MeshFormat", "$NOD", 1, is!(Unsupported), ""),
        ("$MeshFormat", "$Format", 1, is!(Truncated), ""),
        ("\n1\n2 7", "\n2\n2 7", 7, is!(Expected), ""),
        ("\n1\n2 7", "\n0\n2 7", 6, is!(Expected), ""),
        ("2 7 \"pl", "4 7 \"pl", 6, is!(Expected), ""),
        ("\"plate\"", "plate", 6, is!(Expected), ""),
        ("\"plate\"", "\"plate", 6, is!(Expected), ""),
        ("\n3\n1", "\n2\n1", 12, is!(Expected), "expected `$EndNodes`"),
        ("\n3\n1", "\n4\n1", 13, is!(Expected), "found `$EndNodes`"),
        ("\n3\n1", "\n4000000000\n1", 9, is!(Count), "announces 4000000000"),
        ("\n3\n1", "\n18446744073709551615\n1", 9, is!(Count), ""),
        ("\n3\n1", "\n18446744073709551616\n1", 9, is!(Expected), ""),
        ("\n3\n1", "\n-3\n1", 9, is!(Expected), ""),
        ("2 1 0 0", "1 1 0 0", 11, is!(RepeatedNode), "node 1 "),
        ("2 1 0 0", "-2 1 0 0", 11, is!(Expected), ""),
        ("2 1 0 0", "2 nan 0 0", 11, is!(NotFinite), "node 2 "),
        ("2 1 0 0", "2 1 0 1e999", 11, is!(NotFinite), "node 2 "),
        ("2 1 0 0", "2 1 0 1d0", 11, is!(Expected), ""),
        ("2 1 0 0", "2 1 0", 13, is!(Expected), ""),
        ("$EndNodes\n", "", 13, is!(Expected), ""),
        ("1\n1 2 2", "2\n1 2 2", 17, is!(Expected), ""),
        ("1\n1 2 2", "900\n1 2 2", 15, is!(Count), ""),
        ("1 2 2 7", "1 3 2 7", 16, is!(UnsupportedElement), "4-node quad"),
        ("1 2 2 7", "1 16 2 7", 16, is!(UnsupportedElement), "8-node quad"),
        ("1 2 2 7", "1 21 2 7", 16, is!(UnsupportedElement), ""),
        ("1 2 2 7", "1 999 2 7", 16, is!(UnsupportedElement), ""),
        ("1 2 2 7", "1 4 2 7", 17, is!(Expected), ""),
        ("1 2 2 7", "1 2 4 7 1 1", 16, is!(Partitioned), ""),
        ("1 2 2 7 1 1", "1 2 9999999999999 7 1 0", 17, is!(Expected), "a tag"),
        ("1 2 30\n$", "1 2 3\n$", 16, is!(UnknownNode), "node 3"),
        ("1 2 30\n$", "1 2 -3\n$", 16, is!(Expected), ""),
        ("$EndElements", "", 18, is!(Truncated), ""),
        ("$EndElements", "$End", 17, is!(Expected), ""),
        ("$Elements", "$Comments", 14, is!(Truncated), ""),
    ];
    check(good, cases);
    let (place, problem) = refusal(&good.as_bytes()[..good.find("$Elements").expect("there")]);
    assert_eq!(place, File);
    assert!(problem.to_string().contains("no `$Elements`"), "{problem}");
    let mut latin = good.as_bytes().to_vec();
    latin[good.find("late").expect("there")] = 0xe9;
    let (place, problem) = refusal(&latin);
    assert!(
        matches!(&problem, NotUtf8 { name } if name.contains("xe9")),
        "{problem}"
    );
    assert_eq!(place, Line(6));
}

#[test]
fn gmsh_4_1() {
    let good = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n\
        3 0 0 0 1 1 0 1 7 0\n$EndEntities\n$Nodes\n1 3 1 30\n2 3 0 3\n1\n2\n30\n0 0 0\n1 0 0\n\
        0 1 0\n$EndNodes\n$Elements\n1 1 1 1\n2 3 2 1\n1 1 2 30\n$EndElements\n";
    let groups: String = (0..65).map(|k| format!(" {}", k + 1)).collect();
    let groups = format!("0 65{groups} 0\n$End");
    #[rustfmt::skip]
    let cases: &[Case] = &[
        ("4.1 0", "4 0", 2, is!(Unsupported), "version 4"),
        ("4.1 0", "4.0 0", 2, is!(Unsupported), ""),
        ("4.1 0", "4.2 0", 2, is!(Unsupported), ""),
        ("4.1 0", "3 0", 2, is!(Unsupported), ""),
        ("4.1 0", "nan 0", 2, is!(Unsupported), ""),
        ("0 0 1 0\n", "0 0 2 0\n", 7, is!(Expected), ""),
        ("0 0 1 0\n", "0 0 0 1\n", 20, is!(UnknownEntity), ""),
        ("0 0 1 0\n", "0 0 18446744073709551615 0\n", 7, is!(Expected), ""),
        ("0 1 7 0\n", "0 18446744073709551615 7 0\n", 7, is!(Expected), ""),
        ("0 1 7 0\n$End", &groups, 6, is!(Groups), ""),
        ("$Entities", "$PartitionedEntities", 4, is!(Partitioned), ""),
        ("1 3 1 30", "2 3 1 30", 17, is!(Expected), ""),
        ("1 3 1 30", "1 4 1 30", 17, is!(Total), ""),
        ("1 3 1 30", "1 99999999 1 30", 9, is!(Count), "announces 99999999"),
        ("2 3 0 3", "2 3 0 4", 17, is!(Expected), "found `$EndNodes`"),
        ("2 3 0 3", "2 3 0 18446744073709551615", 10, is!(Count), ""),
        ("2 3 0 3", "2 3 1 3", 17, is!(Expected), ""),
        ("\n2\n30\n", "\n2\n2\n", 16, is!(RepeatedNode), "node 2 "),
        ("1 0 0\n", "1 0 inf\n", 15, is!(NotFinite), "node 2 "),
        ("1 1 1 1", "0 1 1 1", 20, is!(Expected), ""),
        ("1 1 1 1", "1 0 1 1", 22, is!(Total), ""),
        ("2 3 2 1", "3 3 2 1", 20, is!(Expected), "found `3-node triangle`"),
        ("2 3 2 1", "2 4 2 1", 20, is!(UnknownEntity), ""),
        ("2 3 2 1", "2 3 3 1", 20, is!(UnsupportedElement), ""),
        ("2 3 2 1", "2 3 2 10000", 20, is!(Count), "announces 10000"),
        ("1 1 2 30", "1 1 2 31", 21, is!(UnknownNode), ""),
        ("1 1 2 30", "1 1 2", 22, is!(Expected), ""),
    ];
    check(good, cases);
    let (_, problem) = refusal(&good.as_bytes()[..good.find("$Nodes").expect("there")]);
    assert!(
        matches!(
            problem,
            Missing {
                section: "`$Nodes`"
            }
        ),
        "{problem}"
    );
}

#[test]
fn medit() {
    const EDGES: &str = "Edges 1\n1 2 4";
    let good = "MeshVersionFormatted 2\nDimension 2\nVertices 3\n0 0 0\n1 0 0\n0 1 0\n\
        Edges 1\n1 2 4\nCorners\n2\n1 2\nAngleOfCornerBound 1e-3\nTriangles\n1\n1 2 3 7\nEnd\n";
    #[rustfmt::skip]
    let cases: &[Case] = &[
        ("Formatted 2", "Formatted 7", 1, is!(Unsupported), ""),
        ("Dimension 2", "Dimension 4", 2, is!(Expected), ""),
        ("Dimension 2", "Identifier \"Dimension 2\"", 3, is!(Order), ""),
        ("Vertices 3", "Vertices 4", 7, is!(Expected), "found `Edges`"),
        ("Vertices 3", "Vertices 2", 6, is!(Expected), "found `0`"),
        ("Vertices 3", "Vertices 5000000000", 3, is!(Count), "announces 5000000000"),
        ("Vertices 3", "Points 3", 7, is!(Order), "`Edges`"),
        ("1 0 0", "1 inf 0", 5, is!(NotFinite), "node 2 "),
        (EDGES, "Vertices 1\n1 2 4", 7, is!(Order), ""),
        (EDGES, "Edges 1\n1 2", 9, is!(Expected), ""),
        (EDGES, "EdgesP3 1\n1 2 4", 7, is!(UnsupportedElement), ""),
        (EDGES, "Quadrilaterals 1\n1 2 3 4 5", 7, is!(UnsupportedElement), ""),
        (EDGES, "Edges 1\n0 2 4", 8, is!(UnknownNode), "node 0"),
        (EDGES, "Edges 1\n1 -9223372036854775808 4", 8, is!(UnknownNode), ""),
        ("1 2 3 7", "1 2 4 7", 15, is!(UnknownNode), "node 4"),
        ("1 2 3 7", "1 2 3 7 7", 15, is!(Expected), ""),
        ("1 2 3 7", "1 2 3", 16, is!(Expected), "found `End`"),
        ("1 2 3 7\nEnd\n", "1 2  3 ", 15, is!(Truncated), "a label"),
    ];
    check(good, cases);
    let none = good.replace(EDGES, "Hexahedra 0 Tetrahedra 0");
    MeshFile::parse(none.as_bytes()).expect("no hexahedra");
    let nothing = good.replace(EDGES, "").replace("Triangles\n1\n1 2 3 7", "");
    let (place, problem) = refusal(nothing.as_bytes());
    assert!(matches!(problem, Missing { .. }), "{problem}");
    assert_eq!(place, File);
}

/// The byte of a number in a good file, what it is replaced by, the byte of the problem, or 0 for the whole file, its kind,
/// and what the message has to contain.
type BinaryCase<'a> = (usize, i32, usize, fn(&Problem) -> bool, &'a str);

/// A triangle in each version, with a section of a kind that is not read, and none of these.
#[test]
fn medit_in_binary() {
    let good = |version: i32| {
        let wide = version > 3;
        let integer = |n: i64| match wide {
            true => n.to_le_bytes().to_vec(),
            false => (n as i32).to_le_bytes().to_vec(),
        };
        let real = |x: f64| match version {
            1 => (x as f32).to_le_bytes().to_vec(),
            _ => x.to_le_bytes().to_vec(),
        };
        let vertex = |x: f64, y: f64| [real(x), real(y), integer(-7)].concat();
        let vertices = [
            integer(3),
            vertex(0.0, 0.0),
            vertex(1.0, 0.0),
            vertex(0.0, 1.0),
        ];
        let triangle = [1, 1, 2, 3, 9].map(integer);
        let sections = [
            (3_i32, 2_i32.to_le_bytes().to_vec()),
            (99, integer(0)),
            (4, vertices.concat()),
            (6, triangle.concat()),
            (54, Vec::new()),
        ];
        let mut bytes = [1, version].map(i32::to_le_bytes).concat();
        let mut starts = Vec::new();
        for (code, items) in sections {
            starts.push(bytes.len());
            bytes.extend(code.to_le_bytes());
            let size = if version > 2 { 8 } else { 4 };
            let next = match code {
                54 => 0,
                _ => bytes.len() + size + items.len(),
            };
            bytes.extend(&next.to_le_bytes()[..size]);
            bytes.extend(items);
        }
        (bytes, starts)
    };
    for version in 1..=4 {
        let (bytes, starts) = good(version);
        let file = MeshFile::parse(&bytes).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(file.vertices()[1], [1.0, 0.0, 0.0]);
        assert_eq!(file.bodies::<2>().expect("a body")[0].0, "9");
        let position = if version > 2 { 8 } else { 4 };
        let [dimension, none, vertices, triangles, end] = starts[..] else {
            panic!("{starts:?}");
        };
        let items = |section: usize| section + 4 + position;
        let integer = if version > 3 { 8 } else { 4 };
        #[rustfmt::skip]
        let cases: &[BinaryCase] = &[
            (items(dimension), 4, items(dimension), is!(Expected), "dimension 2 or 3"),
            (dimension + 4, 3, items(dimension), is!(Expected), "a position from"),
            (dimension + 4, i32::MAX, items(dimension), is!(Expected), "a position from"),
            (items(none), 1, items(none), is!(UnsupportedElement), "`HexahedraQ4`"),
            (items(vertices), i32::MAX, items(vertices), is!(Count), "announces 2147483647"),
            (vertices + 4, 0x1000, triangles - integer, is!(Expected), "the next section at byte"),
            (vertices, 11, items(triangles), is!(Order), "`Vertices` have to"),
            (vertices, 54, 0, is!(Missing), "`Vertices`"),
            (triangles, 11, 0, is!(Missing), "`Triangles`"),
            (items(triangles) + integer, 4, items(triangles) + integer, is!(UnknownNode), "node 4"),
            (items(triangles), 0, items(triangles), is!(Expected), "the next section at byte"),
        ];
        for &(at, number, place, is_kind, part) in cases {
            let mut bad = bytes.clone();
            bad[at..at + 4].copy_from_slice(&number.to_le_bytes());
            let (found, problem) = refusal(&bad);
            let what = format!("version {version}, {number} at {at}: {found:?} {problem}");
            assert!(is_kind(&problem), "{what}");
            assert!(problem.to_string().contains(part), "{what}");
            assert!(
                found == Place::Byte(place) || (place, found) == (0, File),
                "{what}"
            );
        }
        for length in 8..end + 4 {
            let (_, problem) = refusal(&bytes[..length]);
            assert!(
                matches!(problem, Truncated { .. } | Count { .. } | Expected { .. }),
                "{problem}"
            );
        }
        let mut big = bytes.clone();
        big[..8].copy_from_slice(&[0, 0, 0, 1, 0, 0, 0, version as u8]);
        let (_, problem) = refusal(&big);
        assert!(matches!(&problem, Unsupported { found, .. } if found.contains("big-endian")));
        big[..8].copy_from_slice(&[1, 0, 0, 0, 5, 0, 0, 0]);
        assert!(matches!(refusal(&big).1, UnknownFormat { .. }));
    }
}

#[test]
fn freefem() {
    let good = "3 1 1\n0 0 1\n1 0 1\n0 1 1\n1 2 3 5\n1 2 9\n";
    #[rustfmt::skip]
    let cases: &[Case] = &[
        ("3 1 1\n0", "4 1 1\n0", 5, is!(UnknownNode), "node 5"),
        ("3 1 1\n0", "3 0 1\n0", 5, is!(Expected), "found `5`"),
        ("3 1 1\n0", "3 1 0\n0", 6, is!(Expected), ""),
        ("3 1 1\n0", "3 99999999999 1\n0", 4, is!(Count), ""),
        ("3 1 1\n0", "18446744073709551615 1 1\n0", 1, is!(Count), ""),
        ("3 1 1\n0", "18446744073709551616 1 1\n0", 1, is!(Expected), ""),
        ("1 0 1\n", "nan 0 1\n", 3, is!(NotFinite), "node 2 "),
        ("1 2 3 5", "1 2 4 5", 5, is!(UnknownNode), ""),
        ("1 2 9", "0 2 9", 6, is!(UnknownNode), ""),
        ("1 2 9", "1 2 nine", 6, is!(Expected), ""),
    ];
    check(good, cases);
    let (_, problem) = refusal(b"0 0 0");
    assert!(problem.to_string().contains("no vertices"), "{problem}");
}

#[test]
fn legacy_vtk() {
    let good = "# vtk DataFile Version 3.0\na title\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n\
        0 0 0\n1 0 0\n0 1 0\nCELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\nCELL_DATA 1\nSCALARS Label int 1\n\
        LOOKUP_TABLE default\n7\n";
    #[rustfmt::skip]
    let cases: &[Case] = &[
        ("3.0", "6.0", 1, is!(Expected), "a version up to 5, found `6.0`"),
        ("ASCII", "TEXT", 3, is!(Expected), "found `TEXT`"),
        ("DATASET", "DATA", 4, is!(Expected), "found `DATA`"),
        ("UNSTRUCTURED_GRID", "POLYDATA", 4, is!(Unsupported), "VTK's POLYDATA"),
        ("float", "floating", 5, is!(Expected), "a type of numbers"),
        ("POINTS 3 ", "POINTS 99999999999 ", 5, is!(Count), "coordinates, but only"),
        ("POINTS 3 ", "POINTS 18446744073709551615 ", 5, is!(Count), ""),
        ("POINTS 3 ", "POINTS 4 ", 9, is!(Expected), "found `CELLS`"),
        ("POINTS 3 ", "POINTS 2 ", 8, is!(Expected), "found `0`"),
        ("CELLS 1 4", "CELLS 2 4", 10, is!(Total), "2 cells"),
        ("CELLS 1 4", "CELLS 0 4", 10, is!(Total), "4 nodes of cells"),
        ("3 0 1 2", "-3 0 1 2", 10, is!(Total), ""),
        ("3 0 1 2", "2.5 0 1 2", 10, is!(Total), ""),
        ("3 0 1 2", "9e9 0 1 2", 10, is!(Total), ""),
        ("SCALARS Label int 1", "SCALARS Label int 2", 17, is!(Truncated), ""),
        ("SCALARS", "NUMBERS", 14, is!(Expected), "the keyword of data"),
        ("LOOKUP_TABLE", "TABLE", 15, is!(Expected), "`LOOKUP_TABLE`, found `TABLE`"),
        ("\nCELL_DATA 1", "", 13, is!(Expected), "found `SCALARS`"),
    ];
    check(good, cases);
    #[rustfmt::skip]
    let of_the_grid = [
        ("3 0 1 2", "3 0 1 3", "names node 3"),
        ("3 0 1 2", "3 0 1 -1", "names node -1"),
        ("CELL_TYPES 1\n5", "CELL_TYPES 1\n9", "VTK's quadrilateral (9)"),
        ("CELL_TYPES 1\n5", "CELL_TYPES 1\n22", "the 6 nodes of cell 0, a 6-node triangle, found `an end at 3`"),
        ("CELL_TYPES 1\n5", "CELL_TYPES 2\n5 5", "2 offsets of cells, one for each type of a cell, found `1`"),
        ("default\n7", "default\n7.5", "an integer label, found `7.5`"),
        ("0 1 0", "0 nan 0", "NaN"),
        ("CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\nCELL_DATA 1\nSCALARS Label int 1\nLOOKUP_TABLE default\n7\n", "", "no `CELLS`"),
    ];
    for (piece, replacement, part) in of_the_grid {
        assert!(good.contains(piece), "{piece}");
        let (place, problem) = refusal(good.replacen(piece, replacement, 1).as_bytes());
        assert!(problem.to_string().contains(part), "{problem}");
        assert_eq!(place, File);
    }
    // the first cell begins at 0, and has the three nodes that follow
    let offsets = "CELLS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2";
    let of_five = good
        .replace("3.0", "5.1")
        .replace("CELLS 1 4\n3 0 1 2", offsets);
    let file = MeshFile::parse(of_five.as_bytes()).expect("version 5");
    assert_eq!(file.elements()[0].nodes, [0, 1, 2]);
    for (piece, replacement) in [
        ("0 3\n", "0 2\n"),
        ("0 3\n", "1 3\n"),
        ("CELLS 2", "CELLS 0"),
    ] {
        let (_, problem) = refusal(of_five.replacen(piece, replacement, 1).as_bytes());
        assert!(matches!(problem, Expected { .. }), "{piece} {problem}");
    }
}

/// A number that is announced is no reason to take memory; strings that announce more than there is are none, either.
#[test]
fn legacy_vtk_in_binary() {
    let head = b"# vtk DataFile Version 5.1\na title\nBINARY\nDATASET UNSTRUCTURED_GRID\n";
    let file = |rest: &[u8]| [&head[..], rest].concat();
    for rest in [
        &b"POINTS 99999999999 double\n\0\0"[..],
        b"POINTS 18446744073709551615 double\n\0\0",
        b"FIELD FieldData 1\nnote 1 18446744073709551615 string\n\xff",
        b"FIELD FieldData 1\nnote 1 1 string\n\x3f\xff\xff\xff\xff\xff\xff\xff",
        b"FIELD FieldData 1\nnote 1 2 string\n\xc1a\xc2b",
        b"POINT_DATA 100\nSCALARS a bit 1\nLOOKUP_TABLE default\n\0",
    ] {
        let bytes = file(rest);
        let (peak, (_, problem)) = support::memory::peak_of(|| refusal(&bytes));
        assert!(matches!(problem, Count { .. }), "{problem}");
        assert!(peak < 20_000, "{peak}");
    }
    let sound = file(b"FIELD FieldData 1\nnote 1 2 string\n\xc1a\x80\x02bcPOINTS 0 double\n");
    assert!(matches!(refusal(&sound).1, Missing { .. }));
}

#[test]
fn what_is_no_mesh_file() {
    for empty in ["", " \r\n\t ", "\u{feff}"] {
        assert!(matches!(refusal(empty.as_bytes()).1, Empty));
    }
    let mut random = Random(7);
    let noise: Vec<u8> = (0..10 << 20).map(|_| random.number() as u8).collect();
    for bytes in [&noise[..], b"\x1f\x8b\x08\x00", b"1 2", b"\xff"] {
        let (place, problem) = refusal(bytes);
        assert!(
            matches!(&problem, UnknownFormat { start } if start.len() < 200),
            "{problem}"
        );
        assert_eq!(place, File);
    }
    let header = b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n";
    let (peak, _) = support::memory::peak_of(|| refusal(&[header, &noise[..]].concat()));
    assert!(peak < 3 * noise.len(), "{peak}");
    let error = MeshFile::read("/no/such/file.msh").expect_err("no such file");
    assert!(matches!(error, Error::Read { .. }));
    assert!(error.to_string().contains("/no/such/file.msh"), "{error}");
}

#[test]
fn files_of_other_programs_are_refused_by_name() {
    let refused = |name: &str| {
        let error = MeshFile::read(support::folder().join(name)).expect_err(name);
        let text = error.to_string();
        assert!(text.contains(name), "{text}");
        text
    };
    for (name, reason) in [
        ("blocks.v1.msh", "version 1"),
        ("blocks.v3.msh", "version 3"),
        ("blocks.v4.msh", "version 4"),
        ("blocks.3.v41.msh", "4-node segment"),
        ("quadrilaterals.v41.msh", "4-node quadrilateral"),
        ("partitioned.v41.msh", "partitioned"),
        ("partitioned.v22.msh", "partitioned"),
    ] {
        let text = refused(name);
        assert!(text.contains(reason), "{text}");
    }
}

#[test]
fn binary_files_of_other_machines_are_refused() {
    for name in ["blocks.1.v41.bin.msh", "blocks.1.v22.bin.msh"] {
        let good = std::fs::read(support::folder().join(name)).expect("a file");
        let one = good
            .windows(5)
            .position(|w| w == b"\n\x01\0\0\0")
            .expect("there")
            + 1;
        let mut bad = good.clone();
        bad[one..one + 4].copy_from_slice(&1_i32.to_be_bytes());
        let (place, problem) = refusal(&bad);
        assert!(matches!(&problem, Unsupported { found, .. } if found.contains("big-endian")));
        assert_eq!(place, Place::Byte(one));
        bad[one] = 3;
        assert!(matches!(refusal(&bad).1, Expected { .. }));
        let mut short = good.clone();
        short[one - 2] = b'4';
        assert!(
            matches!(&refusal(&short).1, Unsupported { found, .. } if found.contains("4 bytes"))
        );
        // the numbers of nodes, entities and elements, wherever they are, made huge
        for at in (one..good.len() - 8).step_by(4) {
            let mut bad = good.clone();
            bad[at..at + 8].copy_from_slice(&(u64::MAX >> 1).to_le_bytes());
            let (peak, _) = support::memory::peak_of(|| support::read_fully(&bad));
            assert!(peak < support::allowance(&bad), "{name} {at} {peak}");
        }
    }
}

/// Sizes of VTK's blocks that do not fit, and more than a mesh can be.
#[test]
#[cfg(feature = "vtk")]
fn compressed_vtk_files() {
    let folder = support::folder();
    let text = std::fs::read_to_string(folder.join("vtk.inline.zlib.vtu")).expect("a file");
    for (from, to, told) in [
        (
            "NumberOfPoints=\"6\"",
            "NumberOfPoints=\"5\"",
            "announces 5 points",
        ),
        (
            "NumberOfCells=\"8\"",
            "NumberOfCells=\"7\"",
            "announces 7 cells",
        ),
        ("ZLib", "Zip", "`vtkZipDataCompressor`"),
        (
            "header_type=\"UInt64\"",
            "header_type=\"UInt32\"",
            "expected",
        ),
    ] {
        assert!(text.contains(from), "{from}");
        let why = MeshFile::parse(text.replace(from, to).as_bytes()).expect_err(to);
        assert!(why.to_string().contains(told), "{why}");
    }
    // one block, whole, and its last length: the largest numbers there are
    let header = base64_of(&[1, 32768, u64::MAX, 8]);
    let largest = "<VTKFile type=\"UnstructuredGrid\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\
        <Piece><Points><DataArray type=\"Float64\" format=\"binary\">";
    let end = "AAAAAAAAAAA=</DataArray></Points></Piece></VTKFile>";
    let why = MeshFile::parse(format!("{largest}{header}{end}").as_bytes()).expect_err("too large");
    assert!(why.to_string().contains("bytes at most"), "{why}");
}

#[cfg(feature = "vtk")]
fn base64_of(numbers: &[u64]) -> String {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bytes: Vec<u8> = numbers
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    let of = |three: &[u8]| {
        let all = three
            .iter()
            .fold(0_u32, |sum, &byte| sum << 8 | u32::from(byte));
        let all = all << (8 * (3 - three.len()));
        let letter = |k: usize| match k <= three.len() {
            true => LETTERS[(all >> (18 - 6 * k) & 63) as usize] as char,
            false => '=',
        };
        (0..4).map(letter).collect::<String>()
    };
    bytes.chunks(3).map(of).collect()
}

//! Decks of Abaqus and CalculiX by hand: what is read, and what is refused since it would be read as something else.

use contact_fem::{Mesh, MeshFile};

/// A square of four triangles around its middle, the node 5. Numbers of nodes and elements have gaps.
const SQUARE: &str = "*Heading
 a square
*Node
 1, 0, 0
 2, 2, 0
 3, 2, 2
 4, 0, 2
 5, 1, 1
*Element, type=CPE3
 10, 1, 2, 5
 20, 2, 3, 5
 30, 3, 4, 5
 40, 4, 1, 5
*Elset, elset=All, generate
 10, 40, 10
*Elset, elset=Right
 20
*Nset, nset=Left
 1, 4
*Surface, name=Top, type=element
 30, S1
*Surface, name=Side
 Right, S1
*Solid Section, elset=All
";

fn read(deck: &str) -> Mesh<2> {
    let file = MeshFile::parse(deck.as_bytes()).unwrap_or_else(|why| panic!("{why}\n{deck}"));
    let mut bodies = file.bodies::<2>().expect("bodies");
    assert_eq!(bodies.len(), 1);
    bodies.remove(0).1
}

/// The names of the boundaries with their lengths.
fn boundaries(mesh: &Mesh<2>) -> Vec<(String, f64)> {
    let of = |name: &str| {
        let facets = mesh.boundary(name).expect("named");
        let length = |facet: &&[usize]| (mesh.nodes()[facet[0]] - mesh.nodes()[facet[1]]).norm();
        (name.to_string(), facets.iter().map(length).sum())
    };
    mesh.boundary_names().map(of).collect()
}

fn changed(from: &str, to: &str) -> String {
    assert!(SQUARE.contains(from), "{from}");
    SQUARE.replacen(from, to, 1)
}

#[test]
fn the_same_deck_in_other_words() {
    let expected: Vec<_> = ["Left", "Side", "Top"]
        .map(|name| (name.to_string(), 2.0))
        .into();
    let nodes = SQUARE.split_once("*Node\n").expect("nodes").1;
    let (nodes, rest) = nodes.split_once("*Element").expect("elements");
    let after = format!("*Element{rest}*Node\n{nodes}");
    let inside = SQUARE.replace(
        "*Node\n",
        "*Part, name=P\n*End Part\n*Assembly, name=A\n*Instance, name=I, part=P\n 0., 0., 0.\n*Node\n",
    );
    let moved = "*End Instance\n*Node\n 1, 9, 9\n*Nset, nset=Left\n 1\n*End Assembly\n";
    for deck in [
        SQUARE.to_string(),
        SQUARE.replace('\n', "\r\n"),
        SQUARE
            .to_uppercase()
            .replace("LEFT", "Left")
            .replace("TOP", "Top")
            .replace("SIDE", "Side"),
        // a keyword goes on behind its last comma
        changed(
            "*Elset, elset=All, generate",
            "*ELSET, ELSET=All,\n  GENERATE",
        ),
        changed("1, 4\n", "1,\n 4,\n"),
        changed(" 2, 2, 0\n", " 2, 2.0D+00, 0.d0\n"),
        changed("Right, S1", "Inner, S1").replace(
            "*Surface, name=Top",
            "*Elset, elset=Inner\n Right\n*Surface, name=Top",
        ),
        after,
        // points of reference are of the assembly, and so are their sets
        format!("{inside}{moved}"),
        changed(
            "*Solid Section, elset=All\n",
            "*Solid Section, elset=All\n*Step\n*Nonsense\n 1, x\n",
        ),
        // neither a node alone nor one inside is a boundary
        changed(
            "*Nset",
            "*Nset, nset=Point\n 3\n*Nset, nset=Middle\n 1, 2, 5\n*Nset",
        ),
        // one of each, and the same
        changed("*Nset", "*Nset, nset=Top\n 3, 4\n*Nset"),
        changed(
            "*Element, type=CPE3\n 10, 1, 2, 5",
            "*Element, type=CPE3\n 10, 1,\n 2, 5",
        ),
    ] {
        let mesh = read(&deck);
        assert_eq!(boundaries(&mesh), expected, "{deck}");
        let area: f64 = (0..mesh.len()).map(|cell| mesh.volume(cell)).sum();
        assert!((area - 4.0).abs() < 1e-14);
    }
    let mut latin = SQUARE.as_bytes().to_vec();
    let at = SQUARE.find("square").expect("a word");
    latin[at] = 0xfc;
    MeshFile::parse(&latin).expect("the heading does not matter");
    // all that is outside
    let free = read(&changed("Right, S1", "All,"));
    assert_eq!(boundaries(&free)[1], ("Side".to_string(), 8.0));
}

/// A set of nodes between two bodies that share nodes is a boundary of both.
#[test]
fn sets_of_nodes_between_bodies() {
    let deck = SQUARE
        .replace(
            "*Elset, elset=All, generate\n 10, 40, 10\n",
            "*Elset, elset=A\n 10, 40\n*Elset, elset=B\n 20, 30\n",
        )
        .replace("elset=All", "elset=A")
        + "*Solid section, elset=B\n*Nset, nset=between\n 2, 5, 4\n";
    let bodies = MeshFile::parse(deck.as_bytes())
        .expect("a deck")
        .bodies::<2>()
        .expect("bodies");
    for (name, mesh) in &bodies {
        let between = boundaries(mesh).into_iter().find(|own| own.0 == "between");
        let (_, length) = between.unwrap_or_else(|| panic!("{name}"));
        assert!((length - f64::sqrt(8.0)).abs() < 1e-14);
    }
    assert_eq!(bodies.len(), 2);
}

#[test]
fn decks_that_would_be_read_as_something_else() {
    let part = |more: &str| {
        let part = SQUARE.replace("*Node\n", "*Part, name=P\n*Node\n");
        format!("{part}*End Part\n*Assembly, name=A\n*Instance, name=I, part=P\n{more}")
    };
    let cases = [
        (
            part("*End Instance\n*Nset, nset=Left, instance=I\n 2, 3\n"),
            "another `Left`",
        ),
        (part(" 10., 0., 0.\n*End Instance\n"), "instance is moved"),
        (
            part("*End Instance\n*Instance, name=J, part=P\n"),
            "`*INSTANCE",
        ),
        (
            part("*End Instance\n").replace("*End Part\n", "*End Part\n*Part\n*Node\n 7, 0, 0\n"),
            "several parts",
        ),
        (
            changed("*Node\n", "*System\n 10, 0, 0\n*Node\n"),
            "`*SYSTEM",
        ),
        (changed("*Node\n", "*Node, system=C\n"), "fixed axes"),
        (changed("*Node\n", "*Node, input=n.txt\n"), "into one file"),
        (
            changed("*Node\n", "*Include, input=n.txt\n*Node\n"),
            "into one file",
        ),
        (changed("*Node\n", "*Ngen\n 1, 5, 1\n*Node\n"), "`*NGEN`"),
        (
            changed(" 1, 4\n", " 1, 2\n").replace("Left", "Top"),
            "are not the same",
        ),
        (changed(" 1, 4\n", " 1, 4, 99\n"), "`99`"),
        (changed(" 1, 4\n", " 1, 4, Nobody\n"), "`Nobody`"),
        (changed("Right, S1", "Typo, S1"), "`Typo`"),
        (changed("Right, S1", "21, S1"), "`21`"),
        (changed("Right, S1", "Right, S4"), "`S4`"),
        (changed("Right, S1", "Right, SPOS"), "`S1` to `S4`"),
        (
            changed("type=CPE3", "type=S3"),
            "a face of a 3-node triangle",
        ),
        (changed("type=CPE3", "type=C3D8"), "`C3D8`"),
        (
            changed("Section, elset=All\n", "Section, elset=Everything\n"),
            "`Everything`",
        ),
        (
            changed(" 40, 4, 1, 5\n", " 40, 4, 1\n"),
            "the nodes of a 3-node triangle",
        ),
        (
            changed(" 40, 4, 1, 5\n", " 40, 4, 1, 5, 6\n"),
            "the nodes of a 3-node triangle",
        ),
        (
            changed(" 40, 4, 1, 5\n", " 10, 4, 1, 5\n"),
            "numbers of their own",
        ),
        (changed(" 40, 4, 1, 5\n", " 40, 4, 1, 6\n"), "node 6"),
        (
            changed(" 5, 1, 1\n", " 4, 1, 1\n"),
            "node 4 is defined twice",
        ),
        (changed(" 5, 1, 1\n", " 5, 1, inf\n"), "must be finite"),
        (
            changed(
                "*Surface, name=Top, type=element",
                "*Surface, name=Top, combine=union",
            ),
            "name the faces",
        ),
        (
            changed("*Nset, nset=Left", "*Nset, nset=Left, elset=Right"),
            "name the nodes",
        ),
        (changed(" 10, 40, 10\n", " 10, 40, 0\n"), "a step"),
    ];
    for (deck, told) in cases {
        let why = MeshFile::parse(deck.as_bytes()).err();
        let why = why
            .unwrap_or_else(|| panic!("read, although {told}\n{deck}"))
            .to_string();
        assert!(why.contains(told), "{why}: {told}");
    }
    // sets in sets, as deep as one likes
    let chain: String = (0..20_000)
        .map(|k| format!("*Nset, nset=n{}\n n{k}\n", k + 1))
        .collect();
    let deck = format!("{SQUARE}*Nset, nset=n0\n 1\n{chain}");
    let why = MeshFile::parse(deck.as_bytes())
        .expect_err("deep")
        .to_string();
    assert!(why.contains("sets in sets"), "{why}");
}

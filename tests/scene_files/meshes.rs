//! What `ipopt-contact mesh` tells of a file, against the geometry of the file.

use std::fs;

use super::{fresh, program};

/// Two rectangles of 2 by 1 and 2 by 1/2, that share two vertices, and one that no cell has; the middle of the lower one is within it.
const FILE: &str = "MeshVersionFormatted 2\nDimension 2\nVertices 7\n0 0 0\n4 0 0\n4 1 0\n0 1 0\n4 3 0\n0 3 0\n9 9 0\n\
    Triangles 4\n1 2 3 7\n1 3 4 7\n3 4 5 8\n4 5 6 8\nEdges 3\n1 2 1\n3 4 2\n1 3 3\n";

#[test]
fn bodies_boundaries_and_what_is_left_out_are_told() {
    let folder = fresh("mesh_told");
    let (path, to) = (folder.join("two.mesh"), folder.join("two.msh"));
    fs::write(&path, FILE).expect("written");
    let (code, told) = program(&["mesh"], &[&path]);
    assert_eq!(code, Some(0), "{told}");
    for part in [
        "two.mesh: Medit\n",
        "elements           4 3-node triangles, 3 2-node segments\n",
        "bodies             2, in the plane; bodies share no nodes",
        "body               `7`: 2 linear cells, 4 nodes, area 4 UL²\n",
        "from, to           (0, 0) (4, 1) UL; the diagonal is 4.12311 UL: 0.00412311 m if UL is mm\n",
        "sides of cells     1 to 4.12311 UL\n",
        // sides 1, 4 and √17: 4√3 · 2/34
        "worst cell         quality 0.408 at",
        "boundary           `1`: 1 facet\n",
        "boundary           `2`: 1 facet\n",
        "without a name     2 of 4 facets: `boundaries` in a scene",
        "inside             `3`: 1 facet within the body\n",
        "body               `8`: 2 linear cells, 4 nodes, area 8 UL²\n",
        "without a name     3 of 4 facets",
        "left out           1 vertex without a cell\n",
        "turned             1 cell whose nodes are in the other order in the file\n",
        "region = \"8\"\n",
    ] {
        assert!(told.contains(part), "{part}\n{told}");
    }
    // what is written has the same bodies, without the vertex; facets without a name have the label 0 there
    let (code, told) = program(&["mesh", "--to"], &[&to, &path]);
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("label              1 for `1`\n"), "{told}");
    let (code, again) = program(&["mesh"], &[&to]);
    assert_eq!(code, Some(0), "{again}");
    let facts = |text: &str| -> Vec<String> {
        let lines = text.lines().map(String::from);
        let of = ["body ", "from", "sides", "worst"];
        lines
            .filter(|line| of.iter().any(|of| line.starts_with(of)))
            .collect()
    };
    assert!(
        again.contains("two.msh: FreeFEM\n") && !again.contains("left out"),
        "{again}"
    );
    assert_eq!(facts(&again), facts(&told));
    for part in [
        "`1`: 1 facet\n",
        "`2`: 1 facet\n",
        "`0`: 2 facets\n",
        "`0`: 3 facets\n",
    ] {
        assert!(
            again.contains(&format!("boundary           {part}")),
            "{again}"
        );
    }
}

#[test]
fn surfaces_and_wrong_files_are_told() {
    let folder = fresh("mesh_refused");
    let file = |name: &str, text: &str| {
        let path = folder.join(name);
        fs::write(&path, text).expect("written");
        path
    };
    let surface = FILE
        .replace("Dimension 2", "Dimension 3")
        .replace(" 0\n", " 0 0\n");
    let surface = file("surface.mesh", &surface.replace("4 3 0 0", "4 3 1 0"));
    let (code, told) = program(&["mesh"], &[&surface]);
    assert!(
        code == Some(0) && told.contains("[[obstacle]]") && told.contains("at more than one z"),
        "{told}"
    );
    let to = folder.join("out.mesh");
    let (code, told) = program(&["mesh", "--to"], &[&to, &surface]);
    assert!(
        code == Some(2) && told.contains("error: --to writes bodies"),
        "{told}"
    );
    let lines = file(
        "lines.mesh",
        &FILE.replace("Triangles 4\n1 2 3 7\n1 3 4 7\n3 4 5 8\n4 5 6 8\n", ""),
    );
    let (code, told) = program(&["mesh"], &[&lines]);
    assert!(code == Some(0) && told.contains("no cells"), "{told}");
    let plane = file("plane.mesh", FILE);
    let (code, told) = program(&["mesh", "--to"], &[&to, &plane]);
    assert!(
        code == Some(2) && told.contains("with the ending .msh") && !to.exists(),
        "{told}"
    );
    let same = file("same.msh", &fs::read_to_string(&plane).expect("read"));
    let (code, told) = program(&["mesh", "--to"], &[&same, &same]);
    assert!(
        code == Some(2) && told.contains("is the file that is read"),
        "{told}"
    );
    // vertices of no cell do not matter
    let above = FILE
        .replace("Dimension 2", "Dimension 3")
        .replace(" 0\n", " 0 0\n");
    let above = file("above.mesh", &above.replace("9 9 0 0", "9 9 5 0"));
    let (code, told) = program(&["mesh"], &[&above]);
    assert!(
        code == Some(0) && told.contains("2, in the plane"),
        "{told}"
    );
    // an edge that belongs to no body
    let wrong = file("wrong.mesh", &FILE.replace("3 4 2\n", "2 6 2\n"));
    let (code, told) = program(&["mesh"], &[&wrong]);
    assert!(code == Some(2) && told.contains("wrong.mesh"), "{told}");
    let (code, told) = program(&["mesh"], &[]);
    assert!(
        code == Some(2) && told.contains("mesh needs one mesh file, and 0 are given"),
        "{told}"
    );
}

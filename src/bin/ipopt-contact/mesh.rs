//! `ipopt-contact mesh FILE`: the contents of a mesh file, and the lines that a scene with this mesh begins with.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::ExitCode;

use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::contact_fem::mesh::read::{ElementKind, Format, Problem};
use ipopt_contact::contact_fem::mesh::write::{boundary_labels, save_freefem};
use ipopt_contact::contact_fem::output::record::print;
use ipopt_contact::contact_fem::tensor::{Matrix, Vector, determinant};
use ipopt_contact::contact_fem::{Error, Mesh, MeshFile};

use crate::Words;

/// Cells of a quality below this are counted: a triangle with 6° between two equal sides is one.
const POOR: f64 = 0.2;

/// Prints the contents of the file; writes its bodies to another file where `--to` asks for it.
pub fn command(words: &[String]) -> Result<ExitCode, String> {
    let words = Words::parse("mesh", words, &["to"], &[])?;
    let path = words.only("one mesh file")?;
    let file = MeshFile::read(path).map_err(|why| why.to_string())?;
    print(row("file", format!("{path}: {}", name(file.format()))));
    let mut kinds = BTreeMap::new();
    for of in file.elements() {
        *kinds.entry(of.kind).or_default() += of.len();
    }
    print(row("elements", counted(&kinds)));
    let to = words.option("to").map(Path::new);
    let dimensions = kinds.keys().map(|kind| kind.dimension());
    match dimensions.max().unwrap_or(0) {
        3 => told::<3>(
            path,
            &file,
            to,
            &file.bodies().map_err(|why| why.to_string())?,
        )?,
        2 => match file.bodies::<2>() {
            Ok(bodies) => told::<2>(path, &file, to, &bodies)?,
            Err(Error::MeshFile {
                problem: Problem::NotPlane { .. },
                ..
            }) => {
                refuse(to, "a surface")?;
                let surface = "triangles at more than one z: no body, but the surface of an obstacle if it is closed";
                print(row("a surface", surface));
                let lines = format!("[[obstacle]]\nname = \"tool\"\nsurface = {}", quoted(path));
                print(row("in a scene", lines));
            }
            Err(why) => return Err(why.to_string()),
        },
        _ => {
            refuse(to, "a file without cells")?;
            let cells = "a mesh has triangles in the plane, tetrahedra in space";
            print(row("no cells", cells));
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn refuse(to: Option<&Path>, what: &str) -> Result<(), String> {
    match to {
        Some(_) => Err(format!("--to writes bodies, and this is {what}")),
        None => Ok(()),
    }
}

/// Prints the facts of all bodies, the contents of the file that no body has, and the lines of a scene; writes the bodies.
fn told<const D: usize>(
    path: &str,
    file: &MeshFile,
    to: Option<&Path>,
    bodies: &[(String, Mesh<D>)],
) -> Result<(), String> {
    let place = if D == 2 { "the plane" } else { "space" };
    if let Some(to) = to {
        check_target(to, path, if D == 2 { "msh" } else { "mesh" }, place)?;
    }
    let shared = "bodies share no nodes in a scene: state contact or a tie where they meet";
    print(row(
        "bodies",
        match bodies.len() {
            1 => format!("1, in {place}"),
            count => format!("{count}, in {place}; {shared}"),
        },
    ));
    for (name, mesh) in bodies {
        print(String::new());
        size(name, mesh);
        cells(mesh);
        boundaries(mesh);
    }
    print(String::new());
    for (name, fact) in left_out::<D>(file) {
        print(row(name, fact));
    }
    print(row("in a scene", statements(path, bodies)));
    match to {
        Some(to) => written(to, bodies),
        None => Ok(()),
    }
}

/// Checks that a file with this ending is to be written, and not over the one that is read.
fn check_target(to: &Path, from: &str, ending: &str, place: &str) -> Result<(), String> {
    let told = to.display();
    if to.extension().and_then(|e| e.to_str()) != Some(ending) {
        return Err(format!(
            "--to {told}: files in {place} are written as FreeFEM and Medit have them, with the ending .{ending}"
        ));
    }
    match (to.canonicalize(), Path::new(from).canonicalize()) {
        (Ok(to), Ok(from)) if to == from => Err(format!(
            "--to {told} is the file that is read: name another one"
        )),
        _ => Ok(()),
    }
}

/// Writes the bodies, and prints the labels that stand for the names of their boundaries.
fn written<const D: usize>(to: &Path, bodies: &[(String, Mesh<D>)]) -> Result<(), String> {
    let meshes: Vec<&Mesh<D>> = bodies.iter().map(|(_, mesh)| mesh).collect();
    save_freefem(to, &meshes).map_err(|why| why.to_string())?;
    let is_quadratic = meshes.iter().any(|mesh| mesh.order() == Order::Quadratic);
    let straight = match is_quadratic {
        true => ", its corners alone: these formats have straight cells",
        false => "",
    };
    print(row("written", format!("{}{straight}", to.display())));
    let labels = boundary_labels(&meshes).into_iter().flatten();
    let labels: BTreeSet<(i32, &str)> = labels.map(|(name, label)| (label, name)).collect();
    for (label, name) in labels {
        print(row("label", format!("{label} for `{name}`")));
    }
    Ok(())
}

/// Prints the size of a body.
fn size<const D: usize>(name: &str, mesh: &Mesh<D>) {
    let order = match mesh.order() {
        Order::Linear => "linear",
        Order::Quadratic => "quadratic",
    };
    let (of, unit) = match D {
        2 => ("area", "UL²"),
        _ => ("volume", "UL³"),
    };
    let volume: f64 = (0..mesh.len()).map(|k| mesh.volume(k)).sum();
    let cells = many(mesh.len(), &format!("{order} cell"));
    let (nodes, volume) = (mesh.nodes().len(), number(volume));
    print(row(
        "body",
        format!("`{name}`: {cells}, {nodes} nodes, {of} {volume} {unit}"),
    ));
    let (low, high) = mesh.bounding_box();
    let length = (high - low).norm();
    let [diagonal, metres] = [length, 1e-3 * length].map(number);
    let (low, high) = (point(&low), point(&high));
    print(row(
        "from, to",
        format!("{low} {high} UL; the diagonal is {diagonal} UL: {metres} m if UL is mm"),
    ));
    let parts = mesh.parts().len();
    if parts > 1 {
        print(row("parts", format!("{parts}, which share no node")));
    }
    // exactly the same place; -0 is 0
    let places = mesh.nodes().iter().map(|x| x.map(|x| (x + 0.0).to_bits()));
    let places: BTreeSet<Vec<u64>> = places.map(|x| x.iter().copied().collect()).collect();
    match nodes - places.len() {
        0 => {}
        twice => {
            let what = "in the place of another one: `merge-nodes` makes them one";
            print(row("double", format!("{} {what}", many(twice, "node"))));
        }
    }
}

/// Prints the lengths of the sides of cells, and the worst cell.
fn cells<const D: usize>(mesh: &Mesh<D>) {
    let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
    let (mut worst, mut at) = (f64::INFINITY, Vector::<D>::zeros());
    let mut poor = 0;
    for k in 0..mesh.len() {
        let corners = mesh.corners(k).iter().map(|&node| mesh.nodes()[node]);
        let corners: Vec<Vector<D>> = corners.collect();
        let (quality, sides) = quality(&corners);
        shortest = sides.iter().fold(shortest, |a, b| a.min(*b));
        longest = sides.iter().fold(longest, |a, b| a.max(*b));
        poor += usize::from(quality < POOR);
        if quality < worst {
            worst = quality;
            at = corners.iter().sum::<Vector<D>>() / corners.len() as f64;
        }
    }
    let [shortest, longest] = [shortest, longest].map(number);
    print(row("sides of cells", format!("{shortest} to {longest} UL")));
    let bad = match poor {
        0 => String::new(),
        poor => format!("; {poor} below {POOR}"),
    };
    let at = point(&at);
    print(row(
        "worst cell",
        format!("quality {worst:.3} at {at}{bad} (1 has equal sides)"),
    ));
}

/// Prints the names of boundaries, facets inside and regions.
fn boundaries<const D: usize>(mesh: &Mesh<D>) {
    let mut named = BTreeSet::new();
    for name in mesh.boundary_names() {
        let facets = mesh.boundary(name).unwrap_or_default();
        let count = many(facets.len(), "facet");
        print(row("boundary", format!("`{name}`: {count}")));
        for facet in facets {
            let mut facet = facet.to_vec();
            facet.sort_unstable();
            named.insert(facet);
        }
    }
    let all = mesh.exterior().len();
    if let Some(left @ 1..) = all.checked_sub(named.len()) {
        let what = "`boundaries` in a scene gives names, for loads, supports and contact";
        print(row(
            "without a name",
            format!("{left} of {all} facets: {what}"),
        ));
    }
    for (name, facets) in mesh.inner_facets() {
        let count = many(facets.len(), "facet");
        print(row("inside", format!("`{name}`: {count} within the body")));
    }
    let regions = mesh.region_names().map(|name| format!("`{name}`"));
    let regions: Vec<String> = regions.collect();
    if !regions.is_empty() {
        print(row("regions", regions.join(", ")));
    }
}

/// The contents of the file that no body has, and the number of cells that are turned.
fn left_out<const D: usize>(file: &MeshFile) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    let cells = || file.elements().iter().filter(|of| of.kind.dimension() == D);
    let used: BTreeSet<usize> = cells().flat_map(|of| of.nodes.iter().copied()).collect();
    match file.vertices().len() - used.len() {
        0 => {}
        1 => facts.push(("left out", "1 vertex without a cell".into())),
        left => facts.push(("left out", format!("{left} vertices without a cell"))),
    }
    let mut lower = BTreeMap::new();
    for of in file.elements() {
        let dimension = of.kind.dimension();
        if dimension + 1 < D || (dimension + 1 == D && of.groups.is_empty()) {
            *lower.entry(of.kind).or_default() += of.len();
        }
    }
    if !lower.is_empty() {
        let why = "facets without a label, and elements of lower dimension than facets";
        facts.push(("left out", format!("{}: {why}", counted(&lower))));
    }
    let vector = |node: &usize| Vector::<D>::from_fn(|i, _| file.vertices()[*node][i]);
    let is_turned = |nodes: &&[usize]| {
        let corners: Vec<Vector<D>> = nodes[..=D].iter().map(vector).collect();
        signed_volume(&corners) < 0.0
    };
    match cells().flat_map(|of| of.iter()).filter(is_turned).count() {
        0 => {}
        turned => {
            let why = "whose nodes are in the other order in the file";
            facts.push(("turned", format!("{} {why}", many(turned, "cell"))));
        }
    }
    let z = used.first().map_or(0.0, |&node| file.vertices()[node][2]);
    if D == 2 && z != 0.0 {
        facts.push(("left out", format!("z, which is {} everywhere", number(z))));
    }
    facts
}

/// The lines that a scene file with these bodies begins with.
fn statements<const D: usize>(path: &str, bodies: &[(String, Mesh<D>)]) -> String {
    let mut text = String::new();
    for (name, mesh) in bodies {
        let name = quoted(name);
        text += &format!("[[body]]\nname = {name}\nmesh = {}\n", quoted(path));
        if bodies.len() > 1 {
            text += &format!("region = {name}\n");
        }
        text += "# law, young, poisson, supports, loads\n";
        if mesh.boundary_names().next().is_none() {
            text += "# boundaries: names by place, since the file has none\n";
        }
    }
    text + "# keys and units: docs/scene_files.md"
}

/// A line, or several, with its name before it.
fn row(name: &str, value: impl ToString) -> String {
    let lines = value.to_string().replace('\n', &format!("\n{:<18} ", ""));
    format!("{name:<18} {lines}")
}

fn name(format: Format) -> &'static str {
    match format {
        Format::Gmsh41 => "Gmsh, MSH 4.1",
        Format::Gmsh22 => "Gmsh, MSH 2.2",
        Format::Medit => "Medit",
        Format::FreeFem => "FreeFEM",
        Format::Stl => "STL",
        Format::Vtu => "VTK, XML",
        Format::Vtk => "VTK, legacy",
        Format::Inp => "a deck of Abaqus or CalculiX",
    }
}

/// The numbers of elements by kind, the highest dimension first.
fn counted(kinds: &BTreeMap<ElementKind, usize>) -> String {
    let all = kinds.iter().rev();
    let all = all.map(|(kind, &count)| many(count, &kind.to_string()));
    all.collect::<Vec<_>>().join(", ")
}

/// A number of things.
fn many(count: usize, one: &str) -> String {
    match (count, one.strip_suffix("tetrahedron")) {
        (1, _) => format!("1 {one}"),
        (_, Some(nodes)) => format!("{count} {nodes}tetrahedra"),
        _ => format!("{count} {one}s"),
    }
}

/// Six digits of a number.
fn number(x: f64) -> String {
    let rounded = format!("{x:.5e}").parse().unwrap_or(x) + 0.0;
    match rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) {
        true => format!("{rounded}"),
        false => format!("{rounded:e}"),
    }
}

fn point<const D: usize>(x: &Vector<D>) -> String {
    let all: Vec<String> = x.iter().map(|&x| number(x)).collect();
    format!("({})", all.join(", "))
}

/// A string of TOML.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted += &format!("\\u{:04x}", c as u32),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

/// The volume of the simplex between these corners, negative where they are in the other order.
fn signed_volume<const D: usize>(corners: &[Vector<D>]) -> f64 {
    let edges = Matrix::<D>::from_fn(|i, j| corners[j + 1][i] - corners[0][i]);
    determinant(&edges) / if D == 2 { 2.0 } else { 6.0 }
}

/// The quality of the simplex between the corners of a cell, 1 where its sides are equal and 0 where it is flat: 4√3 A/Σl² in the plane,
/// 12 (3V)^{2/3}/Σl² in space, with its sides l; and l (UL).
fn quality<const D: usize>(corners: &[Vector<D>]) -> (f64, Vec<f64>) {
    let volume = signed_volume(corners).abs();
    let mut sides = Vec::new();
    for (i, a) in corners.iter().enumerate() {
        sides.extend(corners[..i].iter().map(|b| (a - b).norm()));
    }
    // in units of the longest side, whose square may be no number
    let longest = sides.iter().fold(0.0, |a: f64, b| a.max(*b));
    let squares: f64 = sides.iter().map(|l| (l / longest).powi(2)).sum();
    let volume = (0..D).fold(volume, |volume, _| volume / longest);
    let quality = match D {
        2 => 4.0 * 3.0_f64.sqrt() * volume / squares,
        _ => 12.0 * (3.0 * volume).powf(2.0 / 3.0) / squares,
    };
    (quality, sides)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_sides_have_quality_1() {
        let h = 3.0_f64.sqrt() / 2.0;
        let triangle = [[0.0, 0.0], [1.0, 0.0], [0.5, h]].map(Vector::<2>::from);
        assert!((quality(&triangle).0 - 1.0).abs() < 1e-12);
        // every second corner of a cube
        let corners = [
            [0.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 0.0, 1.0],
            [0.0, 1.0, 1.0],
        ];
        let (own, sides) = quality(&corners.map(Vector::<3>::from));
        assert!((own - 1.0).abs() < 1e-12 && sides.len() == 6);
        // sides 1, 1 and √2: 4√3 · 0.5/4; of any size
        for scale in [1.0, 1e-90, 1e90] {
            let half = [[0.0, 0.0], [scale, 0.0], [0.0, scale]].map(Vector::<2>::from);
            assert!((quality(&half).0 - h).abs() < 1e-12, "{scale}");
        }
    }

    #[test]
    fn numbers_and_strings_are_short_and_sound() {
        let all = [0.0, -0.0, 1.0 / 3.0, 2.0, 1e-9, 123_456.78, 1.5e7, -2e300];
        let told = [
            "0", "0", "0.333333", "2", "1e-9", "123457", "1.5e7", "-2e300",
        ];
        assert_eq!(all.map(number), told);
        assert_eq!(quoted("a\"b\\c\nd"), r#""a\"b\\c\u000ad""#);
        assert_eq!(many(2, "4-node tetrahedron"), "2 4-node tetrahedra");
    }
}

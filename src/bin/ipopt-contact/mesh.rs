//! `ipopt-contact mesh FILE`: what a mesh file has, and what a scene says of it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::ExitCode;

use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::contact_fem::mesh::read::{ElementKind, Format};
use ipopt_contact::contact_fem::mesh::write::save_freefem;
use ipopt_contact::contact_fem::output::record::print;
use ipopt_contact::contact_fem::tensor::Vector;
use ipopt_contact::contact_fem::{Mesh, MeshFile};

use crate::Words;

/// Cells of a quality below this are counted: a triangle with 6° between two equal sides is one.
const POOR: f64 = 0.2;

/// Prints what the file has; writes its bodies to another file where `--to` asks for it.
pub fn command(words: &[String]) -> Result<ExitCode, String> {
    let words = Words::parse("mesh", words, &["to"], &[])?;
    let path = words.only("one mesh file")?;
    let file = MeshFile::read(path).map_err(|why| why.to_string())?;
    print(row("file", format!("{path}: {}", name(file.format()))));
    print(row("elements", counted(&kinds(&file))));
    let dimensions = file.elements().iter().map(|of| of.kind.dimension());
    let dimension = dimensions.max().unwrap_or(0);
    let is_plane = || {
        let mut heights = file.vertices().iter().map(|x| x[2]);
        let first = heights.next();
        heights.all(|z| Some(z) == first)
    };
    let to = words.option("to").map(Path::new);
    match dimension {
        3 => told::<3>(path, &file, to)?,
        2 if is_plane() => told::<2>(path, &file, to)?,
        2 => {
            let surface =
                "triangles that are in no plane: no body, but an obstacle may have this surface";
            print(row("a surface", surface));
            print(row(
                "in a scene",
                format!("[[obstacle]]\nsurface = {path:?}"),
            ));
            refuse(to, "a surface")?;
        }
        _ => {
            print(row(
                "no cells",
                "a mesh has triangles in the plane, tetrahedra in space",
            ));
            refuse(to, "a file without cells")?;
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

/// A line, or several, with its name before it.
fn row(name: &str, value: impl ToString) -> String {
    let mut lines = value.to_string();
    lines = lines.replace('\n', &format!("\n{:<18} ", ""));
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

/// The numbers of elements by kind.
fn kinds(file: &MeshFile) -> BTreeMap<ElementKind, usize> {
    let mut kinds = BTreeMap::new();
    for of in file.elements() {
        *kinds.entry(of.kind).or_default() += of.len();
    }
    kinds
}

fn counted(kinds: &BTreeMap<ElementKind, usize>) -> String {
    let all = kinds.iter().rev().map(|(kind, &count)| match count {
        1 => format!("1 {kind}"),
        _ if *kind == ElementKind::Tetrahedron => format!("{count} 4-node tetrahedra"),
        _ if *kind == ElementKind::Tetrahedron10 => format!("{count} 10-node tetrahedra"),
        _ => format!("{count} {kind}s"),
    });
    all.collect::<Vec<_>>().join(", ")
}

fn told<const D: usize>(path: &str, file: &MeshFile, to: Option<&Path>) -> Result<(), String> {
    let bodies = file.bodies::<D>().map_err(|why| why.to_string())?;
    let own = file.elements().iter();
    let own = own.filter(|of| of.kind.dimension() == D);
    let used: BTreeSet<usize> = own.flat_map(|of| of.nodes.iter().copied()).collect();
    let place = if D == 2 { "the plane" } else { "space" };
    let count = bodies.len();
    let shared = "bodies share no nodes in a scene: state contact or a tie where they meet";
    print(row(
        "bodies",
        match count {
            1 => format!("1, in {place}"),
            _ => format!("{count}, in {place}; {shared}"),
        },
    ));
    for (name, mesh) in &bodies {
        print(String::new());
        body(name, mesh);
    }
    print(String::new());
    match file.vertices().len() - used.len() {
        0 => {}
        1 => print(row("left out", "1 vertex without a cell")),
        left => print(row("left out", format!("{left} vertices without a cell"))),
    }
    let all = used.iter().map(|&v| file.vertices()[v]);
    let places: BTreeSet<[u64; 3]> = all.map(|x| x.map(|x| (x + 0.0).to_bits())).collect();
    match used.len() - places.len() {
        0 => {}
        twice => print(row(
            "double",
            format!(
                "{twice} nodes are where others are: `merge-nodes` makes them one within a body"
            ),
        )),
    }
    print(row("in a scene", statements(path, &bodies)));
    if let Some(to) = to {
        let ending = if D == 2 { "msh" } else { "mesh" };
        if to.extension().and_then(|e| e.to_str()) != Some(ending) {
            let to = to.display();
            return Err(format!(
                "--to {to}: files in {place} are written as FreeFEM and Medit have them, with the ending .{ending}"
            ));
        }
        let meshes: Vec<&Mesh<D>> = bodies.iter().map(|(_, mesh)| mesh).collect();
        save_freefem(to, &meshes).map_err(|why| why.to_string())?;
        let straight = match meshes.iter().any(|mesh| mesh.order() == Order::Quadratic) {
            true => ", its corners alone: these formats have straight cells",
            false => "",
        };
        print(row("written", format!("{}{straight}", to.display())));
    }
    Ok(())
}

/// Prints the facts of a body.
fn body<const D: usize>(name: &str, mesh: &Mesh<D>) {
    let order = match mesh.order() {
        Order::Linear => "linear",
        Order::Quadratic => "quadratic",
    };
    let volume: f64 = (0..mesh.len()).map(|k| mesh.volume(k)).sum();
    let (of, unit) = if D == 2 {
        ("area", "UL²")
    } else {
        ("volume", "UL³")
    };
    let (cells, nodes) = (mesh.len(), mesh.nodes().len());
    print(row(
        "body",
        format!("`{name}`: {cells} {order} cells, {nodes} nodes, {of} {volume:.6} {unit}"),
    ));
    let (low, high) = mesh.bounding_box();
    let diagonal = (high - low).norm();
    let point = |x: &Vector<D>| {
        let all: Vec<String> = x.iter().map(|x| format!("{x:.6}")).collect();
        format!("({})", all.join(", "))
    };
    let metres = diagonal * 1e-3;
    print(row(
        "from, to",
        format!(
            "{} {} UL; the diagonal is {metres:.3} m if UL is mm",
            point(&low),
            point(&high)
        ),
    ));
    let parts = mesh.parts().len();
    if parts > 1 {
        print(row(
            "parts",
            format!("{parts}, which have no node in common"),
        ));
    }
    let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
    let (mut worst, mut at) = (f64::INFINITY, Vector::<D>::zeros());
    let mut poor = 0;
    for k in 0..cells {
        let corners: Vec<Vector<D>> = mesh.corners(k).iter().map(|&n| mesh.nodes()[n]).collect();
        let (quality, sides) = quality(&corners, mesh.volume(k));
        shortest = sides.iter().fold(shortest, |a, b| a.min(*b));
        longest = sides.iter().fold(longest, |a, b| a.max(*b));
        poor += usize::from(quality < POOR);
        if quality < worst {
            worst = quality;
            at = corners.iter().sum::<Vector<D>>() / corners.len() as f64;
        }
    }
    print(row(
        "sides of cells",
        format!("{shortest:.4e} to {longest:.4e} UL"),
    ));
    let bad = match poor {
        0 => String::new(),
        poor => format!("; {poor} below {POOR}"),
    };
    print(row(
        "worst cell",
        format!(
            "quality {worst:.3} at {}{bad} (1 has equal sides)",
            point(&at)
        ),
    ));
    let names: Vec<&str> = mesh.boundary_names().collect();
    let mut named = BTreeSet::new();
    for boundary in &names {
        let facets = mesh.boundary(boundary).unwrap_or_default();
        let count = facets.len();
        named.extend(facets.into_iter().map(|facet| {
            let mut facet = facet.to_vec();
            facet.sort_unstable();
            facet
        }));
        print(row(
            "boundary",
            format!("`{boundary}`: {}", facets_of(count)),
        ));
    }
    let all = mesh.exterior().len();
    if let Some(left @ 1..) = all.checked_sub(named.len()) {
        let what = "`boundaries` in a scene names these, for loads, supports or contact";
        print(row(
            "without a name",
            format!("{left} of {all} facets: {what}"),
        ));
    }
    for (inner, facets) in mesh.inner_facets() {
        print(row(
            "inside",
            format!("`{inner}`: {} within the body", facets_of(facets.len())),
        ));
    }
    let regions: Vec<String> = mesh
        .region_names()
        .map(|name| format!("`{name}`"))
        .collect();
    if !regions.is_empty() {
        print(row("regions", regions.join(", ")));
    }
}

fn facets_of(count: usize) -> String {
    match count {
        1 => "1 facet".into(),
        _ => format!("{count} facets"),
    }
}

/// The quality of a cell, which is 1 where its sides are equal and 0 where it is flat: 4√3 A/Σl² in the plane, 12 (3V)^{2/3}/Σl² in
/// space; and the lengths l of its straight sides (UL).
fn quality<const D: usize>(corners: &[Vector<D>], volume: f64) -> (f64, Vec<f64>) {
    let mut sides = Vec::new();
    for (i, a) in corners.iter().enumerate() {
        sides.extend(corners[..i].iter().map(|b| (a - b).norm()));
    }
    let squares: f64 = sides.iter().map(|l| l * l).sum();
    let quality = match D {
        2 => 4.0 * 3.0_f64.sqrt() * volume / squares,
        _ => 12.0 * (3.0 * volume).powf(2.0 / 3.0) / squares,
    };
    (quality, sides)
}

/// The lines of a scene file that these bodies begin with.
fn statements<const D: usize>(path: &str, bodies: &[(String, Mesh<D>)]) -> String {
    let mut text = String::new();
    for (name, mesh) in bodies {
        text += &format!("[[body]]\nname = {name:?}\nmesh = {path:?}\n");
        if bodies.len() > 1 {
            text += &format!("region = {name:?}\n");
        }
        text += "# law, young, poisson, supports, loads\n";
        if mesh.boundary_names().next().is_none() {
            text += "# boundaries: names by place, since the file has none\n";
        }
    }
    text + "# keys and units: docs/scene_files.md"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_sides_have_quality_1() {
        let h = 3.0_f64.sqrt() / 2.0;
        let triangle = [[0.0, 0.0], [1.0, 0.0], [0.5, h]].map(Vector::<2>::from);
        assert!((quality(&triangle, 0.5 * h).0 - 1.0).abs() < 1e-12);
        // four corners of a cube, of which the simplex fills a third
        let corners = [
            [0.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 0.0, 1.0],
            [0.0, 1.0, 1.0],
        ];
        let (own, sides) = quality(&corners.map(Vector::<3>::from), 1.0 / 3.0);
        assert!((own - 1.0).abs() < 1e-12 && sides.len() == 6);
        // sides 1, 1 and √2: 4√3 · 0.5/4
        let half = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Vector::<2>::from);
        assert!((quality(&half, 0.5).0 - h).abs() < 1e-12);
    }
}

//! Labels of facets and cells in a file that has numbers only.

use std::collections::{BTreeMap, BTreeSet};

use crate::mesh::Mesh;

/// The labels of the names of each body, in a file of all `bodies`: of boundaries and of
/// [`Mesh::inner_facets`].
///
/// A name keeps the label that it has in the file which the mesh is from, such as the number of
/// Gmsh's physical group. Else a name that is a whole number is its own label. Other names get
/// numbers from 1 in alphabetical order, a name the same in all bodies, and no number that is a
/// label already. Labels have 32 bits, as in FreeFEM.
pub fn boundary_labels<'a, const D: usize>(bodies: &[&'a Mesh<D>]) -> Vec<BTreeMap<&'a str, i32>> {
    let mut labels: Vec<BTreeMap<&str, i32>> = bodies.iter().map(|mesh| known(mesh)).collect();
    let used: BTreeSet<i32> = labels.iter().flat_map(|l| l.values().copied()).collect();
    let mut free = (1..).filter(|label| !used.contains(label));
    let all = bodies.iter().zip(&labels);
    let new: BTreeSet<&str> = all
        .flat_map(|(mesh, known)| names(mesh).filter(|name| !known.contains_key(name)))
        .collect();
    let new: BTreeMap<&str, i32> = new.into_iter().zip(&mut free).collect();
    for (mesh, labels) in bodies.iter().zip(&mut labels) {
        for name in names(mesh) {
            if let Some(&label) = new.get(name) {
                labels.entry(name).or_insert(label);
            }
        }
    }
    labels
}

/// The region of each body in a file of all.
pub(super) fn regions<const D: usize>(bodies: &[&Mesh<D>]) -> Vec<i32> {
    let used: BTreeSet<i32> = bodies.iter().filter_map(|mesh| mesh.region).collect();
    let mut free = (1..).filter(|region| !used.contains(region));
    let regions = bodies.iter();
    regions
        .filter_map(|mesh| mesh.region.or_else(|| free.next()))
        .collect()
}

/// The names of boundaries and inner facets; a name may come twice.
fn names<const D: usize>(mesh: &Mesh<D>) -> impl Iterator<Item = &str> {
    let inner = mesh.inner_facets().map(|(name, _)| name);
    mesh.boundary_names().chain(inner)
}

/// The labels that a mesh has by itself: from its file, or as names that are whole numbers.
fn known<const D: usize>(mesh: &Mesh<D>) -> BTreeMap<&str, i32> {
    let from_file = |name| Some((name, *mesh.labels.get(name)?));
    let mut known: BTreeMap<&str, i32> = names(mesh).filter_map(from_file).collect();
    let used: BTreeSet<i32> = known.values().copied().collect();
    for name in names(mesh) {
        let number = name.parse().ok().filter(|n: &i32| n.to_string() == name);
        if let Some(number) = number.filter(|n| !used.contains(n)) {
            known.entry(name).or_insert(number);
        }
    }
    known
}

//! What the tests of mesh files and the fuzzer share.

pub mod memory;
pub mod mutation;

use std::path::{Path, PathBuf};

use contact_fem::mesh::write::to_freefem;
use contact_fem::{Error, Mesh, MeshFile};

/// The folder of the meshes that other programs made.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes")
}

/// All mesh files there and in the folders below, by path, in order.
pub fn mesh_files() -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = Vec::new();
    let mut folders = vec![folder()];
    while let Some(folder) = folders.pop() {
        for entry in folder.read_dir().expect("a folder") {
            let path = entry.expect("an entry").path();
            let ending = path.extension().and_then(|e| e.to_str());
            if path.is_dir() {
                folders.push(path);
            } else if matches!(
                ending,
                Some("msh" | "mesh" | "meshb" | "stl" | "vtu" | "vtk" | "inp")
            ) {
                let bytes = std::fs::read(&path).expect("a file");
                files.push((path, bytes));
            }
        }
    }
    files.sort();
    files
}

/// Does with a file all that there is to do: reads it, makes bodies in the plane and in space, all
/// together and one by one, writes them, and says what is wrong. Gives whether it could be read, and
/// what was wrong.
pub fn read_fully(bytes: &[u8]) -> (bool, Vec<Error>) {
    let mut errors = Vec::new();
    let read = MeshFile::parse(bytes).map_err(|error| errors.push(error));
    if let Ok(file) = &read {
        errors.extend(file.bodies::<2>().and_then(written).err());
        errors.extend(file.bodies::<3>().and_then(written).err());
        for group in file.groups().iter().filter(|g| g.dimension > 1).take(3) {
            errors.extend(file.body::<2>(&group.name).err());
            errors.extend(file.body::<3>(&group.name).err());
        }
    }
    errors.iter().for_each(|error| drop(error.to_string()));
    (read.is_ok(), errors)
}

fn written<const D: usize>(bodies: Vec<(String, Mesh<D>)>) -> Result<(), Error> {
    let bodies: Vec<&Mesh<D>> = bodies.iter().map(|(_, mesh)| mesh).collect();
    to_freefem(&bodies).map(drop)
}

/// The memory that reading a file fully may take (bytes).
pub fn allowance(bytes: &[u8]) -> usize {
    100 * bytes.len() + (64 << 10)
}

//! What the tests of mesh files and the fuzzer share.
#![allow(dead_code)]

pub mod memory;
pub mod mutation;

use std::path::{Path, PathBuf};

use contact_fem::{Error, MeshFile};

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
            } else if matches!(ending, Some("msh" | "mesh" | "meshb")) {
                let bytes = std::fs::read(&path).expect("a file");
                files.push((path, bytes));
            }
        }
    }
    files.sort();
    files
}

/// Does with a file all that there is to do: reads it, makes bodies in the plane and in space, all
/// together and one by one, and says what is wrong.
pub fn read_fully(bytes: &[u8]) -> Result<MeshFile, Error> {
    let file = MeshFile::parse(bytes).inspect_err(|error| drop(error.to_string()))?;
    let say = |error: Error| drop(error.to_string());
    file.bodies::<2>().map_or_else(say, drop);
    file.bodies::<3>().map_or_else(say, drop);
    for group in file.groups().iter().take(3) {
        file.body::<2>(&group.name).map_or_else(say, drop);
        file.body::<3>(&group.name).map_or_else(say, drop);
    }
    Ok(file)
}

//! Files with random damage: whatever comes of them, nothing panics and nothing takes much more
//! memory than the file has bytes.

use crate::support::{
    self,
    mutation::{Random, damaged},
};

#[test]
fn truncated_files_never_panic() {
    for (path, bytes) in support::mesh_files() {
        if bytes.len() > 6 << 10 {
            continue;
        }
        let has_end = bytes.starts_with(b"$MeshFormat");
        for length in 0..bytes.len() {
            let (read, _) = support::read_fully(&bytes[..length]);
            // the last line of Gmsh's says that the file is complete; Medit's may be left out
            let incomplete = has_end && length < bytes.trim_ascii_end().len();
            assert!(!(read && incomplete), "{} {length}", path.display());
        }
    }
}

#[test]
fn damaged_files_never_panic() {
    let files: Vec<_> = support::mesh_files().into_iter().map(|f| f.1).collect();
    let mut random = Random(2026);
    for file in &files {
        for _ in 0..300 {
            let mut bad = file.clone();
            for _ in 0..1 + random.below(3) {
                bad = damaged(&bad, &files[random.below(files.len())], &mut random);
            }
            let (peak, _) = support::memory::peak_of(|| support::read_fully(&bad));
            assert!(peak < support::allowance(&bad), "{peak} of {}", bad.len());
        }
    }
}

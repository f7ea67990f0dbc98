//! The Ipopt in use, against the one this was compiled for.

use std::sync::Once;

use ipopt_sys::{HEADER_VERSION, library_version};

/// A version's major, minor and release number.
pub type Version = (u32, u32, u32);

/// Warns, once a process, if Ipopt has another C++ interface than its headers promised.
pub(super) fn warn_of_another() {
    static ONCE: Once = Once::new();
    if let Some(library) = library_version() {
        ONCE.call_once(|| {
            if let Some(message) = mismatch(HEADER_VERSION, library) {
                log::warn!(target: "ipopt", "{message}");
            }
        });
    }
}

/// As it is written, such as 3.14.19.
pub(super) fn dotted((major, minor, release): Version) -> String {
    format!("{major}.{minor}.{release}")
}

/// What is wrong with a library of this version; releases of one minor version may replace each other.
pub(super) fn mismatch(headers: Version, library: Version) -> Option<String> {
    ((headers.0, headers.1) != (library.0, library.1)).then(|| {
        format!(
            "compiled with the headers of Ipopt {}, but running with {}: rebuild, or point the loader at the other",
            dotted(headers),
            dotted(library)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn releases_may_differ_and_versions_may_not() {
        assert_eq!(mismatch((3, 14, 4), (3, 14, 19)), None);
        let message = mismatch((3, 11, 9), (3, 14, 19)).unwrap();
        assert!(message.contains("3.11.9") && message.contains("3.14.19"));
    }
}

//! The Ipopt in use, against the one this was compiled for.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

use ipopt_sys::{HEADER_VERSION, ipopt_shim_touch_blas, library_version};

use super::{Blas, BlasKind};
use crate::memory::{self, MemoryError, MemoryLeft};

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

/// What OpenBLAS takes at its first product (bytes), at most: 128 MiB on processors with AVX2, 32 MiB on others, and a margin.
const BUFFER: u64 = 144 << 20;

/// Whether the BLAS has its buffers.
static PREPARED: AtomicBool = AtomicBool::new(false);

/// Makes the BLAS take its buffers now, where a limit of the process may keep them from it later: OpenBLAS then asks for
/// them for ever, and nothing ends that.
pub(super) fn prepare_blas() -> Result<(), MemoryError> {
    if PREPARED.load(Ordering::Relaxed) {
        return Ok(());
    }
    if let Some(MemoryLeft { bytes, limit }) = memory::hard_limit() {
        let needed = blas_bytes();
        if bytes < needed {
            return Err(MemoryError::TooLittle {
                what: "OpenBLAS at its first call",
                needed,
                left: bytes,
                limit,
            });
        }
        // SAFETY: it has no arguments and keeps nothing.
        unsafe { ipopt_shim_touch_blas() };
        PREPARED.store(true, Ordering::Relaxed);
    }
    Ok(())
}

/// What the BLAS will take for its buffers (bytes).
pub(crate) fn blas_bytes() -> u64 {
    let has_buffers = |blas: Blas| matches!(blas.kind, BlasKind::OpenBlas | BlasKind::Unknown);
    match !PREPARED.load(Ordering::Relaxed) && Blas::loaded().is_none_or(has_buffers) {
        true => BUFFER,
        false => 0,
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

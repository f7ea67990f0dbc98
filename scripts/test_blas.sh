#!/usr/bin/env bash
# The tests with each BLAS that Debian has (reference, serial and threaded OpenBLAS), with what an old processor makes of
# OpenBLAS and the C library, and compiled for the processor at hand: no test may depend on round-off. The libraries are
# unpacked aside, never installed.
#
# `make test-blas`, or `scripts/test_blas.sh -p contact-core` for the tests of one package.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '%s\n' "$*" >&2; }
fail() { say "error: $*"; exit 1; }

target=${CARGO_TARGET_DIR:-$PWD/target}
[[ $target == /* ]] || target=$PWD/$target
export CARGO_TARGET_DIR=$target
aside=$target/blas
selection=("$@")
((${#selection[@]} > 0)) || selection=(--workspace --lib --bins --tests)

# The folders of libblas.so.3 and liblapack.so.3 in a list of packages.
fetch() {
    local package place=$aside/$1
    if [[ ! -e $place/unpacked ]]; then
        command -v apt-get >/dev/null 2>&1 && command -v dpkg-deb >/dev/null 2>&1 ||
            fail "the libraries are Debian's, and there is no apt-get to fetch them with"
        rm -rf "$place"
        mkdir -p "$place/debs"
        (cd "$place/debs" && apt-get download -qq "$@" </dev/null >&2) ||
            fail "no $* on offer here (try 'apt-get update')"
        for package in "$place"/debs/*.deb; do
            dpkg-deb --extract "$package" "$place"
        done
        rm -rf "$place/debs"
        touch "$place/unpacked"
    fi
    find "$place" \( -name libblas.so.3 -o -name liblapack.so.3 \) -printf '%h\n' | sort -u | paste -s -d :
}

# run NAME FOLDERS: all tests with the libraries in these folders.
run() {
    local name=$1 folders=$2 blas log=$aside/$1.log
    blas=$(LD_LIBRARY_PATH=$folders cargo run --quiet -p contact-core --example doctor </dev/null | grep -m 1 -i blas) ||
        fail "$name: Ipopt's doctor names no BLAS"
    [[ $blas == *"${folders%%:*}"* ]] || fail "$name: another BLAS was loaded: $blas"
    say "$name: $blas"
    LD_LIBRARY_PATH=$folders cargo test "${selection[@]}" --no-fail-fast </dev/null >"$log" 2>&1 ||
        fail "$name: $(grep -E '^test .* FAILED$|^error' "$log" || true) (all of it: $log)"
    say "$name: $(awk '/^test result: ok\./ { sum += $4 } END { print sum + 0 }' "$log") tests passed"
}

reference=$(fetch libblas3 liblapack3)
serial=$(fetch libopenblas0-serial)
threaded=$(fetch libopenblas0-pthread)

run reference "$reference"
run serial "$serial"
OPENBLAS_NUM_THREADS=2 run threaded "$threaded"
OPENBLAS_CORETYPE=Nehalem GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX run old "$serial"
RUSTFLAGS="-C target-cpu=native" CARGO_TARGET_DIR=$aside/native run native "$serial"
say "All tests pass with each of them."

#!/usr/bin/env bash
# Checks the workspace with the oldest Rust it promises to build with: one that rustup has installed or, on Debian 12,
# the distribution's own packages of that version, unpacked aside and never installed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

version=1.85
package_version='1.85.0+dfsg3-1~deb12u3'
aside=${CARGO_TARGET_DIR:-$PWD/target}/msrv
[[ $aside == /* ]] || aside=$PWD/$aside
export CARGO_TARGET_DIR=$aside/build

# rustc, cargo and the standard library, and the libraries these are linked to.
packages=("rustc-web=$package_version" "cargo-web=$package_version" "libstd-rust-web-$version=$package_version"
    "libstd-rust-web-dev=$package_version" libllvm19 libpcre3 libhttp-parser2.9 libcurl4 libssh2-1 libz3-4 libedit2)

say() { printf '%s\n' "$*" >&2; }
fail() { say "error: $*"; exit 1; }

unpack() {
    command -v dpkg-deb >/dev/null 2>&1 && command -v apt-get >/dev/null 2>&1 ||
        fail "no Rust $version here, and no apt-get to fetch one with: 'rustup toolchain install $version' gives one"
    rm -rf "$aside/root" "$aside/debs"
    mkdir -p "$aside/debs"
    (cd "$aside/debs" && apt-get download -qq "${packages[@]}" </dev/null >&2) ||
        fail "Rust $version is not on offer here. Debian 12 has it (try 'apt-get update'); elsewhere, \
'rustup toolchain install $version' gives one"
    local deb
    for deb in "$aside"/debs/*.deb; do
        dpkg-deb --extract "$deb" "$aside/root"
    done
    rm -rf "$aside/debs"
    # Nothing but these two shall see the libraries that came with them.
    local libraries tool
    libraries=$(find "$aside/root" -maxdepth 3 -type d -name '*-linux-gnu*' -printf '%p:')
    mkdir -p "$aside/bin"
    for tool in rustc cargo; do
        printf '#!/bin/sh\nLD_LIBRARY_PATH="%s" exec "%s" "$@"\n' "${libraries%:}" "$aside/root/usr/bin/$tool" \
            >"$aside/bin/$tool"
        chmod +x "$aside/bin/$tool"
    done
    "$aside/bin/rustc" --version >/dev/null && "$aside/bin/cargo" --version >/dev/null ||
        fail "the unpacked Rust does not start"
    touch "$aside/unpacked-$package_version"
}

toolchain=
if command -v rustup >/dev/null 2>&1; then
    toolchain=$(rustup toolchain list | grep -oE "^$version(\.[0-9]+)?-[^ ]+" | head -n 1) || true
fi
if [[ -n $toolchain ]]; then
    cargo=(rustup run "$toolchain" cargo)
    rustc=$(rustup which --toolchain "$toolchain" rustc)
else
    [[ -e $aside/unpacked-$package_version ]] || unpack
    cargo=("$aside/bin/cargo")
    rustc=$aside/bin/rustc
fi
export RUSTC=$rustc
say "$("$RUSTC" --version), $("${cargo[@]}" --version)"
"${cargo[@]}" check --workspace --all-features
say "The workspace compiles with Rust $version."

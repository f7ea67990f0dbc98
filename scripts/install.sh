#!/usr/bin/env bash
# Installs what is missing to build and run this project on Debian or Ubuntu, and nothing else: Ipopt, a fast BLAS,
# pkg-config, a C++ compiler and libclang. Says nothing and touches nothing when all is there.
set -euo pipefail

say() { printf '%s\n' "$*" >&2; }
fail() { say "error: $*"; exit 1; }
has() { command -v "$1" >/dev/null 2>&1; }

# libclang wherever bindgen would look for it.
has_libclang() {
    local place
    [[ -n ${LIBCLANG_PATH:-} ]] && return 0
    has llvm-config && return 0
    for place in /usr/lib/llvm-*/lib /usr/lib/*-linux-gnu /usr/lib64 /usr/lib /usr/local/lib; do
        compgen -G "$place/libclang.so*" >/dev/null && return 0
        compgen -G "$place/libclang-*.so*" >/dev/null && return 0
    done
    return 1
}

# The BLAS the loader picks. The reference one works, but takes several times as long.
has_fast_blas() {
    local blas
    blas=$(PATH=$PATH:/sbin:/usr/sbin ldconfig -p 2>/dev/null | awk '/libblas\.so\.3/ { print $NF; exit }') || return 0
    [[ -n $blas ]] || return 1
    [[ $(readlink -f "$blas") != */blas/libblas.so.3* ]]
}

missing=()
has pkg-config || missing+=(pkg-config)
has c++ || has g++ || has clang++ || missing+=(g++)
has_libclang || missing+=(libclang-dev)
{ has pkg-config && pkg-config --exists ipopt; } || missing+=(coinor-libipopt-dev)
if [[ $(uname -s) == Linux ]]; then
    has_fast_blas || missing+=(libopenblas0-serial)
fi

has cargo || fail "no cargo: install Rust 1.85 or later first"
if [[ ${#missing[@]} -eq 0 ]]; then
    exit 0
fi

has apt-get || fail "missing: ${missing[*]} (names of Debian packages). There is no apt-get here to install them with; \
please use your system's own packages"

root=()
if [[ $(id -u) -ne 0 ]]; then
    has sudo || fail "missing: ${missing[*]}. Installing them takes root: run 'apt-get install ${missing[*]}' as root, \
then try again"
    root=(sudo)
fi

say "Installing ${missing[*]}"
install=("${root[@]}" env DEBIAN_FRONTEND=noninteractive
    apt-get install --yes --no-install-recommends "${missing[@]}")
# Package lists may be absent or out of date: refresh them once, and only if need be.
"${install[@]}" </dev/null || {
    "${root[@]}" apt-get update </dev/null
    "${install[@]}" </dev/null
}

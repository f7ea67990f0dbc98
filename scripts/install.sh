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

# Whether the loader picks a BLAS other than the reference one, which works but takes several times as long.
has_fast_blas() {
    local blas
    blas=$(PATH=$PATH:/sbin:/usr/sbin ldconfig -p 2>/dev/null |
        awk '/libblas\.so\.3/ && !path { path = $NF } END { print path }') || return 0
    [[ -n $blas && $(readlink -f "$blas") != */blas/libblas.so.3* ]]
}

has cargo || fail "no cargo: install Rust 1.85 or later first"

missing=()
has pkg-config || missing+=(pkg-config)
has c++ || has g++ || has clang++ || missing+=(g++)
has_libclang || missing+=(libclang-dev)
{ has pkg-config && pkg-config --exists ipopt; } || missing+=(coinor-libipopt-dev)
needed=${#missing[@]}
if [[ $(uname -s) == Linux ]]; then
    has_fast_blas || missing+=(libopenblas0-serial)
fi
[[ ${#missing[@]} -gt 0 ]] || exit 0

# Ends here for want of means to install; without a fast BLAS things are slow, but they work.
give_up() {
    [[ $needed -eq 0 ]] || fail "$*"
    say "warning: $*"
    exit 0
}

has apt-get || give_up "missing: ${missing[*]} (names of Debian packages), and there is no apt-get to install them \
with; please use your system's own packages"

root=()
if [[ $(id -u) -ne 0 ]]; then
    has sudo || give_up "missing: ${missing[*]}. Installing them takes root, and there is no sudo: run \
'apt-get install ${missing[*]}' as root"
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

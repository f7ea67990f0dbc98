#!/usr/bin/env bash
# Installs what is missing to build and run this project on Debian or Ubuntu, and nothing else: Ipopt, pkg-config and a
# C++ compiler, which it takes, and a fast BLAS and libclang, which it can do without. Says nothing and touches nothing
# when all is there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '%s\n' "$*" >&2; }
fail() { say "error: $*"; exit 1; }
has() { command -v "$1" >/dev/null 2>&1; }

# Where the build looks for libclang: in LIBCLANG_PATH, a file or a folder, or else everywhere. libclang-cpp is another
# library.
libclang_candidates() {
    local place places=("${LIBCLANG_PATH:-}")
    if [[ -z ${LIBCLANG_PATH:-} ]]; then
        mapfile -t -d : places <<<"${LD_LIBRARY_PATH:-}:${LIBRARY_PATH:-}"
        has llvm-config && places+=("$(llvm-config --libdir)")
        places+=(/usr/local/lib* /usr/lib*/llvm*/lib /usr/lib*/*-linux-gnu /usr/lib*)
    fi
    for place in "${places[@]}"; do
        [[ ! -f $place ]] || printf '%s\n' "$place"
        compgen -G "${place%$'\n'}/libclang[.-]*so*" || true
    done | { grep -v -e -cpp || true; }
}

# Whether one of them loads and reads C. Asking it takes a C compiler; without one, the name has to do.
has_libclang() {
    local candidates candidate arguments probe status=1
    mapfile -t candidates < <(libclang_candidates)
    ((${#candidates[@]} > 0)) || return 1
    probe=$(mktemp)
    if cc -o "$probe" scripts/libclang_probe.c -ldl 2>/dev/null; then
        read -r -a arguments <<<"${BINDGEN_EXTRA_CLANG_ARGS:-}"
        for candidate in "${candidates[@]}"; do
            "$probe" "$candidate" scripts/libclang_probe.c "${arguments[@]}" 2>/dev/null && status=0 && break
        done
    else
        status=0
    fi
    rm -f "$probe"
    return "$status"
}

# Whether the loader picks a BLAS other than the reference one, which works but takes several times as long.
has_fast_blas() {
    local blas
    blas=$(PATH=$PATH:/sbin:/usr/sbin ldconfig -p 2>/dev/null |
        awk '/libblas\.so\.3/ && !path { path = $NF } END { print path }') || return 0
    [[ -n $blas && $(readlink -f "$blas") != */blas/libblas.so.3* ]]
}

has cargo || fail "no cargo: install Rust 1.85 or later first"

# Names of Debian packages: what it takes, and what it can do without.
needed=() wanted=()
has pkg-config || needed+=(pkg-config)
has c++ || has g++ || has clang++ || needed+=(g++)
{ has pkg-config && pkg-config --exists ipopt; } || needed+=(coinor-libipopt-dev)
without=
if ! has_libclang; then
    wanted+=(libclang-dev)
    without+=" Without libclang the bindings kept for Ipopt 3.11 to 3.14 are used."
fi
if [[ $(uname -s) == Linux ]] && ! has_fast_blas; then
    wanted+=(libopenblas0-serial)
    without+=" Without a fast BLAS, large scenes take several times as long."
fi
missing=("${needed[@]}" "${wanted[@]}")
((${#missing[@]} > 0)) || exit 0

# Ends here for want of means to install: an error where something is needed.
give_up() {
    ((${#needed[@]} == 0)) || fail "$*"
    say "warning: $*$without"
    exit 0
}

has apt-get || give_up "missing: ${missing[*]} (names of Debian packages), and there is no apt-get to install them \
with; please use your system's own packages."

root=()
if [[ $(id -u) -ne 0 ]]; then
    has sudo || give_up "missing: ${missing[*]}. Installing them takes root, and there is no sudo: run \
'apt-get install ${missing[*]}' as root."
    root=(sudo)
fi

install() {
    "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "$@" </dev/null
}

say "Installing ${missing[*]}"
install "${missing[@]}" && exit 0
# Package lists may be absent or out of date: refresh them once, and only if need be.
"${root[@]}" apt-get update </dev/null || true
install "${missing[@]}" && exit 0
((${#needed[@]} == 0)) || install "${needed[@]}"
say "warning: could not install ${wanted[*]}.$without"

# Sourced by other scripts: fetches a binary Ipopt 3.14 with its headers, unpacks it aside and never installs it, and
# points pkg-config and the loader at it. It comes from the Python wheel of CasADi, which carries one.
# shellcheck shell=bash

casadi=${CASADI_VERSION:-3.8.2}
aside=${CARGO_TARGET_DIR:-$PWD/target}/ipopt-3.14
[[ $aside == /* ]] || aside=$PWD/$aside

say() { printf '%s\n' "$*" >&2; }
fail() { say "error: $*"; exit 1; }

fetch_ipopt_3_14() {
    local python place
    [[ -e $aside/unpacked-$casadi ]] && return 0
    for python in python3 python; do
        "$python" -m pip --version >/dev/null 2>&1 && break
        python=
    done
    [[ -n $python ]] || fail "fetching a binary Ipopt 3.14 takes Python with pip (Debian, Ubuntu: python3-pip)"
    say "Fetching the wheel of CasADi $casadi, which carries Ipopt 3.14"
    place=$aside/wheel
    rm -rf "$place"
    mkdir -p "$place"
    "$python" -m pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: --dest "$place" \
        "casadi==$casadi" </dev/null || fail "no wheel of CasADi $casadi for this machine"
    "$python" -m zipfile -e "$place"/casadi-*.whl "$place" || fail "the wheel could not be unpacked"
    rm "$place"/casadi-*.whl
    touch "$aside/unpacked-$casadi"
}

# Its version as the headers tell it, for a .pc file that pkg-config can read.
use_ipopt_3_14() {
    local root=$aside/wheel/casadi headers
    fetch_ipopt_3_14
    headers=$root/include/coin-or
    [[ -e $root/libipopt.so && -e $headers/IpoptConfig.h ]] || fail "the wheel has no libipopt with headers"
    ipopt_version=$(sed -n 's/^#define IPOPT_VERSION "\(.*\)"$/\1/p' "$headers/IpoptConfig.h")
    [[ $ipopt_version == 3.14.* ]] || fail "the wheel carries Ipopt $ipopt_version, not 3.14"
    mkdir -p "$aside/pkgconfig"
    printf '%s\n' "libdir=$root" 'Name: IPOPT' 'Description: Interior Point Optimizer' "Version: $ipopt_version" \
        "Libs: -L\${libdir} -lipopt" "Cflags: -I$headers" >"$aside/pkgconfig/ipopt.pc"
    export PKG_CONFIG_PATH=$aside/pkgconfig
    export LD_LIBRARY_PATH=$root${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
    # Apart from the build against the installed Ipopt, so that neither is made anew for the other.
    export CARGO_TARGET_DIR=$aside/build
}

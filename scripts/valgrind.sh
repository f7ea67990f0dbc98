#!/usr/bin/env bash
# Runs the tests of the Ipopt binding under Valgrind's memcheck: those of ipopt-sys, and contact-core's of the driver.
# Any invalid access, any use of a value that was never set and any memory definitely lost is an error, in processes
# that the tests start as well. valgrind.supp has what is Ipopt's own; with Debian 12's libraries nothing else is needed.
#
# `make valgrind`, or `scripts/valgrind.sh hs071 version` for the test programs of these names only.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Fewer tests than this means that some went missing.
floor=40

say() { printf '%s\n' "$*" >&2; }
fail() { say "error: $*"; exit 1; }

install_valgrind() {
    local root=()
    command -v valgrind >/dev/null 2>&1 && return 0
    command -v apt-get >/dev/null 2>&1 ||
        fail "valgrind is missing, and there is no apt-get to install it with; please use your system's own package"
    if [[ $(id -u) -ne 0 ]]; then
        command -v sudo >/dev/null 2>&1 || fail "valgrind is missing: run 'apt-get install valgrind' as root"
        root=(sudo)
    fi
    say "Installing valgrind"
    local install=("${root[@]}" env DEBIAN_FRONTEND=noninteractive
        apt-get install --yes --no-install-recommends valgrind libc6-dbg)
    "${install[@]}" </dev/null || {
        "${root[@]}" apt-get update </dev/null
        "${install[@]}" </dev/null
    }
}

install_valgrind
logs=${CARGO_TARGET_DIR:-$PWD/target}/valgrind
[[ $logs == /* ]] || logs=$PWD/$logs
rm -rf "$logs"
mkdir -p "$logs"

build=(cargo test -p ipopt-contact-sys -p contact-core --features contact-core/ipopt --lib --tests --no-run)
"${build[@]}" </dev/null
# Cargo names the programs it has built on lines such as: Executable tests/hs071.rs (target/debug/deps/hs071-0123)
mapfile -t programs < <("${build[@]}" </dev/null 2>&1 | sed -n 's/^ *Executable .*(\(.*\))$/\1/p')
((${#programs[@]} > 0)) || fail "no test programs were built"

suppressions=$PWD/scripts/valgrind.supp

# The tests run in the directory of their package, as cargo would have it.
directory_of() {
    if [[ $1 == ipopt_sys || -e ipopt-sys/tests/$1.rs ]]; then echo ipopt-sys; else echo contact-core; fi
}

total=0 checked=0 processes=0
for program in "${programs[@]}"; do
    program=$(realpath "$program")
    name=$(basename "$program")
    name=${name%-*}
    if (($# > 0)) && [[ " $* " != *" $name "* ]]; then
        continue
    fi
    if (($# == 0)) && [[ $name == build_script ]]; then
        say "$name: left out, as it runs compilers and nothing of Ipopt"
        continue
    fi
    if (($# == 0)) && [[ $name == ipopt_doctor ]]; then
        say "$name: left out, as it measures allocations, which are memcheck's here, and factorises large matrices"
        continue
    fi
    if (($# == 0)) && [[ $name == ipopt_memory ]]; then
        say "$name: left out, as it limits the address space, most of which is memcheck's here"
        continue
    fi
    if (($# == 0)) && [[ $name == fuzz_binding ]]; then
        say "$name: left out, as its hundreds of solves run in other processes under a limit of time"
        continue
    fi
    tests=$("$program" --list </dev/null | grep -c ': test$') || true
    if ((tests == 0)); then
        say "$name: has no tests of its own"
        continue
    fi
    status=0
    # Its own messages go to files, one a process: some tests look at what is printed.
    (cd "$(directory_of "$name")" &&
        valgrind --tool=memcheck --error-exitcode=99 --leak-check=full --errors-for-leak-kinds=definite \
            --show-leak-kinds=definite --suppressions="$suppressions" --trace-children=yes --num-callers=30 \
            --log-file="$logs/$name.%p.memcheck" \
            "$program" --test-threads=1) </dev/null >"$logs/$name.out" 2>&1 || status=$?
    if ((status != 0)); then
        cat "$logs/$name.out" "$logs/$name".*.memcheck >&2
        fail "$name: exit status $status (99 is memcheck's); its files are in $logs"
    fi
    # A solver library that ends the process does so with exit status 0: the program must have come to its last line.
    passed=$(awk '/^test result: ok\./ { print $4 }' "$logs/$name.out")
    [[ $passed == "$tests" ]] || fail "$name: ${passed:-none} of $tests tests passed; see $logs/$name.out"
    for log in "$logs/$name".*.memcheck; do
        # A process that only became another program has no summary of its own.
        grep -q 'ERROR SUMMARY:' "$log" || continue
        grep -q 'ERROR SUMMARY: 0 errors' "$log" || { cat "$log" >&2; fail "$name: errors, see $log"; }
        processes=$((processes + 1))
    done
    say "$name: $passed tests, no error, nothing definitely lost"
    total=$((total + passed)) checked=$((checked + 1))
done
(($# > 0 || total >= floor)) || fail "at least $floor tests should have run, and $total did"
((total > 0)) || fail "no test program of these names: $*"
say "valgrind: $total tests of $checked programs in $processes processes: no error, no definite leak."

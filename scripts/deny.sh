#!/usr/bin/env bash
# Licences, versions and sources of the crates below, and their known defects where the database of these can be had.
# cargo-deny is a program of its own, installed into the target folder where it is missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '%s\n' "$*" >&2; }

if ! cargo deny --version >/dev/null 2>&1; then
    tools=${CARGO_TARGET_DIR:-$PWD/target}/tools
    if [[ ! -x $tools/bin/cargo-deny ]]; then
        say "Installing cargo-deny in $tools"
        CARGO_TARGET_DIR=$tools/build cargo install --debug --quiet --locked --version 0.20.2 --root "$tools" cargo-deny </dev/null
        rm -rf "$tools/build"
    fi
    PATH=$tools/bin:$PATH
fi

cargo deny check licenses bans sources
if timeout 120 cargo deny fetch db </dev/null >/dev/null 2>&1; then
    cargo deny --offline check advisories
else
    say "Known defects were not looked for: their database cannot be had from here."
fi

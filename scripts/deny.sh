#!/usr/bin/env bash
# Licences, versions and sources of the crates below, and their known defects where the database of these can be had.
# cargo-deny is a program of its own, installed beside cargo where it is missing, so that the next checkout has it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '%s\n' "$*" >&2; }

if ! cargo deny --version >/dev/null 2>&1; then
    say "Installing cargo-deny beside cargo"
    # In a folder of its own, which is removed afterwards.
    env -u CARGO_TARGET_DIR cargo install --debug --quiet --locked --version 0.20.2 cargo-deny </dev/null
    PATH=${CARGO_HOME:-$HOME/.cargo}/bin:$PATH
fi

cargo deny check licenses bans sources
if timeout 120 cargo deny fetch db </dev/null >/dev/null 2>&1; then
    cargo deny --offline check advisories
else
    say "Known defects were not looked for: their database cannot be had from here."
fi

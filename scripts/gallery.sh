#!/usr/bin/env bash
# Runs all scenes of the gallery, and leaves their pictures in docs/gallery: scripts/gallery.sh [PROGRAM [FOLDER]]
# PROGRAM is `ipopt-contact` (target/release/ipopt-contact), FOLDER that of the results (out/gallery).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

program=${1:-target/release/ipopt-contact}
folder=${2:-out/gallery}

say() { printf '%s\n' "$*" >&2; }
fail() { say "error: $*"; exit 1; }

[[ -x $program ]] || fail "$program is not a program: run \`cargo build --release --bin ipopt-contact\`, or name another one"
for tool in rsvg-convert pngquant; do
    command -v "$tool" >/dev/null || fail "$tool is missing: apt-get install librsvg2-bin pngquant"
done
mkdir -p "$folder" docs/gallery
failed=()
for scene in examples/gallery/*.toml; do
    name=$(basename "$scene" .toml)
    say "$name"
    if ! "$program" run "$scene" --out "$folder/$name" >"$folder/$name.txt" 2>&1; then
        failed+=("$name")
        tail -n 40 "$folder/$name.txt" >&2
        continue
    fi
    grep -E '^ *(warning|note)' "$folder/$name.txt" >&2 || true
    # 32 colours do for a map of stress, and take a fifth of the space
    rsvg-convert --width 560 "$folder/$name/meshes.svg" | pngquant --speed 1 32 - >"docs/gallery/$name.png"
done
((${#failed[@]} == 0)) || fail "not complete and certified: ${failed[*]}"

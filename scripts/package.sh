#!/usr/bin/env bash
# Packages each crate that is published, and compiles them from the packages alone; then their documentation as docs.rs
# makes it, where there is no Ipopt. The packages are left in target/package.
#
# `cargo package` can verify crates that depend on each other, too, but compiles a changed one of the same version
# against the sources of others that it has once unpacked.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

crates=(ipopt-contact-sys contact-core contact-fem ipopt-contact)

say() { printf '%s\n' "$*" >&2; }
fail() { say "error: $*"; exit 1; }

export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target}
[[ $CARGO_TARGET_DIR == /* ]] || CARGO_TARGET_DIR=$PWD/$CARGO_TARGET_DIR
# As in the workspace, so that what `make lint` has checked of other crates serves here, too.
export CARGO_PROFILE_DEV_OPT_LEVEL=2 CARGO_PROFILE_DEV_LTO=off
place=$CARGO_TARGET_DIR/package/unpacked

cargo package --no-verify --allow-dirty "${crates[@]/#/--package=}" 2>&1 </dev/null |
    grep -v '^warning: ignoring .* is not included in the published package$' >&2
rm -rf "$place"
mkdir -p "$place"
cp Cargo.lock "$place"
members=
patches=
for crate in "${crates[@]}"; do
    file=$(ls "$CARGO_TARGET_DIR/package/$crate"-[0-9]*.crate)
    tar --extract --gzip --directory "$place" --file "$file"
    folder=$(basename "$file" .crate)
    for needed in README.md LICENSE-MIT LICENSE-APACHE; do
        [[ -s $place/$folder/$needed ]] || fail "the package of $crate has no $needed"
    done
    members+="\"$folder\", "
    patches+="$crate = { path = \"$folder\" }"$'\n'
done
printf '[workspace]\nresolver = "3"\nmembers = [%s]\n\n[patch.crates-io]\n%s' "$members" "$patches" >"$place/Cargo.toml"
cd "$place"
say "Checking the packages"
cargo check --workspace --all-features
say "Making the documentation without Ipopt"
DOCS_RS=1 PKG_CONFIG_PATH='' PKG_CONFIG_LIBDIR=/nonexistent RUSTDOCFLAGS="-D warnings" \
    cargo doc --workspace --no-deps --all-features
say "The packages are complete: $CARGO_TARGET_DIR/package"

#!/usr/bin/env bash
# Makes the bindings kept in ipopt-sys/src anew: from the headers of the Ipopt that is installed, and from those of a
# binary Ipopt 3.14, so that on Debian 12 both releases are covered.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/ipopt_3_14.sh

update() { UPDATE_BINDINGS=1 cargo test --quiet -p ipopt-contact-sys --test kept_bindings are_what_the_headers_give; }

update
use_ipopt_3_14
update
# Both are written now: check them together.
cargo test --quiet -p ipopt-contact-sys --test kept_bindings

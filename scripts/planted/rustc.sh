#!/bin/sh
# The compiler of this workspace's crates for `make planted`: with the faults. Crates below are those of every other build.
compiler=$1
shift
exec "$compiler" "$@" --cfg planted

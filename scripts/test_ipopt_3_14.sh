#!/usr/bin/env bash
# The tests of the Ipopt binding with a binary Ipopt 3.14 in place of the installed one, and proof that they ran and
# with which.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/ipopt_3_14.sh

use_ipopt_3_14
log=$aside/test.log
mkdir -p "$aside"
: >"$log"

run() { cargo "$@" </dev/null 2>&1 | tee -a "$log"; }

run test -p ipopt-contact-sys -p contact-core --features contact-core/ipopt
run test -p ipopt-contact-sys -p contact-core --no-default-features --features contact-core/ipopt --tests

# A solver library that ends the process may do so with exit status 0: every test program must come to its last line.
# Documentation that must not compile has a result of its own.
started=$(grep -cE '^ +(Running|Doc-tests) ' "$log")
ended=$(awk '/^ +(Running|Doc-tests) / { open = 1 } /^test result: ok\./ { n += open; open = 0 } END { print n + 0 }' "$log")
passed=$(awk '/^test result: ok\./ { sum += $4 } END { print sum + 0 }' "$log")
[[ $started == "$ended" ]] || fail "$started test programs started and $ended came to a good end"
((passed >= 80)) || fail "only $passed tests ran"
# What the library itself said when a test asked it.
banner=$(grep -oE 'This is Ipopt version .*' "$log" | sort -u)
[[ $banner == *"version $ipopt_version"* ]] || fail "the tests ran with another Ipopt than $ipopt_version: $banner"
say "$passed tests passed. $banner ($aside/wheel/casadi/libipopt.so)."

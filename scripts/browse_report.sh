#!/usr/bin/env bash
# Opens the pages of a report in Debian's Chromium, which it installs where that is missing, and tells what is wrong:
# scripts/browse_report.sh [FOLDER] [--picture FILE.png]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

missing=()
for program in chromium python3; do
    command -v "$program" >/dev/null || missing+=("$program")
done
root=()
[[ $(id -u) -eq 0 ]] || root=(sudo)
install() {
    "${root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install --yes --no-install-recommends "${missing[@]}" </dev/null >&2
}
if ((${#missing[@]} > 0)); then
    printf 'Installing %s\n' "${missing[*]}" >&2
    install || { "${root[@]}" apt-get update </dev/null >&2 && install; }
fi
exec scripts/browse_report.py "$@"

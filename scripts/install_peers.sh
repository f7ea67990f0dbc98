#!/usr/bin/env bash
# Installs what is missing of the programs that `make report-peers` compares with, on Debian: Gmsh for the meshes, GetFEM, CalculiX and
# FreeFEM with its plugins. Nothing else needs them.
set -euo pipefail

missing=()
for package in gmsh python3-getfem python3-scipy calculix-ccx freefem++ libfreefem++; do
    [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) == installed ]] || missing+=("$package")
done
((${#missing[@]} > 0)) || exit 0
root=()
[[ $(id -u) -eq 0 ]] || root=(sudo)
install() {
    "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "${missing[@]}" </dev/null
}
printf 'Installing %s\n' "${missing[*]}" >&2
install || { "${root[@]}" apt-get update </dev/null && install; }

#!/usr/bin/env bash
# Makes the meshes of this folder anew. The tests read what is kept; they need neither program.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

mesh() { gmsh -v 1 "$@" >/dev/null; }

for order in 1 2; do
    for name in blocks bricks; do
        dimension=$([[ $name == blocks ]] && echo 2 || echo 3)
        made=(-"$dimension" -order "$order" "$name.geo")
        mesh "${made[@]}" -format msh41 -o "$name.$order.v41.msh"
        mesh "${made[@]}" -format msh41 -bin -o "$name.$order.v41.bin.msh"
        mesh "${made[@]}" -format msh22 -o "$name.$order.v22.msh"
        mesh "${made[@]}" -format msh22 -bin -o "$name.$order.v22.bin.msh"
        mesh "${made[@]}" -format mesh -o "$name.$order.mesh"
        mesh "${made[@]}" -format inp -o "$name.$order.inp"
        mesh "${made[@]}" -format vtk -o "$name.$order.vtk"
        mesh "${made[@]}" -format vtk -bin -o "$name.$order.bin.vtk"
    done
done
# Everything is saved, groups or not; nodes come with their parameters.
mesh -2 blocks.geo -save_all -format msh41 -o saved_all.v41.msh
mesh -2 blocks.geo -save_parametric -format msh41 -o parametric.v41.msh
mesh -3 bricks.geo -save_parametric -format msh41 -bin -o parametric.v41.bin.msh
mesh -2 blocks.geo -save_parametric -format msh22 -o parametric.v22.msh
mesh -2 blocks.geo -save_parametric -format msh22 -bin -o parametric.v22.bin.msh
# Refused: partitions, quadrilaterals, other versions and orders.
mesh -2 blocks.geo -part 2 -format msh41 -o partitioned.v41.msh
mesh -2 blocks.geo -part 2 -format msh22 -o partitioned.v22.msh
mesh -2 blocks.geo -setnumber Mesh.RecombineAll 1 -format msh41 -o quadrilaterals.v41.msh
mesh -2 blocks.geo -order 3 -format msh41 -o blocks.3.v41.msh
# FreeFEM's; it writes the borders as a geometry of its own beside, which is not used.
for name in blocks bricks labels p2; do
    FF_LOADPATH=${FF_LOADPATH:-/usr/lib/freefem++} FreeFem++ -nw -v 0 "$name.edp" >/dev/null
done
rm -f freefem.mesh.gmsh
# Medit's binary versions that FreeFEM does not write, by libMeshb where it is installed.
if cc meshb.c -lMeshb.7 -lm -o meshb 2>/dev/null; then
    for version in 1 3 4; do ./meshb blocks.2.mesh "blocks.2.v$version.meshb" "$version"; done
    ./meshb bricks.2.mesh bricks.2.v1.meshb 1
    rm meshb
fi
for version in 1 3 4; do
    mesh -2 blocks.geo -setnumber Mesh.MshFileVersion "$version" -format msh -o "blocks.v$version.msh"
done
# VTK's, where its Python package and meshio are installed.
if python3 -c 'import meshio, vtk' 2>/dev/null; then python3 write_vtu.py && python3 write_vtk.py; fi

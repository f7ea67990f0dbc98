#!/usr/bin/env bash
# What each departure of the library's fixed point from the paper's script changes, as the table of docs/freefem.md: the
# literal script in FreeFEM, the library's literal solver, and that with one departure at a time.
# usage: scripts/departures.sh FOLDER [INCREMENTS [SCENE]]; SCENE is disc_in_disc or three_beams. The folder has the meshes, ring.msh
# and disc.msh or beam1.mesh to beam3.mesh, and gets the results.
set -euo pipefail
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
folder=$(cd "${1:?usage: scripts/departures.sh FOLDER [INCREMENTS [SCENE]], a folder of meshes}" && pwd)
increments=${2:-20}
scene=${3:-disc_in_disc}
case $scene in
disc_in_disc) arguments=() ;;
three_beams) arguments=(-law neo_hookean -young 1 -pressure 5e-4) ;;
*) echo "there is no scene $scene: there are disc_in_disc and three_beams" >&2 && exit 2 ;;
esac
export OPENBLAS_NUM_THREADS=1
mkdir -p "$folder/script"
(cd "$folder/script" && FF_LOADPATH=${FF_LOADPATH:-/usr/lib/freefem++} FF_INCLUDEPATH="$top/freefem" \
    FreeFem++ -nw -v 0 "$top/freefem/${scene}_literal.edp" -meshes .. -out . -increments "$increments" \
    "${arguments[@]}" >log.txt)

value() { awk -v key="$1" '$1 == key { print $2 }' "$folder/script/result.txt"; }
echo "| | fixed point | Ipopt | energy off | displacement off |"
echo "|---|---:|---:|---:|---:|"
echo "| the script | $(value fixed_point_iterations) | $(value ipopt_iterations) | - | - |"
for departure in none lift predictor guard units warm-starts acceleration; do
    keys="departures = []"
    [[ $departure == none ]] || keys="departures = [\"$departure\"]"
    sed "s/^departures = .*/$keys/; s/^increments = .*/increments = $increments/" "$top/freefem/$scene.toml" >"$folder/$departure.toml"
    # 3: increments that did not converge have no certificate
    ipopt-contact run "$folder/$departure.toml" --out "$folder/$departure" >"$folder/$departure.log" 2>&1 || true
    if ! ipopt-contact compare "$folder/$departure" "$folder/script" --tolerance 1 >"$folder/table.txt"; then
        echo "| $departure | $(tail -n 1 "$folder/$departure.log") | | | |"
        continue
    fi
    awk -v name="$departure" '
        /^iterations/ { fixed = $2 }
        /^inner iterations/ { ipopt = $3 }
        /^energy/ { energy = $NF }
        /^displacement, largest/ { displacement = $NF }
        END { print "| " name " | " fixed " | " ipopt " | " energy " | " displacement " |" }' "$folder/table.txt"
done

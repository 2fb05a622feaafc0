#!/usr/bin/env bash
# The package's tests, and twenty sealed cases with the programs of a folder.
set -euo pipefail
cd "$(dirname "$0")"
programs=$1 work=$(mktemp -d)
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install -q .
"$work/venv/bin/python" -m unittest discover -s tests
proof=("$work/venv/bin/python" -m fluxcal_proof)
"${proof[@]}" make -o "$work/round" --set develop --cases 20 --seed 1
"${proof[@]}" answer "$work/round" --programs "$programs" > /dev/null
"${proof[@]}" score "$work/round"
rm -r "$work"

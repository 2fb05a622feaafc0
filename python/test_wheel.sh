#!/usr/bin/env bash
# The wheel of the programs in a folder, in an empty environment away from the sources: its tests, and mypy in its strict mode.
#
#     python/test_wheel.sh target/debug
#
# Needs PyPI for pandas, Polars, PyArrow, matplotlib and mypy; without them it fails.
set -euo pipefail
cd "$(dirname "$0")/.."
programs=$(realpath "$1")
rm -rf target/wheel-test
mkdir -p target/wheel-test
wheel=$(cd python && FLUXCAL_PROGRAMS="$programs" python3 -c 'import backend; print(backend.build_wheel("../target/wheel-test"))')
cp python/test_wheel.py target/wheel-test
fixtures=$PWD/fixtures
cd target/wheel-test
python3 -m venv environment
environment/bin/pip install --quiet "./$wheel[frames,polars,plot]" mypy
environment/bin/mypy --strict --ignore-missing-imports -p fluxcal &
PATH="$PWD/environment/bin:$PATH" environment/bin/python test_wheel.py "$fixtures"
wait $!

#!/usr/bin/env bash
# The lowest versions that pyproject.toml allows, and the newest there are, under every Python from 3.11 to 3.13 found here.
# Run `tests/versions.sh [lowest|newest [PYTHON ...]]`: an environment each, a part of the tests that touches every library.
# Lowest are tried under the lowest Python, where all have wheels. Exit code 0 when all that was tried passes.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1 MPLBACKEND=Agg PYVISTA_OFF_SCREEN=true
unset PYTHONPATH
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

part="tests/test_public_names.py tests/test_units.py tests/scene tests/analysis/material/test_fitted.py tests/analysis/test_tolerances.py
    tests/maps/test_surrogate.py tests/batch tests/boards/test_scene.py tests/export/test_tables.py tests/export/test_spice.py
    tests/report/test_folder.py tests/report/plots/test_curves.py tests/mechanics/test_linear.py
    tests/magnetics/test_rings.py tests/magnetics/test_field.py"

bounds() { # the lower bounds of all that the tests need, as constraints
    "$1" - <<'BOUNDS'
import re
import tomllib
from itertools import chain

with open("pyproject.toml", "rb") as file:
    project = tomllib.load(file)["project"]
extras = {name: lines for name, lines in project["optional-dependencies"].items() if name != "docs"}
for line in chain(project["dependencies"], *extras.values()):
    found = re.fullmatch(r"([A-Za-z0-9_.-]+)>=([0-9.]+)", line)
    if found:
        print(f"{found[1]}=={found[2]}")
BOUNDS
}

tried() { # WHICH PYTHON: install, run, say what came of it
    local venv="$work/$1-$("$2" -c 'import platform; print(platform.python_version())')"
    "$2" -m venv "$venv"
    : >"$work/constraints"
    [ "$1" = newest ] || bounds "$venv/bin/python" >"$work/constraints"
    "$venv/bin/python" -m pip install -qq --disable-pip-version-check -c "$work/constraints" -e ".[test]"
    printf '\n== %s: %s\n' "$(basename "$venv")" "$("$venv/bin/python" -m pip list --disable-pip-version-check --format freeze |
        grep -iE '^(numpy|scipy|scikit-fem|xarray|netCDF4|pydantic|pint|cyclopts|pandas|matplotlib|pyvista|gmsh)==' | tr '\n' ' ')"
    # shellcheck disable=SC2086 # a list of paths
    "$venv/bin/python" -m pytest -q -x -p no:cacheprovider $part
    "$venv/bin/sits-mech" simulate biorob2018 --fx "0.3 N" --fz "1 N" >/dev/null
    rm -rf "$venv"
}

which=${1:-both}
shift || true
[ "$which" = newest ] || tried lowest "${1:-python3.11}"
[ "$which" = lowest ] || for python in ${*:-python3.11 python3.12 python3.13}; do
    if "$python" -c '' 2>/dev/null; then tried newest "$python"; else printf '\n== %s: not here\n' "$python"; fi
done

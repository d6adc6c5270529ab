#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-3.0-or-later
# Install the wheel of build/dist into an empty environment, as a user does, and solve the README's pad.
# Usage: try_wheel.sh [PYTHON]      PYTHON: 3.12 or newer; default: as find_python.sh finds it
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

environment=$PWD/build/wheel-user
"$(tools/find_python.sh "${1:-}")" -m venv --clear "$environment"
wheel=$(echo "$PWD"/build/dist/*.whl)
"$environment/bin/python" -m pip install --quiet --disable-pip-version-check "${wheel}[fem]"
# Nothing of the checkout is found from there.
folder=$environment/pad
mkdir "$folder"
awk '/^```toml/ { inside = 1; next } /^```/ && inside { exit } inside' README.md >"$folder/pad.toml"
check=$PWD/tools/debian/check_pad.py
cd "$folder"
export PATH=$environment/bin:$PATH OMP_NUM_THREADS=1
fretfe info | tee info
! grep 'cannot be used' info || exit 1
fretfe run pad.toml -o pad --quiet
python -P "$check" pad
ls pad/report.html

#!/bin/sh
# SPDX-License-Identifier: LGPL-3.0-or-later
# Create or complete a virtual environment and build and install the package there.
# Usage: install.sh VENV PIP_ARGUMENTS...      e.g. install.sh .venv -e '.[fem,test]'
# PYTHON names the interpreter for a new environment; CXX the compiler.
set -eu

venv=$1
shift
python=$venv/bin/python

compiler_found() {
    for candidate in ${CXX:-c++ g++ clang++}; do
        command -v "$candidate" >/dev/null 2>&1 && return 0
        [ -z "${CXX:-}" ] || return 1 # CXX may carry flags after the command
    done
    return 1
}
if ! compiler_found; then
    cat >&2 <<EOF
No C++ compiler was found. Looked for ${CXX:-c++, g++, clang++} on PATH. Install one, for example with
    apt install g++           (Debian, Ubuntu)
    dnf install gcc-c++       (Fedora, RHEL)
or name one:  make CXX=/path/to/compiler ...
EOF
    exit 1
fi

# An environment whose Python was removed or is too old is made anew; one without pip gets it.
usable='import sys; sys.exit(sys.version_info < (3, 12) or sys.prefix == sys.base_prefix)'
if ! "$python" -c "$usable" >/dev/null 2>&1; then
    base=$("$(dirname "$0")/find_python.sh" "${PYTHON:-}")
    echo "Creating $venv with $base"
    "$base" -m venv --clear "$venv"
fi
"$python" -m pip --version >/dev/null 2>&1 || "$python" -m ensurepip --upgrade >/dev/null

# Python compiles what it imports; all of the packages would take half a minute.
pip_install() {
    "$python" -m pip install --quiet --no-input --disable-pip-version-check --no-compile "$@"
}

echo "Installing into $venv (the first time some minutes and up to 2 GB)"
# Without build isolation a rebuild is incremental and needs no network.
"$python" -c '
import tomllib
with open("pyproject.toml", "rb") as file:
    print(*tomllib.load(file)["build-system"]["requires"], sep="\n")
' | pip_install cmake ninja -r /dev/stdin
if ! pip_install --no-build-isolation \
    --config-settings=build-dir="build/$(basename "$venv")/{wheel_tag}" "$@"; then
    "$python" -c '
import platform
system, machine, (libc, version) = platform.system(), platform.machine(), platform.libc_ver()
glibc = [int(part) for part in version.split(".")] if libc == "glibc" else [0]
if (system, machine) != ("Linux", "x86_64") or glibc < [2, 34]:
    print("DOLFINx is on PyPI for Linux on x86_64 with glibc >= 2.34 only; this is", system,
          "on", machine, "with", libc or "no glibc", version)
' >&2
    exit 1
fi

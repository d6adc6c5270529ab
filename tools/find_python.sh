#!/bin/sh
# SPDX-License-Identifier: LGPL-3.0-or-later
# Print the path of a Python that can hold the environment; explain what to do if there is none.
# Usage: find_python.sh [PYTHON]      PYTHON: take this one or fail
set -u

minors="12 13 14 15 16 17 18 19"
pyenv_versions="${PYENV_ROOT:-${HOME:-}/.pyenv}/versions"
uv_versions="${UV_PYTHON_INSTALL_DIR:-${XDG_DATA_HOME:-${HOME:-}/.local/share}/uv/python}"
rejected=""

# A Python that lacks one of these would only fail later, in the middle of the installation.
probe='
import os, sys, sysconfig
version = "%d.%d" % sys.version_info[:2]
if sys.version_info < (3, 12):
    sys.exit("is Python " + version)
if sys.implementation.name != "cpython" or sysconfig.get_config_var("Py_GIL_DISABLED"):
    sys.exit("is not the standard CPython, the only one with wheels of DOLFINx")
for name in ("ctypes", "ssl", "zlib", "venv", "ensurepip"):
    try:
        __import__(name)
    except ImportError:
        sys.exit("is Python %s without the module %s (Debian, Ubuntu: apt install python%s-venv)"
                 % (version, name, version))
if not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")):
    sys.exit("is Python %s without Python.h (Debian, Ubuntu: apt install python%s-dev)"
             % (version, version))
print(sys.executable)
'

# Print the real path of candidate $1 and leave, if it fits; remember why not otherwise.
try() {
    [ -x "$1" ] && [ ! -d "$1" ] || return 0
    if answer=$("$1" -I -c "$probe" 2>&1 </dev/null); then
        echo "$answer"
        exit 0
    fi
    case $answer in
        is\ *) ;;
        *) answer="does not run (a pyenv version that is not active?)" ;;
    esac
    rejected="$rejected
    $1: $answer"
}

# Try the command $1 in every directory of PATH: a pyenv shim may hide a Python that runs.
try_on_path() {
    old_ifs=$IFS
    IFS=:
    for directory in $PATH; do
        IFS=$old_ifs
        try "$directory/$1"
    done
    IFS=$old_ifs
}

if [ -n "${1:-}" ]; then
    case $1 in
        */*) try "$1" ;;
        *) try_on_path "$1" ;;
    esac
    echo "PYTHON=$1 cannot be used; a CPython >= 3.12 is needed.${rejected:-
    $1: not found}" >&2
    exit 1
fi

for minor in $minors; do
    try_on_path "python3.$minor"
    for candidate in "$pyenv_versions/3.$minor"*/bin/python \
        "$uv_versions/cpython-3.$minor"*/bin/"python3.$minor"; do
        try "$candidate"
    done
done
try_on_path python3
try_on_path python

cat >&2 <<EOF
No Python >= 3.12 was found that can be used (DOLFINx from PyPI needs it). Looked for
    python3.12 and newer, python3, python on PATH
    $pyenv_versions/3.12* and newer
    $uv_versions/cpython-3.12* and newer
Found, but not usable:${rejected:-
    nothing}
Install one, for example with one of
    apt install python3 python3-venv python3-dev      (Debian 13, Ubuntu 24.04 and newer)
    pyenv install 3.12
    uv python install 3.12
or name one:  make PYTHON=/path/to/python3.12 ...
EOF
exit 1

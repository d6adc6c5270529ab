#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-3.0-or-later
# The part of deb.sh that runs in namespaces of its own.
# Usage: deb_in_namespace.sh CACHE SUITE WHAT      WHAT: all, pad
set -euo pipefail

cache=$1 suite=$2 what=$3
. "$(dirname "${BASH_SOURCE[0]}")/system.sh"
packages=$PWD/build/deb/$suite

install() { # COMMANDS
    as_root "$apt_limit" "apt-get -qq update; $1" >"$root.log" 2>&1
}

build() {
    root=$cache/$suite-build
    # The file that says for what the system is comes last: an interrupted one is made anew.
    if cmp --quiet debian/control "$root/etc/fretfe-control"; then
        mount_system
        copy_checkout
    else
        new_system
        mount_system
        keep_downloads
        copy_checkout
        step "what building needs"
        install "apt-get install --no-install-recommends build-essential lintian
            apt-get build-dep --no-install-recommends $home/fretfe" ||
            give_up "deb: what building needs cannot be installed"
        cp debian/control "$root/etc/fretfe-control"
    fi
    rm -f "$root$home"/{,python3-}fretfe[-_]*
    step "package"
    as_tester "$build_limit" "cd fretfe; dpkg-buildpackage --no-sign" >"$root.log" 2>&1 || {
        tail -n 60 "$root.log" >&2
        return 1
    }
    if [ "$what" = all ]; then
        step "lintian"
        as_tester 600 "lintian --info --display-info --fail-on error,warning *.changes"
    fi
    rm -rf "$packages"
    mkdir -p "$packages"
    cp "$root$home"/fretfe_* "$root$home"/python3-fretfe* "$packages"
}

# As a user: apt brings all that the package needs.
try() {
    root=$cache/$suite-user
    new_system
    mount_system
    keep_downloads
    cp "$packages"/python3-fretfe_*.deb "$root$home"
    step "apt install ./python3-fretfe_*.deb"
    install "cd $home; apt install --yes ./python3-fretfe_*.deb" || give_up "deb: apt cannot install the package"
    copy_checkout
    as_tester 60 '! command -v pip pip3'
    step "fretfe info, manual pages, completions"
    as_tester 120 "fretfe info | tee info
        ! grep 'cannot be used' info || exit 1
        ls /usr/share/man/man1/fretfe*.1.gz
        source /usr/share/bash-completion/completions/fretfe
        COMP_WORDS=(fretfe ru) COMP_CWORD=1
        _fretfe_completion fretfe
        [ \"\${COMPREPLY[*]}\" = run ]"
    step "the pad of the README"
    as_tester "$test_limit" "
        awk '/^\`\`\`toml/ { inside = 1; next } /^\`\`\`/ && inside { exit } inside' \\
            fretfe/README.md >pad.toml
        fretfe run pad.toml -o pad --quiet
        python3 fretfe/tools/debian/check_pad.py pad
        ls pad/report.html"
}

# As a user who has several processes, and solids.
try_more() {
    step "the pad on two processes"
    as_tester "$test_limit" "
        mpirun -n 2 fretfe run pad.toml -o pad2 --quiet
        python3 fretfe/tools/debian/check_pad.py pad pad2
        ls pad2/report.html"
    step "the sphere of the tutorial, on a coarser mesh, until it is steady"
    as_tester "$test_limit" "
        awk '/^\`\`\`toml/ { inside = 1; next } /^\`\`\`/ && inside { exit } inside' \\
            fretfe/docs/tutorial-solids.md >sphere.toml
        fretfe run sphere.toml -o sphere --quiet --set geometry.parameters.size=0.15 \\
            --set geometry.parameters.growth=0.6 --set loads.shear.history.2.cycles=6 2>&1 | tee told
        ! grep Warning told || exit 1
        ls sphere/report.html"
}

# As Debian's autopkgtest does it: the tests of the sources against the package.
test_package() {
    step "debian/tests"
    install "apt-get install --no-install-recommends \
        $(sed -n 's/^Depends: @, //p' debian/tests/control | tr -d ,)" ||
        give_up "deb: what the tests need cannot be installed"
    as_tester "$test_limit" "cd fretfe; debian/tests/fast-tests"
}

build
try
if [ "$what" = all ]; then
    try_more
    test_package
fi
step "done: $packages"

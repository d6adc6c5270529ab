#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-3.0-or-later
# Build the Debian package in a bare Debian, and try it in another where apt alone installs it.
# Usage: deb.sh SUITE [pad]      SUITE: trixie, sid, ...; pad: build, install and solve the README's
# pad, and no more
# The packages go to build/deb/SUITE. Exit code 3: Debian's packages cannot be installed.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/outside.sh"

suite=$1
what=${2:-all}
check_machine
lock "$suite-deb"
in_namespaces tools/debian/deb_in_namespace.sh "$cache" "$suite" "$what"

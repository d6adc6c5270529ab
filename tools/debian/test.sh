#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-3.0-or-later
# Install fretfe on a bare Debian, word for word as docs/install.md says, and run its tests there.
# Usage: test.sh SUITE [fresh]      SUITE: trixie, sid, ...; fresh: not with the system of last time
# Exit code 3: Debian's packages cannot be installed, and nothing of fretfe was tried.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/outside.sh"

suite=$1
system=${2:-}
root=$cache/$suite

# The commands in the first code block of docs/install.md after a marker.
commands() {
    awk -v mark="<!-- debian: $1 -->" '
        $0 == mark { found = 1 }
        found && /^```/ { if (inside) exit; inside = 1; next }
        inside' docs/install.md
}

check_machine
packages=$(commands packages)
install=$(commands install)
[ -n "$packages" ] && [ -n "$install" ] || fail "docs/install.md: expected a code block after each of \
<!-- debian: packages --> and <!-- debian: install -->"
lock "$suite"

# Packages that were taken off the list must be gone: another list, another system.
if [ -n "$system" ] || ! [ "$(cat "$root/etc/fretfe-packages" 2>/dev/null)" = "$packages" ]; then
    rm -rf --one-file-system "$root"
fi
in_namespaces tools/debian/in_namespace.sh "$cache" "$suite" "$packages" "$install"

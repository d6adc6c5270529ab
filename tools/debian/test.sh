#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-3.0-or-later
# Install fretfe on a bare Debian, word for word as docs/install.md says, and run its tests there.
# Usage: test.sh SUITE [fresh]      SUITE: trixie, sid, ...; fresh: not with the system of last time
# The system lies in FRETFE_DEBIAN_CACHE/SUITE (~/.cache/fretfe/debian); DEBIAN_MIRROR is where it
# comes from. Exit code 3: Debian's packages cannot be installed, and nothing of fretfe was tried.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

suite=$1
fresh=${2:-}
cache=${FRETFE_DEBIAN_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/fretfe/debian}
root=$cache/$suite

fail() {
    echo "test-debian: $*" >&2
    exit 1
}

# The commands in the first code block of docs/install.md after a marker.
commands() {
    awk -v mark="<!-- debian: $1 -->" '
        $0 == mark { found = 1 }
        found && /^```/ { if (inside) exit; inside = 1; next }
        inside' docs/install.md
}

[ "$(id -u)" = 0 ] || fail "expected to be run by root, who alone can set up a Debian in a folder; \
found user $(id -un). Try: sudo make test-debian"
command -v debootstrap >/dev/null || fail "the command debootstrap was not found. On Debian and \
Ubuntu: apt install debootstrap debian-archive-keyring"
unshare --mount --pid --fork true 2>/dev/null || fail "this machine allows no mount and process \
namespaces (unshare --mount --pid), as in a container without privileges"
packages=$(commands packages)
install=$(commands install)
[ -n "$packages" ] && [ -n "$install" ] || fail "docs/install.md: expected a code block after each of \
<!-- debian: packages --> and <!-- debian: install -->"

mkdir -p "$cache"
exec 9>"$cache/$suite.lock"
flock --nonblock 9 || fail "another run uses $root"

# Packages that were taken off the list must be gone: another list, another system.
if [ "$fresh" = fresh ] || ! [ "$(cat "$root/etc/fretfe-packages" 2>/dev/null)" = "$packages" ]; then
    rm -rf --one-file-system "$root"
fi

# All that runs below is alone in namespaces of its own: no mount is seen outside, and with the
# first process every other process and every mount goes, however this script ends. In the
# background, so that signals are acted upon at once; bash would then have it ignore SIGINT.
env --default-signal=INT,QUIT setpriv --pdeathsig KILL \
    unshare --mount --pid --fork --kill-child=KILL \
    tools/debian/in_namespace.sh "$root" "$suite" "$packages" "$install" </dev/null 9>&- &
child=$!
trap 'kill -KILL "$child" 2>/dev/null; exit 130' INT TERM HUP
wait "$child"

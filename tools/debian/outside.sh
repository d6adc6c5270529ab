# SPDX-License-Identifier: LGPL-3.0-or-later
# What test.sh and deb.sh do before and around their work in namespaces; to be sourced by them.
# Systems lie in FRETFE_DEBIAN_CACHE (~/.cache/fretfe/debian); DEBIAN_MIRROR is where they come from.
# shellcheck shell=bash
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
name=$(basename "$0" .sh)
cache=${FRETFE_DEBIAN_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/fretfe/debian}

fail() {
    echo "$name: $*" >&2
    exit 1
}

check_machine() {
    [ "$(id -u)" = 0 ] || fail "expected to be run by root, who alone can set up a Debian in a \
folder; found user $(id -un). Try it with sudo"
    command -v debootstrap >/dev/null || fail "the command debootstrap was not found. On Debian and \
Ubuntu: apt install debootstrap debian-archive-keyring"
    unshare --mount --pid --fork true 2>/dev/null || fail "this machine allows no mount and process \
namespaces (unshare --mount --pid), as in a container without privileges"
}

lock() { # SYSTEM
    mkdir -p "$cache"
    exec 9>"$cache/$1.lock"
    flock --nonblock 9 || fail "another run uses $cache/$1"
}

# All that runs in here is alone in namespaces of its own: no mount is seen outside, and with the
# first process every other process and every mount goes, however this script ends. In the
# background, so that signals are acted upon at once; bash would then have it ignore SIGINT.
in_namespaces() { # COMMAND
    env --default-signal=INT,QUIT setpriv --pdeathsig KILL \
        unshare --mount --pid --fork --kill-child=KILL "$@" </dev/null 9>&- &
    child=$!
    trap 'kill -KILL "$child" 2>/dev/null; exit 130' INT TERM HUP
    wait "$child"
}

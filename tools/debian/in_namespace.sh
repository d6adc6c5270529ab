#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-3.0-or-later
# The part of test.sh that runs in namespaces of its own.
# Usage: in_namespace.sh ROOT SUITE PACKAGES INSTALL      the last two: shell commands of docs/install.md
set -euo pipefail

root=$1 suite=$2 packages=$3 install=$4
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
home=/home/tester
# Longest times in seconds, several times what a machine with two cores needs that is not shared.
boot_limit=1200 apt_limit=1800 build_limit=900 test_limit=3600

step() {
    echo "== Debian $suite: $* ($(date +%T))"
}

# No locale, no variable of the caller; the network as it is outside.
inside() { # USER HOME SECONDS COMMANDS
    env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
        HOME="$2" DEBIAN_FRONTEND=noninteractive \
        ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
        timeout --kill-after=10 "$3" chroot --userspec="$1" "$root" \
        bash -euo pipefail -c "cd; $4" </dev/null
}
as_root() { inside root:root /root "$@"; }
# Nothing may come from PyPI. One thread: the same rounding in every run. Open MPI refuses more
# ranks than there are cores, binds the ranks of two runs to the same cores, and a rank that waits
# takes the core from the one it waits for.
as_tester() {
    inside tester:tester "$home" "$1" "
        export PIP_NO_INDEX=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
        export PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe
        export PRTE_MCA_hwloc_default_binding_policy=none OMPI_MCA_mpi_yield_when_idle=1
        $2"
}

mount_system() {
    local name
    mount -t proc proc "$root/proc"
    mount --rbind -o ro /sys "$root/sys"
    mount -t tmpfs -o mode=755 dev "$root/dev"
    for name in null zero full random urandom tty; do
        touch "$root/dev/$name"
        mount --bind "/dev/$name" "$root/dev/$name"
    done
    mkdir "$root/dev/pts" "$root/dev/shm"
    mount -t devpts -o newinstance,ptmxmode=666,mode=620,gid=5 devpts "$root/dev/pts"
    mount -t tmpfs -o mode=1777 shm "$root/dev/shm"
    ln -s pts/ptmx "$root/dev/ptmx"
    ln -s /proc/self/fd "$root/dev/fd"
    cp /etc/resolv.conf "$root/etc/resolv.conf"
    echo "127.0.0.1 localhost $(hostname)" >"$root/etc/hosts"
}

# A bare system, and the settings that make installations fast and silent.
bootstrap() {
    timeout --kill-after=10 "$boot_limit" debootstrap --variant=minbase "$suite" "$root" "$mirror" \
        >"$root.log" || return 1
    printf '%s\n' 'APT::Get::Assume-Yes "true";' 'Acquire::Languages "none";' \
        'Acquire::Retries "3";' 'Acquire::Check-Valid-Until "false";' \
        'Acquire::Check-Date "false";' >"$root/etc/apt/apt.conf.d/90fretfe"
    printf '%s\n' force-unsafe-io 'path-exclude /usr/share/doc/*' 'path-exclude /usr/share/man/*' \
        'path-exclude /usr/share/locale/*' >"$root/etc/dpkg/dpkg.cfg.d/fretfe"
    printf '#!/bin/sh\nexit 101\n' >"$root/usr/sbin/policy-rc.d" # starts no services
    chmod 755 "$root/usr/sbin/policy-rc.d"
    chroot "$root" useradd --create-home tester
}

install_packages() {
    as_root "$apt_limit" "apt-get -qq update
        $packages
        apt-get clean" >>"$root.log" 2>&1
}

# The file that says so comes last: an interrupted installation is begun anew.
if [ ! -e "$root/etc/fretfe-packages" ]; then
    rm -rf --one-file-system "$root"
    mkdir -p "$root"
    step "bare system into $root, from $mirror"
    bootstrap || {
        tail -n 20 "$root.log" >&2
        echo "test-debian: debootstrap failed; all of its output is in $root.log" >&2
        exit 3
    }
    mount_system
    step "packages of docs/install.md"
    install_packages || {
        tail -n 20 "$root.log" >&2
        echo "test-debian: the packages of docs/install.md cannot be installed on Debian $suite; all" \
            "of apt's output is in $root.log" >&2
        exit 3
    }
    echo "$packages" >"$root/etc/fretfe-packages"
else
    mount_system
fi

find "$root/tmp" -mindepth 1 -delete
rm -rf --one-file-system "$root$home/fretfe"
mkdir "$root$home/fretfe"
tar -c --exclude=./.git --exclude='./.venv*' --exclude=./build --exclude=./results \
    --exclude='*.so' --exclude=__pycache__ --exclude='.*_cache' . | tar -x -C "$root$home/fretfe"
chroot "$root" chown -R tester:tester "$home"

step "check that the packages are what fretfe needs"
as_tester 300 "cd fretfe; python3 tools/debian/check_packages.py"

step "fretfe as docs/install.md says"
as_tester "$build_limit" "cd fretfe
$install"

# In tests/ a Python finds the fretfe that is installed, not that of the checkout.
pytest="$home/fretfe/.venv-debian/bin/python -m pytest"
# What NumPy and SciPy alone compute is the same as where `make test` ran it. On unstable, which is
# there to show early what a new DOLFINx, PETSc, VTK or Python breaks, the tests that ranks share:
# they go through all that solves, from meshes to results.
[ "$suite" = sid ] && chosen="mpi and not slow" || chosen="not formula and not slow"
step "tests on one rank: $chosen"
as_tester "$test_limit" "cd fretfe/tests; $pytest -m '$chosen' --numprocesses=2 --dist=loadfile"
step "tests on two ranks"
as_tester "$test_limit" "cd fretfe/tests; mpirun -n 2 $pytest -m 'mpi and not slow' \\
    -p no:cacheprovider --timeout-method=thread"
step "done"

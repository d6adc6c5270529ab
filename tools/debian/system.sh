# SPDX-License-Identifier: LGPL-3.0-or-later
# Debian systems in folders, and commands inside them; to be sourced in namespaces of their own.
# Expects `cache` (a folder) and `suite`; commands run in the system in the folder `root`.
# shellcheck shell=bash
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
home=/home/tester
# Longest times in seconds, several times what a machine with two cores needs that is not shared.
boot_limit=1200 apt_limit=1800 build_limit=900 test_limit=3600

step() {
    echo "== Debian $suite: $* ($(date +%T))"
}

# Packages that Debian cannot install are no fault of fretfe.
give_up() { # WHAT
    tail -n 20 "$root.log" >&2
    echo "$1; all of the output is in $root.log" >&2
    exit 3
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
# ranks than there are cores, binds the ranks of two runs to the same cores, a rank that waits takes
# the core from the one it waits for, and networks that lead nowhere are warned of.
as_tester() {
    inside tester:tester "$home" "$1" "
        export PIP_NO_INDEX=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
        export PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe
        export PRTE_MCA_hwloc_default_binding_policy=none OMPI_MCA_mpi_yield_when_idle=1
        export OMPI_MCA_btl=self,sm
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

# A bare system with settings that make installations fast and silent.
bootstrap() { # FOLDER
    timeout --kill-after=10 "$boot_limit" debootstrap --variant=minbase "$suite" "$1" "$mirror" \
        || return 1
    printf '%s\n' 'APT::Get::Assume-Yes "true";' 'Acquire::Languages "none";' \
        'Acquire::Retries "3";' 'Acquire::Check-Valid-Until "false";' \
        'Acquire::Check-Date "false";' >"$1/etc/apt/apt.conf.d/90fretfe"
    printf '%s\n' force-unsafe-io 'path-exclude /usr/share/doc/*' 'path-exclude /usr/share/locale/*' \
        >"$1/etc/dpkg/dpkg.cfg.d/fretfe"
    printf '#!/bin/sh\nexit 101\n' >"$1/usr/sbin/policy-rc.d" # starts no services
    chmod 755 "$1/usr/sbin/policy-rc.d"
    chroot "$1" useradd --create-home tester
    touch "$1/etc/fretfe-bare"
}

# A new system in the folder `root`: a copy of a bare one that is at most a day old.
new_system() {
    local bare=$cache/$suite-bare
    (
        flock 8
        if ! [ "$(find "$bare/etc/fretfe-bare" -mtime -1 2>/dev/null)" ]; then
            step "bare system into $bare, from $mirror"
            rm -rf --one-file-system "$bare"
            bootstrap "$bare" >"$root.log" 2>&1 || give_up "debootstrap failed"
        fi
        rm -rf --one-file-system "$root"
        cp -a "$bare" "$root"
    ) 8>"$bare.lock"
}

# What apt has downloaded once is kept, for other systems of the suite too.
keep_downloads() {
    mkdir -p "$cache/$suite-archives"
    mount --bind "$cache/$suite-archives" "$root/var/cache/apt/archives"
    echo 'Binary::apt::APT::Keep-Downloaded-Packages "true";' \
        >"$root/etc/apt/apt.conf.d/91keep"
}

# The checkout, without what was built in it, in the tester's folder.
copy_checkout() {
    find "$root/tmp" -mindepth 1 -delete
    rm -rf --one-file-system "$root$home/fretfe"
    mkdir "$root$home/fretfe"
    tar -c --exclude=./.git --exclude='./.venv*' --exclude=./build --exclude=./results \
        --exclude='*.so' --exclude=__pycache__ --exclude='.*_cache' . | tar -x -C "$root$home/fretfe"
    chroot "$root" chown -R tester:tester "$home"
}

#!/bin/sh
# Runs the tests in a fresh Debian of another release, and so with another Mesa; with --zink by Mesa's OpenGL
# on Vulkan, which lavapipe computes on the processor. As root, from anywhere in the project:
#
#   sh tests/fresh-debian.sh trixie
#   sh tests/fresh-debian.sh trixie --zink
#   sh tests/fresh-debian.sh trixie 'sh setup.sh && cargo run --release'
#
# What is committed is tested, and `../shared` beside it, if it is there. Debian, Rust and what was built stay in
# FREEFORM_DEBIAN (/var/tmp/freeform-RELEASE otherwise) for the next time: about 4 GB.
set -eu
[ $# -gt 0 ] || { sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 2; }
release=$1
shift
zink=""
if [ "${1:-}" = --zink ]; then
    zink=1
    shift
fi
command=${1:-'sh setup.sh tests && cargo test --release --no-fail-fast'}
[ "$(id -u)" = 0 ] || { echo "fresh-debian.sh: it must run as root, for chroot" >&2; exit 1; }
project=$(cd "$(dirname "$0")/.." && pwd)
root=${FREEFORM_DEBIAN:-/var/tmp/freeform-$release}

if ! [ -e "$root/root/.rustup" ]; then
    if ! command -v debootstrap >/dev/null; then
        apt-get update -q >/dev/null
        apt-get install -qy --no-install-recommends debootstrap >/dev/null
    fi
    # The mirror that this machine uses, if it is a Debian.
    mirror=$(cat /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null |
        grep -oE 'https?://[^ ]+/debian/?( |$)' | head -n 1 | tr -d ' ') || true
    echo "fresh-debian.sh: installing $release in $root"
    debootstrap --variant=minbase --include=ca-certificates "$release" "$root" \
        "${mirror:-https://deb.debian.org/debian}" >"$root.log" 2>&1 ||
        { tail -n 5 "$root.log" >&2; exit 1; }
    cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
    cp -r "${RUSTUP_HOME:-$HOME/.rustup}" "$root/root/.rustup"
fi
cp /etc/resolv.conf /etc/hosts "$root/etc/"
mkdir -p "$root/root/.cargo"
for folder in bin registry; do
    [ -d "${CARGO_HOME:-$HOME/.cargo}/$folder" ] || continue
    cp -r "${CARGO_HOME:-$HOME/.cargo}/$folder" "$root/root/.cargo/"
done
for place in proc dev; do
    mountpoint -q "$root/$place" || mount --bind "/$place" "$root/$place"
done
if [ -d "$root/root/project/.git" ]; then
    git -C "$root/root/project" fetch -q "$project" HEAD
    git -C "$root/root/project" checkout -qf --detach FETCH_HEAD
else
    git clone -q "$project" "$root/root/project"
fi
rm -rf "$root/root/shared"
[ ! -d "$project/../shared" ] || cp -r "$project/../shared" "$root/root/shared"

inside() {
    chroot "$root" /usr/bin/env -i HOME=/root LANG=C.UTF-8 \
        PATH=/root/.cargo/bin:/usr/sbin:/usr/bin:/sbin:/bin "$@"
}
if [ -n "$zink" ]; then
    # shellcheck disable=SC2016 # what is within the quotes is for the other shell
    inside sh -c 'dpkg -s mesa-vulkan-drivers libvulkan1 >/dev/null 2>&1 || { apt-get update -q >/dev/null
        DEBIAN_FRONTEND=noninteractive apt-get install -qy --no-install-recommends \
            mesa-vulkan-drivers libvulkan1 >/dev/null; }'
    driver=$(cd "$root" && echo usr/share/vulkan/icd.d/lvp*.json)
    set -- MESA_LOADER_DRIVER_OVERRIDE=zink LIBGL_ALWAYS_SOFTWARE=1 "VK_ICD_FILENAMES=/$driver"
else
    set --
fi
inside "$@" sh -c "cd /root/project && $command"

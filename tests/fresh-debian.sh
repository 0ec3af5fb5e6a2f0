#!/bin/sh
# Runs the tests in a fresh Debian of another release, and so with another Mesa; with --zink by Mesa's OpenGL
# on Vulkan, which lavapipe computes on the processor. As root, from anywhere in the project:
#
#   sh tests/fresh-debian.sh trixie
#   sh tests/fresh-debian.sh trixie --zink
#   sh tests/fresh-debian.sh trixie 'sh setup.sh && cargo run --release'
#
# What is committed is tested, and `../shared` beside it, if it is there. Debian, Rust and what was built stay in
# FREEFORM_DEBIAN (a folder freeform-RELEASE among the user's caches otherwise) for the next time: about 4 GB.
set -eu
[ $# -gt 0 ] || { sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 2; }
release=$1
shift
zink=""
if [ "${1:-}" = --zink ]; then
    zink=1
    shift
fi
command=${1:-'sh setup.sh tests && sh setup.sh cad && cargo test --release --no-fail-fast'}
[ "$(id -u)" = 0 ] || { echo "fresh-debian.sh: it must run as root, for chroot" >&2; exit 1; }
project=$(cd "$(dirname "$0")/.." && pwd)
caches=${XDG_CACHE_HOME:-$HOME/.cache}
root=${FREEFORM_DEBIAN:-$caches/freeform-$release}
# Rust, the project and what it is tested with, as the other Debian sees them and as this one does.
home=/opt/freeform
there=$root$home

if ! [ -e "$there/rustup" ]; then
    if ! command -v debootstrap >/dev/null; then
        apt-get update -q >/dev/null
        apt-get install -qy --no-install-recommends debootstrap >/dev/null
    fi
    # The mirror that this machine uses, if it is a Debian.
    mirror=$(cat /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null |
        grep -oE 'https?://[^ ]+/debian/?( |$)' | head -n 1 | tr -d ' ') || true
    echo "fresh-debian.sh: installing $release in $root"
    mkdir -p "$caches"
    debootstrap --variant=minbase --include=ca-certificates "$release" "$root" \
        "${mirror:-https://deb.debian.org/debian}" >"$root.log" 2>&1 ||
        { tail -n 5 "$root.log" >&2; exit 1; }
    cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
    mkdir -p "$there"
    cp -r "${RUSTUP_HOME:-$HOME/.rustup}" "$there/rustup"
fi
cp /etc/resolv.conf /etc/hosts "$root/etc/"
mkdir -p "$there/cargo"
for folder in bin registry; do
    [ -d "${CARGO_HOME:-$HOME/.cargo}/$folder" ] || continue
    cp -r "${CARGO_HOME:-$HOME/.cargo}/$folder" "$there/cargo/"
done
for place in proc dev; do
    mountpoint -q "$root/$place" || mount --bind "/$place" "$root/$place"
done
if [ -d "$there/project/.git" ]; then
    git -C "$there/project" fetch -q "$project" HEAD
    git -C "$there/project" checkout -qf --detach FETCH_HEAD
else
    git clone -q "$project" "$there/project"
fi
rm -rf "$there/shared"
[ ! -d "$project/../shared" ] || cp -r "$project/../shared" "$there/shared"

inside() {
    chroot "$root" /usr/bin/env -i HOME=$home LANG=C.UTF-8 RUSTUP_HOME=$home/rustup CARGO_HOME=$home/cargo \
        PATH=$home/cargo/bin:/usr/sbin:/usr/bin:/sbin:/bin "$@"
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
inside "$@" sh -c "cd $home/project && $command"

#!/bin/sh
# Installs what the program needs to draw without a GPU: Mesa's EGL driver. With `tests` it also
# installs OSMesa and a C compiler, which the tests need. Debian and Ubuntu; elsewhere it says what
# to install. Does nothing where everything is there.
set -eu

has_library() {
    /sbin/ldconfig -p 2>/dev/null | grep -q "$1"
}

missing=""
need() {
    missing="$missing $1"
}

has_library libEGL.so.1 || need libegl1
# The driver itself; libEGL alone finds no device.
has_library libEGL_mesa.so.0 || has_library libEGL_nvidia.so.0 || need libegl-mesa0
ls /usr/lib/*/dri/swrast_dri.so /usr/lib/*/dri/libdril_dri.so /usr/lib/*/libgallium*.so \
    /usr/lib64/dri/swrast_dri.so >/dev/null 2>&1 || need libgl1-mesa-dri
command -v cc >/dev/null 2>&1 || need gcc
ls /usr/lib/*/crt1.o /usr/lib64/crt1.o /usr/lib/crt1.o >/dev/null 2>&1 || need libc6-dev
if [ "${1:-}" = tests ]; then
    has_library libOSMesa.so || need libosmesa6
fi
[ -n "$missing" ] || exit 0

if ! command -v apt-get >/dev/null 2>&1; then
    echo "setup.sh: please install what provides (as Debian calls it):$missing" >&2
    exit 1
fi
sudo=""
if [ "$(id -u)" != 0 ]; then
    if ! command -v sudo >/dev/null 2>&1; then
        echo "setup.sh: run as root: apt-get install$missing" >&2
        exit 1
    fi
    sudo="sudo"
fi
echo "setup.sh: installing$missing"
export DEBIAN_FRONTEND=noninteractive
$sudo apt-get update -q >/dev/null
for package in $missing; do
    if ! $sudo apt-get install -qy --no-install-recommends "$package" >/dev/null; then
        # Newer distributions have dropped OSMesa; the program does without it.
        if [ "$package" = libosmesa6 ]; then
            echo "setup.sh: no package libosmesa6 here; tests run with FREEFORM_TEST_BACKENDS=egl" >&2
        else
            echo "setup.sh: apt-get could not install $package" >&2
            exit 1
        fi
    fi
done

#!/bin/sh
# Installs what the program needs to draw without a GPU: Mesa's EGL driver. With `tests` it also
# installs a C compiler, OSMesa, and a display without a screen with its keys and mouse (Xvfb, xdotool and
# the X libraries of a window), which the tests need, and with `check` also libGLU and Chromium, by which
# the report is checked. With `cad` it also installs OCCT and a C++ compiler, and builds the reader of STEP,
# IGES and BREP files (cad/build.sh). Debian and Ubuntu; elsewhere it says what to install. Does nothing where
# everything is there.
set -eu
mode="${1:-}"

has_library() {
    /sbin/ldconfig -p 2>/dev/null | grep -q "$1"
}

any_file() {
    for file in "$@"; do
        [ -e "$file" ] && return 0
    done
    return 1
}

# Builds what was asked for, once everything is installed.
finish() {
    [ "$mode" = cad ] || exit 0
    sh "$(dirname "$0")/cad/build.sh"
    # Beside the program, where `cargo install` puts it.
    bin="${CARGO_HOME:-${HOME:-}/.cargo}/bin"
    [ ! -d "$bin" ] || cp "$(dirname "$0")/cad/build/freeform-occt" "$bin/"
    exit 0
}

missing=""
need() {
    missing="$missing $1"
}
osmesa=""

has_library libEGL.so.1 || need libegl1
# The driver itself; libEGL alone finds no device.
has_library libEGL_mesa.so.0 || has_library libEGL_nvidia.so.0 || need libegl-mesa0
any_file /usr/lib/*/dri/swrast_dri.so /usr/lib/*/dri/libdril_dri.so /usr/lib/*/libgallium*.so \
    /usr/lib64/dri/swrast_dri.so || need libgl1-mesa-dri
command -v cc >/dev/null 2>&1 || need gcc
any_file /usr/lib/*/crt1.o /usr/lib64/crt1.o /usr/lib/crt1.o || need libc6-dev
if [ "$mode" = check ]; then
    has_library libGLU.so.1 || need libglu1-mesa
    command -v chromium >/dev/null 2>&1 || command -v google-chrome >/dev/null 2>&1 || need chromium
fi
if [ "$mode" = tests ] || [ "$mode" = check ]; then
    has_library libOSMesa.so || osmesa=libosmesa6
    for program in Xvfb:xvfb xdotool:xdotool; do
        command -v "${program%:*}" >/dev/null 2>&1 || need "${program#*:}"
    done
    for library in libGL.so.1:libgl1 libX11.so.6:libx11-6 libX11-xcb.so.1:libx11-xcb1 \
        libXcursor.so.1:libxcursor1 libXi.so.6:libxi6 libxkbcommon-x11.so.0:libxkbcommon-x11-0; do
        has_library "${library%:*}" || need "${library#*:}"
    done
fi
if [ "$mode" = cad ]; then
    command -v "${CXX:-c++}" >/dev/null 2>&1 || need g++
    any_file /usr/include/opencascade/STEPCAFControl_Reader.hxx \
        /usr/local/include/opencascade/STEPCAFControl_Reader.hxx || need libocct-data-exchange-dev
    any_file /usr/include/opencascade/TDocStd_Document.hxx \
        /usr/local/include/opencascade/TDocStd_Document.hxx || need libocct-ocaf-dev
fi
[ -n "$missing$osmesa" ] || finish

if ! command -v apt-get >/dev/null 2>&1; then
    # OSMesa is a second way to test, which newer distributions have dropped.
    [ -n "$missing" ] || exit 0
    echo "setup.sh: please install what provides (as Debian calls it):$missing $osmesa" >&2
    exit 1
fi
sudo=""
if [ "$(id -u)" != 0 ]; then
    if ! command -v sudo >/dev/null 2>&1; then
        [ -n "$missing" ] || exit 0
        echo "setup.sh: run as root: apt-get install$missing $osmesa" >&2
        exit 1
    fi
    sudo="sudo"
fi
echo "setup.sh: installing$missing $osmesa"
export DEBIAN_FRONTEND=noninteractive
$sudo apt-get update -q >/dev/null || echo "setup.sh: apt-get update failed; going on" >&2
install="apt-get install -qy --no-install-recommends"
# shellcheck disable=SC2086 # several packages, and maybe no sudo
if [ -n "$missing" ] && ! $sudo $install $missing >/dev/null; then
    echo "setup.sh: apt-get could not install$missing" >&2
    exit 1
fi
# shellcheck disable=SC2086
if [ -n "$osmesa" ] && ! $sudo $install $osmesa >/dev/null; then
    echo "setup.sh: no package $osmesa here; the tests leave it out" >&2
fi
finish

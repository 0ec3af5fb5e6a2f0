#!/bin/sh
# Builds freeform-occt, the reader of STEP, IGES and BREP files, with OCCT 7.6 or later.
set -eu
cd "$(dirname "$0")"

program=build/freeform-occt
[ -x $program ] && [ -z "$(find . -maxdepth 1 -type f -newer $program)" ] && exit 0

for include in /usr/include/opencascade /usr/local/include/opencascade; do
    [ -e "$include/Standard_Version.hxx" ] && break
done
if [ ! -e "$include/Standard_Version.hxx" ]; then
    echo "cad/build.sh: no headers of OCCT; run: sh setup.sh cad" >&2
    exit 1
fi

# The libraries of the readers have other names since OCCT 7.8.
version=$(sed -n 's/^#define OCC_VERSION_\(MAJOR\|MINOR\) *//p' "$include/Standard_Version.hxx")
# shellcheck disable=SC2086 # two numbers
set -- $version
if [ "$1" -gt 7 ] || [ "$2" -ge 8 ]; then
    readers="-lTKDESTEP -lTKDEIGES"
else
    readers="-lTKXDESTEP -lTKXDEIGES -lTKSTEP -lTKSTEPBase -lTKIGES"
fi

mkdir -p build
# Under another name until it is complete.
# shellcheck disable=SC2086 # several words
${CXX:-c++} -std=c++17 -O2 -Wall -Wextra -Werror -isystem "$include" ./*.cpp -o build/unfinished \
    $readers -lTKXSBase -lTKXCAF -lTKLCAF -lTKCDF -lTKMesh -lTKTopAlgo \
    -lTKBRep -lTKGeomBase -lTKG3d -lTKG2d -lTKMath -lTKernel
mv build/unfinished $program

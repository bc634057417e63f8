#!/usr/bin/env bash
# Runs the README's example in a folder that contains only xr/mock. Then runs the Python client against the
# installed runtime, which it finds through the manifest.
#   clean_folder_test.sh SOURCE_DIR
set -euo pipefail
source_dir=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/xr"
cp -r "$source_dir/xr/mock" "$folder/xr/mock"
cd "$folder"

export CMAKE_BUILD_TYPE=Debug XRMOCK_CLOCK=virtual
if command -v ccache > /dev/null; then
    export CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_BASEDIR=$folder CCACHE_NOHASHDIR=1
fi
echo '{ "version": 1, "exit_after_frames": 30 }' > scenario.json
mkfifo open_input  # hello_xr quits when its input ends
exec 3<> open_input

example=$(awk '/^    /{ found = 1; print; next } found { exit }' xr/mock/README.md)
grep -q "hello_xr" <<< "$example" || { echo "the README begins without an example of hello_xr"; exit 1; }
XRMOCK_SCENARIO=$PWD/scenario.json timeout 900 bash -euc "$example" <&3 > example.log 2>&1 ||
    { cat example.log; echo "the README's example failed"; exit 1; }
grep -q "IDLE->XR_SESSION_STATE_EXITING" example.log || { cat example.log; echo "hello_xr never left"; exit 1; }

cmake --install build/mock --prefix "$PWD/prefix" --component xrmock > /dev/null
rm -rf build xr
manifest=$(find prefix -name xrmock.json)
XR_RUNTIME_JSON=$PWD/$manifest PYTHONDONTWRITEBYTECODE=1 \
    timeout 60 python3 "$source_dir/tests/xr/mock/python/client_test.py"

# Shared by the commands of this folder: sourced, not run. Debian 12; any working directory.
set -euo pipefail
ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
export CCACHE_SLOPPINESS=pch_defines,time_macros
# Another clone of the same sources finds the same cache.
export CCACHE_BASEDIR=$ROOT CCACHE_NOHASHDIR=1
export CCACHE_DEPEND=1  # a tenth less where nothing is there yet: no preprocessing to look it up
JOBS=$(nproc)

say() { printf '\033[1m== %s\033[0m\n' "$*" >&2; }
die() { printf 'stylet: %s\n' "$*" >&2; exit 1; }

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"
    elif command -v sudo >/dev/null; then sudo "$@"
    else die "installing packages needs root or sudo; missing: ${MISSING[*]}"
    fi
}

# find_missing SECTION...: what the sections name and this machine lacks, in MISSING.
find_missing() {
    local section name
    MISSING=()
    for section in "$@"; do
        while read -r name; do
            [ -z "$name" ] || [ "${name#\#}" != "$name" ] && continue
            dpkg-query -W -f='${db:Status-Status}' "$name" 2>/dev/null | grep -qx installed || MISSING+=("$name")
        done <"$ROOT/packaging/packages/$section"
    done
}

# install_packages SECTION...: installs what is missing.
install_packages() {
    find_missing "$@"
    [ ${#MISSING[@]} = 0 ] && return
    command -v apt-get >/dev/null || die "this is not Debian; please install: ${MISSING[*]}"
    say "installing ${#MISSING[@]} packages: ${MISSING[*]}"
    as_root apt-get update -q || say "the package lists could not be refreshed (offline?); trying with what is known"
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -yq --no-install-recommends "${MISSING[@]}" ||
        die "could not install: ${MISSING[*]} (offline? bookworm and bookworm-security must be in the apt sources)"
}

# configure_and_build PRESET "CMAKE OPTIONS" TARGET...: no targets = all.
configure_and_build() {
    local preset=$1 options=$2
    shift 2
    say "$preset: configuring"
    # Fresh: another compiler than the folder's would cost the preset's settings.
    # shellcheck disable=SC2086  # options are words
    (cd "$ROOT" && cmake --fresh --preset "$preset" $options >"$ROOT/build/$preset.configure.log" 2>&1) ||
        { tail -n 30 "$ROOT/build/$preset.configure.log" >&2; die "configuring $preset failed"; }
    say "$preset: building with $JOBS jobs"
    cmake --build "$ROOT/build/$preset" -j "$JOBS" ${1:+--target "$@"}
}
mkdir -p "$ROOT/build"

# Shared by the commands of this folder: sourced, not run. For Debian 12; works in any directory.
set -euo pipefail
ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
export CCACHE_SLOPPINESS=pch_defines,time_macros
# These settings let other clones of the same sources share the cache.
export CCACHE_BASEDIR=$ROOT CCACHE_NOHASHDIR=1
export CCACHE_DEPEND=1  # a cold build is 10 % faster, because lookups need no preprocessing
JOBS=$(nproc)

say() { printf '\033[1m== %s\033[0m\n' "$*" >&2; }
die() { printf 'stylet: %s\n' "$*" >&2; exit 1; }

# stage NAME: begins a step of the command. Its time is printed when the command ends, however it ends.
STAGES=()
stage() {
    finish_stage
    STAGE=$1 STAGE_BEGIN=$SECONDS
    say "$1"
}
finish_stage() {
    [ -z "${STAGE:-}" ] || STAGES+=("$(printf '%5d s  %s' $((SECONDS - STAGE_BEGIN)) "$STAGE")")
    STAGE=
}
print_stages() {
    finish_stage
    [ ${#STAGES[@]} = 0 ] && return
    say "time per stage"
    printf '%s\n' "${STAGES[@]}" "$(printf '%5d s  in all' "$SECONDS")" >&2
}
trap print_stages EXIT

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"
    elif command -v sudo >/dev/null; then sudo "$@"
    else die "installing packages needs root or sudo; missing: ${MISSING[*]}"
    fi
}

# find_missing SECTION...: stores the sections' packages that are not installed in MISSING.
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

# install_packages SECTION...: installs the missing packages.
install_packages() {
    find_missing "$@"
    [ ${#MISSING[@]} = 0 ] && return
    command -v apt-get >/dev/null || die "this is not Debian; please install: ${MISSING[*]}"
    stage "installing ${#MISSING[@]} packages"
    printf '%s\n' "${MISSING[*]}" >&2
    as_root apt-get update -q || say "the package lists could not be refreshed (offline?); trying with what is known"
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -yq --no-install-recommends "${MISSING[@]}" ||
        die "could not install: ${MISSING[*]} (offline? bookworm and bookworm-security must be in the apt sources)"
}

# configure_and_build PRESET "CMAKE OPTIONS" TARGET...: builds the targets, or all if none is given.
configure_and_build() {
    local preset=$1 options=$2
    shift 2
    stage "$preset: configuring"
    # --fresh: without it, CMake loses the preset's settings if the compiler differs from the build folder's.
    # shellcheck disable=SC2086  # options are words
    (cd "$ROOT" && cmake --fresh --preset "$preset" $options >"$ROOT/build/$preset.configure.log" 2>&1) ||
        { tail -n 30 "$ROOT/build/$preset.configure.log" >&2; die "configuring $preset failed"; }
    stage "$preset: building with $JOBS jobs"
    NINJA_STATUS='[%f/%t %es] ' cmake --build "$ROOT/build/$preset" -j "$JOBS" ${1:+--target "$@"} | show_progress
}

# Copies ninja's output. On a terminal, progress is one line with an estimate of the time left, which assumes that the
# remaining steps take as long as the finished ones. Otherwise prints a line every ten seconds.
show_progress() {
    local line left shown=-10
    while IFS= read -r line; do
        if [[ ! $line =~ ^\[([0-9]+)/([0-9]+)\ ([0-9]+) ]]; then
            if [ -t 1 ]; then printf '\r\033[K'; fi
            printf '%s\n' "$line"
            continue
        fi
        local finished=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]} elapsed=${BASH_REMATCH[3]}
        left=$((finished > 0 ? elapsed * (all - finished) / finished : 0))
        if [ -t 1 ]; then
            printf '\r\033[K%d of %d steps, %d s, about %d s left' "$finished" "$all" "$elapsed" "$left"
            if [ "$finished" = "$all" ]; then printf '\n'; fi
        elif [ $((elapsed - shown)) -ge 10 ] || [ "$finished" = "$all" ]; then
            printf '%d of %d steps, %d s, about %d s left\n' "$finished" "$all" "$elapsed" "$left"
            shown=$elapsed
        fi
    done
    return 0
}

# option_of_release NAME DEFAULT: prints the release build's current value of a CMake option as -DNAME=VALUE.
option_of_release() {
    local value
    value=$(sed -n "s/^$1:BOOL=//p" "$ROOT/build/release/CMakeCache.txt" 2>/dev/null || true)
    printf -- '-D%s=%s' "$1" "${value:-$2}"
}
mkdir -p "$ROOT/build"

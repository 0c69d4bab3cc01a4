# Sourced by tests/run.sh, tests/bench/run.sh and samples/demo.sh: packages and build.
# Sets PHIZ_ROOT, PHIZ_BUILD and PHIZ_JOBS; says what it does on stderr.

PHIZ_ROOT="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
PHIZ_BUILD="$PHIZ_ROOT/build/release"

phiz_say() { printf '%s\n' "$*" >&2; }

# Names of packages.txt that are not installed, one a line.
phiz_missing_packages() {
  local name
  grep -v '^#' "$PHIZ_ROOT/.ci/packages.txt" | while read -r name; do
    [ -n "$name" ] || continue
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || printf '%s\n' "$name"
  done
}

# Installs what is missing. Touches nothing where all is there; goes on, and says so, where it cannot install.
phiz_install_packages() {
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    phiz_say "no apt-get here: the packages of .ci/packages.txt, under this system's names, have to be there already"
    return 0
  fi
  local missing as_root=()
  missing="$(phiz_missing_packages)"
  [ -n "$missing" ] || return 0
  phiz_say "installing:" $missing
  if [ "$(id -u)" != 0 ]; then
    if ! command -v sudo >/dev/null; then
      phiz_say "error: not root and no sudo; as root: apt-get install" $missing
      return 1
    fi
    as_root=(sudo)
  fi
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -q >&2 || return 1
  # shellcheck disable=SC2086  # one word a package
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends $missing >&2
}

# Compilers at once: one a core, and 2 GB each (OpenVDB's heaviest unit takes 1.8).
phiz_count_jobs() {
  local cores free_gb
  cores="$(nproc 2>/dev/null || echo 2)"
  free_gb="$(awk '/^MemAvailable:/ {print int($2 / 1000000)}' /proc/meminfo 2>/dev/null || echo 4)"
  local by_memory=$((free_gb / 2))
  [ "$by_memory" -ge 1 ] || by_memory=1
  if [ "$cores" -lt "$by_memory" ]; then echo "$cores"; else echo "$by_memory"; fi
}

# phiz_build [TARGET...]: configures the release preset and builds the targets (default: everything).
phiz_build() {
  local log
  log="$(mktemp)"
  if ! (cd "$PHIZ_ROOT" && cmake --preset release "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG") >"$log" 2>&1; then
    cat "$log" >&2
    rm -f "$log"
    phiz_say "error: the configuration failed (above)"
    return 1
  fi
  rm -f "$log"
  phiz_say "building in build/release with $PHIZ_JOBS at once"
  ninja -C "$PHIZ_BUILD" -j "$PHIZ_JOBS" "$@" >&2
}

PHIZ_JOBS="${PHIZ_JOBS:-$(phiz_count_jobs)}"

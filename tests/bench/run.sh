#!/usr/bin/env bash
# Figures, one a line: AREA | what | value | unit | bar | ok or SHORT.
#   bash tests/bench/run.sh fit            one area; several; `all`
#   bash tests/bench/run.sh fit --long     all rotations and kills (about an hour)
#   bash tests/bench/run.sh fit --json     JSON lines
#   bash tests/bench/run.sh store --long --record FILE    long runs in pieces: stop at will, the same command continues
# Ends with 1 where a figure falls short. Test scans: $PHIZ_DATA, by default ../shared/data.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../.ci/setup.sh"

known=(fit head fields adapt animate ship store)
areas=()
options=()
while [ "$#" -gt 0 ]; do
  word="$1"
  shift
  case "$word" in
    --json|--long) options+=("$word") ;;
    --only|--record) options+=("$word" "${1:?$word wants a value}"); shift ;;
    -h|--help) sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    all) areas+=("${known[@]}") ;;
    *)
      if ! printf '%s\n' "${known[@]}" | grep -qxF -- "$word"; then
        phiz_say "error: no area '$word'"
        phiz_say "hint: the areas are: ${known[*]} all"
        exit 2
      fi
      areas+=("$word")
      ;;
  esac
done
if [ "${#areas[@]}" = 0 ]; then
  phiz_say "error: no area named"
  phiz_say "hint: the areas are: ${known[*]} all"
  exit 2
fi

phiz_install_packages
phiz_build phiz "${areas[@]/#/phiz_bench_}"

PHIZ_COMMIT="$(git -C "$PHIZ_ROOT" rev-parse --short HEAD 2>/dev/null || echo unknown)"
[ -z "$(git -C "$PHIZ_ROOT" status --porcelain 2>/dev/null)" ] || PHIZ_COMMIT+=" with changes"
export PHIZ_COMMIT
code=0
for area in "${areas[@]}"; do
  "$PHIZ_BUILD/tests/bench/phiz_bench_$area" ${options[@]+"${options[@]}"} || code=1
done
exit "$code"

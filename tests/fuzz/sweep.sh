#!/usr/bin/env bash
# The long run, in pieces of a million inputs: every target until it has had its share. Stop it whenever you like, the
# same command continues; a piece that was recorded is not run again.
#   bash tests/fuzz/sweep.sh RECORD.csv [--runs 10000000] [TARGET...]
# RECORD.csv gets a line a piece: target, seed, runs, seconds, heap growth in bytes, result, commit. Bytes that were a
# finding are kept beside it. At the end: a table of all that is recorded; code 1 if anything was found.
# $PHIZ_FUZZ names another build of phiz_fuzz.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
program="${PHIZ_FUZZ:-$root/build/release/tests/fuzz/phiz_fuzz}"
piece=1000000
wanted=10000000
targets=()
record="${1:?a file to record in}"
shift
while [ "$#" -gt 0 ]; do
  case "$1" in
    --runs) wanted="$2"; shift 2 ;;
    *) targets+=("$1"); shift ;;
  esac
done
if [ "${#targets[@]}" = 0 ]; then
  for folder in "$root"/tests/fuzz/corpus/*/; do targets+=("$(basename "$folder")"); done
fi
record="$(realpath -m "$record")"
touch "$record"
commit="$(git -C "$root" rev-parse --short HEAD 2>/dev/null || echo unknown)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
cd "$work"

run_piece() { # TARGET SEED
  local said numbers result=ok
  said="$(PHIZ_FUZZ_TARGET="$1" "$program" "$root/tests/fuzz/corpus/$1" --runs "$piece" --seed "$2" 2>&1)" || result="code $?"
  numbers="$(sed -n 's/^\([0-9]*\) runs, \([0-9.e+]*\) s, heap grew by \(-\{0,1\}[0-9]*\) bytes$/\1,\2,\3/p' <<<"$said")"
  if [ "$result" != ok ]; then
    printf '%s: %s\n' "$1" "$said" >&2
    [ ! -e phiz-fuzz-last ] || mv phiz-fuzz-last "$(dirname "$record")/fuzz-$1-$2"
  fi
  printf '%s,%s,%s,%s,%s\n' "$1" "$2" "${numbers:-0,0,0}" "$result" "$commit" >>"$record"
}

for ((seed = 1; seed * piece <= wanted; ++seed)); do
  for target in "${targets[@]}"; do
    grep -q "^$target,$seed," "$record" || run_piece "$target" "$seed"
  done
done
sort "$record" | awk -F, '
  { runs[$1] += $3; seconds[$1] += $4; if ($5 > grew[$1]) grew[$1] = $5; if ($6 != "ok") found[$1] += 1; all += ($6 != "ok") }
  END { printf "| target | runs | seconds | heap grew by, bytes | found |\n|---|---|---|---|---|\n"; fflush()
        for (t in runs) printf "| %s | %d | %.0f | %d | %d |\n", t, runs[t], seconds[t], grew[t], found[t] | "sort"
        close("sort"); exit all > 0 }'

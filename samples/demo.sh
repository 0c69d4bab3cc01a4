#!/usr/bin/env bash
# From nothing to a head: installs packages, builds, scans a synthetic head, fits it, compares it with the truth.
#   bash samples/demo.sh [FOLDER]      default: ./phiz-demo
# Run it again and only what is missing is done.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../.ci/setup.sh"

folder="${1:-phiz-demo}"
mkdir -p "$folder"
folder="$(cd "$folder" && pwd)"
phiz_install_packages
phiz_build phiz phiz-engine

export PHIZ_STORE="$folder/store"
phiz="$PHIZ_BUILD/phiz"
subject=synth007
scan="$folder/scans/$subject.ply"

show() { printf '\n$ phiz %s\n' "${*//$folder\//}"; "$phiz" "$@"; }

# 300,000 points with noise, holes, hair and shoulders; in centimetres, turned and moved at random.
[ -e "$folder/subjects.json" ] || show synth -o "$folder" --seed 7 --units cm --rotate-seed 3
show fit "$scan" --views
show fit "$scan" --views
show evaluate "$subject" --truth "$folder/truth/$subject.ply" --truth-from-scan "$folder/subjects.json" \
  | tee "$folder/evaluation.txt"
for file in head.glb head.ply head.png; do
  show export "$subject" -o "$folder/$file"
done
show export "$subject" -o "$folder/head.obj" --level 3
show export "$subject" -o "$folder/control.obj" --level 0
"$phiz" store cat "$subject/align/silhouettes.png" >"$folder/silhouettes.png"
mkdir -p "$folder/views"
for view in ingest align fit_local fit_global subdivide closeups; do
  show export "$subject" --view "$view" -o "$folder/views/$view.png"
done

cat <<END

In $folder:
  scans/$subject.ply   the raw scan: 300,000 points, no known unit or axes, shoulders, hair, outliers
  head.png             look first: the fitted head from several sides
  views/               what each stage made, beside the scan, and distances in colour; closeups.png: ears, eyes, lips
  head.ply             the same surface at the finest level, mm, upright: open it in any viewer
  head.obj             one level coarser, with (u,v)
  control.obj          its control mesh: the same vertices, in the same places, for every person
  head.glb             the asset itself: control mesh for any glTF viewer, displacements for phiz
  silhouettes.png      how the generic head was aligned: grey both, red the scan alone, blue the head alone
  evaluation.txt       distances to the truth in truth/$subject.ply, by region and by confidence
  store/               every step, kept: 'phiz status', 'phiz why $subject fit_global', 'phiz store ls'
The program is $phiz. Fit a scan of your own: $phiz fit scan.ply
END

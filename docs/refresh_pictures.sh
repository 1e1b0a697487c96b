#!/usr/bin/env bash
# Makes the pictures of the documents anew: docs/refresh_pictures.sh [folder of the programs]
# It plans the demo's patient, palpates an aorta, and photographs the window on a virtual screen (Debian packages xvfb,
# fonts-noto-cjk and fontconfig); on two cores it takes about seven minutes. window-labels.png, window-conference.png, palpation-wound.png and
# report-view.png are made by hand.
set -euo pipefail
cd "$(dirname "$0")/.."
programs=$(realpath "${1:-build/release/bin}")
pictures=$PWD/docs/pictures
# Without a Japanese font the Japanese windows show boxes.
if [[ -z $(fc-list :lang=ja) ]]; then
  echo "no Japanese font is installed: install the Debian package fonts-noto-cjk" >&2
  exit 1
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

"$programs/retractor" demo --out demo
cp demo/intercostal_4-surgeon.png "$pictures/intercostal.png"
cp demo/median-surgeon.png "$pictures/demo-median.png"
cp demo/intercostal_4-slices.png "$pictures/demo-slices.png"

"$programs/retractor" render demo/patient/case.json --out maps --approach median --views surgeon --maps strain
cp maps/median-map-strain.png "$pictures/map-strain.png"

"$programs/retractor" search demo/patient/case.json --target aneurysm --out search
cp search/search-map.png "$pictures/search-map.png"

"$programs/retractor" ports demo/patient/case.json --target heart --side right --out ports
cp ports/ports-1.png "$pictures/ports.png"

"$programs/retractor" phantom thorax --out thorax
"$programs/retractor" import thorax/ct --labels thorax/labels.nrrd --out case/case.json
cp case/contact_sheet.png "$pictures/contact-sheet.png"

"$programs/retractor" phantom aorta --out aorta
"$programs/retractor" palpate aorta/aorta.json --press normal+sclerotic --out forces.csv
cp forces.png "$pictures/palpation-forces.png"
cp forces-view.png "$pictures/palpation.png"

LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s "-screen 0 1280x900x24 +extension GLX" \
  "$programs/retractor-workstation" demo/patient/case.json --approach intercostal_4 --screenshot "$pictures/window.png"
LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s "-screen 0 1280x900x24 +extension GLX" \
  "$programs/retractor-workstation" demo/patient/case.json --view slices --before --screenshot \
  "$pictures/window-slices.png"
LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s "-screen 0 1280x900x24 +extension GLX" \
  "$programs/retractor-workstation" --screenshot "$pictures/window-start.png"
LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s "-screen 0 1280x900x24 +extension GLX" \
  "$programs/retractor-workstation" --language ja --screenshot "$pictures/window-start-ja.png"
LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s "-screen 0 1280x900x24 +extension GLX" \
  "$programs/retractor-workstation" demo/patient/case.json --language ja --view compare --before --screenshot \
  "$pictures/window-ja.png"
LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s "-screen 0 1280x900x24 +extension GLX" \
  "$programs/retractor-workstation" demo/patient/case.json --view overview --wall see-through --before --screenshot \
  "$pictures/window-inside.png"
LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s "-screen 0 1280x900x24 +extension GLX" \
  "$programs/retractor-workstation" demo/patient/case.json --view incision --before --screenshot \
  "$pictures/window-incision.png"
LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s "-screen 0 1280x900x24 +extension GLX" \
  "$programs/retractor-workstation" demo/patient/case.json --view compare --before --screenshot \
  "$pictures/window-compare.png"

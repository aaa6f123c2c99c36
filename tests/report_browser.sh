#!/usr/bin/env bash
# tests/report_browser.sh QUERN NODE CHROMIUM PACKAGES: makes the reports of a small run, of a small sweep and of a diagnosis, and looks at them in a browser.
set -euo pipefail
quern=$1 node=$2 chromium=$3 packages=$4
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export HOME=$work  # where a browser keeps what it keeps
case=$here/../cases/planetary_250rpm/case.toml
short=(--set duration=0.5 --set observe.start=0.2 --set observe.power_interval=0.005)
"$quern" run "$case" "${short[@]}" --set output.frames=0.02 --out "$work/run" --quiet
"$quern" sweep "$case" --set mill.speed=200,250,300 --set duration=0.3 --set observe.start=0.1 --set output.frames=0.05 --out "$work/sweep" > "$work/sweep.txt"
spiked=$here/../cases/diagnose/spike_in/drops_drag
"$quern" diagnose "$spiked/case.toml" --recording "$spiked/recordings.csv" --out "$work/diagnosis" > "$work/diagnosis.txt"
"$node" "$here/../report/test/browser.js" "$packages" "$chromium" "$work/run/report.html" "$work/sweep/report.html" "$work/diagnosis/report.html"

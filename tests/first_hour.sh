#!/usr/bin/env bash
# tests/first_hour.sh QUERN PAGE: runs the commands of docs/first_hour.md as they stand there, in a fresh folder, and looks at what they promise.
set -euo pipefail
program=$(realpath "$1")
page=$(realpath "$2")
work=$(mktemp -d "${TMPDIR:-/tmp}/quern_hour_XXXXXX")
trap 'rm -rf "$work"' EXIT
QUERN=$(dirname "$(dirname "$page")")
PATH=$(dirname "$program"):$PATH
export QUERN PATH
awk '/^```sh$/ {inside = 1; next} /^```$/ {inside = 0} inside' "$page" > "$work/commands.sh"
[ "$(wc -l < "$work/commands.sh")" -gt 20 ] || { echo "The page has no commands."; exit 1; }
mkdir "$work/mill"
cd "$work/mill"
bash -euo pipefail "$work/commands.sh" > "$work/said" 2>&1 || { cat "$work/said"; echo "A command of the page fails."; exit 1; }

wrong=0
for picture in planetary/charge.png slow/charge.png fast/charge.png; do
  [ "$(head -c 4 "$picture" 2> /dev/null | tail -c 3)" = PNG ] && [ "$(stat -c %s "$picture")" -gt 20000 ] || { echo "$picture is no picture of a charge"; wrong=1; }
done
cmp -s slow/charge.png fast/charge.png && { echo "The speed makes no difference"; wrong=1; }
for file in slow/frames.pvd slow/files/drum_*.stl drops/report.html amended/summary.json; do
  [ -e "$file" ] || { echo "$file is missing"; wrong=1; }
done
grep -q 'air_drag' drops/diagnosis.json || { echo "The diagnosis does not name the drag"; wrong=1; }
grep -q '"power"' slow/summary.json || { echo "There is no power"; wrong=1; }
[ $wrong -eq 0 ] || cat "$work/said"
exit $wrong

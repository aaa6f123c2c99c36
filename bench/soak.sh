#!/usr/bin/env bash
# bench/soak.sh [HOURS] [QUERN]: runs a mill again and again, killed, stopped and resumed at random times. After every round the results must be
# those of the unbroken run, every table and frame, no other file may lie beside them, and neither memory nor open files may have grown during it.
# Takes Debian's hdf5-tools.
set -uo pipefail
hours=${1:-8}
quern=$(realpath "${2:-$(dirname "$0")/../build/release/quern}")
work=$(mktemp -d "${TMPDIR:-/tmp}/quern_soak_XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work"
cat > case.toml <<'CASE'
name = "soak"
duration = "20 s"
[material.steel]
density = 7800
young = "10 MPa"
[pair.default]
restitution = 0.6
friction = 0.5
[species.ball]
material = "steel"
diameter = "20 mm"
[mill]
type = "tumbling"
diameter = "0.3 m"
length = "0.1 m"
speed_fraction = 0.75
[insert.charge]
species = "ball"
filling = 0.35
[output]
frames = "0.2 s"
paraview = false
pictures = false
CASE
until_end=$(($(date +%s) + $(awk "BEGIN {print int(3600 * $hours)}")))
"$quern" run case.toml --quiet --out unbroken 2> error || { cat error; exit 1; }
without_clock() { sed '/"wall_clock"/,/}/d;/"particle_steps_per_second"/,/}/d' "$1"; }
rounds=0 breaks=0
while [ "$(date +%s)" -lt "$until_end" ]; do
  rm -rf broken
  resume=()
  while true; do
    "$quern" run case.toml --quiet --out broken --checkpoint 1 "${resume[@]}" > words 2> error &
    process=$!
    first= files=
    pause=$((RANDOM % 12 + 2))
    for ((second = 0; second < pause; ++second)); do
      sleep 1
      kill -0 $process 2> /dev/null || break
      now=$(awk '/VmRSS/ {print $2}' /proc/$process/status 2> /dev/null)
      [ -n "$first" ] || { first=$now; files=$(ls /proc/$process/fd 2> /dev/null | wc -l); }
      if [ -n "$now" ] && [ -n "$first" ] && [ "$now" -gt $((first + 200000)) ]; then echo "Memory grew from $first to $now kB."; exit 1; fi
      open=$(ls /proc/$process/fd 2> /dev/null | wc -l)
      [ "$open" -le $((files + 8)) ] || { echo "Open files grew from $files to $open."; exit 1; }
    done
    signal=KILL
    [ $((RANDOM % 2)) -eq 0 ] && signal=TERM
    kill -$signal $process 2> /dev/null
    wait $process
    status=$?
    [ $status -eq 0 ] && break
    [ $status -eq 143 ] || [ $status -eq 137 ] || { cat error; echo "It ended with status $status."; exit 1; }
    breaks=$((breaks + 1))
    resume=()
    [ -e broken/checkpoint ] && resume=(--resume)
  done
  rounds=$((rounds + 1))
  cmp -s <(without_clock unbroken/summary.json) <(without_clock broken/summary.json) || { echo "Round $rounds ended elsewhere than the unbroken run: its summary.json differs."; exit 1; }
  for table in unbroken/*.csv; do
    cmp -s "$table" "broken/${table##*/}" || { echo "Round $rounds ended elsewhere than the unbroken run: its ${table##*/} differs."; exit 1; }
  done
  h5diff -q unbroken/results.h5 broken/results.h5 || { echo "Round $rounds ended elsewhere than the unbroken run: its results.h5 differs."; exit 1; }
  left=$(diff <(ls -A unbroken) <(ls -A broken)) || { echo "Round $rounds left other files than the unbroken run: $left"; exit 1; }
  printf '\r%d rounds, broken off %d times, all as the unbroken run' $rounds $breaks
done
echo

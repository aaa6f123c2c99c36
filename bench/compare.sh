#!/usr/bin/env bash
# bench/compare.sh [--quick] [--yade] [--cpu-time] [--cores N] [--repeats N] [--only WORK] [--out DIR]
# The same work with quern, LIGGGHTS and LAMMPS (and YADE where asked), from the same positions, alternating, on one core and two.
#   --quick      a drum of 10,000 balls, few steps: under three minutes
#   --cores N    at most so many
#   --only WORK  just one of drum, bed, agglomerate
#   --cpu-time   one-core speeds per second of processor time: for a machine that others use too
# Writes DIR/results.csv (every run), DIR/physics.csv and DIR/table.md; prints the tables.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(dirname "$here")
out=$root/build/compare
quick=no yade=no cpu_time=no repeats= most_cores=2 only=
while [ $# -gt 0 ]; do
  case $1 in
    --quick) quick=yes ;;
    --yade) yade=yes ;;
    --cpu-time) cpu_time=yes ;;
    --cores) most_cores=$2; shift ;;
    --repeats) repeats=$2; shift ;;
    --only) only=$2; shift ;;
    --out) out=$2; shift ;;
    *) sed -n 2,8p "$0" | cut -c3-; exit 2 ;;
  esac
  shift
done
mkdir -p "$out"
out=$(cd "$out" && pwd)
cores=$(nproc)
export OMP_NUM_THREADS=1 LC_ALL=C

# --- the works: name balls settle[s] steps ---
if [ "$quick" = yes ]; then
  works=("drum 10000 0.5 800")
  skins=(0.0005 0.001 0.002) repeats=${repeats:-3}
else
  works=("drum 10000 1.5 2000" "drum 100000 1.5 200" "bed 32000 0.5 500" "agglomerate 10000 0 1000")
  skins=(0.0005 0.001 0.0015 0.002 0.003) repeats=${repeats:-5}
fi

if [ -n "$only" ]; then
  chosen=()
  for work in "${works[@]}"; do [ "${work%% *}" = "$only" ] && chosen+=("$work"); done
  [ ${#chosen[@]} -gt 0 ] || { echo "--only $only: no such work among: ${works[*]%% *}" >&2; exit 2; }
  works=("${chosen[@]}")
fi

# --- the programs ---
install() {  # PACKAGE PROGRAM
  command -v "$2" > /dev/null && return 0
  local as_root=
  [ "$(id -u)" = 0 ] || as_root='sudo -n'
  $as_root apt-get install -y --no-install-recommends "$1" > "$out/install_$1.log" 2>&1 ||
    { $as_root apt-get update > /dev/null 2>&1 && $as_root apt-get install -y --no-install-recommends "$1" > "$out/install_$1.log" 2>&1; } ||
    { echo "$1 cannot be installed here (see $out/install_$1.log); it is left out." >&2; return 1; }
}
codes=(quern)
if install liggghts liggghts; then codes+=(liggghts); fi
if install lammps lmp; then codes+=(lammps lammps_classic); fi
if [ "$yade" = yes ] && install yade yade; then codes+=(yade); fi

if [ -z "${QUERN_BENCH:-}" ]; then
  QUERN_BENCH=$root/build/release/quern_bench
  [ -x "$root/.ci/prepare" ] && "$root/.ci/prepare" release > "$out/prepare.log" 2>&1
  (cd "$root" && cmake --preset release -DQUERN_BENCH=ON && cmake --build --preset release --target quern_bench) > "$out/build.log" 2>&1 ||
    { echo "quern's bench program does not build; see $out/build.log" >&2; exit 1; }
fi

load=$(cut -d' ' -f1 /proc/loadavg)
{
  echo "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1), $cores cores; load average $load before the first run; $(date +%F)"
  awk -v l="$load" 'BEGIN { if (l > 0.5) print "Something else is running on this machine: the figures suffer." }'
  [ "$cores" -ge 2 ] || echo "Only one core: no runs on two."
} | tee "$out/machine.txt"

# Runs a code on a work. Sets `speed` [particle-steps/s] and `share` of the processor that it got; full output in last.log.
run_code() {  # CODE WORK BALLS CORES WARM STEPS SKIN SAMPLE
  local code=$1 work=$2 balls=$3 n=$4 warm=$5 steps=$6 skin=$7 sample=$8
  local start=$out/${work}_$balls.data log=$out/last.log means=$out/means.txt
  local turns=0 px=$n pz=1
  [ "$work" = drum ] && turns=1 px=1 pz=$n
  local vars=(-var start "$start" -var turns "$turns" -var warm "$warm" -var steps "$steps" -var skin "$skin" -var sample "$sample"
    -var means "$means" -var px "$px" -var py 1 -var pz "$pz")
  local mpi=()
  [ "$n" -gt 1 ] && mpi=(mpirun --allow-run-as-root --oversubscribe --bind-to none -np "$n")
  local command
  case $code in
    quern) command=("$QUERN_BENCH" --work "$work" --start "$start" --threads "$n" --warm "$warm" --steps "$steps" --sample "$sample") ;;
    quern_mesh) command=("$QUERN_BENCH" --work "$work" --start "$start" --threads "$n" --warm "$warm" --steps "$steps" --sample "$sample" --mesh 10000) ;;
    liggghts) command=("${mpi[@]}" liggghts -in "$here/peers/in.liggghts" -log none "${vars[@]}") ;;
    lammps) command=("${mpi[@]}" lmp -in "$here/peers/in.lammps" -log none -var law granular "${vars[@]}") ;;
    lammps_classic) command=("${mpi[@]}" lmp -in "$here/peers/in.lammps" -log none -var law classic "${vars[@]}") ;;
    yade)
      command=(yade -n -x -j"$n" "$here/peers/bed.py" "$start" "$warm" "$steps" "$sample" "$means")
      [ "$work" = agglomerate ] && command=(yade -n -x -j"$n" "$here/peers/agglomerate.py" "$start" "$warm" "$steps" "$(cat "$start.gap")")
      ;;
  esac
  local TIMEFORMAT=%P percent
  percent=$( { time (cd "$out" && "${command[@]}" > "$log" 2>&1 < /dev/null) ; } 2>&1 ) || { echo "$code failed on $work $balls; see $log" >&2; return 1; }
  share=$(awk -v p="$percent" -v n="$n" 'BEGIN { s = p / 100 / n; print (s > 1 ? 1 : s) }')
  case $code in
    quern | quern_mesh | yade) speed=$(awk '$1 == "speed" { print $2 }' "$log") ;;
    *) speed=$(awk -v b="$balls" '/^Loop time of/ { s = $4; n = $9 } END { if (s > 0) printf "%.6g", b * n / s }' "$log") ;;
  esac
  [ -n "$speed" ] || { echo "$code gave no speed on $work $balls; see $log" >&2; return 1; }
}

# Whether a code can do a work: YADE's periodic space holds the bed only; of the peers, bonds are tried with YADE alone.
does() {
  case $1 in
    quern*) true ;;
    yade) [ "$2" != drum ] ;;
    *) [ "$2" != agglomerate ] ;;
  esac
}

# --- the common starts ---
for work in "${works[@]}"; do
  read -r name balls settle _ <<< "$work"
  start=$out/${name}_$balls.data stamp="$name $balls $settle"
  [ -e "$start" ] && [ "$(cat "$start.stamp" 2> /dev/null)" = "$stamp" ] && continue
  if [ "$name" = agglomerate ]; then
    # One step, so that it tells the gap within which it bonds.
    "$QUERN_BENCH" --work agglomerate --balls "$balls" --steps 1 --write "$start" | awk '$1 == "bonds" { print $5 / 1000 }' > "$start.gap"
    echo "$stamp" > "$start.stamp"
    continue
  fi
  echo "Settling: $name, $balls balls." >&2
  "$QUERN_BENCH" --work "$name" --balls "$balls" --copies $((balls > 20000 && balls % 10000 == 0 ? balls / 10000 : 1)) --settle "$settle" \
    --threads "$cores" --steps 0 --write "$start"
  echo "$stamp" > "$start.stamp"
done

# --- the best skin of each peer on each work ---
declare -A best_skin
for work in "${works[@]}"; do
  read -r name balls _ steps <<< "$work"
  for code in "${codes[@]}"; do
    does "$code" "$name" || continue
    case $code in quern | yade) best_skin[$code $name $balls]=0; continue ;; esac
    best=0
    for skin in "${skins[@]}"; do
      run_code "$code" "$name" "$balls" 1 50 $((steps / 4)) "$skin" 0 || continue
      rate=$(awk -v v="$speed" -v s="$share" 'BEGIN { printf "%d", v / s }')
      if [ "$rate" -gt "$best" ]; then best=$rate best_skin[$code $name $balls]=$skin; fi
    done
    echo "Skin of $code on $name $balls: ${best_skin[$code $name $balls]:-none works} m" >&2
  done
done

# --- the physics, before the timing ---
echo "work,balls,code,kinetic [J],contacts per ball,torque on the balls [N m]" > "$out/physics.csv"
for work in "${works[@]}"; do
  read -r name balls _ steps <<< "$work"
  [ "$name" = agglomerate ] && continue  # what is left of the bonds stands in the logs
  for code in "${codes[@]}"; do
    does "$code" "$name" || continue
    [ -n "${best_skin[$code $name $balls]:-}" ] || continue
    run_code "$code" "$name" "$balls" 1 0 "$steps" "${best_skin[$code $name $balls]}" 20 || continue
    case $code in
      quern) means=$(awk '$1 == "kinetic" { k = $2 } $1 == "contacts" { c = $2 } $1 == "torque" { t = $2 } END { print k "," c "," t }' "$out/last.log") ;;
      *) means=$(awk '!/^#/ && $1 > 0 { k += $2; c += $3; t += $4; n++ } END { if (n) printf "%.6g,%.5g,%.6g", k / n, c / n, t / n }' "$out/means.txt") ;;
    esac
    [ "$name" = bed ] && means=${means%,*},
    echo "$name,$balls,$code,$means" | tee -a "$out/physics.csv" >&2
  done
done

# --- the timing: A B C A B C … ---
echo "work,balls,code,cores,repeat,particle-steps/s,processor share" > "$out/results.csv"
for repeat in $(seq "$repeats"); do
  for work in "${works[@]}"; do
    read -r name balls _ steps <<< "$work"
    for n in 1 2; do
      [ "$n" -le "$cores" ] && [ "$n" -le "$most_cores" ] || continue
      timed=("${codes[@]}")
      [ "$name" = drum ] && [ "$n" = 1 ] && timed+=(quern_mesh)
      for code in "${timed[@]}"; do
        does "$code" "$name" || continue
        skin=0
        case $code in quern*) ;; *) skin=${best_skin[$code $name $balls]:-} ;; esac
        [ -n "$skin" ] || continue
        run_code "$code" "$name" "$balls" "$n" 100 "$steps" "$skin" 0 || continue
        echo "$name,$balls,$code,$n,$repeat,$speed,$share" >> "$out/results.csv"
        if [ "$repeat" = 1 ] && [ "$n" = 1 ]; then
          cp "$out/last.log" "$out/${code}_${name}_$balls.log"
        fi
      done
    done
  done
  echo "Repeat $repeat of $repeats done." >&2
done

# --- the tables ---
{
  cat "$out/machine.txt"
  echo
  if [ "$cpu_time" = yes ]; then
    echo "Million particle-steps per second, median (least–greatest) of $repeats; one core: per second of processor time."
  else
    echo "Million particle-steps per second, median (least–greatest) of $repeats."
  fi
  echo
  echo "| work | balls | cores | code | speed | quern is faster by |"
  echo "|---|---|---|---|---|---|"
  tail -n +2 "$out/results.csv" | awk -F, -v cpu="$cpu_time" '{ v = $6 / 1e6; if (cpu == "yes" && $4 == 1) v /= $7; print $1, $2, $4, $3, v }' |
    sort -k1,1r -k2,2n -k3,3n -k4,4 -k5,5g |
    awk '
      { key = $1 " " $2 " " $3 " " $4; if (!(key in n)) order[++keys] = key; value[key, ++n[key]] = $5 }
      function median(k) { m = n[k]; return m % 2 ? value[k, (m + 1) / 2] : (value[k, m / 2] + value[k, m / 2 + 1]) / 2 }
      END {
        for (i = 1; i <= keys; i++) {
          k = order[i]; split(k, w, " "); ours = w[1] " " w[2] " " w[3] " quern"
          printf "| %s | %s | %s | %s | %.2f (%.2f–%.2f) | %s |\n", w[1], w[2], w[3], w[4], median(k), value[k, 1], value[k, n[k]],
                 w[4] == "quern" ? "" : sprintf("%.2f", median(ours) / median(k))
        }
      }'
  echo
  echo "The same physics? Means over the steps timed, from the same start."
  echo
  awk -F, '{ gsub(/,/, " | "); print "| " $0 " |" } NR == 1 { print "|---|---|---|---|---|---|" }' "$out/physics.csv"
  echo
  echo "Memory per ball as each tells it (quern: all that the process ever had resident)."
  echo
  for log in "$out"/*_*_*.log; do
    case $log in *install_*) continue ;; esac
    tag=$(basename "$log" .log)
    awk -v tag="$tag" '
      BEGIN { balls = tag; sub(/.*_/, "", balls) }
      $1 == "memory" { m = $2 }
      /Memory usage per processor/ { m = $6 * 1048576 / balls }
      /Per MPI rank memory allocation/ { m = $(NF - 1) * 1048576 / balls }
      END { if (m) printf "- %s: %.0f bytes\n", tag, m }' "$log"
  done
} > "$out/table.md"
cat "$out/table.md"

#!/usr/bin/env bash
# fuzz/nightly.sh [SECONDS FOR EACH READER] [READER …]: builds the fuzzers (needs Debian's clang) and lets each look for inputs that break its
# reader, on one core. Begins from the small corpora of this folder; what it finds on the way grows in build/fuzz/corpus. A finding is kept in
# build/fuzz/findings and ends the script with status 1.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-600}
shift || true
readers=("$@")
[ ${#readers[@]} -gt 0 ] || readers=(case stl table recording study script checkpoint results)
command -v clang++ > /dev/null || { echo "The fuzzers need clang: apt-get install clang" >&2; exit 1; }
[ -f build/fuzz/build.ninja ] || cmake --preset fuzz > /dev/null
cmake --build build/fuzz --target "${readers[@]/#/fuzz_}" -- --quiet
mkdir -p build/fuzz/findings
found=0
for reader in "${readers[@]}"; do
  corpus=build/fuzz/corpus/$reader
  mkdir -p "$corpus"
  QUERN_SEEDS=$corpus "build/fuzz/fuzz/fuzz_$reader" -runs=0 > /dev/null 2>&1 || true
  seeds=("$corpus")
  [ -d "fuzz/corpus/$reader" ] && seeds+=("fuzz/corpus/$reader")
  dictionary=()
  [ -f "fuzz/$reader.dict" ] && dictionary=("-dict=fuzz/$reader.dict")
  log=build/fuzz/$reader.log
  if nice -n 15 "build/fuzz/fuzz/fuzz_$reader" "${dictionary[@]}" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 -malloc_limit_mb=1024 -max_len=65536 \
    -artifact_prefix="build/fuzz/findings/$reader-" -print_final_stats=1 "${seeds[@]}" > "$log" 2>&1; then
    printf '%-12s %s inputs, nothing found\n' "$reader" "$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")"
  else
    found=1
    printf '%-12s FOUND: %s\n' "$reader" "$(grep -m1 -E 'SUMMARY|ERROR' "$log")"
  fi
done
exit $found

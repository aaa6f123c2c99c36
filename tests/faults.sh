#!/usr/bin/env bash
# tests/faults.sh QUERN: breaks runs on purpose, more than forty ways. Each time quern must say in one line what is wrong and with which file,
# end with the promised status, leave a results.h5 that opens, and, once the fault is gone, end where the unbroken run ends.
set -uo pipefail
quern=$(realpath "$1")
work=$(mktemp -d "${TMPDIR:-/tmp}/quern_faults_XXXXXX")
mounted=()
clean_up() {
  for folder in "${mounted[@]}"; do umount -l "$folder" 2>/dev/null; done
  rm -rf "$work"
}
trap clean_up EXIT
# What the caller has open would count among ours.
for file in /proc/$$/fd/*; do
  file=${file##*/}
  if [ "$file" -gt 2 ] && [ "$file" -ne 255 ]; then eval "exec $file>&-"; fi
done
cd "$work"
chmod 755 .

cat > case.toml <<'CASE'
name = "faults"
duration = "0.2 s"
[material.steel]
density = 7800
young = "100 MPa"
poisson = 0.3
[pair.steel.steel]
law = "hertz_mindlin"
restitution = 0.6
friction = 0.5
[species.ball]
material = "steel"
diameter = "25 mm"
[mill]
type = "tumbling"
diameter = "0.3 m"
length = "0.12 m"
speed_fraction = 0.7
material = "steel"
[insert.charge]
species = "ball"
method = "packing"
filling = 0.4
[output]
frames = "0.01 s"
pictures = false
CASE
root=no
[ "$(id -u)" -eq 0 ] && root=yes
instrumented=no
grep -q __asan_init "$quern" && instrumented=yes
waits=yes  # a signal reaches a program that waits for a file to open, but not under the thread sanitizer
grep -q __tsan_init "$quern" && instrumented=yes waits=no
[ $instrumented = yes ] && sed -i 's/"0.2 s"/"0.1 s"/; s/"0.01 s"/"0.005 s"/' case.toml  # they are ten times slower

# ---- what is asked of every fault

faults=0 failures=0 name=
fault() { name=$1; faults=$((faults + 1)); }
wrong() {
  echo "FAILED  $name: $*"
  sed 's/^/        stderr: /' error | head -5
  failures=$((failures + 1))
}
skip() { echo "skipped $1: $2"; }

# run_in FOLDER WORDS…: a quiet run of the case; its status in $status, what it says in ./error
run_in() {
  local folder=$1
  shift
  "$quern" run case.toml --quiet --out "$folder" "$@" > words 2> error
  status=$?
}

# says STATUS PATTERN…: the run before ended so, with one line that has all the patterns
says() {
  [ "$status" -eq "$1" ] || wrong "exit status $status instead of $1"
  shift
  [ "$(wc -l < error)" -eq 1 ] || wrong "$(wc -l < error) lines instead of one"
  grep -q '\.$' error || wrong "no sentence"
  grep -qiE 'terminate called|abort|core dumped|traceback|HDF5-DIAG|vtk|sanitizer|unforeseen' error && wrong "no words for a user"
  local pattern
  for pattern in "$@"; do grep -qE -- "$pattern" error || wrong "does not say \"$pattern\""; done
}

# opens FOLDER: every number that results.h5 has can be read
opens() { h5dump -o /dev/null "$1/results.h5" > /dev/null 2> dump || wrong "results.h5 does not open: $(head -1 dump)"; }

without_clock() { sed '/"wall_clock"/,/}/d;/"particle_steps_per_second"/,/}/d' "$1"; }

# same FOLDER: it holds what the unbroken run left, but for the clock on the wall
same() {
  local file summary=/observables/summary
  h5diff --exclude-path /h5md --exclude-path $summary/wall_clock --exclude-path $summary/particle_steps_per_second \
    unbroken/results.h5 "$1/results.h5" > dump 2>&1 || wrong "results.h5 differs: $(head -2 dump | tr '\n' ' ')"
  diff <(without_clock unbroken/summary.json) <(without_clock "$1/summary.json") > dump 2>&1 || wrong "summary.json differs: $(head -3 dump)"
  for file in $(cd unbroken && ls -- *.csv frames.pvd frames/*); do
    cmp -s "unbroken/$file" "$1/$file" || { wrong "$file differs"; break; }
  done
  file=$(cd "$1" && ls -d -- checkpoint* ./*.journal ./*.part frames/*.part 2> /dev/null)
  [ -z "$file" ] || wrong "left behind: $file"
}

# goes_on FOLDER WORDS…: with --resume to the end, without a word
goes_on() {
  run_in "$@" --resume
  [ "$status" -eq 0 ] && [ ! -s error ] || wrong "--resume ends with status $status"
  same "$1"
}
begins_anew() {
  run_in "$@"
  [ "$status" -eq 0 ] && [ ! -s error ] || wrong "beginning anew ends with status $status"
  same "$1"
}

# start FOLDER WORDS…: in the background, with a checkpoint whenever the run looks at the clock; returns once there are two
start() {
  local folder=$1
  shift
  "$quern" run case.toml --quiet --checkpoint 0 --out "$folder" "$@" > words 2> error &
  process=$!
  until [ -e "$folder/checkpoint.previous" ] || ! kill -0 $process 2> /dev/null; do sleep 0.005; done
}
finish() {
  wait $process 2> /dev/null
  status=$?
}

run_in unbroken
[ "$status" -eq 0 ] || { cat error; echo "The case itself does not run."; exit 1; }

# ---- signals

for signal in HUP:129 INT:130 TERM:143; do
  fault "SIG${signal%:*}"
  start broken
  until [ -e broken/frames/balls_000004.vtp ]; do sleep 0.005; done
  kill "-${signal%:*}" $process
  finish
  says "${signal#*:}" 'Stopped at t = ' 'broken/checkpoint' '--resume'
  opens broken
  [ -d stopped ] || { [ -e broken/checkpoint.previous ] && cp -r broken stopped; }
  goes_on broken
  rm -rf broken
done

fault "SIGINT twice at once is one wish"
start broken
kill -INT $process
kill -INT $process
finish
says 130 'Stopped at t = ' '--resume'
goes_on broken
rm -rf broken

if [ $waits = yes ]; then
  fault "SIGINT again while the run is ending"
  start broken
  mkfifo broken/energy.csv.part  # nobody reads: writing the table takes for ever
  kill -INT $process
  sleep 1
  kill -INT $process
  finish
  says 130 'Stopped at once' 'checkpoint'
  opens broken
  rm broken/energy.csv.part
  goes_on broken
  rm -rf broken

  fault "SIGINT before the run has begun"
  mkfifo slow.toml
  "$quern" run slow.toml --out broken > words 2> error &
  process=$!
  sleep 0.3
  kill -INT $process
  finish
  says 130 'before the run began' 'nothing was written'
  [ ! -e broken ] || wrong "a folder was made"
fi

fault "SIGKILL, again and again"
start broken
for pause in 0 0.03 0.06 0.01; do
  sleep $pause
  kill -KILL $process 2> /dev/null
  finish
  opens broken
  [ -e broken/checkpoint ] || break
  start broken --resume
done
kill -KILL $process 2> /dev/null
finish
if [ -e broken/checkpoint ]; then goes_on broken; else same broken; fi
rm -rf broken

# ---- streams

fault "whoever reads the output goes away"
"$quern" run case.toml --out broken 2>&1 | head -1 > words
status=${PIPESTATUS[0]}
[ "$status" -eq 0 ] || wrong "exit status $status"
same broken
rm -rf broken

fault "closed streams"
"$quern" run case.toml --out broken <&- >&- 2>&-
status=$?
: > error
[ "$status" -eq 0 ] || wrong "exit status $status"
same broken
rm -rf broken

fault "output into a full disk"
"$quern" run case.toml --out broken > /dev/full 2> progress
status=$?
grep -v '%  t = ' progress > error
says 1 'standard output' 'No space left'
same broken
rm -rf broken

# ---- the disk is full

fault "results.h5 over the limit of file sizes"
(ulimit -f 300; run_in broken; exit "$status")
status=$?
says 1 'broken/results.h5 cannot be written: File too large' 'stopped at t = ' 'begin anew'
opens broken
begins_anew broken
rm -rf broken

fault "results.h5 over the limit of file sizes after checkpoints"
(ulimit -f 300; run_in broken --checkpoint 0; exit "$status")
status=$?
says 1 'broken/[a-z.0-9]+ cannot be written: File too large' 'stopped at t = ' '--resume goes on'
opens broken
goes_on broken
rm -rf broken

# A link to /dev/full, where a file is written aside: a disk that is full for this file alone.
fault "no room for a checkpoint"
start broken
while kill -STOP $process && [ -e broken/checkpoint.new.part ]; do kill -CONT $process; sleep 0.003; done
ln -s /dev/full broken/checkpoint.new.part
kill -CONT $process
finish
says 1 'broken/checkpoint.new cannot be written: No space left' '--resume goes on from the checkpoint at t = '
opens broken
goes_on broken
rm -rf broken

fault "no room for a frame"
mkdir -p broken/frames
ln -s /dev/full broken/frames/balls_000010.vtp.part
run_in broken --checkpoint 0
says 1 'balls_000010.vtp cannot be written: No space left' '--resume goes on'
opens broken
goes_on broken
rm -rf broken

fault "no room for a table at the end"
mkdir broken
ln -s /dev/full broken/spectra.csv.part
run_in broken
says 1 'broken/spectra.csv cannot be written: No space left' 'begin anew'
opens broken
begins_anew broken
rm -rf broken

fault "no room for the summary at the end"
mkdir broken
ln -s /dev/full broken/summary.json.part
run_in broken --checkpoint 0
says 1 'broken/summary.json cannot be written: No space left' '--resume goes on'
opens broken
goes_on broken
rm -rf broken

fault "no room for the very first file"
mkdir broken
ln -s /dev/full broken/case.toml.part
run_in broken
says 1 'broken/case.toml cannot be written: No space left'
begins_anew broken
rm -rf broken

mkdir disk
if [ $root = yes ] && mount -t tmpfs -o size=1m quern_faults disk 2> /dev/null; then
  mounted+=("$work/disk")
  fault "a small disk that fills up"
  run_in disk/out --checkpoint 0
  says 1 'disk/out/.* cannot be written: No space left' 'stopped at t = '
  opens disk/out
  mount -o remount,size=64m disk
  goes_on disk/out
  rm -rf disk/out

  fault "a disk without a byte left at the start"
  head -c 64m /dev/zero > disk/filler 2> /dev/null
  run_in disk/out
  says 1 'disk/out.* cannot be (written|made)' 'No space left'
  rm -f disk/filler
  mount -o remount,size=64m disk
  begins_anew disk/out
  rm -rf disk/out

  fault "a disk that others fill during the run"
  start disk/out
  head -c 64m /dev/zero > disk/filler 2> /dev/null
  finish
  says 1 'disk/out/.* cannot be written: No space left' '--resume goes on'
  opens disk/out
  rm disk/filler
  goes_on disk/out
  rm -rf disk/out
  umount disk
else
  skip "small disks" "mounting them takes root"
fi

# ---- folders

fault "the output folder is a file"
: > broken
run_in broken
says 2 'broken' 'file of that name|exists|Not a directory'
run_in broken/below
says 2 'broken/below' 'Not a directory'
rm broken

fault "the output folder cannot be made"
run_in /proc/quern
says 2 '/proc/quern' 'No such file'

# Permissions stop everyone but root, who becomes nobody for this.
as_user=()
[ $root = yes ] && as_user=(setpriv --reuid 65534 --regid 65534 --clear-groups)
if "${as_user[@]}" "$quern" --version > words 2>&1; then
  fault "the output folder is not ours"
  mkdir -m 555 broken
  [ $root = yes ] && chown 65534 broken
  "${as_user[@]}" "$quern" run case.toml --quiet --out broken > words 2> error
  status=$?
  says 2 'broken' 'Permission denied'
  rmdir broken

  fault "the output folder becomes read-only"
  mkdir broken
  [ $root = yes ] && chown 65534 broken
  "${as_user[@]}" "$quern" run case.toml --quiet --checkpoint 0 --out broken > words 2> error &
  process=$!
  until [ -e broken/checkpoint.previous ] || ! kill -0 $process 2> /dev/null; do sleep 0.005; done
  chmod 555 broken
  finish
  says 1 'broken/.*: Permission denied' '--resume goes on'
  opens broken
  chmod 755 broken
  goes_on broken
  rm -rf broken
else
  skip "permissions" "nobody may not run $quern"
fi

fault "the output folder is removed during the run"
start broken
rm -rf broken 2> /dev/null
rm -rf broken 2> /dev/null
finish
says 1 'broken/.*: No such file' 'stopped at t = '
rm -rf broken

fault "two runs into one folder"
start broken
kill -STOP $process
mv error first_error
run_in broken
says 2 'broken' 'Another run'
kill -CONT $process
finish
mv first_error error
[ "$status" -eq 0 ] && [ ! -s error ] || wrong "the first run was disturbed"
same broken
rm -rf broken

# ---- checkpoints that were spoilt: the one before is used

if [ ! -e stopped/checkpoint.previous ]; then
  name="a stopped run with two checkpoints"
  wrong "there is none"
  exit 1
fi
length=$(stat -c %s stopped/checkpoint)
flip() { printf "\\x$(printf %02x $(($(od -An -tu1 -j "$2" -N1 "$1") ^ 64)))" | dd of="$1" bs=1 seek="$2" conv=notrunc status=none; }
spoil() { cp -r stopped broken; }
uses_previous() {
  run_in broken --resume
  says 0 'broken/checkpoint' "$1" 'the one before'
  same broken
  rm -rf broken
}

for cut in 0 7 23 40 $((length / 2)) $((length - 1)); do
  fault "the checkpoint is cut to $cut bytes"
  spoil
  truncate -s "$cut" broken/checkpoint
  uses_previous 'torn|not a checkpoint'
done
for place in 3 13 17 30 $((length / 2)) $((length - 1)); do
  fault "byte $place of the checkpoint is flipped"
  spoil
  flip broken/checkpoint "$place"
  uses_previous 'torn|damaged|not a checkpoint'
done
fault "a checkpoint of a later quern"
spoil
printf '\x63' | dd of=broken/checkpoint bs=1 seek=8 conv=notrunc status=none
uses_previous 'format 99'
fault "something else in the checkpoint's place"
spoil
cp case.toml broken/checkpoint
uses_previous 'not a checkpoint'
fault "the checkpoint is missing"
spoil
rm broken/checkpoint
uses_previous 'No such file'

fault "no checkpoint is left"
spoil
rm broken/checkpoint*
run_in broken --resume
says 2 'no checkpoint' 'broken/checkpoint' 'without --resume'
opens broken
cp stopped/checkpoint broken/
goes_on broken
rm -rf broken

fault "both checkpoints are torn"
spoil
truncate -s 1000 broken/checkpoint broken/checkpoint.previous
run_in broken --resume
says 2 'broken/checkpoint is torn' 'checkpoint.previous' 'without --resume'
opens broken
cp stopped/checkpoint broken/
goes_on broken
rm -rf broken

fault "the folder to go on in is missing"
run_in nowhere --resume
says 2 'nowhere' 'no run'
[ ! -e nowhere ] || wrong "a folder was made"

fault "the case was changed"
spoil
run_in broken --resume --set pair.steel.steel.friction=0.4
says 2 'broken/checkpoint' 'another case' 'friction'
opens broken
goes_on broken
rm -rf broken

fault "another number of threads"
spoil
goes_on broken --threads 3
rm -rf broken

# ---- results that were spoilt

refuses_results() {
  run_in broken --resume
  says 2 'broken/results.h5' "$@"
  [ -e broken/checkpoint ] || wrong "the checkpoint is gone"
  cp stopped/results.h5 broken/
  goes_on broken
  rm -rf broken
}
fault "results.h5 is missing"
spoil
rm broken/results.h5
refuses_results 'is missing' 'without --resume'
for cut in 0 100 $(($(stat -c %s stopped/results.h5) / 2)); do
  fault "results.h5 is cut to $cut bytes"
  spoil
  truncate -s "$cut" broken/results.h5
  refuses_results 'cut short|no HDF5 file' 'without --resume'
done
fault "results.h5 is a text"
spoil
cp case.toml broken/results.h5
refuses_results 'no HDF5 file'
fault "results.h5 is that of another case"
spoil
run_in other --set pair.steel.steel.friction=0.4 --set duration="1 ms"
mv other/results.h5 broken/
refuses_results 'another case'
rm -rf other
fault "results.h5 is that of a shorter run"
spoil
mkdir -p other/frames
ln -s /dev/full other/frames/balls_000002.vtp.part
run_in other
mv other/results.h5 broken/
refuses_results 'less than the'
rm -rf other

fault "results.h5 is locked by another program"
spoil
exec 9<> broken/results.h5
flock -x 9
run_in broken --resume
says 2 'broken/results.h5 is locked'
run_in broken
says 2 'broken/results.h5 is locked'
exec 9>&-
opens broken
goes_on broken
rm -rf broken

# ---- sweeps

sweep() {
  "$quern" sweep case.toml --set pair.steel.steel.friction=0.3,0.4 --set duration="50 ms" --out sweep > words 2> error
  status=$?
}
fault "no room for the table of a sweep"
mkdir sweep
ln -s /dev/full sweep/sweep.csv.part
sweep
says 1 'sweep/sweep.csv cannot be written: No space left'
sweep
[ "$status" -eq 0 ] && [ "$(wc -l < sweep/sweep.csv)" -eq 3 ] || wrong "the sweep does not go on"
rm -rf sweep

if [ $waits = yes ]; then
  fault "a sweep is stopped"
  mkdir -p sweep
  mkfifo sweep/sweep.csv.part  # nobody reads: the sweep waits here after its first run
  "$quern" sweep case.toml --set pair.steel.steel.friction=0.3,0.4 --set duration="50 ms" -j 1 --out sweep > words 2> error &
  process=$!
  until grep -q 1/2 words; do sleep 0.01; done
  kill -TERM $process
  sleep 0.7
  kill -TERM $process
  finish
  says 143 'Stopped at once'
  rm sweep/sweep.csv.part
  sweep
  [ "$status" -eq 0 ] && grep -q '1 of 2 runs are finished already' words && [ "$(wc -l < sweep/sweep.csv)" -eq 3 ] || wrong "the sweep does not go on"
  rm -rf sweep
fi

# ---- what the system gives

if [ $instrumented = no ]; then
  fault "too few open files"
  (ulimit -n 5; run_in broken; exit "$status")
  status=$?
  says 1 'broken/.*: Too many open files'
  begins_anew broken
  rm -rf broken

  fault "too little memory"
  sed 's/"25 mm"/"0.6 mm"/' case.toml > many.toml
  (ulimit -v 650000; "$quern" run many.toml --quiet --out broken > words 2> error)
  status=$?
  says 1 'memory' 'not enough'
  rm -rf broken
else
  skip "too few open files, too little memory" "the sanitizers themselves need more"
fi

echo "$faults faults, $failures failures"
[ $failures -eq 0 ]

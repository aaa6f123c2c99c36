#!/usr/bin/env bash
# ./test.sh: makes this machine ready (once), builds quern and passes all its tests.
# ./test.sh --sanitize address|thread: the same with GCC's sanitizers (address: of undefined behaviour too), in a build of its own.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
preset=release
if [ "${1:-}" = --sanitize ]; then
  case ${2:-} in
    address) preset=asan ;;
    thread) preset=tsan ;;
    *) echo "./test.sh --sanitize knows address and thread, not \"${2:-}\"." >&2; exit 2 ;;
  esac
  shift 2
  export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_stack_use_after_return=1}
  export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
  export TSAN_OPTIONS=${TSAN_OPTIONS:-halt_on_error=1}
fi
"$here/.ci/prepare" "$preset"
cd "$here"
exec ctest --test-dir "build/$preset" --output-on-failure -j "$(nproc)" --no-tests=error "$@"

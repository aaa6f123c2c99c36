#!/usr/bin/env bash
# ./test.sh: makes this machine ready (once), builds quern and passes all its tests.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
"$here/.ci/prepare" release
cd "$here"
exec ctest --test-dir build/release --output-on-failure -j "$(nproc)" --no-tests=error "$@"

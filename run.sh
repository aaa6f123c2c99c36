#!/usr/bin/env bash
# ./run.sh [CASE] [options of `quern run`]: makes this machine ready (once), builds quern, runs a case and says where its pictures are.
# CASE is a case file or a folder of cases/. Without one: a planetary mill.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
"$here/.ci/prepare" release
case=${1:-planetary_250rpm}
[ $# -eq 0 ] || shift
[ -e "$case" ] || case=$here/cases/$case
[ -d "$case" ] && case=$case/case.toml
exec "$here/build/release/quern" run "$case" "$@"

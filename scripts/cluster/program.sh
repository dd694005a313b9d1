# Sets OVERTET to the program's absolute path: $OVERTET, `overtet` on the PATH, or that of build/release. To be read with
# `.` by the scripts beside it.
# shellcheck shell=sh
if [ -z "${OVERTET:-}" ]; then
  OVERTET=$(command -v overtet) || OVERTET=$(dirname "$0")/../../build/release/bin/overtet
fi
if ! [ -x "$OVERTET" ] && ! command -v "$OVERTET" >/dev/null; then
  echo "error: $OVERTET: no such program; set OVERTET to the path of overtet, or build it: ./scripts/build release" >&2
  exit 2
fi
OVERTET=$(realpath "$(command -v "$OVERTET")")
export OVERTET

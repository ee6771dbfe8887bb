#!/usr/bin/env bash
# Lints the wire contract, checks its format, and compares it with the committed baseline.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
buf="${GENPHYS_BUF:-$root/build/tools/bin/buf}"
if ! command -v "$buf" >/dev/null; then
  echo "run_buf.sh: no buf at '$buf': run script/bootstrap --test, or name one with GENPHYS_BUF" >&2
  exit 1
fi

cd "$root/proto"
"$buf" lint || { echo "run_buf.sh: buf lint refuses what stands above" >&2; exit 1; }
"$buf" format --diff --exit-code || { echo "run_buf.sh: not formatted: run 'buf format -w' in proto/" >&2; exit 1; }
"$buf" breaking --against baseline.binpb || {
  echo "run_buf.sh: this breaks clients of the baseline; proto/README.md says how and when it may be renewed" >&2
  exit 1
}
echo "run_buf.sh: lint, format and baseline hold"

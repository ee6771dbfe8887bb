#!/bin/bash
# Runs the benchmark and reports what it found.
#
# Usage: run.sh <build folder> [--record] [options of bench_rpc; see its --help]
#
# The results and the report go to <build folder>/bench/rpc/. With --record they also become those of the tree:
# bench/results/rpc.json and docs/performance.md. The exit status is 1 if serving a step costs more than it may, or
# `Drive` gives less.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="${1:?a build folder is needed}"
shift
out="$build/bench/rpc"
record=()
arguments=()
for argument in "$@"; do
  if [[ "$argument" == --record ]]; then record=(--record); else arguments+=("$argument"); fi
done

mkdir -p "$out"
PYTHONPATH="$root/client/python" PYTHONDONTWRITEBYTECODE=1 "$build/bin/bench_rpc" \
  --server "$build/bin/genphysd" --python-client "$root/bench/rpc/python_client.py" --json "$out/rpc.json" \
  "${arguments[@]}"
exec /usr/bin/python3 "$root/bench/rpc/report.py" "$out" "${record[@]}"

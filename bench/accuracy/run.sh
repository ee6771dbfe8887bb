#!/bin/bash
# Runs the benchmark and reports what it found.
#
# Usage: run.sh <build folder> [--record] [options of bench_accuracy; see its --help]
#
# The results and the report go to <build folder>/bench/accuracy/. With --record they also become those of the tree:
# bench/results/accuracy.json and docs/accuracy.md. With --bars or --engine-only there is no report; the exit status
# of --bars says whether all goals are reached.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="${1:?a build folder is needed}"
shift
out="$build/bench/accuracy"
record=()
arguments=()
report=yes
for argument in "$@"; do
  case "$argument" in
    --record) record=(--record) ;;
    --bars | --engine-only | --list | --help | -h)
      report=no
      arguments+=("$argument")
      ;;
    *) arguments+=("$argument") ;;
  esac
done

mkdir -p "$out"
if [[ "$report" == no ]]; then exec "$build/bin/bench_accuracy" "${arguments[@]}"; fi
"$build/bin/bench_accuracy" --json "$out/accuracy.json" "${arguments[@]}"
exec /usr/bin/python3 "$root/bench/accuracy/accuracy_report.py" "$out" "${record[@]}"

#!/bin/bash
# Runs the benchmark and reports what it found.
#
# Usage: run.sh <build folder> [--record] [options of bench_scaling; see its --help]
#
# The results and the report go to <build folder>/bench/scaling/. With --record they also become those of the tree:
# bench/results/scaling.json, docs/scaling.md and its pictures. The exit status is 1 if a bar is missed.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="${1:?a build folder is needed}"
shift
out="$build/bench/scaling"
record=()
arguments=()
for argument in "$@"; do
  if [[ "$argument" == --record ]]; then record=(--record); else arguments+=("$argument"); fi
done
case " $* " in *" --list "* | *" --help "* | *" -h "*) exec "$build/bin/bench_scaling" "$@" ;; esac

mkdir -p "$out"
"$build/bin/bench_scaling" --server "$build/bin/genphysd" --json "$out/scaling.json" "${arguments[@]}"
exec /usr/bin/python3 "$root/bench/scaling/scaling_report.py" "$out" "${record[@]}"

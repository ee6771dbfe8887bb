#!/bin/bash
# Runs the stress suite and reports who stood it.
#
# Usage: run.sh <build folder> [--record] [options of bench_stability; see its --help]
#
# The results and the report go to <build folder>/bench/stability/. With --record they also become those of the tree:
# bench/results/stability.json and docs/stability.md. With --bars there is no report: the exit status says whether all
# goals are reached.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="${1:?a build folder is needed}"
shift
out="$build/bench/stability"
record=()
arguments=()
for argument in "$@"; do
  if [[ "$argument" == --record ]]; then record=(--record); else arguments+=("$argument"); fi
done
case " $* " in *" --bars "* | *" --list "* | *" --help "* | *" -h "*) exec "$build/bin/bench_stability" "$@" ;; esac

mkdir -p "$out"
"$build/bin/bench_stability" --json "$out/stability.json" "${arguments[@]}"
exec /usr/bin/python3 "$root/bench/stability/stability_report.py" "$out" "${record[@]}"

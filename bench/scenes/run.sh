#!/bin/bash
# Runs the benchmark and reports what it found.
#
# Usage: run.sh <build folder> [--record] [options of bench_scenes; see its --help]
#
# The results and the report go to <build folder>/bench/scenes/. With --record they also become those of the tree:
# bench/results/scenes.json, docs/scenes.md and its picture.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="${1:?a build folder is needed}"
shift
out="$build/bench/scenes"
record=()
arguments=()
for argument in "$@"; do
  if [[ "$argument" == --record ]]; then record=(--record); else arguments+=("$argument"); fi
done
case " $* " in *" --list "* | *" --help "* | *" -h "*) exec "$build/bin/bench_scenes" "$@" ;; esac

mkdir -p "$out"
"$build/bin/bench_scenes" --json "$out/scenes.json" "${arguments[@]}"
exec /usr/bin/python3 "$root/bench/scenes/scenes_report.py" "$out" "${record[@]}"

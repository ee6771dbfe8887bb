#!/bin/bash
# Runs the benchmark and reports what it found.
#
# Usage: run.sh <build folder> [--record] [--peers] [options of bench_accuracy; see its --help]
#
# The results and the report go to <build folder>/bench/accuracy/. With --record they also become those of the tree:
# bench/results/accuracy.json and docs/accuracy.md. With --bars or --engine-only there is no report; the exit status
# of --bars says whether all goals are reached.
#
# With --lanes errors alone are measured, with the lanes that leave bodies to the layer and without them, side by side
# (about 10 minutes); the exit status says whether they agree.
#
# With --peers other engines are measured in the same turns (bench/peers), which are installed first; their results are
# in accuracy-peers.json. Recorded ones stay when a later run is recorded without --peers. With --contender peer- too,
# only they are measured, and recorded beside what the tree has of ours.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="${1:?a build folder is needed}"
shift
out="$build/bench/accuracy"
record=()
arguments=()
report=yes
peers=no
lanes=no
for argument in "$@"; do
  case "$argument" in
    --record) record=(--record) ;;
    --peers) peers=yes ;;
    --lanes) lanes=yes ;;
    --bars | --engine-only | --list | --help | -h)
      report=no
      arguments+=("$argument")
      ;;
    *) arguments+=("$argument") ;;
  esac
done

mkdir -p "$out"
if [[ "$lanes" == yes ]]; then
  measure() { "$build/bin/bench_accuracy" --contender genphys --rounds 0 "$@" "${arguments[@]}"; }
  measure --json "$out/lanes-on.json" &
  on=$!
  measure --json "$out/lanes-off.json" --engine-only 2>"$out/lanes-off.log"
  wait "$on"
  exec /usr/bin/python3 "$root/bench/accuracy/lanes_report.py" "$out/lanes-on.json" "$out/lanes-off.json"
fi
if [[ "$peers" == yes ]]; then
  # Programs of peers are named from there.
  cd "$root"
  mapfile -t offered < <("$root/bench/peers/install.sh")
  for peer in "${offered[@]}"; do arguments+=(--peer "$peer"); done
fi
if [[ "$report" == no ]]; then exec "$build/bin/bench_accuracy" "${arguments[@]}"; fi
# Peers of an earlier run are no part of this one.
rm -f "$out/accuracy-peers.json"
"$build/bin/bench_accuracy" --json "$out/accuracy.json" --peers-json "$out/accuracy-peers.json" "${arguments[@]}"
exec /usr/bin/python3 "$root/bench/accuracy/accuracy_report.py" "$out" "${record[@]}"

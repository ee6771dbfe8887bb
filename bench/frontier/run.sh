#!/bin/bash
# Measures what the settings among which the presets were chosen cost and what they are good for, and reports it.
#
# Usage: run.sh <build folder> [--record]
#
# The results and the report go to <build folder>/bench/frontier/. With --record they also become those of the tree:
# bench/results/frontier.json, docs/presets.md and its picture.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="${1:?a build folder is needed}"
shift
out="$build/bench/frontier"
case "$*" in
  "" | --record) ;;
  *)
    sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 2
    ;;
esac

mkdir -p "$out"
problems=() trials=()
for problem in T.pile T.joints B3 B4; do problems+=(--problem "$problem"); done
for trial in S1 S2.1e2; do trials+=(--trial "$trial"); done
"$build/bin/bench_accuracy" --frontier --rate 60 --rounds 2 "${problems[@]}" --json "$out/accuracy.json"
"$build/bin/bench_stability" --frontier --seeds 3 "${trials[@]}" --json "$out/stability.json"
exec /usr/bin/python3 "$root/bench/frontier/frontier_report.py" "$out" "$@"

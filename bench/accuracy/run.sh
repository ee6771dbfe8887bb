#!/bin/bash
# Runs the benchmark and reports what it found.
#
# Usage: run.sh <build folder> [options of bench_accuracy; see its --help]
#
# The results go to <build folder>/bench/accuracy/.
set -euo pipefail

build="${1:?a build folder is needed}"
shift
out="$build/bench/accuracy"
mkdir -p "$out"
exec "$build/bin/bench_accuracy" --json "$out/accuracy.json" "$@"

# Shared by the scripts of this folder; sourced, never run.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
tools="$root/build/tools"
logs="$root/build/logs"
jobs="$(nproc)"
started_us="${EPOCHREALTIME/[.,]/}"

seconds_since() {  # <start in us>
  local us=$((${EPOCHREALTIME/[.,]/} - $1))
  printf '%d.%d' $((us / 1000000)) $((us % 1000000 / 100000))
}

say() { printf '[%6s s] %s\n' "$(seconds_since "$started_us")" "$*"; }

fail() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# step <title> <what to expect> <command>...: says what begins, runs it, says how long it took. The shell does not stop
# at a failing line of a function that runs under it: such functions join their commands with &&.
step() {
  local title="$1" expect="$2" begun="${EPOCHREALTIME/[.,]/}" status=0
  shift 2
  say "$title${expect:+ ($expect)}"
  "$@" || status=$?
  if ((status == 0)); then
    say "  done in $(seconds_since "$begun") s"
  else
    say "  FAILED after $(seconds_since "$begun") s"
  fi
  return "$status"
}

# quietly <name> <command>...: keeps the output in build/logs/<name>.log and shows its end only when the command fails.
quietly() {
  local log="$logs/$1.log"
  shift
  mkdir -p "$logs"
  "$@" >"$log" 2>&1 && return
  tail -n 40 "$log" >&2
  printf 'The whole output is in %s\n' "$log" >&2
  return 1
}

# help_if_asked <arguments>: prints the comment block under the script's first line, and leaves.
help_if_asked() {
  local argument
  for argument in "$@"; do
    case "$argument" in
      -h | --help)
        sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"
        exit 0
        ;;
    esac
  done
}

# configure <preset> [cmake arguments]: only when something asks for it, for a configure costs more than a warm build.
# A change of a CMakeLists.txt is found by the build itself, one of the presets is not.
configure() {
  local preset="$1"
  shift
  if [[ $# -eq 0 && "$root/build/$preset/build.ninja" -nt "$root/CMakePresets.json" ]]; then return; fi
  (cd "$root" && quietly "configure-$preset" cmake --preset "$preset" "$@")
}

# compile <preset> [targets]
compile() {
  local preset="$1"
  shift
  NINJA_STATUS='  [%f/%t, %e s] ' ninja -C "$root/build/$preset" -j "$jobs" "$@"
}

#!/bin/bash
# Gets the engines that peers need, and prints the peers that there are then, one a line as bench_accuracy --peer takes
# them. What cannot be had is named on the standard error, and the others come all the same.
#
# Usage: install.sh    (its lines are to be used in the folder of the tree)
. "$(dirname "${BASH_SOURCE[0]}")/../../script/lib.sh"
cd "$root"
here=bench/peers
venv=build/tools/peers

have_python() {  # <package>, as requirements.txt has it
  [[ -x "$venv/bin/pip" ]] || quietly peers-venv /usr/bin/python3 -m venv "$venv" || return
  quietly "peers-$1" "$venv/bin/pip" install --disable-pip-version-check -c "$here/requirements.txt" "$1"
}

have_node() {
  [[ "$here/node_modules/.package-lock.json" -nt "$here/package-lock.json" ]] ||
    (cd "$here" && quietly peers-npm npm ci --no-audit --no-fund)
}

offer_python() {  # <name> <package> <program and arguments>
  if have_python "$2" >&2; then
    echo "peer-$1=$venv/bin/python $here/$3"
  else
    say "peer $1 is left out: $2 cannot be installed" >&2
  fi
}

offer_python mujoco mujoco mujoco_peer.py
offer_python mujoco-rk4 mujoco "mujoco_peer.py --rk4"
offer_python drake drake drake_peer.py
offer_python pybullet pybullet pybullet_peer.py
if have_node >&2; then
  for name in jolt rapier; do echo "peer-$name=node $here/${name}_peer.mjs"; done
else
  say "peers jolt and rapier are left out: their packages cannot be installed" >&2
fi

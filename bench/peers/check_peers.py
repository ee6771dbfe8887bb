#!/usr/bin/python3
"""Runs the benchmark of accuracy with a peer that needs no package and checks that what must come out of it does.

Usage: check_peers.py <bench_accuracy>
"""

from __future__ import annotations

import json
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROUNDING = 1e-4
"""Relative: results are written with five digits."""


FRAGILE = """
input()
print('ok {"name": "Fragile", "version": "1", "settings": "ends at the first scene"}', flush=True)
input()
"""


def run(program: str, folder: pathlib.Path) -> dict:
    (folder / "fragile.py").write_text(FRAGILE)
    peers = {"euler": f"{sys.executable} {HERE / 'euler_peer.py'}",
             "fragile": f"{sys.executable} {folder / 'fragile.py'}", "absent": str(folder / "absent")}
    options = [word for name, command in peers.items() for word in ("--peer", f"peer-{name}={command}")]
    options += [word for name in ("A1", "A2", "A7", "C2") for word in ("--problem", name)]
    options += ["--contender", "peer-", "--rate", "60", "--rate", "1000", "--rounds", "1"]
    options += ["--json", str(folder / "ours.json"), "--peers-json", str(folder / "peers.json")]
    subprocess.run([program, *options], check=True, stderr=subprocess.DEVNULL)
    ours = json.loads((folder / "ours.json").read_text())
    assert not any(problem["results"] for problem in ours["problems"]), "peers are among our results"
    return json.loads((folder / "peers.json").read_text())


def problems_of(data: dict) -> list[str]:
    """What is not as it must be."""
    wrong = []
    if set(data["peers"]) != {"peer-euler", "peer-fragile"}:
        wrong.append(f"these answered: {sorted(data['peers'])}")
    for problem in data["problems"]:
        for rate, cell in problem["results"]["peer-euler"].items():
            where = f"{problem['id']} at 1/{rate}"
            if problem["id"].startswith("C2"):
                if cell.get("failure") != "contacts":
                    wrong.append(f"{where}: not refused, but {cell}")
            elif "error" not in cell or not cell["cpu"]:
                wrong.append(f"{where}: no answer, but {cell}")
            elif problem["euler_error"] is not None:
                wanted = problem["euler_error"] / int(rate)
                if abs(cell["error"] / wanted - 1) > ROUNDING:
                    wrong.append(f"{where}: {cell['error']}, and semi-implicit Euler comes to {wanted}")
        for rate, cell in problem["results"]["peer-fragile"].items():
            if "ended" not in cell.get("failure", ""):
                wrong.append(f"{problem['id']} at 1/{rate}: nobody saw that the program ended: {cell}")
    return wrong


def main(arguments: list[str]) -> int:
    with tempfile.TemporaryDirectory() as folder:
        wrong = problems_of(run(arguments[0], pathlib.Path(folder)))
    print("\n".join(wrong) or "The peer comes to what it must.")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

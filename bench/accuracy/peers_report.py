"""What the report of accuracy tells of peers: other engines that were measured like ours and the engines alone."""

from __future__ import annotations

import copy
import re
from typing import Any

from accuracy_numbers import FLOOR, Points, error_at, number, points, table

OURS = {"genphys-ode-balanced": "genphys, ODE", "genphys-bullet-balanced": "genphys, Bullet"}
PRESETS = ("fast", "balanced", "accurate")
# What becomes of a scene, in the column of an engine. The rest is what it does not have.
OUTCOMES = ("unstable", "slow")


def joined(data: dict[str, Any], peers: dict[str, Any]) -> dict[str, Any]:
    """Our results with those of peers in them. Costs of another run are as the fixed piece of arithmetic says that they
    would have been in ours."""
    data = copy.deepcopy(data)
    apart = data["date"] != peers["date"]
    scale = data["calibration"] / peers["calibration"] if apart else 1
    data["peers"] = {"about": peers["peers"], "date": peers["date"] if apart else None, "scale": scale}
    results = {problem["id"]: problem["results"] for problem in peers["problems"]}
    for problem in data["problems"]:
        for name, cells in results.get(problem["id"], {}).items():
            problem["results"][name] = {
                rate: cell | {"cpu": cell["cpu"] and cell["cpu"] * scale} for rate, cell in cells.items()}
    return data


def titles(data: dict[str, Any]) -> dict[str, str]:
    """Of peers, by contender."""
    return {name: about["name"] for name, about in data.get("peers", {}).get("about", {}).items()}


def ahead(problem: dict[str, Any], peer: str) -> list[tuple[float, float, float]]:
    """Where a peer is more accurate at a cost at which our model has an answer too, on either engine: the cost, its
    error and ours."""
    ours: list[Points] = [
        points(problem, f"genphys-{engine}-{preset}") for engine in ("ode", "bullet") for preset in PRESETS]
    found = []
    for cost, error in points(problem, peer):
        reached = [e for e in (error_at(line, cost) for line in ours if line) if e is not None]
        if reached and min(reached) > max(error, FLOOR) * 1.01:
            found.append((cost, error, min(reached)))
    return found


def ahead_table(data: dict[str, Any], problems: list[dict[str, Any]]) -> str:
    rows = [["problem", "peer", "at steps that cost (µs per s)", "its error", "ours at that cost"]]
    for problem in problems:
        for peer, title in titles(data).items():
            if found := ahead(problem, peer):
                worst = max(found, key=lambda each: each[2] / max(each[1], FLOOR))
                costs = f"{1e6 * found[0][0]:.3g}" + (f" to {1e6 * found[-1][0]:.3g}" if len(found) > 1 else "")
                rows.append([problem["id"], title, costs, number(worst[1]), number(worst[2])])
    if len(rows) == 1:
        return "Nowhere: at every cost at which both have an answer, ours is at least as accurate."
    return table(rows)


def cell_text(cell: dict[str, Any] | None) -> str:
    if cell is None:
        return "–"
    if "failure" in cell:
        return next((outcome for outcome in OUTCOMES if cell["failure"].startswith(outcome)), "–")
    return number(cell.get("error"))


def errors_table(data: dict[str, Any], problems: list[dict[str, Any]], rate: str) -> str:
    columns = OURS | titles(data)
    rows = [[f"peers, error at 1/{rate} s", *columns.values()]]
    for problem in problems:
        cells = {name: problem["results"].get(name, {}).get(rate) for name in columns}
        if any(cell for name, cell in cells.items() if name not in OURS):
            rows.append([problem["id"], *[cell_text(cell) for cell in cells.values()]])
    return table(rows) if len(rows) > 1 else ""


def costs_table(data: dict[str, Any], problems: list[dict[str, Any]]) -> str:
    columns = OURS | titles(data)
    rows = [["peers, ms per step of 1/60 s", *columns.values()]]
    for problem in problems:
        cells = [problem["results"].get(name, {}).get("60") for name in columns]
        if any(cells[len(OURS):]):
            rows.append([problem["title"], *[
                f"{1000 * cell['cpu'] / 60:.3g}" if cell and cell["cpu"] else cell_text(cell) for cell in cells]])
    return table(rows) if len(rows) > 1 else ""


def about_table(data: dict[str, Any]) -> str:
    return table([["peer", "version", "settings"], *[
        [about["name"], about["version"], about["settings"]] for about in data["peers"]["about"].values()]])


def _named(problem_ids: list[str], all_ids: list[str]) -> str:
    """Problems by their names; by that of the family alone where all of its variants are meant."""
    names: list[str] = []
    for each in problem_ids:
        head = re.match(r"[^.]*", each).group()
        whole = [other for other in all_ids if re.match(r"[^.]*", other).group() == head]
        name = head if set(whole) <= set(problem_ids) else each
        if name not in names:
            names.append(name)
    return ", ".join(names)


def failures_table(data: dict[str, Any]) -> str:
    """What each peer refused or came to grief at, and in which problems."""
    rows = [["peer", "why there is no answer", "problems"]]
    all_ids = [problem["id"] for problem in data["problems"]]
    for peer, title in titles(data).items():
        found: dict[str, list[str]] = {}
        for problem in data["problems"]:
            cells = problem["results"].get(peer, {})
            for rate, cell in cells.items():
                if "failure" in cell:
                    affected = found.setdefault(cell["failure"], [])
                    if problem["id"] not in affected:
                        affected.append(problem["id"])
        rows += [[title, why, _named(ids, all_ids)] for why, ids in found.items()]
    return table(rows) if len(rows) > 1 else ""


def where_measured(data: dict[str, Any]) -> str:
    peers = data["peers"]
    if peers["date"] is None:
        return "They were measured in the same run as ours, in the same turns."
    return (f"They were measured in a run of their own on {peers['date'][:10]}: their costs are multiplied by "
            f"{peers['scale']:.3g}, which is what the fixed piece of arithmetic took in our run over what it took in "
            "theirs.")


AHEAD = """The same rule, for any peer, against our model on either engine. Some peers have coordinates of joints, so
that joints cannot open, and MuJoCo with RK4 is of fourth order where nothing touches."""

ABOUT = """Other engines, in packages of their own, which `script/bench accuracy --peers` installs and takes along; in
the pictures they are the thin lines with open dots. Each is given the same scenes as ours and the engines alone, told
by a program of `bench/peers`, and measured by the same code. It has its own defaults, but for what a scene asks for.
The cost is the processor time that the program itself measures around its steps: calling the engine from Python or
Node counts, pipes and reading what came out do not. {where}"""

REFUSED = """What a peer cannot do it refuses, and nothing is built from something else: where it has no answer it shows
as –, and here is why. *unstable* is what blows up, at one step size at least, and *slow* what takes more than 20 s of
processor time for what is asked at once. Springs (A3) are asked of our model alone."""

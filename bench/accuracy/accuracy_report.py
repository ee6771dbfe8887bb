#!/usr/bin/python3
"""Tells what the benchmark of accuracy found out: a page and its pictures.

Usage: accuracy_report.py <folder with accuracy.json> [--record]
       accuracy_report.py --check

Page and pictures go beside accuracy.json; accuracy-peers.json is a part of it if it is there. With --record all become
those of the tree; a file in which nothing was measured leaves the recorded one as it is. With --check nothing is
written: it says whether the page of the tree is what the recorded results say.
"""

from __future__ import annotations

import json
import pathlib
import re
import sys
from typing import Any

from accuracy_numbers import FLOOR, Points, error_at, number, order, points, table
from accuracy_plot import STYLES, peer_styles, picture
import peers_report

TREE = pathlib.Path(__file__).resolve().parents[2]
RESULTS = TREE / "bench" / "results" / "accuracy.json"
PEERS = RESULTS.with_name("accuracy-peers.json")
PAGE = TREE / "docs" / "accuracy.md"

FAMILIES = {
    "A": ("Free bodies", "Nothing touches them."),
    "B": ("Joints", "Rods, tops and chains on hinges and balls."),
    "C1": ("Sticking and slipping", "A block on a slope near the angle that friction holds."),
    "C2": ("Sliding", "A block slides to a stop, in any direction."),
    "C3": ("Rolling", "A ball that slides until it rolls; ball and cylinder on a slope."),
    "C5": ("Bouncing", "Bodies fall 1 m; the truth is that every peak is e² times the one before."),
    "C6": ("Collisions", "Momentum and restitution decide all of it; smaller steps cannot help an engine that has another law."),
    "D": ("Changes", "What holds a body goes away at a known moment."),
}
_FAMILY_OF = {"A3": "B", "C19": "C3", "C7": "C6", "S4": "C6", "S13": "C6"}

REASONS: dict[str, str] = {
    "B3": "at that cost ODE takes shorter steps than we do; from half as much again on ours is ahead, by more and more",
    "B5": "at steps this coarse our errors still rise and fall with the step: it does not converge yet",
    "B11.hanging": "what only hangs is right to a millionth of its length in both; our error falls with the square of the "
                   "step, and begins higher",
    "C6.hung": "what a blow that joints pass on costs is paid once, however few the steps; from a third as much again on "
               "ours is ahead",
}
"""Why our model is not ahead at equal cost, by problem."""

RATES = ("60", "240", "1000")
COLUMNS = {
    "genphys-ode-balanced": "genphys, ODE",
    "genphys-bullet-balanced": "genphys, Bullet",
    "raw-ode-step": "ODE, direct",
    "raw-ode-quick": "ODE, quick",
    "raw-bullet": "Bullet",
}
RAW_OF = {"ode": ("raw-ode-step", "raw-ode-quick"), "bullet": ("raw-bullet",)}


def family_of(problem: str) -> str:
    head = re.match(r"[A-Z]\d*", problem).group()
    head = _FAMILY_OF.get(head, head)
    return head if head in FAMILIES else head[0]


def behind(problem: dict[str, Any], engine: str) -> list[tuple[str, float, float, float]]:
    """Where an engine alone is more accurate at a cost at which we have an answer too: whose point, its cost, its error
    and ours."""
    ours = [points(problem, f"genphys-{engine}-{preset}") for preset in ("fast", "balanced", "accurate")]
    found = []
    for raw in RAW_OF[engine]:
        for cost, error in points(problem, raw):
            reached = [e for e in (error_at(line, cost) for line in ours if line) if e is not None]
            if reached and min(reached) > max(error, FLOOR) * 1.01:
                found.append((raw, cost, error, min(reached)))
    return found


def errors_table(problems: list[dict[str, Any]], rate: str) -> str:
    rows = [["problem", f"error at 1/{rate} s, divided by", *COLUMNS.values(), "Euler predicts"]]
    for problem in problems:
        cells = [problem["results"].get(contender, {}).get(rate) for contender in COLUMNS]
        if not any(cells):
            continue
        euler = problem["euler_error"]
        rows.append([f"{problem['id']}: {problem['title']}", problem["error"],
                     *["–" if cell is None else number(cell.get("error")) for cell in cells],
                     "–" if euler is None else number(euler / int(rate))])
    return table(rows) if len(rows) > 1 else ""


def orders_table(problems: list[dict[str, Any]]) -> str:
    rows = [["problem", *COLUMNS.values()]]
    for problem in problems:
        if not problem["first_order"]:
            continue
        orders = [order(problem, contender) for contender in COLUMNS]
        if any(each is not None for each in orders):
            rows.append([problem["id"], *["exact" if each is None else f"{each:.1f}" for each in orders]])
    return table(rows) if len(rows) > 1 else ""


def costs_table(problems: list[dict[str, Any]]) -> str:
    contenders = [f"genphys-{engine}-{preset}" for engine in RAW_OF for preset in ("fast", "balanced", "accurate")]
    raw = ["raw-ode-quick", "raw-bullet"]
    columns = [(contender, "60") for contender in [*contenders, *raw]] + [(contender, "120") for contender in raw]
    rows = [["ms per 1/60 s", *contenders, *raw, *(f"{contender}, two steps" for contender in raw)]]
    for problem in problems:
        cells = [problem["results"].get(contender, {}).get(rate, {}).get("cpu") for contender, rate in columns]
        if not any(cells):
            continue
        row = [problem["title"]]
        for (contender, rate), cpu in zip(columns, cells):
            alone = problem["results"].get("raw-bullet" if "bullet" in contender else "raw-ode-quick", {})
            alone_cpu = alone.get("60", {}).get("cpu")
            ratio = f" ({cpu / alone_cpu:.2f} ×)" if cpu and alone_cpu and contender.startswith("genphys") else ""
            row.append(f"{1000 * cpu / 60:.3g}{ratio}" if cpu else "failed" if rate == "60" else "–")
        rows.append(row)
    return table(rows) if len(rows) > 1 else ""


def exceptions(problems: list[dict[str, Any]]) -> str:
    rows = [["problem", "engine alone", "at steps that cost (µs per s)", "its error", "ours at that cost", "why"]]
    for problem in problems:
        for engine in RAW_OF:
            found = behind(problem, engine)
            for raw in dict.fromkeys(each[0] for each in found):
                mine = [each for each in found if each[0] == raw]
                worst = max(mine, key=lambda each: each[3] / max(each[2], FLOOR))
                costs = f"{1e6 * mine[0][1]:.3g} to {1e6 * mine[-1][1]:.3g}" if len(mine) > 1 else f"{1e6 * mine[0][1]:.3g}"
                rows.append([problem["id"], COLUMNS[raw], costs, number(worst[2]), number(worst[3]),
                             REASONS.get(problem["id"], "not explained yet")])
    if len(rows) == 1:
        return "Nowhere: at every cost at which both have an answer, ours is at least as accurate."
    return table(rows)


def unexplained(data: dict[str, Any]) -> list[str]:
    """Problems in which an engine alone is ahead, and nobody has said why."""
    return [problem["id"] for problem in data["problems"]
            if problem["id"] not in REASONS and any(behind(problem, engine) for engine in RAW_OF)]


def machine(data: dict[str, Any]) -> str:
    about, versions = data["machine"], data["versions"]
    kind = "virtual " if about["virtual"] else ""
    engines = ", ".join(f"{name} {version}" for name, version in versions["engines"].items())
    return (f"Measured on {data['date'][:10]} on {about['processors']} {kind}processors ({about['processor']}), "
            f"{about['system']}, GCC {versions['compiler']}, engines {engines}. The fixed piece of arithmetic took "
            f"{1000 * data['calibration']:.3g} ms.")


def pictures(data: dict[str, Any]) -> dict[str, str]:
    """By file name."""
    drawn = {}
    for family in FAMILIES:
        problems = [each for each in data["problems"] if family_of(each["id"]) == family]
        panels = [(each["id"], {name: points(each, name) for name in each["results"]}) for each in problems]
        panels = [(name, lines) for name, lines in panels if any(len(line) > 1 for line in lines.values())]
        if panels:
            drawn[f"accuracy-{family.lower()}.svg"] = picture(panels, STYLES | peer_styles(peers_report.titles(data)))
    return drawn


def page(data: dict[str, Any]) -> str:
    drawn = pictures(data)
    parts = [INTRODUCTION.format(machine=machine(data)), "## Where an engine alone is ahead at equal cost", BEHIND,
             exceptions([each for each in data["problems"] if family_of(each["id"]) in FAMILIES])]
    if "peers" in data:
        parts += ["## Where a peer is ahead of us at equal cost", peers_report.AHEAD,
                  peers_report.ahead_table(data, [each for each in data["problems"] if family_of(each["id"]) in FAMILIES])]
    for family, (title, about) in FAMILIES.items():
        problems = [each for each in data["problems"] if family_of(each["id"]) == family]
        if not any(problem["results"] for problem in problems):
            continue
        parts += [f"## {title}", about, *[text for text in (errors_table(problems, rate) for rate in RATES[:2]) if text]]
        if orders := orders_table(problems):
            parts += ["Order of convergence, where smaller steps help:", orders]
        if "peers" in data:
            parts += [text for text in (peers_report.errors_table(data, problems, rate) for rate in RATES[:2]) if text]
        if f"accuracy-{family.lower()}.svg" in drawn:
            parts.append(f"![Error against cost: {title}](accuracy-{family.lower()}.svg)")
    large = [each for each in data["problems"] if each["id"].startswith("T.")]
    if costs := costs_table(large):
        parts += ["## Cost of large scenes", COSTS, costs]
    if "peers" in data:
        parts += [text for text in (peers_report.costs_table(data, large),) if text]
        parts += ["## Peers", peers_report.ABOUT.format(where=peers_report.where_measured(data)),
                  peers_report.about_table(data), peers_report.REFUSED]
        parts += [text for text in (peers_report.failures_table(data),) if text]
    return "\n\n".join(parts) + "\n"


INTRODUCTION = """# Accuracy

Written by `bench/accuracy/accuracy_report.py` from `bench/results/accuracy.json`, which `script/bench accuracy --record`
measures.

Every problem here has an answer that comes from elsewhere: a closed form, or an integration in 133 bits
(`bench/accuracy/references.py`). No engine's small step is the truth for another, for one that is wrong in a consistent
way would be right by it. Errors are divided by the size of what happens. *Euler predicts* is what semi-implicit Euler
must come to where it is known, half a step's change of velocity: an engine that shows it has that stepper and no other
fault.

* **genphys**: a world of our model, in this process, with the `balanced` preset and the automatic solver unless a column
  says otherwise; nobody sleeps, no events are recorded.
* **ODE, direct and quick**: ODE alone, `dWorldStep` and `dWorldQuickStep`, all parameters at their defaults, contacts
  with the pyramid approximation of friction, a sweep-and-prune space.
* **Bullet**: Bullet alone in double precision, all parameters at their defaults, nobody sleeps.

Costs are processor time of the whole process per simulated second: the least of several turns, which all contenders
take one after the other. {machine}"""

COSTS = """In parentheses: over the engine alone, which solves once in 1/60 s, as `fast` does. *Two steps*: it solves as often as
`balanced` does, where that was measured."""

BEHIND = """In each problem each point of an engine alone, with its cost and its error, is held against what our model on that
engine reaches at that cost with any preset and step size, if it has an answer at that cost. Errors below 1e-12 count as
equal. Where the engine alone is more accurate it is named, with the reason."""


def load(results: pathlib.Path, peers: pathlib.Path) -> dict[str, Any]:
    data = json.loads(results.read_text())
    return peers_report.joined(data, json.loads(peers.read_text())) if peers.is_file() else data


def record(folder: pathlib.Path) -> None:
    """Makes what was measured that of the tree."""
    RESULTS.parent.mkdir(exist_ok=True)
    for recorded in (RESULTS, PEERS):
        measured = folder / recorded.name
        if measured.is_file() and any(problem["results"] for problem in json.loads(measured.read_text())["problems"]):
            recorded.write_text(measured.read_text())
        elif recorded.is_file():
            print(f"{recorded.relative_to(TREE)} stays: nothing of it was measured")
    write(load(RESULTS, PEERS), PAGE)


def write(data: dict[str, Any], path: pathlib.Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page(data))
    for name, text in pictures(data).items():
        path.with_name(name).write_text(text)


def check() -> int:
    data = load(RESULTS, PEERS)
    wanted = {PAGE: page(data)} | {PAGE.with_name(name): text for name, text in pictures(data).items()}
    stale = [path for path, text in wanted.items() if not path.is_file() or path.read_text() != text]
    for path in stale:
        print(f"{path.relative_to(TREE)} is not what bench/results says: run script/bench accuracy --record")
    missing = unexplained(data)
    if missing:
        print(f"accuracy_report.py does not say why an engine alone is ahead in {', '.join(missing)}")
    return 1 if stale or missing else 0


def main(arguments: list[str]) -> int:
    if arguments == ["--check"]:
        return check()
    if not arguments or arguments[1:] not in ([], ["--record"]):
        print(__doc__, file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[0])
    write(load(folder / RESULTS.name, folder / PEERS.name), folder / PAGE.name)
    if arguments[1:]:
        record(folder)
    print(f"The report is {PAGE if arguments[1:] else folder / PAGE.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

#!/usr/bin/python3
"""Tells who stood the stress suite: a page.

Usage: stability_report.py <folder with stability.json> [--record]
       stability_report.py --check

The page goes beside stability.json. With --record both become those of the tree. With --check nothing is written: it
says whether the page of the tree is what the recorded results say.
"""

from __future__ import annotations

import json
import pathlib
import sys
from typing import Any

TREE = pathlib.Path(__file__).resolve().parents[2]
RESULTS = TREE / "bench" / "results" / "stability.json"
PAGE = TREE / "docs" / "stability.md"

COLUMNS = {
    "genphys-ode-fast": "ODE, fast", "genphys-ode-balanced": "ODE, balanced", "genphys-ode-accurate": "ODE, accurate",
    "genphys-bullet-fast": "Bullet, fast", "genphys-bullet-balanced": "Bullet, balanced",
    "genphys-bullet-accurate": "Bullet, accurate",
    "raw-ode-step": "ODE alone, direct", "raw-ode-quick": "ODE alone, quick", "raw-bullet": "Bullet alone",
}

PAGE_HEAD = """# Stability

Written by `bench/stability/stability_report.py` from `bench/results/stability.json`, which
`script/bench stability --record` measures.

Each trial has a limit for each number that it measures, and is passed if all hold for all of its seeds. A cell says how
many seeds passed, if not all, and the worst number of the first limit that was broken, or of the first one if none was.
*ODE* and *Bullet* are worlds of our model on that engine with a preset; *alone* is the engine with its defaults.
"""


def number(value: float | None) -> str:
    if value is None:
        return "no number"
    if value == 0 or 1e-3 <= abs(value) < 1e4:
        return f"{value:.3g}"
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def cell(trial: dict[str, Any], outcome: dict[str, Any] | None) -> str:
    if outcome is None:
        return "–"
    if "failure" in outcome and not outcome["worst"]:
        return "✗ " + outcome["failure"]
    worst = outcome["worst"]

    def broken(name: str) -> bool:
        return name in worst and (worst[name] is None or worst[name] > trial["limits"][name])

    shown = next((name for name in trial["limits"] if broken(name)), next(iter(trial["limits"])))
    value = f"{shown.replace('_', ' ')} {number(worst.get(shown))}"
    if outcome["passed"] == outcome["seeds"]:
        return f"✓ {value}"
    share = f" {outcome['passed']} of {outcome['seeds']}," if outcome["seeds"] > 1 else ""
    return f"✗{share} {value}"


def limits(trial: dict[str, Any]) -> str:
    return ", ".join(f"{name.replace('_', ' ')} ≤ {number(limit)}" for name, limit in trial["limits"].items())


def rows(data: dict[str, Any], contenders: list[str]) -> list[list[str]]:
    table = [["trial", "step, s", *[COLUMNS[contender] for contender in contenders]]]
    for trial in data["trials"]:
        rates = list(dict.fromkeys(outcome["rate"] for outcome in trial["outcomes"]))
        for rate in rates:
            at_rate = {each["contender"]: each for each in trial["outcomes"] if each["rate"] == rate}
            cells = [cell(trial, at_rate.get(contender)) for contender in contenders]
            if set(cells) != {"–"}:
                table.append([trial["id"], f"1/{rate}", *cells])
    return table


def markdown(table: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in [table[0], ["---"] * len(table[0]), *table[1:]])


def machine(data: dict[str, Any]) -> str:
    about, versions = data["machine"], data["versions"]
    engines = ", ".join(f"{name} {version}" for name, version in versions["engines"].items())
    return f"Taken on {data['date'][:10]}: {about['processor']}, {about['system']}, GCC {versions['compiler']}, {engines}."


def stacks_of(data: dict[str, Any]) -> dict[int, dict[str, Any]]:
    """Trials of stacks by their height, the lowest first."""
    stacks = {int(trial["id"].split(".")[1]): trial for trial in data["trials"] if trial["id"].startswith("S1.")}
    return dict(sorted(stacks.items()))


def tallest_of(data: dict[str, Any], contender: str) -> tuple[int, int]:
    """The highest stack that stands, and that passes, with every lower one; zero: none."""
    stands, still = 0, 0
    for count, trial in stacks_of(data).items():
        outcome = next((each for each in trial["outcomes"] if each["contender"] == contender), None)
        deviation = outcome["worst"].get("deviation") if outcome else None
        if deviation is None or deviation > trial["limits"]["deviation"]:
            break
        if outcome["passed"] == outcome["seeds"] and still == stands:
            still = count
        stands = count
    return stands, still


def tallest(data: dict[str, Any]) -> str:
    if not stacks_of(data):
        return ""
    table = [["", *COLUMNS.values()], ["stands: no cube off by 0.25 m"], ["still: all limits hold"]]
    for contender in COLUMNS:
        stands, still = tallest_of(data, contender)
        table[1].append(str(stands or "–"))
        table[2].append(str(still or "–"))
    return "## The tallest stack\n\nUnit cubes, 10 s, every seed.\n\n" + markdown(table) + "\n"


def page(data: dict[str, Any]) -> str:
    ours = [contender for contender in COLUMNS if contender.startswith("genphys")]
    alone = [contender for contender in COLUMNS if contender.startswith("raw")]
    meanings = [["trial", "what happens", "passed if"]]
    meanings += [[trial["id"], trial["title"], limits(trial)] for trial in data["trials"] if trial["outcomes"]]
    parts = [PAGE_HEAD + "\n" + machine(data) + "\n", tallest(data), "## Our model\n\n" + markdown(rows(data, ours)) + "\n",
             "## The engines alone\n\n" + markdown(rows(data, alone)) + "\n", "## The trials\n\n" + markdown(meanings) + "\n"]
    return "\n".join(part for part in parts if part)


def check() -> int:
    if PAGE.is_file() and PAGE.read_text() == page(json.loads(RESULTS.read_text())):
        return 0
    print("docs/stability.md is not what bench/results/stability.json says: run script/bench stability --record")
    return 1


def main(arguments: list[str]) -> int:
    if arguments == ["--check"]:
        return check()
    if not arguments or arguments[1:] not in ([], ["--record"]):
        print(__doc__, file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[0])
    text = (folder / "stability.json").read_text()
    target = folder / PAGE.name
    target.write_text(page(json.loads(text)))
    if arguments[1:]:
        RESULTS.parent.mkdir(exist_ok=True)
        RESULTS.write_text(text)
        PAGE.write_text(target.read_text())
    print(f"The report is {PAGE if arguments[1:] else target}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

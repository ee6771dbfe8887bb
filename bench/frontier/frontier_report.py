#!/usr/bin/python3
"""Tells what the settings cost and are good for among which the presets were chosen: a page and a picture.

Usage: frontier_report.py <folder with accuracy.json and stability.json> [--record]
       frontier_report.py --check

Both go beside the results. With --record they become those of the tree, and the results frontier.json. With --check
nothing is written: it says whether the page and the picture of the tree are what the recorded results say.
"""

from __future__ import annotations

import dataclasses
import json
import pathlib
import sys
from typing import Any

TREE = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TREE / "bench" / name) for name in ("accuracy", "stability")]

import accuracy_plot  # noqa: E402 the folders have to be known first
from stability_report import machine, markdown, tallest_of  # noqa: E402

RESULTS = TREE / "bench" / "results" / "frontier.json"
PAGE = TREE / "docs" / "presets.md"
PICTURE = TREE / "docs" / "presets.svg"

ENGINES = {"ode": "ODE", "bullet": "Bullet"}
PRESETS = {"ode": {1: "fast", 2: "balanced", 4: "accurate"}, "bullet": {1: "fast", 2: "balanced", 8: "accurate"}}
"""Names of presets by their substeps; their iterations are those that a setting leaves open."""

PAGE_HEAD = """# Presets

Written by `bench/frontier/frontier_report.py` from `bench/results/frontier.json`, which
`script/bench frontier --record` measures.

A preset of the Stepper is a number of substeps; each of them solves in 10 sweeps, more
where few contacts hang together, and with a direct solver where islands are small enough for it. With joints that
is up to 160 rows, in `fast` 60 unless one body weighs 50 times as much as another: three for each point of contact,
and one for each way that a joint holds. (Figures of ODE were
measured with its own sweeps, of which there were 16, before the layer swept contacts.)
This page is why these numbers: what other settings cost, at steps of 1/60 s, and what they are good for.

* **pile**: milliseconds of processor time for a step of 1,000 boxes that lie in a pile and are kept awake.
* **joints**: the same of 20 swinging chains of 10 links.
* **stands**, **still**: the tallest stack of unit cubes that stands for 10 s, and that passes all limits of
  [S1](stability.md), with every lower one.
* **100:1**: how deep a cube of 100 kg sinks on one of 1 kg (S2), in millimetres.
* **rods**, **top**: error of two rods in a row and of a fast top on its tip (B3 and B4 of [accuracy](accuracy.md)).

In **bold**: the presets. A setting is on the *frontier* if none that costs less in the pile is as good in every
column.
"""


@dataclasses.dataclass
class Setting:
    """What one setting of one engine came to. Smaller is better in all but `stands` and `still`."""

    engine: str
    substeps: int
    iterations: int | None
    pile: float
    joints: float
    stands: int
    still: int
    penetration: float
    rods: float
    top: float

    @property
    def name(self) -> str:
        return f"{self.substeps}" if self.iterations is None else f"{self.substeps} × {self.iterations}"

    @property
    def preset(self) -> str | None:
        return PRESETS[self.engine].get(self.substeps) if self.iterations is None else None

    def qualities(self) -> tuple[float, ...]:
        """Larger is better."""
        return (self.stands, self.still, -self.penetration, -self.rods, -self.top)


def settings(data: dict[str, Any]) -> list[Setting]:
    accuracy, stability = data["accuracy"], data["stability"]
    problems = {problem["id"]: problem["results"] for problem in accuracy["problems"]}
    heavy = next(trial for trial in stability["trials"] if trial["id"] == "S2.1e2")
    found = []
    for contender in problems["T.pile"]:
        _, engine, numbers = contender.split("-")
        substeps, _, iterations = numbers.partition("x")

        def at(problem: str, key: str) -> float:
            value = problems[problem][contender]["60"][key]
            return float("inf") if value is None else value

        outcome = next(each for each in heavy["outcomes"] if each["contender"] == contender)
        stands, still = tallest_of(stability, contender)
        found.append(Setting(engine, int(substeps), int(iterations) if iterations else None,
                             1e3 * at("T.pile", "cpu") / 60, 1e3 * at("T.joints", "cpu") / 60, stands, still,
                             1e3 * outcome["worst"]["penetration"], at("B3", "error"), at("B4", "error")))
    return sorted(found, key=lambda setting: (setting.engine != "ode", setting.pile))


def is_on_frontier(setting: Setting, among: list[Setting]) -> bool:
    return not any(other.pile < setting.pile and
                   all(theirs >= mine for theirs, mine in zip(other.qualities(), setting.qualities()))
                   for other in among if other is not setting)


GOALS = {
    "10 cubes stand": lambda setting: setting.stands >= 10,
    "15 cubes stand": lambda setting: setting.stands >= 15,
    "30 cubes stand": lambda setting: setting.stands >= 30,
    "40 cubes stand": lambda setting: setting.stands >= 40,
    "10 cubes stand still": lambda setting: setting.still >= 10,
    "20 cubes stand still": lambda setting: setting.still >= 20,
    "100:1 sinks less than 20 mm": lambda setting: setting.penetration < 20,
    "100:1 sinks less than 5 mm": lambda setting: setting.penetration < 5,
    "the rods are right to 1 %": lambda setting: setting.rods < 1e-2,
    "the rods are right to 0.1 %": lambda setting: setting.rods < 1e-3,
    "the top is right to 10 %": lambda setting: setting.top < 1e-1,
    "the top is right to 1 %": lambda setting: setting.top < 1e-2,
}
"""What one may want of a setting."""


def goals(all_settings: list[Setting]) -> list[list[str]]:
    table = [["if", *(f"on {title} the cheapest is" for title in ENGINES.values())]]
    for goal, is_met in GOALS.items():
        row = [goal]
        for engine in ENGINES:
            meeting = [each for each in all_settings if each.engine == engine and is_met(each)]
            row.append(shown(meeting[0]) if meeting else "none of these")
        table.append(row)
    return table


def shown(setting: Setting) -> str:
    return f"**{setting.name}, {setting.preset}**" if setting.preset else setting.name


def number(value: float) -> str:
    return f"{value:.3g}" if value == 0 or 1e-3 <= abs(value) < 1e4 else f"{value:.1e}"


def rows(all_settings: list[Setting], engine: str) -> list[list[str]]:
    mine = [each for each in all_settings if each.engine == engine]
    fast = next(each.pile for each in mine if each.preset == "fast")
    table = [["substeps × iterations", "pile, ms", "/ fast", "joints, ms", "stands", "still", "100:1, mm", "rods", "top",
              "frontier"]]
    for each in mine:
        table.append([shown(each), number(each.pile), f"{each.pile / fast:.2f}", number(each.joints),
                      str(each.stands or "–"), str(each.still or "–"), number(each.penetration), number(each.rods),
                      number(each.top), "yes" if is_on_frontier(each, mine) else ""])
    return table


def page(data: dict[str, Any]) -> str:
    all_settings = settings(data)
    parts = [PAGE_HEAD, machine(data["accuracy"]) + "\n",
             "## The cheapest for what one wants\n\n" + markdown(goals(all_settings)) + "\n",
             "![What settings cost and are good for](presets.svg)\n"]
    parts += [f"## {title}\n\n" + markdown(rows(all_settings, engine)) + "\n" for engine, title in ENGINES.items()]
    return "\n".join(parts)


def picture(data: dict[str, Any]) -> str:
    """A panel for each of some columns: its error over what the pile costs, a line for each number of iterations."""
    all_settings = settings(data)
    errors = {"100:1, mm": lambda each: each.penetration, "rods": lambda each: each.rods, "top": lambda each: each.top}
    panels = []
    for engine, title in ENGINES.items():
        mine = [each for each in all_settings if each.engine == engine]
        for words, error in errors.items():
            lines: dict[str, accuracy_plot.Points] = {}
            for each in sorted(mine, key=lambda each: each.substeps):
                line = "as the presets" if each.iterations is None else f"{each.iterations} iterations"
                # The picture's costs are in microseconds for each second that is simulated.
                lines.setdefault(line, []).append((each.pile * 60 / 1e3, error(each)))
            panels.append((f"{title}: {words}", lines))
    return accuracy_plot.picture(panels, STYLES)


FEW, MANY = ("#9ecae9", ""), ("#1b3a5c", "")
STYLES = {"as the presets": ("#d62728", ""), "5 iterations": FEW, "8 iterations": FEW, "20 iterations": MANY,
          "32 iterations": MANY, "40 iterations": MANY}


def check() -> int:
    data = json.loads(RESULTS.read_text())
    if PAGE.is_file() and PAGE.read_text() == page(data) and PICTURE.read_text() == picture(data):
        return 0
    print("docs/presets.md is not what bench/results/frontier.json says: run script/bench frontier --record")
    return 1


def main(arguments: list[str]) -> int:
    if arguments == ["--check"]:
        return check()
    if not arguments or arguments[1:] not in ([], ["--record"]):
        print(__doc__, file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[0])
    data = {name: json.loads((folder / f"{name}.json").read_text()) for name in ("accuracy", "stability")}
    targets = {folder / "frontier.json": json.dumps(data, indent=1) + "\n", folder / PAGE.name: page(data),
               folder / PICTURE.name: picture(data)}
    if arguments[1:]:
        targets.update({RESULTS: json.dumps(data, indent=1) + "\n", PAGE: page(data), PICTURE: picture(data)})
    for path, text in targets.items():
        path.write_text(text)
    print(f"The report is {PAGE if arguments[1:] else folder / PAGE.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

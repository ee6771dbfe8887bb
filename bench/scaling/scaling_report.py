#!/usr/bin/python3
"""Tells what the benchmark of scaling found out: a page and two pictures.

Usage: scaling_report.py <folder with scaling.json> [--record]
       scaling_report.py --check

Page and pictures go beside scaling.json. With --record all become those of the tree. The exit status is 1 if a bar is
missed. With --check nothing is written: it says whether the page of the tree is what the recorded results say.
"""

from __future__ import annotations

import json
import pathlib
import sys
from typing import Any

import scaling_plot

TREE = pathlib.Path(__file__).resolve().parents[2]
RESULTS = TREE / "bench" / "results" / "scaling.json"
PAGE = TREE / "docs" / "scaling.md"
COSTS, BARS = "scaling-costs.svg", "scaling-bars.svg"

ABOUT = {
    "passer": "A box slides over the floor without friction, 0.2 m from those beside its path, so that the engine "
              "moves it and the others are only there. After each step a frame of those who moved is encoded as the "
              "server does it; *no frame* is without. Nobody wakes: that is checked.",
    "asleep": "Boxes that lie on the floor and sleep, all of them.",
    "woken": "A ball hits a pile of 100 boxes that sleeps. In the step in which they touch, those that it touched are "
             "awake: that is checked. What that step costs is compared with the 20 steps after it, trial by trial. "
             "Where they touch late in a step, waking is paid in the next one, so that the dearer of both is told too. "
             "*One of many* is a ball that falls onto one of 10,000 sleeping boxes that touch nobody: what its waking "
             "costs must not depend on the others.",
    "flyers": "Bodies far from each other, with collision detection on, in our model and in the engine alone. They go "
              "apart at up to 3 m/s, each its way, under a gravity that turns round; *falling* ones fall for longer "
              "and longer, from 20 m/s on.",
    "pile": "The boxes have fallen and rest, but are kept awake. *Equal* is our model with as many substeps and "
            "iterations as the engine alone takes in its defaults. Events and frames are off. The engine alone is "
            "measured in its defaults and set up for speed; the fastest of all counts. On ODE `quick` is what is taken "
            "for its defaults: sweep and prune, up to eight contacts of a pair; `hash` is a hash space, `xyz` and "
            "`xzy` are orders of sweeping, `4` is up to four contacts. On Bullet `quick` neither looks ahead nor "
            "updates the boxes of sleepers; beside that, `whole` solves all islands as one, and `small` and `large` "
            "have other pools.",
    "small": "Piles of two or three boxes in a row, four to eight high, four seconds after they were let go: some lean, "
             "slide or fall over, others rest. A step is one of all 40 worlds. Few contacts get more iterations than "
             "many, for a stack that is solved to fewer digits creeps.",
    "islands": "Equal piles of 20 boxes that are kept awake, far from each other.",
    "space": "1,000 boxes that float, of one collision space or of none, while another box slides elsewhere.",
    "commands": "Boxes lie by twos, one on the other, and sleep; then one batch has a command of the kind for each of "
                "them. A cost is that of one command. What looked through all others for each would cost eight times "
                "as much where there are eight times as many; memory that is in no cache costs some of it.",
    "worlds": "Worlds of the floor alone, in process and in the engine alone; then a server: processor time of its "
              "process while nobody asks it for anything.",
}
"""What is to be known of a scene besides its title."""

LANES = ("asleep", "in_flight", "in_engine", "pairs", "contacts", "islands")
"""What the results tell of the entities of a step."""


def number(value: float | None) -> str:
    """As people read it: three digits."""
    if value is None:
        return "none"
    if abs(value) >= 1000:
        return f"{float(f'{value:.3g}'):,.0f}"
    return f"{value:.3g}"


def spread(value: dict[str, Any], unit: str = "") -> str:
    words = number(value["median"]) + (f" {unit}" if unit else "")
    return words if value["count"] == 1 else f"{words} ({number(value['p10'])} to {number(value['p90'])})"


def has_bar(figure: dict[str, Any]) -> bool:
    return "at_most" in figure or "at_least" in figure


def is_held(figure: dict[str, Any]) -> bool:
    value = figure["value"]["median"]
    return value is not None and figure.get("at_least", value) <= value <= figure.get("at_most", value)


def barred(data: dict[str, Any]) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """Outcomes and figures for which there is a bar."""
    return [(each, figure) for each in data["results"] for figure in each["figures"] if has_bar(figure)]


def missed(data: dict[str, Any]) -> list[str]:
    return [f"{figure['name']} ({each['scene']}, {each['engine']})"
            for each, figure in barred(data) if not is_held(figure)]


def verdict(data: dict[str, Any]) -> str:
    count, late = len(barred(data)), missed(data)
    return f"{count - len(late)} of {count} bars are held." + (f" Missed: {'; '.join(late)}." if late else "")


def bar(figure: dict[str, Any]) -> str:
    unit = f" {figure['unit']}" if figure["unit"] else ""
    words = [f"{kind.replace('_', ' ')} {number(figure[kind])}" for kind in ("at_least", "at_most") if kind in figure]
    return ", ".join(words) + unit if words else "–"


def figure_rows(outcomes: list[dict[str, Any]]) -> list[list[str]]:
    table = [["engine", "what", "bar", "median", ""]]
    for each in outcomes:
        for figure in each["figures"]:
            word = "" if not has_bar(figure) else "held" if is_held(figure) else "**missed**"
            table.append([each["engine"], figure["name"], bar(figure), spread(figure["value"], figure["unit"]), word])
    return table


def stages(lanes: dict[str, Any]) -> str:
    """Where the time of a step went, the largest parts of it."""
    total = sum(lanes["stages_us"].values())
    parts = sorted(lanes["stages_us"].items(), key=lambda stage: -stage[1])
    return ", ".join(f"{name} {100 * spent / total:.0f} %" for name, spent in parts if total and spent / total >= 0.05)


def cost_rows(outcomes: list[dict[str, Any]]) -> list[list[str]]:
    table = [["engine", "", "µs", "asleep", "in flight", "in the engine", "pairs", "contacts", "islands",
              "where the time goes"]]
    for each in outcomes:
        for cost in each["costs"]:
            lanes = cost.get("lanes")
            told = [*(f"{lanes[key]:,}" for key in LANES), stages(lanes)] if lanes else ["–"] * (len(LANES) + 1)
            table.append([each["engine"], cost["name"], spread(cost["step_us"]), *told])
    return table


def markdown(table: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in [table[0], ["---"] * len(table[0]), *table[1:]])


def section(data: dict[str, Any], scene: str) -> str:
    outcomes = [each for each in data["results"] if each["scene"] == scene]
    parts = [f"## {outcomes[0]['title'][:1].upper()}{outcomes[0]['title'][1:]}", ABOUT.get(scene, ""),
             markdown(figure_rows(outcomes)), markdown(cost_rows(outcomes))]
    return "\n\n".join(part for part in parts if part) + "\n"


def machine(data: dict[str, Any]) -> str:
    about, versions = data["machine"], data["versions"]
    kind = "virtual " if about["virtual"] else ""
    engines = ", ".join(f"{name} {version}" for name, version in versions["engines"].items())
    worst = max(each["others_max_processors"] for each in data["results"])
    return (f"Measured on {data['date'][:10]} on {about['processors']} {kind}processors ({about['processor']}), "
            f"{about['system']}, GCC {versions['compiler']}, engines {engines}. The load average was "
            f"{data['load_average_before']:.1f} when the run began. In no round that counts did other programs and the "
            f"host use more than {worst:.2f} of the {about['processors']} processors.")


def has_curves(data: dict[str, Any]) -> bool:
    return any(each["scene"] in ("passer", "asleep") for each in data["results"])


def page(data: dict[str, Any]) -> str:
    scenes = list(dict.fromkeys(each["scene"] for each in data["results"]))
    pictures = [f"![Cost of a step over the number of bodies beside it]({COSTS})"] if has_curves(data) else []
    pictures.append(f"![How near figures are to what they may be]({BARS})")
    head = f"""# Scaling

Written by `bench/scaling/scaling_report.py` from `bench/results/scaling.json`, which `script/bench scaling --record`
measures.

What a step costs by what happens in it, and what it costs by what is only there. {verdict(data)}

{chr(10).join(pictures)}

Steps are of 1/60 s, with the preset `balanced` where nothing else is said. Costs are processor time. All that is
compared takes turns in one run, in changing order. A turn's value is the mean of its steps; what is told is the median
of all rounds, in parentheses from the tenth to the ninetieth percentile. Beside costs stands how `StepStats` explains
one step: who was asleep, flew by closed forms or was left to the engine.

{machine(data)}
"""
    return "\n".join([head, *(section(data, scene) for scene in scenes)])


def pictures(data: dict[str, Any]) -> dict[str, str]:
    """The text of each picture by its name."""
    shares = [(f"{each['scene']}, {each['engine']}: {figure['name']}", figure["value"]["median"] / figure["at_most"],
               is_held(figure)) for each, figure in barred(data) if figure.get("at_most")]
    found = {BARS: scaling_plot.bars(shares)}
    if has_curves(data):
        found[COSTS] = scaling_plot.costs(data)
    return found


def write(data: dict[str, Any], path: pathlib.Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page(data))
    for name, text in pictures(data).items():
        path.with_name(name).write_text(text)


def check() -> int:
    data = json.loads(RESULTS.read_text())
    wanted = {PAGE: page(data)} | {PAGE.with_name(name): text for name, text in pictures(data).items()}
    stale = [path for path, text in wanted.items() if not path.is_file() or path.read_text() != text]
    for path in stale:
        print(f"{path.relative_to(TREE)} is not what bench/results/scaling.json says: "
              "run script/bench scaling --record")
    return 1 if stale else 0


def main(arguments: list[str]) -> int:
    if arguments == ["--check"]:
        return check()
    if not arguments or arguments[1:] not in ([], ["--record"]):
        print(__doc__, file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[0])
    text = (folder / "scaling.json").read_text()
    data = json.loads(text)
    write(data, folder / PAGE.name)
    if arguments[1:]:
        RESULTS.parent.mkdir(exist_ok=True)
        RESULTS.write_text(text)
        write(data, PAGE)
    print(verdict(data))
    print(f"More in {PAGE if arguments[1:] else folder / PAGE.name}")
    return 1 if missed(data) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

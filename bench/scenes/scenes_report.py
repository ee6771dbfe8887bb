#!/usr/bin/python3
"""Tells what everyday scenes cost: a page and a picture.

Usage: scenes_report.py <folder with scenes.json> [--record]
       scenes_report.py --check

Page and picture go beside scenes.json. With --record all become those of the tree. With --check nothing is written: it
says whether the page of the tree is what the recorded results say.
"""

from __future__ import annotations

import json
import pathlib
import sys
from typing import Any

TREE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TREE / "bench" / "scaling"))

import scenes_plot  # noqa: E402 the folders have to be known first
from scaling_report import machine, markdown, number, stages  # noqa: E402

RESULTS = TREE / "bench" / "results" / "scenes.json"
PAGE = TREE / "docs" / "scenes.md"
PICTURE = "scenes-ratios.svg"

ENGINES = {"ode": "ODE", "bullet": "Bullet"}
PRESETS = ("fast", "balanced", "accurate")
DEAREST_TOLD = 5
"""So many of the dearest are named before the tables."""
FAR = 0.1
"""Overlaps and gaps of joints from here on (m) are named there too."""

NOTES = """* *Alone* is the engine in its defaults: ODE's `dWorldQuickStep` with 20 iterations, sweep and prune and up to eight
  contacts of a pair, and Bullet's `btDiscreteDynamicsWorld` with 10 iterations. Both take one step of the same size
  where we take substeps, so that the same price does not buy the same: the tables of what it came to stand beside.
* Nobody sleeps but in *city*. Events and frames are off.
* Limits of ball joints are a cone to us and to Bullet, and three angles (`dJointTypeAMotor`) to ODE. A servo is a spring
  and damper to us, which give way under a load; alone it is a motor to a velocity that is steered by the error of the
  angle at every step. Telling us all targets of a step is one command, and part of the cost.
* Bullet keeps hulls and cones apart by its margins, 4 cm of each, which are left as they are: they hover and do not
  overlap.
* What an engine has not is named: then there are costs of ours and no ratio.
* Where bodies are lost, sink into each other or come off their joints, a cost is not that of the same thing any more:
  the second table of each engine says where. Overlaps are measured at the end of each part, by our queries."""
"""What is to be known of the comparison."""


def by_name(phase: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Contenders of a phase by what columns call them: "alone", "fast"."""
    found = {}
    for each in phase["contenders"]:
        name = each["name"]
        found[name.rsplit("-", 1)[1] if name.startswith("genphys") else "alone"] = each
    return found


def parts_of(data: dict[str, Any], engine: str) -> list[tuple[dict[str, Any], dict[str, Any], dict[str, Any]]]:
    """Scene, phase and its contenders, of one engine."""
    return [(each, phase, by_name(phase)) for each in data["results"] if each["engine"] == engine
            for phase in each["phases"]]


def title_of(scene: dict[str, Any], phase: dict[str, Any]) -> str:
    return scene["scene"] if len(scene["phases"]) == 1 else f"{scene['scene']}, {phase['name']}"


def has_come(contender: dict[str, Any] | None) -> bool:
    return contender is not None and "us" in contender


def absence(contender: dict[str, Any] | None) -> str:
    """Why a contender has no figures."""
    if contender is None:
        return "not measured"
    return f"has no {contender['not_had']}" if "not_had" in contender else f"broke off: {contender.get('failure', '')}"


def times(contender: dict[str, Any] | None) -> str:
    if not has_come(contender):
        return absence(contender)
    if "ratio" not in contender:
        return f"({number(contender['us'])} µs)"
    return f"× {number(contender['ratio'])}"


def cost_rows(data: dict[str, Any], engine: str) -> list[list[str]]:
    table = [["scene", "bodies", "contacts", "alone, µs", *PRESETS, "dearest step: alone", "balanced",
              "where the time of balanced goes"]]
    for scene, phase, found in parts_of(data, engine):
        alone, balanced = found.get("alone"), found.get("balanced")
        lanes = (balanced or {}).get("lanes")
        table.append([title_of(scene, phase), f"{scene['movers']:,}", number(lanes["contacts"]) if lanes else "–",
                      number(alone["us"]) if has_come(alone) else absence(alone),
                      *(times(found.get(preset)) for preset in PRESETS),
                      *(f"× {number(each['dearest'])}" if has_come(each) else "–" for each in (alone, balanced)),
                      stages(lanes) if lanes else "–"])
    return table


def figure(value: float | None, scale: float = 1) -> str:
    """What is next to nothing is nothing, for what it is of."""
    if value is None:
        return "no number"
    return "0" if abs(value * scale) < 0.0005 else number(value * scale)


def columns(found: dict[str, dict[str, Any]], key: str, scale: float = 1) -> str:
    return " / ".join(figure(each[key], scale) if has_come(each) and key in each else "–"
                      for each in (found.get(name) for name in ("alone", *PRESETS)))


def outcome_rows(data: dict[str, Any], engine: str) -> list[list[str]]:
    table = [["scene", "deepest overlap, mm", "widest gap of a joint, mm", "mean speed, m/s", "lost", "besides"]]
    for scene, phase, found in parts_of(data, engine):
        came = [each for each in found.values() if has_come(each)]
        lost = columns(found, "lost") if any(each["lost"] for each in came) else "–"
        gauge = f"{scene['gauge']}: {columns(found, 'gauge')}" if "gauge" in scene else ""
        gap = columns(found, "gap", 1e3) if scene["joints"] else "–"
        table.append([title_of(scene, phase), columns(found, "overlap", 1e3), gap, columns(found, "speed"), lost, gauge])
    return table


def compared(data: dict[str, Any], engine: str, preset: str) -> list[tuple[float, str]]:
    """Ratio and words of each part of a scene that has one, the dearest first."""
    found = [(contenders[preset]["ratio"], title_of(scene, phase)) for scene, phase, contenders in parts_of(data, engine)
             if "ratio" in contenders.get(preset, {})]
    return sorted(found, reverse=True)


def mishaps(scene: dict[str, Any], contender: dict[str, Any]) -> list[str]:
    """What nobody wants to see."""
    if "failure" in contender:
        return ["broke off"]
    found = [f"lost {contender['lost']} of {scene['movers']} bodies"] if contender.get("lost") else []
    for key, words in (("overlap", "overlaps by"), ("gap", "has a joint open by")):
        if (contender.get(key) or 0) >= FAR:
            found.append(f"{words} {contender[key]:.2f} m")
    return found


def losses(data: dict[str, Any], engine: str) -> list[str]:
    """To whom it happened, and where."""
    return [f"{name} {words} in {title_of(scene, phase)}" for scene, phase, contenders in parts_of(data, engine)
            for name, each in contenders.items() for words in mishaps(scene, each)]


def verdict(data: dict[str, Any], engine: str) -> str:
    """What is dearest beside the engine alone, and what is not."""
    words = []
    for preset in PRESETS:
        found = compared(data, engine, preset)
        if not found:
            continue
        middle = sorted(ratio for ratio, _ in found)[len(found) // 2]
        cheaper = sum(ratio < 1 for ratio, _ in found)
        words.append(f"`{preset}` costs {number(middle)} times what the engine alone does (the median of {len(found)} "
                     f"parts of scenes), and less than it in {cheaper}.")
    dearest = "; ".join(f"{name} (× {number(ratio)})" for ratio, name in compared(data, engine, "balanced")[:DEAREST_TOLD])
    if dearest:
        words.append(f"Dearest beside it, in `balanced`: {dearest}.")
    own = sorted(((found["balanced"]["us"], title_of(scene, phase)) for scene, phase, found in parts_of(data, engine)
                  if has_come(found.get("balanced"))), reverse=True)
    if own:
        most = "; ".join(f"{name} ({number(us)} µs)" for us, name in own[:DEAREST_TOLD])
        words.append(f"Dearest by themselves: {most}.")
    lost = losses(data, engine)
    words.append(f"What went wrong: {'; '.join(lost)}." if lost else f"Nobody lost a body, and nothing is off by {FAR} m.")
    return "\n".join(f"* {each}" for each in words)


def spread(data: dict[str, Any]) -> str:
    """How far ratios of single runs are from each other."""
    apart = sorted(each["ratio_high"] / each["ratio_low"] - 1 for scene in data["results"] for phase in scene["phases"]
                   for each in phase["contenders"] if "ratio" in each and not each["name"].startswith("raw"))
    if not apart:
        return ""
    return (f"The ratios of single runs of a scene differ by {100 * apart[len(apart) // 2]:.0f} % in the median, and by "
            f"{100 * apart[len(apart) * 9 // 10]:.0f} % at the ninetieth percentile.")


def scene_rows(data: dict[str, Any]) -> list[list[str]]:
    table = [["scene", "what happens", "bodies", "joints", "static", "steps of", "measured"]]
    known = set()
    for each in data["results"]:
        if each["scene"] in known:
            continue
        known.add(each["scene"])
        spans = "; ".join(f"{phase['name']}: {phase['steps']} steps after {phase['steps_before']}"
                          for phase in each["phases"])
        table.append([each["scene"], each["title"], f"{each['movers']:,}", f"{each['joints']:,}", f"{each['others']:,}",
                      f"1/{each['rate']} s", spans])
    return table


def engine_section(data: dict[str, Any], engine: str, title: str) -> str:
    if not parts_of(data, engine):
        return ""
    return "\n\n".join([
        f"## {title}", verdict(data, engine), f"### What it costs on {title}", markdown(cost_rows(data, engine)),
        f"### What it came to on {title}",
        "At the end of each part. Each cell: alone / fast / balanced / accurate.", markdown(outcome_rows(data, engine)),
    ]) + "\n"


def page(data: dict[str, Any]) -> str:
    rounds = max(each["rounds"] for each in data["results"])
    head = f"""# Everyday scenes

Written by `bench/scenes/scenes_report.py` from `bench/results/scenes.json`, which `script/bench scenes --record`
measures.

What people simulate, in our model with each preset and in the engines alone. A cost is microseconds of processor time
for each body that moves and each step; **×** is how many times the cost of the engine alone that is. All contenders of
a scene take turns of 16 steps within one run from its begin to its end, and there are up to {rounds} such runs: a step
counts with the median of them, and so does a ratio. What comes first in a turn, with the caches as others left them,
does not count. A part of a scene is told apart where its cost is another. *Dearest step*: what is dearer
than 99 of 100 steps of that part, beside their mean: a frame that is late. Costs have no bars here.

![What scenes cost beside the engines alone]({PICTURE})

{NOTES}

{machine(data)} {spread(data)}
"""
    sections = [engine_section(data, engine, title) for engine, title in ENGINES.items()]
    scenes = "## The scenes\n\n" + markdown(scene_rows(data)) + "\n"
    return "\n".join([head, *(section for section in sections if section), scenes])


def picture(data: dict[str, Any]) -> str:
    rows: dict[str, tuple[dict[str, dict[str, float]], dict[str, str]]] = {}
    for engine in ENGINES:
        for scene, phase, found in parts_of(data, engine):
            ratios, missing = rows.setdefault(title_of(scene, phase), ({}, {}))
            ratios[engine] = {preset: found[preset]["ratio"] for preset in PRESETS if "ratio" in found.get(preset, {})}
            if not ratios[engine]:
                missing[engine] = f"alone it {absence(found.get('alone'))}"
    engines = {engine: title for engine, title in ENGINES.items() if parts_of(data, engine)}
    return scenes_plot.ratios([(words, *row) for words, row in rows.items()], engines)


def write(data: dict[str, Any], path: pathlib.Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page(data))
    path.with_name(PICTURE).write_text(picture(data))


def check() -> int:
    data = json.loads(RESULTS.read_text())
    wanted = {PAGE: page(data), PAGE.with_name(PICTURE): picture(data)}
    stale = [path for path, text in wanted.items() if not path.is_file() or path.read_text() != text]
    for path in stale:
        print(f"{path.relative_to(TREE)} is not what bench/results/scenes.json says: run script/bench scenes --record")
    return 1 if stale else 0


def main(arguments: list[str]) -> int:
    if arguments == ["--check"]:
        return check()
    if not arguments or arguments[1:] not in ([], ["--record"]):
        print(__doc__, file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[0])
    text = (folder / "scenes.json").read_text()
    data = json.loads(text)
    write(data, folder / PAGE.name)
    if arguments[1:]:
        RESULTS.parent.mkdir(exist_ok=True)
        RESULTS.write_text(text)
        write(data, PAGE)
    for engine, title in ENGINES.items():
        if parts_of(data, engine):
            print(f"{title}:\n{verdict(data, engine)}")
    print(f"The report is {PAGE if arguments[1:] else folder / PAGE.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

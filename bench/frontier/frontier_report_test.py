"""Tests of the report of settings and presets."""

import json
import xml.etree.ElementTree

import frontier_report as report

MACHINE = {"date": "2026-01-02T03:04:05Z", "machine": {"processor": "a processor", "system": "a system"},
           "versions": {"compiler": "12.2.0", "engines": {"ode": "0.16.2"}}}


def results(numbers: dict[str, tuple[float, int, float]]) -> dict:
    """Of contenders: the cost of the pile in s for each simulated second, the tallest stack, and one error for all."""
    problems = [{"id": name, "results": {contender: {"60": {"cpu": cost, "error": error}}
                                         for contender, (cost, _, error) in numbers.items()}}
                for name in ("T.pile", "T.joints", "B3", "B4")]

    def outcome(contender: str, passed: bool, **worst: float) -> dict:
        return {"contender": contender, "rate": 60, "seeds": 3, "passed": 3 if passed else 1, "worst": worst}

    trials = [{"id": f"S1.{count}", "limits": {"deviation": 0.25},
               "outcomes": [outcome(contender, count <= tallest, deviation=0.01 if count <= tallest else 9.0)
                            for contender, (_, tallest, _) in numbers.items()]} for count in (5, 10, 15)]
    trials.append({"id": "S2.1e2", "limits": {"penetration": 0.01},
                   "outcomes": [outcome(contender, True, penetration=error)
                                for contender, (_, _, error) in numbers.items()]})
    return {"accuracy": {"problems": problems, **MACHINE}, "stability": {"trials": trials, **MACHINE}}


DATA = results({"genphys-ode-1": (0.6, 5, 0.1), "genphys-ode-1x40": (1.2, 5, 0.2), "genphys-ode-2": (1.1, 15, 0.01),
                "genphys-bullet-1": (0.3, 10, 0.02)})


def test_settings_are_in_order_of_their_cost_and_presets_are_named():
    found = report.settings(DATA)
    assert [(each.engine, each.name, each.preset) for each in found] == [
        ("ode", "1", "fast"), ("ode", "2", "balanced"), ("ode", "1 × 40", None), ("bullet", "1", "fast")]
    assert found[0].pile == 10 and found[1].stands == 15 and found[1].penetration == 10


def test_who_costs_more_and_is_no_better_is_not_on_the_frontier():
    ode = [each for each in report.settings(DATA) if each.engine == "ode"]
    assert [report.is_on_frontier(each, ode) for each in ode] == [True, True, False]


def test_the_cheapest_setting_for_a_goal_is_found_if_there_is_one():
    table = {row[0]: row[1:] for row in report.goals(report.settings(DATA))}
    assert table["10 cubes stand"] == ["**2, balanced**", "**1, fast**"]
    assert table["15 cubes stand"] == ["**2, balanced**", "none of these"]


def test_the_page_and_the_picture_are_written_beside_the_results(tmp_path):
    for name, data in DATA.items():
        (tmp_path / f"{name}.json").write_text(json.dumps(data))
    assert report.main([str(tmp_path)]) == 0
    assert "| **2, balanced** | 18.3 |" in (tmp_path / "presets.md").read_text()
    svg = xml.etree.ElementTree.fromstring((tmp_path / "presets.svg").read_text())
    assert "ODE: rods" in "".join(svg.itertext())
    assert json.loads((tmp_path / "frontier.json").read_text())["accuracy"] == DATA["accuracy"]

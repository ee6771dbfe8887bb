"""Tests of the report of the stress suite."""

import json

import stability_report as report


def outcome(passed: int, **worst: float | None) -> dict:
    return {"contender": "genphys-ode-balanced", "rate": 60, "seeds": 5, "passed": passed, "worst": worst}


def stack(count: int, passed: int, deviation: float, speed: float = 0.001) -> dict:
    return {"id": f"S1.{count}", "title": f"stack of {count}", "limits": {"deviation": 0.25, "speed": 0.02},
            "outcomes": [outcome(passed, deviation=deviation, speed=speed)]}


def data(*trials: dict) -> dict:
    return {"date": "2026-01-02T03:04:05Z", "machine": {"processor": "a processor", "system": "a system"},
            "versions": {"compiler": "12.2.0", "engines": {"ode": "0.16.2"}}, "trials": list(trials)}


def test_a_cell_shows_the_limit_that_was_broken():
    trial = stack(10, 3, 0.01, 0.5)
    assert report.cell(trial, trial["outcomes"][0]) == "✗ 3 of 5, speed 0.5"
    trial = stack(10, 5, 0.01)
    assert report.cell(trial, trial["outcomes"][0]) == "✓ deviation 0.01"
    assert report.cell(trial, outcome(0, deviation=None)) == "✗ 0 of 5, deviation no number"
    assert report.cell(trial, None) == "–"


def test_the_tallest_stack_is_one_below_which_all_stand():
    table = report.tallest(data(stack(5, 5, 0.01), stack(10, 2, 0.02, 0.1), stack(15, 0, 7), stack(20, 5, 0.01)))
    column = 1 + list(report.COLUMNS).index("genphys-ode-balanced")
    stands, still = (line.split("|")[1:-1][column].strip() for line in table.splitlines()[-2:])
    assert (stands, still) == ("10", "5")


def test_the_page_is_written_beside_the_results_and_names_every_trial(tmp_path):
    results = data(stack(5, 5, 0.01), stack(10, 2, 0.02))
    (tmp_path / "stability.json").write_text(json.dumps(results))
    assert report.main([str(tmp_path)]) == 0
    text = (tmp_path / "stability.md").read_text()
    assert "| S1.5 | 1/60 |" in text and "| S1.10 | stack of 10 | deviation ≤ 0.25, speed ≤ 0.02 |" in text

"""Tests of the comparison of errors with and without lanes."""

import json

import lanes_report
import pytest


def results(**cell):
    return {"problems": [{"id": "C6", "results": {"genphys-ode-fast": {"60": cell}}}]}


@pytest.mark.parametrize("on, off, agrees", [
    (0.5, 0.504, True),
    (0.5, 0.51, False),
    (1e-6, 4e-5, True),
    (1e-6, 6e-5, False),
    (0.5, None, False),
    (None, 0.5, False),
])
def test_numbers_agree_within_a_part_of_them_or_what_the_method_may_be_off_by(on, off, agrees):
    assert lanes_report.Pair("error", on, off).agrees() == agrees


def test_costs_are_not_compared(tmp_path, capsys):
    for name, cpu in (("on", 1e-3), ("off", 9e-3)):
        (tmp_path / name).write_text(json.dumps(results(error=0.5, cpu=cpu)))
    assert lanes_report.main([str(tmp_path / "on"), str(tmp_path / "off")]) == 0
    assert "1 numbers" in capsys.readouterr().out


def test_what_differs_is_named(tmp_path, capsys):
    (tmp_path / "on").write_text(json.dumps(results(error=0.5)))
    (tmp_path / "off").write_text(json.dumps(results(error=0.6)))
    assert lanes_report.main([str(tmp_path / "on"), str(tmp_path / "off")]) == 1
    assert "C6 genphys-ode-fast 1/60 error: 0.5 with lanes, 0.6 without" in capsys.readouterr().out


def test_nothing_in_common_is_no_agreement(tmp_path):
    (tmp_path / "none").write_text(json.dumps({"problems": []}))
    assert lanes_report.main([str(tmp_path / "none")] * 2) == 1

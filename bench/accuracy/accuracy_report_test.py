"""Tests of the report of the accuracy benchmark."""

import json
import xml.etree.ElementTree

import accuracy_plot
import accuracy_report as report


def line(costs_and_errors):
    return {str(30 * 2**i): {"cpu": cpu, "error": error} for i, (cpu, error) in enumerate(costs_and_errors)}


def problem(**results):
    named = {name.replace("_", "-"): line(cells) for name, cells in results.items()}
    return {"id": "B0", "title": "rod", "error": "place / 0.5 m", "first_order": True, "euler_error": None, "results": named}


def data(*problems):
    return {
        "date": "2026-01-02T03:04:05Z", "calibration": 0.01,
        "machine": {"processors": 2, "processor": "a processor", "virtual": True, "architecture": "x86_64",
                    "system": "a system"},
        "versions": {"compiler": "12.2.0", "engines": {"ode": "0.16.2"}}, "problems": list(problems),
    }


FIRST_ORDER = [(1e-4, 0.08), (2e-4, 0.04), (4e-4, 0.02), (8e-4, 0.01)]


def test_the_order_is_that_of_the_errors():
    second = [(cpu, error**2) for cpu, error in FIRST_ORDER]
    rod = problem(raw_bullet=FIRST_ORDER, genphys_bullet_balanced=second, raw_ode_step=[(1e-4, 1e-13)] * 4)
    assert abs(report.order(rod, "raw-bullet") - 1) < 1e-9
    assert abs(report.order(rod, "genphys-bullet-balanced") - 2) < 1e-9
    assert report.order(rod, "raw-ode-step") is None


def test_who_is_more_accurate_at_the_same_cost_is_ahead_even_with_larger_steps():
    # Twice as dear a step, but of second order.
    ours = [(2e-4, 0.01), (4e-4, 0.0025), (8e-4, 0.0006)]
    assert report.behind(problem(raw_bullet=FIRST_ORDER, genphys_bullet_balanced=ours), "bullet") == []
    worse = [(2e-4, 0.09), (4e-4, 0.05), (8e-4, 0.01005)]
    found = report.behind(problem(raw_bullet=FIRST_ORDER, genphys_bullet_balanced=worse), "bullet")
    assert [(each[1], round(each[3], 9)) for each in found] == [(2e-4, 0.09), (4e-4, 0.05)]


def test_rounding_errors_are_equal():
    ours, theirs = [(1e-4, 5e-13)], [(1e-4, 1e-16)]
    assert report.behind(problem(raw_bullet=theirs, genphys_bullet_fast=ours), "bullet") == []


def test_between_two_points_the_error_is_on_the_line_of_logarithms():
    assert abs(report.error_at([(1e-4, 1e-2), (1e-2, 1e-4)], 1e-3) - 1e-3) < 1e-12
    assert report.error_at([(1e-2, 1e-4)], 1e-3) is None


def test_the_page_names_where_an_engine_alone_is_ahead(tmp_path):
    worse = problem(raw_bullet=FIRST_ORDER, genphys_bullet_balanced=[(1e-4, 0.5), (8e-4, 0.4)])
    (tmp_path / "accuracy.json").write_text(json.dumps(data(worse)))
    assert report.main([str(tmp_path)]) == 0
    text = (tmp_path / "accuracy.md").read_text()
    assert "| B0 | Bullet |" in text and "Nowhere" not in text
    assert report.unexplained(data(worse)) == ["B0"]
    assert "Nowhere" in report.page(data(problem(genphys_bullet_balanced=FIRST_ORDER)))


def test_every_family_of_problems_has_a_heading():
    for name in ("A1.random", "A5dz", "B11.hanging", "C1.slip", "C2i", "C2.box", "C19.ball", "C5.ball.50", "C7.90",
                 "S4.free", "S13", "D2"):
        assert report.family_of(name) in report.FAMILIES, name


def test_every_point_lies_inside_the_picture():
    lines = {"raw-bullet": FIRST_ORDER, "genphys-ode-fast": [(1e-5, 0.0), (1e-3, 3.0)]}
    svg = xml.etree.ElementTree.fromstring(accuracy_plot.picture([("B1", lines), ("B3", lines)] * 2))
    width, height = (float(size) for size in svg.get("viewBox").split()[2:])
    circles = list(svg.iter("{http://www.w3.org/2000/svg}circle"))
    assert len(circles) == 4 * 6
    assert all(0 < float(dot.get("cx")) < width and 0 < float(dot.get("cy")) < height for dot in circles)

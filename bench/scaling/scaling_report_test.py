"""Tests of the report of the scaling benchmark."""

import copy
import json
import xml.etree.ElementTree

import scaling_plot
import scaling_report as report


def spread(median: float) -> dict:
    return {"count": 10, "p10": median * 0.9, "median": median, "p90": median * 1.1}


def cost(series: str, size: int, us: float) -> dict:
    return {"series": series, "name": f"{size} {series}", "size": size, "step_us": spread(us),
            "lanes": {"asleep": size, "in_flight": 0, "in_engine": 1, "pairs": 1, "contacts": 4, "islands": 1,
                      "stages_us": {"solve": 3.0, "collide": 1.0, "report": 0.01}}}


def results(ratio: float) -> dict:
    passer = {
        "scene": "passer", "title": "a box slides past others", "engine": "ode", "rounds": 40, "rounds_taken": 41,
        "others_max_processors": 0.05,
        "costs": [cost("alone", 0, 5), cost("asleep", 1000, 5.5), cost("asleep", 10000, 5 * ratio)],
        "figures": [{"name": "10,000 asleep / alone", "unit": "", "value": spread(ratio), "at_most": 2},
                    {"name": "fit", "unit": "", "value": spread(0.999), "at_least": 0.99},
                    {"name": "slope", "unit": "ns", "value": spread(0.1)}],
    }
    return {
        "benchmark": "scaling", "date": "2026-01-02T03:04:05Z",
        "machine": {"processors": 2, "processor": "a processor", "virtual": True, "architecture": "x86_64",
                    "system": "a system"},
        "versions": {"compiler": "12.2.0", "engines": {"ode": "0.16.2"}}, "load_average_before": 0.3,
        "results": [passer, copy.deepcopy(passer) | {"engine": "bullet"}],
    }


def test_a_figure_at_its_bar_holds_and_one_beyond_it_is_named():
    assert report.missed(results(2)) == []
    assert report.verdict(results(2)) == "4 of 4 bars are held."
    assert report.missed(results(2.1)) == [f"10,000 asleep / alone (passer, {engine})" for engine in ("ode", "bullet")]
    low = results(2)
    low["results"][0]["figures"][1]["value"] = spread(0.98)
    assert report.missed(low) == ["fit (passer, ode)"]


def test_the_exit_status_says_whether_all_bars_are_held(tmp_path):
    for ratio, status in ((1.5, 0), (2.5, 1)):
        (tmp_path / "scaling.json").write_text(json.dumps(results(ratio)))
        assert report.main([str(tmp_path)]) == status
        assert (tmp_path / "scaling.md").read_text() == report.page(results(ratio))
        assert (tmp_path / report.BARS).is_file() and (tmp_path / report.COSTS).is_file()


def test_the_page_tells_bars_and_lanes():
    page = report.page(results(1.5))
    assert "| ode | 10,000 asleep / alone | at most 2 | 1.5 (1.35 to 1.65) | held |" in page
    assert "| bullet | slope | – | 0.1 ns (0.09 to 0.11) |  |" in page
    assert "| ode | 1000 asleep | 5.5 (4.95 to 6.05) | 1,000 | 0 | 1 | 1 | 4 | 1 | solve 75 %, collide 25 % |" in page


def test_numbers_have_three_digits():
    assert [report.number(value) for value in (0.01234, 1.234, 123.4, 12345.6, None)] == [
        "0.0123", "1.23", "123", "12,300", "none"]


def test_pictures_have_a_line_for_each_series_and_bars_end_inside():
    texts = report.pictures(results(50))
    lines = xml.etree.ElementTree.fromstring(texts[report.COSTS])
    assert len(list(lines.iter("{http://www.w3.org/2000/svg}polyline"))) == 2
    bars = xml.etree.ElementTree.fromstring(texts[report.BARS])
    width = float(bars.get("viewBox").split()[2])
    found = [rect for rect in bars.iter("{http://www.w3.org/2000/svg}rect") if rect.get("x")]
    assert len(found) == 2 and all(rect.get("fill") == scaling_plot.MISSED for rect in found)
    assert all(float(rect.get("x")) + float(rect.get("width")) < width for rect in found)


def test_a_run_of_some_scenes_has_no_picture_of_costs():
    data = results(1)
    for each in data["results"]:
        each["scene"] = "woken"
    assert report.COSTS not in report.pictures(data) and report.COSTS not in report.page(data)

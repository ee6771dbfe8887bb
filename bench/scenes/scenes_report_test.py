"""Tests of the report of everyday scenes."""

import copy
import json
import xml.etree.ElementTree

import scenes_plot
import scenes_report as report


def contender(name: str, us: float, ratio: float | None, **more) -> dict:
    found = {"name": name, "us": us, "dearest": 2, "lost": 0, "overlap": 0.001, "gap": 0.002, "speed": 0.5}
    return found | ({} if ratio is None else {"ratio": ratio, "ratio_low": ratio, "ratio_high": ratio}) | more


def phase(name: str, *contenders: dict) -> dict:
    return {"name": name, "steps_before": 0, "steps": 90, "contenders": list(contenders)}


def scene(name: str, *phases: dict) -> dict:
    return {"scene": name, "title": f"all of {name}", "engine": "ode", "movers": 20, "others": 1, "joints": 3, "rate": 60,
            "seed": 1, "rounds": 3, "others_max_processors": 0.1, "gauge": "fallen, of all", "phases": list(phases)}


LANES = {"contacts": 4, "stages_us": {"solve": 3.0, "collide": 1.0, "report": 0.01}}


def results() -> dict:
    had = phase("falling", contender("raw-ode-quick", 2, 1, gauge=0.5), contender("genphys-ode-fast", 1, 0.5, gauge=1),
                contender("genphys-ode-balanced", 4, 2, lanes=LANES), contender("genphys-ode-accurate", 600, 300))
    not_had = phase("lying", {"name": "raw-ode-quick", "not_had": "cones"}, contender("genphys-ode-fast", 3, None),
                    contender("genphys-ode-balanced", 5, None, gap=None))
    return {
        "benchmark": "scenes", "date": "2026-01-02T03:04:05Z",
        "machine": {"processors": 2, "processor": "a processor", "virtual": True, "architecture": "x86_64",
                    "system": "a system"},
        "versions": {"compiler": "12.2.0", "engines": {"ode": "0.16.2"}}, "load_average_before": 0.3,
        "results": [scene("bridge", had), scene("cones", copy.deepcopy(had), not_had)],
    }


def test_a_row_tells_times_of_the_engine_alone_and_where_time_goes():
    page = report.page(results())
    assert ("| bridge | 20 | 4 | 2 | × 0.5 | × 2 | × 300 | × 2 | × 2 | solve 75 %, collide 25 % |") in page
    assert "| bridge | 1 / 1 / 1 / 1 | 2 / 2 / 2 / 2 | 0.5 / 0.5 / 0.5 / 0.5 | – | fallen, of all: 0.5 / 1 / – / – |" in page


def test_what_an_engine_has_not_is_named_in_place_of_a_ratio():
    rows = report.cost_rows(results(), "ode")
    assert rows[3][:6] == ["cones, lying", "20", "–", "has no cones", "(3 µs)", "(5 µs)"]
    assert rows[3][6] == "not measured"
    assert report.outcome_rows(results(), "ode")[3][2] == "– / 2 / no number / –"


def test_the_verdict_names_the_dearest_and_what_went_wrong():
    data = results()
    assert "Dearest beside it, in `balanced`: cones, falling (× 2); bridge (× 2)." in report.verdict(data, "ode")
    assert "`fast` costs 0.5 times what the engine alone does (the median of 2 parts of scenes), and less than it in 2." in (
        report.verdict(data, "ode"))
    assert "Nobody lost a body" in report.verdict(data, "ode")
    data["results"][0]["phases"][0]["contenders"][0] |= {"lost": 7, "gap": None}
    data["results"][1]["phases"][0]["contenders"][3] |= {"overlap": 0.0999, "gap": 0.1}
    data["results"][1]["phases"][1]["contenders"][1] = {"name": "genphys-ode-fast", "failure": "it diverged"}
    assert ("What went wrong: alone lost 7 of 20 bodies in bridge; accurate has a joint open by 0.10 m in cones, falling; "
            "fast broke off in cones, lying.") in report.verdict(data, "ode")
    assert report.cost_rows(data, "ode")[3][4] == "broke off: it diverged"


def test_bars_end_inside_the_picture_and_go_to_the_left_where_ours_is_cheaper():
    svg = xml.etree.ElementTree.fromstring(report.picture(results()))
    width = float(svg.get("viewBox").split()[2])
    found = [rect for rect in svg.iter("{http://www.w3.org/2000/svg}rect") if rect.get("height") == "6"]
    assert len(found) == 6 and all(float(rect.get("x")) + float(rect.get("width")) < width for rect in found)
    fast, balanced = (next(rect for rect in found if rect.get("fill") == scenes_plot.COLORS[preset])
                      for preset in ("fast", "balanced"))
    end_of_fast = float(fast.get("x")) + float(fast.get("width"))
    assert abs(end_of_fast - float(balanced.get("x"))) < 0.11
    assert "alone it has no cones" in report.picture(results())


def test_the_page_is_written_beside_the_results_and_names_every_scene(tmp_path):
    (tmp_path / "scenes.json").write_text(json.dumps(results()))
    assert report.main([str(tmp_path)]) == 0
    text = (tmp_path / "scenes.md").read_text()
    assert text == report.page(results()) and (tmp_path / report.PICTURE).is_file()
    assert "| cones | all of cones | 20 | 3 | 1 | 1/60 s | falling: 90 steps after 0; lying: 90 steps after 0 |" in text

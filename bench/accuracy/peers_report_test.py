"""Tests of what the report of the accuracy benchmark tells of peers."""

import copy
import json
import xml.etree.ElementTree

import accuracy_plot
import accuracy_report as report
import peers_report
from accuracy_report_test import FIRST_ORDER, data, line, problem

ABOUT = {"peer-mujoco": {"name": "MuJoCo", "version": "4.0", "settings": "all defaults"}}
OURS = [(1e-4, 0.5), (8e-4, 0.4)]


def peers(cells, **more):
    return data({**problem(), "results": {"peer-mujoco": cells}}) | {"peers": ABOUT} | more


def both():
    """With a peer that is ahead, and refuses another problem."""
    ours, theirs = data(problem(genphys_ode_balanced=OURS)), peers(line(FIRST_ORDER))
    for each, results in ((ours, {"genphys-ode-balanced": line(OURS)}),
                          (theirs, {"peer-mujoco": {"30": {"cpu": None, "failure": "restitution: it has none"}}})):
        each["problems"].append({**copy.deepcopy(each["problems"][0]), "id": "C5.ball.50", "results": results})
    return ours, theirs


def test_without_peers_nothing_is_said_of_them():
    alone = report.page(data(problem(genphys_bullet_balanced=FIRST_ORDER)))
    assert "peer" not in alone.lower() and "MuJoCo" not in alone


def test_the_page_shows_peers_with_versions_and_settings_and_what_they_refuse():
    text = report.page(peers_report.joined(*both()))
    assert "| MuJoCo | 4.0 | all defaults |" in text
    assert "| MuJoCo | restitution: it has none | C5 |" in text
    assert "| B0 | MuJoCo | 100 to 800 | 0.01 | 0.4 |" in text
    assert "in the same run as ours" in text


def test_a_peer_is_held_against_our_model_on_the_better_engine():
    rod = problem(peer_mujoco=FIRST_ORDER, genphys_ode_fast=OURS, genphys_bullet_fast=[(1e-4, 1e-3)])
    assert peers_report.ahead(rod, "peer-mujoco") == []
    del rod["results"]["genphys-bullet-fast"]
    assert [each[0] for each in peers_report.ahead(rod, "peer-mujoco")] == [1e-4, 2e-4, 4e-4, 8e-4]
    # At no cost that ours has an answer at.
    dear = problem(peer_mujoco=[(1e-6, 0.1)], genphys_ode_fast=OURS)
    assert peers_report.ahead(dear, "peer-mujoco") == []


def test_costs_of_another_run_are_scaled_by_the_calibration_and_the_page_says_so():
    ours, theirs = data(problem(genphys_ode_fast=OURS)), peers(line([(1e-4, 0.1)]), date="2026-02-03T00:00:00Z")
    theirs["calibration"] = 2 * ours["calibration"]
    found = peers_report.joined(ours, theirs)
    assert found["problems"][0]["results"]["peer-mujoco"]["30"]["cpu"] == 5e-5
    assert "a run of their own on 2026-02-03: their costs are multiplied by 0.5" in report.page(found)
    assert "peer-mujoco" not in ours["problems"][0]["results"]


def test_cells_say_what_became_of_a_scene():
    texts = [peers_report.cell_text(cell) for cell in (
        None, {"cpu": None, "failure": "joints"}, {"cpu": None, "failure": "unstable: a pose is no number"},
        {"cpu": None, "failure": "slow: 240 steps"}, {"cpu": 1e-4, "error": 0.25})]
    assert texts == ["–", "–", "unstable", "slow", "0.25"]


def test_recording_keeps_the_file_in_which_nothing_was_measured(tmp_path, monkeypatch, capsys):
    tree, folder = tmp_path / "tree", tmp_path / "folder"
    folder.mkdir()
    paths = {"RESULTS": "results/accuracy.json", "PEERS": "results/accuracy-peers.json", "PAGE": "accuracy.md"}
    for name, path in paths.items():
        monkeypatch.setattr(report, name, tree / path)
    monkeypatch.setattr(report, "TREE", tree)
    tree.mkdir()
    ours, theirs = both()
    (folder / "accuracy.json").write_text(json.dumps(ours))
    (folder / "accuracy-peers.json").write_text(json.dumps(theirs))
    assert report.main([str(folder), "--record"]) == 0 and report.check() == 0
    assert capsys.readouterr().out.count("stays") == 0

    # Ours alone, once more: the peers of the run before stay, and it is said.
    (folder / "accuracy-peers.json").unlink()
    ours["date"] = "2026-03-03T00:00:00Z"
    (folder / "accuracy.json").write_text(json.dumps(ours))
    assert report.main([str(folder), "--record"]) == 0 and report.check() == 0
    assert "results/accuracy-peers.json stays" in capsys.readouterr().out
    assert "a run of their own" in report.PAGE.read_text()

    # Peers alone.
    nothing = copy.deepcopy(ours)
    for each in nothing["problems"]:
        each["results"] = {}
    (folder / "accuracy.json").write_text(json.dumps(nothing))
    (folder / "accuracy-peers.json").write_text(json.dumps(theirs | {"date": "2026-04-04T00:00:00Z"}))
    assert report.main([str(folder), "--record"]) == 0 and report.check() == 0
    assert "results/accuracy.json stays" in capsys.readouterr().out
    assert json.loads(report.RESULTS.read_text()) == ours and "2026-04-04" in report.PAGE.read_text()


def test_peers_are_thin_lines_with_open_dots_inside_the_picture():
    lines = {"raw-bullet": FIRST_ORDER, "peer-mujoco": [(1e-4, 0.1), (1e-3, 1e12)]}
    styles = accuracy_plot.STYLES | accuracy_plot.peer_styles(["peer-mujoco"])
    svg = xml.etree.ElementTree.fromstring(accuracy_plot.picture([("B1", lines)], styles))
    space = "{http://www.w3.org/2000/svg}"
    assert sorted(each.get("stroke-width") for each in svg.iter(f"{space}polyline")) == ["0.8", "1.5"]
    dots = list(svg.iter(f"{space}circle"))
    assert [dot.get("fill") for dot in dots].count("white") == 2
    height = float(svg.get("viewBox").split()[3])
    assert all(0 < float(dot.get("cy")) < height for dot in dots)
    assert any(each.text == "peer-mujoco" for each in svg.iter(f"{space}text"))

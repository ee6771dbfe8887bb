"""Tests of the report of the RPC benchmark."""

import copy
import xml.etree.ElementTree

import report


def spread(median: float) -> dict:
    return {"count": 10, "p10": median * 0.9, "median": median, "p90": median * 1.1}


def results(ratio: float) -> dict:
    scene = {
        "engine": "ode", "scene": "sleepers", "rows": 1001, "contacts": 4000, "request_bytes": 61, "reply_bytes": 112330,
        "rounds": 40, "rounds_taken": 44, "others_max_processors": 0.07, "steps": 8000,
        "in_process_us": spread(40), "bytes_echo_us": spread(60), "message_echo_us": spread(80),
        "cpp_cycle_us": spread(100 * ratio), "python_cycle_us": spread(2500),
        "cpp_cycle_to_step_and_bytes_echo": spread(ratio), "cpp_cycle_to_step_and_message_echo": spread(ratio / 1.2),
    }
    pile = copy.deepcopy(scene) | {"scene": "pile"}
    return {
        "benchmark": "rpc", "date": "2026-01-02T03:04:05Z",
        "machine": {"processors": 2, "processor": "a processor", "virtual": True, "architecture": "x86_64",
                    "system": "a system"},
        "versions": {"grpc": "1.51.1", "compiler": "12.2.0", "engines": {"ode": "0.16.2"},
                     "python_client": {"python": "3.11.2", "grpcio": "1.51.1", "protobuf": "4.21.12", "numpy": "1.24.2"}},
        "load_average_before": 0.3, "results": [scene, pile],
    }


def test_a_cycle_at_the_bound_holds_and_one_above_it_is_named():
    assert report.missed(results(report.RATIO_MAX)) == []
    assert report.missed(results(report.RATIO_MAX + 0.01)) == ["sleepers on ode", "pile on ode"]
    assert "It holds for every scene." in report.verdict(results(report.RATIO_MAX))
    assert "sleepers on ode, pile on ode." in report.verdict(results(report.RATIO_MAX + 0.01))


def test_a_drive_at_the_bound_holds_and_one_below_it_is_named():
    for part, named in ((report.DRIVE_MIN, []), (report.DRIVE_MIN - 0.01, ["sleepers on ode"])):
        data = results(1.0)
        data["results"][0] |= {report.DRIVE: spread(part), "cpp_drive_us": spread(60)}
        assert report.slow_drives(data) == named
        assert ("holds for every scene" in report.drive_verdict(data)) == (not named)


def test_the_exit_status_says_whether_the_bound_is_held(tmp_path):
    for ratio, status in ((1.0, 0), (2.0, 1)):
        (tmp_path / "rpc.json").write_text(report.json.dumps(results(ratio)))
        assert report.main([str(tmp_path)]) == status
        assert (tmp_path / "performance.md").read_text() == report.page(results(ratio))


def test_what_was_not_measured_is_left_out():
    assert report.further(results(1.0)) == ""
    data = results(1.0)
    data["results"][0] |= {report.DRIVE: spread(0.95), "cpp_drive_us": spread(60)}
    data["worlds"] = [{"engine": "ode", "worlds": 64, "bodies_each": 50, "speedup": spread(1.8),
                       "one_thread_in_process_us": spread(90000), "step_worlds_us": spread(50000)}]
    data["rates"] = [{"engine": "ode", **{name: spread(wanted) for name, (_, _, wanted) in report.RATES.items()}}]

    page = report.page(data)

    assert "| ode | sleepers | 60 µs | 0.95 (0.85 to 1.04) |" in page
    assert "| ode | 64 | 50 | 90 ms | 50 ms | 1.80 (1.62 to 1.98) |" in page
    assert "| forces in columns, C++ | at least 2,000,000/s | 2,000,000/s |" in page
    assert "| a frame of 1,000 entities to numpy arrays, Python | at most 10 µs | 10.0 µs |" in page


def test_durations_have_three_digits_and_a_unit_that_suits_them():
    assert [report.duration(us) for us in (0.678, 64.81, 999.4, 1000, 31400)] == [
        "0.678 µs", "64.8 µs", "999 µs", "1 ms", "31.4 ms"]


def test_every_scene_is_a_row_and_its_bars_end_inside_the_picture():
    data = results(1.1)
    assert [row[:2] for row in report.rows(data)[1:]] == [["ode", "sleepers"], ["ode", "pile"]]
    svg = xml.etree.ElementTree.fromstring(report.picture(data))
    height = float(svg.get("viewBox").split()[3])
    bars = [rect for rect in svg.iter("{http://www.w3.org/2000/svg}rect") if rect.get("y") and rect.get("width") == "34"]
    assert len(bars) == 4 * len(data["results"])
    assert all(0 < float(bar.get("y")) and float(bar.get("y")) + float(bar.get("height")) < height for bar in bars)

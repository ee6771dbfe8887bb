#!/usr/bin/python3
"""Tells what the benchmark of the RPC cycle found out: a table for the terminal, a page and a picture.

Usage: report.py <folder with rpc.json> [--record]
       report.py --check

The page and the picture go beside rpc.json. With --record all three become those of the tree. The exit status is 1 if
serving a step costs more than it may, or `Drive` gives less. With --check nothing is written: it says whether the page of
the tree is what the recorded results say.
"""

from __future__ import annotations

import json
import pathlib
import sys
from typing import Any

RATIO_MAX = 1.15
"""What a cycle from C++ may cost, as a multiple of the step in the same process and an echo."""
BOUND = "cpp_cycle_to_step_and_bytes_echo"
"""The ratio that the bound is for."""
DRIVE_MIN = 0.9
"""How many results `Drive` gives at least, as a part of the rate of the slower of step and echo."""
DRIVE = "cpp_drive_rate_to_slower_of_step_and_bytes_echo"

RATES = {
    "cpp_forces_per_second": ("forces in columns, C++", "/s", 2e6),
    "python_forces_per_second": ("forces in columns, Python", "/s", 1e6),
    "entities_created_per_second": ("entities created in batches, C++", "/s", 50e3),
    "python_frame_to_numpy_us": ("a frame of 1,000 entities to numpy arrays, Python", " µs", 10),
    "python_small_frames_per_second": ("frames of one entity pushed, Python", "/s", 50e3),
    "unwatched_ns_per_body_and_step": ("what serving adds to a step that nobody looks at, per body", " ns", 1),
}
"""What is wanted of each: at least so many per second, at most so much time."""

TREE = pathlib.Path(__file__).resolve().parents[2]
RESULTS = TREE / "bench" / "results" / "rpc.json"
PAGE = TREE / "docs" / "performance.md"
PICTURE = "performance-rpc.svg"

SCENES = {
    "sleepers": "1,000 sleeping boxes",
    "flyers": "1,000 boxes in free flight",
    "pile": "a pile of 1,000 boxes",
}

_PARTS = ("in_process_us", "bytes_echo_us", "message_echo_us", "cpp_cycle_us", "python_cycle_us")
_RATIOS = ("cpp_cycle_to_step_and_bytes_echo", "cpp_cycle_to_step_and_message_echo")


def duration(microseconds: float) -> str:
    """As people read it: three digits and a unit."""
    if microseconds < 1000:
        return f"{microseconds:.3g} µs"
    return f"{microseconds / 1000:.3g} ms"


def named(scenes: list[dict[str, Any]]) -> list[str]:
    return [f"{each['scene']} on {each['engine']}" for each in scenes]


def missed(data: dict[str, Any]) -> list[str]:
    """Which scenes cost more than they may."""
    return named([each for each in data["results"] if each[BOUND]["median"] > RATIO_MAX])


def slow_drives(data: dict[str, Any]) -> list[str]:
    """In which scenes `Drive` waits longer than it may."""
    return named([each for each in data["results"] if DRIVE in each and each[DRIVE]["median"] < DRIVE_MIN])


def verdict(data: dict[str, Any]) -> str:
    bound = f"A cycle from C++ may cost {RATIO_MAX} × (step + echo of its bytes)"
    late = missed(data)
    return f"{bound}, and costs more for: {', '.join(late)}." if late else f"{bound}. It holds for every scene."


def drive_verdict(data: dict[str, Any]) -> str:
    bound = f"It shall give {DRIVE_MIN:.0%} of that rate"
    late = slow_drives(data)
    return f"{bound}, and gives less for: {', '.join(late)}." if late else f"{bound}, which holds for every scene."


def rows(data: dict[str, Any]) -> list[list[str]]:
    """The table, head first."""
    table = [["engine", "scene", "step", "echo, bytes", "echo, messages", "cycle, C++", "cycle, Python",
              "C++ / (step + bytes)", "C++ / (step + messages)"]]
    for each in data["results"]:
        medians = [duration(each[part]["median"]) for part in _PARTS]
        ratios = [f"{each[r]['median']:.2f} ({each[r]['p10']:.2f} to {each[r]['p90']:.2f})" for r in _RATIOS]
        table.append([each["engine"], each["scene"], *medians, *ratios])
    return table


def for_terminal(data: dict[str, Any]) -> str:
    table = rows(data)
    widths = [max(len(row[column]) for row in table) for column in range(len(table[0]))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in table]
    return "\n".join([*lines, "", verdict(data), "", further(data)])


def markdown_table(table: list[list[str]]) -> str:
    lines = [table[0], ["---"] * len(table[0]), *table[1:]]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def drive_rows(data: dict[str, Any]) -> list[list[str]]:
    table = [["engine", "scene", "time per step, two in flight", "rate / rate of the slower of step and echo"]]
    for each in data["results"]:
        if DRIVE in each:
            ratio = each[DRIVE]
            table.append([each["engine"], each["scene"], duration(each["cpp_drive_us"]["median"]),
                          f"{ratio['median']:.2f} ({ratio['p10']:.2f} to {ratio['p90']:.2f})"])
    return table


def worlds_rows(data: dict[str, Any]) -> list[list[str]]:
    table = [["engine", "worlds", "boxes in each", "one thread in process", "one call of StepWorlds", "ratio"]]
    for each in data.get("worlds", []):
        ratio = each["speedup"]
        table.append([each["engine"], str(each["worlds"]), str(each["bodies_each"]),
                      *(duration(each[part]["median"]) for part in ("one_thread_in_process_us", "step_worlds_us")),
                      f"{ratio['median']:.2f} ({ratio['p10']:.2f} to {ratio['p90']:.2f})"])
    return table


def rates_rows(data: dict[str, Any]) -> list[list[str]]:
    engines = data.get("rates", [])
    table = [["", "wanted", *(each["engine"] for each in engines)]]
    for name, (words, unit, wanted) in RATES.items():
        is_cost = unit != "/s"
        bound = f"{'at most' if is_cost else 'at least'} {wanted:,.0f}{unit}"
        table.append([words, bound, *(f"{each[name]['median']:,.{1 if is_cost else 0}f}{unit}" for each in engines)])
    return table


def further(data: dict[str, Any]) -> str:
    """What is measured besides the cycles, where the results have it."""
    parts = []
    if len(drive := drive_rows(data)) > 1:
        parts.append(f"""## Steps that are not waited for

`Drive` from C++ in the scenes above, with the same frames and events. It cannot be faster than the slower of the step
and the transport, which take turns in a call and overlap here. What counts is how a stream goes on, after 0.3 s of it.
{drive_verdict(data)}

{markdown_table(drive)}
""")
    if len(worlds := worlds_rows(data)) > 1:
        parts.append(f"""## Many worlds at once

A step of all worlds: one after the other in one thread of the process that wants them, and as one call of `StepWorlds`
over TCP loopback, with the frames and events of all. In the end all states are compared bit by bit.

{markdown_table(worlds)}
""")
    if data.get("rates"):
        parts.append(f"""## Many things in one message

{markdown_table(rates_rows(data))}

* **Forces**: `ApplyForceColumns` on 1,000 entities, from the values that a program has to the reply. The steps that use
  them up are not in it.
* **Entities**: spheres, 1,000 in a batch, into an empty world.
* **To numpy**: from the reply as a message to all columns as arrays.
* **Nobody looks**: 1,000 sleepers, stepped in calls without frame and events, against the same in process.
* **Pushed**: a world that plays as fast as it can, seen by `World.frames`.
""")
    return "\n".join(parts)


def machine(data: dict[str, Any]) -> str:
    about, versions = data["machine"], data["versions"]
    kind = "virtual " if about["virtual"] else ""
    engines = ", ".join(f"{name} {version}" for name, version in versions["engines"].items())
    python = versions["python_client"]
    return (
        f"Measured on {data['date'][:10]} on {about['processors']} {kind}processors ({about['processor']}), "
        f"{about['system']}, gRPC {versions['grpc']}, GCC {versions['compiler']}, engines {engines}, Python "
        f"{python['python']} with grpcio {python['grpcio']}, protobuf {python['protobuf']} and numpy {python['numpy']}."
    )


def calm(data: dict[str, Any]) -> str:
    worst = max(each["others_max_processors"] for each in data["results"])
    return (
        f"The load average was {data['load_average_before']:.1f} when the run began. In no round that counts did other "
        f"programs and the host use more than {worst:.2f} of the {data['machine']['processors']} processors."
    )


def page(data: dict[str, Any]) -> str:
    sizes = sorted({each["reply_bytes"] for each in data["results"]})
    replies = f"{sizes[0] / 1000:.0f}" + (f" to {sizes[-1] / 1000:.0f}" if sizes[-1] - sizes[0] > 1000 else "")
    pile = [each for each in data["results"] if each["scene"] == "pile"]
    contacts = " and ".join(f"{each['contacts']:,} contact points on {each['engine']}" for each in pile)
    scenes = ", ".join(SCENES[name] for name in dict.fromkeys(each["scene"] for each in data["results"]))
    return f"""# Performance

Written by `bench/rpc/report.py` from `bench/results/rpc.json`, which `script/bench rpc --record` measures.

## What serving a step costs

A client that steps a world pays for the step itself, for a round trip of its bytes, and for all that the server and the
client do besides: check the request, queue it, encode the frame and the events, decode them. The last part is ours to
keep small. {verdict(data)}

{markdown_table(rows(data))}

![Cost of a cycle as a multiple of step and echo]({PICTURE})

* **Scenes**: {scenes}, each stepped by 1/60 s with the default stepper. The pile has
  fallen and no longer tumbles, but is kept awake{f": {contacts}" if contacts else ""}.
* **Step**: `World::Step` of the C++ library and the events that it recorded, in the process that wants them.
* **Echo**: a unary gRPC call over TCP loopback to a process with no worlds, which carries the bytes of a cycle,
  {replies} kB down, made as gRPC makes calls that block, with a queue of its own (which costs 1.5 µs; our client keeps
  one). *Bytes*: neither side looks at them. *Messages*: both sides have protobuf messages, as programs do, so that the
  reply is copied, encoded and decoded.
* **Cycle**: the same step as one `Step` call to `genphysd` over TCP loopback. Back come positions, orientations and
  velocities of all entities as float64, and the events. From Python the columns are numpy arrays.

Each way has a world of its own, and all are at the same step when they take the next one; in the end their states are
compared bit by bit. All take turns in one run, in changing order, {data['results'][0]['rounds']} rounds of each
scene. Durations are means of the steps of a round, ratios are of these means, and of both the median of all rounds is
shown; in parentheses from the tenth to the ninetieth percentile of the rounds.

{further(data)}{chr(10) if further(data) else ""}{machine(data)} {calm(data)}
"""


def picture(data: dict[str, Any]) -> str:
    """Bars of each scene: step and echo one on the other, as one unit, then the cycles."""
    results = data["results"]
    bar, gap, left, top, height = 34, 34, 56, 44, 260
    cycles = [each["cpp_cycle_us"]["median"] for each in results] + [each["python_cycle_us"]["median"] for each in results]
    units = [each["in_process_us"]["median"] + each["bytes_echo_us"]["median"] for each in results]
    top_value = max(2.0, max(cycle / unit for cycle, unit in zip(cycles, units * 2)) * 1.05)
    group = 3 * bar + gap
    width = left + group * len(results) + gap
    base = top + height

    def y(value: float) -> float:
        return base - height * value / top_value

    def box(x: float, low: float, high: float, color: str) -> str:
        return f'<rect x="{x:.1f}" y="{y(high):.1f}" width="{bar}" height="{y(low) - y(high):.1f}" fill="{color}"/>'

    def text(x: float, at: float, words: str, anchor: str = "middle") -> str:
        return f'<text x="{x:.1f}" y="{at:.1f}" text-anchor="{anchor}">{words}</text>'

    colors = {"step in process": "#4c78a8", "echo of the bytes": "#9ecae9", "cycle, C++": "#f58518", "cycle, Python": "#bab0ac"}
    step, echo, cpp, python = colors.values()
    parts = []
    for place, (words, color) in enumerate(colors.items()):
        x = left + place * 130
        parts += [f'<rect x="{x}" y="12" width="12" height="12" fill="{color}"/>', text(x + 18, 22, words, "start")]
    for value in range(int(top_value) + 1):
        parts += [f'<line x1="{left}" x2="{width - gap}" y1="{y(value):.1f}" y2="{y(value):.1f}" stroke="#ddd"/>',
                  text(left - 8, y(value) + 4, str(value), "end")]
    for place, (each, unit) in enumerate(zip(results, units)):
        x = left + gap / 2 + place * group
        share = each["in_process_us"]["median"] / unit
        heights = [each[part]["median"] / unit for part in ("cpp_cycle_us", "python_cycle_us")]
        parts += [box(x, 0, share, step), box(x, share, 1, echo), box(x + bar, 0, heights[0], cpp),
                  box(x + 2 * bar, 0, heights[1], python), text(x + 1.5 * bar, base + 18, each["scene"]),
                  text(x + 1.5 * bar, base + 34, each["engine"]), text(x + 0.5 * bar, y(1) - 5, duration(unit)),
                  text(x + 1.5 * bar, y(max(heights[0], RATIO_MAX)) - 5, f"{heights[0]:.2f}")]
    parts.append(f'<line x1="{left}" x2="{width - gap}" y1="{y(RATIO_MAX):.1f}" y2="{y(RATIO_MAX):.1f}" '
                 'stroke="#d62728" stroke-dasharray="5 4"/>')
    parts.append(text(width - gap + 2, y(RATIO_MAX) + 4, f"{RATIO_MAX}", "start"))
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {base + 48}" font-family="sans-serif" '
        f'font-size="11">\n<rect width="100%" height="100%" fill="white"/>\n{body}\n</svg>\n'
    )


def write(data: dict[str, Any], path: pathlib.Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page(data))
    path.with_name(PICTURE).write_text(picture(data))


def check() -> int:
    data = json.loads(RESULTS.read_text())
    stale = [path for path, wanted in ((PAGE, page(data)), (PAGE.with_name(PICTURE), picture(data)))
             if not path.is_file() or path.read_text() != wanted]
    for path in stale:
        print(f"{path.relative_to(TREE)} is not what bench/results/rpc.json says: run script/bench rpc --record")
    return 1 if stale else 0


def main(arguments: list[str]) -> int:
    if arguments == ["--check"]:
        return check()
    if not arguments or arguments[1:] not in ([], ["--record"]):
        print(__doc__, file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[0])
    text = (folder / "rpc.json").read_text()
    data = json.loads(text)
    print(for_terminal(data))
    write(data, folder / PAGE.name)
    if arguments[1:]:
        RESULTS.parent.mkdir(exist_ok=True)
        RESULTS.write_text(text)
        write(data, PAGE)
    print(f"More in {PAGE if arguments[1:] else folder / PAGE.name}")
    return 1 if missed(data) or slow_drives(data) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

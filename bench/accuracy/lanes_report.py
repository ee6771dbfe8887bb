#!/usr/bin/python3
"""Compares the errors of two runs, with the lanes that leave bodies to the layer alone and without them.

Usage: lanes_report.py <results with lanes> <results without>

Fails if a number differs by more than the method may be off by.
"""

from __future__ import annotations

import json
import pathlib
import sys
from typing import Any, NamedTuple

PART = 0.01
"""Of the larger number."""
TOLERANCE = 5e-5
"""In the unit of the number, mostly a part of the size of what happens. An impact is found as deep as 1e-5 of the way of
a substep, and flight takes a step at once where the engine takes it in substeps."""


class Pair(NamedTuple):
    """A number of both runs."""

    what: str
    on: float | None
    off: float | None

    def agrees(self, part: float = PART, tolerance: float = TOLERANCE) -> bool:
        if self.on is None or self.off is None:
            return self.on == self.off
        return abs(self.on - self.off) <= max(part * max(abs(self.on), abs(self.off)), tolerance)


def numbers(results: dict[str, Any]) -> dict[str, float]:
    """All that was measured but for costs, by problem, contender, steps per second and name."""
    found = {}
    for problem in results["problems"]:
        for contender, cells in problem["results"].items():
            for rate, cell in cells.items():
                for name, value in cell.items():
                    if isinstance(value, (int, float)) and name != "cpu":
                        found[f"{problem['id']} {contender} 1/{rate} {name}"] = value
    return found


def compare(on: dict[str, Any], off: dict[str, Any]) -> list[Pair]:
    """What both measured; of what one of them could not, the other alone."""
    first, second = numbers(on), numbers(off)
    return [Pair(what, first.get(what), second.get(what)) for what in sorted(first.keys() | second.keys())]


def main(arguments: list[str]) -> int:
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    pairs = compare(*(json.loads(pathlib.Path(path).read_text()) for path in arguments))
    apart = [pair for pair in pairs if not pair.agrees()]
    for pair in apart:
        print(f"{pair.what}: {pair.on} with lanes, {pair.off} without")
    same = sum(pair.agrees(tolerance=1e-9) for pair in pairs)
    print(f"{len(pairs)} numbers with and without lanes: {same} differ by no more than {PART:.0%} or 1e-9, "
          f"{len(pairs) - same - len(apart)} by no more than {TOLERANCE:g}, {len(apart)} by more")
    return 1 if apart or not pairs else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

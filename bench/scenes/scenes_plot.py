"""Draws what scenes cost beside the engines alone, as logarithms."""

from __future__ import annotations

import math
import pathlib
import sys
from typing import Any

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scaling"))

from scaling_plot import draw_line, draw_text, power, sheet  # noqa: E402 the folder has to be known first

COLORS = {"fast": "#9ecae9", "balanced": "#4c78a8", "accurate": "#1b3a5c"}
CHEAPEST, DEAREST = 0.1, 100
"""Ratios below and above are drawn at the edge."""

_LEFT, _WIDTH, _GAP, _BAR, _TOP = 210, 330, 40, 7, 62

Rows = list[tuple[str, dict[str, dict[str, float]], dict[str, str]]]


def ratios(rows: Rows, engines: dict[str, str]) -> str:
    """One row for each part of a scene: its words, by engine the ratio of each preset, and by engine why there is none."""
    low, high = math.log10(CHEAPEST), math.log10(DEAREST)
    row_height = _BAR * len(COLORS) + 7
    base = _TOP + row_height * len(rows)
    parts = []

    def left_of(panel: int) -> float:
        return _LEFT + panel * (_WIDTH + _GAP)

    def x(panel: int, ratio: float) -> float:
        share = (math.log10(min(max(ratio, CHEAPEST), DEAREST)) - low) / (high - low)
        return left_of(panel) + _WIDTH * share

    for place, (preset, color) in enumerate(COLORS.items()):
        at = _LEFT + 90 * place
        parts += [f'<rect x="{at}" y="8" width="12" height="10" fill="{color}"/>', draw_text(at + 18, 17, preset, "start")]
    for panel, title in enumerate(engines.values()):
        parts.append(draw_text(left_of(panel) + _WIDTH / 2, _TOP - 26, title))
        for exponent in range(round(low), round(high) + 1):
            at = x(panel, 10.0**exponent)
            parts += [draw_line(at, _TOP - 6, at, base, 'stroke="#ddd"'), draw_text(at, _TOP - 10, power(exponent))]
    for place, (words, by_engine, missing) in enumerate(rows):
        top = _TOP + row_height * place
        parts.append(draw_text(_LEFT - 8, top + row_height / 2 + 2, words, "end"))
        for panel, engine in enumerate(engines):
            for number, (preset, color) in enumerate(COLORS.items()):
                ratio = by_engine.get(engine, {}).get(preset)
                if ratio is None:
                    continue
                begin, end = sorted((x(panel, 1), x(panel, ratio)))
                parts.append(f'<rect x="{begin:.1f}" y="{top + _BAR * number:.1f}" width="{max(end - begin, 0.5):.1f}" '
                             f'height="{_BAR - 1}" fill="{color}"/>')
            if engine in missing:
                parts.append(draw_text(x(panel, 1) + 6, top + row_height / 2 + 2, missing[engine], "start"))
    for panel in range(len(engines)):
        parts.append(draw_line(x(panel, 1), _TOP - 6, x(panel, 1), base, 'stroke="black"'))
    parts.append(draw_text(_LEFT + _WIDTH + _GAP / 2, base + 18, "processor time of a step, over that of the engine alone"))
    return sheet(_LEFT + len(engines) * (_WIDTH + _GAP), base + 28, parts)

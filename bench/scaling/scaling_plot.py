"""Draws how cost grows, as logarithms, and how near figures are to their bars."""

from __future__ import annotations

import html
import math
from typing import Any

COLORS = {"ode": "#4c78a8", "bullet": "#f58518"}
HELD, MISSED = "#54a24b", "#d62728"
NEAREST, FARTHEST = 1e-3, 10
"""Shares of a bar below and above are drawn at the edge."""

LINES = {("passer", "asleep"): ("a box passes sleepers", ""),
         ("passer", "static"): ("a box passes static bodies", "6 3"),
         ("asleep", "all asleep"): ("all asleep", "2 3")}
"""Which series of which scenes the first picture has: words and dashes."""

_LEFT, _WIDTH, _HEIGHT = 60, 620, 300


def draw_text(x: float, y: float, words: str, anchor: str = "middle") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{html.escape(words)}</text>'


def draw_line(x1: float, y1: float, x2: float, y2: float, style: str) -> str:
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" {style}/>'


def sheet(width: float, height: float, parts: list[str]) -> str:
    body = "\n".join(parts)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
            f'font-size="11">\n<rect width="100%" height="100%" fill="white"/>\n{body}\n</svg>\n')


def power(exponent: int) -> str:
    return f"{10**exponent:,}" if exponent >= 0 else f"{10.0**exponent:.{-exponent}f}"


def _curves(data: dict[str, Any]) -> list[tuple[str, str, str, list[tuple[float, float]]]]:
    """Words, color, dashes and points of each line."""
    found = []
    for outcome in data["results"]:
        for (scene, series), (words, dash) in LINES.items():
            points = [(each["size"], each["step_us"]["median"]) for each in outcome["costs"]
                      if scene == outcome["scene"] and series == each["series"] and each["size"] > 0]
            if points:
                found.append((f"{words}, {outcome['engine']}", COLORS[outcome["engine"]], dash, sorted(points)))
    return found


def _decades(values: tuple[float, ...]) -> tuple[int, int]:
    """Exponents of the powers of ten around them."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return low, max(high, low + 1)


def costs(data: dict[str, Any]) -> str:
    """Microseconds per step upwards, bodies that have nothing to do with it to the right."""
    curves = _curves(data)
    points = [point for *_, line in curves for point in line]
    (x_low, x_high), (y_low, y_high) = (_decades(column) for column in zip(*points))
    top = 20 + 16 * math.ceil(len(curves) / 2)
    base = top + _HEIGHT

    def x(size: float) -> float:
        return _LEFT + _WIDTH * (math.log10(size) - x_low) / (x_high - x_low)

    def y(cost: float) -> float:
        return base - _HEIGHT * (math.log10(cost) - y_low) / (y_high - y_low)

    parts = []
    for exponent in range(x_low, x_high + 1):
        parts += [draw_line(x(10.0**exponent), top, x(10.0**exponent), base, 'stroke="#ddd"'),
                  draw_text(x(10.0**exponent), base + 16, power(exponent))]
    for exponent in range(y_low, y_high + 1):
        parts += [draw_line(_LEFT, y(10.0**exponent), _LEFT + _WIDTH, y(10.0**exponent), 'stroke="#ddd"'),
                  draw_text(_LEFT - 6, y(10.0**exponent) + 4, power(exponent), "end")]
    for place, (words, color, dash, line) in enumerate(curves):
        left, at = _LEFT + place % 2 * _WIDTH / 2, 14 + place // 2 * 16
        style = f'stroke="{color}" stroke-width="2"' + (f' stroke-dasharray="{dash}"' if dash else "")
        path = " ".join(f"{x(size):.1f},{y(cost):.1f}" for size, cost in line)
        parts += [draw_line(left, at, left + 28, at, style), draw_text(left + 36, at + 4, words, "start"),
                  f'<polyline points="{path}" fill="none" {style}/>']
        parts += [f'<circle cx="{x(size):.1f}" cy="{y(cost):.1f}" r="3" fill="{color}"/>' for size, cost in line]
    parts.append(draw_text(_LEFT + _WIDTH / 2, base + 34, "to the right: bodies beside it; upwards: µs per step"))
    return sheet(_LEFT + _WIDTH + 30, base + 44, parts)


def bars(figures: list[tuple[str, float, bool]]) -> str:
    """One bar for each figure that may not be too large: its words, its share of what it may be, whether it is held."""
    left, width, row, top = 470, 300, 18, 24
    low, high = math.log10(NEAREST), math.log10(FARTHEST)
    base = top + row * len(figures)

    def x(share: float) -> float:
        return left + width * (math.log10(min(max(share, NEAREST), FARTHEST)) - low) / (high - low)

    parts = []
    for exponent in range(round(low), round(high) + 1):
        parts += [draw_line(x(10.0**exponent), top - 6, x(10.0**exponent), base, 'stroke="#ddd"'),
                  draw_text(x(10.0**exponent), top - 10, power(exponent))]
    for place, (words, share, is_held) in enumerate(figures):
        at = top + row * place
        parts += [draw_text(left - 8, at + 12, words, "end"),
                  f'<rect x="{left}" y="{at + 3}" width="{x(share) - left:.1f}" height="{row - 6}" '
                  f'fill="{HELD if is_held else MISSED}"/>', draw_text(x(share) + 4, at + 12, f"{share:.2g}", "start")]
    parts.append(draw_line(x(1), top - 6, x(1), base, 'stroke="black" stroke-dasharray="5 4"'))
    parts.append(draw_text(left + width / 2, base + 16, "median over what it may be at most"))
    return sheet(left + width + 50, base + 26, parts)

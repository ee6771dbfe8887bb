"""Draws work against precision: for each problem a panel with error over cost, both as logarithms."""

from __future__ import annotations

import math
from collections.abc import Iterable

Points = list[tuple[float, float]]
Styles = dict[str, tuple[str, str]]

STYLES = {
    "genphys-ode-fast": ("#9ecae9", ""), "genphys-ode-balanced": ("#4c78a8", ""), "genphys-ode-accurate": ("#1b3a5c", ""),
    "genphys-bullet-fast": ("#ffbf79", ""), "genphys-bullet-balanced": ("#f58518", ""),
    "genphys-bullet-accurate": ("#8c4a00", ""),
    "raw-ode-step": ("#4c78a8", "2 3"), "raw-ode-quick": ("#4c78a8", "6 3"), "raw-bullet": ("#f58518", "6 3"),
}
PEER_COLORS = {
    "peer-drake": "#2a9d3a", "peer-jolt": "#d62728", "peer-mujoco": "#7b3fbf", "peer-mujoco-rk4": "#c77dff",
    "peer-pybullet": "#17a2a2", "peer-rapier": "#e377c2",
}
LEAST = 1e-16
"""Errors of zero are drawn there."""
MOST = 1e3
"""Errors of peers that are more are drawn there: they blew up, and others are to be seen beside them."""

_COLUMNS, _WIDTH, _HEIGHT, _MARGIN = 3, 270, 210, 46


def is_peer(name: str) -> bool:
    """Whether a contender is another engine, whose lines are thin."""
    return name.startswith("peer-")


def peer_styles(names: Iterable[str]) -> Styles:
    return {name: (PEER_COLORS.get(name, "#888888"), "3 2") for name in names}


def _decades(values: list[float]) -> tuple[int, int]:
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return low, max(high, low + 1)


def _text(x: float, y: float, words: str, anchor: str = "middle") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{words}</text>'


def _power(exponent: int) -> str:
    return f'10<tspan dy="-4" font-size="8">{exponent}</tspan>'


def panel(title: str, lines: dict[str, Points], left: float, top: float, styles: Styles) -> list[str]:
    """Cost in microseconds per simulated second to the right, error upwards."""
    drawn = {name: [(1e6 * cpu, max(min(error, MOST) if is_peer(name) else error, LEAST)) for cpu, error in line]
             for name, line in lines.items() if line}
    costs = [cpu for line in drawn.values() for cpu, _ in line]
    errors = [error for line in drawn.values() for _, error in line]
    (x_low, x_high), (y_low, y_high) = _decades(costs), _decades(errors)
    inner_left, inner_top = left + _MARGIN, top + 20
    inner_width, inner_height = _WIDTH - _MARGIN - 14, _HEIGHT - 58

    def x(cost: float) -> float:
        return inner_left + inner_width * (math.log10(cost) - x_low) / (x_high - x_low)

    def y(error: float) -> float:
        return inner_top + inner_height * (1 - (math.log10(error) - y_low) / (y_high - y_low))

    parts = [_text(inner_left + inner_width / 2, top + 12, f"<tspan font-weight=\"bold\">{title}</tspan>")]
    for exponent in range(x_low, x_high + 1):
        at = x(10.0**exponent)
        parts += [f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{inner_top}" y2="{inner_top + inner_height}" stroke="#ddd"/>',
                  _text(at, inner_top + inner_height + 15, _power(exponent))]
    step = max(1, (y_high - y_low) // 6)
    for exponent in range(y_low, y_high + 1, step):
        at = y(10.0**exponent)
        parts += [f'<line x1="{inner_left}" x2="{inner_left + inner_width}" y1="{at:.1f}" y2="{at:.1f}" stroke="#ddd"/>',
                  _text(inner_left - 6, at + 4, _power(exponent), "end")]
    for name, line in drawn.items():
        color, dash = styles.get(name, ("#888888", ""))
        path = " ".join(f"{x(cost):.1f},{y(error):.1f}" for cost, error in line)
        thickness, dot = ("0.8", f'r="1.8" fill="white" stroke="{color}" stroke-width="0.8"') if is_peer(name) else (
            "1.5", f'r="2" fill="{color}"')
        parts.append(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="{thickness}"'
                     + (f' stroke-dasharray="{dash}"' if dash else "") + "/>")
        parts += [f'<circle cx="{x(cost):.1f}" cy="{y(error):.1f}" {dot}/>' for cost, error in line]
    return parts


def picture(panels: list[tuple[str, dict[str, Points]]], styles: Styles = STYLES) -> str:
    """All panels on one sheet, with one legend: color and dashes of each line by its name."""
    rows = math.ceil(len(panels) / _COLUMNS)
    width = _COLUMNS * _WIDTH
    legend = max(3, math.ceil(len(styles) / 3)) * 16 + 12
    height = legend + rows * _HEIGHT + 16
    parts = []
    for place, (name, (color, dash)) in enumerate(styles.items()):
        left, top = 12 + place % 3 * _WIDTH, 14 + place // 3 * 16
        parts += [f'<line x1="{left}" x2="{left + 28}" y1="{top}" y2="{top}" stroke="{color}" '
                  f'stroke-width="{1 if is_peer(name) else 2}"'
                  + (f' stroke-dasharray="{dash}"' if dash else "") + "/>", _text(left + 36, top + 4, name, "start")]
    for place, (title, lines) in enumerate(panels):
        parts += panel(title, lines, place % _COLUMNS * _WIDTH, legend + place // _COLUMNS * _HEIGHT, styles)
    parts.append(_text(width / 2, height - 6, "to the right: µs of processor time per simulated second; upwards: error"))
    body = "\n".join(parts)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
            f'font-size="11">\n<rect width="100%" height="100%" fill="white"/>\n{body}\n</svg>\n')

"""What the report of accuracy computes from results, whoever they are of."""

from __future__ import annotations

import math
from typing import Any

FLOOR = 1e-12
"""Errors below it are equal: they are rounding."""
NOISE = 1.1
"""By what factor two measurements of the same cost differ on a busy machine."""

Points = list[tuple[float, float]]


def number(value: float | None) -> str:
    if value is None:
        return "failed"
    if value == 0:
        return "0"
    if value < FLOOR:
        return "< 1e-12"
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{value:.2g}" if -3 <= int(exponent) <= 3 else f"{mantissa}e{int(exponent)}"


def points(problem: dict[str, Any], contender: str) -> Points:
    """Cost per simulated second and error, cheapest first."""
    cells = problem["results"].get(contender, {}).values()
    return sorted((cell["cpu"], cell["error"]) for cell in cells if cell.get("cpu") and "error" in cell)


def order(problem: dict[str, Any], contender: str) -> float | None:
    """Of convergence: by least squares over the finest steps whose errors are not rounding, at least three."""
    cells = problem["results"].get(contender, {})
    known = [(math.log(int(rate)), math.log(cell["error"])) for rate, cell in cells.items() if cell.get("error", 0) > FLOOR]
    known = sorted(known)[-4:]
    if len(known) < 3:
        return None
    mean_x, mean_y = (sum(column) / len(known) for column in zip(*known))
    spread = sum((x - mean_x) ** 2 for x, _ in known)
    return -sum((x - mean_x) * (y - mean_y) for x, y in known) / spread


def error_at(ours: Points, cost: float) -> float | None:
    """The least error that our points reach at that cost, between them along straight lines of logarithms."""
    affordable = [error for cpu, error in ours if cpu <= cost * NOISE]
    if not affordable:
        return None
    best = min(affordable)
    for (cpu_a, error_a), (cpu_b, error_b) in zip(ours, ours[1:]):
        if cpu_a <= cost < cpu_b and error_a > 0 and error_b > 0:
            part = math.log(cost / cpu_a) / math.log(cpu_b / cpu_a)
            best = min(best, math.exp(math.log(error_a) + part * math.log(error_b / error_a)))
    return best


def table(rows: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in [rows[0], ["---"] * len(rows[0]), *rows[1:]])

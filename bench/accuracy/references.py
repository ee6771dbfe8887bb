#!/usr/bin/python3
"""Computes what the problems of the benchmark must come to: closed forms, or an integration that comes to the same 25
digits with steps half as long. All in 133 bits.

Usage: references.py [--check]

Writes references.h beside itself; with --check it only says whether that file is what it would write.
"""

from __future__ import annotations

import pathlib
import sys
import textwrap
from collections.abc import Callable

from mpmath import ellipfun, ellipk, linspace, mp, mpf, quad

mp.prec = 133

HEADER = pathlib.Path(__file__).with_name("references.h")
G = mpf("9.81")
AGREEMENT = mpf(10) ** -25

State = list[mpf]
Slope = Callable[[State], State]


def extrapolated_step(slope: Slope, start: State, step: mpf, columns: int = 14) -> State:
    """One step of Gragg, Bulirsch and Stoer: modified midpoints of 2, 4, .. substeps, extrapolated to none."""
    table: list[list[State]] = []
    for column in range(columns):
        count = 2 * (column + 1)
        h = step / count
        before, now = start, [y + h * f for y, f in zip(start, slope(start))]
        for _ in range(count - 1):
            before, now = now, [y + 2 * h * f for y, f in zip(before, slope(now))]
        row = [[(a + b + h * f) / 2 for a, b, f in zip(before, now, slope(now))]]
        for k in range(1, column + 1):
            ratio = mpf(column + 1) / (column + 1 - k)
            row.append([a + (a - b) / (ratio**2 - 1) for a, b in zip(row[k - 1], table[-1][k - 1])])
        table.append(row)
    return table[-1][-1]


def integrate(slope: Slope, start: State, time: mpf, steps: int) -> State:
    def run(count: int) -> State:
        state = start
        for _ in range(count):
            state = extrapolated_step(slope, state, mpf(time) / count)
        return state

    coarse, fine = run(steps), run(2 * steps)
    if max(abs(a - b) for a, b in zip(coarse, fine)) > AGREEMENT:
        raise ArithmeticError("steps half as long come to something else")
    return fine


def cross(a: State, b: State) -> State:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def turned(q: State, v: State) -> State:
    """The vector v, given in the body, in the world; q is w x y z."""
    t = [2 * c for c in cross(q[1:], v)]
    return [a + q[0] * b + c for a, b, c in zip(v, t, cross(q[1:], t))]


def rigid_slope(moments: State, torque: Callable[[State], State]) -> Slope:
    """Of orientation and spin in the body, of a body with these principal moments; the torque is in the body."""

    def slope(state: State) -> State:
        q, w = state[:4], state[4:]
        spin_q = [(-q[1] * w[0] - q[2] * w[1] - q[3] * w[2]) / 2, (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]) / 2,
                  (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]) / 2, (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]) / 2]
        change = cross([i * c for i, c in zip(moments, w)], w)
        return spin_q + [(a + b) / i for a, b, i in zip(change, torque(q), moments)]

    return slope


def top_orientation() -> State:
    """Of a free body with moments 2, 3, 4 that starts with spin (0, 2, 1), after 10 s."""
    slope = rigid_slope([mpf(2), mpf(3), mpf(4)], lambda q: [mpf(0)] * 3)
    state = integrate(slope, [mpf(x) for x in (1, 0, 0, 0, 0, 2, 1)], mpf(10), 30)
    momentum = turned(state[:4], [i * w for i, w in zip((2, 3, 4), state[4:])])
    if max(abs(a - b) for a, b in zip(momentum, (0, 6, 4))) > AGREEMENT:
        raise ArithmeticError("the momentum is not kept")
    return state[:4]


def sprung() -> mpf:
    """1 kg on a spring of 1000 N/m with 2 N s/m, let go at 0.1 m, at 1 s."""
    decay, rate = mpf(1), mp.sqrt(mpf(999))
    return mp.exp(-decay) / 10 * (mp.cos(rate) + decay / rate * mp.sin(rate))


def flip_period() -> mpf:
    """Of the same body with spin (0, 5, 0.01): Landau and Lifshitz, Mechanics, section 37."""
    i1, i2, i3 = mpf(2), mpf(3), mpf(4)
    w2, w3 = mpf(5), mpf("0.01")
    energy, momentum = i2 * w2**2 + i3 * w3**2, (i2 * w2) ** 2 + (i3 * w3) ** 2
    rate = mp.sqrt((i3 - i2) * (momentum - energy * i1) / (i1 * i2 * i3))
    return 2 * ellipk((i2 - i1) * (energy * i3 - momentum) / ((i3 - i2) * (momentum - energy * i1))) / rate


ROD_INERTIA = (1 + mpf("0.05") ** 2) / 12
"""Of 1 kg in a box of 1 x 0.05 x 0.05 m, across its length."""


def pendulum(time: mpf) -> tuple[State, State]:
    """Place and velocity of the middle of that rod, hung at its end and let go when horizontal: x and z."""
    rate = mp.sqrt(G / 2 / (ROD_INERTIA + mpf(1) / 4))
    k = mp.sin(mp.pi / 4)
    u = ellipk(k**2) - rate * time
    angle = 2 * mp.asin(k * ellipfun("sn", u, m=k**2))
    speed = -2 * k * rate * ellipfun("cn", u, m=k**2)
    sine, cosine = mp.sin(angle), mp.cos(angle)
    return [sine / 2, -cosine / 2], [speed * cosine / 2, speed * sine / 2]


def released_pendulum() -> State:
    """The same at 1 s if it is set free at 0.5 s."""
    place, velocity = pendulum(mpf("0.5"))
    return [place[0] + velocity[0] / 2, place[1] + velocity[1] / 2 - G / 8]


def double_pendulum() -> State:
    """The middle of the second of two such rods, both let go when horizontal, at 2 s: x and z."""
    m11, m22 = ROD_INERTIA + mpf(5) / 4, ROD_INERTIA + mpf(1) / 4

    def slope(state: State) -> State:
        a, b, va, vb = state
        m12, sine = mp.cos(a - b) / 2, mp.sin(a - b) / 2
        right_a = -sine * vb**2 - 3 * G / 2 * mp.sin(a)
        right_b = sine * va**2 - G / 2 * mp.sin(b)
        det = m11 * m22 - m12**2
        return [va, vb, (m22 * right_a - m12 * right_b) / det, (m11 * right_b - m12 * right_a) / det]

    a, b = integrate(slope, [mp.pi / 2, mp.pi / 2, mpf(0), mpf(0)], mpf(2), 150)[:2]
    return [mp.sin(a) + mp.sin(b) / 2, -mp.cos(a) - mp.cos(b) / 2]


def heavy_top() -> State:
    """The centre of 1 kg in a cylinder of radius 0.2 and height 0.1 m, 0.3 m above the point that its axis turns about,
    tilted by 60 degrees about y and spun at 50 rad/s, at 2 s."""
    length = mpf("0.3")
    across = (3 * mpf("0.2") ** 2 + mpf("0.1") ** 2) / 12 + length**2
    moments = [across, across, mpf("0.2") ** 2 / 2]

    def torque(q: State) -> State:
        weight = turned([q[0], -q[1], -q[2], -q[3]], [mpf(0), mpf(0), -G])
        return cross([mpf(0), mpf(0), length], weight)

    half = mp.pi / 6
    start = [mp.cos(half), mpf(0), mp.sin(half), mpf(0), mpf(0), mpf(0), mpf(50)]
    return turned(integrate(rigid_slope(moments, torque), start, mpf(2), 100)[:4], [mpf(0), mpf(0), length])


def steady_precession() -> mpf:
    """The slower rate at which that top turns about the vertical without nodding, rad/s, with 50 rad/s about its axis."""
    across = (3 * mpf("0.2") ** 2 + mpf("0.1") ** 2) / 12 + mpf("0.3") ** 2
    lean, spin, torque = across * mp.cos(mp.pi / 3), mpf("0.02") * 50, G * mpf("0.3")
    return (spin - mp.sqrt(spin**2 - 4 * lean * torque)) / (2 * lean)


def slider_crank() -> mpf:
    """Where the slider of 1 kg is at 1 s, driven by a crank of 0.1 m and a rod of 0.3 m, thin and of 1 kg each, without
    gravity, from 60 degrees and 20 rad/s: the energy says how fast the crank turns at each angle."""
    crank, rod = mpf("0.1"), mpf("0.3")

    def at(angle: mpf) -> tuple[mpf, mpf]:
        """Place of the slider, and the kinetic energy over half the square of the crank's speed."""
        lean = mp.asin(crank * mp.sin(angle) / rod)
        lean_rate = crank * mp.cos(angle) / (rod * mp.cos(lean))
        place = crank * mp.cos(angle) + rod * mp.cos(lean)
        slide = -crank * mp.sin(angle) - rod * mp.sin(lean) * lean_rate
        along, across = -crank * mp.sin(angle) - rod / 2 * mp.sin(lean) * lean_rate, crank * mp.cos(angle) / 2
        return place, crank**2 / 3 + along**2 + across**2 + rod**2 / 12 * lean_rate**2 + slide**2

    start = at(mp.pi / 3)[1]
    angle = mpf("26.4")
    # Newton's steps double the digits.
    for _ in range(5):
        time = quad(lambda a: mp.sqrt(at(a)[1] / start) / 20, linspace(mp.pi / 3, angle, 30))
        angle -= (time - 1) * 20 / mp.sqrt(at(angle)[1] / start)
    if abs(time - 1) > AGREEMENT:
        raise ArithmeticError("that angle comes at another time")
    return at(angle)[0]


def slip_acceleration() -> mpf:
    """Of a block on a slope that is steeper than its friction of 0.5 holds, by a hundredth."""
    angle = mp.atan(mpf("0.505"))
    return G * (mp.sin(angle) - mp.cos(angle) / 2)


def slide_then_roll() -> mpf:
    """How far a ball comes in 2 s that is thrown along a floor at 7 m/s without spin, with a friction of 0.2: it slides
    until it has five sevenths of its speed."""
    slowing = G / 5
    until = 2 / slowing
    return 7 * until - slowing * until**2 / 2 + 5 * (2 - until)


def rest_time(e: str) -> mpf:
    """Of a ball that falls 1 m: the sum of all its flights."""
    return mp.sqrt(2 / G) * (1 + mpf(e)) / (1 - mpf(e))


def tilted_bounce() -> State:
    """Where a ball is at 0.8 s, from where it first touches a slope of 20 degrees after falling 1 m: x and z. Without
    friction, with a restitution of 0.8."""
    speed = mp.sqrt(2 * G)
    left = mpf("0.8") - speed / G
    angle = mp.pi / 9
    normal = [mp.sin(angle), mp.cos(angle)]
    push = mpf("1.8") * speed * normal[1]
    return [push * normal[0] * left, (push * normal[1] - speed) * left - G * left**2 / 2]


def two_spheres() -> tuple[State, State]:
    """Where two spheres are at 0.5 s that meet aslant, without gravity and friction and with a restitution of 0.7."""
    x1, v1, m1 = [mpf(0)] * 3, [mpf(3), mpf(0), mpf(0)], mpf(1)
    x2, v2, m2 = [mpf(1), mpf("0.1"), mpf("0.05")], [mpf(-1), mpf("0.2"), mpf(0)], mpf(2)
    apart = [a - b for a, b in zip(x2, x1)]
    drift = [a - b for a, b in zip(v2, v1)]
    a, b = sum(c * c for c in drift), sum(c * d for c, d in zip(apart, drift))
    meeting = (-b - mp.sqrt(b * b - a * (sum(c * c for c in apart) - mpf("0.25") ** 2))) / a
    normal = [(c + d * meeting) / mpf("0.25") for c, d in zip(apart, drift)]
    impulse = -mpf("1.7") * sum(c * d for c, d in zip(drift, normal)) / (1 / m1 + 1 / m2)
    left = mpf("0.5") - meeting
    first = [x + v / 2 - impulse / m1 * n * left for x, v, n in zip(x1, v1, normal)]
    second = [x + v / 2 + impulse / m2 * n * left for x, v, n in zip(x2, v2, normal)]
    return first, second


def references() -> list[tuple[str, str, mpf | State]]:
    """Name, meaning and value of each."""
    hung, stop = pendulum(mpf(5))[0], mpf(25) / G
    first, second = two_spheres()
    slope = mp.pi / 12
    return [
        ("kTopOrientation", "A5 at 10 s, w x y z.", top_orientation()),
        ("kFlipPeriod", "A5dz, s; the first flip comes at half of it.", flip_period()),
        ("kSprung", "A3 at 1 s, m.", sprung()),
        ("kPendulum", "B1 at 5 s, x and z of the centre, m.", hung),
        ("kReleasedPendulum", "B1 set free at 0.5 s, at 1 s, x and z of the centre, m.", released_pendulum()),
        ("kDoublePendulum", "B3 at 2 s, x and z of the second centre, m.", double_pendulum()),
        ("kHeavyTop", "B4 at 2 s, the centre, m.", heavy_top()),
        ("kPrecession", "B4.steady, rad/s.", steady_precession()),
        ("kSliderCrank", "B5 at 1 s, m.", slider_crank()),
        ("kStickAngle", "C1: a hundredth below what friction 0.5 holds, rad.", mp.atan(mpf("0.495"))),
        ("kSlipAngle", "C1: a hundredth above, rad.", mp.atan(mpf("0.505"))),
        ("kSlipAcceleration", "C1 above, m/s^2.", slip_acceleration()),
        ("kStopDistance", "C2, m.", stop),
        ("kSlideThenRoll", "C3 at 2 s, m.", slide_then_roll()),
        ("kRollingBall", "C19 at 1 s on 15 degrees, m.", 5 * G * mp.sin(slope) / 14),
        ("kRollingCylinder", "C19 at 1 s on 15 degrees, m.", G * mp.sin(slope) / 3),
        ("kRestTimes", "C5 for a restitution of 0.5, 0.8, 0.9, s.", [rest_time(e) for e in ("0.5", "0.8", "0.9")]),
        ("kTiltedBounce", "C5 on a slope, x and z from the first touch at 0.8 s, m.", tilted_bounce()),
        ("kFirstSphere", "C5 of two moving spheres at 0.5 s, m.", first),
        ("kSecondSphere", "The other one, m.", second),
    ]


def header() -> str:
    lines = ["// Written by references.py, which says what each number means and how it is computed.", "#pragma once",
             "#include <array>", "", "namespace genphys::bench::reference {", ""]
    for name, meaning, value in references():
        lines.append(f"/// {meaning}")
        if isinstance(value, list):
            head = f"inline constexpr std::array<double, {len(value)}> {name}{{"
            numbers = ", ".join(repr(float(number)) for number in value)
            lines.append(textwrap.fill(numbers + "};", 120, initial_indent=head, subsequent_indent=" " * len(head)))
        else:
            lines.append(f"inline constexpr double {name} = {float(value)!r};")
    return "\n".join([*lines, "", "}  // namespace genphys::bench::reference", ""])


def main(arguments: list[str]) -> int:
    if arguments == ["--check"]:
        if HEADER.is_file() and HEADER.read_text() == header():
            return 0
        print(f"{HEADER.name} is not what {pathlib.Path(__file__).name} computes: run it")
        return 1
    if arguments:
        print(__doc__, file=sys.stderr)
        return 2
    HEADER.write_text(header())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

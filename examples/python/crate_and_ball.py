#!/usr/bin/python3
"""A ball falls on the edge of a crate, is thrown aside, rolls over the floor, and comes to rest.

The program prints what happens and returns 0 only if it went as mechanics says it must.
"""

import argparse
import math
import pathlib
import sys

try:
    import genphys
except ModuleNotFoundError:
    # Run from a checkout that is not installed: the package stands beside the examples.
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "client" / "python"))
    import genphys

GRAVITY = 9.81  # m/s^2
STEP = 1 / 240  # s
STEPS_PER_LINE = 120
LONGEST = 30.0  # s of simulated time: the ball rolls for about ten

RADIUS = 0.5  # m, of the ball
HALF_EDGE = 0.5  # m, of the crate
BALL_X, BALL_Z = 0.7, 5.0  # m, where the ball is let go
ROLLING_DAMPING = 2.0  # 1/s, without it the ball would roll for ever

# The ball meets the edge, at x = 0.5 m and z = 1 m, when its centre is one radius away from it.
EDGE_X, EDGE_Z = HALF_EDGE, 2 * HALF_EDGE
MEETING_Z = EDGE_Z + math.sqrt(RADIUS**2 - (BALL_X - EDGE_X) ** 2)
MEETING_TIME = math.sqrt(2 * (BALL_Z - MEETING_Z) / GRAVITY)

REST_TOLERANCE = 1e-3  # m: engines let resting bodies overlap by less than this


def main() -> int:
    """Plays the scene and returns the exit code."""
    options = parse_arguments()
    server = genphys.connect(options.address) if options.address else genphys.launch()
    with server, server.create_world(engine=options.engine, gravity=(0, 0, -GRAVITY), step_size=STEP) as world:
        print(f"On the engine {world.info().engine}: a ball is let go above the edge of a crate.\n")
        return judge(*play(world))


def play(world: genphys.World) -> tuple[float, float, genphys.EntityInfo]:
    """Steps until the ball sleeps; returns when it first met the crate, when it fell asleep, and how it lies."""
    world.add_box(name="crate", half_extents=(HALF_EDGE,) * 3, mass=1.0, position=(0, 0, HALF_EDGE))
    ball = world.add_sphere(
        name="ball", radius=RADIUS, mass=1.0, position=(BALL_X, 0, BALL_Z), angular_damping=ROLLING_DAMPING
    )
    met = slept = math.nan
    time = 0.0
    while math.isnan(slept) and time < LONGEST:
        # One call: 120 steps, the state after the last, and everything that happened in between.
        frame = world.step(STEPS_PER_LINE)
        time = frame.time
        for event in frame.events:
            moment = event.step * STEP
            if isinstance(event, genphys.ContactBegan):
                print(f"{moment:7.3f} s   {event.entity_a} and {event.entity_b} touch")
                if math.isnan(met) and event.involves(ball) and event.entity_a.name == "crate":
                    met = moment
            elif isinstance(event, genphys.ContactEnded):
                print(f"{moment:7.3f} s   {event.entity_a} and {event.entity_b} part")
            elif isinstance(event, genphys.EntityWoke):
                print(f"{moment:7.3f} s   {event.entity} wakes up")
            elif isinstance(event, genphys.EntitySlept):
                print(f"{moment:7.3f} s   {event.entity} falls asleep")
                if event.involves(ball):
                    slept = moment
        x, _, z = frame.positions[frame.row(ball)]
        print(f"{time:7.3f} s       ball at x = {x:6.3f} m, z = {z:6.3f} m")
    return met, slept, world.entity(ball)


def judge(met: float, slept: float, ball: genphys.EntityInfo) -> int:
    """Compares what happened with what must happen."""
    x, _, z = ball.position
    print()
    verdicts = [
        (
            abs(met - MEETING_TIME) <= STEP,
            f"The ball met the crate at {met:.4f} s; free fall says {MEETING_TIME:.4f} s, and a step is {STEP:.4f} s.",
        ),
        (x > BALL_X, f"It left towards +x, away from the crate, and came as far as x = {x:.3f} m."),
        (
            abs(z - RADIUS) <= REST_TOLERANCE,
            f"It lies on the floor with its centre at z = {z:.5f} m; its radius is {RADIUS} m.",
        ),
        (not math.isnan(slept), f"It fell asleep at {slept:.3f} s."),
    ]
    for is_right, text in verdicts:
        print("as expected:  " if is_right else "NOT EXPECTED: ", text)
    return 0 if all(is_right for is_right, _ in verdicts) else 1


def parse_arguments() -> argparse.Namespace:
    """Reads the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--address", help="of a server that runs, as in 127.0.0.1:50051; default: start a private one")
    parser.add_argument("--engine", default="ode", help="physics engine of the world (default: %(default)s)")
    return parser.parse_args()


if __name__ == "__main__":
    try:
        sys.exit(main())
    except genphys.GenphysError as error:
        sys.exit(f"crate_and_ball: {error}")

#!/usr/bin/python3
"""A ragdoll of eleven bodies falls, lands, and comes to rest with every joint in one piece and within its range.

Shoulders, hips, neck and spine are ball joints with a cone and a range of twist; elbows and knees are hinges with
limits. All of it is in the public model. The program prints what happens and returns 0 only if it went as it must.
"""

import argparse
import dataclasses
import pathlib
import sys

import numpy as np

try:
    import genphys
except ModuleNotFoundError:
    # Run from a checkout that is not installed: the package stands beside the examples.
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "client" / "python"))
    import genphys

from genphys import joints

GRAVITY = 9.81  # m/s^2
STEP = 1 / 240  # s
SECOND = 240  # steps
LONGEST = 20  # s of simulated time
ROLLING = 0.01  # m: limbs are soft, and do not roll on for ever

DROP = 1.0  # m: how high the feet are let go
GAP_TOLERANCE = 5e-3  # m, between what a joint holds together
# rad, beyond a range: the edge of a cone is met to second order, (w h)^2 for a limb at 30 rad/s in half a step.
LIMIT_TOLERANCE = (30 * STEP / 2) ** 2

# One half turn about x points the z axis down, along what hangs.
DOWN = (0.0, 1.0, 0.0, 0.0)
# The z axis along y: elbows and knees turn about it.
SIDEWAYS = (np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0)


@dataclasses.dataclass(frozen=True)
class Bone:
    """A capsule along z, or a ball: its name, where it is, how long and thick, and what it weighs."""

    name: str
    position: tuple[float, float, float]
    half_length: float
    radius: float
    mass: float


@dataclasses.dataclass(frozen=True)
class Link:
    """A joint between two bones at a point of the standing figure."""

    upper: str
    lower: str
    place: tuple[float, float, float]
    kind: joints.Ball | joints.Hinge
    orientation: tuple[float, float, float, float] = DOWN


def figure() -> tuple[list[Bone], list[Link]]:
    """A person of 1.75 m, standing."""
    bones = [
        Bone("pelvis", (0, 0, 1.00), 0.06, 0.12, 12),
        Bone("chest", (0, 0, 1.32), 0.10, 0.14, 24),
        Bone("head", (0, 0, 1.66), 0.0, 0.10, 5),
    ]
    links = [
        Link("pelvis", "chest", (0, 0, 1.15), joints.Ball(swing_max=0.5, twist_lower=-0.5, twist_upper=0.5)),
        Link("chest", "head", (0, 0, 1.54), joints.Ball(swing_max=0.7, twist_lower=-1.0, twist_upper=1.0)),
    ]
    for side, name in ((1, "left"), (-1, "right")):
        shoulder, hip = 0.24 * side, 0.10 * side
        bones += [
            Bone(f"{name} arm", (0, shoulder, 1.28), 0.10, 0.05, 2.5),
            Bone(f"{name} forearm", (0, shoulder, 0.96), 0.10, 0.04, 1.8),
            Bone(f"{name} thigh", (0, hip, 0.68), 0.14, 0.07, 8.0),
            Bone(f"{name} shin", (0, hip, 0.24), 0.14, 0.05, 4.0),
        ]
        links += [
            Link("chest", f"{name} arm", (0, shoulder, 1.43), joints.Ball(swing_max=1.5, twist_lower=-1, twist_upper=1)),
            Link(f"{name} arm", f"{name} forearm", (0, shoulder, 1.12), joints.Hinge(lower=-2.4, upper=0.0), SIDEWAYS),
            Link("pelvis", f"{name} thigh", (0, hip, 0.90), joints.Ball(swing_max=1.2, twist_lower=-0.5, twist_upper=0.5)),
            Link(f"{name} thigh", f"{name} shin", (0, hip, 0.46), joints.Hinge(lower=0.0, upper=2.4), SIDEWAYS),
        ]
    return bones, links


def build(world: genphys.World) -> tuple[dict[str, genphys.Entity], list[tuple[Link, genphys.joints.Joint]]]:
    """Puts the figure above the floor, leaning a little, in one call."""
    bones, links = figure()
    with world.batch() as batch:
        bodies = {}
        for bone in bones:
            position = np.add(bone.position, (0, 0, DROP))
            options = {"name": bone.name, "position": position, "mass": bone.mass, "friction": 0.8}
            options["linear_velocity"] = (0.5 * bone.position[2], 0.1, 0)
            if bone.half_length > 0:
                bodies[bone.name] = batch.add_capsule(radius=bone.radius, half_length=bone.half_length, **options)
            else:
                bodies[bone.name] = batch.add_sphere(radius=bone.radius, **options)
        places = {bone.name: np.array(bone.position) for bone in bones}
        made = [
            (
                link,
                batch.join(
                    bodies[link.upper],
                    bodies[link.lower],
                    link.kind,
                    frame_in_a=(np.subtract(link.place, places[link.upper]), link.orientation),
                    frame_in_b=(np.subtract(link.place, places[link.lower]), link.orientation),
                ),
            )
            for link in links
        ]
    world.step(0)
    return bodies, made


def rotated(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The vector `v` turned by the quaternion `q`."""
    w, xyz = q[0], np.asarray(q[1:])
    return v + 2 * np.cross(xyz, np.cross(xyz, v) + w * v)


def largest_gap(frame: genphys.Frame, bodies: dict[str, genphys.Entity], links: list[Link]) -> float:
    """How far the two sides of a joint are apart at most, metres."""
    places = {bone.name: np.array(bone.position) for bone in figure()[0]}

    def point(name: str, place: tuple[float, float, float]) -> np.ndarray:
        row = frame.row(bodies[name])
        return frame.positions[row] + rotated(frame.orientations[row], np.subtract(place, places[name]))

    return max(float(np.linalg.norm(point(link.upper, link.place) - point(link.lower, link.place))) for link in links)


def beyond_range(link: Link, position: np.ndarray) -> float:
    """By how much a joint is beyond its range, radians."""
    kind = link.kind
    if isinstance(kind, joints.Hinge):
        return max(kind.lower - position[5], position[5] - kind.upper, 0.0)
    return max(position[3] - kind.swing_max, kind.twist_lower - position[5], position[5] - kind.twist_upper, 0.0)


def main() -> int:
    """Plays the fall and returns the exit code."""
    options = parse_arguments()
    server = genphys.connect(options.address) if options.address else genphys.launch()
    with server, server.create_world(
        engine=options.engine,
        gravity=(0, 0, -GRAVITY),
        step_size=STEP,
        rolling_friction=ROLLING,
    ) as world:
        bodies, made = build(world)
        print(f"On the engine {world.info().engine}: {len(bodies)} bodies and {len(made)} joints are let go.\n")
        return judge(*fall(world, bodies, made))


def fall(world, bodies, made) -> tuple[float, float, float, bool]:
    """Steps until all sleep; returns the widest gap, the widest turn beyond a range, the height of the head, and
    whether they sleep."""
    links = [link for link, _ in made]
    by_id = {joint.id: link for link, joint in made}
    gap = beyond = 0.0
    wanted = genphys.FrameRequest(joints=True)
    for tick in range(LONGEST * 10):
        frame = world.step(SECOND // 10, frame=wanted)
        gap = max(gap, largest_gap(frame, bodies, links))
        for joint, position in zip(frame.joint_ids.tolist(), frame.joint_positions):
            beyond = max(beyond, beyond_range(by_id[joint], position))
        head = float(frame.positions[frame.row(bodies["head"])][2])
        if tick % 10 == 9:
            print(f"{frame.time:6.2f} s   head at {head:.2f} m")
        if all(frame.asleep[frame.row(body)] for body in bodies.values()):
            print(f"{frame.time:6.2f} s   all are asleep")
            return gap, beyond, head, True
    return gap, beyond, head, False


def judge(gap: float, beyond: float, head: float, asleep: bool) -> int:
    """Compares what happened with what must happen."""
    print()
    verdicts = [
        (gap <= GAP_TOLERANCE, f"Its joints held together within {gap * 1000:.2f} mm."),
        (beyond <= LIMIT_TOLERANCE, f"No joint went beyond its range by more than {beyond:.4f} rad."),
        (0.05 <= head <= 0.8, f"Its head lies {head:.2f} m above the floor."),
        (asleep, "It came to rest."),
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
        sys.exit(f"ragdoll: {error}")

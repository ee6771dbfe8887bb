#!/usr/bin/python3
"""A car of a chassis and four wheel joints stands on its springs, drives off, takes a bend, and brakes.

Everything about it is in the public model: wheel joints with suspension, steering and a driven spin, and friction
between wheels and floor. The program prints what happens and returns 0 only if it went as mechanics says it must.
"""

import argparse
import math
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
STEP = 1 / 120  # s
SECOND = 120  # steps

CHASSIS_MASS, WHEEL_MASS = 800.0, 20.0  # kg
WHEEL_RADIUS, WHEEL_HALF_WIDTH = 0.35, 0.1  # m
WHEEL_BASE, TRACK = 2.5, 1.5  # m, between the axles and between the wheels of one
HEIGHT = 0.9  # m, of the chassis above the floor
STIFFNESS, DAMPING = 40_000.0, 4_000.0  # N/m and N*s/m, of each spring
SPEED = 8.0  # m/s, at which the motors aim
TORQUE = 400.0  # N*m, of each driven wheel
STEERING = 0.15  # rad

SAG = CHASSIS_MASS * GRAVITY / 4 / STIFFNESS
SAG_TOLERANCE = 2e-3  # m: wheels may sink that far into the floor
BEND_RADIUS = WHEEL_BASE / math.tan(STEERING)
BEND_TOLERANCE = 0.1  # of the radius: tyres slip a little, and the law is that of wheels which do not


class Car:
    """A chassis with four wheels: two in front that steer, two behind that drive."""

    def __init__(self, world: genphys.World) -> None:
        self.world = world
        with world.batch() as batch:
            self.chassis = batch.add_box(
                name="chassis", half_extents=(1.7, 0.6, 0.25), mass=CHASSIS_MASS, position=(0, 0, HEIGHT)
            )
            # A cylinder's axis is its z, and a wheel spins about y.
            lying = (math.sqrt(0.5), math.sqrt(0.5), 0, 0)
            self.wheels = []
            self.joints = []
            for x, y, steers in self.places():
                wheel = batch.add_entity(
                    name="wheel",
                    position=(x, y, WHEEL_RADIUS),
                    mass=WHEEL_MASS,
                    geometries=[
                        genphys.Geometry(
                            shape=genphys.Cylinder(WHEEL_RADIUS, WHEEL_HALF_WIDTH), orientation=lying, friction=1.0
                        )
                    ],
                )
                kind = self.kind(steers, 0.0, 0.0)
                self.wheels.append(wheel)
                self.joints.append(batch.join(self.chassis, wheel, kind, frame_in_a=(x, y, WHEEL_RADIUS - HEIGHT)))
        world.step(0)

    @staticmethod
    def places() -> list[tuple[float, float, bool]]:
        """Where the wheels are under the chassis, and which of them steer."""
        return [(x * WHEEL_BASE / 2, y * TRACK / 2, x > 0) for x in (1, -1) for y in (1, -1)]

    @staticmethod
    def kind(steers: bool, steering: float, speed: float) -> joints.Wheel:
        """A wheel whose spring carries the car as it stands in the drawing, plus the sag."""
        drive = joints.Motor(velocity=speed / WHEEL_RADIUS, force_max=TORQUE)
        turn = joints.Motor(position=steering, stiffness=20_000.0, damping=2_000.0)
        return joints.Wheel(
            suspension=joints.Axis(lower=-0.2, upper=0.2, spring=joints.Spring(stiffness=STIFFNESS, damping=DAMPING)),
            steering=joints.Axis(motor=turn) if steers else None,
            spin=joints.Axis() if steers else joints.Axis(motor=drive),
        )

    def command(self, steering: float, speed: float) -> None:
        """Turns the front wheels and lets the rear ones aim at a speed."""
        with self.world.batch() as batch:
            for joint, (_, _, steers) in zip(self.joints, self.places()):
                batch.change_joint(joint, self.kind(steers, steering, speed))

    def step(self, steps: int) -> genphys.StepResult:
        """One call to the server."""
        return self.world.step(steps, frame=genphys.FrameRequest(poses=True, velocities=True, joints=True))


def main() -> int:
    """Plays the drive and returns the exit code."""
    options = parse_arguments()
    server = genphys.connect(options.address) if options.address else genphys.launch()
    with server, server.create_world(engine=options.engine, gravity=(0, 0, -GRAVITY), step_size=STEP) as world:
        print(f"On the engine {world.info().engine}: a car of {CHASSIS_MASS:g} kg on four wheel joints.\n")
        return judge(drive(Car(world)))


def drive(car: Car) -> list[tuple[bool, str]]:
    """Stands, drives, bends, brakes; returns what was expected and whether it came."""
    verdicts = []

    frame = car.step(3 * SECOND)
    sag = float(np.mean(frame.joint_positions[:, 2]))
    verdicts.append(
        (
            abs(sag - SAG) <= SAG_TOLERANCE,
            f"Its springs give way by {sag * 1000:.1f} mm; weight over stiffness says {SAG * 1000:.1f} mm.",
        )
    )

    car.command(0.0, SPEED)
    frame = car.step(6 * SECOND)
    row = frame.row(car.chassis)
    speed = float(frame.linear_velocities[row, 0])
    verdicts.append((abs(speed - SPEED) <= 0.02 * SPEED, f"It drives at {speed:.2f} m/s; its motors aim at {SPEED}."))
    drift = abs(float(frame.positions[row, 1]))
    verdicts.append((drift <= 0.1, f"In {frame.positions[row, 0]:.1f} m it has left the straight line by {drift:.3f} m."))

    car.command(STEERING, SPEED)
    car.step(2 * SECOND)
    frame = car.step(1)
    row = frame.row(car.chassis)
    speed = float(np.hypot(*frame.linear_velocities[row, :2]))
    turning = float(frame.angular_velocities[row, 2])
    radius = speed / turning if turning else math.inf
    verdicts.append(
        (
            abs(radius - BEND_RADIUS) <= BEND_TOLERANCE * BEND_RADIUS,
            f"With its wheels at {STEERING} rad it goes round a circle of {radius:.2f} m; "
            f"wheels that do not slip would go round one of {BEND_RADIUS:.2f} m.",
        )
    )

    car.command(0.0, 0.0)
    frame = car.step(6 * SECOND)
    speed = float(np.linalg.norm(frame.linear_velocities[frame.row(car.chassis)]))
    verdicts.append((speed <= 0.05, f"It brakes to {speed:.3f} m/s."))
    tilt = float(np.abs(frame.orientations[frame.row(car.chassis)][1:3]).max())
    verdicts.append((tilt <= 0.02, "It stands upright."))
    return verdicts


def judge(verdicts: list[tuple[bool, str]]) -> int:
    """Prints what happened beside what must happen."""
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
        sys.exit(f"car: {error}")

// Resistance to rolling that turns within a substep: of what rolls up a slope and back, of what stops, and of what is
// pushed across the way that it rolls. Where it turns is not to be seen, whatever part of a substep is left then.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(RollingBack, Claim::kRollingFriction, Claim::kContacts, Claim::kPlane);

constexpr double kGravity = 9.81, kSlope = 0.3, kRadius = 0.2;

/// What rolls over a slope, down which points x. `inertia`: its moment over m r^2.
struct Roller {
  Shape shape;
  double inertia;

  static Roller Ball() { return {Sphere{kRadius}, 0.4}; }
  static Roller Wheel() { return {Cylinder{kRadius, 0.1}, 0.5}; }

  EntityDesc Thrown(const Vector3& velocity) const {
    EntityDesc body = Body(shape, {0, 0, kRadius}, 2);
    if (!std::holds_alternative<Sphere>(shape)) {
      body.pose.orientation = Quaternion(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()));
    }
    body.rigid_body->linear_velocity = velocity;
    body.rigid_body->angular_velocity = Vector3::UnitZ().cross(velocity) / kRadius;
    return body;
  }
};

/// `part`: of the resistance that would hold what lies there.
struct Slope {
  double part;
  double moved;  // of a push at its centre, what is left for what has to turn as well

  Slope(double of_holding, const Roller& roller) : part(of_holding), moved(1 / (1 + roller.inertia)) {}

  double pull() const { return moved * kGravity * std::sin(kSlope); }
  double brake() const { return part * pull(); }
  /// m/s^2, by which the velocity jumps where it turns, and is braked until then.
  double most() const { return pull() + brake(); }
};

std::unique_ptr<World> WorldOf(const std::string& engine, int rate, double part, Solver solver = Solver::kAutomatic) {
  WorldDesc desc{.engine = engine,
                 .gravity = {kGravity * std::sin(kSlope), 0, -kGravity * std::cos(kSlope)},
                 .stepper = {.step_size = 1.0 / rate, .solver = solver}};
  desc.default_material.friction = 2;
  desc.default_material.rolling_friction = part * kRadius * std::tan(kSlope);
  desc.default_auto_disable.enabled = false;
  return MakeWorld(desc);
}

struct Course {
  double way = 0, speed = 0;  // down the slope
};

/// Of what is thrown straight up.
Course ThrownUp(const Slope& slope, double speed, double time) {
  const double turned = speed / slope.most(), left = std::max(time - turned, 0.0);
  if (time < turned) return {-speed * time + slope.most() * time * time / 2, -speed + slope.most() * time};
  const double up = -speed * speed / slope.most() / 2, gain = std::max(slope.pull() - slope.brake(), 0.0);
  return {up + gain * left * left / 2, gain * left};
}

// Braked one way for the whole substep it would be off by up to two thirds of most() * h from there on.
TEST_P(RollingBack, UpASlopeAndDownAgain) {
  Proves({Claim::kSphere});
  for (const double part : {0.5, 0.9}) {
    const Roller ball = Roller::Ball();
    const Slope slope(part, ball);
    for (const int rate : {60, 240}) {
      for (int i = 0; i < 12; ++i) {
        const double speed = 0.3 + 0.0137 * i, time = std::ceil(2 * speed / slope.most() * rate) / rate;
        const auto world = WorldOf(GetParam(), rate, part);
        const EntityId id = Add(*world, ball.Thrown({-speed, 0, 0}));
        Steps(*world, static_cast<int>(std::lround(time * rate)));
        const Course course = ThrownUp(slope, speed, time);
        const double off = 2e-3 * slope.most() * SubstepOf(*world);
        EXPECT_NEAR(PositionOf(*world, id).x(), course.way, off * time) << speed << " m/s at " << rate;
        EXPECT_NEAR(VelocityOf(*world, id).x(), course.speed, off) << speed << " m/s at " << rate;
        EXPECT_NEAR(SpinOf(*world, id).y() * kRadius, course.speed, off) << speed << " m/s at " << rate;
      }
    }
  }
}

TEST_P(RollingBack, AWheelToo) {
  Proves({Claim::kCylinder});
  const Roller wheel = Roller::Wheel();
  const Slope slope(0.5, wheel);
  for (int i = 0; i < 12; ++i) {
    constexpr int kRate = 60;
    const double speed = 0.3 + 0.0137 * i, time = 0.5;
    const auto world = WorldOf(GetParam(), kRate, slope.part);
    const EntityId id = Add(*world, wheel.Thrown({-speed, 0, 0}));
    Steps(*world, static_cast<int>(std::lround(time * kRate)));
    const Course course = ThrownUp(slope, speed, time);
    const double off = 2e-3 * slope.most() * SubstepOf(*world);
    EXPECT_NEAR(PositionOf(*world, id).x(), course.way, off * time) << speed;
    EXPECT_NEAR(VelocityOf(*world, id).x(), course.speed, off) << speed;
  }
}

// What stops has gone the way until then. That at the velocity of the middle of the substep would be off by an eighth
// of most() * h * h.
TEST_P(RollingBack, StopsWhereItStops) {
  Proves({Claim::kSphere});
  const Roller ball = Roller::Ball();
  for (const double part : {1.1, 2.0}) {
    const Slope slope(part, ball);
    for (const int rate : {60, 240}) {
      for (int i = 0; i < 12; ++i) {
        const double speed = 0.3 + 0.0137 * i;
        const auto world = WorldOf(GetParam(), rate, part);
        const EntityId id = Add(*world, ball.Thrown({-speed, 0, 0}));
        Steps(*world, static_cast<int>(std::ceil((speed / slope.most() + 0.05) * rate)));
        const double way = ThrownUp(slope, speed, 10).way;
        EXPECT_NEAR(PositionOf(*world, id).x(), way, 1e-5 * -way) << speed << " m/s at " << rate;
        EXPECT_LE(VelocityOf(*world, id).norm(), 1e-6) << speed << " m/s at " << rate;
      }
    }
  }
}

/// Where what is thrown askew is, integrated in steps that become as short as it is slow.
Eigen::Vector2d Askew(const Slope& slope, Eigen::Vector2d velocity, double time) {
  Eigen::Vector2d way = Eigen::Vector2d::Zero();
  while (time > 0 && velocity.norm() > 1e-9) {
    const double h = std::min({time, 1e-4, 2e-3 * velocity.norm() / slope.most()});
    const auto change = [&](const Eigen::Vector2d& at) -> Eigen::Vector2d {
      return Eigen::Vector2d(slope.pull(), 0) - slope.brake() * at.normalized();
    };
    const Eigen::Vector2d middle = velocity + h / 2 * change(velocity);
    const Eigen::Vector2d end = velocity + h * change(middle);
    way += h * middle;
    velocity = end;
    time -= h;
  }
  return way;
}

void ExpectAskew(const std::string& engine, Solver solver) {
  const Roller ball = Roller::Ball();
  for (const double part : {0.5, 1.5}) {
    const Slope slope(part, ball);
    for (const double heading : {1.75, 2.36}) {
      for (const int rate : {60, 240}) {
        for (int i = 0; i < 6; ++i) {
          const double speed = 0.5 + 0.0237 * i, time = 0.4;
          const Eigen::Vector2d velocity = speed * Eigen::Vector2d(std::cos(heading), std::sin(heading));
          const auto world = WorldOf(engine, rate, part, solver);
          const EntityId id = Add(*world, ball.Thrown({velocity.x(), velocity.y(), 0}));
          Steps(*world, static_cast<int>(std::lround(time * rate)));
          const Eigen::Vector2d error = PositionOf(*world, id).head<2>() - Askew(slope, velocity, time);
          // Of first order: 3e-3 m at 60 steps, 9e-4 at 240.
          EXPECT_LE(error.norm(), 0.5 * slope.brake() * std::pow(SubstepOf(*world), 2))
              << part << ", heading " << heading << ", " << speed << " m/s at " << rate;
        }
      }
    }
  }
}

TEST_P(RollingBack, WhatIsPushedAcrossTheWayItRollsIsOfSecondOrder) {
  Proves({Claim::kSphere});
  ExpectAskew(GetParam(), Solver::kAutomatic);
}

TEST_P(RollingBack, AndSoItIsIfAllIsSolvedAtOnce) {
  Proves({Claim::kSphere, Claim::kSolverDirect});
  ExpectAskew(GetParam(), Solver::kDirect);
}

// It goes on one way and turns the other, so that its spin turns while it slips.
TEST_P(RollingBack, ASpinTurnsWhileItSlips) {
  Proves({Claim::kSphere, Claim::kKineticFriction});
  constexpr double kSpin = 4, kFriction = 0.2, kArm = 0.02, kTime = 0.4, kInertia = 0.4 * kRadius * kRadius;
  for (const int rate : {60, 240}) {
    for (int i = 0; i < 12; ++i) {
      const double speed = 3 + 0.037 * i;
      WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -kGravity}, .stepper = {.step_size = 1.0 / rate}};
      desc.default_material = {.friction = kFriction, .rolling_friction = kArm};
      desc.default_auto_disable.enabled = false;
      const auto world = testing::MakeWorld(desc);
      EntityDesc ball = Roller::Ball().Thrown({speed, 0, 0});
      ball.rigid_body->angular_velocity = {0, -kSpin, 0};
      const EntityId id = Add(*world, ball);
      Steps(*world, static_cast<int>(std::lround(kTime * rate)));
      // N*m per kg
      const double rubbing = kFriction * kGravity * kRadius, resisting = kArm * kGravity;
      const double turned = kSpin * kInertia / (rubbing + resisting);
      const double spin = (kTime - turned) * (rubbing - resisting) / kInertia;
      // Braked one way for the whole substep it would be off by up to two thirds of what resists for as long.
      const double off = 0.02 * resisting / kInertia * SubstepOf(*world);
      EXPECT_NEAR(SpinOf(*world, id).y(), spin, off) << speed << " m/s at " << rate;
      EXPECT_NEAR(VelocityOf(*world, id).x(), speed - kFriction * kGravity * kTime, 1e-6) << speed;
    }
  }
}

}  // namespace
}  // namespace genphys::testing

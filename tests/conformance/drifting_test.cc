// What is pushed and not held against that does not fall asleep, however slow it still is.
#include <cmath>
#include <numbers>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Drifting, Claim::kSleeping);

constexpr double kSeconds = 10;
// Of where it should be by then.
constexpr double kOff = 2e-3;

std::unique_ptr<World> FloorOf(const std::string& engine, int rate, double friction) {
  WorldDesc desc{.engine = engine, .stepper = {.step_size = 1.0 / rate}};
  desc.default_material.friction = friction;
  return testing::MakeWorld(desc);
}

// Without a floor; who is slow may fall asleep.
std::unique_ptr<World> SpaceOf(const std::string& engine, int rate, const Vector3& gravity) {
  return testing::MakeWorld(
      WorldDesc{.engine = engine, .gravity = gravity, .stepper = {.step_size = 1.0 / rate}, .ground_plane = false});
}

void GoOn(World& world, int rate) { Steps(world, static_cast<int>(kSeconds * rate)); }

TEST_P(Drifting, OnIceGoesOnUnderAnyForce) {
  Proves({Claim::kForce});
  for (const int rate : {60, 240}) {
    for (const double force : {0.01, 0.03, 0.05}) {
      SCOPED_TRACE(::testing::Message() << force << " N, " << rate << " steps/s");
      const auto world = FloorOf(GetParam(), rate, 0);
      EntityDesc puck = Crate({0, 0, 0.1}, 0.1);
      puck.rigid_body->geometries[0].material.friction = 0;
      const EntityId id = Add(*world, puck);
      Do(*world, ApplyForce{.id = id, .force = {force, 0, 0}, .steps = static_cast<uint32_t>(kSeconds * rate)});
      GoOn(*world, rate);
      const double way = force / 2 * kSeconds * kSeconds;
      EXPECT_NEAR(PositionOf(*world, id).x(), way, kOff * way);
    }
  }
}

// 5 or 20 m long: at no time it is as fast as who rests may be, and at its turning points it stands.
TEST_P(Drifting, PendulumsSwingOn) {
  Proves({Claim::kJointBall});
  for (const double length : {5.0, 20.0}) {
    constexpr double kAngle = 0.003, kGravity = 9.81;
    const auto world = SpaceOf(GetParam(), 240, {0, 0, -kGravity});
    const Vector3 place = length * Vector3(std::sin(kAngle), 0, -std::cos(kAngle));
    const EntityId ball = Add(*world, Ball(place, 0.1));
    Join(*world, ToWorld(ball, BallJoint{}, Pose{Vector3::Zero(), {1, 0, 0, 0}}));
    const double inertia = length * length + 0.4 * 0.1 * 0.1;
    for (int second = 1; second <= 10; ++second) {
      Steps(*world, 240);
      const double x = place.x() * std::cos(second * std::sqrt(kGravity * length / inertia));
      EXPECT_NEAR(PositionOf(*world, ball).x(), x, 0.01 * place.x()) << length << " m after " << second << " s";
      EXPECT_FALSE(Asleep(*world, ball));
    }
  }
}

TEST_P(Drifting, ADoorThatHardlyLeansSwingsOpen) {
  Proves({Claim::kJointHinge});
  constexpr double kLean = 0.2 * std::numbers::pi / 180, kGravity = 9.81, kWidth = 0.45, kStart = 0.5;
  const auto world = SpaceOf(GetParam(), 60, kGravity * Vector3(std::sin(kLean), 0, -std::cos(kLean)));
  // Open by half a radian from where it would hang.
  const Quaternion turn(Eigen::AngleAxisd(kStart, Vector3::UnitZ()));
  EntityDesc door = Body(Box{{kWidth, 0.02, 1}}, turn * Vector3(kWidth, 0, 0), 20);
  door.pose.orientation = turn;
  const EntityId id = Add(*world, door);
  Join(*world, ToWorld(id, HingeJoint{}, Pose{Vector3::Zero(), {1, 0, 0, 0}}));
  double least = kStart;
  for (int i = 0; i < 60 * 20; ++i) {
    Steps(*world, 1);
    const Vector3 at = PositionOf(*world, id);
    least = std::min(least, std::atan2(at.y(), at.x()));
  }
  EXPECT_LT(least, -0.9 * kStart) << "it swings to the other side";
}

// What only trembles or stops falls asleep as before.
TEST_P(Drifting, WhatFrictionStopsFallsAsleepHalfASecondAfter) {
  Proves({Claim::kKineticFriction});
  const auto world = FloorOf(GetParam(), 60, 0.5);
  EntityDesc box = Crate({0, 0, 0.1}, 0.1);
  box.rigid_body->linear_velocity = {0.5, 0, 0};
  const EntityId id = Add(*world, box);
  Steps(*world, 60);
  EXPECT_TRUE(Asleep(*world, id));
}

}  // namespace
}  // namespace genphys::testing

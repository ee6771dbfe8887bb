// What the floor holds while it goes hits what stands in its way when it gets there, and as hard as what flies.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ImpactsOfHeld, Claim::kContacts, Claim::kRestitution);

constexpr double kGravity = 9.81;
constexpr double kRadius = 0.3;
constexpr double kStart = 0.33;
constexpr double kWall = 2;

std::unique_ptr<World> MakeLane(const std::string& engine, double friction, double restitution,
                                double step = 1.0 / 60) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}};
  desc.stepper.step_size = step;
  desc.default_material.friction = friction;
  desc.default_auto_disable.enabled = false;
  auto world = MakeWorld(desc);
  EntityDesc wall = Block({kWall + 0.2, 0, 1}, {0.2, 5, 1});
  wall.rigid_body->geometries[0].material.friction = 0;
  wall.rigid_body->geometries[0].material.restitution = restitution;
  Add(*world, wall);
  return world;
}

EntityDesc Going(const Shape& shape, double speed, double restitution) {
  EntityDesc body = Body(shape, {kStart, 0.2, kRadius});
  body.rigid_body->geometries[0].material.restitution = restitution;
  body.rigid_body->linear_velocity = {speed, 0, 0};
  return body;
}

// Steps until the body is back or has stood at the wall for a while; how far it was in it at most.
double DeepestIn(World& world, EntityId id, double step) {
  double deepest = -1;
  for (int i = 0; i < std::lround(2.5 / step); ++i) {
    Steps(world, 1);
    deepest = std::max(deepest, PositionOf(world, id).x() + kRadius - kWall);
    if (VelocityOf(world, id).x() < 0 && PositionOf(world, id).x() < kStart) break;
  }
  return deepest;
}

TEST_P(ImpactsOfHeld, HappenWhereTheWallIs) {
  const std::vector<Shape> shapes{Sphere{kRadius}, Box{Vector3::Constant(kRadius)}, Cylinder{kRadius, kRadius},
                                  HullBox(Vector3::Constant(kRadius))};
  for (const Shape& shape : shapes) {
    for (const double restitution : {0.0, 0.5}) {
      for (const double speed : {1.0, 4.3, 12.0, 47.0}) {
        for (const double step : {1.0 / 60, 1.0 / 240}) {
          const auto world = MakeLane(GetParam(), 0, restitution, step);
          const EntityId id = Add(*world, Going(shape, speed, restitution));

          const double deepest = DeepestIn(*world, id, step);

          SCOPED_TRACE(::testing::Message()
                       << shape.index() << ", e " << restitution << ", " << speed << " m/s, " << step);
          EXPECT_LE(deepest, 2 * ImpactDepth(speed, SubstepOf(*world)));
          EXPECT_NEAR(VelocityOf(*world, id).x(), -restitution * speed, kDirect * speed);
        }
      }
    }
  }
}

TEST_P(ImpactsOfHeld, LeaveNothingBehindThatDriftsAway) {
  constexpr double kSpeed = 7.7;
  const auto world = MakeLane(GetParam(), 0, 0);
  const EntityId id = Add(*world, Going(Box{Vector3::Constant(kRadius)}, kSpeed, 0));
  Steps(*world, 300);

  EXPECT_NEAR(PositionOf(*world, id).x(), kWall - kRadius, 2 * ImpactDepth(kSpeed, SubstepOf(*world)));
  EXPECT_LE(VelocityOf(*world, id).norm(), kDirect * kSpeed);
}

TEST_P(ImpactsOfHeld, StopABallThatRolls) {
  for (const double speed : {1.0, 4.3}) {
    const auto world = MakeLane(GetParam(), 0.5, 0);
    EntityDesc ball = Going(Sphere{kRadius}, speed, 0);
    ball.rigid_body->angular_velocity = {0, speed / kRadius, 0};
    const EntityId id = Add(*world, ball);

    EXPECT_LE(DeepestIn(*world, id, 1.0 / 60), 2 * ImpactDepth(speed, SubstepOf(*world))) << speed;
    // It still spins against a wall without friction, and the floor drives it on against that.
    EXPECT_NEAR(PositionOf(*world, id).x(), kWall - kRadius, kTouch) << speed;
  }
}

TEST_P(ImpactsOfHeld, PassMomentumToWhatStandsInTheWay) {
  for (const double restitution : {0.0, 0.5}) {
    const auto world = MakeLane(GetParam(), 0, 0);
    const EntityId first = Add(*world, Going(Box{Vector3::Constant(kRadius)}, 6, restitution));
    EntityDesc second = Going(Box{Vector3::Constant(kRadius)}, 0, restitution);
    second.pose.position.x() = 1.13;
    const EntityId other = Add(*world, second);
    Steps(*world, 5);

    const double a = VelocityOf(*world, first).x(), b = VelocityOf(*world, other).x();
    EXPECT_NEAR(a + b, 6, kDirect * 6) << restitution;
    EXPECT_NEAR(b - a, restitution * 6, kDirect * 6) << restitution;
  }
}

}  // namespace
}  // namespace genphys::testing

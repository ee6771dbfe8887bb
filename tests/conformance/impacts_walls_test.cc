// Nothing passes through a wall, whatever else hits that in the same step.
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "conformance/engine_test.h"
#include "genphys/placement.h"
#include "support/joints.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ImpactsOnWalls, Claim::kContacts, Claim::kBox);

constexpr double kStep = 1.0 / 60;
constexpr double kHalf = 0.005;  // m, of the thickness of a wall
constexpr double kRadius = 0.03;
constexpr double kSpeed = 20;
constexpr std::array kFast = {20.0, 100.0, 300.0};

EntityDesc Dull(EntityDesc desc, double friction) {
  desc.rigid_body->geometries[0].material.restitution = 0;
  desc.rigid_body->geometries[0].material.friction = friction;
  return desc;
}

// About the origin, across x.
EntityDesc Wall(double friction) { return Dull(Body(Box{{kHalf, 3, 3}}, Vector3::Zero(), 500), friction); }

EntityDesc TurningWall(double friction) {
  EntityDesc wall = Wall(friction);
  wall.rigid_body->motion_type = MotionType::kKinematic;
  wall.rigid_body->angular_velocity = {0, 0.1, 0.2};
  return wall;
}

// In the frame of the wall.
Vector3 PlaceAt(const World& world, EntityId wall, EntityId body) {
  return ToPlacement(world.state().pose(EntityRow{wall.index()})).ToLocal(PositionOf(world, body));
}

// One ball lies at the wall, another one hits it aslant and stays between the two, and rolls there a trifle each time
// that it is looked at. Two metres from there a third one comes in the same step.
TEST_P(ImpactsOnWalls, AreNotMissedWhereSomebodyIsPinnedElsewhere) {
  Proves({Claim::kSphere, Claim::kKinematicPush});
  for (const double step : {1.0 / 60, 1.0 / 120}) {
    for (int i = 0; i < 8; ++i) {
      SCOPED_TRACE(i);
      const double aside = 0.002 + 0.007 * i, along = -kHalf - kRadius;
      const auto world = MakeSpace(GetParam(), {.step_size = step}, Vector3::Zero());
      Require(*world, Feature::kContacts);
      const EntityId wall = Add(*world, TurningWall(0));
      const EntityId lying = Add(*world, Dull(Ball({along, 0, 0}, kRadius, 0.1), 0));
      const auto flying = [&](double x, double y) {
        EntityDesc ball = Dull(Ball({x, y, 0}, kRadius, 0.1), 0);
        ball.rigid_body->linear_velocity = {kSpeed, 0, 0};
        return Add(*world, ball);
      };
      const double gap = std::sqrt(4 * kRadius * kRadius - aside * aside);
      const EntityId pinned = flying(along - gap - 1.05 * kSpeed * step, aside);
      const EntityId last = flying(along - 1.9 * kSpeed * step, 2);
      Steps(*world, 4);
      for (const EntityId id : {lying, pinned, last}) EXPECT_LT(PlaceAt(*world, wall, id).x(), -kRadius);
    }
  }
}

// More often in a substep than impacts are looked for in one.
TEST_P(ImpactsOnWalls, HoldABallThatFliesToAndFroBetweenTwo) {
  Proves({Claim::kSphere, Claim::kRestitution});
  for (const double turn : {0.0, 0.2}) {
    SCOPED_TRACE(turn);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
    const auto bouncy = [](EntityDesc desc) {
      desc.rigid_body->geometries[0].material.restitution = 1;
      return desc;
    };
    for (const double side : {-0.1, 0.1}) {
      EntityDesc wall = bouncy(TurningWall(0));
      wall.pose.position.x() = side;
      wall.rigid_body->angular_velocity = {turn, 0, 0};
      Add(*world, wall);
    }
    EntityDesc ball = bouncy(Dull(Ball(Vector3::Zero(), kRadius, 0.1), 0));
    ball.rigid_body->linear_velocity = {1500, 0, 0};
    const EntityId id = Add(*world, ball);
    for (int i = 0; i < 20; ++i) {
      Steps(*world, 1);
      EXPECT_LT(std::abs(PositionOf(*world, id).x()), 0.1 - kRadius);
      EXPECT_NEAR(VelocityOf(*world, id).norm(), 1500, 1e-6);
    }
  }
}

// Of several shapes, that meet the wall alone and not each other.
std::vector<EntityId> ThrowMany(World& world, Random& random, int count, std::span<const double> speeds) {
  const std::vector<Shape> shapes = {Sphere{kRadius}, Box{{0.03, 0.05, 0.02}}, Capsule{0.02, 0.15},
                                     Cylinder{0.04, 0.03}, Box{{0.004, 0.06, 0.08}}};
  std::vector<EntityId> thrown;
  for (int i = 0; i < count; ++i) {
    const double speed = speeds[static_cast<size_t>(i) % speeds.size()];
    EntityDesc body = Dull(Body(shapes[static_cast<size_t>(i) % shapes.size()], Vector3::Zero()), 0.3);
    body.rigid_body->geometries[0].category_bits = 2;
    body.rigid_body->geometries[0].collides_with_bits = 1;
    const Vector3 velocity = speed * Vector3(1, random.Uniform(-0.2, 0.2), random.Uniform(-0.2, 0.2));
    const Vector3 aim(-0.4, random.Uniform(-1.5, 1.5), random.Uniform(-1.5, 1.5));
    body.pose = {aim - random.Uniform(0.3, 2.5) * kStep * velocity, random.Turn()};
    body.rigid_body->linear_velocity = velocity;
    body.rigid_body->angular_velocity = random.Vector(random.Chance(0.5) ? 10.0 : 80.0);
    thrown.push_back(Add(world, body));
  }
  return thrown;
}

// Each is looked at until it leaves the wall for good.
void ExpectNobodyBehind(World& world, EntityId wall, const std::vector<EntityId>& thrown) {
  Require(world, Feature::kContacts);
  for (int i = 0; i < 8; ++i) {
    Steps(world, 1);
    for (const EntityId id : thrown) {
      const Vector3 place = PlaceAt(world, wall, id);
      const bool is_beside = std::abs(place.y()) > 2.8 || std::abs(place.z()) > 2.8;
      EXPECT_TRUE(is_beside || place.x() < 0.02) << id.index() << " at " << place.transpose();
    }
  }
}

TEST_P(ImpactsOnWalls, HoldManyOffAWallThatFlies) {
  for (uint64_t seed = 1; seed <= 16; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
    const EntityId wall = Add(*world, Wall(0.3));
    ExpectNobodyBehind(*world, wall, ThrowMany(*world, random, 16, std::span(kFast).first(1)));
  }
}

TEST_P(ImpactsOnWalls, HoldManyOffADoor) {
  Proves({Claim::kJointHinge});
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
    const EntityId wall = Add(*world, Wall(0.3));
    Join(*world, ToWorld(wall, HingeJoint{}, {{0, 3, 0}, Quaternion::Identity()}));
    ExpectNobodyBehind(*world, wall, ThrowMany(*world, random, 16, kFast));
  }
}

TEST_P(ImpactsOnWalls, HoldManyOffAWallOnItsGivenWay) {
  Proves({Claim::kKinematicPush});
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
    const EntityId wall = Add(*world, TurningWall(0.3));
    ExpectNobodyBehind(*world, wall, ThrowMany(*world, random, 16, kFast));
  }
}

}  // namespace
}  // namespace genphys::testing

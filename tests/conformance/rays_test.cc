// What a ray sees first.
#include <cmath>
#include <limits>
#include <numbers>

#include "engine_test.h"
#include "support/shapes.h"

namespace genphys {
namespace {

using namespace testing;

GENPHYS_ENGINE_TESTS(Rays, Claim::kRayCasts);

// Of a fraction: closed forms in double precision.
constexpr double kExact = 1e-12;

Quaternion QuarterTurn() { return Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitZ())); }

EntityDesc Still(const Shape& shape, const Pose& pose) {
  EntityDesc desc = Body(shape, pose.position);
  desc.pose = pose;
  desc.rigid_body->motion_type = MotionType::kStatic;
  return desc;
}

EntityId AddStill(World& world, const Shape& shape, const Vector3& position) {
  return Add(world, Still(shape, {position, Quaternion::Identity()}));
}

RayHit Cast(World& world, const Vector3& origin, const Vector3& translation, uint64_t bits = ~uint64_t{0}) {
  const Ray ray{origin, translation};
  const Result<std::vector<RayHit>> hits = world.CastRays({&ray, 1}, bits);
  EndAtRefusal(hits.status());
  EXPECT_TRUE(hits.ok()) << hits.status();
  return hits.ok() ? hits->front() : RayHit{};
}

bool HitsNothing(const RayHit& hit) { return hit.entity.is_null(); }

std::unique_ptr<World> MakeSpace(const std::string& engine) {
  WorldDesc desc;
  desc.engine = engine;
  desc.ground_plane = false;
  return MakeWorld(desc);
}

// `top` above its middle and `flank` beside it, along x, are the surface of `shape`.
void ExpectSeen(World& world, const Shape& shape, double top, double flank) {
  const EntityId id = AddStill(world, shape, {1, 2, 3});
  const RayHit above = Cast(world, {1, 2, 8}, {0, 0, -10});
  EXPECT_EQ(above.entity, id);
  EXPECT_NEAR(above.fraction, (5 - top) / 10, kExact);
  EXPECT_LT((above.normal - Vector3::UnitZ()).norm(), kExact);
  const RayHit beside = Cast(world, {6, 2, 3}, {-8, 0, 0});
  EXPECT_EQ(beside.entity, id);
  EXPECT_NEAR(beside.fraction, (5 - flank) / 8, kExact);
  EXPECT_LT((beside.normal - Vector3::UnitX()).norm(), kExact);
  EXPECT_TRUE(HitsNothing(Cast(world, {1, 2, 3}, {0, 0, 10}))) << "from inside";
  EXPECT_TRUE(HitsNothing(Cast(world, {1, 2, 8}, {0, 0, -5 + top + 1e-6}))) << "it ends before";
  EXPECT_TRUE(HitsNothing(Cast(world, {1, 2, 8}, {0, 0, 10}))) << "away from it";
  EXPECT_TRUE(HitsNothing(Cast(world, {1 + flank + 1e-6, 2, 8}, {0, 0, -10}))) << "beside it";
}

TEST_P(Rays, HitTheTopAndTheFlankOfASolidAndNothingFromInside) {
  ExpectSeen(*MakeSpace(GetParam()), Sphere{0.7}, 0.7, 0.7);
}

TEST_P(Rays, HitTheTopAndTheFlankOfABox) { ExpectSeen(*MakeSpace(GetParam()), Box{{0.3, 0.4, 0.6}}, 0.6, 0.3); }

TEST_P(Rays, HitTheTopAndTheFlankOfACapsule) { ExpectSeen(*MakeSpace(GetParam()), Capsule{0.3, 0.5}, 0.8, 0.3); }

TEST_P(Rays, HitTheTopAndTheFlankOfACylinder) { ExpectSeen(*MakeSpace(GetParam()), Cylinder{0.3, 0.5}, 0.5, 0.3); }

TEST_P(Rays, HitAPlaneFromAboveOnly) {
  const auto world = MakeSpace(GetParam());
  const EntityId plane = AddStill(*world, Plane{Vector3::UnitZ(), 1}, {0, 0, 1});

  const RayHit hit = Cast(*world, {5, 5, 4}, {3, 0, -4});

  EXPECT_EQ(hit.entity, plane);
  EXPECT_NEAR(hit.fraction, 0.5, kExact);
  EXPECT_LT((hit.normal - Vector3::UnitZ()).norm(), kExact);
  EXPECT_TRUE(HitsNothing(Cast(*world, {5, 5, 1}, {0, 0, 4})));
  EXPECT_TRUE(HitsNothing(Cast(*world, {5, 5, 4}, {1, 0, 0})));
}

TEST_P(Rays, HitTheRoundEndAndTheStraightSideOfACapsule) {
  const auto world = MakeSpace(GetParam());
  AddStill(*world, Capsule{0.5, 1}, Vector3::Zero());

  const RayHit round = Cast(*world, {0.3, 0, 5}, {0, 0, -10});

  EXPECT_NEAR(round.fraction, (5 - 1.4) / 10, kExact);
  EXPECT_LT((round.normal - Vector3(0.6, 0, 0.8)).norm(), kExact);
  EXPECT_NEAR(Cast(*world, {2.5, 0, 0.9}, {-4, 0, 0}).fraction, 0.5, kExact);
  EXPECT_TRUE(HitsNothing(Cast(*world, {2, 0, 1.6}, {-4, 0, 0})));
}

TEST_P(Rays, HitTheFlatEndOfACylinderBesideItsAxis) {
  const auto world = MakeSpace(GetParam());
  AddStill(*world, Cylinder{0.5, 1}, Vector3::Zero());

  const RayHit flat = Cast(*world, {0.3, 0, 5}, {0, 0, -10});

  EXPECT_NEAR(flat.fraction, (5 - 1.0) / 10, kExact);
  EXPECT_LT((flat.normal - Vector3::UnitZ()).norm(), kExact);
}

TEST_P(Rays, AreExactFromFarAway) {
  constexpr double kFar = 1e6;
  const auto world = MakeSpace(GetParam());
  AddStill(*world, Sphere{0.5}, Vector3::Zero());

  const RayHit hit = Cast(*world, {kFar, 0.3, 0}, {-2 * kFar, 0, 0});

  // The place is 0.4 m before the middle; of a fraction of two thousand kilometres that is what rounding leaves.
  EXPECT_NEAR((1 - 2 * hit.fraction) * kFar, 0.4, 2 * kFar * std::numeric_limits<double>::epsilon());
}

TEST_P(Rays, GiveTheClosestHitAndOfEqualOnesTheSmallerId) {
  const auto world = MakeSpace(GetParam());
  AddStill(*world, Sphere{0.5}, {4, 0, 0});
  const EntityId near = AddStill(*world, Sphere{0.5}, {2, 0, 0});
  AddStill(*world, Sphere{0.5}, {2, 0, 0});

  EXPECT_EQ(Cast(*world, {0, 0, 0}, {10, 0, 0}).entity, near);
}

TEST_P(Rays, SeeNoSensorsAndNoOtherCategoriesButStaticAndSleepingBodies) {
  const auto world = MakeSpace(GetParam());
  const EntityId fixed = AddStill(*world, Sphere{0.5}, {7, 0, 0});
  EntityDesc sleeper = Ball({5, 0, 0});
  sleeper.rigid_body->gravity_scale = 0;
  const EntityId asleep = Add(*world, sleeper);
  EntityDesc other = Still(Sphere{0.5}, {{3, 0, 0}, Quaternion::Identity()});
  other.rigid_body->geometries[0].category_bits = 2;
  Add(*world, other);
  Steps(*world, 120);
  ASSERT_TRUE(Asleep(*world, asleep));

  EXPECT_EQ(Cast(*world, {-1, 0, 0}, {10, 0, 0}, 1).entity, asleep);
  EXPECT_EQ(Cast(*world, {6, 0, 0}, {10, 0, 0}, 1).entity, fixed);
  EXPECT_TRUE(HitsNothing(Cast(*world, {-1, 0, 0}, {10, 0, 0}, 4)));
  EntityDesc sensor = Still(Sphere{0.5}, {{1, 0, 0}, Quaternion::Identity()});
  sensor.rigid_body->geometries[0].is_sensor = true;
  Add(*world, sensor);
  EXPECT_EQ(Cast(*world, {-1, 0, 0}, {10, 0, 0}, 1).entity, asleep);
}

TEST_P(Rays, SeeATurnedGeometryThatIsNotAtItsEntity) {
  const auto world = MakeSpace(GetParam());
  EntityDesc bar = Still(Box{{1, 0.1, 0.1}}, {{10, 0, 0}, QuarterTurn()});
  bar.rigid_body->geometries[0].pose_in_entity = {{0, 2, 0}, QuarterTurn()};
  const EntityId id = Add(*world, bar);

  // The entity's turn takes the geometry to x = 8 and its long side along x again.
  const RayHit hit = Cast(*world, {0, 0, 0}, {10, 0, 0});

  EXPECT_EQ(hit.entity, id);
  EXPECT_NEAR(hit.fraction, 0.7, kExact);
  EXPECT_LT((hit.normal + Vector3::UnitX()).norm(), kExact);
}

TEST_P(Rays, SeeABodyWhereItsFlightHasTakenIt) {
  const auto world = MakeSpace(GetParam());
  EntityDesc ball = Ball({0, 0, 0});
  ball.rigid_body->gravity_scale = 0;
  ball.rigid_body->linear_velocity = {6, 0, 0};
  const EntityId id = Add(*world, ball);

  Steps(*world, 60);

  const double x = PositionOf(*world, id).x();
  const RayHit hit = Cast(*world, {x, 0, 5}, {0, 0, -10});
  EXPECT_EQ(hit.entity, id);
  EXPECT_NEAR(hit.fraction, 0.45, kExact);
  EXPECT_TRUE(HitsNothing(Cast(*world, {x - 0.6, 0, 5}, {0, 0, -10})));
  EXPECT_TRUE(HitsNothing(Cast(*world, {0, 0, 5}, {0, 0, -10})));
}

}  // namespace
}  // namespace genphys

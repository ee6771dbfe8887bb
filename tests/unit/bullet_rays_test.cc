#include <gtest/gtest.h>

#include <cmath>

#include "bullet_test_bench.h"

namespace genphys {
namespace {

using namespace bullet_test;

// Closed forms in double precision.
constexpr double kExact = 1e-12;

struct Seen {
  const char* name;
  Shape shape;
  double top;    // of the shape above its middle
  double flank;  // beside its middle, along x
};

class BulletRays : public testing::TestWithParam<Seen> {};

TEST_P(BulletRays, HitTheTopAndTheFlankOfASolidAndNothingFromInside) {
  const Seen& seen = GetParam();
  Bench bench;
  const EntityRow row = bench.Add(seen.shape, {1, 2, 3});

  const RayHit top = bench.Cast({1, 2, 8}, {0, 0, -10});
  EXPECT_EQ(top.entity, bench.id(row));
  EXPECT_NEAR(top.fraction, (5 - seen.top) / 10, kExact);
  EXPECT_LT((top.normal - Vector3::UnitZ()).norm(), kExact);

  const RayHit flank = bench.Cast({6, 2, 3}, {-8, 0, 0});
  EXPECT_EQ(flank.entity, bench.id(row));
  EXPECT_NEAR(flank.fraction, (5 - seen.flank) / 8, kExact);
  EXPECT_LT((flank.normal - Vector3::UnitX()).norm(), kExact);

  EXPECT_TRUE(bench.Cast({1, 2, 3}, {0, 0, 10}).entity.is_null()) << "a ray from inside";
  EXPECT_TRUE(bench.Cast({1, 2, 8}, {0, 0, -5 + seen.top + 1e-6}).entity.is_null()) << "a ray that ends before it";
  EXPECT_TRUE(bench.Cast({1, 2, 8}, {0, 0, 10}).entity.is_null()) << "a ray away from it";
  EXPECT_TRUE(bench.Cast({1 + seen.flank + 1e-6, 2, 8}, {0, 0, -10}).entity.is_null()) << "a ray beside it";
}

INSTANTIATE_TEST_SUITE_P(Bullet, BulletRays,
                         testing::Values(Seen{"Sphere", Sphere{0.7}, 0.7, 0.7},
                                         Seen{"Box", Box{{0.3, 0.4, 0.6}}, 0.6, 0.3},
                                         Seen{"Capsule", Capsule{0.3, 0.5}, 0.8, 0.3},
                                         Seen{"Cylinder", Cylinder{0.3, 0.5}, 0.5, 0.3}),
                         [](const auto& param) { return param.param.name; });

TEST(BulletRays, HitAPlaneFromAboveOnly) {
  Bench bench;
  const EntityRow plane = bench.Add(Plane{Vector3::UnitZ(), 1}, {0, 0, 1}, MotionType::kStatic);

  const RayHit hit = bench.Cast({5, 5, 4}, {3, 0, -4});

  EXPECT_EQ(hit.entity, bench.id(plane));
  EXPECT_NEAR(hit.fraction, 0.5, kExact);
  EXPECT_LT((hit.normal - Vector3::UnitZ()).norm(), kExact);
  EXPECT_TRUE(bench.Cast({5, 5, 1}, {0, 0, 4}).entity.is_null());
  EXPECT_TRUE(bench.Cast({5, 5, 4}, {1, 0, 0}).entity.is_null());
}

TEST(BulletRays, HitTheRoundEndOfACapsuleAndTheFlatOneOfACylinderBesideItsAxis) {
  Bench bench;
  bench.Add(Capsule{0.5, 1}, Vector3::Zero());
  bench.Add(Cylinder{0.5, 1}, {5, 0, 0});

  const RayHit round = bench.Cast({0.3, 0, 5}, {0, 0, -10});
  const RayHit flat = bench.Cast({5.3, 0, 5}, {0, 0, -10});

  EXPECT_NEAR(round.fraction, (5 - 1.4) / 10, kExact);
  EXPECT_LT((round.normal - Vector3(0.6, 0, 0.8)).norm(), kExact);
  EXPECT_NEAR(flat.fraction, (5 - 1.0) / 10, kExact);
  EXPECT_LT((flat.normal - Vector3::UnitZ()).norm(), kExact);
}

TEST(BulletRays, AreExactFromFarAway) {
  constexpr double kFar = 1e6;
  Bench bench;
  bench.Add(kUnitBall, Vector3::Zero());

  const RayHit hit = bench.Cast({kFar, 0.3, 0}, {-2 * kFar, 0, 0});

  // The place is 0.4 m before the middle; a fraction of two thousand kilometres holds that to within rounding.
  EXPECT_NEAR((1 - 2 * hit.fraction) * kFar, 0.4, 1e-9);
}

TEST(BulletRays, GiveTheClosestHitAndOfEqualOnesTheSmallerId) {
  Bench bench;
  bench.Add(kUnitBox, {4, 0, 0});
  const EntityRow near = bench.Add(kUnitBox, {2, 0, 0});
  bench.Add(kUnitBox, {2, 0, 0});

  EXPECT_EQ(bench.Cast({0, 0, 0}, {10, 0, 0}).entity, bench.id(near));
}

TEST(BulletRays, SeeNoSensorsAndNoOtherCategoriesButStaticAndInactiveBodies) {
  Bench bench;
  RigidBody sensor = Bench::Describe(kUnitBox, MotionType::kStatic);
  sensor.geometries[0].is_sensor = true;
  bench.Add(sensor, {{1, 0, 0}, Quaternion::Identity()});
  RigidBody other = Bench::Describe(kUnitBox, MotionType::kStatic);
  other.geometries[0].category_bits = 2;
  bench.Add(other, {{3, 0, 0}, Quaternion::Identity()});
  const EntityRow sleeper = bench.Add(kUnitBox, {5, 0, 0});
  bench.SetActive(sleeper, false);
  const EntityRow fixed = bench.Add(kUnitBox, {7, 0, 0}, MotionType::kStatic);

  EXPECT_EQ(bench.Cast({-1, 0, 0}, {10, 0, 0}, 1).entity, bench.id(sleeper));
  EXPECT_EQ(bench.Cast({6, 0, 0}, {10, 0, 0}, 1).entity, bench.id(fixed));
  EXPECT_TRUE(bench.Cast({-1, 0, 0}, {10, 0, 0}, 4).entity.is_null());
}

TEST(BulletRays, SeeATurnedGeometryThatIsNotAtItsEntity) {
  Bench bench;
  RigidBody body = Bench::Describe(Box{{1, 0.1, 0.1}});
  body.geometries[0].pose_in_entity = {{0, 2, 0}, TurnedBy(std::numbers::pi / 2, Vector3::UnitZ())};
  const EntityRow row = bench.Add(body, {{10, 0, 0}, TurnedBy(std::numbers::pi / 2, Vector3::UnitZ())});

  // The entity's turn takes the geometry to x = 8 and its long side along x again.
  const RayHit hit = bench.Cast({0, 0, 0}, {10, 0, 0});

  EXPECT_EQ(hit.entity, bench.id(row));
  EXPECT_NEAR(hit.fraction, 0.7, kExact);
  EXPECT_LT((hit.normal + Vector3::UnitX()).norm(), kExact);
}

}  // namespace
}  // namespace genphys

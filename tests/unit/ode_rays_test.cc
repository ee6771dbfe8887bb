#include <gtest/gtest.h>

#include <cmath>

#include "ode_test_bench.h"

namespace genphys {
namespace {

using namespace ode_test;

class SeenShape : public testing::TestWithParam<std::pair<const char*, Shape>> {};

TEST_P(SeenShape, IsHitFromAboveAtItsTopAndNotFromInside) {
  Bench bench;
  const EntityRow body = bench.Add(GetParam().second, {3, 4, 5});

  const RayHit hit = bench.Cast({3, 4, 7.5}, {0, 0, -4});

  EXPECT_EQ(hit.entity, bench.id(body));
  EXPECT_NEAR(hit.fraction, 0.5, kRounding);
  EXPECT_LT((hit.normal - Vector3::UnitZ()).norm(), kRounding);
  EXPECT_TRUE(bench.Cast({3, 4, 5}, {0, 0, 4}).entity.is_null()) << "from inside";
  EXPECT_TRUE(bench.Cast({3, 4, 7.5}, {0, 0, -1.9}).entity.is_null()) << "too short";
  EXPECT_TRUE(bench.Cast({3, 4, 7.5}, {0, 0, 4}).entity.is_null()) << "away";
}

TEST_P(SeenShape, IsHitFromTheSideAtItsFlank) {
  Bench bench;
  const EntityRow body = bench.Add(GetParam().second, {3, 4, 5});

  const RayHit hit = bench.Cast({1, 4, 5}, {2, 0, 0});

  EXPECT_EQ(hit.entity, bench.id(body));
  EXPECT_NEAR(hit.fraction, 0.75, kRounding);
  EXPECT_LT((hit.normal + Vector3::UnitX()).norm(), kRounding);
  EXPECT_TRUE(bench.Cast({1, 4, 7}, {2, 0, 0}).entity.is_null()) << "above";
}

INSTANTIATE_TEST_SUITE_P(OdeRays, SeenShape,
                         testing::Values(std::pair{"Box", Shape{Box{{0.5, 0.3, 0.5}}}},
                                         std::pair{"Sphere", Shape{Sphere{0.5}}},
                                         std::pair{"Cylinder", Shape{Cylinder{0.5, 0.5}}}),
                         [](const auto& param) { return param.param.first; });

TEST(OdeRays, SeesTheRoundEndAndTheStraightSideOfACapsule) {
  Bench bench;
  bench.Add(Capsule{0.5, 1}, {0, 0, 0});

  EXPECT_NEAR(bench.Cast({0, 0, 3.5}, {0, 0, -4}).fraction, 0.5, kRounding);
  EXPECT_NEAR(bench.Cast({2.5, 0, 0.9}, {-4, 0, 0}).fraction, 0.5, kRounding);
  const double half_chord = std::sqrt(0.25 - 0.09);
  EXPECT_NEAR(bench.Cast({2, 0, 1.3}, {-4, 0, 0}).fraction, (2 - half_chord) / 4, kRounding);
  EXPECT_TRUE(bench.Cast({2, 0, 1.6}, {-4, 0, 0}).entity.is_null());
}

TEST(OdeRays, GivesTheClosestHitAndOfEqualOnesTheSmallerId) {
  Bench bench;
  bench.AddGround();
  const EntityRow low = bench.Add(kUnitBox, {0, 0, 1});
  const EntityRow high = bench.Add(kUnitBox, {0, 0, 3});
  bench.Add(kUnitBox, {0, 0, 3});

  EXPECT_EQ(bench.Cast({0, 0, 9}, {0, 0, -20}).entity, bench.id(high));
  EXPECT_EQ(bench.Cast({0, 0, 2}, {0, 0, -20}).entity, bench.id(low));
  EXPECT_EQ(bench.Cast({2, 0, 2}, {0, 0, -4}).entity, bench.id(EntityRow{0}));
}

TEST(OdeRays, HidesSensorsAndOtherCategoriesFromRays) {
  Bench bench;
  RigidBody sensor = Bench::BodyOf(kUnitBox, MotionType::kStatic);
  sensor.geometries[0].is_sensor = true;
  bench.Add(sensor, {});
  RigidBody other = Bench::BodyOf(kUnitBox, MotionType::kStatic);
  other.geometries[0].category_bits = 4;
  const EntityRow seen = bench.Add(other, {{0, 0, -2}, Quaternion::Identity()});
  const Ray ray{{0, 0, 5}, {0, 0, -10}};
  RayHit hit;

  bench.world().CastRays(bench.rule, {&ray, 1}, 4, {&hit, 1});
  EXPECT_EQ(hit.entity, bench.id(seen));
  bench.world().CastRays(bench.rule, {&ray, 1}, 3, {&hit, 1});
  EXPECT_TRUE(hit.entity.is_null());
}

TEST(OdeRays, SeesATurnedGeometryThatIsNotAtItsEntity) {
  Bench bench;
  RigidBody body = Bench::BodyOf(Box{{1, 0.1, 0.1}});
  body.geometries[0].pose_in_entity = {{0, 0, 2}, Quaternion(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY()))};
  const Quaternion lying(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY()));
  bench.Add(body, {{0, 0, 0}, lying});

  // The bar stands along z in the entity, and lies along x in the world, from x = 1 to x = 3.
  const RayHit hit = bench.Cast({5, 0, 0}, {-4, 0, 0});

  EXPECT_NEAR(hit.fraction, 0.5, kRounding);
  EXPECT_LT((hit.normal - Vector3::UnitX()).norm(), kRounding);
}

}  // namespace
}  // namespace genphys

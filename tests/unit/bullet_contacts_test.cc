#include <gtest/gtest.h>

#include <cmath>

#include "bullet_test_bench.h"

namespace genphys {
namespace {

using namespace bullet_test;

// Closed forms and clipping in double precision, on lengths around one.
constexpr double kExact = 1e-9;
// Where Bullet's search for closest features on round shapes stops.
constexpr double kSearched = 1e-3;

// The deepest contact point of two solids, the second dynamic, of which the first is at the origin.
ContactPoint Meet(const Shape& a, const Shape& b, const Pose& pose_of_b) {
  Bench bench;
  bench.Add(a, Vector3::Zero(), MotionType::kStatic);
  bench.Add(Bench::Describe(b), pose_of_b);
  bench.Collide();
  EXPECT_EQ(bench.contacts.pairs.size(), 1u);
  const auto deepest = std::max_element(bench.contacts.points.begin(), bench.contacts.points.end(),
                                        [](const auto& x, const auto& y) { return x.depth < y.depth; });
  return deepest == bench.contacts.points.end() ? ContactPoint{} : *deepest;
}

TEST(BulletContacts, TellWhereABallMeetsTheEdgeOfABox) {
  const double reach = 0.5 - 1e-3;
  const Vector3 outward = Vector3(1, 0, 1).normalized();

  const ContactPoint point = Meet(kUnitBox, kUnitBall, {Vector3(0.5, 0.1, 0.5) + reach * outward, {1, 0, 0, 0}});

  EXPECT_NEAR(point.depth, 1e-3, kExact);
  EXPECT_LT((point.normal - outward).norm(), kExact);
  EXPECT_LT((point.position - (Vector3(0.5, 0.1, 0.5) - 0.5e-3 * outward)).norm(), kExact);
}

TEST(BulletContacts, TellTheWayOutOfABallDeepInsideABox) {
  const ContactPoint point = Meet(kUnitBox, kUnitBall, {{0.1, -0.3, 0.2}, Quaternion::Identity()});

  EXPECT_NEAR(point.depth, 0.7, kExact);
  EXPECT_LT((point.normal - Vector3(0, -1, 0)).norm(), kExact);
}

TEST(BulletContacts, TellWhereABallMeetsTheRimAndTheSideOfACylinder) {
  const Vector3 radial(std::cos(0.3), std::sin(0.3), 0);
  const Vector3 rim_normal = (radial + Vector3::UnitZ()).normalized();
  const Vector3 rim = 0.4 * radial + Vector3(0, 0, 0.6);

  const ContactPoint at_rim = Meet(Cylinder{0.4, 0.6}, kUnitBall, {rim + 0.499 * rim_normal, {1, 0, 0, 0}});
  const ContactPoint at_side = Meet(Cylinder{0.4, 0.6}, kUnitBall, {0.901 * radial, {1, 0, 0, 0}});

  EXPECT_NEAR(at_rim.depth, 1e-3, kExact);
  EXPECT_LT((at_rim.normal - rim_normal).norm(), kExact);
  EXPECT_NEAR(at_side.depth, -1e-3, kExact);
  EXPECT_LT((at_side.normal - radial).norm(), kExact);
}

struct FlatCase {
  const char* name;
  Shape lower;
  Shape upper;
  double height;        // of the upper one's middle when it touches
  Quaternion attitude;  // of the upper one
  size_t points;
};

class BulletFlatContacts : public testing::TestWithParam<FlatCase> {};

TEST_P(BulletFlatContacts, AreSpreadOverWhatTouchesAndTellDepthAndGap) {
  const FlatCase& c = GetParam();
  for (const double depth : {1e-2, 1e-6, -1e-4}) {
    Bench bench;
    bench.Add(c.lower, Vector3::Zero(), MotionType::kStatic);
    bench.Add(Bench::Describe(c.upper), {{0.05, 0.02, c.height - depth}, c.attitude});

    bench.Collide();

    ASSERT_EQ(bench.contacts.points.size(), c.points) << depth;
    Vector3 middle = Vector3::Zero();
    for (const ContactPoint& point : bench.contacts.points) {
      EXPECT_NEAR(point.depth, depth, kExact);
      EXPECT_LT((point.normal - Vector3::UnitZ()).norm(), kExact);
      middle += point.position / static_cast<double>(c.points);
    }
    EXPECT_LT((middle.head<2>() - Vector3(0.05, 0.02, 0).head<2>()).norm(), 0.1) << "they do not surround the middle";
  }
}

const Quaternion kUpright = Quaternion::Identity();
const Quaternion kLying = TurnedBy(std::numbers::pi / 2, Vector3::UnitY());

INSTANTIATE_TEST_SUITE_P(
    Bullet, BulletFlatContacts,
    testing::Values(FlatCase{"BoxOnPlane", kGround, kUnitBox, 0.5, kUpright, 4},
                    FlatCase{"BoxOnBox", kUnitBox, kUnitBox, 1, kUpright, 4},
                    FlatCase{"TurnedBoxOnBox", kUnitBox, kUnitBox, 1, TurnedBy(0.6, Vector3::UnitZ()), 4},
                    FlatCase{"CylinderOnPlane", kGround, Cylinder{0.3, 0.5}, 0.5, kUpright, 4},
                    FlatCase{"CylinderOnBox", kUnitBox, Cylinder{0.3, 0.5}, 1, kUpright, 4},
                    FlatCase{"LyingCylinderOnBox", kUnitBox, Cylinder{0.3, 0.4}, 0.8, kLying, 2},
                    FlatCase{"CylinderOnCylinder", Cylinder{0.4, 0.5}, Cylinder{0.3, 0.5}, 1, kUpright, 4},
                    FlatCase{"CapsuleOnPlane", kGround, Capsule{0.3, 0.4}, 0.3, kLying, 2},
                    FlatCase{"CapsuleOnBox", kUnitBox, Capsule{0.3, 0.4}, 0.8, kLying, 2},
                    FlatCase{"CapsuleOnCylinder", Cylinder{0.5, 0.5}, Capsule{0.3, 0.4}, 0.8, kLying, 2},
                    FlatCase{"StandingCapsuleOnBox", kUnitBox, Capsule{0.3, 0.4}, 1.2, kUpright, 1}),
    [](const auto& param) { return param.param.name; });

TEST(BulletContacts, AreTwoAlongRoundSidesThatLieTogether) {
  for (const Shape& shape : {Shape{Capsule{0.3, 0.5}}, Shape{Cylinder{0.3, 0.5}}}) {
    Bench bench;
    bench.Add(shape, Vector3::Zero(), MotionType::kStatic);
    bench.Add(shape, {0.599, 0, 0.4});

    bench.Collide();

    ASSERT_EQ(bench.contacts.points.size(), 2u);
    for (const ContactPoint& point : bench.contacts.points) {
      EXPECT_NEAR(point.depth, 1e-3, kExact);
      EXPECT_LT((point.normal - Vector3::UnitX()).norm(), kExact);
    }
    // Both run from -0.1 to 0.5.
    EXPECT_NEAR(std::abs(bench.contacts.points[0].position.z() - bench.contacts.points[1].position.z()), 0.6, kExact);
  }
}

TEST(BulletContacts, AreEndToEndForCylindersInARowThatOverlapALittle) {
  const ContactPoint point = Meet(Cylinder{0.3, 0.5}, Cylinder{0.3, 0.5}, {{0.2, 0, 1 - 1e-5}, kUpright});

  EXPECT_NEAR(point.depth, 1e-5, kExact);
  EXPECT_LT((point.normal - Vector3::UnitZ()).norm(), kExact);
}

TEST(BulletContacts, AreOnePointWhereEdgesCross) {
  const Quaternion on_edge = TurnedBy(std::numbers::pi / 4, Vector3::UnitX());
  RigidBody lower = Bench::Describe(kUnitBox, MotionType::kStatic);
  lower.geometries[0].pose_in_entity.orientation = TurnedBy(std::numbers::pi / 4, Vector3::UnitY());
  Bench bench;
  bench.Add(lower);
  bench.Add(Bench::Describe(kUnitBox), {{0, 0, std::sqrt(2.0) - 1e-3}, on_edge});

  bench.Collide();

  ASSERT_EQ(bench.contacts.points.size(), 1u);
  EXPECT_NEAR(bench.contacts.points[0].depth, 1e-3, kExact);
  EXPECT_LT((bench.contacts.points[0].normal - Vector3::UnitZ()).norm(), kExact);
  EXPECT_LT(bench.contacts.points[0].position.head<2>().norm(), kSearched);
}

TEST(BulletContacts, LeaveOutWhatHasALargerGapThanTwoMillimetres) {
  for (const auto& [gap, points] : {std::pair{1.9e-3, 1u}, {2.1e-3, 0u}}) {
    Bench bench;
    bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
    bench.Add(kUnitBall, {0, 0, 0.5 + gap});

    bench.Collide();

    EXPECT_EQ(bench.contacts.points.size(), points) << gap;
  }
}

TEST(BulletContacts, AreInCanonicalOrderWithNormalsFromAToB) {
  Bench bench;
  // Added against the order of their ids, as when slots are used again.
  bench.state.Resize(4);
  const std::vector<uint32_t> generations{3, 1, 2, 1};
  for (uint32_t i = 0; i < 4; ++i) {
    const Pose pose{{0.9 * i, 0, 0}, Quaternion::Identity()};
    bench.AddAt(EntityRow{i}, EntityId(i, generations[i]), Bench::Describe(kUnitBall), pose);
  }

  bench.Collide();

  ASSERT_EQ(bench.contacts.pairs.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    const ContactPair& pair = bench.contacts.pairs[i];
    EXPECT_LT(bench.id(pair.entity_a), bench.id(pair.entity_b));
    if (i > 0) {
      const ContactPair& before = bench.contacts.pairs[i - 1];
      EXPECT_LT(std::pair(bench.id(before.entity_a), bench.id(before.entity_b)),
                std::pair(bench.id(pair.entity_a), bench.id(pair.entity_b)));
    }
    const Vector3 between = bench.position(pair.entity_b) - bench.position(pair.entity_a);
    EXPECT_NEAR(bench.contacts.points[pair.first_point].normal.dot(between), between.norm(), kExact);
  }
}

TEST(BulletContacts, OrderTheGeometriesOfAPairByEntityFirst) {
  RigidBody twins = Bench::Describe(kUnitBall);
  twins.geometries.push_back(twins.geometries[0]);
  twins.geometries[0].id = 7;
  twins.geometries[1].id = 2;
  twins.geometries[1].pose_in_entity.position = {0.1, 0, 0};
  Bench bench;
  const EntityRow left = bench.Add(twins);
  const EntityRow right = bench.Add(twins, {{0.5, 0, 0}, Quaternion::Identity()});

  bench.Collide();

  ASSERT_EQ(bench.contacts.pairs.size(), 4u);
  std::vector<std::pair<uint32_t, uint32_t>> order;
  for (const ContactPair& pair : bench.contacts.pairs) {
    EXPECT_EQ(pair.entity_a, left);
    EXPECT_EQ(pair.entity_b, right);
    order.emplace_back(bench.rule.info(pair.geometry_a).geometry_id, bench.rule.info(pair.geometry_b).geometry_id);
  }
  EXPECT_EQ(order, (std::vector<std::pair<uint32_t, uint32_t>>{{2, 2}, {2, 7}, {7, 2}, {7, 7}}));
}

TEST(BulletContacts, AreNotLookedForBetweenInactiveBodies) {
  Bench bench;
  const EntityRow a = bench.Add(kUnitBall, Vector3::Zero());
  const EntityRow b = bench.Add(kUnitBall, {0.9, 0, 0});
  bench.Add(Plane{Vector3::UnitZ(), -0.49}, Vector3::Zero(), MotionType::kStatic);
  for (const EntityRow row : {a, b}) bench.SetActive(row, false);
  bench.Collide();
  EXPECT_TRUE(bench.contacts.pairs.empty());

  bench.SetActive(a, true);
  bench.Collide();

  EXPECT_EQ(bench.contacts.pairs.size(), 2u);
}

TEST(BulletContacts, AreFoundForEveryPairOfManyThatMoveSleepAndGo) {
  Bench bench;
  std::vector<EntityRow> balls;
  // A spiral that is walked along in each round, so that leaves move, change trees and go in every order.
  const auto place = [](int i) -> Vector3 {
    return {0.1 * i * std::cos(0.5 * i), 0.1 * i * std::sin(0.5 * i), 0.3 * std::cos(0.1 * i)};
  };
  for (int i = 0; i < 120; ++i) balls.push_back(bench.Add(kUnitBall, place(i)));
  for (int round = 0; round < 20; ++round) {
    for (int i = 0; i < static_cast<int>(balls.size()); ++i) {
      bench.Put(balls[i], {place(i + 3 * round), Quaternion::Identity()});
      bench.SetActive(balls[i], (i + round) % 3 != 0);
    }
    const size_t victim = static_cast<size_t>(7 * round) % balls.size();
    bench.Remove(balls[victim]);
    balls.erase(balls.begin() + static_cast<ptrdiff_t>(victim));

    bench.Collide();

    size_t expected = 0;
    const auto is_active = [&](EntityRow row) {
      return std::binary_search(bench.moving.begin(), bench.moving.end(), row);
    };
    for (size_t i = 0; i < balls.size(); ++i) {
      for (size_t j = 0; j < i; ++j) {
        const double gap = (bench.position(balls[i]) - bench.position(balls[j])).norm() - 1;
        expected += gap <= 2e-3 && (is_active(balls[i]) || is_active(balls[j]));
      }
    }
    EXPECT_EQ(bench.contacts.pairs.size(), expected) << round;
  }
}

TEST(BulletContacts, FollowAPlaneThatWasPutElsewhere) {
  Bench bench;
  const EntityRow plane = bench.Add(kGround, Vector3::Zero(), MotionType::kStatic);
  bench.Add(kUnitBall, {0, 0, 10.499});

  bench.Put(plane, {{0, 0, 10}, Quaternion::Identity()});
  bench.Collide();
  ASSERT_EQ(bench.contacts.points.size(), 1u);
  EXPECT_NEAR(bench.contacts.points[0].depth, 1e-3, kExact);

  bench.Put(plane, {{0, 0, 10}, TurnedBy(std::numbers::pi, Vector3::UnitX())});
  bench.Collide();

  ASSERT_EQ(bench.contacts.points.size(), 1u);
  EXPECT_NEAR(bench.contacts.points[0].depth, 0.999, kExact)
      << "the ball is inside the half space that was turned over";
}

}  // namespace
}  // namespace genphys

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ode_test_bench.h"

namespace genphys {
namespace {

using namespace ode_test;

TEST(OdeContacts, TellsContactsInCanonicalOrderWithNormalsFromAToB) {
  Bench bench;
  const EntityRow top = bench.Add(kUnitBox, {0, 0, 1.45});
  const EntityRow bottom = bench.Add(kUnitBox, {0, 0, 0.5});
  bench.AddGround();
  bench.Collide();

  ASSERT_EQ(bench.contacts.pairs.size(), 2u);
  const ContactPair& first = bench.contacts.pairs[0];
  EXPECT_EQ(first.entity_a, top);
  EXPECT_EQ(first.entity_b, bottom);
  EXPECT_EQ(first.point_count, 4u);
  for (uint32_t i = 0; i < first.point_count; ++i) {
    EXPECT_LT((bench.contacts.points[first.first_point + i].normal + Vector3::UnitZ()).norm(), kRounding);
    EXPECT_NEAR(bench.contacts.points[first.first_point + i].depth, 0.05, kRounding);
  }
  const ContactPair& second = bench.contacts.pairs[1];
  EXPECT_EQ(second.entity_a, bottom);
  EXPECT_LT((bench.contacts.points[second.first_point].normal + Vector3::UnitZ()).norm(), kRounding);
}

// Edges that lie on each other cross anywhere along them: where, is a matter of the last bit.
TEST(OdeContacts, AreTheFourCornersOfABoxOnAnotherHoweverTheLastBitsLie) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    const double off = std::pow(10, -6 - 4 * std::abs(number(generator)));
    Bench bench;
    bench.Add(kUnitBox, {0, 0, 0.5});
    const Vector3 aside = off * Vector3(number(generator), number(generator), 0);
    const Quaternion turn(Eigen::AngleAxisd(off * number(generator), Vector3::UnitZ()));
    bench.Add(Bench::BodyOf(kUnitBox), {Vector3(0, 0, 1.5 - 1e-6) + aside, turn});
    bench.Collide();
    ASSERT_EQ(bench.contacts.points.size(), 4u);
    Vector3 middle = Vector3::Zero();
    for (const ContactPoint& point : bench.contacts.points) {
      middle += point.position / 4;
      // Within the skin of a corner, and what they lie beside each other.
      EXPECT_NEAR(std::abs(point.position.x()), 0.5, 1e-4 + 4 * off);
      EXPECT_NEAR(std::abs(point.position.y()), 0.5, 1e-4 + 4 * off);
    }
    EXPECT_LT(middle.head<2>().norm(), 1e-4 + 4 * off);
  }
}

TEST(OdeContacts, OrdersTheGeometriesOfAPairByEntityFirst) {
  Bench bench;
  RigidBody two = Bench::BodyOf(kUnitBox);
  two.geometries.push_back(two.geometries[0]);
  two.geometries[1].id = 2;
  const EntityRow first = bench.Add(two, {});
  bench.Add(two, {{0.5, 0, 0}, Quaternion::Identity()});
  bench.Add(two, {{1, 0, 0}, Quaternion::Identity()});

  bench.Collide();

  ASSERT_EQ(bench.contacts.pairs.size(), 12u);
  for (size_t i = 1; i < bench.contacts.pairs.size(); ++i) {
    const auto key = [&](const ContactPair& p) {
      return std::tuple(p.entity_a, p.entity_b, bench.rule.info(p.geometry_a).geometry_id,
                        bench.rule.info(p.geometry_b).geometry_id);
    };
    EXPECT_LT(key(bench.contacts.pairs[i - 1]), key(bench.contacts.pairs[i]));
  }
  EXPECT_EQ(bench.contacts.pairs[0].entity_a, first);
}

TEST(OdeContacts, PushesABallOffTheAxisOfACylinderInSomeDirection) {
  Bench bench;
  // Long, for else the ball would leave through a cap.
  bench.Add(Cylinder{0.5, 2}, {0, 0, 5});
  bench.Add(kUnitBall, {0, 0, 5});

  bench.Collide();

  ASSERT_EQ(bench.contacts.points.size(), 1u);
  EXPECT_NEAR(bench.contacts.points[0].normal.norm(), 1, kRounding);
  EXPECT_NEAR(bench.contacts.points[0].normal.z(), 0, kRounding);
}

TEST(OdeContacts, FindsEveryPairOfManyThatMoveSleepAndGo) {
  constexpr int kCount = 200;
  Bench bench;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-2, 2);
  for (int i = 0; i < kCount; ++i) bench.Add(Sphere{0.2}, {place(random), place(random), place(random)});
  std::vector<EntityRow> all = bench.moving;
  for (int round = 0; round < 20; ++round) {
    const std::vector<EntityRow> before = all;
    for (EntityRow row : before) {
      const double dice = place(random);
      if (dice < -1.9) {
        bench.Remove(row);
        std::erase(all, row);
      } else if (dice < 0) {
        bench.SetActive(row, dice < -1);
      } else if (dice < 1) {
        bench.Move(row, bench.position(row) + 0.1 * Vector3(place(random), place(random), place(random)));
      }
    }

    bench.Collide();

    std::vector<std::pair<EntityRow, EntityRow>> expected, found;
    const auto moves = [&](EntityRow row) { return std::binary_search(bench.moving.begin(), bench.moving.end(), row); };
    for (EntityRow a : all) {
      for (EntityRow b : all) {
        const bool touch = (bench.position(a) - bench.position(b)).norm() < 0.4;
        if (a < b && touch && (moves(a) || moves(b))) expected.emplace_back(a, b);
      }
    }
    for (const ContactPair& pair : bench.contacts.pairs) {
      if (bench.contacts.points[pair.first_point].depth > 0) found.emplace_back(pair.entity_a, pair.entity_b);
    }
    EXPECT_FALSE(expected.empty());
    EXPECT_EQ(found, expected) << round;
  }
}

TEST(OdeContacts, TellsAGapBeforeItCloses) {
  Bench bench;
  bench.AddGround();
  const EntityRow ball = bench.Add(kUnitBall, {0, 0, 0.5 + 5e-5});
  bench.Collide();
  ASSERT_EQ(bench.contacts.points.size(), 1u);
  EXPECT_NEAR(bench.contacts.points[0].depth, -5e-5, kRounding);

  bench.Move(ball, {0, 0, 0.5 + 3e-4});

  bench.Collide();
  EXPECT_TRUE(bench.contacts.points.empty());
}

TEST(OdeContacts, MeasuresTheDepthOfATiltedEdgeExactly) {
  Bench bench;
  bench.AddGround();
  const double half_diagonal = std::sqrt(0.5);
  const Quaternion on_edge(Eigen::AngleAxisd(M_PI / 4, Vector3::UnitX()));
  bench.Add(Bench::BodyOf(kUnitBox), {{0, 0, half_diagonal - 0.01}, on_edge});

  bench.Collide();

  ASSERT_EQ(bench.contacts.points.size(), 2u);
  for (const ContactPoint& point : bench.contacts.points) EXPECT_NEAR(point.depth, 0.01, kRounding);
}

TEST(OdeContacts, TellsTheSameContactsWhenAskedTwice) {
  Bench bench;
  bench.AddGround();
  bench.Add(kUnitBox, {0, 0, 0.5});
  bench.Collide();
  const ContactBuffer once = bench.contacts;

  bench.Collide();

  ASSERT_EQ(bench.contacts.points.size(), once.points.size());
  for (size_t i = 0; i < once.points.size(); ++i) EXPECT_EQ(bench.contacts.points[i].position, once.points[i].position);
}

TEST(OdeContacts, KeepsAtMostEightPointsOfAPair) {
  Bench bench;
  bench.Add(kUnitBox, {0, 0, 0});
  bench.Add(Cylinder{0.3, 0.5}, {0, 0, 0.95});

  bench.Collide();

  ASSERT_EQ(bench.contacts.pairs.size(), 1u);
  EXPECT_LE(bench.contacts.pairs[0].point_count, 8u);
  EXPECT_GE(bench.contacts.pairs[0].point_count, 3u);
}

TEST(OdeContacts, DoesNotTestTwoInactiveBodies) {
  Bench bench;
  bench.AddGround();
  const EntityRow a = bench.Add(kUnitBox, {0, 0, 0.5});
  const EntityRow b = bench.Add(kUnitBox, {0, 0, 1.4});
  bench.SetActive(a, false);
  bench.SetActive(b, false);
  bench.Collide();
  EXPECT_TRUE(bench.contacts.pairs.empty());

  bench.SetActive(a, true);

  bench.Collide();
  EXPECT_EQ(bench.contacts.pairs.size(), 2u);
}

TEST(OdeContacts, FollowsAStaticPlaneThatWasMoved) {
  Bench bench;
  const EntityRow plane = bench.Add(Plane{}, Vector3::Zero(), MotionType::kStatic);
  bench.Add(kUnitBall, {0, 0, 1.4});

  bench.Move(plane, {0, 0, 1});
  bench.Collide();

  ASSERT_EQ(bench.contacts.points.size(), 1u);
  EXPECT_NEAR(bench.contacts.points[0].depth, 0.1, kRounding);
}

TEST(OdeContacts, ForgetsARemovedBody) {
  Bench bench;
  bench.AddGround();
  const EntityRow ball = bench.Add(kUnitBall, {0, 0, 0.4});
  bench.moving.clear();

  bench.Remove(ball);

  bench.Collide();
  EXPECT_TRUE(bench.contacts.pairs.empty());
}

}  // namespace
}  // namespace genphys

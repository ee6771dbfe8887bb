#include "core/src/impacts/ties.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <random>

#include "core/src/joints/row_rate.h"

namespace genphys {
namespace {

// By the softness of rows, 1e-8 of their mobility, in a row of four.
constexpr double kSoftness = 1e-8;
constexpr double kPassed = 100 * kSoftness;

// Four bodies in a row, held by points, of which the first is held by the world.
struct Row {
  static constexpr uint32_t kCount = 4;
  std::vector<JointBody> bodies{1};
  std::vector<JointRow> rows;
  std::vector<uint32_t> slots;
  std::mt19937 dice{3};

  double Any() { return std::uniform_real_distribution(-1.0, 1.0)(dice); }
  Vector3 AnyVector() { return {Any(), Any(), Any()}; }

  Row() {
    for (uint32_t i = 1; i <= kCount; ++i) {
      JointBody& body = bodies.emplace_back();
      body.row = EntityRow{i};
      body.center = {static_cast<double>(i), 0.3 * Any(), 0.3 * Any()};
      body.inverse_mass = 1 / (1.5 + Any());
      body.inverse_tensor = Vector3(3, 2, 5).asDiagonal();
      const Vector3 point = body.center - Vector3(0.5, 0.1 * Any(), 0.1 * Any());
      for (int axis = 0; axis < 3; ++axis) {
        rows.push_back({.a = i == 1 ? kWorldRow : EntityRow{i - 1},
                        .b = EntityRow{i},
                        .axis = Vector3::Unit(axis),
                        .point = point,
                        .softness = kSoftness});
        slots.push_back(i);
      }
    }
  }
};

class TiesTest : public ::testing::Test {
 protected:
  static constexpr std::array<uint32_t, 4> kMembers{7, 2, 5, 3};

  void SetUp() override { ASSERT_TRUE(ties_.Add(kMembers, row_.bodies, row_.rows, row_.slots)); }

  std::array<Velocities, Row::kCount + 1> After(std::span<const Ties::Push> pushes) {
    std::vector<Ties::Change> changes;
    ties_.Pass(pushes, changes);
    std::array<Velocities, Row::kCount + 1> after;
    EXPECT_EQ(changes.size(), Row::kCount);
    for (const Ties::Change& change : changes) {
      const auto place = static_cast<size_t>(std::ranges::find(kMembers, change.body) - kMembers.begin());
      after.at(place + 1) = {change.linear, change.angular};
    }
    return after;
  }

  Row row_;
  Ties ties_;
};

TEST_F(TiesTest, LeaveTogetherWhatTheyHoldTogether) {
  const std::array<Ties::Push, 1> push{{{5, {1, -2, 3}, {0.3, 0.2, -0.5}}}};
  const auto after = After(push);
  for (const JointRow& each : row_.rows) {
    const size_t a = each.a == kWorldRow ? 0 : Index(each.a), b = Index(each.b);
    EXPECT_NEAR(RateOf(each, row_.bodies[a], after[a], row_.bodies[b], after[b]), 0, kPassed);
  }
  EXPECT_GT(after[1].linear.norm() + after[1].spin.norm(), 0.01);
}

TEST_F(TiesTest, TellWhatImpulsesTheJointsHadToBear) {
  const std::array<Ties::Push, 2> pushes{{{5, {1, -2, 3}, {0.3, 0.2, -0.5}}, {3, {0, 1, 0}, {0, 0, 0.1}}}};
  const auto after = After(pushes);
  // N*s on each body, by pushes and joints together.
  std::array<Vector3, Row::kCount + 1> given;
  given.fill(Vector3::Zero());
  given[3] += pushes[0].linear;
  given[4] += pushes[1].linear;
  ties_.VisitBorne(pushes, [&](uint32_t slot, const JointRow& row) {
    EXPECT_EQ(slot, Index(row.b));
    given.at(Index(row.b)) += row.impulse * row.axis;
    if (row.a != kWorldRow) given.at(Index(row.a)) -= row.impulse * row.axis;
  });
  for (size_t i = 1; i <= Row::kCount; ++i) {
    EXPECT_LT((given.at(i) * row_.bodies[i].inverse_mass - after.at(i).linear).norm(), 1e-12) << "body " << i;
  }
}

// Maxwell's and Betti's: what one push does where another one is does that one where it is.
TEST_F(TiesTest, PassOnAsMuchThereAsBack) {
  const Vector3 here = row_.AnyVector(), there = row_.AnyVector();
  const std::array<Ties::Push, 1> first{{{7, here, Vector3::Zero()}}}, last{{{3, there, Vector3::Zero()}}};
  EXPECT_NEAR(After(first)[4].linear.dot(there), After(last)[1].linear.dot(here), 1e-12);
}

TEST_F(TiesTest, KnowWhoIsTiedToWhom) {
  EXPECT_EQ(ties_.With(2).size(), Row::kCount);
  EXPECT_TRUE(ties_.With(4).empty());
  EXPECT_TRUE(ties_.With(1000).empty());
  EXPECT_TRUE(Ties().With(2).empty());
}

TEST_F(TiesTest, AreDrivenByWhatNothingMovesIfItMoves) {
  EXPECT_FALSE(ties_.IsDriven(2));
  Row led;
  led.bodies[0].angular_velocity = {0, 0, 1};
  Ties ties;
  ASSERT_TRUE(ties.Add(kMembers, led.bodies, led.rows, led.slots));
  EXPECT_TRUE(ties.IsDriven(2));
  EXPECT_FALSE(ties.IsDriven(4));
}

}  // namespace
}  // namespace genphys

#include "core/src/joints/row_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace genphys {
namespace {

// The equations are well posed, so that elimination leaves a few times the rounding of their largest terms.
constexpr double kRounding = 1e-9;
constexpr double kSoftness = 1e-8;

struct Graph {
  std::vector<JointBody> bodies{1};  // the first is the world
  std::vector<uint32_t> body_of;
  std::vector<JointRow> rows;
  std::mt19937 dice{7};

  double Any() { return std::uniform_real_distribution(-1.0, 1.0)(dice); }
  Vector3 AnyVector() { return {Any(), Any(), Any()}; }

  EntityRow Add(double mass) {
    const EntityRow row{static_cast<uint32_t>(body_of.size())};
    body_of.push_back(static_cast<uint32_t>(bodies.size()));
    JointBody& body = bodies.emplace_back();
    body.row = row;
    body.center = 3 * AnyVector();
    body.linear_velocity = AnyVector();
    body.angular_velocity = AnyVector();
    body.inverse_mass = 1 / mass;
    body.inverse_tensor = Vector3(3, 2, 5).asDiagonal();
    body.inverse_tensor /= mass;
    return row;
  }

  void Tie(EntityRow a, EntityRow b, uint8_t block = 1, const Matrix3& axes = Matrix3::Identity()) {
    const Vector3 point = 3 * AnyVector();
    for (int i = 0; i < 3; ++i) {
      rows.push_back({.a = a, .b = b, .axis = axes.col(i), .point = point, .target = Any(), .softness = kSoftness});
    }
    (rows.end() - 3)->block = block;
  }

  void Turn(EntityRow a, EntityRow b, double lower, double upper) {
    rows.push_back({.a = a,
                    .b = b,
                    .kind = JointRow::Kind::kAngular,
                    .axis = AnyVector().normalized(),
                    .target = 5 * Any(),
                    .softness = kSoftness,
                    .lower = lower,
                    .upper = upper});
  }

  bool Solve(RowSolver& solver) {
    std::vector<uint32_t> mine(rows.size());
    std::iota(mine.begin(), mine.end(), 0u);
    return solver.Solve(0, rows, mine, body_of, bodies);
  }

  double RateOf(const JointRow& row) const {
    const auto body = [&](EntityRow r) -> const JointBody& {
      return r == kWorldRow ? bodies[0] : bodies[body_of[Index(r)]];
    };
    const JointBody &a = body(row.a), &b = body(row.b);
    if (row.kind == JointRow::Kind::kLinear) return row.axis.dot(b.VelocityAt(row.point) - a.VelocityAt(row.point));
    if (row.kind == JointRow::Kind::kAngular) return row.axis.dot(b.angular_velocity - a.angular_velocity);
    return row.axis_b.dot(b.angular_velocity) + row.axis.dot(a.angular_velocity);
  }

  // Every row has its rate, or is at a bound that holds it back.
  void ExpectSolved() const {
    for (const JointRow& row : rows) {
      const double lacking = row.target - RateOf(row) - row.softness * row.impulse;
      ASSERT_GE(row.impulse, row.lower - kRounding);
      ASSERT_LE(row.impulse, row.upper + kRounding);
      if (row.impulse > row.lower + kRounding) {
        ASSERT_GE(lacking, -kRounding);
      }
      if (row.impulse < row.upper - kRounding) {
        ASSERT_LE(lacking, kRounding);
      }
    }
  }
};

TEST(RowSolver, GivesEveryRowOfAnyGraphItsRate) {
  RowSolver solver;
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    Graph graph;
    graph.dice.seed(seed);
    std::vector<EntityRow> all{kWorldRow};
    for (int i = 0; i < 12; ++i) {
      const EntityRow body = graph.Add(std::exp(3 * graph.Any()));
      graph.Tie(all[graph.dice() % all.size()], body);
      all.push_back(body);
      if (graph.Any() > 0)
        graph.Turn(all[graph.dice() % (all.size() - 1)], body, -JointRow::kUnbounded, JointRow::kUnbounded);
    }
    ASSERT_TRUE(graph.Solve(solver));
    graph.ExpectSolved();
  }
}

TEST(RowSolver, GivesBlocksTheirRates) {
  RowSolver solver;
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    Graph graph;
    graph.dice.seed(seed);
    std::vector<EntityRow> all{kWorldRow};
    for (int i = 0; i < 12; ++i) {
      const EntityRow body = graph.Add(std::exp(3 * graph.Any()));
      // Along the axes of the world or askew, alone between its bodies or with a row more, in a ring or not.
      const bool is_askew = graph.Any() > 0.5;
      const Vector3 turn = graph.AnyVector();
      const Matrix3 axes = Quaternion(Eigen::AngleAxisd(turn.norm(), turn.normalized())).toRotationMatrix();
      graph.Tie(all[graph.dice() % all.size()], body, 3, is_askew ? axes : Matrix3(Matrix3::Identity()));
      if (graph.Any() > 0) graph.Turn(graph.rows.back().a, body, -0.1, 0.1);
      if (graph.Any() > 0 && i > 2) {
        graph.Tie(body, all[1], 3);
        // Two of them between the same bodies say one thing twice.
        for (size_t k = graph.rows.size() - 3; k < graph.rows.size(); ++k) graph.rows[k].softness = 0.1;
      }
      all.push_back(body);
    }
    ASSERT_TRUE(graph.Solve(solver));
    graph.ExpectSolved();
  }
}

TEST(RowSolver, FindsWhichRowsAreAtTheirBounds) {
  RowSolver solver;
  int at_bounds = 0, inside = 0;
  for (uint32_t seed = 1; seed <= 200; ++seed) {
    Graph graph;
    graph.dice.seed(seed);
    EntityRow above = kWorldRow;
    for (int i = 0; i < 8; ++i) {
      const EntityRow body = graph.Add(1);
      graph.Tie(above, body);
      for (int k = 0; k < 2; ++k) {
        const double bound = 0.2 * std::abs(graph.Any());
        const bool is_motor = graph.Any() > 0;
        graph.Turn(above, body, is_motor ? -bound : 0, is_motor ? bound : JointRow::kUnbounded);
      }
      above = body;
    }
    ASSERT_TRUE(graph.Solve(solver));
    graph.ExpectSolved();
    for (const JointRow& row : graph.rows) {
      if (std::isinf(row.upper) && std::isinf(row.lower)) continue;
      const bool is_bound = row.impulse == row.lower || row.impulse == row.upper;
      ++(is_bound ? at_bounds : inside);
    }
  }
  EXPECT_GT(at_bounds, 100);
  EXPECT_GT(inside, 100);
}

TEST(RowSolver, ConservesMomentumBetweenWhatItPushes) {
  RowSolver solver;
  Graph graph;
  const EntityRow a = graph.Add(2), b = graph.Add(0.5);
  graph.Tie(a, b);
  const auto momentum = [&] {
    return Vector3(2 * graph.bodies[1].linear_velocity + graph.bodies[2].linear_velocity / 2);
  };
  const Vector3 before = momentum();
  ASSERT_TRUE(graph.Solve(solver));
  EXPECT_LE((momentum() - before).norm(), kRounding);
}

TEST(RowSolver, LeavesWhatCannotBeMovedAsItIs) {
  RowSolver solver;
  Graph graph;
  const EntityRow driven = graph.Add(1), pulled = graph.Add(1);
  graph.bodies[1].inverse_mass = 0;
  graph.bodies[1].inverse_tensor.setZero();
  const Vector3 velocity = graph.bodies[1].linear_velocity;
  graph.Tie(driven, pulled);
  ASSERT_TRUE(graph.Solve(solver));
  graph.ExpectSolved();
  EXPECT_EQ(graph.bodies[1].linear_velocity, velocity);
}

TEST(RowSolver, LeavesNumbersThatDoNotSuffice) {
  RowSolver solver;
  Graph graph;
  const EntityRow body = graph.Add(1);
  graph.Tie(kWorldRow, body);
  graph.rows[0].target = std::nan("");
  const Vector3 velocity = graph.bodies[1].linear_velocity;
  EXPECT_FALSE(graph.Solve(solver));
  EXPECT_EQ(graph.bodies[1].linear_velocity, velocity);
  graph.rows[0].target = 0;
  EXPECT_TRUE(graph.Solve(solver));
}

std::vector<RowPlan::Group> Chain(uint32_t count) {
  std::vector<RowPlan::Group> groups{{3, {RowPlan::kStill, 0}}};
  for (uint32_t i = 1; i < count; ++i) groups.push_back({3, {i - 1, i}});
  return groups;
}

TEST(RowPlan, OfAChainIsAsLongAsTheChain) {
  RowPlan plan;
  for (const uint32_t count : {1u, 2u, 100u, 2000u}) {
    ASSERT_TRUE(plan.Make(Chain(count)));
    EXPECT_EQ(plan.value_count(), 9 * (2 * count - 1));
    EXPECT_EQ(plan.order().size(), count);
  }
}

TEST(RowPlan, EliminatesTheTipsOfAStarFirst) {
  // Ten arms of two joints each around body 0.
  std::vector<RowPlan::Group> groups;
  for (uint32_t arm = 0; arm < 10; ++arm) {
    groups.push_back({3, {0, 1 + 2 * arm}});
    groups.push_back({3, {1 + 2 * arm, 2 + 2 * arm}});
  }
  RowPlan plan;
  ASSERT_TRUE(plan.Make(groups));
  for (size_t i = 0; i < 10; ++i) EXPECT_EQ(plan.order()[i] % 2, 1u) << i;
}

TEST(RowPlan, RefusesWhatTakesTooLong) {
  const auto hub = [](uint32_t arms) {
    std::vector<RowPlan::Group> groups;
    for (uint32_t arm = 1; arm <= arms; ++arm) groups.push_back({3, {0, arm}});
    return groups;
  };
  RowPlan plan;
  EXPECT_TRUE(plan.Make(hub(90)));
  EXPECT_FALSE(plan.Make(hub(120)));
  EXPECT_FALSE(plan.Make(hub(120)));
  EXPECT_TRUE(plan.Make(hub(90)));
}

}  // namespace
}  // namespace genphys

#include "genphys/contact_sweeps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace genphys {
namespace {

constexpr double kStep = 0.01, kPull = 9.81;
constexpr double kMass = 2;
constexpr double kRounding = 1e-12;

SweptBody BodyAt(const Vector3& velocity) {
  return {.is_dynamic = true,
          .inverse_mass = 1 / kMass,
          .inverse_tensor = Matrix3::Identity(),
          .linear_velocity = velocity};
}

// For what sweeps bring to an end before an engine is asked for anything.
struct NobodyAsked : BoundedSolver {
  bool Solve(const Eigen::MatrixXd&, const Eigen::VectorXd&, std::span<const Bounds>, Eigen::VectorXd&) override {
    ADD_FAILURE() << "asked for";
    return false;
  }
};

// One body on the fixed floor, which it touches below its centre.
struct OnFloor {
  SweptBody Solve(const SweptBody& body, BoundedSolver* direct = nullptr) {
    sweeps.Begin(kStep, kPull, true);
    const uint32_t number = sweeps.AddBody(body);
    point.relative_velocity = body.linear_velocity;
    sweeps.AddPair(ContactSweeps::kFixed, number, pair, {&point, 1}, {&impulse, 1});
    if (direct == nullptr) {
      sweeps.Solve();
    } else {
      EXPECT_TRUE(sweeps.SolveDirectly(direct, false));
    }
    return sweeps.body(number);
  }

  ContactSweeps sweeps;
  ContactPair pair;
  ContactPoint point;
  PointImpulse impulse;
};

// All at once contacts give way by 1e-7 of what they are.
TEST(ContactSweeps, StopWhatFallsOnTheFloorInSweepsAndAllAtOnce) {
  NobodyAsked nobody;
  for (BoundedSolver* const direct : {static_cast<BoundedSolver*>(nullptr), static_cast<BoundedSolver*>(&nobody)}) {
    OnFloor scene;
    const double allowed = direct != nullptr ? 1e-6 : kRounding;
    EXPECT_LE(scene.Solve(BodyAt({0, 0, -3}), direct).linear_velocity.norm(), allowed);
    EXPECT_NEAR(scene.point.normal_impulse, 3 * kMass, allowed);
    EXPECT_NEAR(scene.impulse.normal, 3 * kMass, allowed);
  }
}

TEST(ContactSweeps, LetGoWhatLeaves) {
  OnFloor scene;
  scene.impulse.normal = 5;  // of a guess that was wrong
  EXPECT_NEAR(scene.Solve(BodyAt({0, 0, 3})).linear_velocity.z(), 3, kRounding);
  EXPECT_EQ(scene.point.normal_impulse, 0);
}

TEST(ContactSweeps, CloseAGapAndNoMore) {
  OnFloor scene;
  scene.point.depth = -0.001;
  EXPECT_NEAR(scene.Solve(BodyAt({0, 0, -3})).linear_velocity.z(), -0.001 / kStep, kRounding);
}

TEST(ContactSweeps, TakeAnOverlapAwayByAMoveThatLeavesNoSpeed) {
  OnFloor scene;
  scene.point.depth = 0.001;
  const SweptBody body = scene.Solve(BodyAt({0, 0, -3}));
  EXPECT_LE(body.linear_velocity.norm(), kRounding);
  EXPECT_GT(body.push.z() * kStep, 1e-4);
  EXPECT_LE(body.push.z() * kStep, 0.001);
}

// The friction of a point is in a circle: its force is the same whatever way it slides.
TEST(ContactSweeps, BrakeASlideAlikeInEveryDirection) {
  for (const double heading : {0.0, 0.3, 0.785, 2.0}) {
    OnFloor scene;
    scene.point.friction = 0.5;
    const Vector3 along(std::cos(heading), std::sin(heading), 0);
    const SweptBody body = scene.Solve(BodyAt(4 * along - Vector3(0, 0, 0.1)));
    EXPECT_LE((body.linear_velocity - (4 - 0.5 * 0.1) * along).norm(), kRounding) << heading;
  }
}

// The speed at which the quickest of a pile falls on, of bodies on top of each other that fell for a step.
double SpeedInPile(uint32_t iterations, bool may_go_on) {
  constexpr size_t kHigh = 6;
  ContactSweeps sweeps;
  sweeps.SetIterations(iterations, may_go_on);
  sweeps.Begin(kStep, kPull, true);
  const ContactPair pair;
  std::vector<ContactPoint> points(kHigh);
  std::vector<PointImpulse> impulses(kHigh);
  uint32_t below = ContactSweeps::kFixed;
  for (size_t i = 0; i < kHigh; ++i) {
    const uint32_t body = sweeps.AddBody(BodyAt({0, 0, -kPull * kStep}));
    sweeps.AddPair(below, body, pair, {&points[i], 1}, {&impulses[i], 1});
    below = body;
  }
  sweeps.Solve();
  double speed = 0;
  for (uint32_t i = 1; i <= kHigh; ++i) speed = std::max(speed, sweeps.body(i).linear_velocity.norm());
  return speed;
}

TEST(ContactSweeps, AreNoMoreThanWereAskedFor) {
  constexpr uint32_t kPreset = ContactSweeps::kPresetIterations;
  const double ten = SpeedInPile(kPreset, false);
  EXPECT_GT(ten, 1e-3);
  EXPECT_GT(SpeedInPile(kPreset - 1, false), ten);
  EXPECT_LT(SpeedInPile(kPreset + 1, false), ten);
  EXPECT_LT(SpeedInPile(kPreset, true), ten / 10) << "of a preset few get more";
}

TEST(ContactSweeps, MoveNothingThatIsNotDynamic) {
  OnFloor scene;
  SweptBody driven = BodyAt({0, 0, 1});
  driven.is_dynamic = false;
  driven.inverse_mass = 0;
  driven.inverse_tensor.setZero();
  scene.sweeps.Begin(kStep, kPull, true);
  const uint32_t below = scene.sweeps.AddBody(driven), above = scene.sweeps.AddBody(BodyAt({0, 0, -1}));
  scene.sweeps.AddPair(below, above, scene.pair, {&scene.point, 1}, {&scene.impulse, 1});
  scene.sweeps.Solve();
  EXPECT_EQ(scene.sweeps.body(below).linear_velocity, Vector3(0, 0, 1));
  EXPECT_NEAR(scene.sweeps.body(above).linear_velocity.z(), 1, kRounding);
}

TEST(ContactSweeps, SolveRowsOfJointsTogetherWithContacts) {
  OnFloor scene;
  JointRow row{.axis = Vector3::UnitX()};
  row.target = 0.25;
  scene.sweeps.Begin(kStep, kPull, false);
  const uint32_t number = scene.sweeps.AddBody(BodyAt({1, 0, -1}));
  scene.sweeps.AddPair(ContactSweeps::kFixed, number, scene.pair, {&scene.point, 1}, {&scene.impulse, 1});
  scene.sweeps.AddRow(ContactSweeps::kFixed, number, row);
  scene.sweeps.Solve();
  EXPECT_NEAR(scene.sweeps.body(number).linear_velocity.x(), 0.25, kRounding);
  EXPECT_NEAR(scene.sweeps.body(number).linear_velocity.z(), 0, kRounding);
  EXPECT_NEAR(row.impulse, -0.75 * kMass, kRounding);
}

TEST(MovedBy, TurnsAboutTheCentreOfMassHoweverFast) {
  const Vector3 center(0.3, 0, 0);
  SweptBody body;
  body.angular_velocity = Vector3(0, 0, 3 / kStep);
  const Pose moved = MovedBy(body, kStep, center, Pose{});
  EXPECT_LE((moved.Transform(center) - center).norm(), kRounding);
  EXPECT_NEAR(Eigen::AngleAxisd(moved.orientation).angle(), 3, kRounding);
}

}  // namespace
}  // namespace genphys

// What lands while springs and dampers of joints hold others to it: these go on from the blow by the rates that they
// have since. Of second order, like all that joints do.
#include <algorithm>
#include <cmath>
#include <functional>

#include "conformance/engine_test.h"
#include "support/course.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsLanding, Claim::kContacts, Claim::kJointSlider);

constexpr double kGravity = 9.81, kRadius = 0.1, kLength = 0.5, kMass = 1, kHeavy = 50, kTime = 0.4;

// A ball falls `height`, with another one on a slider above it that `axis` holds. How far the upper one is at most from
// where it should be, m, once the lower one lies.
double ErrorOf(World& world, double height, const JointAxis& axis, const std::function<double(double, double)>& law) {
  EntityDesc below = Ball({0, 0, height + kRadius}, kRadius, kHeavy);
  below.rigid_body->geometries[0].material.restitution = 0;
  const EntityId lower = Add(world, below);
  const EntityId upper = Add(world, Ball({0, 0, height + kRadius + kLength}, kRadius, kMass));
  Join(world, Between(lower, upper, SliderJoint{axis}));
  const double landed = std::sqrt(2 * height / kGravity), h = SubstepOf(world);
  double stretch = 0, rate = -kGravity * landed, since = landed, most = 0;
  for (int i = 1; i * h < kTime; ++i) {
    Steps(world, 1);
    if (i * h <= landed) continue;
    std::tie(stretch, rate) = CourseOf(stretch, rate, i * h - since, 20, law);
    since = i * h;
    most = std::max(most, std::abs(PositionOf(world, upper).z() - kRadius - kLength - stretch));
  }
  return most;
}

// Springs that are solved for as these are make a swing of w = 20 rad/s longer by (w h)^2 / 12, which moves 0.15 m by
// 25 m/s^2 times the square of the step while it goes through 5 rad. A blow between two steps gives as much again.
constexpr double kMost = 50;

void ExpectSecondOrder(const std::string& engine, const JointAxis& axis,
                       const std::function<double(double, double)>& law) {
  for (const int rate : {60, 240, 960}) {
    for (int i = 0; i < 10; ++i) {
      WorldDesc desc;
      desc.engine = engine;
      desc.gravity = {0, 0, -kGravity};
      desc.stepper = {.step_size = 1.0 / rate, .substeps = 1};
      const auto world = MakeWorld(desc);
      EXPECT_LE(ErrorOf(*world, 0.2 + 0.0137 * i, axis, law), kMost / rate / rate) << i << " at " << rate;
    }
  }
}

double LawOf(double stiffness, double damping, double stretch, double rate) {
  return -kGravity - (stiffness * stretch + damping * rate) / kMass;
}

TEST_P(JointsLanding, ADamperBrakesFromTheBlowOn) {
  Proves({Claim::kJointSpring});
  constexpr double kStiffness = 400;
  for (const double damping : {0.0, 4.0, 20.0, 40.0}) {
    SCOPED_TRACE(damping);
    const JointAxis axis{.limits = {}, .motor = {}, .spring = Spring{.stiffness = kStiffness, .damping = damping}};
    ExpectSecondOrder(GetParam(), axis,
                      [=](double stretch, double rate) { return LawOf(kStiffness, damping, stretch, rate); });
  }
}

TEST_P(JointsLanding, AServoBrakesFromTheBlowOnWithNoMoreThanItMay) {
  Proves({Claim::kJointMotor});
  constexpr double kStiffness = 400, kDamping = 20;
  for (const double most : {1e4, 30.0}) {
    SCOPED_TRACE(most);
    const Motor motor{.target_position = 0, .stiffness = kStiffness, .damping = kDamping, .force_max = most};
    ExpectSecondOrder(GetParam(), {.limits = {}, .motor = motor, .spring = {}}, [=](double stretch, double rate) {
      return -kGravity - std::clamp(kStiffness * stretch + kDamping * rate, -most, most) / kMass;
    });
  }
}

}  // namespace
}  // namespace genphys::testing

// Motors to positions that push with all they may, in an arm whose links pull at each other, told anew for each step.
// Of second order, as what has enough, and never more than that.
#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "conformance/engine_test.h"
#include "support/course.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsSpent, Claim::kJointMotor);

using Vector2 = Eigen::Vector2d;

constexpr double kGravity = 9.81, kHalf = 0.05, kTime = 0.5;
constexpr double kEnough = 1e4;  // N*m
// rad/s^2, the error by the square of the step: measured are 55 at most, with enough and with less, and at any step.
constexpr double kBend = 80;

/// Two rods that hang one on the other and turn about -y, by angles from straight down.
struct Rod {
  double mass, length;
  double lever() const { return length / 2; }
  double moment() const { return mass / 12 * (length * length + 4 * kHalf * kHalf) + mass * lever() * lever(); }
  static Vector2 Along(double angle) { return {std::sin(angle), -std::cos(angle)}; }
};
constexpr Rod kUpper{2, 0.5}, kLower{1.5, 0.4};
const Vector2 kStart(0.9, 0.4);  // rad

/// Of both hinges; the second counts from the first rod.
struct Servos {
  Vector2 stiffness{60, 20}, damping{6, 1.5}, most;

  Vector2 Torques(const Vector2& turns, const Vector2& rates, const Vector2& aims) const {
    const Vector2 wanted = stiffness.cwiseProduct(aims - turns) - damping.cwiseProduct(rates);
    return wanted.cwiseMax(-most).cwiseMin(most);
  }
};

Vector2 Relative(const Vector2& angles) { return {angles[0], angles[1] - angles[0]}; }

// Of Lagrange's equations in both angles.
Vector2 Acceleration(const Servos& servos, const Vector2& angles, const Vector2& rates, const Vector2& aims) {
  const double both = kLower.mass * kUpper.length * kLower.lever();
  const double across = both * std::cos(angles[0] - angles[1]), round = both * std::sin(angles[0] - angles[1]);
  Eigen::Matrix2d mass;
  mass << kUpper.moment() + kLower.mass * kUpper.length * kUpper.length, across, across, kLower.moment();
  const Vector2 torques = servos.Torques(Relative(angles), Relative(rates), aims);
  const double weight = kUpper.mass * kUpper.lever() + kLower.mass * kUpper.length;
  return mass.inverse() *
         Vector2(
             torques[0] - torques[1] - round * rates[1] * rates[1] - weight * kGravity * std::sin(angles[0]),
             torques[1] + round * rates[0] * rates[0] - kLower.mass * kLower.lever() * kGravity * std::sin(angles[1]));
}

EntityDesc Hung(const Rod& rod, const Vector2& top, double angle) {
  const Vector2 center = top + rod.lever() * Rod::Along(angle);
  EntityDesc desc = Body(Box{{kHalf, kHalf, rod.lever()}}, {center.x(), 0, center.y()}, rod.mass);
  desc.pose.orientation = Quaternion(Eigen::AngleAxisd(-angle, Vector3::UnitY()));
  return desc;
}

using MakeJoint = JointKind (*)(const Motor& motor);

JointKind Hinged(const Motor& motor) { return HingeJoint{.axis = {.limits = {}, .motor = motor, .spring = {}}}; }

JointKind OfSixTurns(const Motor& motor) {
  SixDofJoint joint;
  joint.about[2] = JointAxis{.limits = {}, .motor = motor, .spring = {}};
  return joint;
}

class Arm {
 public:
  Arm(const std::string& engine, int rate, const Servos& servos, MakeJoint make)
      : servos_(servos), h_(1.0 / rate), world_(MakeSpace(engine, {.step_size = h_, .substeps = 1})) {
    const Vector2 elbow = kUpper.length * Rod::Along(kStart[0]);
    const EntityId upper = Add(*world_, Hung(kUpper, Vector2::Zero(), kStart[0]));
    const EntityId lower = Add(*world_, Hung(kLower, elbow, kStart[1]));
    const Quaternion about(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()));
    const auto kind = [&](int i) {
      return make({.target_position = 0,
                   .stiffness = servos.stiffness[i],
                   .damping = servos.damping[i],
                   .force_max = servos.most[i]});
    };
    joints_[0] = Join(*world_, ToWorld(upper, kind(0), {Vector3::Zero(), about}));
    const Quaternion back = world_->state().pose(EntityRow{upper.index()}).orientation.conjugate();
    joints_[1] = Join(*world_, Between(upper, lower, kind(1), {{0, 0, -kUpper.lever()}, back * about}));
  }

  /// rad, the largest error in kTime.
  double Follow() {
    Vector2 angles = kStart, rates = Vector2::Zero();
    double most = 0;
    for (int i = 0; i * h_ < kTime - h_ / 2; ++i) {
      // As joints count them, from how the arm began.
      const Vector2 aims = AimsAt(i * h_), from_start = aims - Relative(kStart);
      Do(*world_,
         SetMotorColumns{
             .ids = {joints_[0], joints_[1]}, .velocities = {0, 0}, .positions = {from_start[0], from_start[1]}});
      Steps(*world_, 1);
      const auto law = [&](const Vector2& place, const Vector2& rate) {
        return Acceleration(servos_, place, rate, aims);
      };
      std::tie(angles, rates) = CourseOf(angles, rates, h_, kParts, law);
      const Vector2 turned = Relative(angles) - Relative(kStart);
      for (int k = 0; k < 2; ++k) {
        const JointState state = StateOf(*world_, joints_[static_cast<size_t>(k)]);
        most = std::max(most, std::abs(state.positions[5] - turned[k]));
        pushed_[k] = std::max(pushed_[k], std::abs(state.torque.y()));
      }
    }
    return most;
  }

  /// N*m, by which each pushed at most.
  const Vector2& pushed() const { return pushed_; }

 private:
  static constexpr int kParts = 16;

  static Vector2 AimsAt(double time) {
    return Relative(kStart) + 1.2 * Vector2(std::sin(2 * time + 1), std::sin(3 * time + 2));
  }

  Servos servos_;
  double h_;
  std::unique_ptr<World> world_;
  std::array<JointId, 2> joints_;
  Vector2 pushed_ = Vector2::Zero();
};

void ExpectSecondOrder(const std::string& engine, MakeJoint make) {
  for (const Vector2& most : {Vector2(kEnough, kEnough), Vector2(kEnough, 2.5), Vector2(9, 2.5), Vector2(9, kEnough)}) {
    SCOPED_TRACE(::testing::Message() << most[0] << " and " << most[1] << " N*m");
    const Servos servos{.most = most};
    for (const int rate : {120, 240, 480, 960}) {
      Arm arm(engine, rate, servos, make);
      EXPECT_LT(arm.Follow(), kBend / rate / rate) << rate << " steps per second";
      for (int k = 0; k < 2; ++k) {
        EXPECT_LE(arm.pushed()[k], (1 + 1e-9) * most[k]) << rate;
        // All of it was needed.
        EXPECT_GE(arm.pushed()[k], most[k] < kEnough ? (1 - 1e-9) * most[k] : 0) << rate;
      }
    }
  }
}

TEST_P(JointsSpent, ServosOnHingesFollowTheirLawInSecondOrder) {
  Proves({Claim::kJointHinge});
  ExpectSecondOrder(GetParam(), Hinged);
}

TEST_P(JointsSpent, ServosOfSixDegreesFollowTheirLawInSecondOrder) {
  Proves({Claim::kJointSixDof});
  ExpectSecondOrder(GetParam(), OfSixTurns);
}

// A solve acts from before the boundary on, and would tell half of it.
TEST_P(JointsSpent, AServoTellsWhatItGivesSinceItWasToldOtherwise) {
  Proves({Claim::kJointSlider});
  constexpr double kStiffness = 30, kAim = 0.2, kHeavy = 1000;
  for (const double most : {4.0, 10.0}) {
    const auto world = MakeSpace(GetParam(), {.substeps = 1}, Vector3::Zero());
    const EntityId body = Add(*world, Ball(Vector3::Zero(), 0.5, kHeavy));
    const Motor motor{.target_position = 0, .stiffness = kStiffness, .force_max = most};
    const JointId joint = Join(*world, ToWorld(body, SliderJoint{{.limits = {}, .motor = motor, .spring = {}}}));
    Steps(*world, 2);
    Do(*world, SetMotorColumns{.ids = {joint}, .velocities = {0}, .positions = {kAim}});
    Steps(*world, 1);
    // It hardly moves in a step.
    EXPECT_NEAR(StateOf(*world, joint).force.z(), std::min(kStiffness * kAim, most), 1e-4);
  }
}

// Whatever acts on what they drive, and whatever they are told.
TEST_P(JointsSpent, MotorsAreToldToPushWithNoMoreThanTheyMay) {
  Proves({Claim::kJointHinge, Claim::kJointSlider});
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = random.LogUniform(1e-3, 1.0 / 60), .substeps = 1});
    const double most = random.LogUniform(1, 50);
    Motor motor{.target_velocity = random.Uniform(-2, 2), .force_max = most};
    const bool is_servo = random.Chance(0.5), is_hinge = random.Chance(0.5), is_told = random.Chance(0.5);
    if (is_servo) {
      motor.target_position = 0;
      motor.stiffness = random.LogUniform(10, 1000);
      motor.damping = random.LogUniform(0.1, 20);
    }
    const EntityId body = Add(*world, Body(Box{{0.2, 0.1, 0.1}}, {0.3, 0, 0}));
    const JointAxis axis{.limits = {}, .motor = motor, .spring = {}};
    const JointKind kind = is_hinge ? JointKind(HingeJoint{axis}) : JointKind(SliderJoint{axis});
    const JointId joint = Join(*world, ToWorld(body, kind, FrameAlong(Vector3::UnitY())));
    for (int i = 0; i < 100; ++i) {
      if (is_told) {
        const std::vector<double> aim = is_servo ? std::vector{random.Uniform(-1, 1)} : std::vector<double>{};
        Do(*world, SetMotorColumns{.ids = {joint}, .velocities = {random.Uniform(-2, 2)}, .positions = aim});
      }
      Do(*world, ApplyForce{.id = body, .force = 3 * most * random.Direction()});
      Steps(*world, 1);
      const JointState state = StateOf(*world, joint);
      EXPECT_LE(std::abs(is_hinge ? state.torque.y() : state.force.y()), (1 + 1e-6) * most) << "step " << i;
    }
  }
}

}  // namespace
}  // namespace genphys::testing

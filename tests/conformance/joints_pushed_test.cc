// What joints hold, under forces that are told anew for each step, as controllers do: each stays as it is for its step
// and jumps to the next one. Of second order, whatever the number of substeps, and so is the velocity that is shown.
#include <cmath>
#include <functional>
#include <numbers>
#include <tuple>

#include "conformance/engine_test.h"
#include "support/course.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsPushed, Claim::kJointHinge, Claim::kJointSlider);

using Vector2 = Eigen::Vector2d;

constexpr double kGravity = 9.81;
// A hinge about y; angles count from x on downwards.
const Quaternion kAboutY(Eigen::AngleAxisd(-std::numbers::pi / 2, Vector3::UnitX()));
const Quaternion kAlongX(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitY()));

/// Coordinates and their rates under a push that stays as it is.
struct Course {
  Vector2 place = Vector2::Zero(), rate = Vector2::Zero();
  using Law = std::function<Vector2(const Vector2& place, const Vector2& rate, double push)>;

  void Advance(const Law& law, double push, double time) {
    constexpr int kParts = 50;
    const auto at = [&](const auto& here, const auto& speed) { return law(here, speed, push); };
    std::tie(place, rate) = CourseOf(place, rate, time, kParts, at);
  }
};

/// The largest errors at the ends of steps, rad and rad/s.
struct Errors {
  double angle = 0, rate = 0;

  void Note(double of_angle, double of_rate) {
    angle = std::max(angle, std::abs(of_angle));
    rate = std::max(rate, std::abs(of_rate));
  }
};

StepperDesc StepsOf(int rate, uint32_t substeps) {
  StepperDesc stepper;
  stepper.step_size = 1.0 / rate;
  stepper.substeps = substeps;
  return stepper;
}

using PushAt = std::function<double(int step, double time)>;

// Of a ball on a hinge for a second, under a torque.
Errors Pendulum(const std::string& engine, const StepperDesc& stepper, const PushAt& torque_at) {
  constexpr double kArm = 0.5, kMass = 1;
  const auto world = MakeSpace(engine, stepper);
  const EntityId ball = Add(*world, Body(Sphere{kArm}, {kArm, 0, 0}, kMass));
  Join(*world, ToWorld(ball, HingeJoint{}, {Vector3::Zero(), kAboutY}));
  const double moment = (1 + 0.4) * kMass * kArm * kArm;
  const Course::Law law = [=](const Vector2& place, const Vector2&, double torque) -> Vector2 {
    return {(kMass * kGravity * kArm * std::cos(place[0]) + torque) / moment, 0};
  };
  Course course;
  Errors errors;
  const double h = stepper.step_size;
  for (int i = 0; i * h < 1 - h / 2; ++i) {
    const double torque = torque_at(i, i * h);
    Do(*world, ApplyForce{.id = ball, .torque = {0, torque, 0}});
    Steps(*world, 1);
    course.Advance(law, torque, h);
    const Vector3 at = PositionOf(*world, ball);
    const double rate = world->state().angular_velocities(1, ball.index());
    errors.Note(std::remainder(std::atan2(-at.z(), at.x()) - course.place[0], 2 * std::numbers::pi),
                rate - course.rate[0]);
  }
  return errors;
}

// Of the pole that stands on a cart, while that is pushed for so many seconds.
Errors CartPole(const std::string& engine, const StepperDesc& stepper, const PushAt& push_at, double time = 0.5) {
  constexpr double kCart = 1, kPole = 0.1, kHalf = 0.5, kMoment = kPole * kHalf * kHalf / 3;
  const auto world = MakeSpace(engine, stepper);
  const EntityId cart = Add(*world, Body(Box{{0.2, 0.1, 0.1}}, Vector3::Zero(), kCart));
  EntityDesc standing = Body(Box{{0.02, 0.02, kHalf}}, {0, 0, kHalf}, kPole);
  standing.rigid_body->inertia.tensor = Vector3(kMoment, kMoment, 1e-5).asDiagonal();
  const EntityId pole = Add(*world, standing);
  Join(*world, ToWorld(cart, SliderJoint{}, {Vector3::Zero(), kAlongX}));
  Join(*world, Between(cart, pole, HingeJoint{}, {Vector3::Zero(), kAboutY}));
  // x of the cart, and the angle of the pole from above.
  const Course::Law law = [=](const Vector2& place, const Vector2& rate, double push) -> Vector2 {
    const double across = kPole * kHalf * std::cos(place[1]), lever = kPole * kHalf * std::sin(place[1]);
    const Eigen::Matrix2d mass{{kCart + kPole, across}, {across, kMoment + kPole * kHalf * kHalf}};
    return mass.inverse() * Vector2(push + lever * rate[1] * rate[1], kGravity * lever);
  };
  Course course;
  Errors errors;
  const double h = stepper.step_size;
  for (int i = 0; i * h < time - h / 2; ++i) {
    const double push = push_at(i, i * h);
    Do(*world, ApplyForce{.id = cart, .force = {push, 0, 0}});
    Steps(*world, 1);
    course.Advance(law, push, h);
    const Vector3 along = PositionOf(*world, pole) - PositionOf(*world, cart);
    const double rate = world->state().angular_velocities(1, pole.index());
    errors.Note(std::remainder(std::atan2(along.x(), along.z()) - course.place[1], 2 * std::numbers::pi),
                rate - course.rate[1]);
  }
  return errors;
}

double Sine(int, double time) { return 4 * std::sin(3 * time); }
double ToAndFro(int step, double) { return step * 7 % 5 < 2 ? 10 : -10; }
double Jump(int, double time) { return time < 0.5 - 1e-9 ? 0 : 4; }

// A fourth of the step is off by a sixteenth, or nearly. What one substep is off by at 60 steps per second, rad and
// rad/s, halves at least with each one more.
void ExpectSecondOrder(const std::string& engine, const PushAt& torque_at, const Errors& most) {
  for (const uint32_t substeps : {1, 2, 4}) {
    const Errors slow = Pendulum(engine, StepsOf(60, substeps), torque_at);
    const Errors fast = Pendulum(engine, StepsOf(240, substeps), torque_at);
    EXPECT_LT(slow.angle, most.angle / substeps) << substeps;
    EXPECT_LT(fast.angle, slow.angle / 12) << substeps;
    EXPECT_LT(slow.rate, most.rate / substeps) << substeps;
    EXPECT_LT(fast.rate, slow.rate / 10) << substeps;
  }
}

TEST_P(JointsPushed, ATorqueThatIsToldAnewForEachStepIsMetInSecondOrder) {
  ExpectSecondOrder(GetParam(), Sine, {.angle = 0.02, .rate = 0.1});
}

TEST_P(JointsPushed, AJumpIsMetInSecondOrderAndSoIsTheVelocityThatIsShown) {
  ExpectSecondOrder(GetParam(), Jump, {.angle = 0.005, .rate = 0.03});
}

// Its moments are 830 to 1: what its fall tilts it by would spin it about its long axis, and that tilt it again.
TEST_P(JointsPushed, APoleThatFallsFastDoesNotWhirlAboutItsLongAxis) {
  const auto steady = [](int, double) { return 5.0; };
  const Errors slow = CartPole(GetParam(), StepsOf(50, 2), steady, 1);
  EXPECT_LT(slow.angle, 0.01);
  EXPECT_LT(CartPole(GetParam(), StepsOf(200, 2), steady, 1).angle, slow.angle / 12);
}

TEST_P(JointsPushed, ACartThatIsPushedToAndFroMovesItsPoleAsItsEquationsSay) {
  for (const uint32_t substeps : {1, 2}) {
    const Errors slow = CartPole(GetParam(), StepsOf(50, substeps), ToAndFro);
    EXPECT_LT(slow.angle, 2e-3 / substeps) << substeps;
    const Errors steady = CartPole(GetParam(), StepsOf(200, substeps), [](int, double time) { return Sine(0, time); });
    EXPECT_LT(steady.angle, 1e-4 / substeps) << substeps;
  }
}

}  // namespace
}  // namespace genphys::testing

// Motors and springs whose aims are told anew for each step, as controllers do: each stays as it is for its step and
// jumps to the next one. Of second order, whatever the number of substeps.
#include <cmath>
#include <functional>
#include <numbers>
#include <tuple>

#include "conformance/engine_test.h"
#include "support/course.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsTold, Claim::kJointHinge, Claim::kJointSlider, Claim::kJointSixDof, Claim::kJointMotor,
                     Claim::kJointSpring, Claim::kJointChange);

constexpr double kGravity = 9.81;
constexpr double kStiffness = 30, kDamping = 3, kMass = 1, kArm = 0.5;
constexpr double kMoment = (1 + 0.4) * kMass * kArm * kArm;
constexpr double kSwing = 1;  // rad and m, of aims

/// A coordinate and its rate.
struct Course {
  double place = 0, rate = 0;
  using Law = std::function<double(double place, double rate, double aim)>;

  void Advance(const Law& law, double aim, double time) {
    constexpr int kParts = 50;
    const auto at = [&](const auto& here, const auto& speed) { return law(here, speed, aim); };
    std::tie(place, rate) = CourseOf(place, rate, time, kParts, at);
  }
};

/// What is driven, how it is told, where it is, and by which law it goes.
struct Machine {
  std::unique_ptr<World> world;
  std::function<void(double aim)> tell;
  std::function<Course()> now;
  Course::Law law;
};

// A ball on a hinge about y that falls unless its motor holds it. Angles count from x on downwards.
Machine Arm(const std::string& engine, const StepperDesc& stepper) {
  const Quaternion about_y(Eigen::AngleAxisd(-std::numbers::pi / 2, Vector3::UnitX()));
  Machine arm{.world = MakeSpace(engine, stepper), .tell = {}, .now = {}, .law = {}};
  World& world = *arm.world;
  const EntityId ball = Add(world, Body(Sphere{kArm}, {kArm, 0, 0}, kMass));
  const Motor motor{.target_position = 0, .stiffness = kStiffness, .damping = kDamping};
  const HingeJoint hinge{.axis = {.limits = {}, .motor = motor, .spring = {}}};
  const JointId joint = Join(world, ToWorld(ball, hinge, {Vector3::Zero(), about_y}));
  arm.tell = [&world, joint](double aim) {
    Do(world, SetMotorColumns{.ids = {joint}, .velocities = {0}, .positions = {aim}});
  };
  arm.now = [&world, ball] {
    const Vector3 at = PositionOf(world, ball);
    return Course{std::atan2(-at.z(), at.x()), world.state().angular_velocities(1, ball.index())};
  };
  arm.law = [](double place, double rate, double aim) {
    return (kMass * kGravity * kArm * std::cos(place) + kStiffness * (aim - place) - kDamping * rate) / kMoment;
  };
  return arm;
}

double LinearLaw(double place, double rate, double aim) {
  return (kStiffness * (aim - place) - kDamping * rate) / kMass;
}

// A ball on a rail along z, whose spring is told another rest.
Machine Rail(const std::string& engine, const StepperDesc& stepper) {
  Machine rail{.world = MakeSpace(engine, stepper, Vector3::Zero()), .tell = {}, .now = {}, .law = LinearLaw};
  World& world = *rail.world;
  const EntityId ball = Add(world, Body(Sphere{0.2}, Vector3::Zero(), kMass));
  const auto resting_at = [](double rest) {
    return SliderJoint{.axis = {.limits = {}, .motor = {}, .spring = Spring{kStiffness, kDamping, rest}}};
  };
  const JointId joint = Join(world, ToWorld(ball, resting_at(0)));
  rail.tell = [&world, joint, resting_at](double aim) {
    Do(world,
       UpdateJoint{
           .id = joint, .joint = {.kind = resting_at(aim)}, .fields = {static_cast<uint32_t>(JointField::kSpring)}});
  };
  rail.now = [&world, ball] { return Course{PositionOf(world, ball).z(), VelocityOf(world, ball).z()}; };
  return rail;
}

// A ball that springs hold to a frame, which is led along z.
Machine Lead(const std::string& engine, const StepperDesc& stepper) {
  Machine lead{.world = MakeSpace(engine, stepper, Vector3::Zero()), .tell = {}, .now = {}, .law = LinearLaw};
  World& world = *lead.world;
  const EntityId ball = Add(world, Body(Sphere{0.2}, Vector3::Zero(), kMass));
  SixDofJoint sprung;
  for (auto* const axes : {&sprung.along, &sprung.about}) {
    axes->fill(JointAxis{.limits = {}, .motor = {}, .spring = Spring{kStiffness, kDamping, 0}});
  }
  const JointId joint = Join(world, ToWorld(ball, sprung));
  lead.tell = [&world, joint](double aim) {
    Do(world, UpdateJoint{.id = joint,
                          .joint = {.frame_in_a = Pose{{0, 0, aim}}},
                          .fields = {static_cast<uint32_t>(JointField::kFrameInA)}});
  };
  lead.now = [&world, ball] { return Course{PositionOf(world, ball).z(), VelocityOf(world, ball).z()}; };
  return lead;
}

/// The largest errors at the ends of steps within a second, rad or m, and of rates.
struct Errors {
  double place = 0, rate = 0;
};

using AimAt = std::function<double(double time)>;

Errors Follow(const Machine& machine, double h, const AimAt& aim_at) {
  Course course;
  Errors errors;
  for (int i = 0; i * h < 1 - h / 2; ++i) {
    const double aim = aim_at(i * h);
    machine.tell(aim);
    Steps(*machine.world, 1);
    course.Advance(machine.law, aim, h);
    const Course now = machine.now();
    errors.place = std::max(errors.place, std::abs(now.place - course.place));
    errors.rate = std::max(errors.rate, std::abs(now.rate - course.rate));
  }
  return errors;
}

StepperDesc StepsOf(int rate, uint32_t substeps) {
  StepperDesc stepper;
  stepper.step_size = 1.0 / rate;
  stepper.substeps = substeps;
  return stepper;
}

double Sine(double time) { return kSwing * std::sin(3 * time); }
double Jump(double time) { return time < 0.5 - 1e-9 ? 0 : kSwing; }

using Make = Machine (*)(const std::string& engine, const StepperDesc& stepper);

void ExpectSecondOrder(const std::string& engine, Make make, const AimAt& aim_at, double stiffness, double inertia) {
  for (const uint32_t substeps : {1, 2, 4}) {
    SCOPED_TRACE(substeps);
    const Errors slow = Follow(make(engine, StepsOf(60, substeps)), 1.0 / 60, aim_at);
    const Errors fast = Follow(make(engine, StepsOf(240, substeps)), 1.0 / 240, aim_at);
    // The trapezoidal rule makes a period longer by (w h)^2 / 12, within a second that swings by w.
    const double turn = std::sqrt(stiffness / inertia), per_substep = turn / 60 / substeps;
    EXPECT_LT(slow.place, kSwing * turn * per_substep * per_substep / 12);
    EXPECT_LT(fast.place, slow.place / 12);
    EXPECT_LT(slow.rate, kSwing * turn * turn * per_substep * per_substep / 6);
    EXPECT_LT(fast.rate, slow.rate / 10);
  }
}

TEST_P(JointsTold, AMotorThatIsToldAnotherPositionForEachStepGoesThereInSecondOrder) {
  for (const AimAt& aim_at : {AimAt(Sine), AimAt(Jump)}) {
    ExpectSecondOrder(GetParam(), Arm, aim_at, kStiffness, kMoment);
  }
}

TEST_P(JointsTold, ASpringThatIsToldAnotherRestForEachStepPullsThereInSecondOrder) {
  for (const AimAt& aim_at : {AimAt(Sine), AimAt(Jump)}) {
    ExpectSecondOrder(GetParam(), Rail, aim_at, kStiffness, kMass);
  }
}

TEST_P(JointsTold, SpringsWhoseFrameIsLedPullInSecondOrder) {
  for (const AimAt& aim_at : {AimAt(Sine), AimAt(Jump)}) {
    ExpectSecondOrder(GetParam(), Lead, aim_at, kStiffness, kMass);
  }
}

// Whatever they were told between two steps never was, and nothing grows by it.
TEST_P(JointsTold, WhatIsToldOftenBetweenTwoStepsIsToldOnce) {
  for (const Make make : {Arm, Rail, Lead}) {
    const Machine often = make(GetParam(), {}), once = make(GetParam(), {});
    for (const Machine* const each : {&often, &once}) Steps(*each->world, 10);
    for (int i = 0; i < 1000; ++i) often.tell(std::sin(i));
    for (const Machine* const each : {&often, &once}) each->tell(0.3);
    const LayerState& layer = often.world->layer_state();
    EXPECT_LE(layer.former_drives.size() + layer.former_frames.size(), 20u);
    for (const Machine* const each : {&often, &once}) Steps(*each->world, 10);
    EXPECT_EQ(often.now().place, once.now().place);
    EXPECT_EQ(often.now().rate, once.now().rate);
  }
}

}  // namespace
}  // namespace genphys::testing

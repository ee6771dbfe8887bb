// What joints give and bear does not depend on how long the steps are, nor on how much shorter one is than the one
// before it: what a solve gives acts from the middle of the last substep to the middle of the next one.
#include <array>
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsSteps);

constexpr double kGravity = 9.81;

// The sizes of steps, over and over: short ones after long ones, one after another as well.
constexpr double kLongest = 1.0 / 30, kShortest = 1.0 / 1000;
constexpr std::array<double, 6> kSizes{1.0 / 35, 1.0 / 400, kLongest, kShortest, kShortest, 1.0 / 240};

// Calls visit(time) after each of so many steps.
template <typename Visit>
void StepByStep(World& world, int count, Visit&& visit) {
  double time = 0;
  for (int i = 0; i < count; ++i) {
    const double size = kSizes[static_cast<size_t>(i) % kSizes.size()];
    ASSERT_TRUE(world.Step(size).ok());
    time += size;
    visit(time);
  }
}

TEST_P(JointsSteps, LeaveAtRestWhatHangsOnASpring) {
  Proves({Claim::kJointSlider, Claim::kJointSpring});
  constexpr double kStiffness = 50, kMass = 2, kSag = kMass * kGravity / kStiffness;
  for (const double damping : {0.0, 3.0}) {
    const auto world = MakeSpace(GetParam());
    const EntityId weight = Add(*world, Crate({0, 0, -kSag}, 0.1, kMass));
    SliderJoint slider;
    slider.axis.spring = Spring{.stiffness = kStiffness, .damping = damping};
    JointDesc joint = ToWorld(weight, slider);
    joint.frame_in_b = Pose{};
    Join(*world, joint);
    StepByStep(*world, 600, [&](double time) {
      ASSERT_NEAR(PositionOf(*world, weight).z(), -kSag, kDirect * kSag) << "at " << time;
      ASSERT_NEAR(VelocityOf(*world, weight).z(), 0, kDirect * std::sqrt(kGravity * kSag)) << "at " << time;
    });
  }
}

TEST_P(JointsSteps, LeaveAMotorAllOfItsForce) {
  Proves({Claim::kJointSlider, Claim::kJointMotor});
  constexpr double kForce = 3, kMass = 2;
  const auto world = MakeSpace(GetParam(), {}, Vector3::Zero());
  const EntityId cart = Add(*world, Crate({0, 0, 0}, 0.2, kMass));
  SliderJoint slider;
  slider.axis.motor = Motor{.target_velocity = 1000, .force_max = kForce};
  Join(*world, ToWorld(cart, slider));
  StepByStep(*world, 60, [&](double time) {
    const double speed = kForce / kMass * time;
    ASSERT_NEAR(VelocityOf(*world, cart).z(), speed, kDirect * speed) << "at " << time;
  });
}

TEST_P(JointsSteps, BearAWeightWithNoMoreThanThat) {
  Proves({Claim::kJointFixed, Claim::kJointHinge, Claim::kJointBreak});
  constexpr double kWeight = 2 * kGravity;
  // What it sinks in a long substep, by the softness of rows of 1e-8, is made up for in a short one and stopped in the
  // next: as much per square of how much shorter that is.
  constexpr double kPredicted = 1e-8 * (kLongest / kShortest) * (kLongest / kShortest);
  for (const JointKind& kind : {JointKind(FixedJoint{}), JointKind(HingeJoint{})}) {
    const auto world = MakeSpace(GetParam());
    const EntityId weight = Add(*world, Crate({0, 0, 0}, 0.2, 2));
    JointDesc joint = ToWorld(weight, kind);
    joint.break_force = kWeight / 0.99;
    const JointId id = Join(*world, joint);
    StepByStep(*world, 30, [&](double time) {
      ASSERT_FALSE(RefusalOf(world->CheckId(id, ""))) << "broken at " << time;
      ASSERT_NEAR(StateOf(*world, id).force.z(), kWeight, 2 * kPredicted * kWeight) << "at " << time;
    });
  }
}

// Steps became shorter, or substeps did, while it slept and another body went on: what it was owed then is for half a
// long substep, and would press on the joint as that part more than its weight.
TEST_P(JointsSteps, BearNoMoreThanTheWeightOfWhatSleptThroughLongerOnes) {
  Proves({Claim::kJointFixed, Claim::kJointHinge, Claim::kJointBreak, Claim::kSleeping});
  constexpr double kWeight = 2 * kGravity;
  for (const bool is_substep : {false, true}) {
    for (const JointKind& kind : {JointKind(FixedJoint{}), JointKind(HingeJoint{})}) {
      const auto world = testing::MakeWorld(WorldDesc{.engine = GetParam(),
                                                      .gravity = {0, 0, -kGravity},
                                                      .stepper = {.step_size = 1.0 / 60, .substeps = 1},
                                                      .ground_plane = false});
      const EntityId weight = Add(*world, Crate({0, 0, 0}, 0.2, 2));
      EntityDesc other = Crate({5, 0, 0}, 0.2, 2);
      other.rigid_body->auto_disable.enabled = false;
      Join(*world, ToWorld(Add(*world, other), FixedJoint{}));
      JointDesc joint = ToWorld(weight, kind);
      joint.break_force = kWeight / 0.99;
      const JointId id = Join(*world, joint);
      Steps(*world, 60);
      ASSERT_TRUE(Asleep(*world, weight));
      const StepperDesc shorter{.step_size = is_substep ? 1.0 / 60 : 1.0 / 240, .substeps = is_substep ? 4u : 1u};
      Do(*world, SetStepper{shorter});
      Steps(*world, 1);
      ASSERT_TRUE(Asleep(*world, weight));

      Do(*world, ApplyForce{.id = weight});
      ASSERT_FALSE(Asleep(*world, weight));
      for (int i = 0; i < 5; ++i) {
        Steps(*world, 1);
        ASSERT_FALSE(RefusalOf(world->CheckId(id, ""))) << "broken in step " << i;
        ASSERT_NEAR(StateOf(*world, id).force.z(), kWeight, 2 * kDirect * kWeight) << "in step " << i;
        ASSERT_NEAR(PositionOf(*world, weight).z(), 0, kDirect) << "in step " << i;
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

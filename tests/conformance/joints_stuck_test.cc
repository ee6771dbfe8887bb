// Joints that something is in the way of: no impulse brings them together, and nobody is thrown about by the attempt.
#include <algorithm>
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsStuck);

constexpr double kHeight = 0.3;  // m, of the middle of a box that stands on the floor
constexpr double kLength = 0.7;  // m, from there up to the hand

// A box on the floor, and a hand that holds it from above by a joint.
struct Led {
  Led(const std::string& engine, const StepperDesc& stepper, const JointKind& kind, int steps_per_second)
      : rate(steps_per_second), world(testing::MakeWorld(WorldOf(engine, stepper, rate))) {
    box = Add(*world, Body(Box{{0.5, 0.4, kHeight}}, {0, 0, kHeight}, 10));
    EntityDesc ball = Ball({0, 0, kHeight + kLength}, 0.1);
    ball.rigid_body->motion_type = MotionType::kKinematic;
    hand = Add(*world, ball);
    joint = Join(*world, Between(box, hand, kind, Pose{{0, 0, kLength}, {1, 0, 0, 0}}));
  }

  static WorldDesc WorldOf(const std::string& engine, const StepperDesc& stepper, int rate) {
    WorldDesc desc{.engine = engine, .stepper = stepper};
    desc.stepper.step_size = 1.0 / rate;
    desc.default_auto_disable.enabled = false;
    return desc;
  }

  // Leads the hand to `height` over the box's place and on, for `seconds` each.
  void Lead(double height, double seconds) {
    const auto steps = static_cast<uint32_t>(seconds * rate);
    Do(*world, SetPose{.id = hand, .position = Vector3(0, 0, kHeight + kLength + height), .over_steps = steps});
    for (uint32_t i = 0; i < 2 * steps; ++i) {
      Steps(*world, 1);
      fastest = std::max(fastest, VelocityOf(*world, box).norm());
      const Vector3 moved = PositionOf(*world, box) - Vector3(0, 0, kHeight);
      farthest = std::max(farthest, moved.norm());
    }
  }

  int rate;
  std::unique_ptr<World> world;
  EntityId box, hand;
  JointId joint;
  double fastest = 0;   // m/s
  double farthest = 0;  // m
};

// How fast the hand goes is asked of the box, too, until the joint is seen to be in the way: the faster it is led, the
// more may be left of that.
void ExpectStaysAndFollows(Led led, double depth) {
  const double moved = 0.002 + 0.12 * depth, speed = 0.2 + 6 * depth;
  led.Lead(-depth, 1);
  EXPECT_LE(led.farthest, moved) << "the floor bears it";
  EXPECT_LE(led.fastest, speed);
  EXPECT_NEAR(GapOf(*led.world, led.joint), depth, moved);
  EXPECT_LE(VelocityOf(*led.world, led.box).norm(), 0.1) << "it stands still";
  led.Lead(0, 1);
  EXPECT_LE(led.farthest, moved) << "it is not carried along by what was torn open";
  EXPECT_LE(GapOf(*led.world, led.joint), 1e-3) << "that closes again";
  led.Lead(0.2, 1);
  EXPECT_NEAR(PositionOf(*led.world, led.box).z(), kHeight + 0.2, 1e-3) << "nothing holds it down";
  EXPECT_LE(led.fastest, speed);
}

TEST_P(JointsStuck, LeadNobodyThroughTheFloorAndDoNotShakeIt) {
  Proves({Claim::kContacts, Claim::kJointBall});
  for (const int rate : {60, 240}) {
    for (const double depth : {0.02, 0.1, 0.6}) {
      SCOPED_TRACE(::testing::Message() << depth << " m too low, " << rate << " steps/s");
      ExpectStaysAndFollows({GetParam(), {}, BallJoint{}, rate}, depth);
    }
  }
}

TEST_P(JointsStuck, LeadNobodyThroughTheFloorInSweepsEither) {
  Proves({Claim::kContacts, Claim::kSolverIterative});
  for (const double depth : {0.02, 0.1, 0.6}) {
    SCOPED_TRACE(::testing::Message() << depth << " m too low");
    ExpectStaysAndFollows({GetParam(), {.solver = Solver::kIterative}, BallJoint{}, 120}, depth);
  }
}

TEST_P(JointsStuck, LeadNobodyThroughTheFloorThatTheyHoldFast) {
  Proves({Claim::kContacts, Claim::kJointFixed});
  for (const double depth : {0.02, 0.1, 0.6}) {
    SCOPED_TRACE(::testing::Message() << depth << " m too low");
    ExpectStaysAndFollows({GetParam(), {}, FixedJoint{}, 60}, depth);
  }
}

// Sweeps come near slowly where much hangs on little, and that is no jam either: haste that fell would leave it open.
TEST_P(JointsStuck, AHeavyLoadThatTouchesSomethingIsOnlyLate) {
  Proves({Claim::kContacts, Claim::kSolverIterative});
  constexpr int kLinks = 20;
  constexpr double kLink = 0.4;
  const auto world = testing::MakeWorld(Led::WorldOf(GetParam(), {.solver = Solver::kIterative}, 60));
  EntityId above;
  std::vector<JointId> joints;
  const auto hang = [&](const EntityDesc& desc) {
    const EntityId link = Add(*world, desc);
    const Pose place{{0, 0, above.is_null() ? 10 : -kLink}, {1, 0, 0, 0}};
    joints.push_back(Join(*world, Between(above, link, BallJoint{}, place)));
    above = link;
  };
  for (int i = 0; i < kLinks; ++i) hang(Ball({0, 0, 10 - kLink * i}, 0.1));
  const double tray = 10 - kLink * kLinks;
  hang(Body(Box{{0.2, 0.2, 0.05}}, {0, 0, tray}, 50));
  const EntityId passenger = Add(*world, Crate({0.1, 0, tray + 0.07}, 0.02, 0.01));
  double gap = 0;
  for (int i = 0; i < 240; ++i) {
    Steps(*world, 1);
    for (const JointId joint : joints) gap = std::max(gap, GapOf(*world, joint));
  }
  EXPECT_LE((PositionOf(*world, passenger) - PositionOf(*world, above) - Vector3(0.1, 0, 0.07)).norm(), 0.02);
  EXPECT_LE(gap, 0.01);
}

// A press of what weighs far less than what it pushes is no jam: motors and weights have bounds.
TEST_P(JointsStuck, AreNotThoseThatPressHard) {
  Proves({Claim::kContacts, Claim::kJointSlider, Claim::kJointFixed});
  constexpr double kForce = 5000, kMass = 0.1, kSide = 0.1;
  constexpr int kParts = 6;
  const auto world = testing::MakeWorld(Led::WorldOf(GetParam(), {}, 60));
  const double top = kSide * (2 * kParts - 1);
  EntityId above = Add(*world, Crate({0, 0, top}, kSide, kMass));
  const JointAxis axis{.limits = {}, .motor = Motor{.target_velocity = -1.0, .force_max = kForce}, .spring = {}};
  const JointId rail = Join(*world, ToWorld(above, SliderJoint{axis}, Pose{{0, 0, top}, {1, 0, 0, 0}}));
  std::vector<JointId> bolts;
  for (int i = 1; i < kParts; ++i) {
    const EntityId part = Add(*world, Crate({0, 0, top - 2 * kSide * i}, kSide, kMass));
    bolts.push_back(Join(*world, Between(above, part, FixedJoint{}, Pose{{0, 0, -kSide}, {1, 0, 0, 0}})));
    above = part;
  }
  Steps(*world, 120);
  EXPECT_NEAR(PositionOf(*world, above).z(), kSide, 2e-3);
  EXPECT_NEAR(StateOf(*world, rail).force.norm(), kForce, kDirect * kForce) << "it presses as hard as it can";
  for (const JointId bolt : bolts) EXPECT_NEAR(StateOf(*world, bolt).force.norm(), kForce, 1e-2 * kForce);
}

// A ball of `mass` kg on a light slide, which a beam that nothing stops turns into the floor: whichever way it slides,
// there is less and less room for it.
double FastestOfSqueezed(const std::string& engine, int rate, double spin, double mass) {
  constexpr double kArm = 0.8, kRadius = 0.3, kPost = 0.45;
  const auto world = testing::MakeWorld(Led::WorldOf(engine, {}, rate));
  EntityDesc beam = Body(Box{Vector3::Constant(0.1)}, {0, 0, kArm});
  beam.rigid_body->motion_type = MotionType::kKinematic;
  beam.rigid_body->angular_velocity = {0, spin, 0};
  const EntityId turned = Add(*world, beam), slide = Add(*world, Crate({kArm, 0, kArm}, 0.05, 0.05));
  const EntityId ball = Add(*world, Ball({kArm, 0, kArm - kPost}, kRadius, mass));
  const JointAxis axis{.limits = {.lower = -0.2, .upper = 0.2}, .motor = {}, .spring = {}};
  Join(*world, Between(turned, slide, SliderJoint{axis}, Pose{{kArm, 0, 0}, {1, 0, 0, 0}}));
  Join(*world, Between(slide, ball, FixedJoint{}, Pose{{0, 0, kRadius - kPost}, {1, 0, 0, 0}}));
  double fastest = 0;
  for (int i = 0; i < 2 / spin * rate; ++i) {
    Steps(*world, 1);
    fastest = std::max(fastest, VelocityOf(*world, ball).norm());
  }
  return fastest;
}

// The joints are torn open by nearly their size before there is room again, and then close as gravity lets them.
TEST_P(JointsStuck, ThrowNobodyOut) {
  Proves({Claim::kContacts, Claim::kJointSlider, Claim::kJointFixed});
  constexpr double kThrown = 40;  // m/s; twice the fastest of these
  for (const int rate : {60, 120, 240}) {
    for (const double spin : {0.1, 0.3, 1.0}) {
      for (const double mass : {0.5, 26.0}) {
        EXPECT_LE(FastestOfSqueezed(GetParam(), rate, spin, mass), kThrown)
            << mass << " kg at " << spin << " rad/s, " << rate << " steps/s";
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

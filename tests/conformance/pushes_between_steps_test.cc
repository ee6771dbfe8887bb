// What is told a body between two steps acts as told, and nothing more comes of it: who pushes at every step, as
// controllers do, feeds nothing.
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(PushesBetweenSteps, Claim::kImpulse);

constexpr double kGravity = 9.81;
constexpr double kStep = 1.0 / 60;

struct Swing {
  std::unique_ptr<World> world;
  EntityId mass;
};

// A mass of 1 kg on a rod of 1 m that begins level.
Swing OnAJoint(const std::string& engine) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .ground_plane = false};
  desc.default_auto_disable.enabled = false;
  Swing swing{testing::MakeWorld(desc), {}};
  swing.mass = Add(*swing.world, Ball({1, 0, 0}, 0.1));
  Join(*swing.world, Between({}, swing.mass, BallJoint{}, {Vector3::Zero(), Quaternion::Identity()}));
  return swing;
}

// The same on a spring without weight.
Swing OnASpring(const std::string& engine) {
  WorldDesc desc{.engine = engine, .gravity = Vector3::Zero(), .ground_plane = false};
  desc.default_auto_disable.enabled = false;
  Swing swing{testing::MakeWorld(desc), {}};
  swing.mass = Add(*swing.world, Ball({1, 0, 0}, 0.1));
  Do(*swing.world, CreateForceField{{.kind = SpringField{.a = swing.mass, .stiffness = 100}}});
  return swing;
}

using Command = std::function<void(Swing&)>;

const Command kZeroImpulse = [](Swing& s) { Do(*s.world, ApplyImpulse{.id = s.mass}); };
const Command kSameVelocity = [](Swing& s) {
  Do(*s.world, SetVelocity{s.mass, VelocityOf(*s.world, s.mass), SpinOf(*s.world, s.mass)});
};
const Command kSamePose = [](Swing& s) {
  const Pose pose = s.world->state().pose(EntityRow{s.mass.index()});
  Do(*s.world, SetPose{.id = s.mass, .position = pose.position, .orientation = pose.orientation});
};
const Command kSameMass = [](Swing& s) {
  const EntityDesc now = *s.world->Describe(s.mass);
  Do(*s.world, UpdateEntity{s.mass, now, {static_cast<uint32_t>(EntityField::kInertia)}});
};

TEST_P(PushesBetweenSteps, ThatChangeNothingChangeNothing) {
  Proves({Claim::kJointBall, Claim::kSpringField});
  for (const auto& make : {OnAJoint, OnASpring}) {
    int number = 0;
    for (const Command& command : {kZeroImpulse, kSameVelocity, kSamePose, kSameMass}) {
      Swing alone = make(GetParam()), told = make(GetParam());
      for (int i = 0; i < 300; ++i) {
        Steps(*alone.world, 1);
        Steps(*told.world, 1);
        command(told);
      }
      EXPECT_EQ(PositionOf(*told.world, told.mass), PositionOf(*alone.world, alone.mass)) << "command " << number;
      EXPECT_EQ(VelocityOf(*told.world, told.mass), VelocityOf(*alone.world, alone.mass)) << "command " << number;
      ++number;
    }
  }
}

TEST_P(PushesBetweenSteps, ToAndFroFeedNothingThatSwings) {
  Proves({Claim::kJointBall, Claim::kSpringField});
  // Each by a thousandth of the speed that it swings with.
  const auto push = [](Swing& swing, int i) {
    Do(*swing.world, ApplyImpulse{.id = swing.mass, .linear = {i % 2 == 0 ? 5e-3 : -5e-3, 0, 0}});
  };
  const auto most = [&](Swing swing, const std::function<double(const Vector3&, const Vector3&)>& energy) {
    double value = 0;
    for (int i = 0; i < 600; ++i) {
      push(swing, i);
      Steps(*swing.world, 1);
      value = std::max(value, energy(PositionOf(*swing.world, swing.mass), VelocityOf(*swing.world, swing.mass)));
    }
    return value;
  };
  const double joint = most(OnAJoint(GetParam()), [](const Vector3& p, const Vector3& v) {
    return v.squaredNorm() / 2 + kGravity * (p.z() + 1);
  });
  EXPECT_LE(joint, 1.05 * kGravity);
  const double spring = most(OnASpring(GetParam()), [](const Vector3& p, const Vector3& v) {
    return v.squaredNorm() / 2 + 50 * p.squaredNorm();
  });
  EXPECT_LE(spring, 1.05 * 50);
}

TEST_P(PushesBetweenSteps, AreHeldByJointsInTheMeanOverTheStep) {
  Proves({Claim::kJointBall});
  for (const uint32_t substeps : {1u, 2u, 5u}) {
    WorldDesc desc{.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false};
    desc.stepper.substeps = substeps;
    desc.default_auto_disable.enabled = false;
    const auto world = testing::MakeWorld(desc);
    const EntityId ball = Add(*world, Ball({1, 0, 0}, 0.1));
    const JointId joint = Join(*world, Between({}, ball, BallJoint{}, {Vector3::Zero(), Quaternion::Identity()}));
    Steps(*world, 10);

    Do(*world, ApplyImpulse{.id = ball, .linear = {1, 0, 0}});
    Steps(*world, 1);

    EXPECT_NEAR(world->layer_state().joints[joint.index()].force.x(), -1 / kStep, 0.02 / kStep) << substeps;
  }
}

TEST_P(PushesBetweenSteps, LeaveATowerOnWhatHeldIt) {
  Proves({Claim::kBox, Claim::kContacts});
  WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -kGravity}};
  desc.default_auto_disable.enabled = false;
  const auto world = testing::MakeWorld(desc);
  std::vector<EntityId> tower;
  for (int i = 0; i < 5; ++i) tower.push_back(Add(*world, Crate({0, 0, 0.5 + i})));
  Steps(*world, 600);
  // Each by far less than what gravity gives in a step, but a solve acts for half of a substep after it.
  for (const EntityId crate : tower) Do(*world, ApplyImpulse{.id = crate, .linear = {0, 0, -1e-6 * kGravity * kStep}});
  for (int step = 0; step < 30; ++step) {
    Steps(*world, 1);
    for (const EntityId crate : tower) ASSERT_LE(VelocityOf(*world, crate).norm(), 1e-4 * kGravity * kStep) << step;
  }
}

}  // namespace
}  // namespace genphys::testing

// What a joint lets go of goes on together with all that other joints hold to it.
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsRelease, Claim::kJointBall);

constexpr double kGravity = 9.81;

/// Three rods of 1, 1.5 and 2 kg that hang on each other, and on the world, and fall from the horizontal.
class Chain {
 public:
  Chain(const std::string& engine, int rate) : rate_(rate), world_(MakeSpace(engine, {.step_size = 1.0 / rate})) {
    for (int i = 0; i < 3; ++i) {
      EntityDesc rod = Body(Box{{0.3, 0.03, 0.03}}, {0.3 + 0.6 * i, 0, 0}, MassOf(i));
      rod.rigid_body->geometries[0].collides_with_bits = 0;
      rods_.push_back(Add(*world_, rod));
      const JointDesc joint = i == 0 ? ToWorld(rods_[0], BallJoint{})
                                     : Between(rods_[i - 1], rods_[i], BallJoint{}, Pose{.position = {0.3, 0, 0}});
      joints_.push_back(Join(*world_, joint));
    }
  }

  static double MassOf(int rod) { return 1 + 0.5 * rod; }

  World& world() { return *world_; }
  EntityId rod(size_t index) const { return rods_[index]; }
  JointId joint(size_t index) const { return joints_[index]; }
  void Go(double time) { Steps(*world_, static_cast<int>(std::lround(time * rate_))); }

  /// m, and m/s, of the centre of all mass.
  Vector3 Center() const {
    return Mean([&](EntityId id) { return PositionOf(*world_, id); });
  }
  Vector3 Velocity() const {
    return Mean([&](EntityId id) { return VelocityOf(*world_, id); });
  }
  /// m: how far the centre is from where it falls to, from here on, in 0.5 s.
  double ErrorOfFall() {
    constexpr double kTime = 0.5;
    const Vector3 there = Center() + kTime * Velocity() - Vector3(0, 0, kGravity * kTime * kTime / 2);
    Go(kTime);
    return (Center() - there).norm();
  }

 private:
  Vector3 Mean(const std::function<Vector3(EntityId)>& of) const {
    Vector3 sum = Vector3::Zero();
    double mass = 0;
    for (int i = 0; i < 3; ++i) {
      sum += MassOf(i) * of(rods_[i]);
      mass += MassOf(i);
    }
    return sum / mass;
  }

  int rate_;
  std::unique_ptr<World> world_;
  std::vector<EntityId> rods_;
  std::vector<JointId> joints_;
};

// Of what the released joint gave, half a substep's is owed to the first rod at that time: paid to it alone, it is
// taken from the way of all.
TEST_P(JointsRelease, AChainLetGoOfFallsAsAWhole) {
  for (const int rate : {60, 240}) {
    Chain chain(GetParam(), rate);
    chain.Go(0.4);
    Do(chain.world(), DeleteJoint{chain.joint(0)});
    EXPECT_LE(chain.ErrorOfFall(), 1e-12) << rate;  // each for itself: 2.4e-2 and 6e-3
  }
}

TEST_P(JointsRelease, AChainThatBreaksFallsAsAWhole) {
  Proves({Claim::kJointBreak});
  Chain chain(GetParam(), 60);
  JointDesc weak = chain.world().scene().joints[chain.joint(0).index()]->desc;
  weak.break_force = 70;
  Do(chain.world(), UpdateJoint{chain.joint(0), weak, {static_cast<uint32_t>(JointField::kBreakForce)}});
  for (int i = 0; i < 60 && chain.world().joint_count() == 3; ++i) Steps(chain.world(), 1);
  ASSERT_EQ(chain.world().joint_count(), 2u);
  EXPECT_LE(chain.ErrorOfFall(), 1e-12);
}

/// m: where the first rod is 0.5 s after the last one was let go of, 0.3 s after the chain began to fall.
Vector3 FirstAfter(const std::string& engine, int rate) {
  Chain chain(engine, rate);
  chain.Go(0.3);
  Do(chain.world(), DeleteJoint{chain.joint(2)});
  chain.Go(0.5);
  return PositionOf(chain.world(), chain.rod(0));
}

TEST_P(JointsRelease, WhatIsLeftOfAChainGoesOnInSecondOrder) {
  const Vector3 there = FirstAfter(GetParam(), 3000);
  EXPECT_LE((FirstAfter(GetParam(), 60) - there).norm(), 1e-3);
  EXPECT_LE((FirstAfter(GetParam(), 240) - there).norm(), 1e-3 / 14);  // of first order: 4e-4
}

}  // namespace
}  // namespace genphys::testing

#include <gtest/gtest.h>

#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

// A capsule whose joints to the world contradict each other, and a box that falls on it: in few of such worlds ODE ends
// an exact solve in its middle.
void AddContradiction(World& world, Random& random) {
  Add(world, Body(Box{{0.5, 0.5, 0.5}}, {0, 0, random.Uniform(3, 5)}));
  const EntityId held = Add(world, Body(Capsule{0.5, 0.5}, {0, 0, 1}));
  JointDesc hinge = ToWorld(held, HingeJoint{});
  hinge.frame_in_b = Pose{Vector3(random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1)), random.Turn()};
  hinge.frame_in_a = Pose{Vector3::Zero(), random.Turn()};
  Join(world, hinge);
  SliderJoint slider;
  slider.axis.limits = {.lower = random.Uniform(0, 2), .upper = random.Uniform(2, 3)};
  Join(world, ToWorld(held, slider));
}

// Who is solved by other means in the same step must not be taken for one of those (the address sanitizer sees it).
TEST(OdeGivingUp, LeavesAloneWhoLiesBesideAnExactSolveThatEndsInItsMiddle) {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const auto world = MakeSpace("ode");
    Add(*world, Block({50, 0, -0.5}, {5, 5, 0.5}));
    const EntityId lying = Add(*world, Crate({50, 0, 0.4}, 0.4));
    AddContradiction(*world, random);
    for (int step = 0; step < 200; ++step) {
      const Status status = world->Step();
      ASSERT_TRUE(status.ok()) << "world " << i << ", step " << step << ": " << status;
    }
    ASSERT_LE((PositionOf(*world, lying) - Vector3(50, 0, 0.4)).norm(), 1e-4) << "world " << i;
  }
}

}  // namespace
}  // namespace genphys::testing

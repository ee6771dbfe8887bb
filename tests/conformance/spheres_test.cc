// What contacts owe to whoever knows no more than a ball and a floor: the smallest of engines is held to it as well.
#include <cmath>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Spheres, Claim::kContactImpulses);

constexpr double kGravity = 9.81;
// Of a weight, as a mean over a second: what sweeps leave.
constexpr double kSwept = 1e-4;
// m, of what lies still.
constexpr double kRest = 1e-5;

struct Mean {
  double normal = 0;
  Vector3 friction = Vector3::Zero();
};

// N*s per step that the floor passed on to what lies on it.
Mean MeanImpulse(World& world) {
  constexpr int kSteps = 60;
  world.TakeEvents();
  Steps(world, kSteps);
  Mean mean;
  for (const ContactPersisted& contact : Of<ContactPersisted>(world.TakeEvents())) {
    for (const EventContactPoint& point : contact.points) {
      mean.normal += point.normal_impulse / kSteps;
      mean.friction += point.friction_impulse / kSteps;
    }
  }
  return mean;
}

// A world whose floor is a slope of `incline` rad, which is told by what falls and not by the floor.
std::unique_ptr<World> MakeSlope(const std::string& engine, double incline) {
  WorldDesc desc{.engine = engine, .gravity = kGravity * Vector3(std::sin(incline), 0, -std::cos(incline))};
  desc.recorded_events.persisting_contacts = true;
  desc.default_auto_disable.enabled = false;
  return testing::MakeWorld(desc);
}

TEST_P(Spheres, PushTheFloorWithTheirWeight) {
  for (const double mass : {1e-2, 1.0, 1e3}) {
    const auto world = MakeSlope(GetParam(), 0);
    Add(*world, Ball({0, 0, 0.5}, 0.5, mass));
    Steps(*world, 60);
    EXPECT_NEAR(MeanImpulse(*world).normal / (mass * kGravity / 60), 1, kSwept) << "mass " << mass;
  }
}

TEST_P(Spheres, AreTurnedByWhatHoldsThemOnASlope) {
  Proves({Claim::kStaticFriction});
  constexpr double kIncline = 0.2;
  const auto world = MakeSlope(GetParam(), kIncline);
  const EntityId ball = Add(*world, Ball({0, 0, 0.5}));
  Steps(*world, 30);
  const Mean mean = MeanImpulse(*world);
  // A ball rolls with five sevenths of what pulls it along; the floor holds back the rest.
  const double pull = kGravity * std::sin(kIncline);
  EXPECT_NEAR(mean.friction.x() / (-2.0 / 7 * pull / 60), 1, 1e-3);
  EXPECT_NEAR(mean.friction.y(), 0, 1e-6);
  EXPECT_NEAR(VelocityOf(*world, ball).x() / (5.0 / 7 * pull * 1.5), 1, 1e-2);
}

TEST_P(Spheres, CloseAGapAndNoMore) {
  const auto world = MakeSlope(GetParam(), 0);
  for (const double gap : {1e-4, 5e-4, 2e-3, 1e-2}) {
    const EntityId ball = Add(*world, Ball({1000 * gap, 0, 0.5 + gap}, 0.5));
    Steps(*world, 60);
    EXPECT_NEAR(PositionOf(*world, ball).z(), 0.5, kRest) << "gap " << gap;
    EXPECT_NEAR(VelocityOf(*world, ball).norm(), 0, 1e-4) << "gap " << gap;
    Do(*world, DeleteEntity{ball});
  }
}

TEST_P(Spheres, StayWhereTheirAxesAreLockedWhateverTheyTouch) {
  Proves({Claim::kLockedAxes});
  const auto world = MakeSlope(GetParam(), 0.7);
  EntityDesc desc = Ball({0, 0, 0.5});
  desc.rigid_body->locked_axes.linear[0] = true;
  const EntityId held = Add(*world, desc);
  desc = Ball({0, 3, 0.5});
  desc.rigid_body->locked_axes.angular[1] = true;
  const EntityId slides = Add(*world, desc);
  Steps(*world, 60);
  EXPECT_EQ(PositionOf(*world, held).x(), 0) << "not a bit";
  EXPECT_GT(PositionOf(*world, slides).x(), 0.1);
  EXPECT_EQ(SpinOf(*world, slides).y(), 0) << "it does not roll";
}

}  // namespace
}  // namespace genphys::testing

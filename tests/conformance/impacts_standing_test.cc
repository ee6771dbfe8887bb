// What stands on the floor and is hit by something that flies. The floor bears what presses against it within the blow,
// and what is thrown along it goes from then on. Known are Newton's law and Coulomb's.
#include <cmath>
#include <vector>

#include "conformance/engine_test.h"
#include "support/random.h"
#include "support/smooth.h"
#include "support/tolerances.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ImpactsOfStanding, Claim::kContacts, Claim::kRestitution, Claim::kBox, Claim::kSphere);

constexpr double kStep = 1.0 / 60;
constexpr double kGravity = 9.81;
constexpr double kRadius = 0.2;

TEST_P(ImpactsOfStanding, ThrowItAlongTheFloorFromWhenItIsHit) {
  Proves({Claim::kKineticFriction});
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double speed = random.LogUniform(1, 20), restitution = random.Uniform(0.3, 1);
    // It does not follow.
    const double mass = restitution * random.LogUniform(0.1, 1);
    const double friction = seed % 3 == 0 ? 0 : random.Uniform(0.05, 0.8);
    const double meets = random.Uniform(0.5, 0.6);
    const auto world = FloorOf(GetParam(), seed % 2 == 0);
    EntityDesc box = Body(Box{Vector3::Constant(kRadius)}, {0, 0, kRadius});
    Material& material = box.rigid_body->geometries[0].material;
    material.restitution = restitution;
    material.friction = friction;
    material.friction_mixing = Mixing::kMinimum;
    const EntityId hit = Add(*world, box);
    EntityDesc ball = Smooth(Ball({-2 * kRadius - meets * speed, 0, kRadius}, kRadius, mass), restitution);
    ball.rigid_body->linear_velocity = {speed, 0, 0};
    ball.rigid_body->gravity_scale = 0;
    Add(*world, ball);
    Steps(*world, 48);
    const double thrown = (1 + restitution) * speed * mass / (1 + mass);
    const double grip = std::min(friction, 0.5) * kGravity;
    const double since = grip > 0 ? std::min(48 * kStep - meets, thrown / grip) : 48 * kStep - meets;
    // The times of blows are found to 1e-5 of the way of a substep.
    const double error = 3e-6 * speed + 1e-6 + StopError(grip, SubstepOf(*world));
    EXPECT_NEAR(PositionOf(*world, hit).x(), thrown * since - grip * since * since / 2, error);
    EXPECT_NEAR(PositionOf(*world, hit).z(), kRadius, 2e-6);
  }
}

TEST_P(ImpactsOfStanding, DriveItIntoNothingHoweverHeavyTheyAre) {
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double mass = random.LogUniform(1, 1000), fall = random.Uniform(0.2, 2);
    // In one substep, so that it ends before the engine has to hold what lies there.
    const auto world = FloorOf(GetParam(), seed % 2 == 0, Quality::kFast);
    const EntityId crate = Add(*world, Crate({0, 0, 0.5}));
    const Vector3 from(random.Uniform(-0.3, 0.3), random.Uniform(-0.3, 0.3), 1.2 + fall);
    const EntityId ball = Add(*world, Ball(from, 0.2, mass));
    int step = 0;
    while (VelocityOf(*world, ball).z() <= 0 && PositionOf(*world, ball).z() > 1.2 + 1e-3 && ++step < 60) {
      Steps(*world, 1);
    }
    EXPECT_LT(step, 60);
    EXPECT_NEAR(PositionOf(*world, crate).z(), 0.5, 1e-5) << mass << " kg";
    EXPECT_NEAR(PositionOf(*world, ball).z(), 1.2, 1e-5) << mass << " kg";
    EXPECT_NEAR(VelocityOf(*world, ball).z(), 0, 1e-2) << mass << " kg";
  }
}

TEST_P(ImpactsOfStanding, ThrowBackWhatFallsOnItAsTheFloorWould) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double restitution = random.Uniform(0.3, 1), fall = random.Uniform(0.5, 1.5);
    const auto world = FloorOf(GetParam(), seed % 2 == 0);
    Add(*world, Smooth(Crate({0, 0, 0.5}), restitution));
    const EntityId ball =
        Add(*world, Smooth(Ball({0.1, 0.2, 1.2 + fall}, 0.2, random.LogUniform(0.1, 100)), restitution));
    const double down = std::sqrt(2 * fall / kGravity), up = restitution * std::sqrt(2 * fall * kGravity);
    const int steps = static_cast<int>((down + up / kGravity) / kStep);
    Steps(*world, steps);
    const double since = steps * kStep - down;
    EXPECT_NEAR(PositionOf(*world, ball).z(), 1.2 + up * since - kGravity * since * since / 2, 1e-4);
  }
}

// Two tiles, one of which lies lower by less than what does not touch, and a crate on both that is hit above that one.
TEST_P(ImpactsOfStanding, TipNothingThatStandsALittleOffTheFloorThere) {
  constexpr double kEdge = -0.3, kFall = 1, kRestitution = 0.8;
  for (const double gap : {0.0, 3e-5, 9e-5}) {
    WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -kGravity}, .stepper = {.step_size = kStep}};
    desc.ground_plane = false;
    const auto world = testing::MakeWorld(desc);
    Require(*world, Feature::kContacts);
    Add(*world, Block({kEdge + 1, 0, -0.5}, {1, 1, 0.5}));
    Add(*world, Block({kEdge - 1, 0, -0.5 - gap}, {1, 1, 0.5}));
    const EntityId crate = Add(*world, Smooth(Crate({0, 0, 0.5}), kRestitution));
    const EntityId ball = Add(*world, Smooth(Ball({-0.45, 0, 1 + kRadius + kFall}, kRadius), kRestitution));
    Steps(*world, static_cast<int>(std::sqrt(2 * kFall / kGravity) / kStep) + 2);
    const double up = VelocityOf(*world, ball).z();
    const double rise = PositionOf(*world, ball).z() - 1 - kRadius + up * up / 2 / kGravity;
    EXPECT_NEAR(rise, kRestitution * kRestitution * kFall, 1e-3) << gap;
    EXPECT_LT(VelocityOf(*world, crate).norm(), 1e-3) << gap;
  }
}

// A ball falls on a box that stands on another one. Returns how both go in the two steps from then on, if the frame of
// the box is so far above it (m).
std::vector<Vector3> FallenOn(const std::string& engine, Random random, double frame_above) {
  const double speed = random.LogUniform(1, 20), restitution = random.Uniform(0, 1), aside = random.Uniform(0, kRadius);
  const auto world = FloorOf(engine, false);
  Add(*world, Smooth(Body(Box{Vector3::Constant(kRadius)}, {0, 0, kRadius}), 0));
  EntityDesc box = Smooth(Body(Box{Vector3::Constant(kRadius)}, {0, 0, 3 * kRadius + frame_above}), restitution);
  box.rigid_body->geometries[0].pose_in_entity.position = {0, 0, -frame_above};
  const EntityId hit = Add(*world, box);
  Steps(*world, 10);
  EntityDesc ball = Smooth(Ball({aside, 0, 5 * kRadius + speed * kStep / 2}, kRadius), restitution);
  ball.rigid_body->linear_velocity = {0, 0, -speed};
  ball.rigid_body->gravity_scale = 0;
  const EntityId fallen = Add(*world, ball);
  std::vector<Vector3> velocities;
  for (int step = 0; step < 2; ++step) {
    Steps(*world, 1);
    for (const EntityId id : {hit, fallen}) velocities.push_back(VelocityOf(*world, id));
  }
  return velocities;
}

TEST_P(ImpactsOfStanding, ComeToTheSameWhereverTheFrameIs) {
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<Vector3> expected = FallenOn(GetParam(), Random(seed), 0);
    const std::vector<Vector3> found = FallenOn(GetParam(), Random(seed), 3);
    // Of numbers up to 20; what differs by where a frame is differs by more than a thousand times that.
    for (size_t i = 0; i < expected.size(); ++i) EXPECT_LE((found[i] - expected[i]).norm(), 1e-9) << i;
  }
}

}  // namespace
}  // namespace genphys::testing

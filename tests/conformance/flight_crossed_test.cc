// Who flies is met by whatever goes through where it may be, however that came to be so fast: as it is when the engine
// moves it.
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(FlightCrossed, Claim::kEnginesAgree);

constexpr double kStep = 1.0 / 60;
constexpr double kRadius = 0.1;
constexpr double kForce = 1e5;
// Of what speeds are, the most by which two ways of moving the same freely may differ once a blow multiplied it.
constexpr double kSame = 1e-6;

// Weightless, without friction.
std::unique_ptr<World> MakeCrossing(const std::string& engine, double restitution = 0) {
  WorldDesc desc{.engine = engine, .gravity = Vector3::Zero(), .ground_plane = false};
  desc.default_material = {.friction = 0, .restitution = restitution};
  desc.default_auto_disable.enabled = false;
  auto world = MakeWorld(desc);
  Require(*world, Feature::kContacts);
  world->set_record_stats(true);
  return world;
}

// A body that flies, unless a field that gives it nothing has the engine move it.
EntityId AddFlyer(World& world, const EntityDesc& desc, bool flies) {
  const EntityId id = Add(world, desc);
  if (!flies) Do(world, CreateForceField{{.kind = UniformField{}, .entities = {id}}});
  return id;
}

EntityDesc Thrown(const Vector3& position, const Vector3& velocity = Vector3::Zero()) {
  EntityDesc ball = Ball(position, kRadius);
  ball.rigid_body->linear_velocity = velocity;
  return ball;
}

// What speeds up a body of 1 kg at the origin along x.
struct Drive {
  std::string name;
  std::function<void(World&, EntityId)> start;
};

std::vector<Drive> Drives() {
  return {{"a force that is sampled",
           [](World& world, EntityId id) {
             Do(world, ApplyForce{.id = id, .force = {kForce, 0, 0}, .sampled = true});
           }},
          {"a force field",
           [](World& world, EntityId id) {
             Do(world, CreateForceField{{.kind = UniformField{.force = {kForce, 0, 0}}, .entities = {id}}});
           }},
          {"a motor",
           [](World& world, EntityId id) {
             SliderJoint slider;
             slider.axis.motor = Motor{.target_velocity = 700};
             Join(world, ToWorld(id, slider, FrameAlong(Vector3::UnitX())));
           }},
          {"a spring", [](World& world, EntityId id) {
             const Vector3 far(50, 0, 0);
             Do(world, CreateForceField{{.kind = SpringField{.a = id, .point_in_b = far, .stiffness = kForce / 50}}});
           }}};
}

TEST_P(FlightCrossed, EndsWhereSomethingIsDrivenThroughItsRegion) {
  for (const Drive& drive : Drives()) {
    for (const double distance : {1.0, 2.0, 7.0}) {
      SCOPED_TRACE(drive.name + " over " + std::to_string(distance) + " m");
      std::vector<Vector3> velocities;
      for (const bool flies : {true, false}) {
        const auto world = MakeCrossing(GetParam());
        const EntityId driven = Add(*world, Thrown(Vector3::Zero()));
        const EntityId flyer = AddFlyer(*world, Thrown({distance, 0.03, 0}, {0, 0.01, 0}), flies);
        Steps(*world, 1);
        ASSERT_EQ(world->stats().entities_in_flight, flies ? 2u : 1u);
        drive.start(*world, driven);
        // It is past the other one by the end of this.
        Steps(*world, 1);
        velocities.push_back(VelocityOf(*world, flyer));
      }
      EXPECT_GT(velocities[1].x(), 10);
      EXPECT_LE((velocities[0] - velocities[1]).norm(), kSame * velocities[1].norm());
    }
  }
}

// A rod that was hit at one end sweeps over somebody near its other end, within one step.
TEST_P(FlightCrossed, EndsWhereSomethingTurnsThroughItsRegion) {
  Proves({Claim::kSphere, Claim::kBox, Claim::kRestitution});
  for (const double speed : {300.0, 1300.0, 1800.0}) {
    SCOPED_TRACE(speed);
    std::vector<Vector3> velocities;
    for (const bool flies : {true, false}) {
      const auto world = MakeCrossing(GetParam(), 0.5);
      Add(*world, Body(Box{{2, 0.05, 0.05}}, Vector3::Zero()));
      // In the third step.
      Add(*world, Thrown({1.9, -2.3 * speed * kStep - 0.15, 0}, {0, speed, 0}));
      const EntityId flyer = AddFlyer(*world, Thrown({-1.1, -0.75, 0}, {0, 1e-3, 0}), flies);
      Steps(*world, 5);
      velocities.push_back(VelocityOf(*world, flyer));
    }
    EXPECT_GT(velocities[1].norm(), speed / 10);
    EXPECT_LE((velocities[0] - velocities[1]).norm(), kSame * velocities[1].norm());
  }
}

// Both go far in each of several substeps, and meet in one that is not the first.
TEST_P(FlightCrossed, EndsWhereItIsByThen) {
  Proves({Claim::kSphere, Claim::kRestitution});
  constexpr double kSpeed = 200;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double time = random.Uniform(0.3, 0.95) * kStep;
    const Vector3 meeting(kForce * time * time / 2, random.Uniform(-kRadius, kRadius), 0);
    const Vector3 velocity = kSpeed * Vector3(0, 0.8, 0.6);
    std::vector<Vector3> velocities;
    for (const bool flies : {true, false}) {
      const auto world = MakeCrossing(GetParam(), 1);
      StepperDesc stepper = world->scene().world.stepper;
      stepper.substeps = 4;
      Do(*world, SetStepper{stepper});
      // Of two that are alike it is the first one along whose way they are looked for.
      const EntityId flyer = AddFlyer(*world, Thrown(meeting - time * velocity, velocity), flies);
      const EntityId driven = Add(*world, Thrown(Vector3::Zero()));
      Do(*world, ApplyForce{.id = driven, .force = {kForce, 0, 0}, .sampled = true});
      Steps(*world, 1);
      velocities.push_back(VelocityOf(*world, flyer));
    }
    EXPECT_GT((velocities[1] - velocity).norm(), 1);
    EXPECT_LE((velocities[0] - velocities[1]).norm(), kSame * velocities[1].norm());
  }
}

}  // namespace
}  // namespace genphys::testing

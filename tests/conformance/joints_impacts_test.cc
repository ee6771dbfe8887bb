// What joints hold together and what bounces off each other, the same bodies at the same time, make no energy of it.
#include <algorithm>
#include <array>

#include "conformance/engine_test.h"
#include "support/energy.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsImpacts, Claim::kContacts, Claim::kRestitution, Claim::kJointBall, Claim::kJointHinge);

// Three rough, lively bodies of very different masses, one joined to the next, of which the last lies a little inside
// the first: contact drives apart what the joints hold together, at every step anew.
void AddPinched(World& world, Random& random) {
  std::array<EntityId, 3> bodies;
  const double overlap = random.LogUniform(1e-3, 0.05);
  const std::array<Vector3, 3> halves{Vector3(0.5, 0.4, 0.3), Vector3(0.2, 0.15, 0.2), Vector3(0.1, 0.2, 0.15)};
  const std::array<Vector3, 3> places{Vector3::Zero(), Vector3(0.9, 0.1, 0),
                                      Vector3(halves[0].x() + halves[2].x() - overlap, 0, 0.1)};
  for (size_t i = 0; i < bodies.size(); ++i) {
    EntityDesc desc = Body(Box{halves[i]}, places[i], i == 0 ? 40 : random.LogUniform(0.1, 10));
    Geometry& box = desc.rigid_body->geometries[0];
    box.material.restitution = 0.9;
    box.material.friction = 0.9;
    // The one between them touches neither.
    box.category_bits = i == 1 ? 2 : 1;
    box.collides_with_bits = i == 1 ? 4 : 1;
    desc.rigid_body->linear_velocity = random.Vector(1);
    desc.rigid_body->angular_velocity = random.Vector(2);
    bodies[i] = Add(world, desc);
  }
  const auto hinge = [&] { return FrameAlong(random.Direction(), random.Vector(0.5)); };
  Join(world, Between(bodies[0], bodies[1], HingeJoint{}, hinge()));
  if (random.Chance(0.5)) {
    Join(world, Between(bodies[1], bodies[2], HingeJoint{}, hinge()));
  } else {
    Join(world, Between(bodies[1], bodies[2], BallJoint{}, {random.Vector(0.2)}));
  }
}

TEST_P(JointsImpacts, GiveNoEnergyToWhatIsPinched) {
  constexpr uint64_t kScenes = 100;
  constexpr uint32_t kSteps = 200;
  for (uint64_t seed = 1; seed <= kScenes; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = random.LogUniform(2e-4, 1.0 / 60)}, Vector3::Zero());
    AddPinched(*world, random);
    const double start = KineticEnergyOf(*world);
    double most = 0;
    for (uint32_t step = 0; step < kSteps; ++step) {
      Steps(*world, 1);
      most = std::max(most, KineticEnergyOf(*world));
    }
    // Measured: 1.32 at most, and 1.6 or more in some of these without any one of what holds it down. It is no promise
    // for every scene: what making up for errors of joints may give brings 17 of 3,000 such scenes on Bullet above 1.2
    // times, to 2.2 at most, and none on ODE above 1.003. Which ones is chance.
    EXPECT_LE(most, 1.4 * start);
  }
}

}  // namespace
}  // namespace genphys::testing

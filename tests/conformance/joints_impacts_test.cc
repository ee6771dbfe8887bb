// What joints hold together and what bounces off each other, the same bodies at the same time, make no energy of it.
#include <array>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsImpacts, Claim::kContacts, Claim::kRestitution, Claim::kJointBall, Claim::kJointHinge);

double KineticEnergyOf(const World& world, EntityId id) {
  const EntityRow row{id.index()};
  const MassProperties& mass = world.scene().entities[Index(row)]->mass;
  const Vector3 velocity = world.state().linear_velocities.col(Index(row));
  const Vector3 spin =
      world.state().pose(row).orientation.conjugate() * Vector3(world.state().angular_velocities.col(Index(row)));
  return (mass.mass * velocity.squaredNorm() + spin.dot(mass.tensor * spin)) / 2;
}

double KineticEnergyOf(const World& world, const std::array<EntityId, 3>& bodies) {
  double energy = 0;
  for (const EntityId id : bodies) energy += KineticEnergyOf(world, id);
  return energy;
}

// Three rough, lively bodies of very different masses, one joined to the next, of which the last lies a little inside
// the first: contact drives apart what the joints hold together, at every step anew.
std::array<EntityId, 3> AddPinched(World& world, Random& random) {
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
  return bodies;
}

TEST_P(JointsImpacts, GiveNoEnergyToWhatIsPinched) {
  constexpr uint64_t kScenes = 100;
  constexpr uint32_t kSteps = 200;
  for (uint64_t seed = 1; seed <= kScenes; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = random.LogUniform(2e-4, 1.0 / 60)}, Vector3::Zero());
    const std::array<EntityId, 3> bodies = AddPinched(*world, random);
    const double start = KineticEnergyOf(*world, bodies);
    double most = 0;
    for (uint32_t step = 0; step < kSteps; ++step) {
      Steps(*world, 1);
      most = std::max(most, KineticEnergyOf(*world, bodies));
    }
    // What lies in each other may be driven apart by a little speed that nobody gave it.
    EXPECT_LE(most, 1.1 * start);
  }
}

}  // namespace
}  // namespace genphys::testing

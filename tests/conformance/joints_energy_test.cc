// Joints that nobody drives do not feed what they hold together, however unequal that is.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsEnergy);

constexpr uint64_t kChains = 200;

double KineticEnergyOf(const World& world) {
  double energy = 0;
  for (const auto& entity : world.scene().entities) {
    if (!entity) continue;
    const EntityRow row{entity->id.index()};
    const Vector3 velocity = world.state().linear_velocities.col(Index(row));
    const Vector3 spin =
        world.state().pose(row).orientation.conjugate() * Vector3(world.state().angular_velocities.col(Index(row)));
    energy += (entity->mass.mass * velocity.squaredNorm() + spin.dot(entity->mass.tensor * spin)) / 2;
  }
  return energy;
}

// Boxes of any masses and shapes one behind the other, which pass through each other, each turning its own way.
void AddChain(World& world, Random& random) {
  const size_t links = 2 + random.Below(5);
  EntityId above;
  Vector3 place = Vector3::Zero(), reach = Vector3::Zero();
  for (size_t i = 0; i < links; ++i) {
    const Vector3 half(random.LogUniform(0.02, 0.5), random.LogUniform(0.02, 0.5), random.LogUniform(0.02, 0.5));
    const Vector3 from = half.cwiseProduct(random.Vector(1));
    place += reach - from;
    EntityDesc link = Body(Box{half}, place, random.LogUniform(1e-3, 1e3));
    link.rigid_body->geometries[0].collides_with_bits = 0;
    link.rigid_body->linear_velocity = random.Vector(3);
    link.rigid_body->angular_velocity = random.Vector(20);
    const EntityId id = Add(world, link);
    if (i > 0) {
      const Pose frame{reach, random.Turn()};
      const JointKind kinds[] = {BallJoint{}, HingeJoint{}, UniversalJoint{}, FixedJoint{}};
      Join(world, Between(above, id, kinds[random.Below(4)], frame));
    }
    above = id;
    reach = half.cwiseProduct(random.Vector(1));
  }
}

// Some of the links turn by more than a radian in a step, or are so slender that a tenth of that is as much: steps of
// this size are off by as much energy as there is.
TEST_P(JointsEnergy, OfATumblingChainOfAnyMassesDoesNotRunAway) {
  Proves({Claim::kJointBall, Claim::kJointHinge, Claim::kJointUniversal, Claim::kJointFixed});
  for (uint64_t seed = 1; seed <= kChains; ++seed) {
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = 1 / random.Uniform(30, 120)}, Vector3::Zero());
    AddChain(*world, random);
    const double start = KineticEnergyOf(*world);
    double most = 0;
    for (int i = 0; i < 300; ++i) {
      Steps(*world, 1);
      most = std::max(most, KineticEnergyOf(*world));
    }
    EXPECT_LE(most, 2 * start) << "seed " << seed;
  }
}

}  // namespace
}  // namespace genphys::testing

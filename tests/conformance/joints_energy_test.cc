// Joints that nobody drives do not feed what they hold together, however unequal that is, and do not let go of it.
#include <cmath>
#include <vector>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"
#include "support/tolerances.h"

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

// Boxes of any shapes and of masses up to `unequal` times one kilogram and down to its inverse, one behind the other,
// which pass through each other; hung on the world if they hang, and else each turning its own way.
std::vector<JointId> AddChain(World& world, Random& random, size_t links, double unequal, bool hangs = false) {
  std::vector<JointId> joints;
  EntityId above;
  Vector3 place = Vector3::Zero(), reach = Vector3::Zero();
  for (size_t i = 0; i < links; ++i) {
    const Vector3 half(random.LogUniform(0.02, 0.5), random.LogUniform(0.02, 0.5), random.LogUniform(0.02, 0.5));
    const Vector3 from = half.cwiseProduct(random.Vector(1));
    place += reach - from;
    EntityDesc link = Body(Box{half}, place, random.LogUniform(1 / unequal, unequal));
    link.rigid_body->geometries[0].collides_with_bits = 0;
    if (!hangs) {
      link.rigid_body->linear_velocity = random.Vector(3);
      link.rigid_body->angular_velocity = random.Vector(20);
    }
    const EntityId id = Add(world, link);
    if (i > 0 || hangs) {
      const Pose frame{reach, random.Turn()};
      const JointKind kinds[] = {BallJoint{}, HingeJoint{}, UniversalJoint{}, FixedJoint{}};
      // Who is fixed to the world does not swing.
      joints.push_back(Join(world, Between(above, id, kinds[random.Below(i > 0 ? 4 : 3)], frame)));
    }
    above = id;
    reach = half.cwiseProduct(random.Vector(1));
  }
  return joints;
}

// m: how far the joint is from the centres of mass of what it holds, together.
double ReachOf(const World& world, JointId id) {
  const JointDesc& joint = world.scene().joints[id.index()]->desc;
  double reach = 0;
  for (const auto& [entity, frame] :
       {std::pair(joint.entity_a, *joint.frame_in_a), {joint.entity_b, *joint.frame_in_b}}) {
    if (entity.is_world()) continue;
    reach += (frame.position - world.scene().entities[entity.id.index()]->mass.center_of_mass).norm();
  }
  return reach;
}

// rad: how far the fastest turns in a substep.
double TurnOf(const World& world) {
  return world.state().angular_velocities.colwise().norm().maxCoeff() * SubstepOf(world);
}

// Some of the links turn by more than a radian in a step, or are so slender that a tenth of that is as much.
TEST_P(JointsEnergy, OfATumblingChainOfAnyMassesDoesNotRunAway) {
  Proves({Claim::kJointBall, Claim::kJointHinge, Claim::kJointUniversal, Claim::kJointFixed});
  for (uint64_t seed = 1; seed <= kChains; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = 1 / random.Uniform(30, 120)}, Vector3::Zero());
    AddChain(*world, random, 2 + random.Below(5), 1e3);
    const double start = KineticEnergyOf(*world);
    double widest = 0;
    for (int i = 0; i < 300; ++i) {
      Steps(*world, 1);
      widest = std::max(widest, TurnOf(*world));
      ASSERT_LE(KineticEnergyOf(*world), start * (1 + 2 * Unearned(widest))) << "step " << i;
    }
  }
}

TEST_P(JointsEnergy, IsNotKeptByLettingGoOfPendulumsOfUnequalLinks) {
  Proves({Claim::kJointBall, Claim::kJointHinge, Claim::kJointUniversal, Claim::kJointFixed});
  for (uint64_t seed = 1; seed <= kChains; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double step = 1 / random.Uniform(60, 240);
    const auto world = MakeSpace(GetParam(), {.step_size = step});
    const std::vector<JointId> joints = AddChain(*world, random, 1 + random.Below(3), 10, true);
    double widest = 0;
    std::vector<double> gaps(joints.size());
    for (int i = 0; i < 5 / step; ++i) {
      Steps(*world, 1);
      widest = std::max(widest, TurnOf(*world));
      for (size_t j = 0; j < joints.size(); ++j) gaps[j] = std::max(gaps[j], GapOf(*world, joints[j]));
    }
    for (size_t j = 0; j < joints.size(); ++j) {
      // A circle of that radius, and straight on for the substep that opens it and one for which that may wait.
      const double reach = ReachOf(*world, joints[j]);
      EXPECT_LE(gaps[j], 2 * OffCircle(widest * reach, 2, reach) + kTouch) << "joint " << j;
    }
  }
}

}  // namespace
}  // namespace genphys::testing

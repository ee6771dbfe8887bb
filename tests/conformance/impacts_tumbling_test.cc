// What turns while it hits may hit again within a step, and be apart once more at its end.
#include <algorithm>
#include <cmath>

#include "conformance/engine_test.h"
#include "support/energy.h"
#include "support/random.h"
#include "support/tolerances.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ImpactsOfTumbling, Claim::kContacts, Claim::kRestitution);

constexpr int kPairs = 2000;
constexpr int kSteps = 72;        // in which the slowest meet and part again
const Vector3 kMiddle(0, 0, 10);  // far above the floor

EntityDesc Thrown(Random& random, const Vector3& from, double speed) {
  EntityDesc body = Body(Box{{random.Uniform(0.1, 0.5), random.Uniform(0.1, 0.5), random.Uniform(0.1, 0.5)}},
                         kMiddle + from, random.LogUniform(0.3, 3));
  body.pose.orientation = random.Turn();
  body.rigid_body->linear_velocity = speed * (0.25 * random.Direction() - from).normalized();
  body.rigid_body->angular_velocity = random.Uniform(0, 3) * random.Direction();
  body.rigid_body->geometries[0].material.friction = 0;
  body.rigid_body->geometries[0].material.restitution = 1;
  return body;
}

// Of the energy of what turns by `turn` rad in each substep, relative: of the exponential of a turn the first four
// powers are right.
double TurnError(double turn, int substeps) { return substeps * std::pow(turn, 5) / 120; }

TEST_P(ImpactsOfTumbling, KeepTheEnergyOfElasticBoxes) {
  Random random(3);
  int hits = 0;
  for (int i = 0; i < kPairs; ++i) {
    WorldDesc desc{.engine = GetParam(), .gravity = Vector3::Zero()};
    desc.default_auto_disable.enabled = false;
    const auto world = testing::MakeWorld(desc);
    const Vector3 side = random.Direction();
    const EntityId a = Add(*world, Thrown(random, random.Uniform(1, 1.5) * side, random.Uniform(1, 5)));
    const EntityId b = Add(*world, Thrown(random, -random.Uniform(1, 1.5) * side, random.Uniform(1, 5)));
    const double before = KineticEnergyOf(*world);
    const Vector3 at_first = VelocityOf(*world, a);
    const double substep = SubstepOf(*world);
    double turn = 0;  // rad, in a substep, the most
    for (int step = 0; step < kSteps; ++step) {
      Steps(*world, 1);
      for (const EntityId id : {a, b}) turn = std::max(turn, substep * SpinOf(*world, id).norm());
    }
    hits += VelocityOf(*world, a) != at_first;
    const int substeps = static_cast<int>(std::lround(kSteps / (60 * substep)));
    EXPECT_NEAR(KineticEnergyOf(*world) / before, 1, 2 * TurnError(turn, substeps) + kRounded)
        << "pair " << i << " turns by " << turn;
  }
  EXPECT_GT(hits, kPairs / 2);
}

}  // namespace
}  // namespace genphys::testing

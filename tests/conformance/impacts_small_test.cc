// Parts of millimetres turn at a landing askew as larger bodies do: what is flat is told by how they lie, not by a
// length.
#include <cmath>
#include <string>
#include <utility>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ImpactsOfSmall, Claim::kContacts, Claim::kRestitution, Claim::kBox);

constexpr double kGravity = 9.81;
constexpr double kRestitution = 0.5;
constexpr double kTilt = 0.2 * M_PI / 180;

// How a smooth cube of this half edge goes on that fell ten times that, as parts of its speed when it landed: up, and
// turning at its corners.
std::pair<double, double> AfterLanding(const std::string& engine, double half, double tilt) {
  const double fall = 10 * half, time = std::sqrt(2 * fall / kGravity);
  // So that a substep covers a five-hundredth of the half edge, and it lands in the middle of one.
  const int steps = 10000;
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = time / (steps - 0.5)}};
  desc.stepper.substeps = 1;
  desc.default_material.friction = desc.default_material.kinetic_friction = 0;
  desc.default_material.restitution = kRestitution;
  const auto world = testing::MakeWorld(desc);
  EntityDesc cube = Body(Box{Vector3::Constant(half)}, {0, 0, half * (std::cos(tilt) + std::sin(tilt)) + fall});
  cube.pose.orientation = Quaternion(Eigen::AngleAxisd(tilt, Vector3::UnitY()));
  const EntityId id = Add(*world, cube);
  Steps(*world, steps + steps / 1000);
  const double speed = kGravity * time;
  return {VelocityOf(*world, id).z() / speed, half * world->state().angular_velocities(1, id.index()) / speed};
}

TEST_P(ImpactsOfSmall, LandAskewOneEdgeAfterTheOther) {
  // On an edge that is a half edge off the centre, with 2/3 m half^2 about that: (1 + e) / (1 + 3/2) of the momentum,
  // and 3/2 of that turns it; then the other edge is hit as fast as that makes it.
  const double first = (1 + kRestitution) / 2.5, turned = 1.5 * first;
  const double second = (1 + kRestitution) * (1 - first + turned) / 2.5;
  for (const double half : {0.1, 0.0025}) {
    SCOPED_TRACE(half);
    const auto [up, turning] = AfterLanding(GetParam(), half, kTilt);
    EXPECT_NEAR(up, first + second - 1, 4 * kTilt);
    EXPECT_NEAR(std::abs(turning), std::abs(turned - 1.5 * second), 4 * kTilt);
  }
}

TEST_P(ImpactsOfSmall, LandOnAllCornersAtOnceWhenTheyLieFlat) {
  for (const double half : {0.1, 0.0025}) {
    SCOPED_TRACE(half);
    const auto [up, turning] = AfterLanding(GetParam(), half, 0);
    EXPECT_NEAR(up, kRestitution, 0.01);
    EXPECT_NEAR(turning, 0, 1e-6);
  }
}

}  // namespace
}  // namespace genphys::testing

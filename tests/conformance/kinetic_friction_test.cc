// Friction of what slides may be less than that of what rests. Which of both acts is a matter of whether a contact
// slides, not of how fast.
#include <cmath>
#include <memory>
#include <string>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(KineticFriction, Claim::kContacts, Claim::kKineticFriction, Claim::kStaticFriction, Claim::kPlane,
                     Claim::kBox);

constexpr double kStatic = 0.5, kKinetic = 0.3;

// A block on a floor that gravity makes a slope, down which x points.
struct Sloping {
  std::unique_ptr<World> world;
  EntityId block;
  double pull = 0, brake = 0;  // m/s^2, of the slope and of friction while it slides

  Sloping(const std::string& engine, int rate, double slope, double strength, double speed)
      : pull(strength * std::sin(slope)), brake(kKinetic * strength * std::cos(slope)) {
    WorldDesc desc{.engine = engine,
                   .gravity = strength * Vector3(std::sin(slope), 0, -std::cos(slope)),
                   .stepper = {.step_size = 1.0 / rate}};
    desc.default_material.friction = kStatic;
    desc.default_material.kinetic_friction = kKinetic;
    desc.default_auto_disable.enabled = false;
    world = testing::MakeWorld(desc);
    EntityDesc body = Body(Box{{0.3, 0.2, 0.05}}, {0, 0, 0.05}, 3);
    body.rigid_body->linear_velocity.x() = speed;
    block = Add(*world, body);
  }
  double x() const { return PositionOf(*world, block).x(); }
};

TEST_P(KineticFriction, BrakesFromWhereThatAtRestGivesWay) {
  constexpr double kTime = 1;
  for (const double strength : {9.81, 1.62}) {
    for (const int rate : {60, 240, 1000}) {
      Sloping at(GetParam(), rate, std::atan(1.01 * kStatic), strength, 0);
      Steps(*at.world, static_cast<int>(std::lround(kTime * rate)));
      const double gain = at.pull - at.brake;
      // It begins under the friction at rest, for a substep and until it is seen to move: 1e-4 m/s at a hundredth of
      // the pull.
      const double late = SubstepOf(*at.world) + 1e-4 / (0.01 * at.pull);
      EXPECT_NEAR(at.x(), gain * kTime * kTime / 2, 2 * gain * kTime * late) << strength << " m/s^2 at " << rate;
    }
  }
}

TEST_P(KineticFriction, LeavesWhatHaltsOnASlopeToThatAtRest) {
  for (const double speed : {0.03, 0.3, 2.0}) {
    for (const int rate : {60, 90, 240, 1000}) {
      Sloping at(GetParam(), rate, std::atan(0.9 * kStatic), 9.81, -speed);
      const double brake = at.pull + at.brake, way = speed * speed / brake / 2;
      Steps(*at.world, static_cast<int>(std::ceil((speed / brake + 1) * rate)));
      EXPECT_LT(VelocityOf(*at.world, at.block).norm(), 1e-6) << speed << " m/s at " << rate;
      // It may turn back for what is left of a substep, and the next one stops it.
      EXPECT_NEAR(at.x(), -way, 2 * brake * std::pow(SubstepOf(*at.world), 2)) << speed << " m/s at " << rate;
    }
  }
}

TEST_P(KineticFriction, BrakesWhatHasNearlyStopped) {
  for (const double speed : {0.02, 0.1}) {
    for (const int rate : {60, 240, 1000}) {
      Sloping at(GetParam(), rate, 0, 1.62, speed);
      const double way = speed * speed / at.brake / 2;
      Steps(*at.world, static_cast<int>(std::ceil((speed / at.brake + 0.2) * rate)));
      EXPECT_NEAR(at.x(), way, 2e-3 * way) << speed << " m/s at " << rate;
    }
  }
}

}  // namespace
}  // namespace genphys::testing

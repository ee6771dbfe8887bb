// The scene of the thesis: a ball falls on a crate, beside its middle it meets the edge, and rolls away.
#include <cmath>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(CrateAndBall, Claim::kContacts);

constexpr double kStep = 1.0 / 60;
constexpr double kGravity = 9.81, kFriction = 0.5;
constexpr double kContactTime = 0.849746;  // s: sqrt(2 (5 - 1.45826) / 9.81)

struct Scene {
  std::unique_ptr<World> world;
  EntityId crate;
  EntityId ball;
};

Scene MakeScene(const std::string& engine, double x, double angular_damping = 0) {
  Scene scene{MakeWorld(engine), {}, {}};
  scene.crate = Add(*scene.world, Crate({0, 0, 0.5}));
  EntityDesc ball = Ball({x, 0, 5});
  ball.rigid_body->angular_damping = angular_damping;
  scene.ball = Add(*scene.world, ball);
  scene.world->TakeEvents();
  return scene;
}

TEST_P(CrateAndBall, MeetWhenTheClosedFormSaysSo) {
  Scene scene = MakeScene(GetParam(), 0.7);

  Steps(*scene.world, 60);

  for (const Event& event : scene.world->TakeEvents()) {
    const ContactBegan* began = std::get_if<ContactBegan>(&event.kind);
    if (began == nullptr || began->pair.b != scene.ball) continue;
    EXPECT_EQ(began->pair.a, scene.crate);
    EXPECT_NEAR(static_cast<double>(event.step) * kStep, kContactTime, kStep);
    return;
  }
  FAIL() << "they never met";
}

TEST_P(CrateAndBall, TheBallRollsAwayWithoutSlipping) {
  Scene scene = MakeScene(GetParam(), 0.7);

  Steps(*scene.world, 51 + 600);

  const Vector3 position = PositionOf(*scene.world, scene.ball);
  EXPECT_GT(position.x(), 1.0);
  EXPECT_NEAR(position.z(), 0.5, kTouch);
  const Vector3 slip =
      VelocityOf(*scene.world, scene.ball) - 0.5 * SpinOf(*scene.world, scene.ball).cross(Vector3::UnitZ());
  EXPECT_GT(VelocityOf(*scene.world, scene.ball).x(), 0.01);
  EXPECT_LT(slip.norm(), 2 * SweptSpeed(kFriction * kGravity, SubstepOf(*scene.world)));
}

TEST_P(CrateAndBall, TheDampedBallFallsAsleep) {
  Scene scene = MakeScene(GetParam(), 0.7, 2.0);

  Steps(*scene.world, 51 + 600);

  EXPECT_TRUE(Asleep(*scene.world, scene.ball));
  EXPECT_NEAR(PositionOf(*scene.world, scene.ball).z(), 0.5, kTouch);
}

TEST_P(CrateAndBall, OnTheFlatTopTheBallStays) {
  Scene scene = MakeScene(GetParam(), 0.3);

  Steps(*scene.world, 51 + 600);

  // What the blow leaves of the ball's speed counts as rest, 0.02 m/s at most, and so ends after half a second.
  const Vector3 position = PositionOf(*scene.world, scene.ball);
  EXPECT_TRUE(Asleep(*scene.world, scene.ball));
  EXPECT_NEAR(position.x(), 0.3, 0.02 * 0.5);
  EXPECT_NEAR(position.z(), 1.5, 2 * kTouch);
}

}  // namespace
}  // namespace genphys::testing

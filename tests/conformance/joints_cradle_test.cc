// Newton's cradle: balls that hang side by side pass on what hits the row to as many at its other end as came, again
// and again, and all others stay where they are.
#include <cmath>
#include <vector>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsCradle, Claim::kContacts, Claim::kRestitution, Claim::kSphere);

constexpr double kGravity = 9.81;
constexpr double kRadius = 0.05, kLength = 1;
constexpr int kBalls = 5;

struct Cradle {
  std::unique_ptr<World> world;
  std::vector<EntityId> balls;
  std::vector<Vector3> hooks;
};

// `raised` at one end are drawn aside by `swing` rad. Balls are `gap` (m) apart, or as deep in each other.
Cradle MakeCradle(const std::string& engine, uint32_t substeps, const JointKind& kind, int raised, double swing,
                  double gap) {
  StepperDesc stepper;
  stepper.step_size = 1.0 / 240;
  stepper.substeps = substeps;
  Cradle cradle{.world = MakeSpace(engine, stepper), .balls = {}, .hooks = {}};
  for (int i = 0; i < kBalls; ++i) {
    const Vector3 hook((2 * kRadius + gap) * i, 0, 2), down(0, 0, -kLength);
    const Quaternion turn(Eigen::AngleAxisd(i < raised ? swing : 0, Vector3::UnitY()));
    EntityDesc ball = Ball(hook + turn * down, kRadius);
    ball.pose.orientation = turn;
    Material& material = ball.rigid_body->geometries[0].material;
    material.restitution = 1;
    material.friction = 0;
    const EntityId id = Add(*cradle.world, ball);
    const Quaternion along_y = FrameAlong(Vector3::UnitY()).orientation;
    Join(*cradle.world,
         {.entity_b = {.id = id}, .frame_in_a = Pose{hook, along_y}, .frame_in_b = Pose{-down, along_y}, .kind = kind});
    cradle.balls.push_back(id);
    cradle.hooks.push_back(hook);
  }
  return cradle;
}

// m, by which a ball is elsewhere than it should be at most, at any of the ends of eighths of a second, of which there
// are 20: two strokes and a half.
double WorstOf(const Cradle& cradle, int raised, double swing) {
  constexpr double kEighth = 1.0 / 8;
  constexpr int kSmall = 500;
  const double pull = kGravity / (kLength * (1 + 0.4 * kRadius * kRadius / (kLength * kLength)));
  double angle = -swing, rate = 0, worst = 0;
  for (int eighth = 0; eighth < 20; ++eighth) {
    for (int i = 0; i < kSmall; ++i) {  // leapfrog
      const double h = kEighth / kSmall;
      rate -= h / 2 * pull * std::sin(angle);
      angle += h * rate;
      rate -= h / 2 * pull * std::sin(angle);
    }
    Steps(*cradle.world, 30);
    for (int i = 0; i < kBalls; ++i) {
      const bool is_out = angle < 0 ? i < raised : i >= kBalls - raised;
      const double its = is_out ? angle : 0;
      const auto place = static_cast<size_t>(i);
      const Vector3 there = cradle.hooks[place] + kLength * Vector3(std::sin(its), 0, -std::cos(its));
      worst = std::max(worst, (PositionOf(*cradle.world, cradle.balls[place]) - there).norm());
    }
  }
  return worst;
}

TEST_P(JointsCradle, PassesOnHoweverFarAndHoweverManyAreDrawnAside) {
  Proves({Claim::kJointHinge});
  for (const uint32_t substeps : {1, 2}) {
    for (const int raised : {1, 2, 3}) {
      for (const double swing : {0.3, 0.45, 0.6, 0.75, 0.9}) {
        const Cradle cradle = MakeCradle(GetParam(), substeps, HingeJoint{}, raised, swing, 0);
        EXPECT_LT(WorstOf(cradle, raised, swing), 5e-4) << raised << " by " << swing << ", substeps " << substeps;
      }
    }
  }
}

// Rounding and how it was put together leave balls a little apart or pressed against each other.
TEST_P(JointsCradle, PassesOnWhetherItsBallsJustTouchOrNot) {
  Proves({Claim::kJointBall});
  for (const double gap : {-1e-5, -1e-6, 1e-6, 1e-5}) {
    for (const double swing : {0.4, 0.8}) {
      const Cradle cradle = MakeCradle(GetParam(), 2, BallJoint{}, 1, swing, gap);
      EXPECT_LT(WorstOf(cradle, 1, swing), 5e-4) << gap << " m apart, by " << swing;
    }
  }
}

}  // namespace
}  // namespace genphys::testing

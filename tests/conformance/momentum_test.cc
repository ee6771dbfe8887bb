// What bodies on smooth ground pass on to each other: along the ground nobody else gives them anything, whoever is hit
// and whenever, so that momentum is known whatever comes of it.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/energy.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Momentum, Claim::kContacts, Claim::kBox, Claim::kSphere);

constexpr double kGravity = 9.81;
constexpr double kRadius = 0.1;
// Of a blow: some thousand sums of what was rounded.
constexpr double kLost = 1e-9;

EntityDesc Smooth(EntityDesc body) {
  Material& material = body.rigid_body->geometries[0].material;
  material.friction = material.restitution = 0;
  material.friction_mixing = Mixing::kMinimum;
  return body;
}

EntityDesc Thrown(EntityDesc body, const Vector3& velocity) {
  body.rigid_body->linear_velocity = velocity;
  return body;
}

std::unique_ptr<World> FloorOf(const std::string& engine, uint64_t seed, bool sleeps) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}};
  desc.stepper.step_size = seed % 2 == 0 ? 1.0 / 240 : 1.0 / 60;
  if (seed % 3 == 1) desc.stepper.quality = Quality::kAccurate;
  desc.default_auto_disable = {.enabled = sleeps, .rest_time = 0.1};
  return MakeWorld(desc);
}

Vector3 AlongGround(const Vector3& vector) { return {vector.x(), vector.y(), 0}; }

TEST_P(Momentum, StaysInRowsThatLieOnTheGroundAndAreHit) {
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const bool are_balls = seed % 4 == 3, sleeps = seed % 5 == 0;
    const auto world = FloorOf(GetParam(), seed, sleeps);
    const int count = 2 + static_cast<int>(seed % 5);
    double x = 0;
    for (int i = 0; i < count; ++i) {
      const double mass = random.LogUniform(0.1, 10);
      Add(*world,
          Smooth(are_balls ? Ball({x, 0, 0.5}, 0.5, mass) : Body(Box{Vector3::Constant(0.5)}, {x, 0, 0.5}, mass)));
      x += 1 + (random.Chance(0.5) ? 0 : random.Uniform(0, 1e-3));
    }
    Steps(*world, 60);
    const double side = random.Chance(0.5) ? 1 : -1, speed = random.LogUniform(sleeps ? 2 : 0.1, 10);
    const double end = side > 0 ? -0.5 : x - 0.4, away = kRadius + speed * random.Uniform(0.01, 0.1);
    const double mass = random.LogUniform(0.05, 1), height = are_balls ? 0.5 : random.Uniform(0.15, 0.8);
    EntityDesc ball = Smooth(Ball({end - side * away, 0, height}, kRadius, mass));
    ball.rigid_body->gravity_scale = 0;
    Add(*world, Thrown(ball, {side * speed, 0, 0}));
    const Vector3 before = AlongGround(MomentumOf(*world));
    for (int step = 0; step < 60; ++step) {
      Steps(*world, 1);
      ASSERT_LE((AlongGround(MomentumOf(*world)) - before).norm(), kLost * mass * speed) << step;
    }
  }
}

TEST_P(Momentum, StaysInStacksThatStandSideBySide) {
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = FloorOf(GetParam(), seed, false);
    const int count = 2 + static_cast<int>(seed % 3);
    for (int i = 0; i < count; ++i) {
      const int height = 1 + static_cast<int>(random.Uniform(0, 3));
      for (int j = 0; j < height; ++j) {
        // Between two of them there is friction; the ground is smooth, for of both materials the smoother one counts.
        EntityDesc crate = Body(Box{Vector3::Constant(0.5)}, {1.0 * i, 0, 0.5 + j}, random.Uniform(0.5, 2));
        Add(*world, j == 0 ? Smooth(crate) : crate);
      }
    }
    Steps(*world, 30);
    const double speed = random.LogUniform(0.1, 10), mass = random.LogUniform(0.05, 1);
    EntityDesc sled = Smooth(Body(Box{Vector3::Constant(kRadius)}, {-0.6 - speed * 0.05, 0, kRadius}, mass));
    Add(*world, Thrown(sled, {speed, 0, 0}));
    const Vector3 before = AlongGround(MomentumOf(*world));
    for (int step = 0; step < 60; ++step) {
      Steps(*world, 1);
      ASSERT_LE((AlongGround(MomentumOf(*world)) - before).norm(), kLost * mass * speed) << step;
    }
  }
}

// Those who push each other all the time owe each other something at every boundary, and one of them begins anew.
TEST_P(Momentum, GrowsByWhatPushesARowAndByWhatHitsIt) {
  Proves({Claim::kForce, Claim::kImpulse});
  constexpr int kCount = 4;
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = FloorOf(GetParam(), seed, false);
    std::vector<EntityId> row;
    for (int i = 0; i < kCount; ++i) {
      row.push_back(Add(*world, Smooth(Body(Box{Vector3::Constant(0.5)}, {1.0 * i, 0, 0.5}, random.Uniform(0.5, 2)))));
    }
    const double force = random.Uniform(5, 20);
    Do(*world, ApplyForce{.id = row[0], .force = {force, 0, 0}, .steps = 100});
    Steps(*world, 20);
    const double mass = random.LogUniform(0.05, 1), speed = random.Uniform(1, 10);
    const double there = PositionOf(*world, row[kCount - 1]).x() + 0.5 + kRadius;
    EntityDesc ball = Smooth(Ball({there + speed * random.Uniform(0.01, 0.1), 0, 0.5}, kRadius, mass));
    ball.rigid_body->gravity_scale = 0;
    Add(*world, Thrown(ball, {-speed, 0, 0}));
    double along = MomentumOf(*world).x();
    for (int step = 0; step < 40; ++step) {
      if (step == 20) {
        const double impulse = random.Uniform(-1, 1);
        Do(*world, ApplyImpulse{.id = row[1 + seed % 3], .linear = {impulse, 0, 0}});
        along += impulse;
      }
      Steps(*world, 1);
      along += force * world->scene().world.stepper.step_size;
      ASSERT_NEAR(MomentumOf(*world).x(), along, kLost * std::abs(along) + kLost * mass * speed) << step;
    }
  }
}

}  // namespace
}  // namespace genphys::testing

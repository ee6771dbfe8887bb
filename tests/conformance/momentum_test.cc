// What bodies on smooth ground, or in space, pass on to each other: along the ground nobody else gives them anything,
// whoever is hit and whenever, so that momentum is known whatever comes of it.
#include <cmath>

#include "conformance/engine_test.h"
#include "support/energy.h"
#include "support/joints.h"
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

// Boxes in space that are thrown at each other, and stay together or not.
std::unique_ptr<World> CloudOf(const std::string& engine, int rate, int count, double restitution, uint64_t seed) {
  Random random(seed);
  auto world = MakeSpace(engine, {.step_size = 1.0 / rate}, Vector3::Zero());
  Require(*world, Feature::kContacts);
  for (int i = 0; i < count; ++i) {
    const Vector3 place(0.9 * (i % 4), 0.9 * (i / 4 % 2), 0.9 * (i / 8));
    const Vector3 middle = 0.45 * Vector3(std::min(count, 4) - 1, count > 4, count > 8);
    const Vector3 half_extents(random.Uniform(0.1, 0.4), random.Uniform(0.1, 0.4), random.Uniform(0.1, 0.4));
    EntityDesc box = Body(Box{half_extents}, place - middle, random.Uniform(0.5, 3));
    box.rigid_body->geometries[0].material.restitution = restitution;
    box.rigid_body->linear_velocity = 1.5 * (middle - place) + random.Vector(count > 4 ? 1 : 0.2);
    box.rigid_body->angular_velocity = random.Vector(3);
    Add(*world, box);
  }
  return world;
}

struct Turning {
  double most = 0;  // by which the angular momentum was ever seen to change, as a part of what there is
  double last = 0;  // at the end
};

Turning ChangeIn(World& world, int steps) {
  double all = 0;
  for (const auto& entity : world.scene().entities) {
    if (!entity) continue;
    const uint32_t row = entity->id.index();
    const Vector3 place = world.state().positions.col(row), velocity = world.state().linear_velocities.col(row);
    all += entity->mass.mass * place.norm() * velocity.norm();
  }
  const Vector3 before = AngularMomentumOf(world);
  Turning change;
  for (int i = 0; i < steps; ++i) {
    Steps(world, 1);
    change.last = (AngularMomentumOf(world) - before).norm() / all;
    change.most = std::max(change.most, change.last);
  }
  return change;
}

// They owe each other something at every boundary, and overlap a little, which is made up for.
TEST_P(Momentum, OfTurningStaysInTwoThatMeetInSpace) {
  for (const int rate : {60, 240}) {
    for (const double restitution : {0.0, 0.1, 0.5}) {
      for (uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(::testing::Message() << rate << " steps/s, e = " << restitution << ", seed " << seed);
        const Turning change = ChangeIn(*CloudOf(GetParam(), rate, 2, restitution, seed), 2 * rate);
        EXPECT_LE(change.most, 1e-6);
        EXPECT_LE(change.last, 1e-10);
      }
    }
  }
}

// Blows that come one after the other within a substep are taken to where each of them was: to first order only.
TEST_P(Momentum, OfTurningStaysInCrowdsThatMeetInSpace) {
  for (const int rate : {60, 240}) {
    for (const double restitution : {0.0, 0.1, 0.5}) {
      for (uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE(::testing::Message() << rate << " steps/s, e = " << restitution << ", seed " << seed);
        EXPECT_LE(ChangeIn(*CloudOf(GetParam(), rate, 16, restitution, seed), 2 * rate).most, 0.02 / rate);
      }
    }
  }
}

// Who was hit where he is, and is taken back from there for another blow, still has what holds him meanwhile.
TEST_P(Momentum, StaysInCrowdsThatMeetInSpace) {
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    const auto world = CloudOf(GetParam(), 60, 16, 0, seed);
    const Vector3 before = MomentumOf(*world);
    for (int step = 0; step < 45; ++step) {
      Steps(*world, 1);
      ASSERT_LE((MomentumOf(*world) - before).norm(), kLost) << step;
    }
  }
}

TEST_P(Momentum, OfTurningIsNotGivenToSmoothBallsThatMeetInSpace) {
  Random random(1);
  const auto world = MakeSpace(GetParam(), {.step_size = 1.0 / 60}, Vector3::Zero());
  Require(*world, Feature::kContacts);
  std::vector<EntityId> balls;
  for (int i = 0; i < 16; ++i) {
    const Vector3 place = Vector3(0.5 * (i % 4), 0.5 * (i / 4 % 2), 0.5 * (i / 8)) - Vector3(0.75, 0.25, 0.25);
    EntityDesc ball = Smooth(Ball(place, random.Uniform(0.1, 0.28), random.Uniform(0.5, 3)));
    balls.push_back(Add(*world, Thrown(ball, random.Vector(0.5) - place)));
  }
  for (int step = 0; step < 120; ++step) {
    Steps(*world, 1);
    for (const EntityId ball : balls) ASSERT_LE(SpinOf(*world, ball).norm(), 1e-12) << step;
  }
}

}  // namespace
}  // namespace genphys::testing

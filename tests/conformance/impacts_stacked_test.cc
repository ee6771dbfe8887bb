// What lies on others and is hit by something that falls: they pass the blow on to the floor, so that it is thrown back
// as by the floor itself (Newton's law, for what rests has no speed of its own).
#include <algorithm>
#include <cmath>

#include "conformance/engine_test.h"
#include "support/random.h"
#include "support/smooth.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ImpactsOfStacked, Claim::kContacts, Claim::kRestitution, Claim::kBox, Claim::kSphere);

constexpr double kGravity = 9.81;
constexpr double kRadius = 0.2;
constexpr double kRestSpeed = 1e-2;  // m/s: what is slower may sleep

EntityDesc Springy(EntityDesc body, double restitution) {
  body.rigid_body->geometries[0].material.restitution = restitution;
  return body;
}

std::unique_ptr<World> FloorOf(const std::string& engine, double step, bool sleeps) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = step}};
  desc.default_auto_disable = {.enabled = sleeps, .linear_speed_max = kRestSpeed, .rest_time = 0.1};
  return MakeWorld(desc);
}

// How high it gets when it goes as it does now, above where its centre is when it lies on `top`.
double RiseOf(World& world, EntityId ball, double top) {
  const double up = VelocityOf(world, ball).z();
  return PositionOf(world, ball).z() - top - kRadius + up * up / 2 / kGravity;
}

// J, of motion and of height.
double EnergyOf(World& world, EntityId id, double mass, double moment) {
  return mass * (VelocityOf(world, id).squaredNorm() / 2 + kGravity * PositionOf(world, id).z()) +
         moment * SpinOf(world, id).squaredNorm() / 2;
}

TEST_P(ImpactsOfStacked, ThrowBackWhatFallsOnThemAsTheFloorWould) {
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double restitution = random.Uniform(0.4, 1), fall = random.Uniform(0.5, 1.5);
    const double step = seed % 2 == 0 ? 1.0 / 60 : 1.0 / 240;
    const int count = 2 + static_cast<int>(seed % 9);
    const auto world = FloorOf(GetParam(), step, true);
    std::vector<EntityId> crates;
    for (int i = 0; i < count; ++i) crates.push_back(Add(*world, Springy(Crate({0, 0, 0.5 + i}), restitution)));
    const Vector3 from(random.Uniform(-0.4, 0.4), random.Uniform(-0.4, 0.4), count + kRadius + fall);
    const EntityId ball = Add(*world, Springy(Ball(from, kRadius, random.LogUniform(0.1, 10)), restitution));
    Steps(*world, static_cast<int>(std::sqrt(2 * fall / kGravity) / step) + 2);
    // Where the topmost lies once the stack has settled.
    const double top = PositionOf(*world, crates.back()).z() + 0.5;
    const double fell = from.z() - kRadius - top;
    // What wakes when it comes near moves a little at first: it is thrown back from that.
    const double error = 2 * restitution * (1 + restitution) * kRestSpeed * std::sqrt(fell / 2 / kGravity);
    EXPECT_NEAR(RiseOf(*world, ball, top), restitution * restitution * fell, error);
    std::vector<Vector3> places;
    for (const EntityId crate : crates) places.push_back(PositionOf(*world, crate));
    Steps(*world, 2);
    for (size_t i = 0; i < crates.size(); ++i) {
      EXPECT_LE((PositionOf(*world, crates[i]) - places[i]).norm(), 2 * step * kRestSpeed) << i;
    }
  }
}

TEST_P(ImpactsOfStacked, PassItOnToAllOnWhichTheyLie) {
  constexpr int kRows = 4;
  constexpr double kSpacing = 1.1, kFall = 1, kRestitution = 0.8;
  for (const double mass : {0.1, 1.0, 10.0}) {
    const auto world = FloorOf(GetParam(), 1.0 / 60, true);
    for (int row = 0; row < kRows; ++row) {
      for (int i = 0; i < kRows - row; ++i) {
        Add(*world, Springy(Crate({(i + row / 2.0) * kSpacing, 0, 0.5 + row}), kRestitution));
      }
    }
    const Vector3 from((kRows - 1) / 2.0 * kSpacing, 0, kRows + kRadius + kFall);
    const EntityId ball = Add(*world, Springy(Ball(from, kRadius, mass), kRestitution));
    Steps(*world, static_cast<int>(std::sqrt(2 * kFall / kGravity) * 60) + 2);
    EXPECT_NEAR(RiseOf(*world, ball, kRows), kRestitution * kRestitution * kFall, 2e-3);
  }
}

TEST_P(ImpactsOfStacked, ThrowBackSeveralAtOnce) {
  constexpr int kCount = 3;
  constexpr double kFall = 1, kRestitution = 0.8;
  const auto world = FloorOf(GetParam(), 1.0 / 60, true);
  std::vector<EntityId> balls;
  for (int stack = 0; stack < 12; ++stack) {
    for (int i = 0; i < kCount; ++i) Add(*world, Springy(Crate({2.0 * stack, 0, 0.5 + i}), kRestitution));
    for (const double y : {-0.25, 0.25}) {
      const Vector3 from(2.0 * stack, y, kCount + kRadius + kFall);
      balls.push_back(Add(*world, Springy(Ball(from, kRadius, y < 0 ? 1 : 3), kRestitution)));
    }
  }
  Steps(*world, static_cast<int>(std::sqrt(2 * kFall / kGravity) * 60) + 2);
  for (const EntityId ball : balls) {
    EXPECT_NEAR(RiseOf(*world, ball, kCount), kRestitution * kRestitution * kFall, 2e-3);
  }
}

TEST_P(ImpactsOfStacked, StayInPlaceUnderWhatComesToRestOnThem) {
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double step = seed % 2 == 0 ? 1.0 / 60 : 1.0 / 240, fall = random.Uniform(0.3, 3);
    const int count = 2 + static_cast<int>(seed % 5);
    const auto world = FloorOf(GetParam(), step, seed % 3 != 0);
    std::vector<EntityId> crates;
    for (int i = 0; i < count; ++i)
      crates.push_back(Add(*world, Crate({0, 0, 0.5 + i}, 0.5, random.LogUniform(0.5, 2))));
    Steps(*world, 20);
    const double mass = random.LogUniform(0.1, 10), top = PositionOf(*world, crates.back()).z() + 0.5;
    const Vector3 from(random.Uniform(-0.2, 0.2), random.Uniform(-0.2, 0.2), top + kRadius + fall);
    const EntityId ball = Add(*world, Ball(from, kRadius, mass));
    Steps(*world, static_cast<int>(std::sqrt(2 * fall / kGravity) / step) + 1);
    for (int i = 0; i < 3; ++i) {
      // Half of a substep of their weight may show, and what that takes them in a step.
      const double fallen = kGravity * step / 4;
      double fastest = 0;
      for (const EntityId crate : crates) fastest = std::max(fastest, VelocityOf(*world, crate).norm());
      EXPECT_LT(fastest, fallen + 1e-3 * mass) << mass << " kg";
      EXPECT_NEAR(PositionOf(*world, ball).z(), top + kRadius, fallen * step);
      Steps(*world, 1);
    }
  }
}

// The floor and what lies on it are smooth, so that nothing from outside acts along them.
TEST_P(ImpactsOfStacked, AreMovedAlongByWhatSlidesOntoThem) {
  constexpr int kCount = 3;
  constexpr double kFall = 1, kAside = 3, kMass = 2, kFriction = 0.2;
  const auto rough = [&](EntityDesc body) {
    body.rigid_body->geometries[0].material.friction = kFriction;
    body.rigid_body->geometries[0].material.friction_mixing = Mixing::kMinimum;
    return body;
  };
  for (const double step : {1.0 / 60, 1.0 / 240}) {
    const auto world = FloorOf(GetParam(), step, false);
    std::vector<EntityId> crates{Add(*world, Smooth(Crate({0, 0, 0.5}), 0))};
    for (int i = 1; i < kCount; ++i) crates.push_back(Add(*world, rough(Crate({0, 0, 0.5 + i}))));
    Steps(*world, 20);
    const double down = std::sqrt(2 * kFall / kGravity);
    EntityDesc box = Body(Box{{0.2, 0.2, 0.2}}, {-kAside * down, 0, kCount + 0.2 + kFall}, kMass);
    box.rigid_body->linear_velocity.x() = kAside;
    const EntityId sliding = Add(*world, rough(box));
    Steps(*world, static_cast<int>(down / step) + 1);
    Vector3 momentum = kMass * VelocityOf(*world, sliding);
    for (const EntityId crate : crates) momentum += VelocityOf(*world, crate);
    // It still slides, slowed down by what pressed it onto them, and by what has pulled it since.
    EXPECT_LE(VelocityOf(*world, sliding).x(), kAside - kFriction * (1 - 1e-6) * kGravity * down);
    EXPECT_GT(VelocityOf(*world, sliding).x(), kAside / 2);
    EXPECT_NEAR(momentum.x(), kMass * kAside, 1e-9);
  }
}

// Crooked stacks on which it falls askew: those below tip and slide, and give way. What overlaps then is pushed apart,
// which lifts some by less than a millimetre.
TEST_P(ImpactsOfStacked, GiveNobodyEnergyWhereTheyGiveWay) {
  Proves({Claim::kKineticFriction});
  constexpr double kLift = 1e-3;
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = FloorOf(GetParam(), 1.0 / 240, false);
    const int count = 2 + static_cast<int>(seed % 4);
    std::vector<EntityId> crates;
    Vector3 place(0, 0, 0.5);
    const auto rough = [&](EntityDesc body, double restitution) {
      body.rigid_body->geometries[0].material.friction = random.Uniform(0, 1);
      return Springy(body, restitution);
    };
    for (int i = 0; i < count; ++i) {
      crates.push_back(Add(*world, rough(Crate(place), random.Uniform(0, 1))));
      place += Vector3(random.Uniform(-0.2, 0.2), random.Uniform(-0.2, 0.2), 1);
    }
    const double mass = random.LogUniform(0.1, 10);
    const Vector3 from = place + Vector3(random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5), 0);
    EntityDesc falling = rough(Ball(from, kRadius, mass), random.Uniform(0.5, 1));
    falling.rigid_body->linear_velocity = {random.Uniform(-2, 2), random.Uniform(-2, 2), random.Uniform(-6, 0)};
    const EntityId ball = Add(*world, falling);
    const auto energy = [&] {
      double sum = EnergyOf(*world, ball, mass, 0.4 * mass * kRadius * kRadius);
      for (const EntityId crate : crates) sum += EnergyOf(*world, crate, 1, 1.0 / 6);
      return sum;
    };
    // From when it hits them, a few steps: from then on they jostle.
    double gain = 0, before = energy();
    int since = 0;
    for (int step = 0; step < 120 && since < 4; ++step) {
      const double falls = VelocityOf(*world, ball).z();
      Steps(*world, 1);
      since += since > 0 || VelocityOf(*world, ball).z() > falls;
      const double now = energy();
      gain = std::max(gain, now - before);
      before = now;
    }
    EXPECT_LE(gain, kLift * kGravity * (count + mass));
  }
}

}  // namespace
}  // namespace genphys::testing

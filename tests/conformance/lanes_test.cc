// No lane changes what happens: a world whose bodies all go through the engine does the same within the errors of the
// method, and the same to the last bit when it is done again.
#include <cmath>
#include <vector>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Lanes, Claim::kEnginesAgree);

constexpr double kGravity = 9.81;
constexpr double kStep = 1.0 / 60;
// Of numbers up to a hundred.
constexpr double kRounding = 100 * kRounded;

std::unique_ptr<World> MakeSpace(const std::string& engine, bool engine_only, bool ground_plane = false) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .ground_plane = ground_plane};
  desc.stepper.engine_only = engine_only;
  auto world = MakeWorld(desc);
  world->set_record_stats(true);
  return world;
}

EntityDesc Thrown(double damping) {
  EntityDesc crate = Body(Box{{0.2, 0.3, 0.5}}, {0, 0, 50});
  crate.rigid_body->linear_velocity = {4, -3, 10};
  crate.rigid_body->angular_velocity = {3, 1, 0.5};
  crate.rigid_body->linear_damping = damping;
  crate.rigid_body->angular_damping = damping;
  return crate;
}

double AngleBetween(const World& a, const World& b, EntityId id) {
  return a.Describe(id)->pose.orientation.angularDistance(b.Describe(id)->pose.orientation);
}

TEST_P(Lanes, AreLeftForTheEngineWhereThatIsAskedFor) {
  for (const bool engine_only : {false, true}) {
    const auto world = MakeSpace(GetParam(), engine_only);
    Add(*world, Thrown(0));
    Steps(*world, 3);

    EXPECT_EQ(world->stats().entities_in_flight, engine_only ? 0u : 1u);
    EXPECT_EQ(world->stats().entities_in_engine, engine_only ? 1u : 0u);
  }
}

TEST_P(Lanes, OfFlightAreLeftByThoseAloneWhomFieldsMayActOn) {
  const auto world = MakeSpace(GetParam(), false);
  std::vector<EntityId> ids;
  for (int i = 0; i < 4; ++i) {
    EntityDesc ball = Ball({10.0 * i, 0, 50}, 0.5);
    ball.rigid_body->linear_velocity = {0, 3, 0};
    ids.push_back(Add(*world, ball));
  }
  const auto flying = [&] {
    Steps(*world, 1);
    return world->stats().entities_in_flight;
  };
  EXPECT_EQ(flying(), 4u);
  Do(*world, CreateForceField{{.kind = UniformField{.force = {0, 0, 1}}, .entities = {ids[0]}}});
  EXPECT_EQ(flying(), 3u) << "one is named";
  Do(*world, CreateForceField{{.kind = SpringField{.a = ids[1], .rest_length = 1, .stiffness = 1}}});
  EXPECT_EQ(flying(), 2u) << "one hangs on a spring";
  const Region ahead{{15, 2, 0}, {25, 4, 100}};
  Do(*world, CreateForceField{{.kind = UniformField{.acceleration = {0, 0, 5}}, .region = ahead}});
  EXPECT_EQ(flying(), 2u) << "nobody is in the region";
  Steps(*world, 50);
  EXPECT_EQ(world->stats().entities_in_flight, 1u) << "one came into it";
  EXPECT_GT(VelocityOf(*world, ids[2]).z(), VelocityOf(*world, ids[3]).z() + 0.5);
  Steps(*world, 60);
  EXPECT_EQ(world->stats().entities_in_flight, 2u) << "and left it";
  Do(*world, CreateForceField{{UniformField{.acceleration = {0, 0, 1}}}});
  EXPECT_EQ(flying(), 0u) << "this one acts on all";
}

TEST_P(Lanes, TellHowManyIslandsTheEngineWasGiven) {
  const auto world = MakeSpace(GetParam(), false, true);
  const auto lie = [&](const Vector3& position) {
    EntityDesc crate = Crate(position, 0.5);
    crate.rigid_body->auto_disable.enabled = false;
    return Add(*world, crate);
  };
  // Two stacks, two who are alone, and somebody who flies.
  lie({0, 0, 0.5});
  lie({0, 0, 1.5});
  const EntityId low = lie({10, 0, 0.5});
  lie({10, 0, 1.5});
  const EntityId joined = lie({13, 0, 0.5});
  lie({20, 0, 0.5});
  Add(*world, Thrown(0));
  Steps(*world, 20);

  EXPECT_EQ(world->stats().islands, 4u);
  EXPECT_EQ(world->stats().entities_in_engine, 6u);
  Join(*world, Between(low, joined, DistanceJoint{}));
  Steps(*world, 1);
  EXPECT_EQ(world->stats().islands, 3u);
  Do(*world, DeleteEntity{joined});
  Steps(*world, 1);
  EXPECT_EQ(world->stats().islands, 3u);
}

TEST_P(Lanes, OfFlightAndEngineGoTheSameWay) {
  constexpr int kSteps = 120;
  for (const double damping : {0.0, 0.1, 1.0}) {
    const auto with = MakeSpace(GetParam(), false), without = MakeSpace(GetParam(), true);
    const EntityId id = Add(*with, Thrown(damping));
    Add(*without, Thrown(damping));
    Steps(*with, kSteps);
    Steps(*without, kSteps);

    // In the engine's lane damping takes its halves before and after what pulls. The first half of a substep so begins
    // with c g h^2 / 8 too much, each substep adds g h (c h)^2 / 12 to that, and goes by its middle velocity v where it
    // would go by (c h)^2 / 24 (v - g / c) more. Turning goes by a mean spin of fourth order. Speeds begin with 12 m/s
    // and 3.2 rad/s.
    const double h = SubstepOf(*without), square = std::pow(damping * h, 2), time = kSteps * kStep;
    const double first = damping * kGravity * h * h / 8, rate = kGravity * square / 12;
    const double aside = (12 * square + kGravity * damping * h * h) / 24;
    const double turned = 3.2 * time * (std::pow(3.2 * h, 4) + square / 24);
    EXPECT_LE((PositionOf(*with, id) - PositionOf(*without, id)).norm(),
              2 * ((first + aside) * time + rate * time * time / 2) + kRounding)
        << damping;
    EXPECT_LE((VelocityOf(*with, id) - VelocityOf(*without, id)).norm(), 2 * (first + rate * time) + kRounding)
        << damping;
    EXPECT_LE(AngleBetween(*with, *without, id), 2 * turned) << damping;
  }
}

TEST_P(Lanes, MayBeLeftAndTakenInFlight) {
  const auto world = MakeSpace(GetParam(), false);
  const EntityId id = Add(*world, Thrown(0));
  const Vector3 start = PositionOf(*world, id), velocity = VelocityOf(*world, id);
  StepperDesc stepper;
  for (int i = 0; i < 12; ++i) {
    stepper.engine_only = !stepper.engine_only;
    Do(*world, SetStepper{stepper});
    Steps(*world, 10);
  }

  const double time = 120 * kStep;
  const Vector3 exact = start + time * velocity - Vector3(0, 0, kGravity * time * time / 2);
  EXPECT_LE((PositionOf(*world, id) - exact).norm(), kRounding);
}

// Balls far apart, each of which bounces off the floor by itself.
TEST_P(Lanes, TellTheSameOfWhatBounces) {
  constexpr int kBalls = 6, kSteps = 150;
  std::vector<std::vector<Event>> told;
  std::vector<Vector3> places;
  double longest = 0;  // solve, s
  for (const bool engine_only : {false, true}) {
    WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -kGravity}};
    desc.stepper.engine_only = engine_only;
    desc.default_material.restitution = 0.8;
    const auto world = testing::MakeWorld(desc);
    Random random(5);
    std::vector<EntityId> balls;
    for (int i = 0; i < kBalls; ++i) {
      EntityDesc ball = Ball({20.0 * i, 0, random.Uniform(2, 6)});
      ball.rigid_body->linear_velocity = {random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(0, 3)};
      balls.push_back(Add(*world, ball));
    }
    Steps(*world, kSteps);
    longest = std::max(longest, SubstepOf(*world));
    told.push_back(world->TakeEvents());
    for (const EntityId ball : balls) places.push_back(PositionOf(*world, ball));
  }

  ASSERT_EQ(told[0].size(), told[1].size());
  for (size_t i = 0; i < told[0].size(); ++i) {
    EXPECT_EQ(told[0][i].kind.index(), told[1][i].kind.index()) << i;
    EXPECT_EQ(told[0][i].step, told[1][i].step) << i;
  }
  // Flight is exact in both, and at up to 11 m/s an impact is found a little late, as is that of the next bounce after
  // it: a place is off by twice of what both ways leave of the place of each.
  constexpr int kBounces = 2;
  const double found = 2 * kBounces * ImpactDepth(11, longest);
  for (size_t i = 0; i < kBalls; ++i) EXPECT_LE((places[i] - places[kBalls + i]).norm(), 2 * found) << i;
}

// One ball glances off another so fast that the second one flies on to a third within the same substep, which was in
// nobody's way before.
TEST_P(Lanes, AreLeftByWhomSomethingThrownBackMeets) {
  Proves({Claim::kSphere, Claim::kRestitution});
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double radius = 0.1, speed = random.LogUniform(100, 300), aside = random.Uniform(0.3, 0.9);
    // From the first to the second where they touch; along it the second one goes then.
    const double aslant = aside * std::sqrt(2.0) * radius;
    const Vector3 normal = Vector3(std::sqrt(4 * radius * radius - aslant * aslant), aslant, 0).normalized();
    for (const bool engine_only : {false, true}) {
      WorldDesc desc{.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false};
      desc.stepper.engine_only = engine_only;
      desc.stepper.quality = Quality::kFast;
      desc.default_material = {.friction = 0, .restitution = 1};
      const auto world = testing::MakeWorld(desc);
      Require(*world, Feature::kContacts);
      EntityDesc first = Ball(-2 * radius * normal - Vector3(0.3 * speed * kStep, 0, 0), radius);
      first.rigid_body->linear_velocity = {speed, 0, 0};
      Add(*world, first);
      Add(*world, Ball(Vector3::Zero(), radius));
      const EntityId third = Add(*world, Ball(0.8 * normal, radius));
      Steps(*world, 1);
      EXPECT_NEAR(VelocityOf(*world, third).norm(), speed * normal.x(), 1e-3 * speed) << engine_only;
    }
  }
}

// By the end of the substep both are past the other one.
TEST_P(Lanes, LeaveNobodyUnmetWhoseWayIsCrossed) {
  Proves({Claim::kSphere, Claim::kRestitution});
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double radius = random.LogUniform(0.02, 0.1), speed = random.LogUniform(60, 300);
    const double time = random.Uniform(0.3, 0.7) * kStep;
    for (const bool engine_only : {false, true}) {
      WorldDesc desc{.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false};
      desc.stepper.engine_only = engine_only;
      desc.stepper.quality = Quality::kFast;
      desc.default_material = {.friction = 0, .restitution = 1};
      const auto world = testing::MakeWorld(desc);
      Require(*world, Feature::kContacts);
      std::vector<EntityId> balls;
      for (const Vector3& way : {Vector3(speed, 0, 0), Vector3(0, speed, 0)}) {
        EntityDesc ball = Ball(-time * way, radius);
        ball.rigid_body->linear_velocity = way;
        balls.push_back(Add(*world, ball));
      }
      Steps(*world, 1);
      // They exchange what they have along the diagonal between them.
      EXPECT_LE((VelocityOf(*world, balls[0]) - Vector3(0, speed, 0)).norm(), 1e-3 * speed) << engine_only;
      EXPECT_LE((VelocityOf(*world, balls[1]) - Vector3(speed, 0, 0)).norm(), 1e-3 * speed) << engine_only;
    }
  }
}

// A ball hits a second one and throws it into the way of a third, in one substep at whose end that is far away. Returns
// how the third one goes on, if its frame is `aside` (m) from it.
Vector3 CrossedWithItsFrameAside(const WorldDesc& desc, Random& random, const Vector3& aside) {
  constexpr double kRadius = 0.1, kSpeed = 200, kAcross = 600;
  const double hit = random.Uniform(0.1, 0.4) * kStep, meeting = random.Uniform(0.6, 0.95) * kStep;
  const auto world = testing::MakeWorld(desc);
  Require(*world, Feature::kContacts);
  EntityDesc first = Ball({-2 * kRadius - kSpeed * hit, 0, 0}, kRadius);
  first.rigid_body->linear_velocity = {kSpeed, 0, 0};
  Add(*world, first);
  Add(*world, Ball(Vector3::Zero(), kRadius));
  const Vector3 across = kAcross * Vector3(0, 0.8, 0.6);
  EntityDesc third = Ball(Vector3(kSpeed * (meeting - hit) + 0.03, 0, 0) - meeting * across - aside, kRadius);
  third.rigid_body->geometries.front().pose_in_entity.position = aside;
  third.rigid_body->linear_velocity = across;
  const EntityId id = Add(*world, third);
  Steps(*world, 1);
  EXPECT_GT((VelocityOf(*world, id) - across).norm(), kSpeed / 10) << "they meet";
  return VelocityOf(*world, id);
}

TEST_P(Lanes, LeaveNobodyUnmetWhoseFrameIsElsewhere) {
  Proves({Claim::kSphere, Claim::kRestitution});
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    for (const bool engine_only : {false, true}) {
      WorldDesc desc{.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false};
      desc.stepper.engine_only = engine_only;
      desc.stepper.quality = Quality::kFast;
      desc.default_material = {.friction = 0, .restitution = 1};
      Random random(seed), again(seed);
      const Vector3 aside = 10 * Random(seed + 100).Direction();
      const Vector3 expected = CrossedWithItsFrameAside(desc, random, Vector3::Zero());
      EXPECT_LE((CrossedWithItsFrameAside(desc, again, aside) - expected).norm(), 1e-3 * expected.norm())
          << engine_only;
    }
  }
}

TEST_P(Lanes, ThatAreLeftGiveTheSameBitsAgain) {
  std::vector<uint64_t> hashes;
  for (int run = 0; run < 2; ++run) {
    const auto world = MakeSpace(GetParam(), true, true);
    Random random(9);
    for (int i = 0; i < 20; ++i) {
      EntityDesc crate = Thrown(0.1);
      crate.pose.position = {random.Uniform(-2, 2), random.Uniform(-2, 2), random.Uniform(1, 8)};
      Add(*world, crate);
    }
    Steps(*world, 200);
    hashes.push_back(world->StateHash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

}  // namespace
}  // namespace genphys::testing

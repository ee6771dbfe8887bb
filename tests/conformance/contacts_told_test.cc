// What is told of the contacts of an entity is how the last substep had them, and not how the next one goes on.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <vector>

#include "conformance/engine_test.h"
#include "genphys/work_watch.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ContactsTold, Claim::kContacts, Claim::kContactsOf);

constexpr double kGravity = 9.81;
// Of what is solved to rounding in sweeps.
constexpr double kSolved = 1e-6;

struct Rubbed {
  double pressed = 0;                    // N*s
  Vector3 friction = Vector3::Zero();    // N*s
  Vector3 velocities = Vector3::Zero();  // m/s, the sum of all points
};

Rubbed SumOf(const std::vector<EventContactPoint>& points) {
  Rubbed sum;
  for (const EventContactPoint& point : points) {
    sum.pressed += point.normal_impulse;
    sum.friction += point.friction_impulse;
    sum.velocities += point.relative_velocity;
  }
  return sum;
}

TEST_P(ContactsTold, HaveTheFrictionAtRestAndTheImpulseOfWhatSlides) {
  Proves({Claim::kStaticFriction, Claim::kKineticFriction, Claim::kBox, Claim::kPlane});
  for (const double kinetic : {0.5, 0.3}) {
    WorldDesc desc{.engine = GetParam(), .gravity = {0, 0, -kGravity}};
    desc.default_material.friction = 0.5;
    desc.default_material.kinetic_friction = kinetic;
    const auto world = testing::MakeWorld(desc);
    EntityDesc body = Body(Box{{0.3, 0.2, 0.05}}, {0, 0, 0.05}, 3);
    body.rigid_body->linear_velocity.x() = 4;
    const EntityId block = Add(*world, body);
    Steps(*world, 10);

    const std::vector<EntityContact> contacts = world->ContactsOf(block).value();

    ASSERT_EQ(contacts.size(), 1u);
    for (const EventContactPoint& point : contacts[0].points) EXPECT_EQ(point.friction, 0.5);
    const Rubbed sum = SumOf(contacts[0].points);
    const double pressed = 3 * kGravity * SubstepOf(*world);
    EXPECT_NEAR(sum.pressed, pressed, kSolved * pressed);
    EXPECT_NEAR(sum.friction.norm(), kinetic * pressed, kSolved * pressed);
  }
}

// Up a slope, which x points down, and back: with one substep in a step its contacts are those of the event.
void ExpectAsTheEventsTell(const std::string& engine, const Material& material, const Shape& shape, double height) {
  constexpr double kSlope = 0.3;
  WorldDesc desc{.engine = engine,
                 .gravity = kGravity * Vector3(std::sin(kSlope), 0, -std::cos(kSlope)),
                 .stepper = {.substeps = 1},
                 .default_material = material};
  desc.default_auto_disable.enabled = false;
  desc.recorded_events.persisting_contacts = true;
  const auto world = testing::MakeWorld(desc);
  EntityDesc body = Body(shape, {0, 0, height}, 2);
  body.rigid_body->linear_velocity.x() = -0.5;
  const EntityId id = Add(*world, body);
  int turned = 0;
  for (int step = 0; step < 40; ++step) {
    const bool was_upwards = VelocityOf(*world, id).x() < 0;
    Steps(*world, 1);
    turned += was_upwards != (VelocityOf(*world, id).x() < 0) ? 1 : 0;
    const std::vector<ContactPersisted> told = Of<ContactPersisted>(world->TakeEvents());
    if (told.empty()) continue;
    ASSERT_EQ(told.size(), 1u);
    const std::vector<EntityContact> contacts = world->ContactsOf(id).value();
    ASSERT_EQ(contacts.size(), 1u);
    const Rubbed now = SumOf(contacts[0].points), event = SumOf(told[0].points);
    const double allowed = kSolved * now.pressed;
    EXPECT_NEAR(now.pressed, event.pressed, allowed) << step;
    EXPECT_LE((now.friction - event.friction).norm(), allowed) << step;
    EXPECT_LE((now.velocities - event.velocities).norm(), kSolved) << step;
  }
  EXPECT_EQ(turned, 1);
}

TEST_P(ContactsTold, OfWhatTurnsBackAreThoseOfItsLastSubstep) {
  Proves({Claim::kContactEvents, Claim::kContactImpulses});
  ExpectAsTheEventsTell(GetParam(), {.friction = 0.2, .kinetic_friction = 0.15}, Box{{0.3, 0.2, 0.05}}, 0.05);
  ExpectAsTheEventsTell(GetParam(), {.friction = 0.8, .rolling_friction = 0.01}, Sphere{0.2}, 0.2);
}

TEST_P(ContactsTold, OfAFloorUnderManyAreFoundInAboutTheTimeOfEach) {
  const auto time_of = [&](int across) {
    const auto world = MakeWorld();
    std::vector<Command> commands;
    const EntityId floor = Add(*world, Block({0, 0, -0.5}, {200, 200, 0.5}));
    for (int i = 0; i < across * across; ++i) {
      commands.push_back(CreateEntity{Ball({1.5 * (i % across), 1.5 * (i / across), 0.5})});
    }
    EXPECT_TRUE(world->Apply(commands).ok());
    Steps(*world, 2);
    auto least = std::chrono::steady_clock::duration::max();
    for (int i = 0; i < 3; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      EXPECT_EQ(world->ContactsOf(floor)->size(), commands.size());
      least = std::min(least, std::chrono::steady_clock::now() - begin);
    }
    return least / (across * across);
  };
  const auto usual = time_of(15);
  EXPECT_LT(time_of(75), 6 * usual);
}

TEST_P(ContactsTold, OfAFloorUnderManyCanBeCutShort) {
  const auto world = MakeWorld();
  const EntityId floor = Add(*world, Block({0, 0, -0.5}, {20, 20, 0.5}));
  for (int i = 0; i < 5; ++i) Add(*world, Ball({1.5 * i, 0, 0.5}));
  Steps(*world, 2);
  ASSERT_EQ(world->ContactsOf(floor)->size(), 5u);
  int asked = 0;
  const WorkWatch watch([&] { return ++asked == 4 ? absl::CancelledError("enough") : absl::OkStatus(); }, 1);
  EXPECT_THROW(static_cast<void>(world->ContactsOf(floor)), CutShort);
}

}  // namespace
}  // namespace genphys::testing

// The scene of the thesis, by a client of a server: a ball falls on a crate, beside its middle it meets the edge, and
// rolls away.
#include <cmath>
#include <map>

#include "conformance/engine_test.h"
#include "integration/live_server.h"

namespace genphys::testing {
namespace {

constexpr double kStep = 1.0 / 60;         // s, the default
constexpr uint32_t kStepsToContact = 51;   // the first step boundary behind kContactTime
constexpr uint32_t kTenSeconds = 600;      // steps
constexpr double kContactTime = 0.849746;  // s: sqrt(2 (5 - 1.45826) / 9.81)
constexpr double kRestHeightError = 1e-3;  // m
constexpr double kSlip = 1e-3;             // m/s
constexpr double kPlaceOnTop = 1e-2;       // m
constexpr double kBounceHeight = 1e-3;     // m: what the correction of one step's penetration may lift it
// m: the ball sinks in by up to 8.3 m/s for a step before it is seen, and the point lies within what sinks.
constexpr double kEdgePlace = 0.02;
constexpr double kUnitLength = 1e-6;

class LiveCrateAndBall : public EngineTest {
 protected:
  void Place(double x, double angular_damping = 0) {
    crate_ = Value(world_.Add(Box{{0.5, 0.5, 0.5}}, {.display_name = "crate", .position = {0, 0, 0.5}, .mass = 1}));
    ball_ = Value(world_.Add(
        Sphere{0.5}, {.display_name = "ball", .position = {x, 0, 5}, .mass = 1, .angular_damping = angular_damping}));
  }

  client::StepResult Step(uint32_t steps) { return Value(world_.Step(steps)); }

  // All events since the world was made.
  std::vector<Event> EventsUpTo(const client::StepResult& result) { return ReadEvents(stream_, result.last_sequence); }

  LiveServer server_;
  client::World world_ = Value(server_.Connect().CreateWorld(WorldOn(GetParam())));
  client::EventStream stream_ = Value(world_.WatchEvents());
  EntityId crate_;
  EntityId ball_;
};

INSTANTIATE_TEST_SUITE_P(Engines, LiveCrateAndBall, ::testing::ValuesIn(EnginesWithContacts()), EngineName);

// The step after which `a` and `b` began to touch; zero if they never did.
uint64_t StepOfMeeting(const std::vector<Event>& events, EntityId a, EntityId b) {
  for (const Event& event : events) {
    const auto* began = std::get_if<ContactBegan>(&event.kind);
    if (began != nullptr && began->pair == EntityPair{std::min(a, b), std::max(a, b)}) return event.step;
  }
  return 0;
}

TEST_P(LiveCrateAndBall, MeetWhenTheClosedFormSaysSo) {
  Place(0.7);

  const std::vector<Event> events = EventsUpTo(Step(60));

  EXPECT_NEAR(static_cast<double>(StepOfMeeting(events, crate_, ball_)) * kStep, kContactTime, kStep);
}

TEST_P(LiveCrateAndBall, TheBallLeavesToTheSideItFellOnAndRollsWithoutSlipping) {
  Place(0.7);

  const client::StepResult result = Step(kStepsToContact + kTenSeconds);

  EXPECT_GT(PositionIn(result.frame, ball_).x(), 1.0);
  EXPECT_NEAR(PositionIn(result.frame, ball_).z(), 0.5, kRestHeightError);
  const Vector3 velocity = VelocityIn(result.frame, ball_);
  EXPECT_GT(velocity.x(), 10 * kSlip) << "it still rolls";
  EXPECT_LT((velocity - 0.5 * SpinIn(result.frame, ball_).cross(Vector3::UnitZ())).norm(), kSlip);
}

TEST_P(LiveCrateAndBall, ADampedBallFallsAsleepAndIsToldOf) {
  Place(0.7, 2.0);

  const client::StepResult result = Step(kStepsToContact + kTenSeconds);

  EXPECT_TRUE(AsleepIn(result.frame, ball_));
  EXPECT_NEAR(PositionIn(result.frame, ball_).z(), 0.5, kRestHeightError);
  int slept = 0;
  for (const EntitySlept& event : Of<EntitySlept>(EventsUpTo(result))) slept += event.id == ball_ ? 1 : 0;
  EXPECT_EQ(slept, 1);
}

TEST_P(LiveCrateAndBall, OnTheFlatTopTheBallStaysAndDoesNotBounce) {
  Place(0.3);
  Step(kStepsToContact + 1);

  double highest = 0;
  client::StepResult result;
  for (uint32_t i = 0; i < kTenSeconds; i += 10) {
    result = Step(10);
    highest = std::max(highest, PositionIn(result.frame, ball_).z());
  }

  EXPECT_LT(highest, 1.5 + kBounceHeight) << "restitution is 0 unless asked for";
  EXPECT_NEAR(PositionIn(result.frame, ball_).x(), 0.3, kPlaceOnTop);
  EXPECT_NEAR(PositionIn(result.frame, ball_).z(), 1.5, kPlaceOnTop);
}

TEST_P(LiveCrateAndBall, TellTheirStoryInOrder) {
  Place(0.7);

  const std::vector<Event> events = EventsUpTo(Step(kStepsToContact + kTenSeconds));

  const auto created = Of<EntityCreated>(events);
  ASSERT_EQ(created.size(), 2u);
  EXPECT_EQ(created[0].id, crate_);
  EXPECT_EQ(created[0].entity->display_name, "crate");
  EXPECT_EQ(created[1].id, ball_);
  const EntityId floor = EntityId(0, crate_.generation());
  EXPECT_EQ(StepOfMeeting(events, floor, crate_), 1u);
  EXPECT_LT(StepOfMeeting(events, crate_, ball_), StepOfMeeting(events, floor, ball_));
  std::map<EntityPair, int> touching;
  for (const Event& event : events) {
    if (const auto* began = std::get_if<ContactBegan>(&event.kind)) {
      EXPECT_EQ(++touching[began->pair], 1);
    }
    if (const auto* ended = std::get_if<ContactEnded>(&event.kind)) {
      EXPECT_EQ(--touching[ended->pair], 0);
    }
  }
  EXPECT_EQ((touching[{crate_, ball_}]), 0);
  EXPECT_EQ((touching[{floor, ball_}]), 1);
}

TEST_P(LiveCrateAndBall, ToldByTheReplyAndByTheStreamAreTheSame) {
  Place(0.7);
  EventsUpTo(Step(0));

  const client::StepResult result = Step(120);
  const std::vector<Event> streamed = EventsUpTo(result);

  ASSERT_EQ(result.events.size(), streamed.size());
  ASSERT_FALSE(streamed.empty());
  for (size_t i = 0; i < streamed.size(); ++i) {
    EXPECT_EQ(result.events[i].sequence, streamed[i].sequence);
    EXPECT_EQ(result.events[i].step, streamed[i].step);
    EXPECT_EQ(result.events[i].kind.index(), streamed[i].kind.index());
  }
}

TEST_P(LiveCrateAndBall, TakeOneCallFromTheirCreationToTheirMeeting) {
  const client::StepResult result = Value(world_.Step(
      60, {.commands = {CreateEntity{Crate({0, 0, 0.5})}, CreateEntity{Ball({0.7, 0, 5})}}, .stats = true}));

  ASSERT_EQ(result.created.size(), 2u);
  EXPECT_EQ(result.stamp.step, 60u);
  EXPECT_NEAR(static_cast<double>(StepOfMeeting(result.events, result.created[0], result.created[1])) * kStep,
              kContactTime, kStep);
  EXPECT_LT(PositionIn(result.frame, result.created[1]).z(), 2);
  EXPECT_EQ(result.frame.stamp().step, 60u);
  EXPECT_TRUE(result.stats.has_value());
}

TEST_P(LiveCrateAndBall, MeetAtTheEdgeWithoutRestitution) {
  Place(0.7);

  for (const ContactBegan& began : Of<ContactBegan>(EventsUpTo(Step(60)))) {
    if (began.pair != EntityPair{crate_, ball_}) continue;
    ASSERT_FALSE(began.points.empty());
    const EventContactPoint& point = began.points.front();
    EXPECT_EQ(point.restitution, 0);
    EXPECT_NEAR(point.friction, 0.5, 1e-12);
    EXPECT_NEAR(point.position.x(), 0.5, kEdgePlace);
    EXPECT_GT(point.normal.x(), 0) << "from the crate to the ball";
    EXPECT_NEAR(point.normal.norm(), 1, kUnitLength);
    return;
  }
  FAIL() << "they never met";
}

}  // namespace
}  // namespace genphys::testing

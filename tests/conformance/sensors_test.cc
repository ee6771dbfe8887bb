// A sensor tells of whoever was inside it at any time of a step, and of nobody else.
#include <string>

#include "conformance/engine_test.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Sensors, Claim::kSensors, Claim::kSensorEvents);

constexpr double kRadius = 0.05;

// Two centimetres thick, two metres wide.
EntityDesc Gate(double x) {
  EntityDesc gate = Block({x, 0, 0}, {0.01, 1, 1});
  gate.rigid_body->geometries[0].is_sensor = true;
  return gate;
}

EntityDesc Shot(double x, double speed, double restitution = 0) {
  EntityDesc ball = Ball({x, 0, 0}, kRadius);
  ball.rigid_body->linear_velocity = {speed, 0, 0};
  ball.rigid_body->geometries[0].material.restitution = restitution;
  return ball;
}

std::unique_ptr<World> Space(const std::string& engine, Quality quality = Quality::kBalanced) {
  auto world = MakeWorld(WorldDesc{.engine = engine,
                                   .gravity = Vector3::Zero(),
                                   .stepper = {.step_size = 1.0 / 60, .quality = quality},
                                   .ground_plane = false});
  return world;
}

TEST_P(Sensors, NoticeWhoFliesThroughThemHoweverFast) {
  for (const Quality quality : {Quality::kFast, Quality::kBalanced, Quality::kAccurate}) {
    for (const double speed : {1.0, 3.0, 8.0, 10.0, 50.0, 300.0}) {
      for (const double start : {-1.0, -1.013, -1.37, -2.7113}) {
        SCOPED_TRACE(std::to_string(speed) + " m/s from " + std::to_string(start));
        const auto world = Space(GetParam(), quality);
        const EntityId gate = Add(*world, Gate(0)), ball = Add(*world, Shot(start, speed));
        std::vector<Event> events;
        const double before = (-0.01 - kRadius - start) / speed, after = (0.01 + kRadius - start) / speed;
        Steps(*world, static_cast<int>(after * 60) + 3);
        events = world->TakeEvents();
        ASSERT_EQ(Of<SensorEntered>(events).size(), 1u);
        ASSERT_EQ(Of<SensorLeft>(events).size(), 1u);
        EXPECT_EQ(Of<SensorEntered>(events)[0].sensor, gate);
        EXPECT_EQ(Of<SensorEntered>(events)[0].visitor, ball);
        // In the step in which it came there, and in the one in which it was there no more.
        for (const Event& event : events) {
          const bool enters = std::holds_alternative<SensorEntered>(event.kind);
          if (!enters && !std::holds_alternative<SensorLeft>(event.kind)) continue;
          EXPECT_EQ(event.step, static_cast<uint64_t>((enters ? before : after) * 60) + 1) << (enters ? "in" : "out");
        }
      }
    }
  }
}

TEST_P(Sensors, DoNotNoticeWhoIsStoppedBeforeThem) {
  Proves({Claim::kContacts, Claim::kRestitution});
  for (const double speed : {3.0, 50.0, 300.0}) {
    for (const double restitution : {0.0, 1.0}) {
      SCOPED_TRACE(speed);
      const auto world = Space(GetParam());
      Add(*world, Gate(0));
      EntityDesc wall = Block({-0.2, 0, 0}, {0.01, 1, 1});
      wall.rigid_body->geometries[0].material.restitution = restitution;
      Add(*world, wall);
      Add(*world, Shot(-1.37, speed, restitution));
      Steps(*world, 60);
      EXPECT_TRUE(Of<SensorEntered>(world->TakeEvents()).empty());
    }
  }
}

TEST_P(Sensors, NoticeWhoBouncesBackThroughThem) {
  Proves({Claim::kContacts, Claim::kRestitution});
  const auto world = Space(GetParam());
  const EntityId gate = Add(*world, Gate(0));
  EntityDesc wall = Block({0.2, 0, 0}, {0.01, 1, 1});
  wall.rigid_body->geometries[0].material.restitution = 1;
  Add(*world, wall);
  const EntityId ball = Add(*world, Shot(-1.37, 300, 1));
  Steps(*world, 10);
  const std::vector<Event> events = world->TakeEvents();
  ASSERT_EQ(Of<SensorEntered>(events).size(), 1u);
  EXPECT_EQ(Of<SensorEntered>(events)[0].sensor, gate);
  EXPECT_EQ(Of<SensorLeft>(events).size(), 1u);
  EXPECT_LT(VelocityOf(*world, ball).x(), -299);
}

TEST_P(Sensors, NoticeWhomTheyPassWhenTheyMove) {
  Proves({Claim::kMotionTypes});
  for (const double speed : {3.0, 50.0, 300.0}) {
    SCOPED_TRACE(speed);
    const auto world = Space(GetParam());
    EntityDesc scanner = Gate(-1.37);
    scanner.rigid_body->motion_type = MotionType::kKinematic;
    scanner.rigid_body->linear_velocity = {speed, 0, 0};
    const EntityId gate = Add(*world, scanner);
    const EntityId post = Add(*world, Block({0, 0, 0}, {0.03, 0.03, 0.03}));
    const EntityId ball = Add(*world, Ball({0.5, 0, 0}, kRadius));
    Steps(*world, static_cast<int>(3 / speed * 60) + 3);
    const auto entered = Of<SensorEntered>(world->TakeEvents());
    ASSERT_EQ(entered.size(), 2u);
    for (const SensorEntered& each : entered) EXPECT_EQ(each.sensor, gate);
    std::vector<EntityId> visitors{entered[0].visitor, entered[1].visitor};
    std::ranges::sort(visitors);
    EXPECT_EQ(visitors, (std::vector{post, ball}));
  }
}

}  // namespace
}  // namespace genphys::testing

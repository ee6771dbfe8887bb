// The engines agree with each other, and both with the closed form, for whatever heading, mass, shape and coefficient.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "conformance/engine_test.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Agreement, Claim::kEnginesAgree);

constexpr double kGravity = 9.81;
constexpr double kStep = 1.0 / 60;
// What the layer does without the engine, of numbers up to a hundred.
constexpr double kRounding = 100 * kRounded;

// Runs `scene` on the engine of the test and on another one; both results.
template <typename Scene>
auto OnBoth(const std::string& engine, Scene scene) {
  return std::pair(scene(engine), scene(OtherEngine(engine)));
}

// In as many substeps on each, whatever a preset means there.
std::unique_ptr<World> Weightless(const std::string& engine) {
  return MakeWorld(
      WorldDesc{.engine = engine, .gravity = Vector3::Zero(), .stepper = {.substeps = 2}, .ground_plane = false});
}

Vector3 Horizontal(double heading) { return {std::cos(heading), std::sin(heading), 0}; }

TEST_P(Agreement, OnWhereMixedFrictionStopsASlider) {
  Proves({Claim::kKineticFriction, Claim::kBox, Claim::kConvexHull, Claim::kCylinder});
  const std::vector<std::pair<Shape, double>> sliders{
      {Box{{0.3, 0.2, 0.05}}, 0.05}, {HullBox({0.2, 0.3, 0.06}), 0.06}, {Cylinder{0.3, 0.05}, 0.05}};
  Random random(11);
  for (const auto& [shape, height] : sliders) {
    for (const double mass : {1e-2, 1.0, 300.0}) {
      const double speed = random.Uniform(1, 3), heading = random.Uniform(-3, 3);
      const double own = random.Uniform(0.1, 1), floor = random.Uniform(0.2, 0.9);
      double substep = 0;
      const auto [here, there] = OnBoth(GetParam(), [&](const std::string& engine) {
        WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}};
        desc.default_material.friction = floor;
        const auto world = testing::MakeWorld(desc);
        EntityDesc slider = Body(shape, {0, 0, height}, mass);
        slider.rigid_body->geometries[0].material.friction = own;
        slider.rigid_body->linear_velocity = speed * Horizontal(heading);
        const EntityId id = Add(*world, slider);
        Steps(*world, 180);
        substep = SubstepOf(*world);
        return PositionOf(*world, id);
      });
      const double distance = speed * speed / (2 * std::sqrt(own * floor) * kGravity);
      const double tolerance = 2 * StopError(std::sqrt(own * floor) * kGravity, substep);
      SCOPED_TRACE(::testing::Message() << "shape " << shape.index() << " mass " << mass);
      EXPECT_LE((here.head<2>() - distance * Horizontal(heading).head<2>()).norm(), tolerance);
      EXPECT_LE((here - there).norm(), tolerance + kTouch);
    }
  }
}

TEST_P(Agreement, OnTheSpeedAfterABounce) {
  Proves({Claim::kRestitution, Claim::kSphere});
  Random random(12);
  for (int i = 0; i < 12; ++i) {
    const double mass = random.LogUniform(1e-3, 1e3), own = random.Uniform(0.2, 1), wall = random.Uniform(0.2, 1);
    const double radius = random.Uniform(0.1, 1);
    const Vector3 normal = random.Direction();
    // Not so flat that it would not come near in time.
    Vector3 velocity = -random.Uniform(1, 4) * (normal + 0.5 * random.Direction().cross(normal));
    const auto [here, there] = OnBoth(GetParam(), [&](const std::string& engine) {
      const auto world = Weightless(engine);
      EntityDesc plane = Body(Plane{normal, 0.7}, Vector3::Zero());
      plane.rigid_body->motion_type = MotionType::kStatic;
      plane.rigid_body->geometries[0].material = {.friction = 0, .restitution = wall};
      Add(*world, plane);
      EntityDesc ball = Ball((0.7 + radius + 0.5) * normal, radius, mass);
      ball.rigid_body->geometries[0].material = {.friction = 0, .restitution = own};
      ball.rigid_body->linear_velocity = velocity;
      const EntityId id = Add(*world, ball);
      Steps(*world, 60);
      return VelocityOf(*world, id);
    });
    const double approach = velocity.dot(normal);
    const Vector3 expected = velocity - (1 + std::sqrt(own * wall)) * approach * normal;
    const double tolerance = kDirect * (1 + std::sqrt(own * wall)) * std::abs(approach);
    EXPECT_LE((here - expected).norm(), tolerance) << "case " << i;
    EXPECT_LE((here - there).norm(), tolerance) << "case " << i;
  }
}

struct Filter {
  uint64_t category;
  uint64_t mask;
  std::string space;
};

std::string RootOf(const std::string& space) { return space.substr(0, space.find('/')); }

bool MayTouch(const Filter& a, const Filter& b) {
  if ((a.category & b.mask) == 0 || (b.category & a.mask) == 0) return false;
  return a.space.empty() || RootOf(a.space) != RootOf(b.space);
}

TEST_P(Agreement, OnWhoPassesThroughWhom) {
  Proves({Claim::kCategories, Claim::kCollisionSpaces});
  static constexpr std::array<const char*, 5> kSpaces{"", "", "car", "car/wheels", "crane/hook"};
  Random random(13);
  const auto any = [&] {
    const uint64_t last_bit = random.Chance(0.2) ? uint64_t{1} << 63 : 0;
    return Filter{(1 + random.Below(7)) | last_bit, (1 + random.Below(7)) | last_bit, kSpaces[random.Below(5)]};
  };
  std::vector<std::pair<Filter, Filter>> pairs;
  for (int i = 0; i < 100; ++i) pairs.push_back({any(), any()});
  const auto [here, there] = OnBoth(GetParam(), [&](const std::string& engine) {
    const auto world = Weightless(engine);
    Require(*world, Feature::kContacts);
    std::vector<bool> touching;
    const auto add = [&](const Vector3& place, const Filter& filter) {
      EntityDesc ball = Ball(place, 0.5);
      Geometry& geometry = ball.rigid_body->geometries[0];
      geometry.category_bits = filter.category;
      geometry.collides_with_bits = filter.mask;
      geometry.collision_space = filter.space;
      return Add(*world, ball);
    };
    std::vector<EntityPair> ids;
    for (size_t i = 0; i < pairs.size(); ++i) {
      const Vector3 place(3.0 * static_cast<double>(i), 0, 0);
      const EntityId first = add(place, pairs[i].first);
      ids.push_back({first, add(place + Vector3(0.3, 0.9, 0.1), pairs[i].second)});
    }
    Steps(*world, 1);
    for (const EntityPair& pair : ids) {
      const std::vector<TouchingPair> found = TouchingIn(*world);
      touching.push_back(std::any_of(found.begin(), found.end(), [&](const auto& t) { return t.pair == pair; }));
    }
    return touching;
  });
  std::vector<bool> expected;
  for (const auto& [a, b] : pairs) expected.push_back(MayTouch(a, b));
  EXPECT_EQ(here, expected);
  EXPECT_EQ(there, expected);
  const auto may = std::count(expected.begin(), expected.end(), true);
  EXPECT_TRUE(may > 20 && may < 80) << may << " of 100 pairs touch";
}

TEST_P(Agreement, OnWhenASensorIsEnteredAndLeft) {
  Proves({Claim::kSensors, Claim::kSensorEvents});
  Random random(14);
  for (int i = 0; i < 8; ++i) {
    const double radius = random.Uniform(0.2, 1), own = random.Uniform(0.1, 0.5), speed = random.Uniform(1, 5);
    const double mass = random.LogUniform(1e-3, 1e3);
    const Vector3 along = random.Direction(), start = -(radius + own + 1) * along;
    const auto [here, there] = OnBoth(GetParam(), [&](const std::string& engine) {
      const auto world = Weightless(engine);
      EntityDesc sensor = Ball({0, 0, 0}, radius);
      sensor.rigid_body->motion_type = MotionType::kStatic;
      sensor.rigid_body->geometries[0].is_sensor = true;
      Add(*world, sensor);
      EntityDesc visitor = Ball(start, own, mass);
      visitor.rigid_body->linear_velocity = speed * along;
      Add(*world, visitor);
      std::pair<uint64_t, uint64_t> steps;
      for (int step = 0; step < 360; ++step) {
        Steps(*world, 1);
        for (const Event& event : world->TakeEvents()) {
          if (std::holds_alternative<SensorEntered>(event.kind)) steps.first = event.step;
          if (std::holds_alternative<SensorLeft>(event.kind)) steps.second = event.step;
        }
      }
      return steps;
    });
    // Seen at the end of the step: the next one if it falls between two.
    EXPECT_NEAR(static_cast<double>(here.first) * kStep, 1 / speed, kStep) << "case " << i;
    EXPECT_NEAR(static_cast<double>(here.second) * kStep, (1 + 2 * (radius + own)) / speed, kStep) << "case " << i;
    EXPECT_EQ(here, there) << "case " << i;
  }
}

TEST_P(Agreement, OnWhenSomethingIsAtRest) {
  Proves({Claim::kSleeping});
  // A brake that leaves exp(-c t) of the speed: below the threshold at ln(v / threshold) / c, asleep the rest time
  // later.
  Random random(15);
  for (int i = 0; i < 16; ++i) {
    const double brake = random.Uniform(0.5, 3), speed = random.Uniform(0.5, 2), mass = random.LogUniform(1e-3, 1e3);
    const double threshold = random.LogUniform(1e-2, 0.3), rest = random.Uniform(0.05, 0.7);
    const bool turns = i % 2 == 0, is_told_by_world = i % 4 < 2;
    const Vector3 direction = random.Direction();
    const auto [here, there] = OnBoth(GetParam(), [&](const std::string& engine) {
      AutoDisable policy{.enabled = true, .rest_time = rest};
      (turns ? policy.angular_speed_max : policy.linear_speed_max) = threshold;
      WorldDesc desc{.engine = engine, .gravity = Vector3::Zero(), .ground_plane = false};
      if (is_told_by_world) desc.default_auto_disable = policy;
      const auto world = testing::MakeWorld(desc);
      EntityDesc ball = Ball({0, 0, 0}, 0.5, mass);
      if (!is_told_by_world) ball.rigid_body->auto_disable = policy;
      (turns ? ball.rigid_body->angular_velocity : ball.rigid_body->linear_velocity) = speed * direction;
      (turns ? ball.rigid_body->angular_damping : ball.rigid_body->linear_damping) = brake;
      const EntityId id = Add(*world, ball);
      int steps = 0;
      for (; !Asleep(*world, id) && steps < 2000; ++steps) Steps(*world, 1);
      return steps;
    });
    const double expected = std::log(speed / threshold) / brake + rest;
    // One step until it is seen to be slow, and one until it has rested that long.
    EXPECT_NEAR(here * kStep, expected, 2 * kStep) << "case " << i;
    EXPECT_EQ(here, there) << "case " << i;
  }
}

TEST_P(Agreement, OnDamping) {
  Proves({Claim::kDamping});
  Random random(16);
  for (int i = 0; i < 8; ++i) {
    const double linear = random.Uniform(0, 5), angular = random.Uniform(0, 5), mass = random.LogUniform(1e-3, 1e3);
    const Vector3 velocity = random.Vector(3), spin = random.Vector(3);
    const auto [here, there] = OnBoth(GetParam(), [&](const std::string& engine) {
      const auto world = Weightless(engine);
      EntityDesc ball = Ball({1, 2, 3}, 0.3, mass);
      ball.rigid_body->auto_disable.enabled = false;
      ball.rigid_body->linear_velocity = velocity;
      ball.rigid_body->angular_velocity = spin;
      ball.rigid_body->linear_damping = linear;
      ball.rigid_body->angular_damping = angular;
      const EntityId id = Add(*world, ball);
      Steps(*world, 60);
      return std::pair(VelocityOf(*world, id), SpinOf(*world, id));
    });
    EXPECT_LE((here.first - std::exp(-linear) * velocity).norm(), kRounding);
    EXPECT_LE((here.second - std::exp(-angular) * spin).norm(), kRounding);
    EXPECT_LE((here.first - there.first).norm() + (here.second - there.second).norm(), kRounding);
  }
}

TEST_P(Agreement, OnForcesInTheirCoordinatesForTheirSteps) {
  Proves({Claim::kForce, Claim::kForceCoordinates});
  Random random(17);
  for (int i = 0; i < 12; ++i) {
    const double mass = random.LogUniform(1e-3, 1e3);
    const Quaternion turn = random.Turn();
    const Vector3 force = mass * random.Vector(5), torque = mass * random.Vector(0.2), point = random.Vector(0.3);
    const bool own = i % 2 == 0;
    const auto steps = static_cast<uint32_t>(1 + random.Below(30));
    const auto [here, there] = OnBoth(GetParam(), [&](const std::string& engine) {
      const auto world = Weightless(engine);
      EntityDesc ball = Ball({4, 5, 6}, 0.5, mass);
      ball.pose.orientation = turn;
      const EntityId id = Add(*world, ball);
      Do(*world, ApplyForce{.id = id,
                            .force = force,
                            .torque = torque,
                            .coordinates = own ? Coordinates::kEntity : Coordinates::kWorld,
                            .steps = 1});
      ApplyForce at_point{.id = id, .force = force, .steps = steps};
      at_point.point = Vector3(4, 5, 6) + point;
      Do(*world, at_point);
      Steps(*world, 1);
      const Vector3 after_one = SpinOf(*world, id);
      Steps(*world, 59);
      return std::pair(after_one, VelocityOf(*world, id));
    });
    const Quaternion frame = own ? turn : Quaternion::Identity();
    // The torque in its own frame is turned on by half of w h / 2 on the mean of the second half of its only step, so
    // by w h / 8 of itself on the mean of all of it; the other one keeps its direction.
    const Vector3 angular = (frame * torque + point.cross(force)) / (0.4 * mass * 0.25) * kStep;
    const double turned = angular.norm() * kStep;
    EXPECT_LE((here.first - angular).norm(), 2 * turned / 8 * angular.norm()) << "case " << i;
    const Vector3 linear = (frame * force + steps * force) / mass * kStep;
    EXPECT_LE((here.second - linear).norm(), 2 * turned / 8 * force.norm() / mass * kStep + kRounding) << "case " << i;
    EXPECT_LE((here.first - there.first).norm() + (here.second - there.second).norm(), kRounding) << "case " << i;
  }
}

}  // namespace
}  // namespace genphys::testing

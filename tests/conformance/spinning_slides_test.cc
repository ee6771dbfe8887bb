// Boxes that spin as they slide. Which of their corners presses how much decides where they go: the load shifts to the
// front, against which friction tips them, and three corners would be enough to bear it. The reference is that of a
// pressure that is linear over the face, which is what an even floor and a stiff box have.
#include <array>
#include <cmath>

#include "conformance/engine_test.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(SpinningSlides, Claim::kContacts);

constexpr double kGravity = 9.81;

struct Spun {
  Vector3 half_extents;
  double friction;
  double speed;  // m/s, along x
  double spin;   // rad/s
};

struct Stop {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double turn = 0;
};

// What friction does to it: m/s^2, and rad/s^2.
Vector3 Braked(const Spun& spun, double turn, const Eigen::Vector2d& velocity, double spin) {
  const Vector3& half = spun.half_extents;
  const double c = std::cos(turn), s = std::sin(turn);
  std::array<Eigen::Vector2d, 4> arms, ways;
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  for (size_t i = 0; i < 4; ++i) {
    const double x = i % 2 == 0 ? half.x() : -half.x(), y = i < 2 ? half.y() : -half.y();
    arms[i] = {c * x - s * y, s * x + c * y};
    ways[i] = (velocity + spin * Eigen::Vector2d(-arms[i].y(), arms[i].x())).stableNormalized();
    squares += arms[i] * arms[i].transpose();
  }
  // Of a unit mass. Friction at the face tips the box until the load does so the other way.
  Eigen::Vector2d slope = Eigen::Vector2d::Zero(), force;
  double torque = 0;
  for (int round = 0; round < 25; ++round) {
    force.setZero();
    torque = 0;
    for (size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d rub = -spun.friction * (kGravity / 4 + slope.dot(arms[i])) * ways[i];
      force += rub;
      torque += arms[i].x() * rub.y() - arms[i].y() * rub.x();
    }
    slope = squares.inverse() * (-half.z() * force);
  }
  return {force.x(), force.y(), torque / ((half.x() * half.x() + half.y() * half.y()) / 3)};
}

// By small steps of second order, to the one in which friction stops it.
Stop Reference(const Spun& spun) {
  constexpr double h = 2e-4;
  Stop stop;
  Eigen::Vector2d velocity(spun.speed, 0);
  double spin = spun.spin;
  const double size = spun.half_extents.head<2>().norm();
  while (velocity.norm() + size * std::abs(spin) > 2 * spun.friction * kGravity * h) {
    const Vector3 now = Braked(spun, stop.turn, velocity, spin);
    const Vector3 middle =
        Braked(spun, stop.turn + h / 2 * spin, velocity + h / 2 * now.head<2>(), spin + h / 2 * now.z());
    stop.place += h * (velocity + h / 2 * middle.head<2>());
    stop.turn += h * (spin + h / 2 * middle.z());
    velocity += h * middle.head<2>();
    spin += h * middle.z();
  }
  return stop;
}

Stop StopOf(World& world, EntityDesc body, const Spun& spun) {
  body.rigid_body->linear_velocity = {spun.speed, 0, 0};
  body.rigid_body->angular_velocity = {0, 0, spun.spin};
  body.rigid_body->geometries[0].material.friction = spun.friction;
  const EntityId id = Add(world, body);
  const double seconds = 2;
  Steps(world, static_cast<int>(seconds / world.scene().world.stepper.step_size));
  const Quaternion turned = world.state().pose(EntityRow{id.index()}).orientation;
  return {PositionOf(world, id).head<2>(), 2 * std::atan2(turned.z(), turned.w())};
}

std::unique_ptr<World> FloorOf(const std::string& engine, int rate, double friction, bool is_block) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = 1.0 / rate}};
  desc.default_material.friction = friction;
  desc.default_auto_disable.enabled = false;
  desc.ground_plane = !is_block;
  auto world = testing::MakeWorld(desc);
  if (is_block) {
    EntityDesc block = Block({0, 0, -0.5}, {5, 5, 0.5});
    block.rigid_body->geometries[0].material.friction = friction;
    Add(*world, block);
  }
  return world;
}

const std::array kSlides{Spun{{0.1, 0.1, 0.1}, 0.5, 2, 10}, Spun{{0.2, 0.2, 0.02}, 0.3, 1, 8},
                         Spun{{0.15, 0.15, 0.03}, 0.4, 1.5, 12}, Spun{{0.2, 0.1, 0.05}, 0.4, 1.5, 6}};

TEST_P(SpinningSlides, EndWhereALinearPressureTakesThem) {
  Proves({Claim::kBox, Claim::kConvexHull, Claim::kKineticFriction});
  for (Spun spun : kSlides) {
    for (const double side : {1.0, -1.0}) {
      spun.spin *= side;
      const Stop reference = Reference(spun);
      for (const int rate : {60, 240, 960}) {
        for (const bool is_block : {false, true}) {
          for (const bool is_hull : {false, true}) {
            SCOPED_TRACE(::testing::Message() << spun.half_extents.transpose() << " at " << spun.spin << " rad/s, "
                                              << rate << " steps/s, block " << is_block << ", hull " << is_hull);
            const auto world = FloorOf(GetParam(), rate, spun.friction, is_block);
            const Shape shape = is_hull ? Shape(HullBox(spun.half_extents)) : Shape(Box{spun.half_extents});
            const Stop stop = StopOf(*world, Body(shape, {0, 0, spun.half_extents.z()}, 2), spun);
            // Up to 1.2e-2 rad were seen at 60 steps per second.
            EXPECT_LE((stop.place - reference.place).norm(), 5e-4 + 0.06 / rate);
            EXPECT_NEAR(stop.turn, reference.turn, 0.003 + 0.6 / rate);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

// Friction that turns within a substep: of what slides up a slope and back, of what stops, and of what is pushed across
// its slip. Where it turns is not to be seen in the way, whatever part of a substep is left then.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(TurningBack, Claim::kContacts, Claim::kKineticFriction, Claim::kBox, Claim::kPlane);

constexpr double kGravity = 9.81, kSlope = 0.3;

/// Down a slope points x.
struct Slope {
  double pull = kGravity * std::sin(kSlope);
  double press = kGravity * std::cos(kSlope);
  double friction = 0;
  double kinetic = 0;

  /// `part` of the friction that would hold what lies there, and of that as much as is left while it slides.
  explicit Slope(double part, double kinetic_part = 1)
      : friction(part * std::tan(kSlope)), kinetic(kinetic_part * friction) {}

  double brake() const { return kinetic * press; }
  /// m/s^2, by which the velocity jumps where it turns.
  double most() const { return pull + brake(); }
};

std::unique_ptr<World> WorldOf(const std::string& engine, int rate, const Slope& slope) {
  WorldDesc desc{.engine = engine, .gravity = {slope.pull, 0, -slope.press}, .stepper = {.step_size = 1.0 / rate}};
  desc.default_material.friction = slope.friction;
  if (slope.kinetic != slope.friction) desc.default_material.kinetic_friction = slope.kinetic;
  desc.default_auto_disable.enabled = false;
  return MakeWorld(desc);
}

EntityDesc Thrown(const Shape& shape, const Eigen::Vector2d& velocity) {
  EntityDesc body = Body(shape, {0, 0, 0.05}, 2);
  body.pose.orientation = Quaternion(Eigen::AngleAxisd(0.4, Vector3::UnitZ()));
  body.rigid_body->linear_velocity.head<2>() = velocity;
  return body;
}

struct Course {
  double way = 0, speed = 0;  // down the slope
};

/// Of what is thrown straight up.
Course ThrownUp(const Slope& slope, double speed, double time) {
  const double turned = speed / slope.most();
  const double up = -speed * speed / slope.most() / 2, left = std::max(time - turned, 0.0);
  if (time < turned) return {-speed * time + slope.most() * time * time / 2, -speed + slope.most() * time};
  if (slope.friction * slope.press >= slope.pull) return {up, 0};
  const double gain = slope.pull - slope.brake();
  return {up + gain * left * left / 2, gain * left};
}

// With the friction of one way for the whole substep it would be off by up to two thirds of most() * h from there on.
void ExpectThrownUp(const std::string& engine, const Slope& slope, const Shape& shape) {
  for (const int rate : {60, 240}) {
    for (int i = 0; i < 12; ++i) {
      const double speed = 0.3 + 0.0137 * i, time = std::ceil(2 * speed / slope.most() * rate) / rate;
      const auto world = WorldOf(engine, rate, slope);
      const EntityId id = Add(*world, Thrown(shape, {-speed, 0}));
      Steps(*world, static_cast<int>(std::lround(time * rate)));
      const Course course = ThrownUp(slope, speed, time);
      const double off = 0.02 * slope.most() * SubstepOf(*world);
      const Vector3 way = PositionOf(*world, id) - Vector3(course.way, 0, 0.05);
      EXPECT_LE(way.norm(), off * time) << speed << " m/s at " << rate;
      EXPECT_LE((VelocityOf(*world, id) - Vector3(course.speed, 0, 0)).norm(), off) << speed << " m/s at " << rate;
    }
  }
}

TEST_P(TurningBack, UpASlopeAndDownAgain) {
  Proves({Claim::kCylinder});
  for (const Shape& shape : {Shape(Box{{0.3, 0.2, 0.05}}), Shape(Cylinder{0.2, 0.05})}) {
    for (const double part : {0.5, 0.9}) ExpectThrownUp(GetParam(), Slope(part), shape);
  }
}

TEST_P(TurningBack, UnderTheFrictionOfWhatSlides) {
  Proves({Claim::kStaticFriction});
  for (const double part : {0.5, 0.9}) ExpectThrownUp(GetParam(), Slope(part, 0.6), Box{{0.3, 0.2, 0.05}});
}

TEST_P(TurningBack, OnWhatLiesOnTheSlope) {
  for (int i = 0; i < 12; ++i) {
    constexpr int kRate = 60;
    const Slope slope(0.8);
    const double speed = 0.3 + 0.0137 * i, time = 0.25;
    const auto world = WorldOf(GetParam(), kRate, slope);
    EntityDesc plate = Body(Box{{2, 1, 0.05}}, {0, 0, 0.05}, 6);
    // The square root of what it has is on top of it, and enough to hold it below.
    plate.rigid_body->geometries[0].material.friction = 9;
    Add(*world, plate);
    EntityDesc block = Thrown(Box{{0.2, 0.2, 0.05}}, {-speed, 0});
    block.pose.position.z() = 0.15;
    block.rigid_body->geometries[0].material.friction = slope.friction * slope.friction / 9;
    const EntityId id = Add(*world, block);
    Steps(*world, static_cast<int>(std::lround(time * kRate)));
    const Course course = ThrownUp(slope, speed, time);
    const double off = 0.02 * slope.most() * SubstepOf(*world);
    // The way in the substep in which it turns is that at the velocity of its middle.
    const double once = slope.most() * std::pow(SubstepOf(*world), 2) / 4;
    EXPECT_NEAR(PositionOf(*world, id).x(), course.way, off * time + once) << speed;
    EXPECT_NEAR(VelocityOf(*world, id).x(), course.speed, off) << speed;
  }
}

// What stops has gone the way until then. That at the velocity of the middle of the substep would be off by an eighth
// of most() * h * h.
TEST_P(TurningBack, StopsWhereItStops) {
  for (const double part : {1.1, 2.0}) {
    const Slope slope(part);
    for (const int rate : {60, 240, 1000}) {
      for (int i = 0; i < 12; ++i) {
        const double speed = 0.15 + 0.0137 * i;
        const auto world = WorldOf(GetParam(), rate, slope);
        const EntityId id = Add(*world, Thrown(Box{{0.3, 0.2, 0.05}}, {-speed, 0}));
        Steps(*world, static_cast<int>(std::ceil((speed / slope.most() + 0.05) * rate)));
        const double way = ThrownUp(slope, speed, 10).way;
        EXPECT_NEAR(PositionOf(*world, id).x(), way, 1e-5 * -way) << speed << " m/s at " << rate;
        EXPECT_LE(VelocityOf(*world, id).norm(), 1e-6) << speed << " m/s at " << rate;
      }
    }
  }
}

/// Where what is thrown askew is, integrated in steps that become as short as it is slow.
Eigen::Vector2d Askew(const Slope& slope, Eigen::Vector2d velocity, double time) {
  Eigen::Vector2d way = Eigen::Vector2d::Zero();
  while (time > 0 && velocity.norm() > 1e-9) {
    const double h = std::min({time, 1e-4, 2e-3 * velocity.norm() / slope.most()});
    const auto change = [&](const Eigen::Vector2d& at) -> Eigen::Vector2d {
      return Eigen::Vector2d(slope.pull, 0) - slope.brake() * at.normalized();
    };
    const Eigen::Vector2d middle = velocity + h / 2 * change(velocity);
    const Eigen::Vector2d end = velocity + h * change(middle);
    way += h * middle;
    velocity = end;
    time -= h;
  }
  return way;
}

TEST_P(TurningBack, WhatIsPushedAcrossItsSlipIsOfSecondOrder) {
  for (const double part : {0.9, 1.1, 2.0}) {
    const Slope slope(part);
    for (const double heading : {1.75, 2.36}) {
      for (const int rate : {60, 240}) {
        for (int i = 0; i < 6; ++i) {
          const double speed = 0.18 + 0.0073 * i, time = 0.2;
          const Eigen::Vector2d velocity = speed * Eigen::Vector2d(std::cos(heading), std::sin(heading));
          const auto world = WorldOf(GetParam(), rate, slope);
          const EntityId id = Add(*world, Thrown(Box{{0.3, 0.2, 0.05}}, velocity));
          Steps(*world, static_cast<int>(std::lround(time * rate)));
          const Eigen::Vector2d error = PositionOf(*world, id).head<2>() - Askew(slope, velocity, time);
          // Of first order: 3e-3 m at 60 steps, 6e-5 at 240. What stops soon takes no error of its velocity along.
          const double share = part < 2 ? 0.5 : 0.1;
          EXPECT_LE(error.norm(), share * slope.brake() * std::pow(SubstepOf(*world), 2))
              << part << ", heading " << heading << ", " << speed << " m/s at " << rate;
        }
      }
    }
  }
}

TEST_P(TurningBack, WhatAForceThrowsOutOfTheWorldMeanwhileStaysWhereItWas) {
  Proves({Claim::kBounds});
  const Slope slope(0.9);
  for (const double force : {1e9, 1e12}) {
    const auto world = WorldOf(GetParam(), 60, slope);
    const EntityId id = Add(*world, Thrown(Box{{0.3, 0.2, 0.05}}, {0.5, 0}));
    for (int i = 0; i < 6; ++i) {
      Do(*world, ApplyForce{.id = id, .force = {-1e-3, 0, 0}, .sampled = true});
      Steps(*world, 1);
    }
    const Vector3 before = PositionOf(*world, id);
    world->TakeEvents();
    // It slips down and is driven up: friction turns in the substep in which it leaves.
    Do(*world, ApplyForce{.id = id, .force = {-force, 0, 0}, .sampled = true});
    Steps(*world, 1);
    ASSERT_EQ(Of<EntityFaulted>(world->TakeEvents()).size(), 1u) << force;
    EXPECT_EQ(PositionOf(*world, id), before) << force;
  }
}

}  // namespace
}  // namespace genphys::testing

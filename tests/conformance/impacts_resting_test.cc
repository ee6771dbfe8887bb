// What lands without bouncing stays on the floor and turns on: it touches ever elsewhere than where it was hit, and the
// floor gives way to it nowhere. Without friction the height h of its centre is that of a body that turns by an angle t
// as (I + m h'^2) t'' + m h' h'' t'^2 + m g h' = 0: Lagrange's equation, of one degree of freedom.
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "conformance/engine_test.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ImpactsOfResting, Claim::kContacts);

constexpr double kGravity = 9.81;
constexpr double kMass = 2;  // kg

// Turned about y.
struct Solid {
  Shape shape;
  double inertia;                        // kg*m^2, about y
  std::function<double(double)> height;  // m, of its centre while it touches, by the angle
};

struct Course {
  double angle;  // rad
  double spin;   // rad/s
};

double Slope(const Solid& solid, double angle) {
  constexpr double kPart = 1e-5;
  return (solid.height(angle + kPart) - solid.height(angle - kPart)) / (2 * kPart);
}

double Bend(const Solid& solid, double angle) {
  constexpr double kPart = 1e-4;
  return (solid.height(angle + kPart) - 2 * solid.height(angle) + solid.height(angle - kPart)) / (kPart * kPart);
}

// rad/s^2, as long as it stays.
double Turning(const Solid& solid, const Course& c) {
  const double slope = Slope(solid, c.angle);
  return -kMass * slope * (Bend(solid, c.angle) * c.spin * c.spin + kGravity) / (solid.inertia + kMass * slope * slope);
}

// N, by which the floor holds it.
double Pressure(const Solid& solid, const Course& c) {
  const double lift = Bend(solid, c.angle) * c.spin * c.spin + Slope(solid, c.angle) * Turning(solid, c);
  return kMass * (lift + kGravity);
}

Course Later(const Course& c, const Course& rate, double time) {
  return {c.angle + time * rate.angle, c.spin + time * rate.spin};
}

// Runge and Kutta's fourth-order method.
Course Go(const Solid& solid, Course c, double time) {
  constexpr int kParts = 200;
  const double h = time / kParts;
  const auto rate = [&](const Course& at) { return Course{at.spin, Turning(solid, at)}; };
  for (int i = 0; i < kParts; ++i) {
    const Course a = rate(c), b = rate(Later(c, a, h / 2)), d = rate(Later(c, b, h / 2)), e = rate(Later(c, d, h));
    c.angle += h / 6 * (a.angle + 2 * b.angle + 2 * d.angle + e.angle);
    c.spin += h / 6 * (a.spin + 2 * b.spin + 2 * d.spin + e.spin);
  }
  return c;
}

Solid Boxed(double x, double z) {
  return {Box{{x, 0.3, z}}, kMass / 3 * (x * x + z * z),
          [=](double angle) { return x * std::sin(angle) + z * std::cos(angle); }};
}

Solid Cylindric(double radius, double half) {
  return {Cylinder{radius, half}, kMass * (radius * radius / 4 + half * half / 3),
          [=](double angle) { return radius * std::sin(angle) + half * std::cos(angle); }};
}

Solid Ellipsoidal(double x, double z) {
  return {Ellipsoid{{x, 0.3, z}}, kMass / 5 * (x * x + z * z),
          [=](double angle) { return std::hypot(x * std::sin(angle), z * std::cos(angle)); }};
}

struct Fall {
  double angle;   // rad, when it is let go
  double height;  // m
};

struct Flight {
  std::unique_ptr<World> world;
  EntityId id;
};

Flight Thrown(const std::string& engine, const Solid& solid, const Fall& fall, double step_size) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = step_size, .substeps = 1}};
  desc.default_material.friction = desc.default_material.kinetic_friction = 0;
  auto world = testing::MakeWorld(desc);
  Require(*world, Feature::kContacts);
  EntityDesc thrown = Body(solid.shape, {0, 0, solid.height(fall.angle) + fall.height}, kMass);
  thrown.pose.orientation = Quaternion(Eigen::AngleAxisd(fall.angle, Vector3::UnitY()));
  const EntityId id = Add(*world, thrown);
  return {std::move(world), id};
}

// How it goes on from the blow, which lets it not close where it is hit.
Course Landed(const Solid& solid, const Fall& fall) {
  const double slope = Slope(solid, fall.angle), speed = std::sqrt(2 * kGravity * fall.height);
  const double impulse = speed / (1 / kMass + slope * slope / solid.inertia);
  return {fall.angle, -impulse * slope / solid.inertia};
}

// Lets it fall, and compares it with its course at the end of the step in which it lands.
void Land(const std::string& engine, const Solid& solid, const Fall& fall, size_t points_max) {
  constexpr double kStep = 1.0 / 60;
  const auto [world, id] = Thrown(engine, solid, fall, kStep);
  const double lands = std::sqrt(2 * fall.height / kGravity);
  const int steps = static_cast<int>(lands / kStep) + 1;
  Steps(*world, steps);

  const Course start = Landed(solid, fall);
  const Course end = Go(solid, start, steps * kStep - lands);
  ASSERT_GT(Pressure(solid, start), 0);
  ASSERT_GT(Pressure(solid, end), 0);
  EXPECT_NEAR(PositionOf(*world, id).z(), solid.height(end.angle), 5e-5);
  EXPECT_NEAR(VelocityOf(*world, id).z(), Slope(solid, end.angle) * end.spin, 4e-3);
  EXPECT_NEAR(SpinOf(*world, id).y(), end.spin, 3e-2);
  // What holds it all the time is no further impact: each of those would be told.
  for (const Event& event : world->TakeEvents()) {
    const auto* const began = std::get_if<ContactBegan>(&event.kind);
    EXPECT_LE(began != nullptr ? began->points.size() : 0, points_max);
  }
}

void LandFromAll(const std::string& engine, const Solid& solid, const std::vector<double>& angles, size_t points_max) {
  for (const double height : {0.3, 0.35, 0.4, 0.45, 0.5}) {
    for (const double angle : angles) {
      SCOPED_TRACE(::testing::Message() << height << " m, " << angle << " rad");
      Land(engine, solid, {angle, height}, points_max);
    }
  }
}

TEST_P(ImpactsOfResting, HoldACornerWhereItIsByThen) { LandFromAll(GetParam(), Boxed(0.2, 0.25), {0.5, 0.6, 0.7}, 8); }

// About the corner, which goes round with it: what holds that at rest where it was holds it back.
TEST_P(ImpactsOfResting, LetItTurnOnAboutItsCorner) {
  constexpr double kStep = 1.0 / 120;
  const Solid solid = Boxed(0.2, 0.25);
  for (const double height : {0.3, 0.35, 0.4, 0.45, 0.5}) {
    SCOPED_TRACE(height);
    const auto [world, id] = Thrown(GetParam(), solid, {0.5, height}, kStep);
    const double lands = std::sqrt(2 * height / kGravity);
    const Course start = Landed(solid, {0.5, height});
    Steps(*world, static_cast<int>(lands / kStep) + 1);
    for (int step = static_cast<int>(lands / kStep) + 1; step < static_cast<int>(lands / kStep) + 10; ++step) {
      const Course course = Go(solid, start, step * kStep - lands);
      ASSERT_GT(Pressure(solid, course), 0);
      EXPECT_NEAR(PositionOf(*world, id).z(), solid.height(course.angle), 6e-5);
      EXPECT_NEAR(VelocityOf(*world, id).z(), Slope(solid, course.angle) * course.spin, 3e-3);
      EXPECT_NEAR(SpinOf(*world, id).y(), course.spin, 1e-2);
      Steps(*world, 1);
    }
  }
}

TEST_P(ImpactsOfResting, HoldARimWhereItIsByThen) {
  Proves({Claim::kCylinder});
  LandFromAll(GetParam(), Cylindric(0.2, 0.25), {0.5, 0.6, 0.7}, 2);
}

TEST_P(ImpactsOfResting, HoldWhatRollsWhereItTouchesByThen) {
  Proves({Claim::kEllipsoid});
  LandFromAll(GetParam(), Ellipsoidal(0.2, 0.3), {0.3, 0.5, 0.7}, 2);
}

}  // namespace
}  // namespace genphys::testing

// What stands on an edge alone and tips over it: friction has to hold the edge, whichever way that would slip.
#include <cmath>
#include <utility>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Tipping, Claim::kStaticFriction, Claim::kBox);

constexpr double kGravity = 9.81, kWide = 0.5, kHigh = 1, kLean = 0.05, kSeconds = 0.9;

// rad, of a box that leans so far beyond where it would stand on its edge: theta'' = g d sin(theta) / I about the edge,
// by Runge and Kutta's method with steps of 1e-5 s.
double TippedIn(double seconds) {
  const double arm = std::hypot(kWide, kHigh), inertia = arm * arm * 4 / 3, h = 1e-5;
  const auto rate = [&](double angle) { return kGravity * arm * std::sin(angle) / inertia; };
  double angle = kLean, spin = 0;
  for (int i = 0, steps = static_cast<int>(std::lround(seconds / h)); i < steps; ++i) {
    const double k1 = rate(angle), v2 = spin + h / 2 * k1, k2 = rate(angle + h / 2 * spin), v3 = spin + h / 2 * k2,
                 k3 = rate(angle + h / 2 * v2), v4 = spin + h * k3, k4 = rate(angle + h * v3);
    angle += h / 6 * (spin + 2 * v2 + 2 * v3 + v4);
    spin += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return angle;
}

// How far it tipped, rad, and where its edge is then, m, of a box that falls that way.
std::pair<double, Vector3> Tip(const std::string& engine, const Shape& shape, double heading, double step_size) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = step_size}};
  desc.default_material.friction = 2;
  const auto world = MakeWorld(desc);
  const double arm = std::hypot(kWide, kHigh);
  const Quaternion turn(Eigen::AngleAxisd(heading, Vector3::UnitZ()));
  EntityDesc box = Body(shape, turn * Vector3(arm * std::sin(kLean), 0, arm * std::cos(kLean)), 3);
  box.pose.orientation = turn * Quaternion(Eigen::AngleAxisd(std::atan2(kWide, kHigh) + kLean, Vector3::UnitY()));
  const EntityId id = Add(*world, box);
  Steps(*world, static_cast<int>(std::lround(kSeconds / step_size)));
  const Vector3 center = turn.conjugate() * PositionOf(*world, id);
  return {std::atan2(center.x(), center.z()), world->state().pose(EntityRow{id.index()}).Transform({kWide, 0, -kHigh})};
}

TEST_P(Tipping, GoesAsTheClosedFormSaysAndTheEdgeStays) {
  // Along x and y, and between them.
  for (const double heading : {0.0, 0.6, M_PI / 2}) {
    for (const double rate : {60.0, 240.0}) {
      const auto [angle, edge] = Tip(GetParam(), Box{{kWide, 0.7, kHigh}}, heading, 1 / rate);
      // Of second order.
      EXPECT_NEAR(angle, TippedIn(kSeconds), 2e-5 * (60 / rate) * (60 / rate) + 1e-7) << heading << " " << rate;
      EXPECT_LT(edge.norm(), 1e-4) << heading << " " << rate;
    }
  }
}

}  // namespace
}  // namespace genphys::testing

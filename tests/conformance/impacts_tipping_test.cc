// What stands on one end and tips over comes down with the other one while the first is pressed on.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "conformance/engine_test.h"
#include "support/energy.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ImpactsOfTipping, Claim::kContacts, Claim::kRestitution);

constexpr double kGravity = 9.81;
constexpr double kTilt = std::numbers::pi / 6;

struct Surface {
  double friction, restitution;
};

// On its lowest end, 30 degrees above the floor.
EntityDesc Tipping(const Shape& shape, const Surface& surface) {
  EntityDesc body = Body(shape, Vector3::Zero());
  if (const auto* capsule = std::get_if<Capsule>(&shape)) {
    body.pose.orientation = Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2 - kTilt, Vector3::UnitY()));
    body.pose.position.z() = capsule->radius + capsule->half_length * std::sin(kTilt);
  } else {
    const Vector3 half = std::get<Box>(shape).half_extents;
    body.pose.orientation = Quaternion(Eigen::AngleAxisd(-kTilt, Vector3::UnitY()));
    body.pose.position.z() = half.x() * std::sin(kTilt) + half.z() * std::cos(kTilt);
  }
  body.rigid_body->geometries[0].material.friction = surface.friction;
  body.rigid_body->geometries[0].material.restitution = surface.restitution;
  return body;
}

// By how much of its energy at first that rises most in any step of 2 s.
double LargestRise(const std::string& engine, const EntityDesc& body, int rate) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = 1.0 / rate}};
  desc.default_auto_disable.enabled = false;
  desc.default_material = body.rigid_body->geometries[0].material;
  const auto world = testing::MakeWorld(desc);
  const EntityId id = Add(*world, body);
  const double first = kGravity * body.pose.position.z();
  double energy = first, largest = 0;
  for (int i = 0; i < 2 * rate; ++i) {
    Steps(*world, 1);
    const double now = KineticEnergyOf(*world) + kGravity * PositionOf(*world, id).z();
    largest = std::max(largest, now - energy);
    energy = now;
  }
  EXPECT_LT(energy, 0.5 * first) << "it came down";
  return largest / first;
}

TEST_P(ImpactsOfTipping, GiveNoEnergyWhereTheOtherEndComesDown) {
  for (const Shape& shape : {Shape(Capsule{.radius = 0.1, .half_length = 0.5}), Shape(Box{{0.5, 0.3, 0.1}})}) {
    for (const Surface& surface : {Surface{0, 0.5}, {0.5, 0.8}}) {
      SCOPED_TRACE(::testing::Message() << "shape " << shape.index() << ", restitution " << surface.restitution);
      const EntityDesc body = Tipping(shape, surface);
      // Of second order.
      EXPECT_LE(LargestRise(GetParam(), body, 60), 2e-4);
      EXPECT_LE(LargestRise(GetParam(), body, 240), 2e-5);
    }
  }
}

}  // namespace
}  // namespace genphys::testing

// A block that rocks from one edge to the other loses at each landing what the blow on the new edge takes, and nothing
// else: Housner, "The behavior of inverted pendulum structures during earthquakes", Bull. Seismol. Soc. Am. 53 (1963).
#include <cmath>
#include <string>
#include <vector>

#include "conformance/engine_test.h"
#include "support/energy.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(ImpactsOfRocking, Claim::kContacts, Claim::kRestitution, Claim::kStaticFriction);

constexpr double kGravity = 9.81;
constexpr double kFloorHalf = 3;  // m
constexpr double kLayer = 2e-6;   // m

struct Slab {
  Vector3 half;
  double tilt;  // rad, at first, about the edge at +x
  int landings;

  double reach() const { return std::hypot(half.x(), half.z()); }
  double slenderness() const { return std::atan2(half.x(), half.z()); }
  // m, of its centre at first, above where that is when it stands upright.
  double lift() const { return reach() * std::cos(slenderness() - tilt) - half.z(); }
  // By so much of its fastest turn it turns on after a landing: the momentum about the new edge is kept.
  double kept() const { return 1 - 1.5 * std::pow(std::sin(slenderness()), 2); }
};

const std::vector<Slab> kSlabs{{{0.05, 0.1, 0.2}, 0.08, 4},
                               {{0.08, 0.1, 0.24}, 0.2, 4},
                               {{0.02, 1, 0.3}, 0.03, 4},  // a plank on its long edge
                               {{0.2, 0.1, 0.24}, 0.3, 2}};

EntityDesc Tilted(const Slab& slab, const Shape& shape) {
  const double angle = slab.slenderness() - slab.tilt;
  EntityDesc desc = Body(shape, {slab.half.x() - slab.reach() * std::sin(angle), 0, slab.reach() * std::cos(angle)});
  desc.pose.orientation = Quaternion(Eigen::AngleAxisd(slab.tilt, Vector3::UnitY()));
  return desc;
}

// On a floor of this shape, whose top is at zero.
std::unique_ptr<World> On(const std::string& engine, const Shape& floor, int rate) {
  const bool is_plane = std::holds_alternative<Plane>(floor), is_box = std::holds_alternative<Box>(floor);
  WorldDesc desc{
      .engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = 1.0 / rate}, .ground_plane = is_plane};
  desc.default_material.friction = desc.default_material.kinetic_friction = 0.8;
  desc.default_auto_disable.enabled = false;
  auto world = testing::MakeWorld(desc);
  Require(*world, Feature::kContacts);
  if (is_plane) return world;
  EntityDesc still = Body(floor, {0, 0, is_box ? -kFloorHalf : 0});
  still.rigid_body->motion_type = MotionType::kStatic;
  Add(*world, still);
  return world;
}

// Of what it had of energy when it was let go, how much is left each time that it has turned as far as it gets.
std::vector<double> LeftAtTurns(World& world, EntityId id, const Slab& slab, int rate) {
  const double lowest = kGravity * slab.half.z();
  const double first = kGravity * slab.lift();
  std::vector<double> left;
  double side = 1, farthest = 0, energy = 0;
  for (int i = 0; i < 3 * rate && static_cast<int>(left.size()) <= slab.landings; ++i) {
    Steps(world, 1);
    const Pose pose = world.state().pose(EntityRow{id.index()});
    const double angle = 2 * std::atan2(pose.orientation.y(), pose.orientation.w());
    if (angle * side < 0) {
      left.push_back(energy / first);
      side = -side;
      farthest = 0;
    }
    if (std::abs(angle) < farthest) continue;
    farthest = std::abs(angle);
    energy = KineticEnergyOf(world) + kGravity * pose.position.z() - lowest;
  }
  return left;
}

void ExpectRocks(const std::string& engine, const Slab& slab, const Shape& shape, const Shape& floor) {
  for (const int rate : {60, 240}) {
    SCOPED_TRACE(::testing::Message() << "half of it " << slab.half.transpose() << ", shape " << shape.index() << " on "
                                      << floor.index() << " at " << rate);
    const auto world = On(engine, floor, rate);
    const std::vector<double> left = LeftAtTurns(*world, Add(*world, Tilted(slab, shape)), slab, rate);
    ASSERT_EQ(static_cast<int>(left.size()), slab.landings + 1);
    for (int k = 0; k <= slab.landings; ++k) {
      const double kept = std::pow(slab.kept(), 2 * k);
      // Of second order in the part that a substep is of the time in which it turns over, which is a third of its
      // swing's; and it stands on a layer of a micrometre or two.
      const double part = 3 * SubstepOf(*world) * std::sqrt(kGravity / slab.reach());
      const double error = (k + 1) * part * part * std::sqrt(kept) + kLayer / slab.lift();
      EXPECT_NEAR(left[static_cast<size_t>(k)], kept, error) << "after landing " << k;
    }
  }
}

TEST_P(ImpactsOfRocking, KeepTheMomentumAboutTheNewEdge) {
  Proves({Claim::kBox, Claim::kConvexHull});
  for (const Slab& slab : kSlabs) {
    for (const Shape& shape : {Shape(Box{slab.half}), Shape(HullBox(slab.half))}) {
      ExpectRocks(GetParam(), slab, shape, Plane{});
      ExpectRocks(GetParam(), slab, shape, Box{Vector3::Constant(kFloorHalf)});
    }
  }
}

TEST_P(ImpactsOfRocking, KeepItOnGroundOfTriangles) {
  Proves({Claim::kTriangleMesh, Claim::kHeightfield});
  for (const Slab& slab : kSlabs) {
    for (const Shape& floor : {Shape(GroundMesh(kFloorHalf, 21)), Shape(Ground(41, 0.1))}) {
      ExpectRocks(GetParam(), slab, Box{slab.half}, floor);
    }
  }
}

}  // namespace
}  // namespace genphys::testing

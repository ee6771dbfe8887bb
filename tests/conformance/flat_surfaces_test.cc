// A flat mesh or heightfield is a plane to whatever falls, slides and rolls on it: where its triangles meet is nothing.
#include <cmath>
#include <vector>

#include "engine_test.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(FlatSurfaces, Claim::kContacts, Claim::kTriangleMesh, Claim::kHeightfield, Claim::kPlane,
                     Claim::kConvexHull);

constexpr double kStep = 1.0 / 60;  // of a world that is not asked for another one
// Of a speed: sweeps over the same points in another order end by as much apart.
constexpr double kAlike = 1e-6;

// About the origin, level at zero, of triangles from larger to much smaller than what comes to them.
std::vector<Shape> Grounds() { return {GroundMesh(8, 11), GroundMesh(8, 160), Ground(23, 0.73), Ground(161, 0.1)}; }

ConvexHull Spike() { return *MakeConvexHull({{0.2, 0, -0.3}, {-0.1, 0.17, -0.3}, {-0.1, -0.17, -0.3}, {0, 0, 0.9}}); }

struct Surroundings {
  Vector3 gravity = Vector3::Zero();
  double friction = 0;
  double restitution = 0;
};

std::unique_ptr<World> WorldOn(const std::string& engine, const Shape& ground, const Surroundings& around) {
  WorldDesc desc{.engine = engine, .gravity = around.gravity, .ground_plane = false};
  desc.default_material.friction = around.friction;
  desc.default_material.restitution = around.restitution;
  desc.default_auto_disable.enabled = false;
  auto world = testing::MakeWorld(desc);
  Require(*world, Feature::kContacts);
  EntityDesc floor = Body(ground, Vector3::Zero());
  floor.rigid_body->motion_type = MotionType::kStatic;
  Add(*world, floor);
  return world;
}

// Above the ground, turned anyhow.
EntityDesc Thrown(const Shape& shape, const Vector3& velocity, double height, Random& random) {
  EntityDesc body = Body(shape, {random.Uniform(-3, 3), random.Uniform(-3, 3), height}, 2);
  body.pose.orientation = random.Turn();
  body.rigid_body->linear_velocity = velocity;
  return body;
}

struct Motion {
  Vector3 velocity;
  Vector3 spin;
};

Motion MotionOf(const World& world, EntityId id) { return {VelocityOf(world, id), SpinOf(world, id)}; }

void ExpectAlike(const Motion& got, const Motion& wanted, double speed) {
  EXPECT_LT((got.velocity - wanted.velocity).norm(), kAlike * speed);
  // 1/m: of what is a few decimetres large.
  EXPECT_LT((got.spin - wanted.spin).norm(), 10 * kAlike * speed);
}

TEST_P(FlatSurfaces, HitWhatFallsOnACornerAsAPlaneDoes) {
  Proves({Claim::kRestitution, Claim::kBox, Claim::kCapsule, Claim::kCylinder, Claim::kCone});
  const std::vector<Shape> grounds = Grounds();
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    for (const Shape& shape : {Shape{Box{{0.3, 0.2, 0.4}}}, Shape{Spike()}, Shape{Capsule{0.12, 0.3}},
                               Shape{Cylinder{0.2, 0.3}}, Shape{Cone{0.3, 0.3}}}) {
      Random random(seed);
      const double speed = random.Uniform(2, 6);
      const Vector3 velocity(random.Uniform(-1, 1), random.Uniform(-1, 1), -speed);
      const EntityDesc body = Thrown(shape, velocity, 1 + random.Uniform(0, speed * kStep), random);
      const Surroundings around{.restitution = random.Uniform(0.2, 1)};
      const auto after_a_hit = [&](const Shape& ground) {
        const auto world = WorldOn(GetParam(), ground, around);
        const EntityId id = Add(*world, body);
        for (int i = 0; i < 60 && VelocityOf(*world, id).z() == -speed; ++i) Steps(*world, 1);
        EXPECT_NE(VelocityOf(*world, id).z(), -speed);
        return MotionOf(*world, id);
      };
      const Motion wanted = after_a_hit(Plane{});
      for (size_t i = 0; i < grounds.size(); ++i) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed << ", shape " << shape.index() << ", ground " << i);
        ExpectAlike(after_a_hit(grounds[i]), wanted, speed);
      }
    }
  }
}

// Of bodies whose points on a plane are the layer's, too.
TEST_P(FlatSurfaces, CarryWhatTumblesSlidesAndRollsAsAPlaneDoes) {
  Proves({Claim::kStaticFriction, Claim::kKineticFriction, Claim::kCone, Claim::kEllipsoid});
  const std::vector<Shape> grounds = Grounds();
  const Surroundings around{.gravity = {0, 0, -9.81}, .friction = 0.4, .restitution = 0.2};
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    for (const Shape& shape :
         {Shape{HullBox({0.3, 0.2, 0.4})}, Shape{Spike()}, Shape{Cone{0.3, 0.3}}, Shape{Ellipsoid{{0.3, 0.25, 0.2}}}}) {
      Random random(seed);
      const Vector3 velocity(random.Uniform(-3, 3), random.Uniform(-3, 3), -1);
      const EntityDesc body = Thrown(shape, velocity, 0.8, random);
      const auto way_on = [&](const Shape& ground) {
        const auto world = WorldOn(GetParam(), ground, around);
        const EntityId id = Add(*world, body);
        std::vector<Motion> way;
        for (int i = 0; i < 60; ++i) {
          Steps(*world, 1);
          way.push_back(MotionOf(*world, id));
        }
        return way;
      };
      const std::vector<Motion> wanted = way_on(Plane{});
      for (size_t i = 0; i < grounds.size(); ++i) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed << ", shape " << shape.index() << ", ground " << i);
        const std::vector<Motion> way = way_on(grounds[i]);
        for (size_t step = 0; step < way.size(); ++step) ExpectAlike(way[step], wanted[step], velocity.norm());
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

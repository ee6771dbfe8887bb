// Bodies of every shape move on every ground as mechanics has it.
#include <cmath>

#include "engine_test.h"
#include "support/shapes.h"

namespace genphys {
namespace {

using namespace testing;

GENPHYS_ENGINE_TESTS(MovingShapes);

constexpr double kGravity = 9.81;

std::unique_ptr<World> WorldOn(const std::string& engine, const Shape& ground, double friction,
                               const Vector3& gravity) {
  WorldDesc desc{.engine = engine, .gravity = gravity, .ground_plane = false};
  desc.default_material.friction = friction;
  desc.default_material.kinetic_friction = friction;
  auto world = testing::MakeWorld(desc);
  EntityDesc floor = Body(ground, {0, 0, 0});
  floor.rigid_body->motion_type = MotionType::kStatic;
  Add(*world, floor);
  return world;
}

std::vector<Shape> FlatGrounds() { return {GroundMesh(6, 25), Ground(49, 0.25)}; }

TEST_P(MovingShapes, SlideAndRollOverSeamsAsOverAPlane) {
  Proves({Claim::kTriangleMesh, Claim::kHeightfield, Claim::kBox, Claim::kConvexHull, Claim::kSphere, Claim::kCylinder,
          Claim::kCone, Claim::kEllipsoid});
  // Without friction nothing changes the velocity, and without a bump nothing lifts or turns by more than sweeps leave.
  for (const Shape& ground : FlatGrounds()) {
    for (const Shape& shape : {Shape{Box{{0.3, 0.2, 0.1}}}, Shape{HullBox({0.3, 0.2, 0.1})}, Shape{Sphere{0.1}},
                               Shape{Cylinder{0.3, 0.1}}, Shape{Cone{0.3, 0.1}}, Shape{Ellipsoid{{0.3, 0.2, 0.1}}}}) {
      const auto world = WorldOn(GetParam(), ground, 0, {0, 0, -kGravity});
      EntityDesc desc = Body(shape, {-3, 0.37, 0.1});
      desc.pose.orientation = Eigen::AngleAxisd(0.4, Vector3::UnitZ());
      desc.rigid_body->linear_velocity = {3, 0.2, 0};
      const EntityId id = Add(*world, desc);
      double highest = 0;
      for (int i = 0; i < 110; ++i) {
        Steps(*world, 1);
        highest = std::max(highest, std::abs(VelocityOf(*world, id).z()));
      }
      SCOPED_TRACE(::testing::Message() << "shape " << shape.index() << " on " << ground.index());
      constexpr double kArm = 0.1;  // m, of the shortest
      const double unchanged = 2 * SweptSpeed(kGravity, SubstepOf(*world));
      EXPECT_NEAR(VelocityOf(*world, id).x(), 3, 3 * kRounded);
      EXPECT_NEAR(VelocityOf(*world, id).y(), 0.2, 3 * kRounded);
      EXPECT_LT(SpinOf(*world, id).norm(), unchanged / kArm);
      EXPECT_LT(highest, unchanged);
    }
  }
}

TEST_P(MovingShapes, SlideDownAHeightfieldWithGSinA) {
  Proves({Claim::kHeightfield, Claim::kTriangleMesh});
  constexpr double kAngle = 0.3;
  const auto slope = [](double x, double) { return -x * std::tan(kAngle); };
  const double acceleration = kGravity * std::sin(kAngle);
  const double tolerance = 2 * kSwept * acceleration / 2;
  for (const Shape& ground : {Shape{Ground(41, 0.5, slope)}, Shape{GroundMesh(10, 40, slope)}}) {
    for (const Shape& shape : {Shape{Box{{0.3, 0.2, 0.1}}}, Shape{HullBox({0.3, 0.2, 0.1})}}) {
      const auto world = WorldOn(GetParam(), ground, 0, {0, 0, -kGravity});
      const Quaternion tilt(Eigen::AngleAxisd(kAngle, Vector3::UnitY()));
      EntityDesc desc = Body(shape, tilt * Vector3(0, 0.13, 0.1));
      desc.pose.orientation = tilt;
      const EntityId id = Add(*world, desc);
      Steps(*world, 60);
      const Vector3 moved = tilt.inverse() * PositionOf(*world, id);
      EXPECT_NEAR(moved.x(), acceleration / 2, tolerance) << shape.index() << " on " << ground.index();
      EXPECT_NEAR(moved.y(), 0.13, kRounded);
      EXPECT_NEAR(moved.z(), 0.1, kTouch);
    }
  }
}

TEST_P(MovingShapes, StayWhereTheyHoverBesideARidgeHoweverSteep) {
  Proves({Claim::kHeightfield, Claim::kSphere, Claim::kBox, Claim::kCapsule, Claim::kCylinder, Claim::kConvexHull});
  constexpr double kCell = 0.4, kClear = 0.04;
  const Vector3 small = Vector3::Constant(0.03);
  for (const double height : {0.2, 0.4, 0.6, 1.0}) {
    const auto ridge = [&](double x, double y) { return std::abs(x - y) < kCell / 4 ? height : 0.0; };
    const double across = kCell / std::sqrt(2);
    const Vector3 up = Vector3(height / std::sqrt(2), -height / std::sqrt(2), across).normalized();
    for (const Shape& shape : {Shape{Sphere{0.03}}, Shape{Box{small}}, Shape{Capsule{0.02, 0.01}},
                               Shape{Cylinder{0.02, 0.02}}, Shape{HullBox(small)}}) {
      const auto world = WorldOn(GetParam(), Ground(9, kCell, ridge), 0, Vector3::Zero());
      // No part of the shape is farther from its middle than this.
      const Vector3 start = Vector3(0.32, 0.08, 0.4 * height) + (small.norm() + kClear) * up;
      const EntityId id = Add(*world, Body(shape, start));
      Steps(*world, 60);
      EXPECT_EQ(PositionOf(*world, id), start) << shape.index() << " beside " << height;
      EXPECT_TRUE(TouchingIn(*world).empty()) << shape.index() << " beside " << height;
    }
  }
}

TEST_P(MovingShapes, ASpheroidRollsDownAsABallDoes) {
  Proves({Claim::kEllipsoid, Claim::kStaticFriction});
  // About its long axis, two fifths of its mass times the square of its radius turn: 5/7 g sin a.
  constexpr double kAngle = 0.2;
  const double acceleration = 5.0 / 7 * kGravity * std::sin(kAngle);
  const double tolerance = 2 * kSwept * acceleration / 2;
  const Vector3 gravity = kGravity * Vector3(std::sin(kAngle), 0, -std::cos(kAngle));
  for (const Shape& ground : {Shape{Plane{}}, Shape{HullBox({9, 9, 1e-3})}, FlatGrounds()[0], FlatGrounds()[1]}) {
    const auto world = WorldOn(GetParam(), ground, 1, gravity);
    const double top = std::holds_alternative<ConvexHull>(ground) ? 1e-3 : 0;
    const EntityId id = Add(*world, Body(Ellipsoid{{0.3, 0.6, 0.3}}, {0, 0.1, 0.3 + top}));
    Steps(*world, 60);
    EXPECT_NEAR(PositionOf(*world, id).x(), acceleration / 2, tolerance) << ground.index();
    EXPECT_NEAR(PositionOf(*world, id).y(), 0.1, tolerance) << ground.index();
  }
}

TEST_P(MovingShapes, ATowerOfHullsStands) {
  Proves({Claim::kConvexHull});
  const auto world = MakeWorld();
  std::vector<EntityId> ids;
  for (int i = 0; i < 5; ++i) ids.push_back(Add(*world, Body(HullBox({0.5, 0.5, 0.5}), {0, 0, 0.5 + i})));
  Steps(*world, 300);
  for (int i = 0; i < 5; ++i) {
    EXPECT_LT((PositionOf(*world, ids[static_cast<size_t>(i)]) - Vector3(0, 0, 0.5 + i)).norm(), (i + 1) * kTouch) << i;
  }
}

TEST_P(MovingShapes, ManyPointsOnABumpyMeshCarryTheirWeight) {
  Proves({Claim::kTriangleMesh, Claim::kHeightfield});
  // Ribs of two slopes each, on which a ball lies between every two: eight normals under one body of balls.
  const auto ribs = [](double x, double y) { return 0.3 * std::abs(std::sin(x)) + 0.2 * std::abs(std::cos(y)); };
  for (const Shape& ground : {Shape{GroundMesh(6, 48, ribs)}, Shape{Ground(49, 0.25, ribs)}}) {
    const auto world = WorldOn(GetParam(), ground, 0.5, {0, 0, -kGravity});
    std::vector<EntityId> ids;
    for (int i = 0; i < 9; ++i) {
      const Vector3 place(-2.0 + 2.0 * (i % 3), -2.0 + 2.0 * (i / 3), 1.2);
      const Shape shape = i % 2 == 0 ? Shape{Ellipsoid{{0.8, 0.7, 0.6}}} : Shape{HullBox({0.7, 0.7, 0.3})};
      ids.push_back(Add(*world, Body(shape, place, 2)));
    }
    size_t most = 0;
    for (int i = 0; i < 240; ++i) {
      Steps(*world, 1);
      for (const ContactPair& pair : world->contacts().pairs) most = std::max<size_t>(most, pair.point_count);
    }
    EXPECT_GT(most, 4u);
    for (const EntityId id : ids) {
      // None has fallen through, and none has more energy than it fell for.
      const double height = PositionOf(*world, id).z();
      EXPECT_GT(height, 0.2);
      EXPECT_LT(height, 1.2);
      EXPECT_LT(VelocityOf(*world, id).squaredNorm() / 2, kGravity * (1.2 - height));
    }
  }
}

TEST_P(MovingShapes, AKinematicMeshCarriesWhatLiesOnIt) {
  Proves({Claim::kTriangleMesh, Claim::kKinematicPush});
  const auto world = testing::MakeWorld({.engine = GetParam(), .gravity = {0, 0, -kGravity}, .ground_plane = false});
  EntityDesc lift = Body(BoxMesh({1, 1, 0.2}), {0, 0, 0});
  lift.rigid_body->motion_type = MotionType::kKinematic;
  lift.rigid_body->linear_velocity = {0, 0, 1};
  Add(*world, lift);
  const EntityId id = Add(*world, Crate({0, 0, 0.7}));
  Steps(*world, 60);
  EXPECT_NEAR(PositionOf(*world, id).z(), 1.7, kTouch);
}

TEST_P(MovingShapes, MeshesAndHeightfieldsDoNotMoveByForces) {
  Proves({Claim::kTriangleMesh, Claim::kHeightfield});
  const auto world = testing::MakeWorld(
      {.engine = GetParam(), .required_features = {Feature::kShapeTriangleMesh, Feature::kShapeHeightfield}});
  for (const auto& [shape, name] : {std::pair{Shape{GroundMesh(1, 1)}, "dynamic_triangle_mesh"},
                                    std::pair{Shape{Ground(2, 1)}, "dynamic_heightfield"}}) {
    for (const MotionType motion : {MotionType::kDynamic, MotionType::kKinematic, MotionType::kStatic}) {
      EntityDesc desc = Body(shape, {0, 0, 5});
      desc.rigid_body->motion_type = motion;
      desc.rigid_body->inertia.tensor = Matrix3::Identity();
      const Command command = CreateEntity{desc};
      const Status status = world->Apply({&command, 1}).status();
      EXPECT_EQ(status.ok(), motion != MotionType::kDynamic) << status;
      if (status.ok()) continue;
      EXPECT_EQ(RefusalOf(status)->reason, Reason::kUnsupportedFeature);
      EXPECT_EQ(RefusalOf(status)->field, "commands[0].create_entity.entity.rigid_body.geometries[0].shape") << status;
      EXPECT_NE(MessageOf(status).find(name), std::string::npos) << status;
    }
  }
}

TEST_P(MovingShapes, AMeshThatIsThereIsNotMadeDynamic) {
  Proves({Claim::kTriangleMesh});
  const auto world = MakeWorld();
  EntityDesc desc = Body(GroundMesh(1, 1), {0, 0, 5});
  desc.rigid_body->motion_type = MotionType::kStatic;
  desc.rigid_body->inertia.tensor = Matrix3::Identity();
  UpdateEntity update{.id = Add(*world, desc), .entity = desc};
  update.entity.rigid_body->motion_type = MotionType::kDynamic;
  update.fields.Add(EntityField::kMotionType);
  const Command command = update;
  const Status status = world->Apply({&command, 1}).status();
  EXPECT_EQ(RefusalOf(status).value_or(Refusal{}).reason, Reason::kUnsupportedFeature) << status;
  update.entity.rigid_body->motion_type = MotionType::kKinematic;
  Do(*world, update);
}

TEST_P(MovingShapes, AreSeenByRaysWhereTheyAre) {
  Proves({Claim::kRayCasts});
  const auto world = testing::MakeWorld({.engine = GetParam(), .gravity = Vector3::Zero(), .ground_plane = false});
  const Vector3 half(0.3, 0.4, 0.5);
  std::vector<std::pair<EntityId, double>> seen;  // and how high they reach
  const auto add = [&](const Shape& shape, double top, MotionType motion = MotionType::kDynamic) {
    EntityDesc desc = Body(shape, {3.0 * static_cast<double>(seen.size()), 0, 1});
    desc.rigid_body->motion_type = motion;
    desc.pose.orientation = Eigen::AngleAxisd(0.7, Vector3::UnitZ());
    seen.push_back({Add(*world, desc), 1 + top});
  };
  add(Cone{0.3, 0.5}, 0.5);
  add(Ellipsoid{half}, 0.5);
  add(HullBox(half), 0.5);
  add(BoxMesh(half), 0.5, MotionType::kStatic);
  add(Ground(4, 0.5), 0, MotionType::kKinematic);
  std::vector<Ray> rays;
  for (size_t i = 0; i < seen.size(); ++i) rays.push_back({{3.0 * static_cast<double>(i), 0, 5}, {0, 0, -10}});
  const auto hits = world->CastRays(rays);
  ASSERT_TRUE(hits.ok()) << hits.status();
  for (size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ((*hits)[i].entity, seen[i].first) << i;
    EXPECT_NEAR((*hits)[i].fraction, (5 - seen[i].second) / 10, kRounded) << i;
  }
}

TEST_P(MovingShapes, GoOnAfterAChangeOfEngine) {
  Proves({Claim::kEngineChange});
  const auto world = WorldOn(GetParam(), GroundMesh(6, 9), 0.5, {0, 0, -kGravity});
  std::vector<EntityId> ids;
  const std::vector<Shape> shapes{HullBox({0.3, 0.3, 0.3}), Cone{0.3, 0.3}, Ellipsoid{{0.4, 0.4, 0.3}}};
  for (size_t i = 0; i < shapes.size(); ++i)
    ids.push_back(Add(*world, Body(shapes[i], {2.0 * double(i) - 2, 0.2, 0.31})));
  for (int i = 0; i < 60; ++i) {
    Steps(*world, 2);
    Do(*world, SetEngine{i % 2 == 0 ? OtherEngine(GetParam()) : GetParam()});
  }
  for (const EntityId id : ids) EXPECT_NEAR(PositionOf(*world, id).z(), 0.3, kTouch);
}

TEST_P(MovingShapes, TheStateHashTellsHullsApart) {
  Proves({Claim::kConvexHull});
  const auto hash = [&](const Shape& shape, MotionType motion = MotionType::kStatic) {
    const auto world = MakeWorld();
    EntityDesc desc = Body(shape, {0, 0, 3});
    desc.rigid_body->motion_type = motion;
    Add(*world, desc);
    return world->StateHash();
  };
  EXPECT_EQ(hash(HullBox({1, 1, 1})), hash(HullBox({1, 1, 1})));
  EXPECT_NE(hash(HullBox({1, 1, 1})), hash(HullBox({1, 1, 1.1})));
  EXPECT_NE(hash(GroundMesh(1, 2)), hash(GroundMesh(1, 2, [](double x, double) { return x; })));
  EXPECT_NE(hash(Ground(3, 1)), hash(Ground(3, 2)));
  EXPECT_NE(hash(Cone{0.5, 0.5}), hash(Cylinder{0.5, 0.5}));
}

}  // namespace
}  // namespace genphys

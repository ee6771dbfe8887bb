// What an engine has is accepted, and what it lacks is refused by name wherever it is asked for.
#include <functional>
#include <map>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

// Engines without contacts have as much to refuse.
class EngineCapabilities : public ::testing::TestWithParam<std::string> {
 protected:
  const Capabilities& capabilities() const { return EveryEngine().Find(GetParam())->capabilities(); }
};

std::unique_ptr<World> Space(const std::string& engine) {
  return MakeWorld(WorldDesc{.engine = engine, .ground_plane = false});
}

Status Try(World& world, const Command& command) { return world.Apply({&command, 1}).status(); }

Status TryShape(World& world, const Shape& shape, MotionType motion) {
  EntityDesc desc = Body(shape, {0, 0, 5});
  desc.rigid_body->motion_type = motion;
  desc.rigid_body->inertia.tensor = Matrix3::Identity();
  return Try(world, CreateEntity{desc});
}

Status TryJoint(World& world, const JointKind& kind) {
  const EntityId a = Add(world, Ball({0, 0, 0})), b = Add(world, Ball({2, 0, 0}));
  return Try(world, CreateJoint{Between(a, b, kind)});
}

Status TrySensor(World& world) {
  EntityDesc gate = Ball({0, 0, 0});
  gate.rigid_body->motion_type = MotionType::kStatic;
  gate.rigid_body->geometries[0].is_sensor = true;
  return Try(world, CreateEntity{gate});
}

using Use = std::function<Status(World&)>;

// What can be asked for by using it; the rest only by requiring it.
std::map<Feature, Use> Uses() {
  std::map<Feature, Use> uses;
  const auto shape = [&](const Shape& wanted, MotionType motion) {
    uses[FeatureOf(wanted)] = [=](World& world) { return TryShape(world, wanted, motion); };
  };
  for (const Shape& solid : {Shape{Sphere{}}, Shape{Box{}}, Shape{Capsule{}}, Shape{Cylinder{}}, Shape{Cone{}},
                             Shape{Ellipsoid{}}, Shape{HullBox({1, 1, 1})}}) {
    shape(solid, MotionType::kDynamic);
  }
  for (const Shape& ground : {Shape{Plane{}}, Shape{GroundMesh(1, 1)}, Shape{Ground(2, 1)}}) {
    shape(ground, MotionType::kStatic);
  }
  uses[Feature::kDynamicTriangleMesh] = [](World& w) { return TryShape(w, BoxMesh({1, 1, 1}), MotionType::kDynamic); };
  uses[Feature::kDynamicHeightfield] = [](World& w) { return TryShape(w, Ground(2, 1), MotionType::kDynamic); };
  uses[Feature::kErrorCorrection] = [](World& world) {
    EntityDesc ball = Ball({0, 0, 5});
    ball.rigid_body->error_correction.slop = 0.01;
    return Try(world, CreateEntity{ball});
  };
  uses[Feature::kLockedAxes] = [](World& world) {
    EntityDesc ball = Ball({0, 0, 5});
    ball.rigid_body->locked_axes.linear[2] = true;
    return Try(world, CreateEntity{ball});
  };
  uses[Feature::kSurfaceVelocity] = [](World& world) {
    EntityDesc ball = Ball({0, 0, 5});
    ball.rigid_body->geometries[0].surface_velocity = {1, 0, 0};
    return Try(world, CreateEntity{ball});
  };
  for (const JointKind& kind : {JointKind{BallJoint{}}, JointKind{HingeJoint{}}, JointKind{SliderJoint{}},
                                JointKind{UniversalJoint{}}, JointKind{FixedJoint{}}, JointKind{WheelJoint{}},
                                JointKind{SixDofJoint{}}, JointKind{DistanceJoint{}}, JointKind{GearJoint{}}}) {
    uses[FeatureOf(kind)] = [=](World& world) { return TryJoint(world, kind); };
  }
  uses[Feature::kSensors] = TrySensor;
  uses[Feature::kSolverDirect] = [](World& w) { return Try(w, SetStepper{{.solver = Solver::kDirect}}); };
  uses[Feature::kRayCasts] = [](World& w) { return w.CastRays(std::vector<Ray>(1)).status(); };
  uses[Feature::kShapeQueries] = [](World& w) { return w.FindOverlaps(Sphere{}, std::vector<Pose>(1)).status(); };
  return uses;
}

bool IsRefusedByName(const Status& status, const std::string& engine, Feature feature) {
  const std::optional<Refusal> refusal = RefusalOf(status);
  const std::string expected = "engine \"" + engine + "\" does not support " + std::string(NameOf(feature));
  return refusal && refusal->reason == Reason::kUnsupportedFeature && MessageOf(status) == expected;
}

TEST_P(EngineCapabilities, AreAcceptedWhereTheyAreUsedAndRefusedByNameWhereTheyLack) {
  const std::map<Feature, Use> uses = Uses();
  std::string refused;
  for (size_t i = 1; i < static_cast<size_t>(Feature::kCount); ++i) {
    const auto feature = static_cast<Feature>(i);
    const bool has = capabilities().Has(feature);
    SCOPED_TRACE(NameOf(feature));
    const WorldDesc required{.engine = GetParam(), .ground_plane = false, .required_features = {feature}};
    const Status creation = World::Create(EveryEngine(), required).status();
    EXPECT_EQ(creation.ok(), has) << creation;
    EXPECT_EQ(IsRefusedByName(creation, GetParam(), feature), !has) << creation;
    if (!has) refused += std::string(NameOf(feature)) + ' ';
    const auto use = uses.find(feature);
    // A mesh that may not be there at all is refused for that.
    const bool needs_more =
        (feature == Feature::kDynamicTriangleMesh && !capabilities().Has(Feature::kShapeTriangleMesh)) ||
        (feature == Feature::kDynamicHeightfield && !capabilities().Has(Feature::kShapeHeightfield));
    if (use == uses.end() || needs_more) continue;
    const auto world = Space(GetParam());
    const Status status = use->second(*world);
    EXPECT_EQ(status.ok(), has) << status;
    EXPECT_EQ(IsRefusedByName(status, GetParam(), feature), !has) << status;
  }
  RecordProperty("refuses", refused);
}

INSTANTIATE_TEST_SUITE_P(Engines, EngineCapabilities, ::testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const auto& backend : EveryEngine().backends()) {
                             names.push_back(backend->capabilities().engine());
                           }
                           return names;
                         }()),
                         EngineName);

TEST(CapabilitiesOfTheServer, AreWhatTheModelPromisesOnBothEngines) {
  for (const std::string engine : {"ode", "bullet"}) {
    const Backend* backend = Engines().Find(engine);
    ASSERT_NE(backend, nullptr);
    for (const Feature feature : {Feature::kShapeSphere,      Feature::kShapeBox,        Feature::kShapeCapsule,
                                  Feature::kShapeCylinder,    Feature::kShapeCone,       Feature::kShapeEllipsoid,
                                  Feature::kShapePlane,       Feature::kShapeConvexHull, Feature::kShapeTriangleMesh,
                                  Feature::kShapeHeightfield, Feature::kContacts,        Feature::kSensors,
                                  Feature::kRayCasts,         Feature::kShapeQueries,    Feature::kSolverIterative,
                                  Feature::kJointBall,        Feature::kJointHinge,      Feature::kJointSlider,
                                  Feature::kJointUniversal,   Feature::kJointFixed,      Feature::kJointWheel,
                                  Feature::kJointSixDof,      Feature::kJointDistance,   Feature::kJointGear,
                                  Feature::kErrorCorrection,  Feature::kSolverDirect,    Feature::kLockedAxes,
                                  Feature::kSurfaceVelocity}) {
      EXPECT_TRUE(backend->capabilities().Has(feature)) << engine << " lacks " << NameOf(feature);
    }
  }
}

// The rows and columns of docs/engines.md, for tools/engines_table.
TEST(Claims, AreTheRowsOfTheTable) {
  ASSERT_EQ(ClaimRows().size(), static_cast<size_t>(Claim::kCount));
  std::string rows, features, engines;
  for (size_t i = 0; i < ClaimRows().size(); ++i) {
    rows += NameOf(static_cast<Claim>(i)) + '|';
    const std::optional<Feature>& feature = ClaimRows()[i].feature;
    features += std::string(feature ? NameOf(*feature) : "") + '|';
  }
  for (const std::string& engine : EnginesWithContacts()) engines += engine + '|';
  RecordProperty("rows", rows);
  RecordProperty("features", features);
  RecordProperty("engines", engines);
}

}  // namespace
}  // namespace genphys::testing

#include "support/claims.h"

namespace genphys::testing {
namespace {

std::vector<ClaimRow> MakeRows() {
  std::vector<ClaimRow> rows;
  const char* group = "";
  const auto add = [&](const char* text, std::optional<Feature> feature = {}) {
    rows.push_back({group, text, feature});
  };
  group = "Shapes of bodies that move";
  add("sphere", Feature::kShapeSphere), add("box", Feature::kShapeBox), add("capsule", Feature::kShapeCapsule);
  add("cylinder", Feature::kShapeCylinder), add("cone", Feature::kShapeCone);
  add("ellipsoid", Feature::kShapeEllipsoid), add("convex hull", Feature::kShapeConvexHull);
  add("several with offsets");
  group = "Shapes of what stands still or is moved";
  add("plane", Feature::kShapePlane), add("triangle mesh", Feature::kShapeTriangleMesh);
  add("heightfield", Feature::kShapeHeightfield), add("every shape of bodies");
  add("triangle mesh moved by forces", Feature::kDynamicTriangleMesh);
  add("heightfield moved by forces", Feature::kDynamicHeightfield);
  group = "Motion";
  add("static, kinematic, dynamic, none"), add("kinematic bodies push"), add("kinematic bodies are led to a pose"),
      add("free rotation keeps its momentum");
  add("scale of gravity"), add("linear and angular damping"), add("largest speeds");
  add("locked axes", Feature::kLockedAxes), add("bodies, pictures, geometries and motion changed live"),
      add("bounds of the world");
  group = "Surfaces";
  add("static friction"), add("kinetic friction"), add("rolling and spinning friction"), add("restitution");
  add("rules of mixing"), add("surfaces that run", Feature::kSurfaceVelocity);
  group = "Forces";
  add("force at a point, for steps, added or replaced"), add("world and entity coordinates"), add("in columns");
  add("impulse"), add("net force told"), add("field: uniform"), add("field: drag and wind"), add("field: spring");
  add("field: point gravity"), add("field: buoyancy");
  group = "Joints";
  add("ball", Feature::kJointBall), add("hinge", Feature::kJointHinge), add("slider", Feature::kJointSlider);
  add("universal", Feature::kJointUniversal), add("fixed", Feature::kJointFixed), add("wheel", Feature::kJointWheel);
  add("six degrees of freedom", Feature::kJointSixDof), add("distance", Feature::kJointDistance);
  add("gear", Feature::kJointGear), add("limits", Feature::kJointHinge), add("motors", Feature::kJointHinge);
  add("springs and dampers", Feature::kJointSlider), add("breaking by force or torque", Feature::kJointFixed);
  add("everything changed live", Feature::kJointSlider);
  group = "Who collides";
  add("contacts", Feature::kContacts), add("categories and masks"), add("collision spaces");
  add("joined pairs ignore each other", Feature::kJointDistance), add("any pair ignores each other"),
      add("sensors", Feature::kSensors);
  group = "Solving";
  add("iterative solver", Feature::kSolverIterative), add("direct solver asked for", Feature::kSolverDirect);
  add("error correction in physical terms", Feature::kErrorCorrection);
  add("continuous collision", Feature::kContinuousCollision), add("sleeping, with thresholds and rest time");
  add("steps that take too much are undone");
  add("exact snapshot", Feature::kExactSnapshot);
  group = "Events";
  add("contact began, persisted, ended"), add("impulses that carry the weight");
  add("sensor entered, left", Feature::kSensors), add("slept, woke"), add("started, stopped moving and turning");
  add("joint broke", Feature::kJointFixed), add("entity faulted");
  add("joint and force field created, updated, deleted"), add("canonical order, the same bytes again");
  group = "Queries";
  add("closest hit of a ray", Feature::kRayCasts), add("all hits of a ray", Feature::kShapeQueries);
  add("shape cast", Feature::kShapeQueries), add("overlap", Feature::kShapeQueries);
  add("closest points and distance", Feature::kShapeQueries), add("contacts of an entity");
  group = "Engines";
  add("live change of engine"), add("the same results on every engine");
  return rows;
}

}  // namespace

const std::vector<ClaimRow>& ClaimRows() {
  static const std::vector<ClaimRow> rows = MakeRows();
  return rows;
}

std::string NameOf(Claim claim) {
  const ClaimRow& row = ClaimRows().at(static_cast<size_t>(claim));
  return row.group + ": " + row.text;
}

}  // namespace genphys::testing

#pragma once
#include <bitset>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

#include "genphys/joint.h"
#include "genphys/shape.h"

namespace genphys {

/// Something an engine may be able to do. The wire has the same list in the same order.
enum class Feature : uint8_t {
  kUnspecified,
  kShapeSphere,
  kShapeBox,
  kShapeCapsule,
  kShapeCylinder,
  kShapePlane,
  kShapeConvexHull,
  kShapeTriangleMesh,
  kShapeHeightfield,
  kContacts,
  kRayCasts,
  kSensors,
  kSolverIterative,
  kSolverDirect,
  kJointBall,
  kJointHinge,
  kJointSlider,
  kJointUniversal,
  kJointFixed,
  kErrorCorrection,
  kContinuousCollision,
  kExactSnapshot,
  kShapeCone,
  kShapeEllipsoid,
  kDynamicTriangleMesh,
  kDynamicHeightfield,
  kShapeQueries,
  kJointWheel,
  kJointSixDof,
  kJointDistance,
  kJointGear,
  kLockedAxes,
  kSurfaceVelocity,
  kCount,
};

/// snake_case name of `feature` for people, as in "shape_cylinder".
std::string_view NameOf(Feature feature);

/// The feature that `shape` needs.
Feature FeatureOf(const Shape& shape);
/// The feature that a joint of this kind needs.
Feature FeatureOf(const JointKind& kind);

/// What one engine can do, asked before it is called.
class Capabilities {
 public:
  Capabilities(std::string engine, std::string version, std::initializer_list<Feature> features);

  /// Short name, as in "ode".
  const std::string& engine() const { return engine_; }
  const std::string& version() const { return version_; }
  bool Has(Feature feature) const { return features_[static_cast<size_t>(feature)]; }

 private:
  std::string engine_;
  std::string version_;
  std::bitset<static_cast<size_t>(Feature::kCount)> features_;
};

}  // namespace genphys

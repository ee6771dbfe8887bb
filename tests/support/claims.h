#pragma once
#include <optional>
#include <string>
#include <vector>

#include "genphys/capabilities.h"

namespace genphys::testing {

/// What the model offers on an engine: a row of docs/engines.md, which conformance tests prove.
enum class Claim {
  // Shapes that bodies have.
  kSphere,
  kBox,
  kCapsule,
  kCylinder,
  kCone,
  kEllipsoid,
  kConvexHull,
  kCompound,
  // Shapes of what stands still.
  kPlane,
  kTriangleMesh,
  kHeightfield,
  kStaticSolid,
  kDynamicTriangleMesh,
  kDynamicHeightfield,
  // How things move.
  kMotionTypes,
  kKinematicPush,
  kKinematicLed,
  kFreeRotation,
  kGravityScale,
  kDamping,
  kSpeedMax,
  kLockedAxes,
  kLiveChange,
  kBounds,
  // Surfaces.
  kStaticFriction,
  kKineticFriction,
  kRollingFriction,
  kRestitution,
  kMixingRules,
  kSurfaceVelocity,
  // Forces.
  kForce,
  kForceCoordinates,
  kForceColumns,
  kImpulse,
  kNetForce,
  kUniformField,
  kDragField,
  kSpringField,
  kPointGravityField,
  kBuoyancyField,
  // Joints.
  kJointBall,
  kJointHinge,
  kJointSlider,
  kJointUniversal,
  kJointFixed,
  kJointWheel,
  kJointSixDof,
  kJointDistance,
  kJointGear,
  kJointLimit,
  kJointMotor,
  kJointSpring,
  kJointBreak,
  kJointChange,
  // Who collides with whom.
  kContacts,
  kCategories,
  kCollisionSpaces,
  kJoinedPairs,
  kIgnoredPairs,
  kSensors,
  // Solving and time.
  kSolverIterative,
  kSolverDirect,
  kErrorCorrection,
  kContinuousCollision,
  kSleeping,
  kBudget,
  kExactSnapshot,
  // What is told.
  kContactEvents,
  kContactImpulses,
  kSensorEvents,
  kSleepEvents,
  kMotionEvents,
  kJointBrokeEvents,
  kFaultEvents,
  kChangeEvents,
  kEventOrder,
  // What is answered.
  kRayCasts,
  kRaysThrough,
  kShapeCast,
  kOverlap,
  kClosestPoints,
  kContactsOf,
  // From engine to engine.
  kEngineChange,
  kEnginesAgree,
  kCount,
};

struct ClaimRow {
  std::string group;
  std::string text;
  /// Without which the claim is refused by name; unset: any engine with contacts.
  std::optional<Feature> feature;
};

/// By number of the claim.
const std::vector<ClaimRow>& ClaimRows();

/// As the table and the reports name it.
std::string NameOf(Claim claim);

}  // namespace genphys::testing

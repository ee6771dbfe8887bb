#pragma once
#include <optional>

#include "genphys/capabilities.h"
#include "genphys/command.h"
#include "genphys/entity.h"
#include "genphys/status.h"
#include "genphys/stepper.h"
#include "genphys/v1/engine_service.pb.h"
#include "genphys/v1/entity.pb.h"
#include "genphys/v1/error.pb.h"
#include "genphys/v1/stepper.pb.h"
#include "genphys/v1/types.pb.h"

// Enums of the model and of the wire. Most have a default at zero on the wire and none in the model, so their numbers
// are one apart. A number that neither knows becomes the default.

namespace genphys {

static_assert(static_cast<int>(Feature::kCount) == v1::Feature_ARRAYSIZE, "the wire has the same list of features");
static_assert(static_cast<int>(Feature::kExactSnapshot) == v1::FEATURE_EXACT_SNAPSHOT, "in the same order");
static_assert(static_cast<int>(Feature::kJointGear) == v1::FEATURE_JOINT_GEAR, "in the same order");
static_assert(static_cast<int>(Feature::kSurfaceVelocity) == v1::FEATURE_SURFACE_VELOCITY, "in the same order");
static_assert(static_cast<int>(Reason::kInvalidValue) + 1 == v1::ErrorReason_ARRAYSIZE, "the wire has every reason");

inline v1::Feature EncodeFeature(Feature feature) { return static_cast<v1::Feature>(feature); }

inline Feature DecodeFeature(int feature) {
  return v1::Feature_IsValid(feature) ? static_cast<Feature>(feature) : Feature::kUnspecified;
}

inline v1::Mixing EncodeMixing(Mixing mixing) { return static_cast<v1::Mixing>(static_cast<int>(mixing) + 1); }

/// Nothing for the default.
inline std::optional<Mixing> DecodeMixing(v1::Mixing mixing) {
  if (mixing == v1::MIXING_UNSPECIFIED || !v1::Mixing_IsValid(mixing)) return std::nullopt;
  return static_cast<Mixing>(static_cast<int>(mixing) - 1);
}

inline v1::MotionType EncodeMotionType(MotionType type) {
  return static_cast<v1::MotionType>(static_cast<int>(type) + 1);
}

inline MotionType DecodeMotionType(v1::MotionType type) {
  switch (type) {
    case v1::MOTION_TYPE_STATIC:
      return MotionType::kStatic;
    case v1::MOTION_TYPE_KINEMATIC:
      return MotionType::kKinematic;
    default:
      return MotionType::kDynamic;
  }
}

inline v1::Coordinates EncodeCoordinates(Coordinates coordinates) {
  return coordinates == Coordinates::kEntity ? v1::COORDINATES_ENTITY : v1::COORDINATES_WORLD;
}

inline Coordinates DecodeCoordinates(v1::Coordinates coordinates) {
  return coordinates == v1::COORDINATES_ENTITY ? Coordinates::kEntity : Coordinates::kWorld;
}

inline v1::Stepper::Solver EncodeSolver(Solver solver) { return static_cast<v1::Stepper::Solver>(solver); }

inline Solver DecodeSolver(v1::Stepper::Solver solver) {
  return v1::Stepper::Solver_IsValid(solver) ? static_cast<Solver>(solver) : Solver::kAutomatic;
}

inline v1::Stepper::Quality EncodeQuality(Quality quality) {
  return static_cast<v1::Stepper::Quality>(static_cast<int>(quality) + 1);
}

inline Quality DecodeQuality(v1::Stepper::Quality quality) {
  switch (quality) {
    case v1::Stepper::QUALITY_FAST:
      return Quality::kFast;
    case v1::Stepper::QUALITY_ACCURATE:
      return Quality::kAccurate;
    default:
      return Quality::kBalanced;
  }
}

}  // namespace genphys

#pragma once

namespace genphys {

/// What the model accepts, in SI units. The wire declares the same numbers as field options (a test compares them).
struct Limits {
  static constexpr double kMassMin = 1e-9;
  static constexpr double kMassMax = 1e9;
  static constexpr double kSizeMin = 1e-5;
  static constexpr double kSizeMax = 1e5;
  static constexpr double kPositionMax = 1e7;
  static constexpr double kSpeedMax = 1e5;
  static constexpr double kSpinMax = 1e4;
  static constexpr double kStepSizeMin = 1e-6;
  static constexpr double kStepSizeMax = 0.25;
  static constexpr double kDensityMin = 1e-6;
  static constexpr double kDensityMax = 1e5;
  static constexpr double kFrictionMax = 1000;
  static constexpr double kFrictionArmMax = 1000;  ///< Of rolling and spinning friction, m.
  static constexpr double kGravityMax = 1e4;
  static constexpr double kGravityScaleMax = 1000;
  static constexpr double kForceMax = 1e12;
  static constexpr double kDampingMax = 1e4;
  static constexpr double kStiffnessMax = 1e15;
  static constexpr double kDragMax = 1e12;
  static constexpr double kPointGravityMax = 1e20;
  static constexpr unsigned kForceFieldsMax = 1000;
  static constexpr double kInertiaMax = 1e20;
  static constexpr double kRestTimeMax = 1e6;
  static constexpr double kCorrectionTimeMax = 1e6;
  static constexpr double kSlopMax = 1;
  static constexpr double kRayLengthMax = 2e7;
  /// Of a spring, a damper or a motor, in its own unit: N/m, N*s/m, N, or those of rotation.
  static constexpr double kJointAngleMax = 1e4;
  static constexpr double kGearRatioMax = 1e6;
  /// How far the length of a quaternion or normal may be from one before it is refused; within, it is normalised.
  static constexpr double kUnitLengthTolerance = 1e-3;
  static constexpr unsigned kSubstepsMax = 64;
  static constexpr unsigned kIterationsMax = 1000;
  static constexpr unsigned kForceStepsMax = 1'000'000'000;
  static constexpr unsigned kGeometriesMax = 256;
  static constexpr unsigned kIgnoredEntitiesMax = 1000;
  static constexpr unsigned kHeightfieldSideMax = 1024;
  static constexpr unsigned kJointsMax = 1'000'000;
  static constexpr unsigned kEntitiesMax = 1'000'000;
  /// Of all entities of a world together, each of which takes about 2 kB.
  static constexpr unsigned kWorldGeometriesMax = 1'000'000;
  /// That the hulls, meshes and heightfields of a world take, each counted once however many copies it has.
  static constexpr unsigned kShapeMebibytesMax = 1024;
  /// Forces of commands that wait for a step, or for more of them.
  static constexpr unsigned kPendingForcesMax = 2'000'000;
  /// Of geometries near each other, and of points at which they touch, when a step begins: memory grows with them.
  static constexpr unsigned kNearPairsMax = 1'000'000;
  static constexpr unsigned kContactPointsMax = 1'000'000;
  /// At corners and triangles of shapes near each other, in one step: time grows with them, about a second for 4e8.
  static constexpr long long kLooksMax = 4'000'000'000;
  /// Hits or overlaps that one query tells.
  static constexpr unsigned kQueryResultsMax = 4'000'000;
};

}  // namespace genphys

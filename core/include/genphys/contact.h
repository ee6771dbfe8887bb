#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "genphys/error_correction.h"
#include "genphys/ids.h"
#include "genphys/limits.h"
#include "genphys/material.h"
#include "genphys/math.h"

namespace genphys {

/// Geometries count in one dense list per world; a backend hands these numbers back in contacts and ray hits.
enum class GeometryRow : uint32_t {};

constexpr uint32_t Index(GeometryRow row) { return static_cast<uint32_t>(row); }

/// One point of a touching or nearly touching pair, at the poses at which FindPoints() was called.
struct ContactPoint {
  Vector3 position = Vector3::Zero();          // m, world
  Vector3 normal = Vector3::UnitZ();           // unit length, from entity a towards entity b, world
  double depth = 0;                            // m; negative is a gap
  double friction = 0;                         // Coulomb coefficient that Solve() uses; the layer fills it before
  double normal_impulse = 0;                   // N*s on b along the normal, of the last Solve(); zero before it
  Vector3 friction_impulse = Vector3::Zero();  // N*s on b, of the last Solve()
  Vector3 relative_velocity =
      Vector3::Zero();  // of b against a at the point, before the solve, m/s; the layer fills it
  /// m/s: by how much faster the two part here on the mean of the substep than before the solve, for they turn. What
  /// touches must part at -`bend` at least after the solve; the layer fills it before.
  double bend = 0;
  bool is_ahead = false;  // of a gap that the layer closes itself, as an impact: Solve() must not push here
};

/// Two geometries whose points follow each other in ContactBuffer::points.
struct ContactPair {
  EntityRow entity_a{};  // has the smaller id
  EntityRow entity_b{};
  GeometryRow geometry_a{};
  GeometryRow geometry_b{};
  MixedMaterial material;
  ErrorCorrection correction;
  /// m/s, world: how the surface of b runs against that of a, on top of how both move. Solve() takes what lies across
  /// the normal of a point as slip there; the layer fills it before.
  Vector3 surface_velocity = Vector3::Zero();
  /// m/s, world: by how much more the two slip on the mean of the substep than before the solve, for they turn. Solve()
  /// adds it to the slip that it holds; what slides is braked against the slip as it is before, in the middle of the
  /// time for which the solve acts; the layer fills it before.
  Vector3 bend = Vector3::Zero();
  /// m/s, world: by how much more the two would slip after Solve() than before if all but friction between them were as
  /// in the last solve, and there were none. It tells the direction in which joints and other contacts draw over a
  /// surface what they hold; zero where nothing tells it. The layer fills it before.
  Vector3 drawn = Vector3::Zero();
  /// rad/s, world: how b turns against a before the solve, in the middle of the time that this is for. What rolls fast
  /// is braked against that. The layer fills it before where something resists rolling.
  Vector3 rolling = Vector3::Zero();
  /// s, for which Solve() acts on the two, and what is held gives impulses that grow with it; the layer fills it
  /// before.
  double interval = 0;
  /// The part of its impulses that it owes the two after Solve(), for the time from the middle of the substep to its
  /// end; the layer fills it then.
  double owed = 0;
  bool is_sensor = false;  // the engine must not push for it
  uint32_t first_point = 0;
  uint32_t point_count = 0;
};

/// What the last solve left of a point of which a buffer tells how it goes on from there instead.
struct SolvedPoint {
  uint32_t point = 0;                          // in ContactBuffer::points
  Vector3 friction_impulse = Vector3::Zero();  // as in ContactPoint
  Vector3 relative_velocity = Vector3::Zero();
};

/// By what to multiply an impulse that held something for `before` s, to hold it for `now` s.
inline double ImpulseScale(double before, double now) { return before > 0 ? now / before : 1; }

/// What touches, in canonical order: by (id of a, id of b, geometry id in a, geometry id in b).
struct ContactBuffer {
  std::vector<ContactPair> pairs;
  std::vector<ContactPoint> points;
  /// Ascending; of those that turned within the substep. Who tells of the last solve shows these, who solves goes on
  /// from `points`.
  std::vector<SolvedPoint> turned;
  double pull = kUsualPull;  // m/s^2, of gravity: by it solvers tell what slips slowly

  static constexpr double kUsualPull = 9.81;  // of the Earth, also where nothing pulls

  void Clear() {
    pairs.clear();
    points.clear();
    turned.clear();
  }
};

/// How many pairs of geometries may be near each other, and at how many points they may touch: memory grows with them.
/// What a step may look at of their shapes is time: see WorkWatch::Look().
struct ContactBudget {
  size_t pairs = Limits::kNearPairsMax;
  size_t points = Limits::kContactPointsMax;
  int64_t looks = Limits::kLooksMax;
};

/// Pairs with a wider gap (m) have no contact point, on any engine.
inline constexpr double kContactGapMax = 2e-3;

/// Pairs touch when a point is at least this deep (m), on every engine, or when it passed on an impulse.
inline constexpr double kTouchingDepth = -1e-4;

}  // namespace genphys

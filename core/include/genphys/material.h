#pragma once
#include <cstdint>
#include <optional>

namespace genphys {

/// How the coefficients of two touching materials become one. Of two different rules the later one counts.
enum class Mixing : uint8_t { kGeometricMean, kAverage, kMinimum, kMultiply, kMaximum };

/// Surface and bulk properties. Unset fields take the world's defaults; a Scene holds none unset.
struct Material {
  std::optional<double> friction;            // Coulomb coefficient at rest, default 0.5
  std::optional<double> kinetic_friction;    // Coulomb coefficient while sliding, default: as friction
  std::optional<double> restitution;         // speed of separation over speed of approach, 0..1, default 0
  std::optional<double> density;             // kg/m^3, default 1000
  std::optional<Mixing> friction_mixing;     // of all coefficients of friction, default geometric mean
  std::optional<Mixing> restitution_mixing;  // default geometric mean
  std::optional<double> rolling_friction;    // m: largest torque across the normal per normal force, default 0
  std::optional<double> spinning_friction;   // m: largest torque along the normal per normal force, default 0
  bool operator==(const Material&) const = default;
};

/// `material` with every unset field taken from `defaults`, and what that lacks from the defaults in the comments
/// above.
Material Filled(const Material& material, const Material& defaults);

/// What two touching surfaces have in common.
struct MixedMaterial {
  double friction = 0;
  double kinetic_friction = 0;
  double restitution = 0;
  double rolling_friction = 0;   // m
  double spinning_friction = 0;  // m
};

/// Both materials must be filled.
MixedMaterial Mix(const Material& a, const Material& b);

}  // namespace genphys

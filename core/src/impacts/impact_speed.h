#pragma once
#include "genphys/contact.h"
#include "impacts/impact_world.h"

namespace genphys {

/// From which closing speed on (m/s) two bodies collide: below it they only come to rest on each other.
class ImpactSpeed {
 public:
  /// m/s, on top of what acceleration alone brings up in a substep.
  static constexpr double kMin = 1e-3;

  ImpactSpeed(const ImpactWorld& world, double step_size) : world_(world), step_size_(step_size) {}

  double Of(EntityRow a, EntityRow b, const Vector3& normal) const;
  /// Nothing held or hit it in the last substep. What cannot be moved counts as well.
  bool IsInFlight(EntityRow row) const;
  /// Whether an impact of this pair is solved apart from the engine even without restitution. Those that are held
  /// already come to rest on each other in the engine, together with all that holds them.
  bool IsFree(const ContactPair& pair) const;
  /// Whether one of them flies on its own even now, after the solve of this substep.
  bool IsStillFree(const ContactPair& pair) const;

 private:
  bool IsMovable(EntityRow row, GeometryRow geometry) const;

  const ImpactWorld& world_;
  double step_size_;
};

}  // namespace genphys

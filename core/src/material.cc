#include "genphys/material.h"

#include <cmath>

#include "genphys/entity.h"

namespace genphys {
namespace {

template <typename T>
T Either(const std::optional<T>& own, const std::optional<T>& given, T fallback) {
  return own ? *own : given.value_or(fallback);
}

}  // namespace

Material Filled(const Material& material, const Material& defaults) {
  Material filled;
  filled.friction = Either(material.friction, defaults.friction, 0.5);
  // A friction given without its kinetic twin speaks for both; the world's kinetic default must not undercut it.
  if (material.kinetic_friction) {
    filled.kinetic_friction = material.kinetic_friction;
  } else if (material.friction) {
    filled.kinetic_friction = material.friction;
  } else {
    filled.kinetic_friction = defaults.kinetic_friction.value_or(*filled.friction);
  }
  filled.restitution = Either(material.restitution, defaults.restitution, 0.0);
  filled.density = Either(material.density, defaults.density, 1000.0);
  return filled;
}

MixedMaterial Mix(const Material& a, const Material& b) {
  return {std::sqrt(*a.friction * *b.friction), std::sqrt(*a.kinetic_friction * *b.kinetic_friction),
          std::sqrt(*a.restitution * *b.restitution)};
}

AutoDisable Filled(const AutoDisable& policy, const AutoDisable& defaults) {
  return {Either(policy.enabled, defaults.enabled, true),
          Either(policy.linear_speed_max, defaults.linear_speed_max, 0.02),
          Either(policy.angular_speed_max, defaults.angular_speed_max, 0.05),
          Either(policy.rest_time, defaults.rest_time, 0.5)};
}

}  // namespace genphys

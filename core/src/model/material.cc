#include "genphys/material.h"

#include <algorithm>
#include <cmath>

#include "genphys/entity.h"

namespace genphys {
namespace {

template <typename T>
T Either(const std::optional<T>& own, const std::optional<T>& given, T fallback) {
  return own ? *own : given.value_or(fallback);
}

double Mixed(Mixing rule, double a, double b) {
  // Most of what touches is of one material, and a root for each pair of a pile is a part of its step.
  if (a == b && rule != Mixing::kMultiply) return a;
  switch (rule) {
    case Mixing::kGeometricMean:
      return std::sqrt(a * b);
    case Mixing::kAverage:
      return (a + b) / 2;
    case Mixing::kMinimum:
      return std::min(a, b);
    case Mixing::kMultiply:
      return a * b;
    case Mixing::kMaximum:
      return std::max(a, b);
  }
  return 0;
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
  filled.friction_mixing = Either(material.friction_mixing, defaults.friction_mixing, Mixing::kGeometricMean);
  filled.restitution_mixing = Either(material.restitution_mixing, defaults.restitution_mixing, Mixing::kGeometricMean);
  filled.rolling_friction = Either(material.rolling_friction, defaults.rolling_friction, 0.0);
  filled.spinning_friction = Either(material.spinning_friction, defaults.spinning_friction, 0.0);
  return filled;
}

MixedMaterial Mix(const Material& a, const Material& b) {
  const Mixing friction = std::max(*a.friction_mixing, *b.friction_mixing);
  return {Mixed(friction, *a.friction, *b.friction), Mixed(friction, *a.kinetic_friction, *b.kinetic_friction),
          Mixed(std::max(*a.restitution_mixing, *b.restitution_mixing), *a.restitution, *b.restitution),
          Mixed(friction, *a.rolling_friction, *b.rolling_friction),
          Mixed(friction, *a.spinning_friction, *b.spinning_friction)};
}

AutoDisable Filled(const AutoDisable& policy, const AutoDisable& defaults) {
  return {Either(policy.enabled, defaults.enabled, true),
          Either(policy.linear_speed_max, defaults.linear_speed_max, 0.02),
          Either(policy.angular_speed_max, defaults.angular_speed_max, 0.05),
          Either(policy.rest_time, defaults.rest_time, 0.5)};
}

}  // namespace genphys

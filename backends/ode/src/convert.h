#pragma once
#include <ode/common.h>

#include "genphys/math.h"

namespace genphys::ode_backend {

inline Vector3 FromOde(const dReal* v) { return {v[0], v[1], v[2]}; }

inline void ToOde(const Vector3& v, dReal* to) {
  for (int i = 0; i < 3; ++i) to[i] = v[i];
}

}  // namespace genphys::ode_backend

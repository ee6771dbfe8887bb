#pragma once
#include <ode/common.h>
#include <ode/objects.h>

#include "genphys/math.h"

namespace genphys::ode_backend {

inline Vector3 FromOde(const dReal* v) { return {v[0], v[1], v[2]}; }

inline void ToOde(const Vector3& v, dReal* to) {
  for (int i = 0; i < 3; ++i) to[i] = v[i];
}

// Whatever it was before: its moments are the same about all axes, but for what rounding makes of them.
inline void SetUpright(dBodyID body) {
  const dQuaternion upright = {1, 0, 0, 0};
  dBodySetQuaternion(body, upright);
}

}  // namespace genphys::ode_backend

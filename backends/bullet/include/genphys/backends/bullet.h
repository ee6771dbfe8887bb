#pragma once
#include <memory>

#include "genphys/backend.h"

namespace genphys {

/// Bullet 3 in double precision: its sequential impulse solver, driven in canonical order, with the rows and sweeps of
/// the layer (ContactSweeps). Contacts are a function of the poses alone; only the impulses that warm-start the solver
/// are carried from one solve to the next. `kDirect` solves an island of up to 100 points all at once, `kAutomatic`
/// decides for each island by its size, joints and masses.
std::unique_ptr<Backend> MakeBulletBackend();

}  // namespace genphys

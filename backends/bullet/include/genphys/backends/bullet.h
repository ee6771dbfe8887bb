#pragma once
#include <memory>

#include "genphys/backend.h"

namespace genphys {

/// Bullet 3 in double precision: its sequential impulse solver, driven in canonical order. Contacts are a function of
/// the poses alone; only the impulses that warm-start the solver are carried from one solve to the next.
///
/// While the preset's 10 iterations are in force, a substep with fewer than 200 contact points makes more, up to 100:
/// so few points cost next to nothing. There is no exact solver: `kAutomatic` is `kIterative`.
std::unique_ptr<Backend> MakeBulletBackend();

}  // namespace genphys

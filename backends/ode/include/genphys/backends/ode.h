#pragma once
#include <memory>

#include "genphys/backend.h"

namespace genphys {

/// The Open Dynamics Engine, 0.16 in double precision.
///
/// `kIterative` is its QuickStep. While the preset's 20 iterations are in force, a substep with few constraint rows
/// (three for each point with friction) gets more of them, up to 150, for 10,000 updates of a row in all: they cost
/// next to nothing, and 20 leave a small stack creeping. `kDirect` is its exact solver, for great ratios of mass and
/// small stacks; its cost grows with the cube of the contacts, so a substep with more than 100 points is solved
/// iteratively. `kAutomatic` is `kIterative`, which is truer where sticking turns into sliding.
std::unique_ptr<Backend> MakeOdeBackend();

}  // namespace genphys

#pragma once
#include <memory>

#include "genphys/backend.h"

namespace genphys {

/// The Open Dynamics Engine, 0.16 in double precision.
///
/// `kIterative` is ContactSweeps, those of the layer: see docs/decisions/README.md for what its own came to. `kDirect`
/// is its exact solver, for great ratios of mass, and for joints where the layer's own does not find who obeys what;
/// its cost grows with the cube of the contacts, so an island with more than 100 points is swept. `kAutomatic` decides
/// for each island by its size, joints and masses.
std::unique_ptr<Backend> MakeOdeBackend();

}  // namespace genphys

#pragma once
#include <cstddef>

#include "case.h"

namespace genphys::bench {

/// How far `joint`, a hinge, is turned from where it began, rad.
double HingeAngle(const Simulation& simulation, const Scene& scene, size_t joint);

/// How far the farthest of all that move is aside from where it began, m.
Gauge Drift();
/// The mean of their velocities along x, m/s.
Gauge SpeedAlongX();

}  // namespace genphys::bench

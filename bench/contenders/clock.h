#pragma once

namespace genphys::bench {

/// Processor time of this process since it began, s.
double ProcessorTime();

/// Seconds of processor time that a fixed piece of arithmetic takes here and now: what costs are compared with, so that
/// figures of different machines, or of one that is busy, can be.
double CalibrationTime();

}  // namespace genphys::bench

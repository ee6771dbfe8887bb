#include "clock.h"

#include <time.h>

#include "genphys/math.h"

namespace genphys::bench {

double ProcessorTime() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double CalibrationTime() {
  constexpr int kTurns = 200'000;
  // Each turn needs the one before: neither the compiler nor the processor can take several at once.
  const Quaternion turn(Eigen::AngleAxisd(1e-3, Vector3(1, 2, 3).normalized()));
  const double begin = ProcessorTime();
  Quaternion orientation = Quaternion::Identity();
  for (int i = 0; i < kTurns; ++i) orientation = (turn * orientation).normalized();
  volatile double used = orientation.w();
  static_cast<void>(used);
  return ProcessorTime() - begin;
}

}  // namespace genphys::bench

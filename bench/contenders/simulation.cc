#include "simulation.h"

#include "clock.h"

namespace genphys::bench {

double Simulation::TimedSteps(double step_size, long count) {
  const double begin = ProcessorTime();
  for (long i = 0; i < count; ++i) Step(step_size);
  return ProcessorTime() - begin;
}

void Simulation::Aim(std::span<const size_t>, std::span<const double>, std::span<const double>) {
  throw NotHad("motors");
}

}  // namespace genphys::bench

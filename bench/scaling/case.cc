#include "case.h"

namespace genphys::bench {

std::vector<Case> Cases() {
  return {
      {"passer", "a box slides past others that sleep, or are static, and is watched", MeasurePasser},
      {"asleep", "all sleep", MeasureAsleep},
      {"woken", "a ball hits a pile that sleeps", MeasureWoken},
      {"flyers", "10,000 bodies in free flight", MeasureFlyers},
      {"pile", "a pile of 1,000 boxes that does not sleep", MeasurePile},
      {"small", "40 worlds, each with a pile of 16 to 72 boxes that does not sleep", MeasureSmallPiles},
      {"islands", "piles of 20 boxes that do not sleep, among 200 that do, and without them", MeasureIslands},
      {"space", "1,000 members of a collision space that touch nothing", MeasureSpace},
      {"commands", "one command for each of many sleeping boxes, in one batch", MeasureCommands},
      {"worlds", "empty worlds, and servers that have nothing to do", MeasureWorlds},
  };
}

}  // namespace genphys::bench

#include "genphys/hosting/stamp.h"

#include <random>

namespace genphys {

void Stamp::Encode(v1::WorldStamp* out) const {
  out->set_step(step);
  out->set_simulation_time_seconds(simulation_time);
  out->set_epoch(epoch);
  if (state_hash) out->set_state_hash(*state_hash);
}

uint64_t NewEpoch() {
  std::random_device device;
  std::uniform_int_distribution<uint64_t> any(1);
  return any(device);
}

}  // namespace genphys

#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "genphys/hosting/bytes.h"
#include "genphys/status.h"
#include "genphys/v1/simulation_service.pb.h"

namespace genphys {

/// The Step requests of one world as messages. One that differs from the last in nothing but its id, as those of a loop
/// do, is not decoded and not checked once more.
class StepRequests {
 public:
  /// The request, found to be within its limits; its id may be that of one before.
  Result<std::shared_ptr<const v1::StepRequest>> Decode(const Bytes& request);

 private:
  // Longer ones are not kept, for worlds are many.
  static constexpr size_t kBytesMax = 1024;

  bool RepeatsLast(std::string_view request) const;
  void Keep(std::string_view request, std::shared_ptr<const v1::StepRequest> message);

  std::shared_ptr<const v1::StepRequest> last_;
  std::string bytes_;  // of it
  size_t id_begin_ = 0;
  size_t id_end_ = 0;
};

}  // namespace genphys

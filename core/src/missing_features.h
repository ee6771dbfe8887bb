#pragma once
#include <bitset>

#include "genphys/capabilities.h"
#include "genphys/entity.h"
#include "genphys/status.h"

namespace genphys {

/// What a world uses and an engine cannot do.
class MissingFeatures {
 public:
  explicit MissingFeatures(const Capabilities& capabilities) : capabilities_(capabilities) {}

  void Need(Feature feature);
  void Need(const EntityDesc& desc);

  /// OK, or UNSUPPORTED_FEATURE with the name of each that is missing.
  Status Check() const;

 private:
  const Capabilities& capabilities_;
  std::bitset<static_cast<size_t>(Feature::kCount)> missing_;
};

}  // namespace genphys

#pragma once
#include <stdexcept>
#include <utility>

#include "genphys/status.h"

namespace genphys::bench {

/// Throws a std::runtime_error unless `status` is OK.
inline void Check(const Status& status) {
  if (!status.ok()) throw std::runtime_error(status.ToString());
}

/// What `result` has; it is a std::runtime_error if it has none.
template <typename T>
T Must(Result<T> result) {
  Check(result.status());
  return *std::move(result);
}

}  // namespace genphys::bench

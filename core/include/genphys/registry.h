#pragma once
#include <memory>
#include <string_view>
#include <vector>

#include "genphys/backend.h"
#include "genphys/status.h"

namespace genphys {

/// The engines that this build offers, in the order added; the first is the default.
class BackendRegistry {
 public:
  void Add(std::unique_ptr<Backend> backend);

  /// Null if there is no engine of that short name ("ode").
  const Backend* Find(std::string_view name) const;
  const std::vector<std::unique_ptr<Backend>>& backends() const { return backends_; }

  /// Runs the self-test of every engine: the first failure, or OK.
  Status SelfTest() const;

 private:
  std::vector<std::unique_ptr<Backend>> backends_;
};

}  // namespace genphys

#pragma once
#include <string>

#include "child_process.h"

namespace genphys::bench {

/// A genphysd that listens at a free port of this machine and ends with this object. Failures are std::runtime_errors.
class ServerProcess {
 public:
  /// `program` is the path of genphysd.
  explicit ServerProcess(const std::string& program);

  const std::string& address() const { return address_; }
  const ChildProcess& process() const { return process_; }

 private:
  ChildProcess process_;
  std::string address_;
};

}  // namespace genphys::bench

#pragma once
#include <vector>

#include "child_process.h"

namespace genphys::bench {

/// How much of the machine everybody else used while something was measured, so that a result can say it, and a
/// measurement that others disturbed be told from one that they did not.
class OthersWatch {
 public:
  /// Processes that belong to the measurement, as this one does. They outlive this object.
  explicit OthersWatch(std::vector<const ChildProcess*> ours);

  void Begin();
  /// Processors that others, the kernel's interrupts and other guests of the host kept busy since Begin(), on average.
  double End() const;

 private:
  struct Reading {
    double time = 0;  // s
    double idle = 0;  // s, all processors together
    double ours = 0;  // s of processor time
  };
  Reading Read() const;

  std::vector<const ChildProcess*> ours_;
  Reading begin_;
};

/// Load average of the last minute.
double LoadAverage();

}  // namespace genphys::bench

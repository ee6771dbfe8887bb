#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>

namespace genphys {

/// How many calls are under way.
class OpenCalls {
 public:
  void Begin() { ++count_; }
  void End() { --count_; }

  /// Returns at once if none is under way, else a little after the last one's end, and at `deadline` if that does not
  /// come: a connection that closes while its client still writes to it takes with it what the client has not read yet,
  /// which is how its calls ended.
  void AwaitEnd(std::chrono::steady_clock::time_point deadline) const;

 private:
  std::atomic<int64_t> count_ = 0;
};

}  // namespace genphys

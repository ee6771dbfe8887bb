#include "open_calls.h"

#include <thread>

namespace genphys {
namespace {

constexpr std::chrono::milliseconds kLook(1);
// For the last words to cross a network of some width.
constexpr std::chrono::milliseconds kFarewell(100);

}  // namespace

void OpenCalls::AwaitEnd(std::chrono::steady_clock::time_point deadline) const {
  if (count_ == 0) return;
  while (count_ > 0 && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(kLook);
  if (count_ == 0) std::this_thread::sleep_for(kFarewell);
}

}  // namespace genphys

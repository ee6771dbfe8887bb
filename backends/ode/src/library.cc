#include "library.h"

#include <ode/ode.h>

#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <vector>

#include "genphys/backend.h"

namespace genphys::ode_backend {
namespace {

// The library aborts the process when this returns. It may throw instead: the frames between are C++.
void ThrowFault(int, const char* format, va_list arguments) {
  constexpr size_t kMessageSizeMax = 256;
  char message[kMessageSizeMax];
  std::vsnprintf(message, sizeof message, format, arguments);
  throw EngineFault(std::string("ODE: ") + message);
}

thread_local uint64_t complaints = 0;

// Messages only tell that an equation was solved badly; without a handler they go to the process's standard error.
void CountMessage(int, const char*, va_list) { ++complaints; }

}  // namespace

void StartLibrary() {
  static std::once_flag once;
  std::call_once(once, [] {
    dSetErrorHandler(ThrowFault);
    dSetDebugHandler(ThrowFault);
    dSetMessageHandler(CountMessage);
    dInitODE2(0);
  });
}

void PrepareThread() {
  thread_local const bool prepared = dAllocateODEDataForThread(dAllocateMaskAll) != 0;
  if (!prepared) throw EngineFault("ODE: no memory for the data of a thread");
}

uint64_t Complaints() { return complaints; }

void Abandon(dxThreadingImplementation* threading) {
  static std::mutex mutex;
  // Never destroyed, so that worlds may still end while the process does.
  static auto& abandoned = *new std::vector<dxThreadingImplementation*>;
  const std::lock_guard lock(mutex);
  abandoned.push_back(threading);
}

}  // namespace genphys::ode_backend

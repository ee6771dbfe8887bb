#pragma once
#include <cstdint>

struct dxThreadingImplementation;

namespace genphys::ode_backend {

/// Starts the library once per process and makes its fatal errors EngineFault. Cheap to call again, from any thread.
void StartLibrary();

/// Makes the calling thread fit to use the library. Cheap to call again.
void PrepareThread();

/// How often the library has said on this thread that it solved something badly.
uint64_t Complaints();

/// Keeps for the life of the process what a faulted world leaves behind: it still holds work to do, and freeing it
/// would end the process. Some 66 kB each.
void Abandon(dxThreadingImplementation* threading);

}  // namespace genphys::ode_backend

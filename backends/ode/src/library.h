#pragma once
#include <cstdint>

struct dxThreadingImplementation;

namespace genphys::ode_backend {

class RowOrder;

/// Starts the library once per process and makes its fatal errors EngineFault. Cheap to call again, from any thread.
void StartLibrary();

/// Makes the calling thread fit to use the library. Cheap to call again.
void PrepareThread();

/// How often the library has said on this thread that it solved something badly.
uint64_t Complaints();

/// Keeps for the life of the process what a faulted world leaves behind: it still holds work to do, and freeing it
/// would end the process. Some 66 kB each.
void Abandon(dxThreadingImplementation* threading);

/// How many random numbers were drawn on this thread.
uint64_t RandomDraws();

/// The next of them.
uint32_t DrawRandom();

/// From now on the library takes rows on this thread in that order; null: in its own. The order must outlive that.
void OrderRowsBy(RowOrder* order);

}  // namespace genphys::ode_backend

#include "genphys/hosting/memory_return.h"

#include <malloc.h>

// Of tcmalloc (gperftools/malloc_extension_c.h), with which the server is linked, but neither tests nor sanitizers are.
extern "C" [[gnu::weak]] void MallocExtension_ReleaseFreeMemory();

namespace genphys {

void MemoryReturn::Note() {
  if (is_due_->exchange(true)) return;
  pool_.PostAt(WorkerPool::Clock::now() + kPause, [is_due = is_due_] {
    *is_due = false;
    if (MallocExtension_ReleaseFreeMemory != nullptr) {
      MallocExtension_ReleaseFreeMemory();
    } else {
      malloc_trim(0);
    }
  });
}

}  // namespace genphys

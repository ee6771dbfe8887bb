#include "genphys/joint_memory.h"

#include <algorithm>
#include <utility>

#include "model/serialize.h"

namespace genphys {

void JointMemory::Sort() {
  std::ranges::stable_sort(entries_, {}, [](const Entry& entry) { return PairOf(entry.key); });
}

const JointMemory::Entry* JointMemory::Take(const Key& key) {
  const auto alike =
      std::ranges::equal_range(entries_, PairOf(key), {}, [](const Entry& entry) { return PairOf(entry.key); });
  for (Entry& entry : alike) {
    if (entry.key == key && !std::exchange(entry.is_taken, true)) return &entry;
  }
  return nullptr;
}

void JointMemory::Remove(EntityId id) {
  std::erase_if(entries_, [&](const Entry& entry) { return entry.key.a == id || entry.key.b == id; });
}

void JointMemory::Save(std::string& bytes) const {
  ByteWriter writer(bytes);
  writer.Put(uint64_t{entries_.size()});
  for (const Entry& entry : entries_) {
    writer.Put(entry.key.a.packed());
    writer.Put(entry.key.b.packed());
    writer.Put(entry.key.lower);
    writer.Put(entry.key.upper);
    writer.Put(entry.impulse);
  }
}

}  // namespace genphys

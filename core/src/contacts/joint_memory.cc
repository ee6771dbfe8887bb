#include "genphys/joint_memory.h"

#include "model/serialize.h"

namespace genphys {

const JointMemory::Entry* JointMemory::Find(const Key& key, size_t& next) const {
  for (size_t i = 0; i < entries_.size(); ++i) {
    const size_t at = next + i < entries_.size() ? next + i : next + i - entries_.size();
    if (entries_[at].key != key) continue;
    next = at + 1 < entries_.size() ? at + 1 : 0;
    return &entries_[at];
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

#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

namespace genphys {

/// What an engine remembers of pairs at which nobody looks because neither side moves. They are found by those of their
/// bodies that may be woken, so that one of them costs by how many pairs it has, and not by how many rest.
template <typename Memory, typename Body>
class RestingPairs {
 public:
  /// Keeps what is remembered of a pair. `wakeable` are those of its two bodies that may be woken: a floor that nothing
  /// moves has no list.
  void Put(Memory memory, std::span<const Body> wakeable) {
    if (wakeable.empty()) return;
    auto slot = static_cast<uint32_t>(slots_.size());
    if (free_.empty()) {
      slots_.emplace_back();
    } else {
      slot = free_.back();
      free_.pop_back();
    }
    Slot& kept = slots_[slot];
    kept.memory = std::move(memory);
    for (const Body& body : wakeable) {
      std::vector<uint32_t>& own = slots_of_[body];
      kept.wakeable[kept.count++] = {body, own.size()};
      own.push_back(slot);
    }
  }

  /// Appends those of `body` to `out`, and keeps them no longer.
  void TakeOf(const Body& body, std::vector<Memory>& out) {
    const auto own = slots_of_.find(body);
    if (own == slots_of_.end()) return;
    const std::vector<uint32_t> slots = std::move(own->second);
    slots_of_.erase(own);
    for (const uint32_t slot : slots) {
      out.push_back(std::move(slots_[slot].memory));
      Free(slot, body);
    }
  }

  template <typename Visit>
  void ForEach(Visit visit) const {
    for (const Slot& slot : slots_) {
      if (slot.count > 0) visit(slot.memory);
    }
  }

 private:
  struct Listed {
    Body body{};
    size_t place = 0;  // in the list of the body
  };
  struct Slot {
    Memory memory;
    std::array<Listed, 2> wakeable{};
    size_t count = 0;  // of those; none: it is free
  };

  // It is not in the list of `gone` any more.
  void Free(uint32_t slot, const Body& gone) {
    for (const Listed& listed : std::span(slots_[slot].wakeable).first(slots_[slot].count)) {
      if (listed.body != gone) Unlist(listed);
    }
    slots_[slot] = {};
    free_.push_back(slot);
  }

  // The last one of the list goes to the place that becomes free: what lies on a floor that may be woken is in one list
  // with all others on it, which may not be looked through for each of them.
  void Unlist(const Listed& listed) {
    const auto own = slots_of_.find(listed.body);
    std::vector<uint32_t>& slots = own->second;
    for (Listed& each : slots_[slots.back()].wakeable) {
      if (each.body == listed.body) each.place = listed.place;
    }
    slots[listed.place] = slots.back();
    slots.pop_back();
    if (slots.empty()) slots_of_.erase(own);
  }

  std::vector<Slot> slots_;
  std::vector<uint32_t> free_;
  std::unordered_map<Body, std::vector<uint32_t>> slots_of_;
};

}  // namespace genphys

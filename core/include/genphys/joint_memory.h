#pragma once
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "genphys/ids.h"
#include "genphys/joint_row.h"

namespace genphys {

/// What rows of joints came to in the last solve, from which the next one starts where rows are solved all at once:
/// what it finds is the same without that, but later.
class JointMemory {
 public:
  /// Has each row start from the last impulse of one between the same two with bounds alike, in the same order; others
  /// from none. `id_of` tells whose a row of the columns is.
  template <typename IdOf>
  void Recall(std::span<JointRow> rows, IdOf id_of) {
    for (Entry& entry : entries_) entry.is_taken = false;
    for (JointRow& row : rows) {
      const Entry* const found = entries_.empty() ? nullptr : Take(KeyOf(row, id_of));
      row.impulse = found != nullptr ? found->impulse : 0;
    }
  }

  /// Notes what all rows of a solve came to.
  template <typename IdOf>
  void Note(std::span<const JointRow> rows, IdOf id_of) {
    entries_.clear();
    for (const JointRow& row : rows) entries_.push_back({KeyOf(row, id_of), row.impulse});
    Sort();
  }

  /// Forgets a body that was removed.
  void Remove(EntityId id);

  /// Appends all of it.
  void Save(std::string& bytes) const;

 private:
  struct Key {
    EntityId a, b;
    double lower, upper;  // of a drive but their signs, for it may be told another force
    bool operator==(const Key&) const = default;
  };
  struct Entry {
    Key key;
    double impulse;         // N*s or N*m*s
    bool is_taken = false;  // in this recall
  };

  template <typename IdOf>
  static Key KeyOf(const JointRow& row, IdOf id_of) {
    const auto side_of = [](double bound) {
      return bound == 0 || std::isinf(bound) ? bound : std::copysign(1.0, bound);
    };
    return {id_of(row.a), id_of(row.b), side_of(row.lower), side_of(row.upper)};
  }
  static std::pair<uint64_t, uint64_t> PairOf(const Key& key) { return {key.a.packed(), key.b.packed()}; }
  void Sort();
  // The first one with this key that is not taken. Null: there is none.
  const Entry* Take(const Key& key);

  std::vector<Entry> entries_;  // ascending by the two bodies; of the same two as they were solved
};

}  // namespace genphys

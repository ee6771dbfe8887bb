#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "genphys/contact.h"
#include "genphys/work_watch.h"

namespace genphys {

/// One number for a pair of geometries.
inline uint64_t KeyOf(GeometryRow a, GeometryRow b) { return uint64_t{Index(a)} << 32 | Index(b); }

/// Finds pairs in a list to which more are added: of many that land at once each is looked for.
class PairPlaces {
 public:
  /// The first of `list` whose `pair` is of these two; null if there is none. Since the last Forget() nobody but this
  /// may have gone from the list, or changed places in it.
  template <typename Entry>
  Entry* Find(std::vector<Entry>& list, GeometryRow a, GeometryRow b) {
    if (list.size() <= kFew) {
      const auto is_one = [&](const Entry& entry) { return entry.pair.geometry_a == a && entry.pair.geometry_b == b; };
      const auto entry = std::ranges::find_if(list, is_one);
      return entry == list.end() ? nullptr : &*entry;
    }
    for (; known_ < list.size(); ++known_) {
      WorkWatch::Spend(kEntryWork);
      place_of_.try_emplace(KeyOf(list[known_].pair.geometry_a, list[known_].pair.geometry_b), known_);
    }
    const auto place = place_of_.find(KeyOf(a, b));
    return place == place_of_.end() ? nullptr : &list[place->second];
  }

  void Forget() {
    place_of_.clear();
    known_ = 0;
  }

 private:
  // So many are looked through before an index of them is made.
  static constexpr size_t kFew = 8;
  // Of a WorkWatch.
  static constexpr int64_t kEntryWork = 32;

  std::unordered_map<uint64_t, size_t> place_of_;  // of the first known_ of the list
  size_t known_ = 0;
};

}  // namespace genphys

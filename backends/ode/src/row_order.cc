#include "row_order.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace genphys::ode_backend {
namespace {

// ODE shuffles after so many sweeps, unless they were the last ones.
constexpr uint32_t kPeriod = 8;
// Rows of a kind that are taken one after the other where they are mixed: a step of 1,000 boxes in a pile takes 0.94 of
// what it does with each row by itself, and they overlap as much.
constexpr size_t kChunk = 128;
// Sweeps after the last shuffle in which friction may have the last word: with four of them boxes in a pile overlap by
// half as much again.
constexpr uint32_t kLastSweeps = 1;

}  // namespace

void RowOrder::Begin(size_t free, size_t bounded, uint32_t sweeps, uint32_t (*draw)()) {
  sweeps_left_ = sweeps;
  draw_ = draw;
  free_rows_.resize(free);
  std::iota(free_rows_.begin(), free_rows_.end(), 0);
  bounded_rows_.resize(bounded);
  std::iota(bounded_rows_.begin(), bounded_rows_.end(), static_cast<uint32_t>(free));
  present_.resize(free + bounded);
  std::iota(present_.begin(), present_.end(), 0);
  swaps_.resize(present_.size());
}

int RowOrder::PlaceOfLast(int count) {
  const auto last = static_cast<size_t>(count) - 1;
  if (last == 1) {
    sweeps_left_ -= std::min(sweeps_left_, kPeriod);
    Shuffle();
    Arrange();
    FindSwaps();
  }
  return static_cast<int>(last < swaps_.size() ? swaps_[last] : last);
}

void RowOrder::Shuffle() {
  for (std::vector<uint32_t>* rows : {&free_rows_, &bounded_rows_}) {
    for (size_t i = 1; i < rows->size(); ++i) std::swap((*rows)[i], (*rows)[uint64_t{draw_()} * (i + 1) >> 32]);
  }
}

// Chunks of the bounded rows are as many as those of the free ones.
void RowOrder::Arrange() {
  wanted_.clear();
  const size_t chunks = sweeps_left_ <= kLastSweeps ? 1 : 1 + free_rows_.size() / kChunk;
  for (size_t i = 0; i < chunks; ++i) {
    for (const std::vector<uint32_t>* rows : {&free_rows_, &bounded_rows_}) {
      const auto at = [&](size_t chunk) {
        return rows->begin() + static_cast<std::ptrdiff_t>(rows->size() * chunk / chunks);
      };
      wanted_.insert(wanted_.end(), at(i), at(i + 1));
    }
  }
}

// Swaps of places 1, 2, ... with one before them, or themselves, by which the rows come to be as wanted: the last row
// is moved by the last swap alone, so that this one is known, and then all others before it.
void RowOrder::FindSwaps() {
  const size_t count = present_.size();
  // Rows by the place that they have before.
  place_.resize(count);
  for (uint32_t i = 0; i < count; ++i) place_[present_[i]] = i;
  for (uint32_t i = 0; i < count; ++i) present_[i] = place_[wanted_[i]];
  for (uint32_t i = 0; i < count; ++i) place_[present_[i]] = i;
  for (uint32_t i = static_cast<uint32_t>(count); i-- > 1;) {
    const uint32_t swapped = place_[i];
    swaps_[i] = swapped;
    std::swap(present_[i], present_[swapped]);
    place_[present_[swapped]] = swapped;
    place_[present_[i]] = i;
  }
  present_.swap(wanted_);
}

}  // namespace genphys::ode_backend

#include "genphys/pair_set.h"

#include <algorithm>

namespace genphys {

void PairSet::Insert(const TouchingPair& pair) {
  const uint32_t a = pair.pair.a.index(), b = pair.pair.b.index();
  if (lists_.size() <= std::max(a, b)) lists_.resize(std::max(a, b) + 1);
  if (Find(pair) != kNone) return;
  auto at = static_cast<Place>(entries_.size());
  if (free_.empty()) {
    entries_.emplace_back();
  } else {
    at = free_.back();
    free_.pop_back();
  }
  entries_[at] = {.pair = pair};
  Chain(a, at);
  Chain(b, at);
}

void PairSet::Erase(const TouchingPair& pair) {
  const Place at = Find(pair);
  if (at == kNone) return;
  Unchain(pair.pair.a.index(), at);
  Unchain(pair.pair.b.index(), at);
  free_.push_back(at);
}

std::vector<TouchingPair> PairSet::Sorted() const {
  std::vector<TouchingPair> pairs;
  pairs.reserve(size());
  for (uint32_t slot = 0; slot < lists_.size(); ++slot) {
    for (Place at = lists_[slot].first; at != kNone; at = LinkIn(slot, at).after) {
      const TouchingPair& pair = entries_[at].pair;
      if (pair.pair.a.index() == slot) pairs.push_back(pair);  // it is in the list of b, too
    }
  }
  std::ranges::sort(pairs);
  return pairs;
}

// In the shorter one of the two lists: the ground has all that lies on it.
PairSet::Place PairSet::Find(const TouchingPair& pair) const {
  const uint32_t a = pair.pair.a.index(), b = pair.pair.b.index();
  if (lists_.size() <= std::max(a, b)) return kNone;
  const uint32_t slot = lists_[a].size < lists_[b].size ? a : b;
  Place at = lists_[slot].first;
  while (at != kNone && entries_[at].pair != pair) at = LinkIn(slot, at).after;
  return at;
}

void PairSet::Chain(uint32_t slot, Place at) {
  List& list = lists_[slot];
  LinkIn(slot, at) = {.before = kNone, .after = list.first};
  if (list.first != kNone) LinkIn(slot, list.first).before = at;
  list.first = at;
  ++list.size;
}

void PairSet::Unchain(uint32_t slot, Place at) {
  List& list = lists_[slot];
  const Link link = LinkIn(slot, at);
  (link.before == kNone ? list.first : LinkIn(slot, link.before).after) = link.after;
  if (link.after != kNone) LinkIn(slot, link.after).before = link.before;
  --list.size;
}

}  // namespace genphys

#pragma once
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace genphys {

/// Sets of numbers that are joined until none has a member in common: union-find by path halving. The root of a set is
/// its smallest member.
class DisjointSets {
 public:
  explicit DisjointSets(size_t size) : parents_(size) { std::iota(parents_.begin(), parents_.end(), 0); }

  /// A set of its own more. Returns its only member.
  uint32_t Add() {
    parents_.push_back(static_cast<uint32_t>(parents_.size()));
    return parents_.back();
  }
  /// How many members there are.
  size_t size() const { return parents_.size(); }
  uint32_t Find(uint32_t member) {
    while (parents_[member] != member) member = parents_[member] = parents_[parents_[member]];
    return member;
  }
  void Join(uint32_t a, uint32_t b) {
    a = Find(a);
    b = Find(b);
    parents_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<uint32_t> parents_;
};

}  // namespace genphys

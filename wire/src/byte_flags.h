#pragma once
#include <cstdint>
#include <cstring>

namespace genphys {

/// The lowest bits of eight bytes, each of them 0 or 1 in a column of flags, as one byte: that of the first is the
/// lowest.
inline uint8_t LowestBits(uint64_t bytes) {
  constexpr uint64_t kOnes = 0x0101010101010101;
  // Brings the eight bits together in the highest byte of the product.
  constexpr uint64_t kGather = 0x0102040810204080;
  constexpr int kGatheredAt = 56;
  return static_cast<uint8_t>((bytes & kOnes) * kGather >> kGatheredAt);
}

inline uint8_t LowestBits(const uint8_t* bytes) {
  uint64_t word;
  std::memcpy(&word, bytes, sizeof word);
  return LowestBits(word);
}

}  // namespace genphys

#pragma once
#include <compare>
#include <cstdint>

namespace genphys {

/// Opaque handle: a slot index and the generation of the tenant of that slot.
/// Zero is null, so a forgotten id is never a valid one. Ids order canonically by their packed value.
template <typename Tag>
class Id {
 public:
  constexpr Id() = default;
  constexpr Id(uint32_t index, uint32_t generation) : packed_((uint64_t{generation} << 32) | (uint64_t{index} + 1)) {}

  static constexpr Id FromPacked(uint64_t packed) {
    Id id;
    id.packed_ = packed;
    return id;
  }
  constexpr uint64_t packed() const { return packed_; }
  /// Slot, or 2^32 - 1 for an id that names no slot (null, or forged with an empty lower half).
  constexpr uint32_t index() const { return static_cast<uint32_t>(packed_) - 1; }
  constexpr uint32_t generation() const { return static_cast<uint32_t>(packed_ >> 32); }
  constexpr bool is_null() const { return packed_ == 0; }
  constexpr auto operator<=>(const Id&) const = default;

 private:
  uint64_t packed_ = 0;
};

using EntityId = Id<struct EntityTag>;
using JointId = Id<struct JointTag>;

/// What a command created: an entity or a joint, as the command says, or null.
class CreatedId {
 public:
  constexpr CreatedId() = default;
  template <typename Tag>
  constexpr CreatedId(Id<Tag> id) : packed_(id.packed()) {}
  template <typename Tag>
  constexpr operator Id<Tag>() const {
    return Id<Tag>::FromPacked(packed_);
  }
  constexpr uint64_t packed() const { return packed_; }
  constexpr bool is_null() const { return packed_ == 0; }
  constexpr bool operator==(const CreatedId&) const = default;

 private:
  uint64_t packed_ = 0;
};

/// Row of an entity in StateArrays: the slot of its id. Stable until removal.
enum class EntityRow : uint32_t {};

constexpr uint32_t Index(EntityRow row) { return static_cast<uint32_t>(row); }

}  // namespace genphys

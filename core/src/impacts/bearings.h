#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "genphys/contact.h"
#include "impacts/impact_past.h"
#include "impacts/impact_world.h"

namespace genphys {

/// Who bears whom where something is hit: as the last solve pressed them together, and for those that were woken since,
/// of whom it knows nothing, as they touch. Arguments outlive this object.
class Bearings {
 public:
  struct Bearing {
    EntityRow borne{};
    EntityRow bearer{};  // or what nothing can move
    ContactPair pair;
  };

  Bearings(const ImpactWorld& world, const ImpactPast& past) : world_(world), past_(past) {}

  /// Tells ImpactWorld::stances who is pressed against something. With `is_anybody_woken` among those that are hit,
  /// whoever was woken counts too, and Find() has to look again.
  void FindStances(const ContactBuffer& contacts, bool is_anybody_woken);
  bool IsWoken(EntityRow row) const { return past_.IsMovable(row) && past_.IsWoken(row); }

  /// Finds who bears whom, unless that is known.
  void Find(const ContactBuffer& contacts);
  /// The numbers of those Bearing in which `row` is borne.
  std::span<const uint32_t> Of(EntityRow row) const;
  const Bearing& operator[](size_t number) const { return bearings_[number]; }

  /// Whether the other one, or what nothing can move, bears a, and whether it bears b: by what pressed them together
  /// in the solve of `contacts`, or without one by where they touch.
  std::pair<bool, bool> BorneIn(const ContactBuffer& contacts, const ContactPair& pair, bool has_pressed) const;
  /// Whether the other one comes down on `row`, as on what bears it.
  bool IsHitFromAbove(const ContactBuffer& contacts, const ContactPair& hit, EntityRow row) const;

 private:
  void NoteStance(const ContactPair& pair);
  void Note(const ContactBuffer& contacts, const ContactPair& pair, bool has_pressed);
  template <typename Visit>
  void VisitWoken(const ContactBuffer& contacts, Visit visit) const;

  const ImpactWorld& world_;
  const ImpactPast& past_;
  std::vector<Bearing> bearings_;
  std::vector<uint32_t> order_;  // of bearings_, by row of who is borne
  bool is_found_ = false;
  bool knows_stances_ = false;
};

}  // namespace genphys

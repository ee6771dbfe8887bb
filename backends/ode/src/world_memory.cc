// What held contacts at the last solve, and who is recognised by that.
#include <absl/container/inlined_vector.h>

#include <algorithm>
#include <utility>

#include "world.h"

namespace genphys::ode_backend {
namespace {

// Contacts of an island that is solved from what held it before. Of more, some slip or part at every step.
constexpr size_t kWarmContactsMax = 200;

}  // namespace

bool World::MayBeWarm(uint32_t number) const {
  const Islands::Island& island = islands_.islands()[number];
  return island.joint_rows == 0 && island.contacts <= kWarmContactsMax;
}

// Recalls the last solve, and what it tells of every island.
void World::Recognise(const ContactBuffer& contacts) {
  recalled_.assign(contacts.points.size(), {});
  known_.assign(islands_.islands().size(), {});
  for (const ContactPair& pair : contacts.pairs) {
    const uint32_t island = islands_.IslandOf(pair.entity_a, pair.entity_b);
    if (pair.is_sensor || island == Islands::kNone) continue;
    const bool is_known = RecognisePair(pair, contacts);
    const auto is_nothing = [](const WarmStart::Recalled& point) { return point.given.isZero(0); };
    const auto recalled = std::span(recalled_).subspan(pair.first_point, pair.point_count);
    Known& known = known_[island];
    known.is_whole = known.is_whole && is_known;
    known.is_all_given = known.is_all_given && std::ranges::none_of(recalled, is_nothing);
  }
}

bool World::RecognisePair(const ContactPair& pair, const ContactBuffer& contacts) {
  const Body& a = bodies_[Index(pair.entity_a)];
  const Body& b = bodies_[Index(pair.entity_b)];
  const bool resists_turning = pair.material.rolling_friction > 0 || pair.material.spinning_friction > 0;
  // In the frame of what rests on the other its points stand still.
  const Pose& frame = b.motion_type == MotionType::kDynamic ? b.pose : a.pose;
  const bool is_known = warm_start_.Add({pair.geometry_a, pair.geometry_b, a.serial, b.serial}, frame, pair,
                                        std::span(contacts.points).subspan(pair.first_point, pair.point_count),
                                        std::span(recalled_).subspan(pair.first_point, pair.point_count));
  return is_known && !resists_turning;
}

void World::Recall(const ContactBuffer& solved) {
  warm_start_.Begin();
  recalled_.assign(solved.points.size(), {});
  for (const ContactPair& pair : solved.pairs) {
    if (!pair.is_sensor) RecognisePair(pair, solved);
  }
  warm_start_.End(solved.points);
}

// No body, if another one has its row by now.
const World::Body* World::BodyOf(GeometryRow geometry, uint64_t serial) const {
  const EntityRow row = shapes_[Index(geometry)].entity();
  const bool is_there = Index(row) < bodies_.size() && bodies_[Index(row)].serial == serial;
  return is_there ? &bodies_[Index(row)] : nullptr;
}

// Keeps what held those who fell asleep since the last solve, and brings back what held those who were woken: a solve
// from nothing takes many sweeps, and moves a tower that rested.
void World::BringBack() {
  if (std::exchange(has_slept_, false)) {
    warm_start_.VisitPairs([&](const WarmStart::Key& key, auto keep) {
      absl::InlinedVector<uint64_t, 2> wakeable;
      for (const Body* body : {BodyOf(key.a, key.serial_a), BodyOf(key.b, key.serial_b)}) {
        if (body == nullptr || (body->is_active && body->motion_type != MotionType::kStatic)) return;
        if (body->motion_type != MotionType::kStatic) wakeable.push_back(body->serial);
      }
      resting_.Put(keep(), wakeable);
    });
  }
  std::vector<WarmStart::Kept> back;
  for (const uint64_t serial : std::exchange(woken_, {})) resting_.TakeOf(serial, back);
  for (const WarmStart::Kept& kept : back) warm_start_.Return(kept);
}

void World::SaveState(std::string& bytes) const {
  warm_start_.Save(bytes);
  std::vector<const WarmStart::Kept*> all;
  resting_.ForEach([&](const WarmStart::Kept& kept) { all.push_back(&kept); });
  std::ranges::sort(all, {}, [](const WarmStart::Kept* kept) { return kept->pair.key; });
  for (const WarmStart::Kept* kept : all) WarmStart::Save(*kept, bytes);
  bytes.push_back(has_failed_directly_ ? 1 : 0);
}

}  // namespace genphys::ode_backend

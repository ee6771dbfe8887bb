#include "genphys/contact_memory.h"

#include <algorithm>

namespace genphys {
namespace {

// m: a point that is farther from where one was is another point.
constexpr double kSamePoint = 0.02;

template <typename T>
void AppendBytes(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void AppendBytes(const Vector3& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(value.data()), 3 * sizeof(double));
}

// Each old point is given to at most one new one.
PointImpulse TakeImpulseAt(const Vector3& place, ContactMemory::Pair& pair) {
  size_t nearest = 0;
  double least = kSamePoint * kSamePoint;
  bool is_found = false;
  for (size_t i = 0; i < pair.places.size(); ++i) {
    const double distance = (pair.places[i] - place).squaredNorm();
    if (pair.impulses[i].normal > 0 && distance < least) {
      least = distance;
      nearest = i;
      is_found = true;
    }
  }
  return is_found ? std::exchange(pair.impulses[nearest], {}) : PointImpulse{};
}

}  // namespace

// Looking for what is remembered of one takes as long as for many.
void ContactMemory::ForgetRemoved() {
  if (removed_.empty()) return;
  std::ranges::sort(removed_);
  const auto is_removed = [&](EntityId id) { return std::ranges::binary_search(removed_, id); };
  std::erase_if(pairs_, [&](const Pair& pair) { return is_removed(pair.key.a) || is_removed(pair.key.b); });
  removed_.clear();
}

bool ContactMemory::KeepResting(Pair& pair, Motion a, Motion b) {
  absl::InlinedVector<uint64_t, 2> wakeable;
  for (const auto& [id, motion] : {std::pair(pair.key.a, a), std::pair(pair.key.b, b)}) {
    if (motion == Motion::kMoving || motion == Motion::kGone) return false;
    if (motion == Motion::kResting) wakeable.push_back(id.packed());
  }
  if (wakeable.empty()) return false;
  resting_.Put(std::move(pair), wakeable);
  return true;
}

void ContactMemory::BeginList() {
  pairs_.swap(before_);
  pairs_.clear();
  next_before_ = 0;
  if (woken_.empty()) return;
  for (const EntityId id : std::exchange(woken_, {})) resting_.TakeOf(id.packed(), before_);
  std::ranges::sort(before_, {}, &Pair::key);
}

ContactMemory::Pair& ContactMemory::Append(const Key& key, const Placement& frame, double interval,
                                           std::span<const ContactPoint> points) {
  Pair& pair = pairs_.emplace_back();
  pair.key = key;
  pair.interval = interval;
  pair.places.resize(points.size());
  pair.impulses.resize(points.size());
  for (size_t i = 0; i < points.size(); ++i) pair.places[i] = frame.ToLocal(points[i].position);
  return pair;
}

void ContactMemory::Add(const Key& key, const Placement& frame, double interval, std::span<const ContactPoint> points) {
  Pair& pair = Append(key, frame, interval, points);
  while (next_before_ < before_.size() && before_[next_before_].key < key) ++next_before_;
  if (next_before_ == before_.size() || before_[next_before_].key != key) return;
  Pair& old = before_[next_before_++];
  const double scale = ImpulseScale(old.interval, interval);
  // The points of a wheel are new ones all the time.
  for (const PointImpulse& impulse : old.impulses) pair.load += scale * impulse.normal;
  for (size_t i = 0; i < points.size(); ++i) {
    if (points[i].is_ahead) continue;
    const PointImpulse last = TakeImpulseAt(pair.places[i], old);
    pair.impulses[i] = {scale * last.normal, scale * last.friction, scale * last.torque};
  }
}

void ContactMemory::AddSolved(const Key& key, const Placement& frame, double interval,
                              std::span<const ContactPoint> points, std::span<const ContactPoint> solved) {
  if (points.empty()) return;
  Pair& pair = Append(key, frame, interval, points);
  for (const ContactPoint& point : solved) {
    const auto distance = [&](const ContactPoint& own) { return (own.position - point.position).squaredNorm(); };
    const auto nearest = std::ranges::min_element(points, {}, distance);
    PointImpulse& impulse = pair.impulses[static_cast<size_t>(nearest - points.begin())];
    impulse.normal += point.normal_impulse;
    impulse.friction += point.friction_impulse;
  }
}

ContactMemory ContactMemory::OfBefore() const {
  ContactMemory memory;
  for (const Pair& pair : pairs_) {
    Pair& before = memory.pairs_.emplace_back();
    before.key = pair.key;
    before.interval = pair.interval;
    before.impulses.push_back({.normal = pair.load});
  }
  return memory;
}

void ContactMemory::SetActive(EntityId id, bool active) {
  if (active) woken_.push_back(id);
  has_slept_ = has_slept_ || !active;
}

void ContactMemory::Remove(EntityId id) {
  std::vector<Pair> forgotten;
  resting_.TakeOf(id.packed(), forgotten);
  removed_.push_back(id);
  // Where nothing moves no list is ever begun.
  if (removed_.size() > pairs_.size()) ForgetRemoved();
}

void ContactMemory::Save(std::string& bytes) const {
  std::vector<const Pair*> all;
  std::vector<EntityId> removed = removed_;
  std::ranges::sort(removed);
  const auto is_removed = [&](EntityId id) { return std::ranges::binary_search(removed, id); };
  const auto add = [&](const Pair& pair) {
    if (!is_removed(pair.key.a) && !is_removed(pair.key.b)) all.push_back(&pair);
  };
  for (const Pair& pair : pairs_) add(pair);
  resting_.ForEach(add);
  std::ranges::sort(all, {}, [](const Pair* pair) { return pair->key; });
  AppendBytes(uint64_t{all.size()}, bytes);
  for (const Pair* pair : all) {
    AppendBytes(pair->key.a.packed(), bytes);
    AppendBytes(pair->key.b.packed(), bytes);
    AppendBytes(pair->key.geometry_a, bytes);
    AppendBytes(pair->key.geometry_b, bytes);
    AppendBytes(pair->interval, bytes);
    AppendBytes(static_cast<uint32_t>(pair->places.size()), bytes);
    for (size_t i = 0; i < pair->places.size(); ++i) {
      AppendBytes(pair->places[i], bytes);
      AppendBytes(pair->impulses[i].normal, bytes);
      AppendBytes(pair->impulses[i].friction, bytes);
      AppendBytes(pair->impulses[i].torque, bytes);
    }
  }
}

}  // namespace genphys

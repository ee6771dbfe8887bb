#include "warm_start.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace genphys::bullet_backend {
namespace {

// m: a point that is farther from where one was is another point.
constexpr double kSamePoint = 0.02;

// Canonical order, as ContactBuffer has it.
template <typename X, typename Y>
bool ComesBefore(const X& x, const Y& y) {
  return std::tie(x.a->body->id, x.b->body->id, x.a->id, x.b->id) <
         std::tie(y.a->body->id, y.b->body->id, y.a->id, y.b->id);
}

// Neither side moves, so that the pair is not looked at.
bool IsResting(const PairMemory& memory) { return !memory.a->body->is_moving() && !memory.b->body->is_moving(); }

bool IsOfRemoved(const PairMemory& memory) { return memory.a->body->is_removed || memory.b->body->is_removed; }

template <typename T>
void Append(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void Append(const Vector3& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(value.data()), 3 * sizeof(double));
}

// Each old point is given to at most one new one.
PointImpulse TakeImpulseAt(const Vector3& place, PairMemory& memory) {
  size_t nearest = 0;
  double least = kSamePoint * kSamePoint;
  bool is_found = false;
  for (size_t i = 0; i < memory.places.size(); ++i) {
    const double distance = (memory.places[i] - place).squaredNorm();
    if (memory.impulses[i].normal > 0 && distance < least) {
      least = distance;
      nearest = i;
      is_found = true;
    }
  }
  return is_found ? std::exchange(memory.impulses[nearest], {}) : PointImpulse{};
}

}  // namespace

void WarmStart::Begin() {
  pairs_.swap(before_);
  pairs_.clear();
  next_before_ = 0;
  if (woken_.empty()) return;
  for (const Body* body : std::exchange(woken_, {})) resting_.TakeOf(body, before_);
  std::sort(before_.begin(), before_.end(), [](const auto& x, const auto& y) { return ComesBefore(x, y); });
}

void WarmStart::Add(const MeetingPair& pair, double interval, std::span<const ContactPoint> points) {
  while (next_before_ < before_.size() && ComesBefore(before_[next_before_], pair)) {
    PassOver(before_[next_before_++]);
  }
  PairMemory* old = nullptr;
  if (next_before_ < before_.size()) {
    PairMemory& next = before_[next_before_];
    if (next.a == pair.a && next.b == pair.b) old = &before_[next_before_++];
  }

  PairMemory& memory = pairs_.emplace_back();
  memory.a = pair.a;
  memory.b = pair.b;
  memory.interval = interval;
  memory.places.resize(points.size());
  memory.impulses.resize(points.size());
  // In the frame of what slides over the other its points stand still.
  const PlacedGeometry& frame = pair.b->body->motion_type == MotionType::kDynamic ? *pair.b : *pair.a;
  const double scale = old != nullptr ? ImpulseScale(old->interval, interval) : 0;
  for (size_t i = 0; i < points.size(); ++i) {
    memory.places[i] = frame.placement.ToLocal(points[i].position);
    if (old == nullptr || points[i].is_ahead) continue;
    const PointImpulse last = TakeImpulseAt(memory.places[i], *old);
    memory.impulses[i] = {scale * last.normal, scale * last.friction, scale * last.torque};
  }
}

void WarmStart::End() {
  while (next_before_ < before_.size()) PassOver(before_[next_before_++]);
}

void WarmStart::PassOver(const PairMemory& memory) {
  if (!IsResting(memory)) return;
  absl::InlinedVector<const Body*, 2> wakeable;
  for (const PlacedGeometry* side : {memory.a, memory.b}) {
    if (side->body->motion_type != MotionType::kStatic) wakeable.push_back(side->body);
  }
  resting_.Put(memory, wakeable);
}

void WarmStart::ForgetRemoved() {
  std::erase_if(pairs_, IsOfRemoved);
  resting_.EraseIf(IsOfRemoved);
}

void WarmStart::Save(std::string& bytes) const {
  std::vector<const PairMemory*> all;
  const auto add = [&](const PairMemory& memory) {
    if (!IsOfRemoved(memory)) all.push_back(&memory);
  };
  for (const PairMemory& memory : pairs_) add(memory);
  resting_.ForEach(add);
  std::sort(all.begin(), all.end(), [](const auto* x, const auto* y) { return ComesBefore(*x, *y); });
  Append(static_cast<uint64_t>(all.size()), bytes);
  for (const PairMemory* memory : all) {
    Append(memory->a->body->id.packed(), bytes);
    Append(memory->b->body->id.packed(), bytes);
    Append(memory->a->id, bytes);
    Append(memory->b->id, bytes);
    Append(memory->interval, bytes);
    Append(static_cast<uint32_t>(memory->places.size()), bytes);
    for (size_t i = 0; i < memory->places.size(); ++i) {
      Append(memory->places[i], bytes);
      Append(memory->impulses[i].normal, bytes);
      Append(memory->impulses[i].friction, bytes);
      Append(memory->impulses[i].torque, bytes);
    }
  }
}

}  // namespace genphys::bullet_backend

#include "warm_start.h"

#include <algorithm>
#include <utility>

namespace genphys::bullet_backend {
namespace {

// m: a point that is farther from where one was is another point.
constexpr double kSamePoint = 0.02;

CandidatePair KeyOf(const PairMemory& memory) { return {memory.a, memory.b}; }

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
  for (size_t i = 0; i < memory.count; ++i) {
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
}

void WarmStart::Add(const CandidatePair& pair, std::span<const ContactPoint> points) {
  while (next_before_ < before_.size() && ComesBefore(KeyOf(before_[next_before_]), pair)) ++next_before_;
  PairMemory* old = next_before_ < before_.size() ? &before_[next_before_] : nullptr;
  if (old != nullptr && (old->a != pair.a || old->b != pair.b)) old = nullptr;

  PairMemory& memory = pairs_.emplace_back();
  memory.a = pair.a;
  memory.b = pair.b;
  memory.count = points.size();
  // In the frame of what slides over the other its points stand still.
  const PlacedGeometry& frame = pair.b->body->motion_type == MotionType::kDynamic ? *pair.b : *pair.a;
  for (size_t i = 0; i < points.size(); ++i) {
    memory.places[i] = frame.placement.ToLocal(points[i].position);
    memory.impulses[i] = old != nullptr ? TakeImpulseAt(memory.places[i], *old) : PointImpulse{};
  }
}

void WarmStart::Forget(const Body& body) {
  std::erase_if(pairs_, [&](const PairMemory& memory) { return memory.a->body == &body || memory.b->body == &body; });
}

double WarmStart::ScaleTo(double step_size) {
  const double before = std::exchange(step_size_, step_size);
  return before > 0 ? step_size / before : 1;
}

void WarmStart::Save(std::string& bytes) const {
  Append(step_size_, bytes);
  Append(static_cast<uint64_t>(pairs_.size()), bytes);
  for (const PairMemory& memory : pairs_) {
    Append(memory.a->body->id.packed(), bytes);
    Append(memory.b->body->id.packed(), bytes);
    Append(memory.a->id, bytes);
    Append(memory.b->id, bytes);
    Append(static_cast<uint32_t>(memory.count), bytes);
    for (size_t i = 0; i < memory.count; ++i) {
      Append(memory.places[i], bytes);
      Append(memory.impulses[i].normal, bytes);
      Append(memory.impulses[i].friction, bytes);
    }
  }
}

}  // namespace genphys::bullet_backend

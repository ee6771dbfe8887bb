#include "warm_start.h"

#include <algorithm>

namespace genphys::ode_backend {
namespace {

// m: a point that is farther from where one was is another point.
constexpr double kSamePoint = 0.02;
// The part of what friction may hold: with more of it, a pair slips or soon will.
constexpr double kStuckMax = 0.95;
// The same from which on it matters in which direction friction is bounded. With less, that direction is noise.
constexpr double kStrained = 0.5;
// The same of half of the points, for these to hold alone what all of them do.
constexpr double kSharedMax = 0.8;

void Append(const Vector3& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(value.data()), 3 * sizeof(double));
}

template <typename T>
void Append(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

}  // namespace

void WarmStart::Memory::Clear() {
  pairs.clear();
  places.clear();
  impulses.clear();
  pressures.clear();
}

void WarmStart::Begin(double step_size) {
  std::swap(now_, before_);
  now_.Clear();
  scale_ = step_size_ > 0 ? step_size / step_size_ : 1;
  step_size_ = step_size;
  index_.clear();
  for (uint32_t i = 0; i < before_.pairs.size(); ++i) index_.emplace_back(before_.pairs[i].key, i);
  // Of a scene to which nothing was added late they come in the order of their ids, which is that of their rows.
  if (!std::is_sorted(index_.begin(), index_.end())) std::sort(index_.begin(), index_.end());
  next_ = 0;
}

const WarmStart::Pair* WarmStart::Find(const Key& key) {
  auto place = index_.begin() + static_cast<std::ptrdiff_t>(next_);
  if (place == index_.end() || place->first != key) {
    place = std::lower_bound(index_.begin(), index_.end(), std::pair(key, uint32_t{0}));
    if (place == index_.end() || place->first != key) return nullptr;
  }
  next_ = static_cast<size_t>(place - index_.begin()) + 1;
  return &before_.pairs[place->second];
}

WarmStart::Recalled WarmStart::RecallAt(const Pair& old, const Vector3& place, const Vector3& normal) const {
  uint32_t nearest = old.first;
  double least = kSamePoint * kSamePoint;
  bool is_found = false;
  for (uint32_t i = old.first; i < old.first + old.count; ++i) {
    const double distance = (before_.places[i] - place).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    nearest = i;
    is_found = true;
  }
  if (!is_found) return {};
  const Vector3& impulse = before_.impulses[nearest];
  Recalled recalled{.braked = scale_ * old.braked, .grip = scale_ * old.grip, .may_share = old.may_share};
  if (old.strain > kStuckMax) return recalled;
  recalled.given = scale_ * (before_.pressures[nearest] * normal + impulse - impulse.dot(normal) * normal);
  return recalled;
}

void WarmStart::TakeBack() {
  std::swap(now_, before_);
  step_size_ /= scale_;
}

bool WarmStart::Add(const Key& key, const Pose& frame, std::span<const ContactPoint> points, uint32_t first,
                    std::span<Recalled> recalled) {
  now_.pairs.push_back({.key = key,
                        .first = static_cast<uint32_t>(now_.places.size()),
                        .count = static_cast<uint32_t>(points.size()),
                        .first_point = first});
  const Quaternion back = frame.orientation.conjugate();
  for (const ContactPoint& point : points) now_.places.push_back(back * (point.position - frame.position));
  const Pair* const old = Find(key);
  if (old == nullptr) return false;
  for (size_t i = 0; i < points.size(); ++i) {
    recalled[i] = RecallAt(*old, now_.places[now_.pairs.back().first + i], points[i].normal);
  }
  return true;
}

void WarmStart::End(std::span<const ContactPoint> points) {
  for (Pair& pair : now_.pairs) {
    const std::span<const ContactPoint> own = points.subspan(pair.first_point, pair.count);
    // How the points of a pair share what holds it is left to chance, so that they count together.
    const double count = std::max(pair.count, 1u);
    double held = 0, grips[2] = {};
    for (size_t i = 0; i < own.size(); ++i) {
      pair.braked += own[i].friction_impulse / count;
      held += own[i].friction_impulse.norm();
      grips[i % 2] += own[i].friction * own[i].normal_impulse;
    }
    const double grip = grips[0] + grips[1];
    pair.grip = grip / count;
    pair.strain = grip > 0 ? held / grip : 1;
    const double load = pair.braked.norm();
    pair.may_share = count * load < kSharedMax * 2 * std::min(grips[0], grips[1]);
    if (load <= kStrained * pair.grip) pair.braked.setZero();
    for (const ContactPoint& point : own) {
      now_.impulses.push_back(point.normal_impulse > 0 ? point.friction_impulse : Vector3(Vector3::Zero()));
      now_.pressures.push_back(std::max(point.normal_impulse, 0.0));
    }
  }
}

void WarmStart::Save(std::string& bytes) const {
  Append(step_size_, bytes);
  Append(uint64_t{now_.pairs.size()}, bytes);
  for (const Pair& pair : now_.pairs) {
    Append(pair.key.a, bytes);
    Append(pair.key.b, bytes);
    Append(pair.count, bytes);
    Append(pair.strain, bytes);
    Append(pair.braked, bytes);
    Append(pair.grip, bytes);
    Append(pair.may_share, bytes);
  }
  for (size_t i = 0; i < now_.places.size(); ++i) {
    Append(now_.places[i], bytes);
    Append(now_.impulses[i], bytes);
    Append(now_.pressures[i], bytes);
  }
}

}  // namespace genphys::ode_backend

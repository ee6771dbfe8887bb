#include "warm_start.h"

#include <algorithm>

namespace genphys::ode_backend {
namespace {

// m: a point that is farther from where one was is another point.
constexpr double kSamePoint = 0.02;
// The part of what friction may hold: with more of it, a pair slips or soon will.
constexpr double kStuckMax = 0.95;

void Append(const Vector3& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(value.data()), 3 * sizeof(double));
}

template <typename T>
void Append(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

// How the points of a pair share what holds it is left to chance, so that they count together.
bool IsStuck(std::span<const ContactPoint> points) {
  double held = 0, grip = 0;
  for (const ContactPoint& point : points) {
    held += point.friction_impulse.norm();
    grip += point.friction * point.normal_impulse;
  }
  return grip > 0 && held <= kStuckMax * grip;
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
  std::sort(index_.begin(), index_.end());
}

const WarmStart::Pair* WarmStart::Find(const Key& key) const {
  const auto place = std::lower_bound(index_.begin(), index_.end(), std::pair(key, uint32_t{0}));
  return place != index_.end() && place->first == key ? &before_.pairs[place->second] : nullptr;
}

Vector3 WarmStart::GivenAt(const Pair& old, const Vector3& place, const Vector3& normal) const {
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
  if (!is_found) return Vector3::Zero();
  const Vector3& across = before_.impulses[nearest];
  return scale_ * (before_.pressures[nearest] * normal + across - across.dot(normal) * normal);
}

bool WarmStart::Add(const Key& key, const Pose& frame, std::span<const ContactPoint> points, uint32_t first,
                    std::span<Vector3> given) {
  now_.pairs.push_back({.key = key,
                        .first = static_cast<uint32_t>(now_.places.size()),
                        .count = static_cast<uint32_t>(points.size()),
                        .first_point = first});
  const Quaternion back = frame.orientation.conjugate();
  for (const ContactPoint& point : points) now_.places.push_back(back * (point.position - frame.position));
  const Pair* const old = Find(key);
  if (old == nullptr) return false;
  for (size_t i = 0; i < points.size(); ++i) {
    given[i] = GivenAt(*old, now_.places[now_.pairs.back().first + i], points[i].normal);
  }
  return true;
}

void WarmStart::End(std::span<const ContactPoint> points) {
  for (Pair& pair : now_.pairs) {
    const std::span<const ContactPoint> own = points.subspan(pair.first_point, pair.count);
    const bool rests = IsStuck(own);
    for (const ContactPoint& point : own) {
      now_.impulses.push_back(rests && point.normal_impulse > 0 ? point.friction_impulse : Vector3(Vector3::Zero()));
      now_.pressures.push_back(rests ? std::max(point.normal_impulse, 0.0) : 0);
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
  }
  for (size_t i = 0; i < now_.places.size(); ++i) {
    Append(now_.places[i], bytes);
    Append(now_.impulses[i], bytes);
    Append(now_.pressures[i], bytes);
  }
}

}  // namespace genphys::ode_backend

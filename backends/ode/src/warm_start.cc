#include "warm_start.h"

#include <algorithm>
#include <numeric>

namespace genphys::ode_backend {
namespace {

// m: a point that is farther from where one was is another point.
constexpr double kSamePoint = 0.02;
// The part of what friction may hold: with more of it, a pair slips or soon will.
constexpr double kStuckMax = 0.95;
// The same from which on it matters in which direction friction is bounded. With less, that direction is noise.
constexpr double kStrained = 0.5;
// The same of those points that hold along one axis, for these to hold alone what all of them do.
constexpr double kSharedMax = 0.8;
// Cosine between the normals of pairs that lie on the same surface.
constexpr double kSameNormal = 0.999;

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

void WarmStart::Begin() {
  std::swap(now_, before_);
  now_.Clear();
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

// Which of before_ it was.
std::optional<uint32_t> WarmStart::FindPoint(const Pair& old, const Vector3& place) const {
  std::optional<uint32_t> nearest;
  double least = kSamePoint * kSamePoint;
  for (uint32_t i = old.first; i < old.first + old.count; ++i) {
    const double distance = (before_.places[i] - place).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    nearest = i;
  }
  return nearest;
}

WarmStart::Recalled WarmStart::RecallAt(const Pair& old, double scale, uint32_t point, const Vector3& normal) const {
  const Vector3& impulse = before_.impulses[point];
  Recalled recalled{.braked = scale * old.braked, .grip = scale * old.grip};
  if (old.strain > kStuckMax) return recalled;
  recalled.given = scale * (before_.pressures[point] * normal + impulse - impulse.dot(normal) * normal);
  return recalled;
}

// Points hold along two axes in turns where those of either axis could have held all that friction held. Where what
// bears most stands on one side, they take their turns by what they bear; where it is one point, that holds along both.
void WarmStart::ShareOut(const Pair& old, std::span<Recalled> recalled) {
  order_.resize(recalled.size());
  std::iota(order_.begin(), order_.end(), 0);
  if (ShareOut(old, order_, false, recalled)) return;
  std::stable_sort(order_.begin(), order_.end(), [&](uint32_t a, uint32_t b) { return Bore(a) > Bore(b); });
  if (!ShareOut(old, order_, false, recalled)) ShareOut(old, order_, true, recalled);
}

bool WarmStart::ShareOut(const Pair& old, std::span<const uint32_t> order, bool is_first_alone,
                         std::span<Recalled> recalled) {
  const double alone = is_first_alone ? Bore(order.front()) : 0;
  const auto others = order.subspan(is_first_alone ? 1 : 0);
  double held[2] = {};
  for (size_t i = 0; i < others.size(); ++i) held[i % 2] += Bore(others[i]);
  if (old.load >= kSharedMax * old.friction * (alone + 2 * std::min(held[0], held[1]))) return false;
  for (size_t i = 0; i < others.size(); ++i) recalled[others[i]].shared_axis = i % 2;
  return true;
}

WarmStart::Kept WarmStart::Keep(const Pair& pair) const {
  const auto own = [&](const auto& all) {
    const auto first = all.begin() + pair.first;
    return std::vector(first, first + pair.count);
  };
  return {pair, own(now_.places), own(now_.impulses), own(now_.pressures)};
}

void WarmStart::Return(const Kept& kept) {
  Pair& pair = now_.pairs.emplace_back(kept.pair);
  pair.first = static_cast<uint32_t>(now_.places.size());
  now_.places.insert(now_.places.end(), kept.places.begin(), kept.places.end());
  now_.impulses.insert(now_.impulses.end(), kept.impulses.begin(), kept.impulses.end());
  now_.pressures.insert(now_.pressures.end(), kept.pressures.begin(), kept.pressures.end());
}

bool WarmStart::Add(const Key& key, const Pose& frame, const ContactPair& pair, std::span<const ContactPoint> points,
                    std::span<Recalled> recalled) {
  now_.pairs.push_back({.key = key,
                        .first = static_cast<uint32_t>(now_.places.size()),
                        .count = static_cast<uint32_t>(points.size()),
                        .first_point = pair.first_point,
                        .interval = pair.interval});
  const Quaternion back = frame.orientation.conjugate();
  for (const ContactPoint& point : points) now_.places.push_back(back * (point.position - frame.position));
  const Pair* const old = Find(key);
  if (old == nullptr) return false;
  const double scale = ImpulseScale(old->interval, pair.interval);
  found_.clear();
  for (size_t i = 0; i < points.size(); ++i) {
    found_.push_back(FindPoint(*old, now_.places[now_.pairs.back().first + i]));
    if (found_[i]) {
      recalled[i] = RecallAt(*old, scale, *found_[i], points[i].normal);
    } else {
      // The points of a wheel are new ones all the time.
      recalled[i].grip = scale * old->grip;
    }
  }
  if (points.size() > 1) ShareOut(*old, recalled);
  return true;
}

void WarmStart::End(std::span<const ContactPoint> points) {
  for (Pair& pair : now_.pairs) {
    const std::span<const ContactPoint> own = points.subspan(pair.first_point, pair.count);
    // How the points of a pair share what holds it is left to chance, so that they count together.
    const double count = std::max(pair.count, 1u);
    double held = 0, grip = 0, pressure = 0;
    for (const ContactPoint& point : own) {
      pair.braked += point.friction_impulse / count;
      held += point.friction_impulse.norm();
      grip += point.friction * point.normal_impulse;
      pressure += point.normal_impulse;
    }
    pair.grip = grip / count;
    pair.strain = grip > 0 ? held / grip : 1;
    pair.load = count * pair.braked.norm();
    pair.friction = pressure > 0 ? grip / pressure : 0;
    for (const ContactPoint& point : own) {
      now_.impulses.push_back(point.normal_impulse > 0 ? point.friction_impulse : Vector3(Vector3::Zero()));
      now_.pressures.push_back(std::max(point.normal_impulse, 0.0));
    }
  }
  ShareBraked(points);
}

// Pairs of the same two bodies, as of the feet of a table and the floor, count together as well: those that held
// against each other across the load would each hold along another direction than that, and all of them more than
// friction can.
void WarmStart::ShareBraked(std::span<const ContactPoint> points) {
  const auto is_alike = [&](const Pair& a, const Pair& b) {
    return a.key.serial_a == b.key.serial_a && a.key.serial_b == b.key.serial_b && a.count > 0 && b.count > 0 &&
           points[a.first_point].normal.dot(points[b.first_point].normal) > kSameNormal;
  };
  // They follow each other in the contact buffer.
  for (size_t first = 0, last = 0; first < now_.pairs.size(); first = last) {
    Vector3 braked = Vector3::Zero();
    double grip = 0, count = 0;
    for (; last < now_.pairs.size() && (last == first || is_alike(now_.pairs[first], now_.pairs[last])); ++last) {
      const Pair& pair = now_.pairs[last];
      braked += pair.count * pair.braked;
      grip += pair.count * pair.grip;
      count += pair.count;
    }
    const bool is_strained = braked.norm() > kStrained * grip;
    for (Pair& pair : std::span(now_.pairs).subspan(first, last - first)) {
      pair.braked = is_strained ? Vector3(braked / count) : Vector3::Zero();
      if (count > 0) pair.grip = grip / count;
    }
  }
}

void WarmStart::Save(std::string& bytes) const {
  Append(uint64_t{now_.pairs.size()}, bytes);
  // Which pair it is, its place among those that were solved tells; rows tell also in which order they were added.
  for (const Pair& pair : now_.pairs) {
    const auto own = [&](const auto& all) { return std::span(all).subspan(pair.first, pair.count); };
    Save(pair, own(now_.places), own(now_.impulses), own(now_.pressures), bytes);
  }
}

void WarmStart::Save(const Kept& kept, std::string& bytes) {
  Save(kept.pair, kept.places, kept.impulses, kept.pressures, bytes);
}

void WarmStart::Save(const Pair& pair, std::span<const Vector3> places, std::span<const Vector3> impulses,
                     std::span<const double> pressures, std::string& bytes) {
  Append(pair.count, bytes);
  Append(pair.interval, bytes);
  Append(pair.strain, bytes);
  Append(pair.braked, bytes);
  Append(pair.grip, bytes);
  Append(pair.load, bytes);
  Append(pair.friction, bytes);
  for (size_t i = 0; i < places.size(); ++i) {
    Append(places[i], bytes);
    Append(impulses[i], bytes);
    Append(pressures[i], bytes);
  }
}

}  // namespace genphys::ode_backend

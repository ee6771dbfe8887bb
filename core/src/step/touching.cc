#include "step/touching.h"

#include <algorithm>

#include "pairs/contact_points.h"

namespace genphys {
namespace {

bool DeepEnough(const ContactBuffer& contacts, const ContactPair& pair) {
  return std::ranges::any_of(PointsOf(contacts, pair),
                             [](const ContactPoint& point) { return point.depth >= kTouchingDepth; });
}

ContactImpulse ImpulseOf(const std::vector<EventContactPoint>& points) {
  ContactImpulse sum;
  for (const EventContactPoint& point : points) {
    sum.normal += point.normal_impulse;
    sum.friction += point.friction_impulse;
  }
  return sum;
}

}  // namespace

TouchingPair StepTouches::PairOf(const ContactPair& pair) const {
  return {{state_.ids[Index(pair.entity_a)], state_.ids[Index(pair.entity_b)]},
          pair.is_sensor,
          pair.is_sensor && rule_.info(pair.geometry_a).is_sensor};
}

void StepTouches::Collect(const ContactBuffer& contacts, const ContactPair& pair,
                          std::vector<EventContactPoint>& points) const {
  const std::span<const ContactPoint> found = genphys::PointsOf(contacts, pair);
  if (points.empty()) points.reserve(found.size());
  for (const ContactPoint& p : found) {
    if (p.depth < kTouchingDepth && !(p.normal_impulse > 0)) continue;
    points.push_back(EventPointOf(rule_, pair, p));
  }
}

bool StepTouches::Touched(const TouchingPair& pair) const {
  return std::binary_search(before_.begin(), before_.end(), pair);
}

bool StepTouches::WillBeTold(const TouchingPair& pair) const {
  if (!kinds_.contact_points || pair.is_sensor) return false;
  return kinds_.persisting_contacts || (kinds_.contacts && !Touched(pair));
}

void StepTouches::Merge(const ContactBuffer& contacts, bool solved) {
  // Contacts come in order of entities, so this is sorted already but for pairs that are both sensor and solid.
  if (!std::is_sorted(found_.begin(), found_.end())) std::sort(found_.begin(), found_.end());
  std::vector<Touch> merged;
  merged.reserve(touches_.size() + found_.size());
  auto known = touches_.begin();
  for (auto first = found_.begin(); first != found_.end();) {
    const TouchingPair pair = first->pair;
    for (; known != touches_.end() && known->pair < pair; ++known) merged.push_back(std::move(*known));
    if (known != touches_.end() && known->pair == pair) {
      merged.push_back(std::move(*known++));
    } else {
      merged.push_back({.pair = pair});
    }
    Touch& touch = merged.back();
    std::vector<EventContactPoint> points;
    for (; first != found_.end() && first->pair == pair; ++first) {
      if (WillBeTold(pair) && (solved || !touch.solved)) Collect(contacts, contacts.pairs[first->place], points);
    }
    // Of several substeps the one is shown in which most was passed on.
    const ContactImpulse before = ImpulseOf(touch.points), now = ImpulseOf(points);
    const bool is_shown = !points.empty() && now.normal >= before.normal;
    if (is_shown) {
      std::swap(points, touch.points);
      // What that one found of their velocities may be what the first hit left of them.
      if (touch.first.empty() && !Touched(pair)) touch.first = std::move(points);
    }
    const ContactImpulse& other = is_shown ? before : now;
    touch.earlier.normal += other.normal;
    touch.earlier.friction += other.friction;
    touch.solved = touch.solved || solved;
  }
  for (; known != touches_.end(); ++known) merged.push_back(std::move(*known));
  touches_ = std::move(merged);
}

void StepTouches::AddSolved(const ContactBuffer& contacts) {
  found_.clear();
  for (uint32_t i = 0; i < contacts.pairs.size(); ++i) {
    const ContactPair& pair = contacts.pairs[i];
    if (!pair.is_sensor && HasPressed(contacts, pair)) found_.push_back({PairOf(pair), i});
  }
  Merge(contacts, true);
}

void StepTouches::AddVisits(const ContactBuffer& contacts, std::span<const ContactPair> visits) {
  if (!kinds_.sensors) return;
  for (const ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor && DeepEnough(contacts, pair)) visits_.push_back(PairOf(pair));
  }
  for (const ContactPair& visit : visits) visits_.push_back(PairOf(visit));
}

void StepTouches::AddFinal(const ContactBuffer& contacts) {
  found_.clear();
  for (uint32_t i = 0; i < contacts.pairs.size(); ++i) {
    if (DeepEnough(contacts, contacts.pairs[i])) found_.push_back({PairOf(contacts.pairs[i]), i});
  }
  Merge(contacts, false);
}

void StepTouches::KeepUntested(const RowMarks& tested) {
  const size_t found = touches_.size();
  for (const TouchingPair& pair : before_) {
    const auto is_tested = [&](EntityId id) { return tested[EntityRow{id.index()}]; };
    if (is_tested(pair.pair.a) || is_tested(pair.pair.b)) continue;
    // Who left the world's bounds in this step was still solved in it.
    const auto those = std::span(touches_).first(found);
    const auto same = std::ranges::lower_bound(those, pair, {}, &Touch::pair);
    if (same == those.end() || same->pair != pair) touches_.push_back({.pair = pair});
  }
  std::inplace_merge(touches_.begin(), touches_.begin() + static_cast<std::ptrdiff_t>(found), touches_.end(),
                     [](const Touch& a, const Touch& b) { return a.pair < b.pair; });
}

std::vector<TouchingPair> StepTouches::Pairs() const {
  std::vector<TouchingPair> pairs;
  pairs.reserve(touches_.size());
  for (const Touch& touch : touches_) pairs.push_back(touch.pair);
  return pairs;
}

std::vector<EventContactPoint> StepTouches::PointsOf(const Touch& touch) {
  std::vector<EventContactPoint> points = touch.points;
  // Impulses are told per step: those of other substeps are shared out as these points press.
  const double shown = ImpulseOf(points).normal;
  if (shown > 0) {
    for (EventContactPoint& point : points) {
      const double part = point.normal_impulse / shown;
      point.normal_impulse += part * touch.earlier.normal;
      point.friction_impulse += part * touch.earlier.friction;
    }
  }
  for (EventContactPoint& point : points) {
    const auto apart = [&](const EventContactPoint& other) { return (other.position - point.position).squaredNorm(); };
    const auto nearest = std::ranges::min_element(touch.first, {}, apart);
    if (nearest != touch.first.end()) point.relative_velocity = nearest->relative_velocity;
  }
  return points;
}

void StepTouches::ReportNow(const Touch& touch, bool was, std::vector<EventKind>& events) const {
  const auto& [a, b] = touch.pair.pair;
  if (touch.pair.is_sensor) {
    if (was || !kinds_.sensors) return;
    events.push_back(touch.pair.a_is_sensor ? SensorEntered{a, b} : SensorEntered{b, a});
  } else if (was) {
    if (kinds_.persisting_contacts) events.push_back(ContactPersisted{touch.pair.pair, PointsOf(touch)});
  } else if (kinds_.contacts) {
    events.push_back(ContactBegan{touch.pair.pair, PointsOf(touch)});
  }
}

// Of those who are inside neither before nor after the step.
void StepTouches::ReportVisits(std::vector<EventKind>& events) const {
  std::vector<TouchingPair> visits = visits_;
  std::ranges::sort(visits);
  const auto twice = std::ranges::unique(visits);
  visits.erase(twice.begin(), twice.end());
  for (const TouchingPair& pair : visits) {
    const auto now = std::ranges::lower_bound(touches_, pair, {}, &Touch::pair);
    if ((now != touches_.end() && now->pair == pair) || std::ranges::binary_search(before_, pair)) continue;
    ReportNow({.pair = pair}, false, events);
    ReportEnd(pair, events);
  }
}

void StepTouches::ReportEnd(const TouchingPair& pair, std::vector<EventKind>& events) const {
  const auto& [a, b] = pair.pair;
  if (!pair.is_sensor && kinds_.contacts) events.push_back(ContactEnded{pair.pair});
  if (pair.is_sensor && kinds_.sensors) events.push_back(pair.a_is_sensor ? SensorLeft{a, b} : SensorLeft{b, a});
}

void StepTouches::Report(std::vector<EventKind>& events) const {
  auto old = before_.begin();
  for (const Touch& touch : touches_) {
    for (; old != before_.end() && *old < touch.pair; ++old) ReportEnd(*old, events);
    const bool was = old != before_.end() && *old == touch.pair;
    if (was) ++old;
    ReportNow(touch, was, events);
  }
  for (; old != before_.end(); ++old) ReportEnd(*old, events);
  ReportVisits(events);
}

}  // namespace genphys

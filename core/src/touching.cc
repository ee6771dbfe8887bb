#include "touching.h"

#include <algorithm>

namespace genphys {
namespace {

bool DeepEnough(const ContactBuffer& contacts, const ContactPair& pair) {
  for (uint32_t i = 0; i < pair.point_count; ++i) {
    if (contacts.points[pair.first_point + i].depth >= kTouchingDepth) return true;
  }
  return false;
}

bool PassedImpulse(const ContactBuffer& contacts, const ContactPair& pair) {
  for (uint32_t i = 0; i < pair.point_count; ++i) {
    if (contacts.points[pair.first_point + i].normal_impulse > 0) return true;
  }
  return false;
}

double NormalImpulse(const std::vector<EventContactPoint>& points) {
  double sum = 0;
  for (const EventContactPoint& point : points) sum += point.normal_impulse;
  return sum;
}

}  // namespace

TouchingPair StepTouches::PairOf(const ContactPair& pair) const {
  return {{state_.ids[Index(pair.entity_a)], state_.ids[Index(pair.entity_b)]},
          pair.is_sensor,
          pair.is_sensor && rule_.info(pair.geometry_a).is_sensor};
}

void StepTouches::Collect(const ContactBuffer& contacts, const ContactPair& pair, Touch& touch) const {
  if (!kinds_.contact_points || pair.is_sensor) return;
  for (uint32_t i = 0; i < pair.point_count; ++i) {
    const ContactPoint& p = contacts.points[pair.first_point + i];
    if (p.depth < kTouchingDepth && !(p.normal_impulse > 0)) continue;
    touch.points.push_back({p.position, p.normal, p.depth, p.normal_impulse, p.friction_impulse, p.relative_velocity,
                            pair.material.friction, pair.material.restitution, rule_.info(pair.geometry_a).geometry_id,
                            rule_.info(pair.geometry_b).geometry_id});
  }
}

void StepTouches::AddSolved(const ContactBuffer& contacts) {
  // One entity pair may come as several geometry pairs in a row: what an earlier substep left is folded away once.
  TouchingPair last;
  for (const ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor || !PassedImpulse(contacts, pair)) continue;
    const TouchingPair key = PairOf(pair);
    Touch& touch = touches_[key];
    if (key != last) {
      touch.impulse_before += NormalImpulse(touch.points);
      touch.points.clear();
      last = key;
    }
    touch.solved = true;
    Collect(contacts, pair, touch);
  }
}

void StepTouches::AddFinal(const ContactBuffer& contacts) {
  for (const ContactPair& pair : contacts.pairs) {
    if (!DeepEnough(contacts, pair)) continue;
    Touch& touch = touches_[PairOf(pair)];
    if (!touch.solved) Collect(contacts, pair, touch);
  }
}

void StepTouches::KeepUntested(const std::vector<TouchingPair>& before, const std::vector<uint8_t>& tested_rows) {
  for (const TouchingPair& pair : before) {
    if (!tested_rows[pair.pair.a.index()] && !tested_rows[pair.pair.b.index()]) touches_.try_emplace(pair);
  }
}

std::vector<TouchingPair> StepTouches::Pairs() const {
  std::vector<TouchingPair> pairs;
  pairs.reserve(touches_.size());
  for (const auto& [pair, touch] : touches_) pairs.push_back(pair);
  return pairs;
}

std::vector<EventContactPoint> StepTouches::PointsOf(const TouchingPair& pair) const {
  const Touch& touch = touches_.at(pair);
  std::vector<EventContactPoint> points = touch.points;
  // Impulses are told per step: those of earlier substeps are shared out like those of the last one.
  const double shown = NormalImpulse(points);
  if (shown > 0 && touch.impulse_before > 0) {
    const double scale = (shown + touch.impulse_before) / shown;
    for (EventContactPoint& point : points) {
      point.normal_impulse *= scale;
      point.friction_impulse *= scale;
    }
  }
  return points;
}

void StepTouches::Report(const std::vector<TouchingPair>& before, std::vector<EventKind>& events) const {
  const auto was = [&](const TouchingPair& pair) { return std::binary_search(before.begin(), before.end(), pair); };
  const auto visit = [](const TouchingPair& pair, auto make) {
    return pair.a_is_sensor ? make(pair.pair.a, pair.pair.b) : make(pair.pair.b, pair.pair.a);
  };
  for (const auto& [pair, touch] : touches_) {
    if (!pair.is_sensor && kinds_.contacts && !was(pair)) events.push_back(ContactBegan{pair.pair, PointsOf(pair)});
    if (!pair.is_sensor && kinds_.persisting_contacts && was(pair)) {
      events.push_back(ContactPersisted{pair.pair, PointsOf(pair)});
    }
    if (pair.is_sensor && kinds_.sensors && !was(pair)) {
      events.push_back(visit(pair, [](EntityId s, EntityId v) { return SensorEntered{s, v}; }));
    }
  }
  for (const TouchingPair& pair : before) {
    if (touches_.contains(pair)) continue;
    if (!pair.is_sensor && kinds_.contacts) events.push_back(ContactEnded{pair.pair});
    if (pair.is_sensor && kinds_.sensors) {
      events.push_back(visit(pair, [](EntityId s, EntityId v) { return SensorLeft{s, v}; }));
    }
  }
}

}  // namespace genphys

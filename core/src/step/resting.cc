#include "step/resting.h"

namespace genphys {
namespace {

// So many times as fast as who rests at most. (Of 100 boxes that lie on each other and are swept 20 times a substep the
// fastest has 0.8 of those speeds in the median of all steps, and up to 4 in one of 240.)
constexpr double kTrembleMax = 4;

// The part of the way that it would go at those speeds in its rest time. What a steady push sets in motion comes half
// as far as at the speed that it has in the end.
constexpr double kDriftMax = 0.5;

// The part of the speeds at which it rests at most. What steadily comes to go by so much faster, or in another
// direction, is pushed, and nothing holds it there: a hundredth of a metre per second each second shows within half a
// second.
constexpr double kDriven = 0.15;
// The part of its rest time for which one is looked at before that: a single jolt is no push.
constexpr double kKnown = 0.25;

enum class Motion { kRests, kTrembles, kMoves };

Motion MotionOf(const StateArrays& state, uint32_t row, const BodyTraits& traits, bool is_pushed) {
  const double speed = state.linear_velocities.col(row).norm(), spin = state.angular_velocities.col(row).norm();
  if (speed <= traits.rest_speed && spin <= traits.rest_spin && !is_pushed) return Motion::kRests;
  const bool is_slow = speed <= kTrembleMax * traits.rest_speed && spin <= kTrembleMax * traits.rest_spin;
  return is_slow ? Motion::kTrembles : Motion::kMoves;
}

bool IsThere(const Pose& from, const Pose& pose, const SceneEntity& entity) {
  const BodyTraits& traits = entity.traits;
  const Vector3& center = entity.mass.center_of_mass;
  const double way = (pose.Transform(center) - from.Transform(center)).norm();
  const double time = kDriftMax * traits.rest_time;
  return way <= traits.rest_speed * time &&
         pose.orientation.angularDistance(from.orientation) <= traits.rest_spin * time;
}

// What a brake or friction stops is at rest once it is slow enough, though it steadily gets slower. What only joints
// hold swings back, and what stands on something by joints trembles.
bool IsDriven(const Drift& drift, double speed_max, EntityRow row, const RestMarks& marks) {
  if (!drift.IsSteady(kDriven * speed_max)) return false;
  return marks.jointed[row] ? marks.swings(row) : drift.last.dot(drift.last - drift.first) > 0;
}

// Of the entity in `row`, which rests on, or not if it turns out to be driven.
void Advance(const StateArrays& state, uint32_t row, const BodyTraits& traits, const RestMarks& marks, double step_size,
             LayerState& layer) {
  double& time = layer.rest_times[row];
  RestWatch& watch = layer.rest_watches[row];
  const Vector3 velocity = state.linear_velocities.col(row), spin = state.angular_velocities.col(row);
  bool begins = time == 0;
  if (!begins) {
    watch.linear.Look(velocity);
    watch.angular.Look(spin);
    const bool is_known = watch.time >= kKnown * traits.rest_time;
    if (is_known && (IsDriven(watch.linear, traits.rest_speed, EntityRow{row}, marks) ||
                     IsDriven(watch.angular, traits.rest_spin, EntityRow{row}, marks))) {
      time = 0;
      begins = true;
    }
  }
  time += step_size;
  watch.time += step_size;
  if (!begins && watch.time < traits.rest_time) return;
  watch.time = 0;
  watch.from = state.pose(EntityRow{row});
  watch.linear.Begin(velocity);
  watch.angular.Begin(spin);
}

// By row.
std::vector<uint8_t> WhoTouches(const StateArrays& state, const LayerState& layer) {
  std::vector<uint8_t> touches(state.rows());
  for (const TouchingPair& touching : layer.touching) {
    if (touching.is_sensor) continue;
    touches[touching.pair.a.index()] = touches[touching.pair.b.index()] = true;
  }
  return touches;
}

}  // namespace

void AdvanceRests(const Scene& scene, const StateArrays& state, const std::vector<EntityRow>& rows,
                  const RestMarks& marks, double step_size, LayerState& layer) {
  std::vector<uint32_t> trembling;
  const auto advance = [&](uint32_t row) { Advance(state, row, scene.entities[row]->traits, marks, step_size, layer); };
  for (const EntityRow entity : rows) {
    const uint32_t row = Index(entity);
    const BodyTraits& traits = scene.entities[row]->traits;
    if (!traits.may_sleep) {
      layer.rest_times[row] = 0;
      continue;
    }
    switch (MotionOf(state, row, traits, marks.pushed[entity])) {
      case Motion::kRests:
        advance(row);
        break;
      case Motion::kTrembles:
        trembling.push_back(row);
        break;
      case Motion::kMoves:
        layer.rest_times[row] = 0;
        break;
    }
  }
  if (trembling.empty()) return;
  const std::vector<uint8_t> touches = WhoTouches(state, layer);
  for (const uint32_t row : trembling) {
    // What hops or was pushed from outside moves.
    const HalfStep& half = layer.half_steps[row];
    const bool may_rest = layer.rest_times[row] > 0 && touches[row] && !half.is_struck && !half.restarts;
    if (may_rest && IsThere(layer.rest_watches[row].from, state.pose(EntityRow{row}), *scene.entities[row])) {
      advance(row);
    } else {
      layer.rest_times[row] = 0;
    }
  }
}

bool HasRested(const Scene& scene, const LayerState& layer, uint32_t row) {
  const BodyTraits& traits = scene.entities[row]->traits;
  const double time = layer.rest_times[row];
  return traits.may_sleep && time > 0 && time >= traits.rest_time;
}

}  // namespace genphys

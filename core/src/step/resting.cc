#include "step/resting.h"

namespace genphys {
namespace {

// So many times as fast as who rests at most. (Of 100 boxes that lie on each other and are swept 20 times a substep the
// fastest has 0.8 of those speeds in the median of all steps, and up to 4 in one of 240.)
constexpr double kTrembleMax = 4;

// The part of the way that it would go at those speeds in its rest time. What a steady push sets in motion comes half
// as far as at the speed that it has in the end.
constexpr double kDriftMax = 0.5;

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

void Advance(double& time, RestWatch& watch, const Pose& pose, double rest_time, double step_size) {
  const bool begins = time == 0;
  time += step_size;
  watch.time += step_size;
  if (begins || watch.time >= rest_time) watch = {0, pose};
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
                  const RowMarks& pushed, double step_size, LayerState& layer) {
  std::vector<uint32_t> trembling;
  const auto advance = [&](uint32_t row) {
    const double rest_time = scene.entities[row]->traits.rest_time;
    Advance(layer.rest_times[row], layer.rest_watches[row], state.pose(EntityRow{row}), rest_time, step_size);
  };
  for (const EntityRow entity : rows) {
    const uint32_t row = Index(entity);
    const BodyTraits& traits = scene.entities[row]->traits;
    if (!traits.may_sleep) {
      layer.rest_times[row] = 0;
      continue;
    }
    switch (MotionOf(state, row, traits, pushed[entity])) {
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

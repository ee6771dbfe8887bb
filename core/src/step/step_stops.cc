// Whom the impacts of a substep leave, for too many happen one after the other: nobody goes through another one for it.
#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "impacts/impact_past.h"
#include "motion/free_rotation.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// Who is met later waits in so many rounds until it is known where that one stays: each finds the next of a row.
constexpr int kRoundsInOrder = 16;
// So often somebody is stopped: by what takes it along, and by what is in the way then.
constexpr int kStopsMost = 2;

}  // namespace

// Stays where it met somebody, from then to the end, and goes along with that one if this is led. All of it is known
// then, as if it went there so; its velocity is what it came with, and the blow is that of the end.
class StepRun::Stops {
 public:
  Stops(StepRun& run, double h) : run_(run), world_(run.Surroundings()), past_(world_, h) {}

  // Stops those of `hits` that are the first of their bodies, or all that are not `in_order`. Returns the ways of whom
  // that stopped, ascending, which are in `flown` as well.
  std::vector<FlownWay> Stop(std::span<const SweptPair> hits, std::vector<FlownWay>& flown, bool in_order) {
    past_.Follow(flown);
    FindGroups(hits);
    std::vector<FlownWay> ways;
    for (const SweptPair& hit : hits) {
      Group *const a = GroupOf(hit.entity_a), *const b = GroupOf(hit.entity_b);
      const double first = std::max(a != nullptr ? a->time : 0, b != nullptr ? b->time : 0);
      if (in_order && hit.time < first) continue;
      if (a != nullptr) StopAll(*a, hit.entity_b, ways);
      if (b != nullptr) StopAll(*b, hit.entity_a, ways);
    }
    world_.group_of.Clear();
    std::ranges::sort(ways, {}, &FlownWay::row);
    for (const FlownWay& way : ways) {
      const auto place = std::ranges::lower_bound(flown, way.row, {}, &FlownWay::row);
      if (place != flown.end() && place->row == way.row) {
        *place = way;
      } else {
        flown.insert(place, way);
      }
    }
    return ways;
  }

  // They go on as they came.
  void LetGo() {
    for (const auto& [row, stopped] : stopped_) {
      if (!run_.IsMoved(row)) continue;
      world_.state.linear_velocities.col(Index(row)) = stopped.linear_velocity;
      world_.state.angular_velocities.col(Index(row)) = stopped.angular_velocity;
      world_.layer.half_steps[Index(row)].in_flight = stopped.was_in_flight;
    }
  }

 private:
  // What joints hold together.
  struct Group {
    std::vector<EntityRow> rows;
    double time = 0;  // s before the end, of the first hit
    bool is_stopped = false;
  };
  struct Stopped {
    Vector3 linear_velocity = Vector3::Zero();
    Vector3 angular_velocity = Vector3::Zero();
    bool was_in_flight = false;
    int stops = 0;
  };

  bool MayStop(EntityRow row) const {
    const auto known = stopped_.find(row);
    return run_.IsMoved(row) && (known == stopped_.end() || known->second.stops < kStopsMost);
  }

  Group* GroupOf(EntityRow row) {
    const int number = std::as_const(world_.group_of)[row];
    return number < 0 ? nullptr : &groups_[static_cast<size_t>(number)];
  }

  void FindGroups(std::span<const SweptPair> hits) {
    groups_.clear();
    world_.linked.Clear();
    for (const SweptPair& hit : hits) {
      for (const EntityRow row : {hit.entity_a, hit.entity_b}) {
        if (!MayStop(row)) continue;
        if (GroupOf(row) == nullptr) {
          const bool is_alone = !world_.jointed[row];
          groups_.push_back({is_alone ? std::vector{row} : world_.joints.TiedTo(row, world_.linked).rows});
          for (const EntityRow each : groups_.back().rows) world_.group_of[each] = static_cast<int>(groups_.size()) - 1;
        }
        Group& group = *GroupOf(row);
        group.time = std::max(group.time, hit.time);
      }
    }
  }

  void StopAll(Group& group, EntityRow other, std::vector<FlownWay>& ways) {
    if (std::exchange(group.is_stopped, true)) return;
    const bool is_led = world_.active[Index(other)] && !run_.IsDynamic(other);
    for (const EntityRow row : group.rows) {
      if (run_.IsMoved(row)) ways.push_back(Stop(row, group.time, is_led ? &other : nullptr));
    }
  }

  FlownWay Stop(EntityRow row, double time, const EntityRow* leader) {
    const uint32_t index = Index(row);
    HalfStep& half = world_.layer.half_steps[index];
    const auto [known, is_new] = stopped_.try_emplace(row);
    // Who was stopped goes straight on since then.
    const ImpactMotion motion =
        is_new ? past_.MotionOf(row)
               : ImpactMotion::Driven(world_.state.pose(row), world_.state.linear_velocities.col(index),
                                      world_.state.angular_velocities.col(index));
    time = std::min(time, std::as_const(world_.free_since)[row]);
    if (is_new) {
      const StruckBody then = motion.BodyBefore(time);
      known->second = {then.linear_velocity, then.angular_velocity, half.in_flight};
    }
    ++known->second.stops;
    const Pose start = motion.PoseBefore(time);
    Pose end = start;
    Vector3 spin = Vector3::Zero();
    if (leader != nullptr) {
      const Pose before = run_.LedFrom(*leader, time), now = world_.state.pose(*leader);
      const Quaternion turn = now.orientation * before.orientation.conjugate();
      end = {now.position + turn * (start.position - before.position), (turn * start.orientation).normalized()};
      spin = world_.state.angular_velocities.col(Index(*leader));
    }
    world_.state.set_pose(row, end);
    world_.state.linear_velocities.col(index) =
        time > 0 ? Vector3((end.position - start.position) / time) : Vector3(Vector3::Zero());
    world_.state.angular_velocities.col(index) = spin;
    world_.free_since[row] = time;
    half.Restart();
    half.in_flight = false;
    run_.scratch_.changed.Mark(row);
    return {row, start, time};
  }

  StepRun& run_;
  ImpactWorld world_;
  ImpactPast past_;
  std::map<EntityRow, Stopped> stopped_;
  std::vector<Group> groups_;
};

// Those whose ways meet are stopped at that. `ways` are those that nobody looked along since the last impacts.
void StepRun::StopThoseLeft(double h, double elapsed, std::vector<FlownWay>& flown, std::vector<FlownWay>& ways,
                            const RowMarks*& looked_at) {
  Stops stops(*this, h);
  for (int round = 0;; ++round) {
    const Swept swept = SweepAlong(h, elapsed, flown, ways, looked_at);
    ways = stops.Stop(swept.hits, flown, round < kRoundsInOrder);
    if (ways.empty()) break;
    std::vector<EntityRow> rows;
    for (const FlownWay& way : ways) rows.push_back(way.row);
    TellMoved(rows, elapsed, looked_at);
    AddCrossing(flown, ways);
  }
  stops.LetGo();
}

}  // namespace genphys

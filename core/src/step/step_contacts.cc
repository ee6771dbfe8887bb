// What the layer tells the engine of contacts before a solve: how rough they are, and which of them are impacts to
// come.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "genphys/work_watch.h"
#include "motion/free_rotation.h"
#include "motion/running_surfaces.h"
#include "pairs/bounds_tree.h"
#include "pairs/contact_points.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// More impacts one after the other than this are left to the next substep.
constexpr int kWavesMax = 32;
// Of a WorkWatch, to see whether a way crosses others.
constexpr int64_t kWayWork = 64;
// Friction that gave this part of what it can held no more.
constexpr double kGivenWay = 0.99;
// m/s: what slips more slowly than this trembles.
constexpr double kTremble = 1e-4;

Vector3 SlipAt(const ContactPair& pair, const ContactPoint& point) {
  const Vector3 slip = point.relative_velocity + pair.surface_velocity;
  return slip - slip.dot(point.normal) * point.normal;
}

// Whether friction gave all that it can in the solve that left the pair there.
bool HasGivenWay(const ContactBuffer& solved, const ContactPair& pair) {
  double given = 0, most = 0;
  for (const ContactPoint& point : PointsOf(solved, pair)) {
    given += point.friction_impulse.norm();
    most += point.friction * point.normal_impulse;
  }
  return most > 0 && given >= kGivenWay * most;
}

const ContactPoint& NearestOf(std::span<const ContactPoint> points, const Vector3& position) {
  return *std::ranges::min_element(
      points, {}, [&](const ContactPoint& point) { return (point.position - position).squaredNorm(); });
}

}  // namespace

const ContactPair* StepRun::SolvedBefore(const ContactPair& pair) const {
  const auto ids = [&](const ContactPair& each) {
    return EntityPair{state_.ids[Index(each.entity_a)], state_.ids[Index(each.entity_b)]};
  };
  const std::vector<ContactPair>& solved = world_.solved_.pairs;
  for (auto each = solved_search_.LowerBound(solved, ids(pair), ids); each != solved.end(); ++each) {
    if (each->geometry_a == pair.geometry_a && each->geometry_b == pair.geometry_b) return &*each;
    if (ids(*each) != ids(pair)) break;
  }
  return nullptr;
}

// What slides goes on sliding until its slip comes to nothing, and then friction at rest may hold it. What was held
// slides from where that gives way: how fast tells neither, for it is as slow before it stops as when it has begun.
void StepRun::RoughenSliding(ContactPair& pair, double h) {
  std::span<ContactPoint> points = std::span(world_.contacts_.points).subspan(pair.first_point, pair.point_count);
  if (pair.material.kinetic_friction == pair.material.friction) {
    for (ContactPoint& point : points) point.friction = pair.material.friction;
    return;
  }
  const ContactPair* before = SolvedBefore(pair);
  const std::span<const ContactPoint> solved =
      before == nullptr ? std::span<const ContactPoint>() : PointsOf(world_.solved_, *before);
  const auto pull = [&](EntityRow row) { return IsMoved(row) ? scratch_.accelerations[row].norm() : 0.0; };
  const double stoppable = pair.material.friction * std::max(pull(pair.entity_a), pull(pair.entity_b)) * h;
  const bool has_given_way = !solved.empty() && HasGivenWay(world_.solved_, *before);
  for (ContactPoint& point : points) {
    const Vector3 slip = SlipAt(pair, point);
    double least = kSlidingSpeed;
    bool has_turned = false;
    if (!solved.empty()) {
      const ContactPoint& last = NearestOf(solved, point.position);
      const Vector3 last_slip = SlipAt(*before, last);
      const bool slid = last.friction == pair.material.kinetic_friction;
      has_turned = slip.dot(last_slip) < 0;
      // What was held shows what it is owed as a slip, and so does what was just stopped.
      const bool slides_on = has_given_way && (slid || slip.squaredNorm() > last_slip.squaredNorm());
      least = slides_on ? kTremble : std::max(kSlidingSpeed, stoppable);
    }
    const bool slides = !has_turned && slip.norm() > least;
    point.friction = slides ? pair.material.kinetic_friction : pair.material.friction;
  }
}

Vector3 StepRun::CenterOf(EntityRow row) const {
  const Vector3& center = world_.scene_.entities[Index(row)]->mass.center_of_mass;
  if (center.isZero(0)) return state_.positions.col(Index(row));
  return state_.pose(row).Transform(center);
}

Vector3 StepRun::VelocityAt(EntityRow row, const Vector3& center, const Vector3& point) const {
  const Vector3 spin = state_.angular_velocities.col(Index(row));
  return state_.linear_velocities.col(Index(row)) + spin.cross(point - center);
}

void StepRun::FillRelativeVelocities(const RowMarks* changed) {
  ContactBuffer& contacts = world_.contacts_;
  FillSurfaceVelocities(world_.rule_, state_, contacts);
  for (ContactPair& pair : contacts.pairs) {
    if (changed != nullptr && !(*changed)[pair.entity_a] && !(*changed)[pair.entity_b]) continue;
    if (pair.material.rolling_friction > 0) {
      pair.rolling =
          state_.angular_velocities.col(Index(pair.entity_b)) - state_.angular_velocities.col(Index(pair.entity_a));
    }
    const Vector3 center_a = CenterOf(pair.entity_a), center_b = CenterOf(pair.entity_b);
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      ContactPoint& point = contacts.points[i];
      point.relative_velocity =
          VelocityAt(pair.entity_b, center_b, point.position) - VelocityAt(pair.entity_a, center_a, point.position);
    }
  }
}

void StepRun::PrepareContacts(double h) {
  ContactBuffer& contacts = world_.contacts_;
  const double pull = world_.scene_.world.gravity.norm();
  contacts.pull = pull > 0 ? pull : ContactBuffer::kUsualPull;
  const ImpactWorld surroundings = Surroundings();
  const ImpactSpeed impact_speed(surroundings, h);
  const Impacts impacts(surroundings, h, true);
  CountPartners();
  for (const Mover& mover : movers_) {
    scratch_.flew.Set(mover.row, world_.layer_.half_steps[Index(mover.row)].in_flight);
  }
  for (ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor) continue;
    pair.interval = IntervalOf(pair, h);
    const bool is_solved_apart = pair.material.restitution > 0 || impact_speed.IsFree(pair);
    const bool is_met_anew = !is_solved_apart && impacts.IsNewAmongHeld(pair);
    // Whether it slides is a matter of its true velocity: this substep's push may be one that friction holds.
    RoughenSliding(pair, h);
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      ContactPoint& point = contacts.points[i];
      const double closing = -point.relative_velocity.dot(point.normal);
      // What parts fast enough to be apart by the end is no more in touch.
      const bool is_apart = point.depth < std::max(0.0, -closing * h);
      const double speed = impact_speed.Of(pair.entity_a, pair.entity_b, point.normal);
      point.is_ahead = is_solved_apart && is_apart && (point.depth < -kReleaseGap || std::abs(closing) > speed);
      // Impacts stop it where it comes to lie.
      const bool is_stopped = is_met_anew || (!is_solved_apart && impacts.SlamsOnto(pair, closing));
      point.is_ahead = point.is_ahead || (is_stopped && point.depth < 0 && closing > speed);
      point.is_ahead = point.is_ahead || (point.depth < 0 && impacts.TipsOnto(pair, point));
      point.is_ahead = point.is_ahead || impacts.OnlySlidesOnto(pair, point);
    }
    pair.bend = scratch_.bends[static_cast<size_t>(&pair - contacts.pairs.data())];
    pair.drawn = DrawnBefore(pair, h);
  }
}

// For how long (s) the next solve acts on the two: of who began anew and who did not, the shorter time.
double StepRun::IntervalOf(const ContactPair& pair, double h) const {
  const LayerState& layer = world_.layer_;
  double interval = std::numeric_limits<double>::infinity();
  for (const EntityRow row : {pair.entity_a, pair.entity_b}) {
    if (!IsMoved(row)) continue;
    interval = std::min(interval, layer.half_steps[Index(row)].Interval(layer.last_substep, h));
  }
  return std::isfinite(interval) ? interval : h;
}

// What is told of a solve are the impulses of one substep. Of two of which only one began anew the other one was given
// what it got in less time than it was held.
void StepRun::ShareImpulses(double h) {
  ContactBuffer& contacts = world_.contacts_;
  for (ContactPair& pair : contacts.pairs) {
    pair.owed = kOwed;
    if (pair.is_sensor) continue;
    if (pair.interval != h) {
      NoteUneven(pair, h);
      const double scale = ImpulseScale(std::exchange(pair.interval, h), h);
      for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
        contacts.points[i].normal_impulse *= scale;
        contacts.points[i].friction_impulse *= scale;
      }
    }
    NoteLever(pair, h);
  }
}

// What two that move owe each other they pay at one point, or what turns them would come or go: where they touched,
// taken along more by the lighter one. What each of them was given turns it as if its own centre took that along.
void StepRun::NoteLever(const ContactPair& pair, double h) {
  // Joints would have to pass it on, and smooth ones cannot turn each other.
  const auto is_free = [this](EntityRow row) { return IsMoved(row) && !scratch_.jointed[row]; };
  if (pair.material.friction == 0 || !is_free(pair.entity_a) || !is_free(pair.entity_b)) return;
  Vector3 impulse = Vector3::Zero();
  for (const ContactPoint& point : PointsOf(world_.contacts_, pair)) {
    impulse += point.normal_impulse * point.normal + point.friction_impulse;
  }
  if (impulse.isZero(0)) return;
  const Vector3 parted =
      h * (state_.linear_velocities.col(Index(pair.entity_b)) - state_.linear_velocities.col(Index(pair.entity_a)));
  const double mass_a = MassOf(pair.entity_a), mass_b = MassOf(pair.entity_b);
  const Vector3 more = kOwed / (mass_a + mass_b) * impulse.cross(parted);
  scratch_.uneven[pair.entity_a].torque += mass_a * more;
  scratch_.uneven[pair.entity_b].torque += mass_b * more;
}

// What the pair owes to the one that was given it for a longer time, beyond what it would owe if it had got it all the
// time.
void StepRun::NoteUneven(const ContactPair& pair, double h) {
  if (!IsMoved(pair.entity_a) || !IsMoved(pair.entity_b)) return;
  if (scratch_.jointed[pair.entity_a] || scratch_.jointed[pair.entity_b]) return;
  // Of who was woken nobody knows yet how it is held.
  const auto is_woken = [&](EntityRow row) { return world_.layer_.half_steps[Index(row)].is_woken; };
  if (is_woken(pair.entity_a) || is_woken(pair.entity_b)) return;
  for (const auto& [row, sign] : {std::pair(pair.entity_a, -1.0), std::pair(pair.entity_b, 1.0)}) {
    const double own = world_.layer_.half_steps[Index(row)].Interval(world_.layer_.last_substep, h);
    if (own == pair.interval) continue;
    const double part = sign * h / 2 * (1 / pair.interval - 1 / own);
    const Vector3 center = CenterOf(row);
    Wrench& uneven = scratch_.uneven[row];
    for (const ContactPoint& point : std::span(world_.contacts_.points).subspan(pair.first_point, pair.point_count)) {
      const Vector3 impulse = part * (point.normal_impulse * point.normal + point.friction_impulse);
      uneven.force += impulse;
      uneven.torque += (point.position - center).cross(impulse);
    }
  }
}

ImpactWorld StepRun::Surroundings() {
  return {.scene = world_.scene_,
          .state = state_,
          .layer = world_.layer_,
          .rule = world_.rule_,
          .geometry_rows = world_.geometry_rows_,
          .active = world_.active_,
          .accelerations = scratch_.accelerations,
          .flew = scratch_.flew,
          .flies = scratch_.flies,
          .jolted = scratch_.jolted,
          .jointed = scratch_.jointed,
          .solved = world_.solved_,
          .joints = joints_,
          .linked = scratch_.linked,
          .shoved = scratch_.shoved,
          .group_of = scratch_.group_of,
          .struck_index = scratch_.struck_index,
          .swept_index = scratch_.swept_index,
          .crowd_number = scratch_.crowd_number,
          .earliest = scratch_.earliest,
          .free_since = scratch_.free_since,
          .stances = scratch_.stances,
          .passed_index = scratch_.passed_index};
}

// Where a kinematic entity was `time` seconds ago.
Pose StepRun::LedFrom(EntityRow row, double time) const {
  const Pose now = state_.pose(row);
  return {now.position - time * state_.linear_velocities.col(Index(row)),
          Turned(now.orientation, -state_.angular_velocities.col(Index(row)), time)};
}

// Who sleeps where something flew through is awake when that hits it.
bool StepRun::WakeSwept(std::span<const SweptPair> swept) {
  bool is_any = false;
  for (const SweptPair& pair : swept) {
    for (const EntityRow row : {pair.entity_a, pair.entity_b}) {
      if (!state_.asleep[Index(row)] || world_.layer_.faulted[Index(row)] || !IsDynamic(row)) continue;
      world_.WakeIslandOf(row);
      is_any = true;
    }
  }
  if (!is_any) return false;
  Mark("impacts");
  world_.WakeStirred();
  CollideWoken();
  return true;
}

void StepRun::AddVisits() {
  std::vector<ContactPair> pairs;
  for (const SweptPair& visit : visits_) {
    pairs.push_back({.entity_a = visit.entity_a,
                     .entity_b = visit.entity_b,
                     .geometry_a = visit.geometry_a,
                     .geometry_b = visit.geometry_b,
                     .is_sensor = true});
  }
  touches_.AddVisits(world_.contacts_, pairs);
}

// Of all that move, by row, since the substep began.
std::vector<FlownWay> StepRun::FlownWays(double h) const {
  std::vector<FlownWay> ways;
  ways.reserve(movers_.size() + kinematic_rows_.size());
  for (const Mover& mover : movers_) {
    FlownWay& way = ways.emplace_back(FlownWay{mover.row, mover.start, h});
    if (!scratch_.jointed[mover.row]) continue;
    const HalfStep& half = world_.layer_.half_steps[Index(mover.row)];
    way.acceleration = std::as_const(scratch_.accelerations)[mover.row] + 2 / h * half.held_velocity;
    way.torque = 2 / h * (half.steady_twist + half.held_momentum);
  }
  for (const EntityRow row : kinematic_rows_) ways.push_back({row, LedFrom(row, h), h});
  if (!std::ranges::is_sorted(ways, {}, &FlownWay::row)) std::ranges::sort(ways, {}, &FlownWay::row);
  return ways;
}

// The ways that nobody looked along yet, now that the last impacts changed some. `flown` has those since each was hit.
std::vector<FlownWay> StepRun::NewWays(const Impacts& impacts, std::vector<FlownWay>& flown) {
  std::vector<EntityRow> rows = impacts.WaitingSwept();
  for (const FlownWay& moved : impacts.moved()) {
    rows.push_back(moved.row);
    const auto place = std::ranges::lower_bound(flown, moved.row, {}, &FlownWay::row);
    if (place != flown.end() && place->row == moved.row) {
      *place = moved;
    } else {
      flown.insert(place, moved);
    }
  }
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  std::vector<FlownWay> ways;
  for (const EntityRow row : rows) {
    const auto place = std::ranges::lower_bound(flown, row, {}, &FlownWay::row);
    if (place != flown.end() && place->row == row) ways.push_back(*place);
  }
  return ways;
}

// Adds the ways of those that go far and cross one of `ways`: where they are by now is no more in its way.
void StepRun::AddCrossing(std::span<const FlownWay> flown, std::vector<FlownWay>& ways) const {
  // Of the mass centre: the frame may be anywhere else, and goes round it.
  const auto ends = [&](const FlownWay& way) {
    const Vector3& center = world_.scene_.entities[Index(way.row)]->mass.center_of_mass;
    return std::pair(center.isZero(0) ? way.start.position : way.start.Transform(center), CenterOf(way.row));
  };
  const auto around = [&](const FlownWay& way) {
    const auto [start, end] = ends(way);
    return Bounds{start.cwiseMin(end), start.cwiseMax(end)}.Widened(world_.reaches_[Index(way.row)]);
  };
  // Where many land in the same substep, as many fly on.
  BoundsTree boxes;
  for (uint32_t i = 0; i < ways.size(); ++i) boxes.Insert(around(ways[i]), GeometryRow{i}, BoundsTree::kNoGroup);
  boxes.Tidy();
  const auto own = static_cast<std::ptrdiff_t>(ways.size());
  for (const FlownWay& way : flown) {
    const auto [start, end] = ends(way);
    if ((end - start).norm() <= ThicknessOf(*world_.scene_.entities[Index(way.row)])) continue;
    if (std::ranges::binary_search(ways.begin(), ways.begin() + own, way.row, {}, &FlownWay::row)) continue;
    WorkWatch::Spend(kWayWork);
    bool crosses = false;
    boxes.VisitOverlaps(around(way), BoundsTree::kNoGroup, [&](GeometryRow) { crosses = true; });
    if (crosses) ways.push_back(way);
  }
  std::ranges::inplace_merge(ways, ways.begin() + own, {}, &FlownWay::row);
}

// Whom the bodies of `ways` met on them. What is looked at anew, for others are there now, is all: null.
Swept StepRun::SweepAlong(double h, double elapsed, std::vector<FlownWay>& flown, std::vector<FlownWay>& ways,
                          const RowMarks*& looked_at) {
  const ImpactWorld surroundings = Surroundings();
  Swept swept = FindSwept(surroundings, *world_.near_, ways, h);
  while (GroundPassed(swept, h, elapsed, flown, ways)) {
    FillRelativeVelocities(looked_at = nullptr);
    swept = FindSwept(surroundings, *world_.near_, ways, h);
  }
  return swept;
}

// Tells everybody where these are now. What is looked at anew is all, or nothing else.
void StepRun::TellMoved(const std::vector<EntityRow>& rows, double elapsed, const RowMarks*& looked_at) {
  for (const EntityRow row : rows) {
    std::erase_if(visits_, [&](const SweptPair& visit) {
      return (visit.entity_a == row || visit.entity_b == row) && visit.time < std::as_const(scratch_.free_since)[row];
    });
  }
  world_.engine_->WriteState(rows, state_);
  const size_t strays = faulted_.size();
  RetireStrays(&scratch_.changed);
  for (const EntityRow row : rows) Place(row);
  GroundMet(elapsed);
  const bool are_strays = faulted_.size() != strays;
  CollideAndWake(are_strays ? nullptr : &rows);
  if (are_strays) looked_at = nullptr;
}

void StepRun::ResolveImpacts(double h, double elapsed, bool after_move, const RowMarks* among) {
  const ImpactWorld surroundings = Surroundings();
  Impacts impacts(surroundings, h, after_move);
  std::vector<FlownWay> flown = after_move ? FlownWays(h) : std::vector<FlownWay>();
  std::vector<FlownWay> renewed;
  std::vector<FlownWay>* ways = &flown;
  FillRelativeVelocities(nullptr);
  RowMarks& changed = scratch_.changed;
  const RowMarks* looked_at = among;
  bool is_over = false;
  visits_.clear();
  for (int wave = 0; wave < kWavesMax; ++wave) {
    const Swept swept = SweepAlong(h, elapsed, flown, *ways, looked_at);
    visits_.insert(visits_.end(), swept.visits.begin(), swept.visits.end());
    if (WakeSwept(swept.hits)) FillRelativeVelocities(looked_at = nullptr);
    is_over = !impacts.Solve(world_.contacts_, looked_at, swept.hits, flown);
    if (is_over) break;
    changed.Clear();
    impacts.MarkStruck(changed);
    renewed = NewWays(impacts, flown);
    if (!renewed.empty()) AddCrossing(flown, renewed);
    ways = &renewed;
    std::vector<EntityRow> rows;
    for (const FlownWay& moved : impacts.moved()) rows.push_back(moved.row);
    locked_.Finish(changed);
    looked_at = &changed;
    Mark("impacts");
    if (!rows.empty()) TellMoved(rows, elapsed, looked_at);
    // Those whom an impact threw out of the bounds of the world meet nobody any more.
    const auto is_stray = [&](const FlownWay& way) { return scratch_.strays[way.row]; };
    std::erase_if(flown, is_stray);
    std::erase_if(renewed, is_stray);
    FillRelativeVelocities(looked_at);
  }
  if (!is_over && after_move) StopThoseLeft(h, elapsed, flown, renewed, looked_at);
  unfinished_.clear();
  if (!is_over && !after_move) {
    for (const Mover& mover : movers_) {
      if (looked_at == nullptr || changed[mover.row]) unfinished_.push_back(mover.row);
    }
  }
  scratch_.free_since.Clear();
  scratch_.stances.Clear();
  scratch_.shoved.Clear();
  world_.near_->PutInOrder(world_.contacts_);
  touches_.AddSolved(impacts.impulses());
  if (after_move) AddVisits();
  Mark("impacts");
  if (!is_over && after_move) ResolveImpacts(h, elapsed, false, looked_at);
}

}  // namespace genphys

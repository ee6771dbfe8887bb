// The flight lane: bodies that nothing can meet in this step, moved by the layer alone, exactly and at once.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "genphys/limits.h"
#include "motion/free_rotation.h"
#include "pairs/near_pairs.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// Of c t: below it the closed form loses more digits than its series leaves out.
constexpr double kSmallDamping = 1e-3;

// Those go together whose mean velocity is so many times as large as what theirs differ from it.
constexpr double kTogether = 2;
// So many steps away they must be from what rests.
constexpr double kStepsFromRest = 16;

// Who would find more than so many others in its region would hardly ever be let fly: to look for them is dearer than
// to have the engine move it. Spread at random, none of so many is there for one of seven.
constexpr double kCrowd = 2;

// What becomes of a velocity that decays by exp(-c t) on top of a constant acceleration: after `time` s, `lag` is left
// of it, it took the body `way` (s) times as far as its start says, and the acceleration gave `way` of velocity and
// `fall` (s^2) of way. The integrals of exp(-c t), once and twice.
struct DampedFlight {
  DampedFlight(double damping, double time) : lag(1), way(time), fall(time * time / 2) {
    if (damping == 0) return;
    const double u = damping * time;
    lag = std::exp(-u);
    way = -std::expm1(-u) / damping;
    fall = u > kSmallDamping ? (time - way) / damping : time * time * (1.0 / 2 - u / 6 + u * u / 24 - u * u * u / 120);
  }
  double lag;
  double way;
  double fall;
};

}  // namespace

// m, half of that of its thinnest geometry.
double StepRun::ThicknessOf(const SceneEntity& entity) {
  double least = std::numeric_limits<double>::infinity();
  for (const Geometry& geometry : entity.desc->rigid_body->geometries) {
    least = std::min(least, SmallestHalfExtent(geometry.shape));
  }
  return least;
}

// Whether its way through this step has a closed form as long as nothing comes in between.
bool StepRun::MayFly(EntityRow row) const {
  if (!world_.layer_.half_steps[Index(row)].in_flight || scratch_.jointed[row]) return false;
  // An impulse may make it turn as fast as that.
  if (IsBlurred(state_.angular_velocities.col(Index(row)).norm(), step_size_)) return false;
  return !scratch_.steered[row] && world_.scene_.entities[Index(row)]->traits.is_free;
}

// Of those that move: a list may name many more, who sleep and are not to cost anything.
void StepRun::MarkListed(std::span<const EntityId> listed) {
  if (listed.size() <= rows_.size()) {
    for (const EntityId id : listed) scratch_.steered.Mark(EntityRow{id.index()});
    return;
  }
  for (const EntityRow row : rows_) {
    if (std::ranges::binary_search(listed, state_.ids[Index(row)])) scratch_.steered.Mark(row);
  }
}

// Forces that turn a body, or turn with it, or change in the step, leave its flight without a closed form, and so do
// force fields.
void StepRun::MarkSteered() {
  for (const EntityId id : field_reach_.tied) {
    if (!id.is_null()) scratch_.steered.Mark(EntityRow{id.index()});
  }
  for (const std::span<const EntityId> listed : field_reach_.listed) MarkListed(listed);
  for (const PendingForce& force : world_.layer_.forces) {
    if (!force.is_sampled && force.at_center_of_mass && force.coordinates == Coordinates::kWorld &&
        force.torque.isZero(0))
      continue;
    scratch_.steered.Mark(EntityRow{force.id.index()});
  }
}

// Whether it may come into a force field in this step.
bool StepRun::MayMeetField(EntityRow row, const Vector3& acceleration) const {
  if (field_reach_.regions.empty()) return false;
  const Bounds way = RegionOf(row, acceleration, Vector3::Zero());
  return std::ranges::any_of(field_reach_.regions, [&](const Bounds& region) { return region.Overlaps(way); });
}

// Where the body may be in this step, however it turns, as seen from what goes `drift` meanwhile; damping only leaves
// out some of the way.
Bounds StepRun::RegionOf(EntityRow row, const Vector3& acceleration, const Vector3& drift) const {
  const Vector3 start = CenterOf(row);
  const Vector3 coasted = step_size_ * state_.linear_velocities.col(Index(row)) - drift;
  const Vector3 fallen = step_size_ * step_size_ / 2 * acceleration;
  const Bounds way{start + coasted.cwiseMin(0) + fallen.cwiseMin(0), start + coasted.cwiseMax(0) + fallen.cwiseMax(0)};
  return way.Widened(world_.reaches_[Index(row)]);
}

// How fast all go together, m/s; zero: they do not.
Vector3 StepRun::CommonVelocity() const {
  if (rows_.empty()) return Vector3::Zero();
  Vector3 sum = Vector3::Zero();
  double squares = 0;
  for (const EntityRow row : rows_) {
    sum += state_.linear_velocities.col(Index(row));
    squares += state_.linear_velocities.col(Index(row)).squaredNorm();
  }
  const auto count = static_cast<double>(rows_.size());
  const Vector3 mean = sum / count;
  const double apart = squares / count - mean.squaredNorm();
  return mean.squaredNorm() > kTogether * kTogether * apart ? mean : Vector3::Zero();
}

// How far all go together in this step, if all may fly, far from what rests; else zero. Seen from what goes along they
// hardly move, however fast they fall. It follows from the state alone, as lanes do.
Vector3 StepRun::CommonWay() const {
  const Vector3 none = Vector3::Zero(), velocity = CommonVelocity();
  if (velocity.isZero(0) || !kinematic_rows_.empty()) return none;
  Bounds all{CenterOf(rows_.front()), CenterOf(rows_.front())};
  Vector3 gained = none;
  double margin = 0;
  for (const EntityRow row : rows_) {
    // What is damped falls behind within a step.
    if (!MayFly(row) || world_.scene_.entities[Index(row)]->traits.linear_damping != 0) return none;
    const Vector3 center = CenterOf(row), acceleration = SteadyPush(row).acceleration;
    all = all.Union({center, center});
    gained += step_size_ / static_cast<double>(rows_.size()) * acceleration;
    const double speed = state_.linear_velocities.col(Index(row)).norm() + step_size_ * acceleration.norm();
    margin = std::max(margin, world_.reaches_[Index(row)] + kStepsFromRest * step_size_ * speed);
  }
  all = all.Widened(margin);
  const bool fits = all.min.minCoeff() > -Limits::kPositionMax && all.max.maxCoeff() < Limits::kPositionMax;
  return fits && world_.near_->IsFreeOfResting(all) ? Vector3(step_size_ * (velocity + gained / 2)) : none;
}

// How many of those that move have a place or a way that meets a box, if they are spread evenly where they are. Each is
// as large as the mean of them, and all go `drift` besides.
class StepRun::Crowd {
 public:
  Crowd(const StepRun& run, const Vector3& drift) : others_(static_cast<double>(run.rows_.size()) - 1) {
    Bounds all{run.CenterOf(run.rows_.front()), run.CenterOf(run.rows_.front())};
    for (const EntityRow row : run.rows_) {
      const Vector3 center = run.CenterOf(row);
      const Vector3 way = run.step_size_ * run.state_.linear_velocities.col(Index(row)) - drift;
      all = all.Union({center, center});
      size_ += (way.cwiseAbs().array() + 2 * run.world_.reaches_[Index(row)]).matrix();
    }
    size_ /= static_cast<double>(run.rows_.size());
    room_ = all.max - all.min + size_;
  }

  double Around(const Bounds& box) const {
    return others_ * (box.max - box.min + size_).cwiseQuotient(room_).cwiseMin(1).prod();
  }

 private:
  double others_;
  Vector3 size_ = Vector3::Zero();  // m
  Vector3 room_;                    // m
};

// Those that may fly, with room for their ways as seen from what goes `drift` in this step.
void StepRun::ReserveFlyers(const Vector3& drift) {
  const auto within = [](const Vector3& v, double bound) { return (v.array().abs() < bound).all(); };
  flyers_.clear();
  scratch_.flies.Clear();
  std::optional<Crowd> crowd;
  for (const EntityRow row : rows_) {
    if (!MayFly(row)) continue;
    const Flyer flyer{row, SteadyPush(row).acceleration};
    if (MayMeetField(row, flyer.acceleration)) continue;
    const Bounds region = RegionOf(row, flyer.acceleration, drift);
    const Vector3 end = state_.linear_velocities.col(Index(row)) + step_size_ * flyer.acceleration;
    // Who may leave the world's bounds is looked after by the engine's lane.
    if (!within(region.min, Limits::kPositionMax) || !within(region.max, Limits::kPositionMax) ||
        !within(end, Limits::kSpeedMax)) {
      continue;
    }
    // Who goes less far than it is wide finds hardly more than what the engine has to look at as well.
    if ((region.max - region.min).maxCoeff() > 4 * world_.reaches_[Index(row)]) {
      if (!crowd) crowd.emplace(*this, drift);
      if (crowd->Around(region) > kCrowd) continue;
    }
    flyers_.push_back(flyer);
    scratch_.flies.Mark(row);
    const bool is_first = !std::exchange(world_.flown_[Index(row)], true);
    world_.near_->Reserve(world_.geometry_rows_[Index(row)], region, is_first);
  }
}

// Whether all go on together until the end of the step.
bool StepRun::Drift() {
  const Vector3 drift = CommonWay();
  if (drift.isZero(0)) return false;
  world_.near_->BeginDrift(drift);
  ReserveFlyers(drift);
  GroundThoseThatMeet();
  return flyers_.size() == rows_.size();
}

// Sorts rows_ into those that fly and those that the engine has to move.
void StepRun::ChooseFlyers() {
  field_reach_ = fields_.reach();
  if (!field_reach_.is_everywhere && !world_.scene_.world.stepper.engine_only) {
    MarkSteered();
    if (!Drift()) {
      world_.near_->Settle();
      ReserveFlyers(Vector3::Zero());
      GroundThoseThatMeet();
    }
  } else {
    world_.near_->Settle();
  }
  std::erase_if(rows_, [&](EntityRow row) { return scratch_.flies[row]; });
  // Nothing is near them, which is as good as a test.
  for (const Flyer& flyer : flyers_) scratch_.tested.Mark(flyer.row);
  for (EntityRow row : rows_) {
    if (world_.flown_[Index(row)]) world_.TellPose(row);
  }
}

// Two whose regions overlap may meet, and so may a flyer and what is in its region.
void StepRun::GroundThoseThatMeet() {
  if (flyers_.empty()) return;
  std::vector<EntityRow> met;
  for (const NearPairs::Pair& pair : world_.near_->Update(world_.rule_)) {
    const bool flies_a = scratch_.flies[pair.entity_a], flies_b = scratch_.flies[pair.entity_b];
    if (!(flies_a || flies_b) || !world_.near_->MayTouch(pair)) continue;
    if (flies_a) met.push_back(pair.entity_a);
    if (flies_b) met.push_back(pair.entity_b);
  }
  for (EntityRow row : met) scratch_.flies.Unmark(row);
  ForgetGrounded();
}

void StepRun::ForgetGrounded() {
  std::erase_if(flyers_, [&](const Flyer& flyer) { return !scratch_.flies[flyer.row]; });
}

// What the engine moved came into the region of a flyer: this goes on in the engine's lane, from where it is after
// `elapsed` seconds of the step.
void StepRun::GroundMet(double elapsed) {
  if (flyers_.empty()) return;
  bool is_any = true, was_any = false;
  while (is_any) {
    is_any = false;
    for (const NearPairs::Pair& pair : world_.near_->Update(world_.rule_)) {
      const bool flies_a = scratch_.flies[pair.entity_a], flies_b = scratch_.flies[pair.entity_b];
      if (flies_a == flies_b || !world_.near_->MayTouch(pair)) continue;
      Ground(flies_a ? pair.entity_a : pair.entity_b, elapsed);
      is_any = was_any = true;
    }
  }
  if (was_any) ForgetGrounded();
}

// So does who flies where one of `flown` went in the substep of `h` seconds, wherever that is by now: what only a solve
// or an impact sped up, nobody could look ahead for. Whether there was any; its way is added to `flown` and to `ways`,
// which may be the same.
bool StepRun::GroundPassed(const Swept& swept, double h, double elapsed, std::vector<FlownWay>& flown,
                           std::vector<FlownWay>& ways) {
  if (swept.flyers.empty()) return false;
  const auto add = [](const FlownWay& way, std::vector<FlownWay>& all) {
    all.insert(std::ranges::lower_bound(all, way.row, {}, &FlownWay::row), way);
  };
  for (const EntityRow row : swept.flyers) {
    Ground(row, elapsed);
    const FlownWay way{row, movers_.back().start, h};
    add(way, flown);
    if (&ways != &flown) add(way, ways);
  }
  ForgetGrounded();
  CollideAndWake(&swept.flyers);
  return true;
}

// From now on it is one of the movers, as if it had been one since the step began.
void StepRun::Ground(EntityRow row, double elapsed) {
  const auto flyer = std::ranges::lower_bound(flyers_, row, {}, &Flyer::row);
  scratch_.flies.Unmark(row);
  rows_.insert(std::lower_bound(rows_.begin(), rows_.end(), row), row);
  undo_.Keep(row);
  Mover& mover = movers_.emplace_back();
  StartMover(row, mover);
  const double before = std::max(elapsed - substep_, 0.0);
  if (before > 0) {
    Fly(*flyer, before);
    mover.start = state_.pose(row);
  }
  Fly(*flyer, elapsed - before);
  world_.TellPose(row);
}

void StepRun::Fly(const Flyer& flyer, double time) {
  const uint32_t row = Index(flyer.row);
  const SceneEntity& entity = *world_.scene_.entities[row];
  const MassProperties& mass = entity.mass;
  const DampedFlight linear(entity.traits.linear_damping, time), angular(entity.traits.angular_damping, time);
  Pose pose = state_.pose(flyer.row);
  const Vector3 velocity = state_.linear_velocities.col(row), spin = state_.angular_velocities.col(row);
  pose.position += linear.way * velocity + linear.fall * flyer.acceleration;
  state_.linear_velocities.col(row) = linear.lag * velocity + linear.way * flyer.acceleration;
  if (!spin.isZero(0)) {
    const Quaternion before = pose.orientation;
    // Momentum that decays turns the body as far as all of it would in a shorter time.
    if (mass.spherical) {
      pose.orientation = Turned(before, spin, angular.way);
      state_.angular_velocities.col(row) = angular.lag * spin;
    } else {
      const FreeRotation free(before, spin, mass, angular.way);
      pose.orientation = free.orientation;
      state_.angular_velocities.col(row) = angular.lag * free.spin;
    }
    pose.position += before * mass.center_of_mass - pose.orientation * mass.center_of_mass;
  }
  state_.set_pose(flyer.row, pose);
  HalfStep& half = world_.layer_.half_steps[row];
  if (!half.restarts || half.has_past) half.Forget();
}

// Those that nobody met, to the end of the step.
void StepRun::FinishFlight() {
  for (const Flyer& flyer : flyers_) {
    const uint32_t row = Index(flyer.row);
    const SceneEntity& entity = *world_.scene_.entities[row];
    const Vector3 before = state_.linear_velocities.col(row);
    const double damping = entity.traits.angular_damping;
    // Nothing but damping turns it, and takes this part of what there was: of what is left it may be more than can be
    // told.
    state_.net_torques.col(row).setZero();
    if (damping > 0) {
      const Matrix3 tensor = WorldTensor(state_.pose(flyer.row).orientation, entity.mass.tensor);
      state_.net_torques.col(row) =
          std::expm1(-damping * step_size_) / step_size_ * (tensor * state_.angular_velocities.col(row));
    }
    Fly(flyer, step_size_);
    NoteTurn(flyer.row, flyer.acceleration);
    state_.net_forces.col(row) = entity.mass.mass / step_size_ * (state_.linear_velocities.col(row) - before);
  }
  world_.near_->EndDrift();
  Mark("flight");
}

}  // namespace genphys

// Friction that turns within a substep. A solve gives one impulse for all of it, against the slip at its end or its
// middle: what slides up a slope and back down again would be braked one way for the whole of the substep in which it
// turns. So how a slip goes on is looked at before the solve. Friction of the time until it turns is given by what
// pressed in the last solve, and the solve is left the rest. What only stops the solve stops as well, but the way until
// then is not that at the velocity of the middle.
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "motion/free_rotation.h"
#include "pairs/contact_points.h"
#include "step/slide.h"
#include "step/step_foretold.h"

namespace genphys {
namespace {

// Of the speed that what pulls at it gives in a substep, and m/s: what slips more slowly than both trembles.
constexpr double kTremblePart = 1e-3;
constexpr double kTremble = 1e-6;
// Of that speed again: what slips more slowly does so only if friction gave at least this part of what it can.
constexpr double kSlides = 0.05;
constexpr double kBrakes = 0.5;
// The sine of the angle from which on a slip turns. What turns by less is braked against it by the solve.
constexpr double kTurns = 0.02;
// Of the slip of their middle: points that slip otherwise by more turn about each other.
constexpr double kTogether = 0.05;
// Of the acceleration that friction alone would give: what has less is held.
constexpr double kHeld = 1e-3;
// So many points or more lie beside each other, and what stands on them does not roll.
constexpr uint32_t kPatch = 3;

}  // namespace

class StepRun::Turns : Foretold {
 public:
  using Foretold::Foretold;

  // Velocities are those from which the next solve goes on.
  void Find() {
    if (last_ == 0) return;
    for (const ContactPair& pair : run_.world_.contacts_.pairs) {
      if (pair.is_sensor || pair.material.friction == 0 || !SlipsAsOne(pair) || !IsKnown(pair)) continue;
      change_ = ChangeOf(pair);
      const double until = time_ + h_ / 2;
      if (Angle(slip_, slip_ + until * change_) <= kTurns) continue;
      const ContactPair* before = run_.SolvedBefore(pair);
      if (before == nullptr) continue;
      Measure(pair, *before);
      if (slip_.norm() <= kSlides * pull_ * h_ && braked_.norm() < kBrakes * brake_) continue;
      const double mobility = Mobility(pair);
      if (mobility * brake_ > 0) Follow(pair, mobility);
    }
    ForgetPairs();
  }

 private:
  // Whether all its points slip the same way, and by more than they tremble.
  bool SlipsAsOne(const ContactPair& pair) {
    const auto pull = [&](EntityRow row) -> double {
      return run_.IsMoved(row) ? std::as_const(run_.scratch_.accelerations)[row].norm() : 0;
    };
    pull_ = std::max(pull(pair.entity_a), pull(pair.entity_b));
    const double tremble = std::max(kTremble, kTremblePart * pull_ * h_);
    const std::span<const ContactPoint> points = PointsOf(pair);
    const ContactPoint& first = points.front();
    const Vector3 at_first = VelocityAt(pair, pair.entity_b, first.position) -
                             VelocityAt(pair, pair.entity_a, first.position) + pair.surface_velocity;
    slip_ = Across(at_first, first.normal);
    const double square = slip_.squaredNorm();
    if (!(square > tremble * tremble)) return false;
    const Vector3 spin = run_.state_.angular_velocities.col(Index(pair.entity_b)) -
                         run_.state_.angular_velocities.col(Index(pair.entity_a));
    return std::all_of(points.begin() + 1, points.end(), [&](const ContactPoint& point) {
      const Vector3 slip = at_first + spin.cross(point.position - first.position);
      return (Across(slip, point.normal) - slip_).squaredNorm() <= kTogether * kTogether * square;
    });
  }

  // As the time begins that the next solve is for. What is led shows how it goes in the middle of the coming substep.
  Vector3 VelocityAt(const ContactPair& pair, EntityRow row, const Vector3& point) const {
    const Vector3 now = run_.VelocityAt(row, run_.CenterOf(row), point);
    if (run_.IsMoved(row) || run_.courses_.empty()) return now;
    return now - run_.IntervalOf(pair, h_) * LedRateAt(row, point);
  }

  // m/s^2, of what is led.
  Vector3 LedRateAt(EntityRow row, const Vector3& point) const {
    const Courses::Faster faster = run_.courses_.ChangeOf(row, h_, false);
    return (faster.linear + faster.angular.cross(point - run_.CenterOf(row))) / h_;
  }

  // How the slip changes then (m/s^2). What stands on a face does not tip, whatever noise its torques have.
  Vector3 ChangeOf(const ContactPair& pair) const {
    const ContactPoint& point = PointsOf(pair).front();
    const auto gain = [&](EntityRow row) -> Vector3 {
      if (!run_.IsMoved(row)) return LedRateAt(row, point.position);
      if (pair.point_count >= kPatch) return RateOf(row);
      return RateOf(row) + TurnRateOf(row).cross(point.position - run_.CenterOf(row));
    };
    return Across(gain(pair.entity_b) - gain(pair.entity_a), point.normal);
  }

  // How hard both are pressed, and what friction gave them.
  void Measure(const ContactPair& pair, const ContactPair& before) {
    const double kinetic = pair.material.kinetic_friction;
    double press = 0;
    bool has_slid = slip_.norm() > kSlidingSpeed;
    braked_.setZero();
    solved_ = genphys::PointsOf(run_.world_.solved_, before);
    for (const ContactPoint& last : solved_) {
      press += last.normal_impulse / last_;
      braked_ += last.friction_impulse / last_;
      has_slid |= last.friction == kinetic;
    }
    brake_ = has_slid ? kinetic * press : 0;
  }

  // m/s^2 along the slip, by which a force of 1 N on both changes it.
  double Mobility(const ContactPair& pair) const {
    const ContactPoint& point = PointsOf(pair).front();
    const Vector3 along = slip_.normalized();
    double mobility = 0;
    for (const EntityRow row : {pair.entity_a, pair.entity_b}) {
      const MassProperties& mass = run_.world_.scene_.entities[Index(row)]->mass;
      // What friction does not speed up is held by others.
      if (!run_.IsMoved(row) || std::abs(RateOf(row).dot(along)) < kHeld * brake_ / mass.mass) continue;
      mobility += 1 / mass.mass;
      if (pair.point_count >= kPatch) continue;
      const Vector3 arm = (point.position - run_.CenterOf(row)).cross(along);
      mobility += arm.dot(InverseOf(row) * arm);
    }
    return mobility;
  }

  void Follow(const ContactPair& pair, double mobility) {
    const double grip = pair.material.friction / pair.material.kinetic_friction;
    const Vector3 drive = change_ - mobility * Across(braked_, PointsOf(pair).front().normal);
    const std::optional<EntityRow> alone = pair.point_count < kPatch ? std::nullopt : StandingAlone(pair);
    // What others change too is only looked at where it slips straight back.
    const bool may_turn_back =
        drive.norm() > mobility * brake_ * grip && drive.dot(slip_) < 0 && Angle(slip_, -drive) <= kTurns;
    if ((!alone && !may_turn_back) || !FindShares(pair)) return;
    Slide slide(slip_, drive, mobility * brake_, mobility * brake_ * grip);
    // The way of a substep begins in the middle of the time that the solve is for, or with it if all begins anew.
    slide.GoOn(time_ - h_ / 2);
    const Vector3 from = slide.way();
    slide.GoOn(h_ / 2);
    const Slide middle = slide;
    slide.GoOn(h_ / 2);
    const bool turns_back = middle.has_stopped() && middle.is_driven();
    const bool turns = turns_back || (!middle.has_stopped() && Angle(slip_, middle.slip()) > kTurns);
    if (turns_back || (alone && (turns || slide.has_stopped()))) {
      FrictionTurn turn{.a = pair.entity_a, .b = pair.entity_b, .is_on_face = pair.point_count >= kPatch};
      if (turns) {
        turn.given = -brake_ * middle.led();
        turn.rest = turns_back ? 1 - middle.stopped_after() / time_ : 0;
        turn.slip_change = middle.slip() - slip_;
      }
      turn.friction = pair.material.kinetic_friction;
      if (alone) turn.since = 2 / mobility * (slide.braked() - middle.braked());
      Tell(pair, turn, alone);
    }
    if (!alone || !(turns || slide.has_stopped())) return;
    const Vector3 way = slide.way() - from - h_ * middle.slip();
    run_.scratch_.shifts.push_back({.row = *alone, .way = *alone == pair.entity_b ? way : Vector3(-way)});
  }

  // Shares what is of the whole pair.
  void Tell(const ContactPair& pair, const FrictionTurn& whole, std::optional<EntityRow> alone) {
    const Vector3 beside = alone ? BesideFoot(pair, *alone) : Vector3::Zero();
    for (uint32_t i = 0; i < pair.point_count; ++i) {
      FrictionTurn& turn = run_.scratch_.turns.emplace_back(whole);
      turn.point = pair.first_point + i;
      turn.at = PointsOf(pair)[i].position - beside;
      turn.given *= pressed_[i];
      if (turn.since) *turn.since *= pressed_[i];
    }
  }

  // From below its centre of mass to where it is pressed on the mean: this goes ahead of it the way it slips, for it is
  // braked below its centre, so that friction does not turn it about the normal. As it was in the last solve it is not
  // yet that of a slip that turns.
  Vector3 BesideFoot(const ContactPair& pair, EntityRow row) const {
    const std::span<const ContactPoint> points = PointsOf(pair);
    const Vector3 center = run_.CenterOf(row);
    Vector3 sum = Vector3::Zero();
    for (uint32_t i = 0; i < pair.point_count; ++i) sum += pressed_[i] * (points[i].position - center);
    return Across(sum, points.front().normal);
  }

  // Of the pair at hand.
  double pull_ = 0;                   // m/s^2, of what pulls at them from outside
  Vector3 slip_ = Vector3::Zero();    // m/s
  Vector3 change_ = Vector3::Zero();  // m/s^2
  double brake_ = 0;                  // N, as much as friction can give
  Vector3 braked_ = Vector3::Zero();  // N, on b, by friction
};

void StepRun::FindTurns(double h) {
  scratch_.turns.clear();
  scratch_.shifts.clear();
  Turns(*this, h).Find();
}

// On top of what else acts before the solve.
void StepRun::GiveTurns() {
  for (FrictionTurn& turn : scratch_.turns) {
    ContactPoint& point = world_.contacts_.points[turn.point];
    if (turn.rest == 1) continue;
    point.friction = turn.rest * turn.friction;
    KickTurned(turn, turn.a);
    KickTurned(turn, turn.b);
  }
}

void StepRun::KickTurned(const FrictionTurn& turn, EntityRow row) {
  if (!IsMoved(row)) return;
  const MassProperties& mass = world_.scene_.entities[Index(row)]->mass;
  const Vector3 given = row == turn.b ? turn.given : Vector3(-turn.given);
  const Vector3 twist = (turn.at - CenterOf(row)).cross(given);
  state_.linear_velocities.col(Index(row)) += given / mass.mass;
  state_.angular_velocities.col(Index(row)) += WorldTensor(state_.pose(row).orientation, mass.inverse_tensor) * twist;
}

// What friction gave in all. What is owed from the middle of the substep on is as it is since it turned.
void StepRun::TakeTurns(double h) {
  for (FrictionTurn& turn : scratch_.turns) {
    ContactPoint& point = world_.contacts_.points[turn.point];
    if (turn.rest < 1) point.friction = turn.friction;
    const Vector3 solved = std::exchange(point.friction_impulse, point.friction_impulse + turn.given);
    for (const auto& [row, sign] : {std::pair(turn.a, -1.0), std::pair(turn.b, 1.0)}) {
      if (!IsMoved(row)) continue;
      const double scale = h / world_.layer_.half_steps[Index(row)].Interval(world_.layer_.last_substep, h);
      if (!turn.since) turn.since = scale / turn.rest * solved;
      const Vector3 more = sign * kOwed * (*turn.since - scale * point.friction_impulse);
      const Vector3 twist = (turn.at - CenterOf(row)).cross(more);
      Wrench& uneven = scratch_.uneven[row];
      uneven.force += more;
      // What stands on a face does not tip: what presses it holds up.
      uneven.torque += turn.is_on_face ? Vector3(twist.dot(point.normal) * point.normal) : twist;
    }
  }
}

// What this solve did at the points of which only that is kept from here on with which they go on.
void StepRun::NoteTurned() {
  ContactBuffer& contacts = world_.contacts_;
  std::vector<uint32_t> numbers;
  for (const FrictionTurn& turn : scratch_.turns) numbers.push_back(turn.point);
  for (const RollTurn& turn : scratch_.rolls) {
    const ContactPair& pair = contacts.pairs[turn.pair];
    for (uint32_t i = 0; i < pair.point_count; ++i) numbers.push_back(pair.first_point + i);
  }
  std::ranges::sort(numbers);
  const auto twice = std::ranges::unique(numbers);
  numbers.erase(twice.begin(), twice.end());
  contacts.turned.clear();
  for (const uint32_t number : numbers) {
    const ContactPoint& point = contacts.points[number];
    contacts.turned.push_back({number, point.friction_impulse, point.relative_velocity});
  }
}

// As it goes on from there.
void StepRun::KeepTurns() {
  for (const FrictionTurn& turn : scratch_.turns) {
    ContactPoint& point = world_.contacts_.points[turn.point];
    if (turn.since) point.friction_impulse = *turn.since;
    point.relative_velocity += turn.slip_change;
  }
}

// Where it is after a substep at the middle of which it slipped otherwise than on the mean.
void StepRun::ShiftTurned() {
  if (scratch_.shifts.empty()) return;
  std::vector<EntityRow> moved;
  for (const TurnShift& shift : scratch_.shifts) {
    // Forces may have thrown it out of the bounds of the world.
    if (!IsMoved(shift.row)) continue;
    if (!shift.turn.isZero(0)) {
      const Pose pose = state_.pose(shift.row);
      const Vector3 center = CenterOf(shift.row);
      const Quaternion turned = Turned(pose.orientation, shift.turn, 1);
      const Vector3& own = world_.scene_.entities[Index(shift.row)]->mass.center_of_mass;
      state_.set_pose(shift.row, {center - turned * own, turned});
    }
    state_.positions.col(Index(shift.row)) += shift.way;
    moved.push_back(shift.row);
  }
  world_.engine_->WriteState(moved, state_);
}

}  // namespace genphys

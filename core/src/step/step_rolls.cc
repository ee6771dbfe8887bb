// Resistance to rolling that turns within a substep. As with friction (step_turns.cc) one solve gives one torque for
// all of it: what rolls up a slope and back down again would be braked one way for the whole of the substep in which it
// turns. So how it rolls on is looked at before the solve, and what resists until it turns is given there. What brakes
// a spin changes at the same time what friction gives, if that keeps it from slipping.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "motion/free_rotation.h"
#include "step/slide.h"
#include "step/step_foretold.h"

namespace genphys {
namespace {

// Of the spin that what changes it gives in a substep, and rad/s: what turns more slowly than both trembles.
constexpr double kTremblePart = 1e-3;
constexpr double kTremble = 1e-6;
// Of that spin again: what turns more slowly rolls only if at least this part of what can resist did.
constexpr double kRolls = 0.05;
constexpr double kBrakes = 0.5;
// The sine of the angle from which on a rolling turns. What turns by less is braked against it by the solve: that knows
// how it goes in the middle only of what rolls so many times as fast as what resists slows it down in a substep.
constexpr double kTurns = 0.02;
constexpr double kTurnsSlowly = 1e-4;
constexpr double kFast = 6;
// Of what it can give: friction that gave less held.
constexpr double kHolds = 0.99;
// So many points or more lie beside each other, and what stands on them does not roll.
constexpr uint32_t kPatch = 3;

}  // namespace

class StepRun::Rolls : Foretold {
 public:
  using Foretold::Foretold;

  void Find() {
    if (last_ == 0) return;
    const std::vector<ContactPair>& pairs = run_.world_.contacts_.pairs;
    for (size_t i = 0; i < pairs.size(); ++i) {
      const ContactPair& pair = pairs[i];
      if (pair.is_sensor || pair.material.rolling_friction == 0 || pair.point_count >= kPatch) continue;
      if (run_.IsMoved(pair.entity_a) == run_.IsMoved(pair.entity_b) || !IsKnown(pair)) continue;
      const ContactPair* const before = run_.SolvedBefore(pair);
      if (before == nullptr) continue;
      solved_ = genphys::PointsOf(run_.world_.solved_, *before);
      if (!FindShares(pair)) continue;
      Measure(pair);
      if (DoesRoll() && StandingAlone(pair)) Follow(pair, static_cast<uint32_t>(i));
    }
    ForgetPairs();
  }

 private:
  // By a torque (N*m) across the surface, and what friction answers it with.
  struct Answer {
    Vector3 force = Vector3::Zero();   // N
    Vector3 linear = Vector3::Zero();  // m/s^2
    Vector3 spin = Vector3::Zero();    // rad/s^2
  };

  // What resisted it, and all that this takes.
  void Measure(const ContactPair& pair) {
    row_ = run_.IsMoved(pair.entity_a) ? pair.entity_a : pair.entity_b;
    const EntityRow other = row_ == pair.entity_a ? pair.entity_b : pair.entity_a;
    const double sign = row_ == pair.entity_b ? 1 : -1;
    const HalfStep& half = run_.world_.layer_.half_steps[Index(row_)];
    normal_ = PointsOf(pair).front().normal;
    at_.setZero();
    for (uint32_t i = 0; i < pair.point_count; ++i) at_ += pressed_[i] * PointsOf(pair)[i].position;
    const Vector3 center = run_.CenterOf(row_) - last_ * half.velocity;  // where the last substep began
    double press = 0, rubbed = 0, most = 0;
    Vector3 torque = half.held_torque;
    for (const ContactPoint& last : solved_) {
      const Vector3 impulse = last.normal_impulse * last.normal + last.friction_impulse;
      torque -= sign / last_ * (last.position - center).cross(impulse);
      press += last.normal_impulse / last_;
      rubbed += last.friction_impulse.norm() / last_;
      most += last.friction * last.normal_impulse / last_;
    }
    holds_ = rubbed < kHolds * most;
    braked_ = Across(torque, normal_);
    brake_ = pair.material.rolling_friction * press;
    inverse_ = InverseOf(row_);
    const Courses::Faster faster = run_.courses_.ChangeOf(other, h_, false);
    const Vector3 led = time_ / h_ * faster.angular;
    spin_ = Across(
        run_.state_.angular_velocities.col(Index(row_)) - (run_.state_.angular_velocities.col(Index(other)) - led),
        normal_);
    const Vector3 turning = inverse_ * Vector3(run_.state_.angular_velocities.col(Index(row_))).cross(half.momentum);
    change_ = Across(TurnRateOf(row_) - turning - faster.angular / h_, normal_);
  }

  // Whether it does, and faster than it trembles.
  bool DoesRoll() {
    const double speed = spin_.norm();
    if (!(speed > kTremble) || !(brake_ > 0)) return false;
    const Vector3 along = spin_ / speed;
    gain_ = AnswerTo(along).spin.dot(along);
    if (!(gain_ > 0)) return false;
    drive_ = change_ - gain_ * braked_;
    const double soon = (drive_.norm() + gain_ * brake_) * h_;
    return speed > kTremblePart * soon && (speed > kRolls * soon || braked_.norm() >= kBrakes * brake_);
  }

  Answer AnswerTo(const Vector3& torque) const {
    const double mass = run_.world_.scene_.entities[Index(row_)]->mass.mass;
    Answer answer{.spin = inverse_ * torque};
    if (!holds_) return answer;
    const Vector3 arm = at_ - run_.CenterOf(row_);
    Eigen::Matrix<double, 3, 2> across;
    across.col(0) = normal_.unitOrthogonal();
    across.col(1) = normal_.cross(across.col(0));
    Eigen::Matrix2d mobility;
    for (int i = 0; i < 2; ++i) {
      const Vector3 force = across.col(i), spun = inverse_ * arm.cross(force);
      mobility.col(i) = across.transpose() * (force / mass + spun.cross(arm));
    }
    const Eigen::Vector2d slip = across.transpose() * answer.spin.cross(arm);
    answer.force = -across * mobility.ldlt().solve(slip);
    answer.linear = answer.force / mass;
    answer.spin += inverse_ * arm.cross(answer.force);
    return answer;
  }

  // Velocities and torques are those of the one that rolls, however the pair has it.
  void Follow(const ContactPair& pair, uint32_t number) {
    const double slowed = (inverse_ * spin_.normalized()).norm() * brake_ * time_;
    const double turns_from = spin_.norm() > kFast * slowed ? kTurns : kTurnsSlowly;
    Slide slide(spin_, drive_, gain_ * brake_, gain_ * brake_);
    slide.GoOn(time_ - h_ / 2);
    const Vector3 from = slide.way();
    slide.GoOn(h_ / 2);
    const Slide middle = slide;
    slide.GoOn(h_ / 2);
    const bool turns_back = middle.has_stopped() && middle.is_driven();
    const bool turns = turns_back || (!middle.has_stopped() && Angle(spin_, middle.slip()) > turns_from);
    if (!turns && !slide.has_stopped()) return;
    RollTurn& turn = run_.scratch_.rolls.emplace_back();
    turn.pair = number;
    turn.row = row_;
    turn.friction = pair.material.rolling_friction;
    if (turns) {
      turn.given = -brake_ * middle.led();
      turn.rest = turns_back ? 1 - middle.stopped_after() / time_ : 0;
    }
    const Vector3 more = (2 * (slide.braked() - middle.braked()) - h_ / time_ * middle.braked()) / gain_;
    const Answer owed = AnswerTo(more);
    turn.more = {owed.force, more + (at_ - run_.CenterOf(row_)).cross(owed.force)};
    turn.sign = row_ == pair.entity_b ? 1 : -1;
    const Answer way = AnswerTo((slide.way() - from - h_ * middle.slip()) / gain_);
    run_.scratch_.shifts.push_back({.row = row_, .way = way.linear, .turn = way.spin});
  }

  // Of the pair at hand, and of the one that moves.
  EntityRow row_{};
  Vector3 normal_ = Vector3::UnitZ();
  Vector3 at_ = Vector3::Zero();  // m, where it is pressed on the mean
  Matrix3 inverse_ = Matrix3::Zero();
  Vector3 spin_ = Vector3::Zero();    // rad/s, across the normal
  Vector3 change_ = Vector3::Zero();  // rad/s^2
  Vector3 drive_ = Vector3::Zero();   // rad/s^2, were nothing to resist
  double gain_ = 0;                   // rad/s^2 per N*m
  double brake_ = 0;                  // N*m, as much as can resist
  Vector3 braked_ = Vector3::Zero();  // N*m, by what resisted
  bool holds_ = false;                // friction keeps it from slipping
};

void StepRun::FindRolls(double h) {
  scratch_.rolls.clear();
  Rolls(*this, h).Find();
}

void StepRun::GiveRolls() {
  for (const RollTurn& turn : scratch_.rolls) {
    if (turn.rest == 1) continue;
    world_.contacts_.pairs[turn.pair].material.rolling_friction = turn.rest * turn.friction;
    KickRolled(turn);
  }
}

void StepRun::KickRolled(const RollTurn& turn) {
  if (!IsMoved(turn.row)) return;
  const MassProperties& mass = world_.scene_.entities[Index(turn.row)]->mass;
  state_.angular_velocities.col(Index(turn.row)) +=
      WorldTensor(state_.pose(turn.row).orientation, mass.inverse_tensor) * turn.given;
}

// What resisted in all. What is owed from the middle of the substep on is as it is since it turned.
void StepRun::TakeRolls() {
  for (const RollTurn& turn : scratch_.rolls) {
    world_.contacts_.pairs[turn.pair].material.rolling_friction = turn.friction;
    if (!IsMoved(turn.row)) continue;
    Wrench& uneven = scratch_.uneven[turn.row];
    uneven.force += kOwed * turn.more.force;
    uneven.torque += kOwed * turn.more.torque;
  }
}

// As friction goes on from there.
void StepRun::KeepRolls() {
  for (const RollTurn& turn : scratch_.rolls) {
    const ContactPair& pair = world_.contacts_.pairs[turn.pair];
    const std::span<ContactPoint> points =
        std::span(world_.contacts_.points).subspan(pair.first_point, pair.point_count);
    double press = 0;
    for (const ContactPoint& point : points) press += point.normal_impulse;
    if (!(press > 0)) continue;
    for (ContactPoint& point : points) {
      point.friction_impulse += point.normal_impulse / press * turn.sign * turn.more.force;
    }
  }
}

}  // namespace genphys

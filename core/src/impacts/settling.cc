#include "impacts/settling.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace genphys {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

namespace {

// A part of what it would give way if nobody held it.
constexpr double kHeldFast = 1e-3;
// Of the product of how it gives way along each axis alone: below that the three are not independent enough to be
// divided by, as where locked axes hold a body.
constexpr double kIndependent = 1e-6;
// Of Coulomb's bound: as near as slipping is brought to it, and in how many looks at most.
constexpr double kNearBound = 1e-14;
constexpr int kLooksMax = 60;
// Of how the blow gives way: the least resistance, and by its inverse the most, from which the search begins.
constexpr double kLeastResistance = 1e-9;

}  // namespace

Along::Along(const Vector3& axis, const Blow& blow, std::span<const StruckBody> bodies, Ties& ties,
             std::vector<Passed>& passed)
    : axis_(Pad(axis)),
      a_(-axis, blow.position, bodies[blow.body_a]),
      b_(axis, blow.position, bodies[blow.body_b]),
      first_passed_(passed.size()),
      last_passed_(passed.size()) {
  if (!ties.With(blow.body_a).empty() || !ties.With(blow.body_b).empty()) Tie(axis, blow, ties, passed);
}

Along::Side::Side(const Vector3& push, const Vector3& position, const StruckBody& body)
    : lever(Pad((position - body.center).cross(push))),
      shift(Pad(body.inverse_mass * body.freedom.cwiseProduct(push))),
      turn(Pad(body.inverse_tensor * lever.head<3>())) {}

double Along::FreeAnswer(const StruckBody& a, const StruckBody& b) const {
  const auto turned = [](const Side& side, const StruckBody& body) {
    const Vector3 lever = side.lever.head<3>();
    return lever.dot(body.inverse_tensor * lever);
  };
  return a.inverse_mass + b.inverse_mass + turned(a_, a) + turned(b_, b);
}

void Along::Tie(const Vector3& axis, const Blow& blow, Ties& ties, std::vector<Passed>& passed) {
  std::vector<Ties::Push> pushes;
  const auto push = [&](uint32_t body, const Vector3& linear, Side& side) {
    if (ties.With(body).empty()) return;
    pushes.push_back({body, linear, side.lever.head<3>()});
    side.shift.setZero();
    side.turn.setZero();
  };
  push(blow.body_a, -axis, a_);
  push(blow.body_b, axis, b_);
  std::vector<Ties::Change> changes;
  ties.Pass(pushes, changes);
  for (const Ties::Change& change : changes) {
    const Padded shift = Pad(change.linear), turn = Pad(change.angular);
    if (change.body == blow.body_a || change.body == blow.body_b) {
      Side& side = change.body == blow.body_a ? a_ : b_;
      side.shift = shift;
      side.turn = turn;
    } else {
      passed.push_back({change.body, shift, turn});
    }
  }
  last_passed_ = passed.size();
}

Settling::Settling(Blow& blow, const Vector3& first, std::span<const StruckBody> bodies, Ties& ties,
                   std::vector<Passed>& passed)
    : blow_(&blow),
      first_(first),
      second_(blow.normal.cross(first)),
      along_{Along(blow.normal, blow, bodies, ties, passed), Along(first_, blow, bodies, ties, passed),
             Along(second_, blow, bodies, ties, passed)},
      run_(blow.run.dot(first_), blow.run.dot(second_)),
      impulse_(blow.impulse, blow.rubbing.dot(first_), blow.rubbing.dot(second_)),
      is_tied_(!ties.With(blow.body_a).empty() || !ties.With(blow.body_b).empty()) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) answers_(i, j) = along_[i].Answer(along_[j]);
  }
  softness_ = answers_(0, 0);
  if (is_tied_) {
    // What joints hold fast gives way by the softness of their rows alone, and that is no way.
    const double free = along_[0].FreeAnswer(bodies[blow.body_a], bodies[blow.body_b]);
    if (softness_ < kHeldFast * free) softness_ = 0;
  } else {
    bool is_free = false;
    answers_.computeInverseWithCheck(stopping_, is_free, kIndependent * answers_.diagonal().prod());
    is_locked_ = !is_free;
  }
}

void Settling::Finish() {
  blow_->impulse = impulse_[0];
  blow_->rubbing = impulse_[1] * first_ + impulse_[2] * second_;
}

void Settling::Push(int axis, double impulse, std::span<Speeds> speeds, std::span<const Passed> passed) const {
  along_[axis].Push(impulse, speeds[blow_->body_a], speeds[blow_->body_b]);
  if (is_tied_) along_[axis].PassOn(impulse, passed, speeds);
}

void Settling::Take(const Blow& solved, std::span<Speeds> speeds, std::span<const Passed> passed) {
  const Vector3 wanted(solved.impulse, solved.rubbing.dot(first_), solved.rubbing.dot(second_));
  Give(wanted - impulse_, speeds, passed);
}

void Settling::Leap(const Vector3& far, std::span<Speeds> speeds, std::span<const Passed> passed) {
  Vector3 wanted = impulse_ + far;
  wanted[0] = std::max(wanted[0], 0.0);
  const double bound = blow_->friction * wanted[0], size = wanted.tail<2>().norm();
  if (size > bound) wanted.tail<2>() *= bound / size;
  Give(wanted - impulse_, speeds, passed);
}

// All that the turn changes is reckoned from the rates at its begin, so that the bodies are read and written once.
double Settling::Relax(std::span<Speeds> speeds, std::span<const Passed> passed) {
  const Speeds &a = speeds[blow_->body_a], &b = speeds[blow_->body_b];
  const double rate = along_[0].Rate(a, b) - blow_->separation_speed;
  if (rate >= 0 && impulse_.isZero(0)) return 0;
  const double pressed = softness_ > 0 ? std::max(-rate / softness_, -impulse_[0]) : 0;
  Vector3 impulse(pressed, 0, 0);
  double changed = std::abs(pressed) * softness_;
  const double bound = blow_->friction * (impulse_[0] + pressed);
  if (bound > 0 || !impulse_.tail<2>().isZero(0)) {
    const Vector2 slip =
        Vector2(along_[1].Rate(a, b), along_[2].Rate(a, b)) + run_ + pressed * answers_.bottomLeftCorner<2, 1>();
    impulse.tail<2>() = Rubbed(slip, bound);
    changed = std::max(changed, (answers_.bottomRightCorner<2, 2>() * impulse.tail<2>()).cwiseAbs().maxCoeff());
  }
  Give(impulse, speeds, passed);
  return changed;
}

double Settling::Settle(std::span<Speeds> speeds, std::span<const Passed> passed) {
  if (is_tied_ || is_locked_) return Relax(speeds, passed);
  const Vector3 rates = Rates(speeds);
  if (rates[0] >= 0 && impulse_.isZero(0)) return 0;
  const Vector3 impulse = Settled(rates) - impulse_;
  Give(impulse, speeds, passed);
  return (answers_ * impulse).cwiseAbs().maxCoeff();
}

Vector3 Settling::Motion(std::span<const Speeds> speeds) const {
  const Speeds &a = speeds[blow_->body_a], &b = speeds[blow_->body_b];
  return {along_[0].Rate(a, b), along_[1].Rate(a, b), along_[2].Rate(a, b)};
}

Vector3 Settling::Rates(std::span<const Speeds> speeds) const {
  Vector3 rates = Motion(speeds);
  rates[0] -= blow_->separation_speed;
  rates.tail<2>() += run_;
  return rates;
}

// The impulse that leaves the blow as it is to be.
Vector3 Settling::Settled(const Vector3& rates) const {
  const Vector3 free = rates - answers_ * impulse_;
  if (free[0] >= 0) return Vector3::Zero();
  if (!(blow_->friction > 0)) return {-free[0] / softness_, 0, 0};
  const Vector3 stuck = -stopping_ * free;
  if (stuck[0] > 0 && stuck.tail<2>().norm() <= blow_->friction * stuck[0]) return stuck;
  return Slipped(free, rates.tail<2>().norm());
}

// The impulse with all of friction, which leaves a slip against it. The two are as much as a resistance times each
// other, which is looked for: from Newton's method between bounds, for the part that is left of Coulomb's bound, which
// is all but linear in it (as in the regions of trust of Moré and Sorensen, "Computing a trust region step", SIAM J.
// Sci. Stat. Comput. 4 (1983)). There is always one, for none at all leaves too much friction, and so much that nothing
// rubs leaves too little. `slip` is that of now, m/s, to begin from.
Vector3 Settling::Slipped(const Vector3& free, double slip) const {
  const Vector2 across = answers_.bottomLeftCorner<2, 1>(), free_slip = free.tail<2>();
  const double friction = blow_->friction;
  const double rubbing_now = impulse_.tail<2>().norm();
  const bool is_known = slip > 0 && rubbing_now > 0;
  const double guess = is_known ? slip / rubbing_now : free_slip.norm() * softness_ / (-free[0] * friction);
  double low = 0, high = std::numeric_limits<double>::infinity();
  double resistance = std::clamp(guess, kLeastResistance * softness_, softness_ / kLeastResistance);  // 1/kg
  Vector3 impulse;
  for (int look = 0; look < kLooksMax; ++look) {
    const Matrix2 yielding = (answers_.bottomRightCorner<2, 2>() + resistance * Matrix2::Identity()).inverse();
    const double softness = softness_ - across.dot(yielding * across);
    const double normal = (across.dot(yielding * free_slip) - free[0]) / softness;
    const Vector2 rubbing = -(yielding * (free_slip + normal * across));
    const double size = rubbing.norm();
    if (!(size > 0)) return {normal, 0, 0};
    const double left = friction * normal / size - 1;
    impulse << normal, (1 + left) * rubbing;
    if (std::abs(left) <= kNearBound) break;
    (left < 0 ? low : high) = resistance;
    // How all of these change with the resistance.
    const double normal_gain = across.dot(yielding * rubbing) / softness;
    const Vector2 gain = -(yielding * (rubbing + normal_gain * across));
    const double slope = friction / size * (normal_gain - normal * rubbing.dot(gain) / (size * size));
    const double next = resistance - left / slope;
    const bool is_between = next > low && next < high;
    resistance = is_between ? next : std::isfinite(high) ? (low + high) / 2 : 4 * resistance;
  }
  return impulse;
}

// By how much friction has to change that is bound by so much, N*s, to stop what slips so, or to come nearer to that.
Vector2 Settling::Rubbed(const Vector2& slip, double bound) const {
  const Vector2 present = impulse_.tail<2>();
  const double answer = slip.dot(answers_.bottomRightCorner<2, 2>() * slip);
  Vector2 wanted = present;
  if (answer > 0) wanted -= (slip.squaredNorm() / answer) * slip;
  const double size = wanted.squaredNorm();
  if (size > bound * bound) wanted *= bound / std::sqrt(size);
  return wanted - present;
}

// Its two bodies are read and written once.
void Settling::Give(const Vector3& impulse, std::span<Speeds> speeds, std::span<const Passed> passed) {
  impulse_ += impulse;
  Speeds a = speeds[blow_->body_a], b = speeds[blow_->body_b];
  for (int i = 0; i < 3; ++i) along_[i].Push(impulse[i], a, b);
  speeds[blow_->body_a] = a;
  speeds[blow_->body_b] = b;
  if (!is_tied_) return;
  for (int i = 0; i < 3; ++i) along_[i].PassOn(impulse[i], passed, speeds);
}

}  // namespace genphys

#include "motion/resistance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

namespace genphys {
namespace {

// The solution of m v' = -(linear + quadratic |v|) v after `h` seconds: its direction stays, and 1 / speed obeys a
// linear equation (the substitution of Bernoulli).
double SlowedSpeed(double speed, double mass, double linear, double quadratic, double h) {
  const double rate = linear / mass, bend = quadratic * speed / mass;
  return speed * std::exp(-rate * h) / (1 + bend * h * MeanLeft(rate * h));
}

// Of what turns a body no more than exp() of this with a minus is left then. Where less is taken the momentum of the
// middle leads it better than this does: a brick at 9 rad/s in 10 N*m*s, at 60 steps per second, is off by half as
// much.
constexpr double kMost = 2;

}  // namespace

double MeanLeft(double x) { return x > 0 ? -std::expm1(-x) / x : 1; }

Resistance::Resistance(double mass, const Matrix3& inverse_tensor, double linear_damping, double angular_damping)
    : mass_(mass), inverse_tensor_(inverse_tensor), linear_rate_(linear_damping), angular_rate_(angular_damping) {}

void Resistance::Add(const DragField& drag, double part) {
  angular_ += part * drag.angular;
  if (drag.quadratic > 0) {
    media_.push_back({part * drag.linear, part * drag.quadratic, drag.medium_velocity});
    return;
  }
  const double rate = part * drag.linear / mass_;
  linear_rate_ += rate;
  linear_flow_ += rate * drag.medium_velocity;
}

Motion Resistance::Slowed(double time, const Motion& before, const Motion& pushed, const Motion& given) const {
  return {SlowedVelocity(time, before.linear, pushed.linear + given.linear) - given.linear,
          SlowedMomentum(time, before.momentum, pushed.momentum + given.momentum) - given.momentum};
}

Resistance::Rate Resistance::At(const Vector3& velocity) const {
  Rate sum{linear_rate_, linear_flow_};
  for (const Medium& medium : media_) {
    const double speed = (velocity - medium.velocity).norm();
    const double rate = (medium.linear + medium.quadratic * speed) / mass_;
    sum.rate += rate;
    sum.flow += rate * medium.velocity;
  }
  return sum;
}

void Resistance::Slow(const Medium& medium, double time, Vector3& velocity) const {
  const Vector3 relative = velocity - medium.velocity;
  const double speed = relative.norm();
  if (speed > 0) {
    velocity += relative * (SlowedSpeed(speed, mass_, medium.linear, medium.quadratic, time) / speed - 1);
  }
}

// Each for half of the time, and then in the other order, so that none comes before the others (Strang, SIAM J. Numer.
// Anal. 5, 1968).
void Resistance::SlowInTurns(double time, Vector3& velocity) const {
  const auto slow_linearly = [&] {
    const double left = linear_rate_ * time / 2;
    velocity = std::exp(-left) * velocity + time / 2 * MeanLeft(left) * linear_flow_;
  };
  slow_linearly();
  for (size_t i = 0; i + 1 < media_.size(); ++i) Slow(media_[i], time / 2, velocity);
  Slow(media_.back(), time, velocity);
  for (size_t i = media_.size() - 1; i > 0; --i) Slow(media_[i - 1], time / 2, velocity);
  slow_linearly();
}

// The velocity at which all that resists is in balance with a push, and what resists there; nothing if nothing does.
// `resistance` is that at some guess.
std::optional<Resistance::Balance> Resistance::BalanceWith(const Vector3& acceleration, const Rate& resistance) const {
  constexpr int kRoundsMax = 50;
  constexpr double kFound = 1e-12;
  Balance found{(resistance.flow + acceleration) / resistance.rate, resistance.rate};
  // The mean of what resists at one guess and at the next is right at once where drag goes with the square of speed.
  for (int i = 0; i < kRoundsMax; ++i) {
    const Rate now = At(found.velocity);
    if (now.rate == 0) return std::nullopt;
    const double before = std::exchange(found.rate, std::sqrt(found.rate * now.rate));
    found.velocity = now.flow / now.rate + acceleration / found.rate;
    if (std::abs(found.rate - before) <= kFound * found.rate) break;
  }
  return found;
}

// In proportion to speed it is a linear equation. Else pushes and drag are taken in turns, unless more than this part
// of a velocity is taken in the time, where they would not find the balance of both: with 0.14 of it the speed is
// 0.26 % off, with 0.8 6 %.
Vector3 Resistance::SlowedVelocity(double time, const Vector3& before, const Vector3& pushed) const {
  constexpr double kMuch = 0.2;
  if (media_.empty()) {
    const double taken = linear_rate_ * time;
    return std::exp(-taken) * before + MeanLeft(taken) * (pushed + time * linear_flow_);
  }
  const Rate fast = At(before + pushed);
  if (fast.rate * time > kMuch) {
    if (const std::optional<Balance> balance = BalanceWith(pushed / time, fast)) {
      const double slows = std::max(balance->rate, At(before).rate);
      return balance->velocity + std::exp(-slows * time) * (before - balance->velocity);
    }
  }
  Vector3 velocity = before + pushed / 2;
  SlowInTurns(time, velocity);
  return velocity + pushed / 2;
}

// Of all three moments, as MeanSpin() does, unless one of them is much less than the others.
bool Resistance::StopsTurning(double time) const {
  return time * (angular_rate_ + angular_ / 4 * inverse_tensor_.trace()) > kMost;
}

// What turning changes of it comes evenly, and decays by the rate of each principal axis.
Vector3 Resistance::MeanSpin(double time, const Vector3& spin, const Vector3& freely) const {
  const double rate = std::max(spin.norm(), kMost / time);
  if (!(angular_ * inverse_tensor_.trace() > rate)) return freely;
  Eigen::SelfAdjointEigenSolver<Matrix3> principal;
  principal.computeDirect(inverse_tensor_);
  if (!(angular_ * principal.eigenvalues()[0] > rate)) return freely;
  Vector3 own = principal.eigenvectors().transpose() * (freely - spin);
  for (int i = 0; i < 3; ++i) own[i] *= MeanLeft(time / 2 * angular_ * principal.eigenvalues()[i]);
  return spin + principal.eigenvectors() * own;
}

// The solution of L' = torque - (damping + angular I^-1) L: along each principal axis by its own exponential.
Vector3 Resistance::SlowedMomentum(double time, const Vector3& before, const Vector3& pushed) const {
  if (angular_ == 0) {
    const double taken = angular_rate_ * time;
    return std::exp(-taken) * before + MeanLeft(taken) * pushed;
  }
  Eigen::SelfAdjointEigenSolver<Matrix3> principal;
  principal.computeDirect(inverse_tensor_);
  const Matrix3& axes = principal.eigenvectors();
  Vector3 own = axes.transpose() * before;
  const Vector3 push = axes.transpose() * pushed;
  for (int i = 0; i < 3; ++i) {
    const double taken = time * (angular_rate_ + angular_ * std::max(principal.eigenvalues()[i], 0.0));
    own[i] = std::exp(-taken) * own[i] + MeanLeft(taken) * push[i];
  }
  return axes * own;
}

}  // namespace genphys

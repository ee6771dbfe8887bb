#include "motion/free_rotation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace genphys {
namespace {

// Radians per inner step. It was chosen by what steps missed of the energy when nothing gave that back: with 0.25 up to
// 4e-5 in 10 s of 20 tumbling bodies at 1/60 s, with 0.12 up to 1.7e-4 in 1e5 steps of 30. Now it is how far a body
// turns about its momentum that errors add up in.
constexpr double kAngleMax = 0.1;
// The same where so many are not to be taken: fewer are, until each of them is as long as this. Twice that is still
// stable, and what steps miss is given back; with a turn of tens of radians in one the numbers would overflow.
constexpr double kAngleMost = 0.5;
// Turning less than this in a step, the spin changes by less than rounding can show in the orientation.
constexpr double kNegligibleAngle = 1e-8;
// Relative difference of moments that is no more than rounding.
constexpr double kSymmetric = 1e-14;
// Of the most that the energy could be: less than this is rounding.
constexpr double kSameEnergy = 4e-15;
// Of the momentum: steps that miss by more are too long for what is near to be found from there.
constexpr double kFarOff = 1e-2;
// The sine of an angle that is no more than rounding.
constexpr double kParallel = 1e-14;

Vector3 BodySpin(const Quaternion& orientation, const Vector3& momentum, const Matrix3& inverse_tensor) {
  return inverse_tensor * (orientation.conjugate() * momentum);
}

// What stays as it is while a body turns freely: how large its momentum is, and its energy. How often it turns over in
// a time depends on how far both are from those of a body that never does, and that may be less than what steps miss.
class Invariants {
 public:
  // Of `momentum` and `spin` in the axes of the body.
  Invariants(const Vector3& momentum, const Vector3& spin, const Matrix3& inverse_tensor)
      : square_(momentum.squaredNorm()),
        inverse_square_(1 / square_),
        energy_(momentum.dot(spin)),
        rounding_(kSameEnergy * inverse_tensor.trace() * square_) {}

  // The momentum nearest to `momentum`, which misses them by little and with which the body has the spin `spin`, that
  // has them again: to first order in what is lacking. Where steps were too long to be accurate only its size is put
  // back.
  Vector3 Of(const Vector3& momentum, const Vector3& spin) const {
    const double square = momentum.squaredNorm(), energy = momentum.dot(spin);
    const double larger = (1 - square * inverse_square_) / 2, mean = energy * inverse_square_;
    const double lacking = (energy_ - energy) / 2 - energy * larger;
    const double aside = momentum.cross(spin).squaredNorm();
    // Of what is near to an axis about which it turns evenly, rounding would move more than steps miss.
    if (std::abs(lacking) <= rounding_ || !(lacking * lacking < kFarOff * kFarOff * aside)) {
      return std::sqrt(square_ / square) * momentum;
    }
    const double uphill = lacking * square_ / aside;
    return (1 + larger - uphill * mean) * momentum + uphill * spin;
  }

  // The turn, rad, axes of the body, after which it sees its momentum as `wanted` and not as `apparent`, which is near.
  Vector3 TurnBetween(const Vector3& wanted, const Vector3& apparent) const {
    return inverse_square_ * wanted.cross(apparent);
  }

 private:
  double square_;
  double inverse_square_;
  double energy_;    // twice the kinetic one
  double rounding_;  // of the energy
};

// A free body in its own frame, where its momentum goes round by Euler's equations, dL/dt = L x w.
class TurningBody {
 public:
  TurningBody(const Vector3& momentum, const Matrix3& inverse_tensor)
      : inverse_tensor_(inverse_tensor),
        momentum_(momentum),
        spin_(inverse_tensor * momentum),
        invariants_(momentum, spin_, inverse_tensor) {}

  // The rotation vector, rad, by which it turns in `h` seconds: its momentum by the classical method of fourth order
  // of Runge and Kutta, and what its spin comes to by the expansion of Magnus, of fourth order too (Iserles and
  // Norsett, Phil. Trans. R. Soc. A 357, 1999), with the spin in the middle from both ends and their rates.
  Vector3 Advance(double h) {
    const Vector3 first = spin_;
    const Vector3 k1 = momentum_.cross(first);
    const Vector3 k2 = Rate(momentum_ + h / 2 * k1);
    const Vector3 k3 = Rate(momentum_ + h / 2 * k2);
    const Vector3 k4 = Rate(momentum_ + h * k3);
    const Vector3 before = momentum_;
    momentum_ += h / 6 * (k1 + 2 * (k2 + k3) + k4);
    spin_ = inverse_tensor_ * momentum_;
    const Vector3 middle = inverse_tensor_ * (0.5 * (before + momentum_) + h / 8 * (k1 - momentum_.cross(spin_)));
    return h / 6 * (first + 4 * middle + spin_) + h * h / 12 * first.cross(spin_);
  }

  // Between steps.
  void KeepInvariants() {
    momentum_ = invariants_.Of(momentum_, spin_);
    spin_ = inverse_tensor_ * momentum_;
  }

  // The turn, rad, axes of the body, after which it sees its momentum as it is here and not as `apparent`.
  Vector3 TurnTo(const Vector3& apparent) const { return invariants_.TurnBetween(momentum_, apparent); }
  // `orientation`, where a body sees the momentum `momentum` (world) nearly as it is here, turned to where it does.
  Quaternion Turned(const Quaternion& orientation, const Vector3& momentum) const {
    const Vector3 half = TurnTo(orientation.conjugate() * momentum) / 2;
    return (orientation * Quaternion(1, half.x(), half.y(), half.z())).normalized();
  }

  const Vector3& spin() const { return spin_; }

 private:
  Vector3 Rate(const Vector3& momentum) const { return momentum.cross(inverse_tensor_ * momentum); }

  const Matrix3& inverse_tensor_;
  Vector3 momentum_;
  Vector3 spin_;
  Invariants invariants_;
};

// The turn by a rotation vector of no more than some tenths of a radian: by series, of which what is left out is less
// than rounding.
Quaternion SmallTurn(const Vector3& rotation) {
  const double square = rotation.squaredNorm() / 4;
  // What is constant is inverted beforehand: of all that flies this is computed in each step.
  const auto over = [square](double factor) { return square * (1 / factor); };
  const double cosine = 1 - over(2) * (1 - over(12) * (1 - over(30) * (1 - over(56))));
  const double ratio = 1 - over(6) * (1 - over(20) * (1 - over(42) * (1 - over(72))));
  const Vector3 half = ratio / 2 * rotation;
  return {cosine, half.x(), half.y(), half.z()};
}

// The rotation vector of a small turn and of a much smaller one after it, by the formula of Baker, Campbell and
// Hausdorff.
Vector3 Composed(const Vector3& turn, const Vector3& after) {
  const Vector3 across = turn.cross(after);
  return turn + after + across / 2 + turn.cross(across) / 12;
}

bool IsAboutPrincipalAxis(const Vector3& momentum, const Vector3& spin) {
  return momentum.cross(spin).squaredNorm() <= kParallel * kParallel * momentum.squaredNorm() * spin.squaredNorm();
}

int CountSteps(double rate, double angle_max, double time, int steps_max) {
  const double steps = std::floor(rate * time / angle_max) + 1;
  const double fewest = std::min<double>(std::ceil(rate * time / kAngleMost), kInnerStepsMax);
  return static_cast<int>(std::min(steps, std::max<double>(steps_max, fewest)));
}

// The rotation vector of `turn` on the branch nearest to `expected`, which may exceed half a turn.
Vector3 Logarithm(const Quaternion& turn, const Vector3& expected) {
  const double sine = turn.vec().norm();
  if (sine < 1e-300) return Vector3::Zero();
  const Vector3 axis = turn.vec() / sine;
  const double angle = 2 * std::atan2(sine, turn.w());
  const double whole = 2 * std::numbers::pi;
  return (angle + whole * std::round((expected.dot(axis) - angle) / whole)) * axis;
}

// The axis about which a diagonal tensor is symmetric, or -1. One of all moments equal is the caller's.
int SymmetryAxis(const Matrix3& inverse_tensor) {
  if (!inverse_tensor.isDiagonal(0)) return -1;
  for (int i = 0; i < 3; ++i) {
    const double a = inverse_tensor((i + 1) % 3, (i + 1) % 3), b = inverse_tensor((i + 2) % 3, (i + 2) % 3);
    if (std::abs(a - b) <= kSymmetric * (a + b)) return i;
  }
  return -1;
}

Quaternion TurnOf(double angle, const Vector3& axis) {
  const Vector3 half = std::sin(angle / 2) * axis;
  return {std::cos(angle / 2), half.x(), half.y(), half.z()};
}

// How a symmetric body turns: about its axis while the axis turns about the momentum, both uniformly (Goldstein,
// Classical Mechanics, 5.6).
Quaternion SymmetricTurn(const Vector3& axis, double across, double along, const Vector3& momentum, double time) {
  const double precession = across * momentum.norm(), own = (along - across) * momentum.dot(axis);
  return TurnOf(time * precession, momentum.normalized()) * TurnOf(time * own, axis);
}

Vector3 MeanSymmetricSpin(const Vector3& axis, double across, double along, const Vector3& momentum, double time) {
  const Vector3 precession = across * momentum, about = precession.normalized();
  const double own = (along - across) * momentum.dot(axis);
  const double angle = precession.norm() * time, sine = std::sin(angle / 2), cosine = std::cos(angle / 2);
  // The mean of the axis tells how often it has turned.
  Vector3 mean = axis;
  if (angle > kNegligibleAngle) {
    const Vector3 steady = about * about.dot(axis), turning = axis - steady;
    mean = steady + 2 * sine / angle * (cosine * turning + sine * about.cross(turning));
  }
  const Quaternion turn = SymmetricTurn(axis, across, along, momentum, time);
  return Logarithm(turn, time * (precession + own * mean)) / time;
}

// A body that one of its moments is so much smaller than the others of that little of its momentum turns it fast: steps
// of Runge and Kutta would have to resolve what all of it could do. Here its energy is taken apart into that of a body
// that is symmetric about this axis, and what is left of one other axis, which is little: such moments are no further
// from each other than the smallest is large. Either part alone turns it uniformly, and both in turns as a symmetric
// composition of fourth order (Fasso, J. Comput. Phys. 189, 2003; Yoshida, Phys. Lett. A 150, 1990).
class SlenderBody {
 public:
  static bool Is(const Vector3& momentum, const Vector3& spin, const Matrix3& inverse_tensor) {
    return momentum.norm() * inverse_tensor.norm() > kSlender * spin.norm();
  }

  SlenderBody(const Quaternion& orientation, const Vector3& momentum, const Matrix3& inverse_tensor)
      : momentum_(momentum), own_(orientation), inverse_tensor_(inverse_tensor) {
    const Eigen::SelfAdjointEigenSolver<Matrix3> principal(inverse_tensor);  // ascending
    axis_ = principal.eigenvectors().col(2);
    other_ = principal.eigenvectors().col(1);
    across_ = principal.eigenvalues()[0];
    along_ = principal.eigenvalues()[2] - across_;
    left_ = principal.eigenvalues()[1] - across_;
  }

  void Advance(double time, int steps_max = kInnerStepsMax) {
    const Vector3 own = own_.conjugate() * momentum_;
    // As fast as it turns about the axis, and as it can by what is left.
    const double along = along_ * own.dot(axis_), left = left_ * momentum_.norm();
    const double rate = std::sqrt(along * along + along_ * left * momentum_.norm()) + left;
    const int count = CountSteps(rate, kSlenderAngleMax, time, steps_max);
    const double h = time / count;
    const double cube = std::cbrt(2.0), outer = h / (2 - cube), inner = -cube * outer;
    for (int i = 0; i < count; ++i) {
      turned_ += h * (orientation() * BodySpin());
      TurnOther(outer / 2);
      TurnAxis(outer);
      TurnOther((outer + inner) / 2);
      TurnAxis(inner);
      TurnOther((outer + inner) / 2);
      TurnAxis(outer);
      TurnOther(outer / 2);
      time_ += h;
    }
    const Vector3 after = own_.conjugate() * momentum_;
    const Invariants invariants(own, inverse_tensor_ * own, inverse_tensor_);
    own_ *= SmallTurn(invariants.TurnBetween(invariants.Of(after, inverse_tensor_ * after), after));
    own_.normalize();
  }

  // The precession about the momentum changes nothing that the body sees.
  Quaternion orientation() const { return TurnOf(time_ * across_ * momentum_.norm(), momentum_.normalized()) * own_; }
  // How far it turned, rad, world: near enough to tell how often.
  const Vector3& turned() const { return turned_; }

 private:
  // The momentum could turn it so many times as fast as it does.
  static constexpr double kSlender = 4;
  static constexpr double kSlenderAngleMax = 0.02;  // rad

  Vector3 BodySpin() const {
    const Vector3 own = own_.conjugate() * momentum_;
    return across_ * own + along_ * own.dot(axis_) * axis_ + left_ * own.dot(other_) * other_;
  }
  void TurnAxis(double time) { Turn(time * along_, axis_); }
  void TurnOther(double time) { Turn(time * left_, other_); }
  void Turn(double ease, const Vector3& about) {
    own_ = own_ * TurnOf(ease * (own_.conjugate() * momentum_).dot(about), about);
  }

  Vector3 momentum_;
  Quaternion own_;  // but for the precession
  const Matrix3& inverse_tensor_;
  Vector3 axis_;  // of the smallest moment, in the frame of the body
  Vector3 other_;
  double across_ = 0;  // 1/(kg*m^2), of the largest moment
  double along_ = 0;   // of the smallest, more than that
  double left_ = 0;    // of the other one, more than that
  double time_ = 0;    // s
  Vector3 turned_ = Vector3::Zero();
};

}  // namespace

bool IsBlurred(double spin, double time) { return !(spin * time <= 2 * kAngleMost * kInnerStepsMax); }

Quaternion Turned(const Quaternion& orientation, const Vector3& spin, double time) {
  const double angle = spin.norm() * time;
  if (angle == 0) return orientation;
  return (Quaternion(Eigen::AngleAxisd(angle, spin.normalized())) * orientation).normalized();
}

Matrix3 WorldTensor(const Matrix3& axes, const Matrix3& tensor) {
  // Of most shapes it is diagonal, and of many the same across an axis.
  const bool is_diagonal = tensor(1, 0) == 0 && tensor(2, 0) == 0 && tensor(2, 1) == 0;
  if (is_diagonal && tensor(0, 0) == tensor(1, 1)) {
    const Matrix3 along = axes.col(2) * axes.col(2).transpose();
    return (tensor(2, 2) - tensor(0, 0)) * along + tensor(0, 0) * Matrix3::Identity();
  }
  const Matrix3 half = is_diagonal ? Matrix3(axes * tensor.diagonal().asDiagonal()) : Matrix3(axes * tensor);
  const auto at = [&](int i, int k) { return half.row(i).dot(axes.row(k)); };
  const double xy = at(1, 0), xz = at(2, 0), yz = at(2, 1);
  Matrix3 world;
  world << at(0, 0), xy, xz, xy, at(1, 1), yz, xz, yz, at(2, 2);
  return world;
}

Vector3 TurnBetween(const Quaternion& before, const Quaternion& after) {
  const Quaternion turn = after * before.conjugate();
  const double sine = turn.vec().norm();
  const double sign = turn.w() < 0 ? -1 : 1;
  // At smaller angles the quotient is two to the last bit.
  const double scale = sine > 1e-8 ? 2 * std::atan2(sine, sign * turn.w()) / sine : 2;
  return sign * scale * turn.vec();
}

Vector3 TurnBetween(const Quaternion& before, const Quaternion& after, const Vector3& expected) {
  return Logarithm(after * before.conjugate(), expected);
}

Vector3 MeanFreeSpin(const Quaternion& orientation, const Vector3& momentum, const Matrix3& inverse_tensor, double time,
                     int steps_max) {
  const Vector3 spin = orientation * BodySpin(orientation, momentum, inverse_tensor);
  return MeanFreeSpin(orientation, spin, momentum, inverse_tensor, time, steps_max);
}

Vector3 MeanFreeSpin(const Quaternion& orientation, const Vector3& spin, const Vector3& momentum,
                     const Matrix3& inverse_tensor, double time, int steps_max) {
  // About a principal axis it goes on as it is.
  if (spin.norm() * time < kNegligibleAngle || IsAboutPrincipalAxis(momentum, spin)) return spin;
  if (const int axis = SymmetryAxis(inverse_tensor); axis >= 0) {
    return MeanSymmetricSpin(orientation.toRotationMatrix().col(axis), inverse_tensor((axis + 1) % 3, (axis + 1) % 3),
                             inverse_tensor(axis, axis), momentum, time);
  }
  if (IsBlurred(spin.norm(), time)) return spin;
  if (SlenderBody::Is(momentum, spin, inverse_tensor)) {
    SlenderBody body(orientation, momentum, inverse_tensor);
    body.Advance(time, steps_max);
    return Logarithm(body.orientation() * orientation.conjugate(), body.turned()) / time;
  }
  const int count = CountSteps(spin.norm(), kAngleMax, time, steps_max);
  const double h = time / count;
  const Vector3 own = orientation.conjugate() * momentum;
  TurningBody body(own, inverse_tensor);
  if (count == 1) {
    const Vector3 turn = body.Advance(h);
    body.KeepInvariants();
    return orientation * (Composed(turn, body.TurnTo(SmallTurn(turn).conjugate() * own)) / h);
  }
  Quaternion turned = orientation;
  Vector3 expected = Vector3::Zero();
  for (int i = 0; i < count; ++i) {
    const Vector3 rotation = body.Advance(h);
    expected += turned * rotation;
    turned *= SmallTurn(rotation);
    body.KeepInvariants();
  }
  turned = body.Turned(turned, momentum);
  return Logarithm(turned * orientation.conjugate(), expected) / time;
}

// A free body with the momentum of the middle is off by the square of the time, and by even powers of it, for that is a
// symmetric composition. From the whole and both halves these are known, and the square is taken out (Richardson).
Vector3 MeanDrivenSpin(const Quaternion& orientation, const Vector3& momentum, const Vector3& torque,
                       const Matrix3& inverse_tensor, double time) {
  const Vector3 whole = MeanFreeSpin(orientation, momentum, inverse_tensor, time);
  const double half = time / 2;
  const Vector3 change = half / 2 * torque;
  const Vector3 first = MeanFreeSpin(orientation, momentum - change, inverse_tensor, half);
  const Quaternion middle = Turned(orientation, first, half);
  const Vector3 second = MeanFreeSpin(middle, momentum + change, inverse_tensor, half);
  const Quaternion by_halves = Turned(middle, second, half);
  const Vector3 off = TurnBetween(Turned(orientation, whole, time), by_halves);
  return TurnBetween(orientation, Turned(by_halves, off, 1.0 / 3), half * (first + second)) / time;
}

FreeRotation::FreeRotation(const Quaternion& before, const Vector3& spin_before, const MassProperties& mass,
                           double time)
    : orientation(before), spin(spin_before) {
  const Matrix3 rotation = before.toRotationMatrix();
  const Vector3 body_momentum = mass.tensor * (rotation.transpose() * spin_before);
  const Vector3 momentum = rotation * body_momentum;
  if (IsAboutPrincipalAxis(momentum, spin_before)) {
    orientation = Turned(before, spin_before, time);
    return;
  }
  if (const int axis = SymmetryAxis(mass.inverse_tensor); axis >= 0) {
    const double across = mass.inverse_tensor((axis + 1) % 3, (axis + 1) % 3), along = mass.inverse_tensor(axis, axis);
    const Vector3 axis_before = rotation.col(axis);
    orientation = (SymmetricTurn(axis_before, across, along, momentum, time) * before).normalized();
    spin = across * momentum + (along - across) * momentum.dot(axis_before) * (orientation * Vector3::Unit(axis));
    return;
  }
  if (SlenderBody::Is(momentum, spin_before, mass.inverse_tensor)) {
    SlenderBody body(before, momentum, mass.inverse_tensor);
    body.Advance(time);
    orientation = body.orientation().normalized();
    spin = orientation * BodySpin(orientation, momentum, mass.inverse_tensor);
    return;
  }
  const int count = CountSteps(spin_before.norm(), kAngleMax, time, kInnerStepsMax);
  TurningBody body(body_momentum, mass.inverse_tensor);
  for (int i = 0; i < count; ++i) {
    orientation *= SmallTurn(body.Advance(time / count));
    body.KeepInvariants();
  }
  orientation = body.Turned(orientation, momentum);
  spin = orientation * body.spin();
}

}  // namespace genphys

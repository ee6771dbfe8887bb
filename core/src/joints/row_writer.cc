#include "joints/row_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "joints/row_rate.h"

namespace genphys {
namespace {

// The part of an error that one substep takes away. The rest of the first order is what a whole one would overshoot by
// when a solver stops early.
constexpr double kCorrected = 1;
constexpr double kCorrectionSpinMax = 20;  // rad/s, as kCorrectionSpeedMax
// What making up for errors may give to what would else stand still.
constexpr double kQuietSpeed = 0.3;  // m/s
constexpr double kQuietSpin = 0.5;   // rad/s
// What comes to a limit no faster only comes to rest there: and this part of what it is sped up by in the substep.
constexpr double kLeastReachSpeed = 1e-3;  // m/s
constexpr double kLeastReachSpin = 1e-3;   // rad/s
constexpr double kShortestReach = 0.25;
// m/s or rad/s: a limit that could only be reached faster than this within the step is left out.
constexpr double kLimitHorizon = 200;
constexpr double kTurn = 2 * std::numbers::pi;

// The rotation vector of `q`, rad, the short way round.
Vector3 Log(const Quaternion& q) {
  const double sign = q.w() < 0 ? -1 : 1;
  const double sine = q.vec().norm();
  const double angle = 2 * std::atan2(sine, sign * q.w());
  return sine > 1e-12 ? Vector3(sign * angle / sine * q.vec()) : Vector3(2 * sign * q.vec());
}

}  // namespace

// After a longer substep it is longer than this one. Where no solve acts on either side it has no end.
double RowWriter::interval() const {
  const double shorter = std::min(a_.body->interval, b_.body->interval);
  return std::isfinite(shorter) ? shorter : step_size_;
}

// Of b against a, as it is now or was before the forces of this substep.
double RowWriter::RateOf(const Coordinate& coordinate, bool before) const {
  const JointBody &a = *a_.body, &b = *b_.body;
  const Vector3& point = b_.frame.position;
  Vector3 relative;
  if (coordinate.is_angular()) {
    relative = before ? Vector3(b.angular_before - a.angular_before) : Vector3(b.angular_velocity - a.angular_velocity);
  } else {
    relative =
        before ? Vector3(b.BeforeAt(point) - a.BeforeAt(point)) : Vector3(b.VelocityAt(point) - a.VelocityAt(point));
  }
  return coordinate.axis.dot(relative) / coordinate.scale;
}

// Along its axis, m/s or rad/s, on the mean of the substep, if joints and contacts go on as in the last one.
double RowWriter::ExpectedRateOf(const Coordinate& coordinate) const {
  const JointBody &a = *a_.body, &b = *b_.body;
  if (coordinate.is_angular()) return coordinate.axis.dot(b.angular_expected - a.angular_expected);
  return coordinate.axis.dot(b.ExpectedAt(b_.frame.position) - a.ExpectedAt(b_.frame.position));
}

// By how much more (m/s or rad/s) the coordinate changes in the step than its rate says.
double RowWriter::Bend(const Coordinate& coordinate) {
  if (positions_ != nullptr) {
    positions_->push_back(coordinate.position);
    return 0;
  }
  if (rows_ == nullptr || next_expected_ >= expected_.positions.size()) return 0;
  const double straight = ExpectedRateOf(coordinate) / coordinate.scale * step_size_;
  double bend = expected_.positions[next_expected_++] - coordinate.position - straight;
  if (coordinate.is_angular()) bend -= kTurn * std::round(bend / kTurn);
  return expected_.trust * coordinate.scale * bend / step_size_;
}

void RowWriter::Lock(const Coordinate& coordinate) { LockAt(coordinate, 0, Bend(coordinate)); }

Vector3 RowWriter::Offset() const { return axes_.transpose() * (b_.frame.position - a_.frame.position); }

Quaternion RowWriter::Turn() const { return a_.frame.orientation.conjugate() * b_.frame.orientation; }

Coordinate RowWriter::Along(int i) const {
  const Vector3 axis = axes_.col(i);
  return {.place = static_cast<size_t>(i), .axis = axis, .position = axis.dot(b_.frame.position - a_.frame.position)};
}

double RowWriter::Mobility(const JointRow& row, Matrix3 JointBody::*inverse_tensor) const {
  Vector3 turn_a = row.axis, turn_b = row.kind == JointRow::Kind::kGeared ? row.axis_b : row.axis;
  double linear = 0;
  if (row.kind == JointRow::Kind::kLinear) {
    linear = a_.body->inverse_mass + b_.body->inverse_mass;
    turn_a = (row.point - a_.body->center).cross(row.axis);
    turn_b = (row.point - b_.body->center).cross(row.axis);
  }
  return linear + turn_a.dot(a_.body->*inverse_tensor * turn_a) + turn_b.dot(b_.body->*inverse_tensor * turn_b);
}

RowWriter::Lever RowWriter::LeverOf(const JointRow& row) const {
  if (row.kind != JointRow::Kind::kLinear) return {.turn_a = row.axis, .turn_b = row.axis};
  return {.push = row.axis,
          .turn_a = (row.point - a_.body->center).cross(row.axis),
          .turn_b = (row.point - b_.body->center).cross(row.axis)};
}

double RowWriter::Coupling(const Lever& row, const Lever& other) const {
  return (a_.body->inverse_mass + b_.body->inverse_mass) * row.push.dot(other.push) +
         row.turn_a.dot(a_.body->inverse_tensor * other.turn_a) +
         row.turn_b.dot(b_.body->inverse_tensor * other.turn_b);
}

double RowWriter::HeldMobility(const JointRow& row) const {
  constexpr int kMost = 6;
  std::array<Lever, kMost> locked;
  int count = 0;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost> among(kMost, kMost);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1> across(kMost);
  const Lever lever = LeverOf(row);
  for (const JointRow& held : std::span(*rows_).subspan(first_)) {
    if (!IsLocked(held) || count == kMost) continue;
    locked[static_cast<size_t>(count)] = LeverOf(held);
    const Lever& last = locked[static_cast<size_t>(count)];
    across[count] = Coupling(last, lever);
    for (int i = 0; i <= count; ++i) {
      among(i, count) = among(count, i) = Coupling(locked[static_cast<size_t>(i)], last);
    }
    among(count, count) += held.softness;
    ++count;
  }
  const double own = Coupling(lever, lever);
  if (count == 0) return own;
  const double taken = across.head(count).dot(among.topLeftCorner(count, count).ldlt().solve(across.head(count)));
  return std::clamp(own - taken, 0.0, own);
}

double RowWriter::SpeedFor(double error, bool is_angular) const {
  const double bound = is_angular ? kCorrectionSpinMax : correction_.speed_max.value_or(kCorrectionSpeedMax);
  const double slop = is_angular ? 0 : correction_.slop.value_or(0);
  const double speed =
      std::min(correction_.PartOf(step_size_, kCorrected) * std::max(error - slop, 0.0) / step_size_, bound);
  return std::min(speed, std::max(state_.haste * speed, is_angular ? kCreepingSpin : kCreepingSpeed));
}

double RowWriter::RepairAt(double speed, bool is_angular, double mobility) const {
  if (!(mobility > 0)) return 0;
  // Who says how errors are taken away gets what that takes; else they wait where it would be too much at once.
  const double quiet = is_angular ? kQuietSpin : kQuietSpeed;
  const double rate = correction_.any() ? speed : std::min(speed, quiet);
  return rate * rate / mobility / 2;
}

void RowWriter::Correct(double error, JointRow& row) const {
  const bool is_angular = row.kind != JointRow::Kind::kLinear;
  const double speed = SpeedFor(std::abs(error), is_angular);
  row.target = std::copysign(speed, -error);
  // Who is harder to turn in this step has no more energy for that.
  row.repair = RepairAt(speed, is_angular, is_scaled() ? Mobility(row, &JointBody::own_inverse) : mobility_);
}

void RowWriter::Soften(JointRow& row) {
  mobility_ = Mobility(row, &JointBody::inverse_tensor);
  row.softness = kLeastSoftness * mobility_;
}

JointRow& RowWriter::AddRow(JointRow::Kind kind, const Vector3& axis) {
  // Made in place it would be cleared first.
  rows_->push_back({.a = a_.body->row, .b = b_.body->row, .kind = kind, .axis = axis, .point = b_.frame.position});
  return rows_->back();
}

JointRow& RowWriter::Add(const Coordinate& coordinate) {
  JointRow& row = AddRow(coordinate.is_angular() ? JointRow::Kind::kAngular : JointRow::Kind::kLinear, coordinate.axis);
  Soften(row);
  return row;
}

void RowWriter::LockAt(const Coordinate& coordinate, double position, double bend) {
  if (rows_ == nullptr) return;
  const double error = coordinate.scale * (coordinate.position - position);
  JointRow& row = Add(coordinate);
  Correct(error, row);
  row.target -= bend;
}

// How fast the body turns the origin of b away per impulse there along x, y and z, along the same, 1/kg.
Vector3 RowWriter::TurnOfPoint(const JointBody& body) const {
  if (!body.is_movable()) return Vector3::Zero();
  const Vector3 arm = b_.frame.position - body.center;
  const Matrix3& inverse = body.inverse_tensor;
  // Of the torque arm x axis.
  const auto along = [&](int j, int k) {
    return arm[k] * arm[k] * inverse(j, j) + arm[j] * arm[j] * inverse(k, k) - 2 * arm[j] * arm[k] * inverse(j, k);
  };
  return {along(1, 2), along(2, 0), along(0, 1)};
}

// The same as Bend() of all three coordinates of the origin of b in a, but in the world.
Vector3 RowWriter::BendOfPoint(const Vector3& offset) {
  if (next_expected_ + 3 > expected_.positions.size()) return Vector3::Zero();
  const Eigen::Map<const Vector3> ahead(&expected_.positions[next_expected_]);
  next_expected_ += 3;
  const Vector3 relative = b_.body->ExpectedAt(b_.frame.position) - a_.body->ExpectedAt(b_.frame.position);
  return expected_.trust * ((axes_ * ahead - offset) / step_size_ - relative);
}

// Coordinates are told along the axes of a, and rows are along those of the world, which cost a solver less.
void RowWriter::LockPoint() {
  if (positions_ != nullptr) {
    const Vector3 along = Offset();
    positions_->insert(positions_->end(), along.begin(), along.end());
    return;
  }
  if (rows_ == nullptr) return;
  const JointBody &a = *a_.body, &b = *b_.body;
  const Vector3 offset = b_.frame.position - a_.frame.position;
  const Vector3 turn_a = TurnOfPoint(a), turn_b = TurnOfPoint(b);
  const double push = a.inverse_mass + b.inverse_mass, most = push + (turn_a + turn_b).maxCoeff();
  // Who is harder to turn in this step has no more energy for making up for errors.
  const Vector3 own = (a.factor * turn_a + b.factor * turn_b).array() + push;
  Vector3 target = -BendOfPoint(offset);
  double repair = 0;
  for (int i = 0; i < 3; ++i) {
    const double speed = SpeedFor(std::abs(offset[i]), false);
    target[i] -= std::copysign(speed, offset[i]);
    repair += RepairAt(speed, false, own[i]);
  }
  for (int i = 0; i < 3; ++i) {
    JointRow& row = AddRow(JointRow::Kind::kLinear, Vector3::Unit(i));
    row.softness = kLeastSoftness * most;
    row.target = target[i];
  }
  JointRow& first = *(rows_->end() - 3);
  first.block = 3;
  first.repair = repair;
}

void RowWriter::LockAcross() {
  Lock(Along(0));
  Lock(Along(1));
  if (rows_ == nullptr) return;
  const auto block = rows_->end() - 2;
  block->block = 2;
  block[0].softness = block[1].softness = std::max(block[0].softness, block[1].softness);
}

void RowWriter::LockOrientation() {
  const Vector3 error = Log(Turn());
  for (int i = 0; i < 3; ++i) {
    Lock({.place = static_cast<size_t>(3 + i), .axis = axes_.col(i), .position = error[i]});
  }
}

void RowWriter::LockTilt(int i) {
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  const Vector3 tilted = Turn() * Vector3::Unit(i);
  // The turn about the other two that would bring it there: the angle itself, so that a wide one is not taken for a
  // small one.
  const double sine = std::hypot(tilted[j], tilted[k]);
  const double angle = std::atan2(sine, tilted[i]);
  const double scale = sine > 1e-9 ? angle / sine : 1;
  const bool is_opposite = sine <= 1e-9 && tilted[i] < 0;
  const auto turn = [&](int about, double position) {
    Lock({.place = static_cast<size_t>(3 + about), .axis = axes_.col(about), .position = position});
  };
  turn(j, is_opposite ? std::numbers::pi : -scale * tilted[k]);
  turn(k, scale * tilted[j]);
}

void RowWriter::Drive(Coordinate coordinate, const JointAxis& axis) {
  const double bend = Bend(coordinate);
  if (positions_ != nullptr) return;
  if (coordinate.is_angular()) {
    CountTurns(coordinate.place, coordinate.position);
    coordinate.position = state_.positions[coordinate.place];
  }
  if (is_noting()) {
    state_.positions[coordinate.place] = coordinate.position;
    state_.rates[coordinate.place] = RateOf(coordinate, false);
    return;
  }
  WriteLimits(coordinate, axis.limits, bend);
  WriteDrives(coordinate, axis, bend);
}

void RowWriter::CountTurns(size_t place, double position) {
  double& noted = state_.positions[place];
  noted = position + kTurn * std::round((noted - position) / kTurn);
}

void RowWriter::WriteLimits(const Coordinate& coordinate, const AxisLimits& limits, double bend) {
  if (limits.lock()) return LockAt(coordinate, *limits.lower, bend);
  const double above = limits.lower ? coordinate.position - *limits.lower : JointRow::kUnbounded;
  const double below = limits.upper ? *limits.upper - coordinate.position : JointRow::kUnbounded;
  const bool is_lower = above < below;
  const double gap = coordinate.scale * std::min(above, below);
  if (!(gap <= kLimitHorizon * step_size_)) return;
  JointRow& row = Add(coordinate);
  // What is left may be used up within the step, and no more.
  if (gap >= 0) {
    row.target = -gap / step_size_;
  } else {
    Correct(gap, row);
    // What has little scale turns its bodies mostly another way, and making up for it fast would swing them.
    row.target *= coordinate.scale;
  }
  if (!is_lower) row.target = -row.target;
  (is_lower ? row.lower : row.upper) = 0;
  if (gap > 0) Reach(coordinate, gap, bend, row);
}

// Whether it comes to the limit, `gap` away, within the substep, if what acted in the last one still does.
void RowWriter::Reach(const Coordinate& coordinate, double gap, double bend, JointRow& row) const {
  const double h = step_size_, side = row.lower == 0 ? -1 : 1;
  const double mean = side * ExpectedRateOf(coordinate);
  const double straight = (mean - side * coordinate.scale * RateOf(coordinate, true)) / interval();
  const double coming = mean - h / 2 * straight, pull = straight + 2 / h * side * bend;
  const double square = coming * coming + 2 * pull * gap;
  const double least =
      (coordinate.is_angular() ? kLeastReachSpin : kLeastReachSpeed) + kShortestReach * h * std::abs(pull);
  if (!(square > least * least) || !(coming + std::sqrt(square) > 0)) return;
  const double time = 2 * gap / (coming + std::sqrt(square));
  if (!(time < h)) return;
  row.is_reached = true;
  row.until = time;
  row.leaving = std::max(-pull, 0.0) * (h - time);
  // By the end it has gone so far from the limit.
  row.target -= side * row.leaving * (h - time) / 2 / h;
}

void RowWriter::LockGear(double ratio) {
  if (positions_ != nullptr) return;
  const Vector3 axis_a = -ratio * axes_.col(2), axis_b = b_.axis(2);
  if (is_noting()) {
    state_.rates[5] = axis_a.dot(a_.body->angular_velocity) + axis_b.dot(b_.body->angular_velocity);
    return;
  }
  JointRow& row = Add({.place = 5});
  row.kind = JointRow::Kind::kGeared;
  row.axis = axis_a;
  row.axis_b = axis_b;
  Soften(row);
  Correct(state_.positions[5], row);
}

}  // namespace genphys

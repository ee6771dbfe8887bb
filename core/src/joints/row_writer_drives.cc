// Motors and springs as rows.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "joints/row_writer.h"

namespace genphys {
namespace {

// Of its own mobility: a row that is softer moves nothing by as much as a rounding error.
constexpr double kMostSoftness = 1e18;
constexpr double kLeastImpulse = 1e-290;
// (rad per step)^2 of a spring alone on what it holds, or the part of a velocity that its damper takes in a step: from
// where on a step resolves it no more, and from where on not at all.
constexpr double kResolvedPace = 1, kUnresolvedPace = 4;

// m or rad: what frames that go elsewhere leave there.
constexpr double kSamePlace = 1e-9;

bool IsSoft(const std::optional<Motor>& motor) { return motor && motor->target_position; }
bool IsSoft(const std::optional<Spring>& spring) { return spring.has_value(); }

}  // namespace

RowWriter::SoftDrive RowWriter::SoftDrive::Of(const Motor& motor) {
  return {.stiffness = motor.stiffness,
          .damping = motor.damping,
          .rest = *motor.target_position,
          .rate = motor.target_velocity,
          .force_max = motor.force_max.value_or(JointRow::kUnbounded)};
}

RowWriter::SoftDrive RowWriter::SoftDrive::Of(const Spring& spring) {
  return {.stiffness = spring.stiffness,
          .damping = spring.damping,
          .rest = spring.rest,
          .rate = 0,
          .force_max = JointRow::kUnbounded};
}

void RowWriter::WriteDrives(const Coordinate& coordinate, const JointAxis& axis, double bend) {
  const double told = ToldPosition(coordinate);
  const auto former = std::ranges::find(former_.drives, coordinate.place, &FormerDrive::place);
  const auto write = [&](const auto& now, auto FormerDrive::*drive) {
    const bool has_former = former != former_.drives.end() && IsSoft((*former).*drive);
    if (!has_former) return WriteSoft(coordinate, told, SoftDrive::Of(*now), nullptr);
    const SoftDrive before = SoftDrive::Of(*((*former).*drive));
    WriteSoft(coordinate, told, SoftDrive::Of(*now), &before);
  };
  if (IsSoft(axis.motor)) {
    write(axis.motor, &FormerDrive::motor);
  } else if (axis.motor) {
    WriteMotor(coordinate, *axis.motor, axis.limits, bend);
  }
  if (axis.spring) write(axis.spring, &FormerDrive::spring);
}

void RowWriter::WriteMotor(const Coordinate& coordinate, const Motor& motor, const AxisLimits& limits, double bend) {
  const double force_max = motor.force_max.value_or(JointRow::kUnbounded);
  if (force_max == 0) return;
  JointRow& row = Add(coordinate);
  double rate = motor.target_velocity;
  const double gained = force_max * interval() * mobility_ / (coordinate.scale * coordinate.scale);
  // A motor does not fight its own limits: one equation would say what the other forbids. But one that pushes with all
  // that it may comes there no slower than it does without them.
  if (!(std::abs(rate - RateOf(coordinate, false)) >= gained)) {
    if (limits.lower) rate = std::max(rate, std::min(0.0, (*limits.lower - coordinate.position) / step_size_));
    if (limits.upper) rate = std::min(rate, std::max(0.0, (*limits.upper - coordinate.position) / step_size_));
  }
  row.is_driven = true;
  row.target = coordinate.scale * rate - bend;
  Bound(force_max / coordinate.scale);
}

void RowWriter::Bound(double force_max) {
  JointRow& row = rows_->back();
  row.upper = force_max * interval();
  row.lower = -row.upper;
  // What is too weak to be a number does nothing.
  if (!(row.upper > kLeastImpulse)) rows_->pop_back();
}

double RowWriter::ToldPosition(const Coordinate& coordinate) const {
  if (former_.told.empty()) return coordinate.position;
  const double told = former_.told[coordinate.place] - coordinate.position;
  return coordinate.position + (coordinate.is_angular() ? std::remainder(told, 2 * std::numbers::pi) : told);
}

// How far a step does not resolve it, 0 to 1.
double RowWriter::LatenessOf(const SoftDrive& drive, const Coordinate& coordinate) {
  const JointRow row = Add(coordinate);
  rows_->pop_back();
  const auto pace_at = [&](double mobility) {
    return std::max(drive.stiffness * step_size_, drive.damping) * step_size_ * mobility /
           (coordinate.scale * coordinate.scale);
  };
  double pace = pace_at(mobility_);
  // About an axis beside it a body is harder to turn than about its centre of mass.
  if (pace > kResolvedPace) pace = pace_at(HeldMobility(row));
  return std::clamp((pace - kResolvedPace) / (kUnresolvedPace - kResolvedPace), 0.0, 1.0);
}

RowWriter::SoftPart RowWriter::SoftPart::Of(const SoftDrive& drive, double position, double part) {
  // One without bounds has none for no time either.
  const double force_max = std::isfinite(drive.force_max) ? part * drive.force_max : drive.force_max;
  return {part * drive.stiffness, part * drive.damping, part * drive.PushAt(position), force_max};
}

RowWriter::SoftPart RowWriter::SoftPart::With(const SoftPart& other) const {
  return {stiffness + other.stiffness, damping + other.damping, pull + other.pull, force_max + other.force_max};
}

// Until the boundary it pulled as it was told before, and to both sides of that as it pulls there: the trapezoidal rule
// on each. What is to be where it is told at the end does not lag behind.
void RowWriter::WriteSoft(const Coordinate& coordinate, double told, const SoftDrive& now, const SoftDrive* before) {
  if (!now.pulls() && (before == nullptr || !before->pulls())) return;
  const double late = LatenessOf(now, coordinate);
  is_late_ |= late > 0 && (before != nullptr || std::abs(told - coordinate.position) > kSamePlace);
  const double position = coordinate.position + late * (told - coordinate.position);
  const double past = before != nullptr ? (1 - late) * PastPart(interval(), step_size_) : 0;
  const SoftPart rest = SoftPart::Of(now, position, 1 - past);
  if (past == 0) return WriteSoftPart(coordinate, late, rest, 1);
  const SoftPart first = SoftPart::Of(*before, position, past);
  const bool is_bounded = std::isfinite(now.force_max) || std::isfinite(before->force_max);
  if (!is_bounded) return WriteSoftPart(coordinate, late, first.With(rest), -1);
  // Half with all that it has and half with less is not what it would push with midway.
  WriteSoftPart(coordinate, late, first, 0);
  WriteSoftPart(coordinate, late, rest, 1 / (1 - past));
}

// The force at the start of the step, of the mean of the places before, there and after it with weights 1, 2 and 1 and
// of the mean velocity: second order, and no oscillation grows (Newmark's method with beta 1/4, in the form of a
// leapfrog). One that a step does not resolve would not decay either, so that its force is that at the end.
void RowWriter::WriteSoftPart(const Coordinate& coordinate, double late, const SoftPart& part, double since) {
  if (!(part.stiffness + part.damping > 0) || part.force_max == 0) return;
  JointRow& row = Add(coordinate);
  row.is_driven = true;
  row.since = since;
  const double h = step_size_, time = interval(), scale = coordinate.scale;
  const double inertia = (1 - late) * h * h / 4 * part.stiffness, resistance = (1 - late) * time / 2 * part.damping;
  const double after = inertia + resistance + late * time * (h * part.stiffness + part.damping);
  row.target = scale * (time * part.pull + (inertia - resistance) * RateOf(coordinate, true)) / after;
  const double softness = scale * scale / after;
  // What is too weak to be felt must not be divided by.
  if (!(kLeastSoftness * softness <= kMostSoftness * row.softness)) return rows_->pop_back();
  row.softness = std::max(row.softness, softness);
  // It also brakes itself, at most for as long as a step.
  const double damping = part.damping / (scale * scale);
  row.damping = damping / (1 + h * damping * mobility_);
  Bound(part.force_max / scale);
}

}  // namespace genphys

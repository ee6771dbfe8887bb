// Motors that come to the speed that they are to reach in the course of a substep, under a load that they cannot hold
// there. A solve lets them hold it to the end of the substep with what they pushed before as well, and only the next
// one finds that they cannot: like friction that turns, they push one way until then, and the other way after it. So
// an island is solved from one such time to the next. Between them all that pushes is constant, and so is what speeds
// change by: a solve to the end of the substep, with the impulses that there were until then, tells both.
#include <algorithm>
#include <cmath>

#include "joints/joint_step.h"
#include "joints/row_rate.h"

namespace genphys {
namespace {

// Of the speed, and m/s or rad/s: who is as near to it was there all the time.
constexpr double kThere = 1e-6;
// Of the speed that it lacks: by less a motor does not give way.
constexpr double kGivesWay = 1e-3;
// Of what it may push with: all of it.
constexpr double kAll = 1 - 1e-9;
// As many are looked at in a substep, one after the other. All others come there as if nothing pulled at them.
constexpr int kTurnsMax = 8;

// A motor that drives to a speed and not, like a spring, gives way.
bool IsWeakMotor(const JointRow& row, double lacking) {
  const bool is_bounded = row.is_driven && std::isfinite(row.upper) && row.lower == -row.upper;
  return is_bounded && row.softness * row.upper < kGivesWay * std::abs(lacking);
}

}  // namespace

void JointStep::TurningMotor::Restore(JointRow& to) const {
  to.upper = most;
  to.lower = -most;
}

// What it may push with in all by the end of the substep, of which that part is left.
void JointStep::TurningMotor::Bound(JointRow& to, double left) const {
  to.upper = pushed + left * most;
  to.lower = pushed - left * most;
}

// The same if it does not come there any more.
void JointStep::TurningMotor::Drive(JointRow& to, double left) const {
  to.upper = to.lower = pushed + left * sign * most;
}

// As the substep began, before forces acted.
double JointStep::RateBefore(const JointRow& row) const {
  const JointBody &a = BodyAt(row.a), &b = BodyAt(row.b);
  return RateOf(row, a, {a.linear_before, a.angular_before}, b, {b.linear_before, b.angular_before});
}

// As the last solve left it.
double JointStep::RateAfter(const JointRow& row) const {
  const JointBody &a = BodyAt(row.a), &b = BodyAt(row.b);
  return RateOf(row, a, {a.linear_velocity, a.angular_velocity}, b, {b.linear_velocity, b.angular_velocity});
}

bool JointStep::SolveAnew(uint32_t island, std::vector<JointRow>& rows) {
  for (const uint32_t moved : solver_.moved()) bodies_[moved].Return();
  return solver_.Solve(island, rows, islands_.JointRowsOf(island), body_of_, bodies());
}

// kg or kg*m^2: what the row finds at most where joints hold its bodies together with others, and with none in a ring:
// all that the last solve moved, as if it were one.
double JointStep::InertiaOf(const JointRow& row) const {
  double sum = 0;
  for (const uint32_t moved : solver_.moved()) {
    const JointBody& body = bodies_[moved];
    const double mass = 1 / body.inverse_mass;
    const bool is_linear = row.kind == JointRow::Kind::kLinear;
    const Vector3 arm = row.axis.cross(body.center - row.point);
    sum += is_linear ? mass : mass * arm.squaredNorm() + body.factor * row.axis.dot(body.own_tensor * row.axis);
  }
  return sum;
}

// Motors that have not come to their speed as the substep begins, but for those that hold their load for long: these
// are near it, as turning changes it from substep to substep. None if all of the others hold it too.
void JointStep::FindTurning(std::span<const uint32_t> mine, std::span<const JointRow> rows) {
  motors_.clear();
  bool may_turn = false;
  for (const uint32_t i : mine) {
    const JointRow& row = rows[i];
    if (!row.is_driven) continue;
    const double before = RateBefore(row), lacking = row.target - before, sign = lacking < 0 ? -1 : 1;
    if (!IsWeakMotor(row, lacking) || std::abs(lacking) <= kThere * (1 + std::abs(row.target))) continue;
    const double pushed = sign * row.impulse;
    const bool gets_there = pushed < kAll * row.upper;
    // It comes there the later the heavier what it pushes is, and pushes `upper` until then and no less than -`upper`
    // from then on: with this inertia it would come to `pushed` just so.
    if (gets_there && InertiaOf(row) * std::abs(lacking) <= row.upper + pushed) continue;
    may_turn |= gets_there;
    motors_.push_back({.row = i, .most = row.upper, .sign = sign, .rate = before});
  }
  if (!may_turn) motors_.clear();
}

// After a solve as if all motors that are driven did not come to their speed. The first that does, and after which part
// of what is left of the substep.
std::pair<JointStep::TurningMotor*, double> JointStep::FirstThere(std::span<const JointRow> rows) {
  std::pair<TurningMotor*, double> first{nullptr, 1};
  for (TurningMotor& motor : motors_) {
    const JointRow& row = rows[motor.row];
    const double after = RateAfter(row);
    if (motor.is_there || !(motor.sign * (after - row.target) > 0)) continue;
    const double part = std::clamp((row.target - motor.rate) / (after - motor.rate), 0.0, 1.0);
    if (first.first == nullptr || part < first.second) first = {&motor, part};
  }
  return first;
}

// After a solve. False: the numbers do not suffice for another one.
bool JointStep::TurnMotors(uint32_t island, std::vector<JointRow>& rows) {
  FindTurning(islands_.JointRowsOf(island), rows);
  // What contradicts itself is not solved alike twice.
  if (solver_.is_swept()) motors_.clear();
  double left = 1;
  for (int turns = 0; !motors_.empty(); ++turns) {
    for (const TurningMotor& motor : motors_) {
      JointRow& row = rows[motor.row];
      motor.is_there || turns == kTurnsMax ? motor.Bound(row, left) : motor.Drive(row, left);
    }
    if (!SolveAnew(island, rows)) return false;
    if (solver_.is_swept()) {
      for (const TurningMotor& motor : motors_) motor.Restore(rows[motor.row]);
      return SolveAnew(island, rows);
    }
    const auto [first, part] = FirstThere(rows);
    if (first == nullptr || turns == kTurnsMax) break;
    for (TurningMotor& motor : motors_) {
      const JointRow& row = rows[motor.row];
      motor.rate += part * (RateAfter(row) - motor.rate);
      motor.pushed += part * (row.impulse - motor.pushed);
    }
    first->is_there = true;
    left *= 1 - part;
  }
  return true;
}

}  // namespace genphys

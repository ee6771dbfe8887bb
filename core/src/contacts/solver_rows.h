#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "genphys/contact_sweeps.h"
#include "genphys/error_correction.h"
#include "genphys/joint_row.h"

namespace genphys {

/// Part of an overlap that one step takes away. It is taken away by moving the bodies apart, never by a velocity, so
/// that it costs no accuracy to be quick.
inline constexpr double kOverlapTakenPerStep = 0.4;

// Rows between two bodies of a solve, written from what the layer says of contacts and joints.

/// What rows have changed of the velocities of a body, of one of the two kinds that sweeps keep. Fourth components
/// are zero: processors calculate with pairs of numbers.
struct MotionChange {
  Eigen::Vector4d linear = Eigen::Vector4d::Zero();   // m/s
  Eigen::Vector4d angular = Eigen::Vector4d::Zero();  // rad/s
  double inverse_mass = 0;                            // 1/kg; zero of one that nothing moves
};

/// A row between two bodies.
struct SolverRow {
  // Written out, or all of it would be cleared before its members are.
  SolverRow() {}

  Eigen::Vector4d push = Eigen::Vector4d::Zero();    // of the Jacobian, on a; on b against it
  Eigen::Vector4d turn_a = Eigen::Vector4d::Zero();  // of the Jacobian, m
  Eigen::Vector4d turn_b = Eigen::Vector4d::Zero();
  Eigen::Vector4d gain_a = Eigen::Vector4d::Zero();  // rad/s per N*s
  Eigen::Vector4d gain_b = Eigen::Vector4d::Zero();
  double mobility = 0;  // m/s per N*s
  double inverse = 0;   // N*s per m/s
  double wanted = 0;    // N*s, were all else as it is
  double impulse = 0;   // N*s
  double friction = 0;  // of one that takes slip: Coulomb coefficient
  uint32_t a = 0;       // numbers of bodies
  uint32_t b = 0;
};

/// One of a joint, or about a line: from `lower` to `upper`.
struct BoundedRow : SolverRow {
  double softness = 0;  // see JointRow
  double lower = -JointRow::kUnbounded;
  double upper = JointRow::kUnbounded;
  double pushed = 0;  // the impulse of what takes overlaps apart
};

/// What takes an overlap apart by a move, which leaves the velocities as they are.
struct ContactPush {
  uint32_t row = 0;   // of the contact, that it goes along
  double wanted = 0;  // as in that
  double impulse = 0;
};

/// Fills in all of a row of a joint but ids and impulse: rate + softness * impulse = target.
void FillJointRow(const JointRow& row, const SweptBody& a, const SweptBody& b, BoundedRow& to);

/// Fills in all but ids, friction and impulse of a row that pushes `a` along `axis` (unit length) at `place`, and `b`
/// against it, and wants nothing. Returns how fast a goes that way against b there, m/s.
double FillPush(const Vector3& axis, const Vector3& place, const SweptBody& a, const SweptBody& b, SolverRow& to);

/// What remains to be said of a row that keeps two bodies apart, which touch at `point` and approach at -`rate` m/s.
/// Returns what is wanted of a push that takes them apart; zero if none is.
double FillContact(const ContactPoint& point, double rate, const ErrorCorrection& correction, double step_size,
                   SolverRow& to);

/// Two directions across `normal`, the first of them along `slip` if there is any.
void FindTangents(const Vector3& normal, const Vector3& slip, Vector3& first, Vector3& second);

/// Gives two bodies an impulse of a row.
[[gnu::always_inline]] inline void Apply(const SolverRow& row, double impulse, MotionChange& a, MotionChange& b) {
  a.linear += (a.inverse_mass * impulse) * row.push;
  b.linear -= (b.inverse_mass * impulse) * row.push;
  a.angular += impulse * row.gain_a;
  b.angular += impulse * row.gain_b;
}

/// How fast what rows have changed moves along a row, m/s.
[[gnu::always_inline]] inline double RateOf(const SolverRow& row, const MotionChange& a, const MotionChange& b) {
  const Eigen::Vector4d rates = row.push.cwiseProduct(a.linear - b.linear) + row.turn_a.cwiseProduct(a.angular) +
                                row.turn_b.cwiseProduct(b.angular);
  return rates.sum();
}

/// Brings the impulse of a row to `impulse`, and `applied` with it. Returns the change of its rate.
[[gnu::always_inline]] inline double BringTo(double impulse, const SolverRow& row, double& applied, MotionChange& a,
                                             MotionChange& b) {
  const double change = impulse - applied;
  applied = impulse;
  Apply(row, change, a, b);
  return change * row.mobility;
}

/// One turn of a row: brings its rate to what is `wanted`, as far as the bounds of the impulse `applied` let it.
/// Returns the change of the rate.
[[gnu::always_inline]] inline double Relax(const SolverRow& row, double wanted, double lower, double upper,
                                           double& applied, MotionChange& a, MotionChange& b) {
  const double free = applied + wanted - RateOf(row, a, b) * row.inverse;
  return BringTo(std::min(std::max(free, lower), upper), row, applied, a, b);
}

/// The impulses (N*s) of two rows that come nearest to `wanted` (m/s), by the energy of what is left, of all in a disc
/// of radius `most`: where they slip they are against the slip. `mobility`: m/s per N*s of each by each.
Eigen::Vector2d NearestInDisc(const Eigen::Matrix2d& mobility, const Eigen::Vector2d& wanted, double most);

/// One turn of two rows across each other, whose impulses together stay in a disc of radius `most` (N*s), as friction
/// does whichever way it acts. Returns the larger change of their rates.
inline double RelaxInDisc(SolverRow& first, SolverRow& second, double most, MotionChange& a, MotionChange& b) {
  const auto lack = [&](const SolverRow& row) { return row.wanted - RateOf(row, a, b) * row.inverse; };
  const Eigen::Vector2d held(first.impulse, second.impulse), lacks(lack(first), lack(second));
  if ((held + lacks).squaredNorm() <= most * most) {
    const double change = std::abs(BringTo(held.x() + lacks.x(), first, first.impulse, a, b));
    const double rest = std::sqrt(std::max(most * most - first.impulse * first.impulse, 0.0));
    return std::max(change, std::abs(Relax(second, second.wanted, -rest, rest, second.impulse, a, b)));
  }
  const double both = first.push.dot(second.push) * (a.inverse_mass + b.inverse_mass) +
                      first.gain_a.dot(second.turn_a) + first.gain_b.dot(second.turn_b);
  const Eigen::Matrix2d mobility{{1 / first.inverse, both}, {both, 1 / second.inverse}};
  const Eigen::Vector2d wanted = mobility * held + mobility.diagonal().cwiseProduct(lacks);
  const Eigen::Vector2d to = NearestInDisc(mobility, wanted, most);
  const double change = std::abs(BringTo(to.x(), first, first.impulse, a, b));
  return std::max(change, std::abs(BringTo(to.y(), second, second.impulse, a, b)));
}

}  // namespace genphys

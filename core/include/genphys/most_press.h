#pragma once
#include <cmath>

#include "genphys/joint_row.h"
#include "genphys/math.h"

namespace genphys {

/// How hard contacts and joints of an island can press against each other, N*s: with what weighs and drives there, and
/// stops if it moves, by long levers. What presses harder is jammed: something that nothing stops is in the way of
/// something that nothing moves, and impulses are as large as a solver's softness lets them be.
class MostPress {
 public:
  /// `gain` is the speed (m/s) that gravity gives in the solve.
  explicit MostPress(double gain) : gain_(gain) {}

  /// The weight of a body of `mass` kg.
  void AddWeight(double mass) { most_ += mass * gain_; }
  /// What stops such a body: its velocity in m/s, and twice the energy of its turning in J.
  void AddMotion(double mass, const Vector3& velocity, double turning) {
    most_ += std::sqrt(mass * (mass * velocity.squaredNorm() + turning));
  }
  /// A motor or spring. Those that have no bound may press as they like.
  void AddDrive(const JointRow& row) {
    if (row.is_driven) most_ += row.upper;
  }

  double value() const { return kLever * most_; }
  /// What is pressed harder and does not move has something in its way.
  double usual() const { return kUsualLever * most_; }

 private:
  static constexpr double kLever = 100;
  static constexpr double kUsualLever = 10;

  double gain_;
  double most_ = 0;
};

}  // namespace genphys

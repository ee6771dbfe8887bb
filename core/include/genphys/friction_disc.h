#pragma once
#include <Eigen/Core>

namespace genphys {

/// Coulomb's friction at a point for a solver that bounds impulses along two lines, each of them by itself: a square,
/// whose corners hold more than friction does, and another way than against the slip. Solve by solve the first line is
/// turned to where friction pushes what slips. Across it the impulse is as soft as Coulomb's law is in which it only
/// turns, so that directions are twice as exact after each solve. A point that holds has both lines, without that
/// softness.
class FrictionDisc {
 public:
  /// Looks at what a solve gave along the two lines from which it all began: the impulse, and the slip that is left,
  /// without what a row gives way by softness. `mobility` (m/s per N*s) is about that of the point, `most` (N*s) what
  /// friction bears there. Returns how far that is from Coulomb's law, m/s; zero: as good as nothing.
  double Follow(const Eigen::Vector2d& impulse, const Eigen::Vector2d& slip, double mobility, double most);

  /// The first line of the next solve, along the two lines; the second one is across it.
  const Eigen::Vector2d& along() const { return along_; }
  /// What the second row gives way, m/s per N*s.
  double softness() const { return softness_; }
  /// The bound of both, N*s, foretold: friction itself changes what presses, which changes the bound from solve to
  /// solve.
  double most() const { return most_; }

 private:
  // Bounds come nearer to the last one like a geometric series, of which three tell where it ends (Aitken).
  void Foretell();

  Eigen::Vector2d along_ = Eigen::Vector2d::UnitX();
  double softness_ = 0;
  double most_ = 0;
  double before_ = 0, long_before_ = 0;  // the same, of the two solves before
  int known_ = 0;                        // of these
};

}  // namespace genphys

#pragma once
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "genphys/friction_disc.h"
#include "genphys/math.h"

struct dContact;
struct dJointFeedback;
struct dxBody;

namespace genphys::ode_backend {

struct ContactConstraint;

/// Along which lines the exact solver bounds the friction of contacts. It bounds each line by itself, so that an island
/// in which something slips is solved anew, with lines turned to where friction pushes, until none of it is more than
/// Coulomb's or goes another way.
class FrictionLines {
 public:
  /// For other contacts.
  void Begin();
  /// Tells the solver of the lines of the next contact, which pushes `body`, at its first solve those that it has. All
  /// solves add the same contacts. `softness` (1/kg) is that of both lines.
  void Turn(const ContactConstraint& contact, dxBody* body, dxBody* other, double softness, double step_size,
            dContact& to);
  /// After a solve, with what contacts came to. True: it is to be solved anew, along other lines.
  bool Follow(std::span<const dJointFeedback> feedback, double step_size);
  /// After one that failed. True: it is to be solved anew, as it was best.
  bool GoBack();

 private:
  struct Point {
    bool is_followed = false;
    bool is_line = false;
    dxBody* body = nullptr;
    dxBody* other = nullptr;
    Vector3 arm, other_arm;  // from the centres, m
    Vector3 run;             // m/s, of the body where nothing slips and the other one rests
    Vector3 normal, first;
    Vector3 second = Vector3::Zero();
    double friction = 0;  // Coulomb coefficient
    double softness = 0;  // 1/kg
    double mobility = 0;  // 1/kg
  };

  static void Read(const ContactConstraint& contact, const dContact& from, Point& to);
  static Vector3 SlipOf(const Point& point);

  std::vector<Point> points_;
  size_t next_ = 0;
  size_t solves_ = 0;                // that are over
  std::vector<FrictionDisc> discs_;  // of points_, none in the first solve
  std::vector<FrictionDisc> best_;
  double least_ = std::numeric_limits<double>::infinity();  // m/s, from Coulomb's law, with best_
};

}  // namespace genphys::ode_backend

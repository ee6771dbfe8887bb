// How surfaces that touch run against each other because their bodies turn. Contacts are solved for velocities at
// points where these are when a substep begins, and by its middle the points have turned on: what is held there at
// every beginning creeps outward by half of omega^2 r h. So solves are told how the slip changes until the middle, and
// hold or rub what slips on the mean.
#include <algorithm>
#include <cmath>
#include <span>

#include "pairs/contact_points.h"
#include "shapes/curvature.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// rad in a substep: who turns less bends no way.
constexpr double kNoTurn = 1e-4;
// 1/m: what is less curved than that is flat.
constexpr double kFlat = 1e-6;
// Of how large something is: a place that runs farther over it in a substep, and is that many times as fast as its spin
// makes all else, is not where it was taken to be.
constexpr double kFar = 0.5;
constexpr double kFaster = 2;
// m: what turning lifts by more in a substep changes so much meanwhile that it would lose touch, and keep as energy
// what was too much. It is lifted by so much, and the rest is an overlap that costs it some.
constexpr double kLiftMost = 3e-4;
// Points around a rim: what touches at so many stands on it.
constexpr uint32_t kWide = 3;

// s: how long a velocity that turns by `spin` has to be led across it to become its mean in `h` seconds. Half of them,
// while that turns it little.
double TimeOfBend(const Vector3& spin, double h) {
  constexpr double kLittle = 0.1;  // rad
  const double square = spin.squaredNorm() * (h * h);
  return square < kLittle * kLittle ? h * (0.5 - square / 24) : h * (1 - std::cos(std::sqrt(square))) / square;
}

// How fast the place at which two touch runs over either of them, m/s.
struct Course {
  Eigen::Vector2d over_a = Eigen::Vector2d::Zero();
  Eigen::Vector2d over_b = Eigen::Vector2d::Zero();
  Eigen::Matrix2d told = Eigen::Matrix2d::Zero();  // projects on where curvature tells it
};

// `turn`: rad/s, by how the normal turns more on b than on a, where both are held. `slip`: m/s, of b against a.
Course CourseOf(const Curvature& a, const Curvature& b, const Eigen::Vector2d& turn, const Eigen::Vector2d& slip) {
  Course course;
  const Eigen::Matrix2d both = a + b;
  const double trace = both.trace(), determinant = both.determinant();
  Eigen::Matrix2d radii = Eigen::Matrix2d::Zero();
  if (determinant > kFlat * trace) {
    radii << both(1, 1), -both(0, 1), -both(1, 0), both(0, 0);
    radii /= determinant;
    course.told.setIdentity();
  } else if (trace > kFlat) {
    // Curved in one direction alone.
    course.told = both / trace;
    radii = course.told / trace;
  }
  course.over_a = radii * (turn + b * slip);
  course.over_b = radii * (turn - a * slip);
  return course;
}

}  // namespace

// One of two that touch.
struct StepRun::BendSide {
  const Shape* shape = nullptr;
  Pose pose;                                // of the geometry
  Vector3 center = Vector3::Zero();         // m, of mass
  Vector3 velocity = Vector3::Zero();       // m/s
  Vector3 spin = Vector3::Zero();           // rad/s
  double size = 0;                          // m
  double sign = 1;                          // of the normal that points outward
  Curvature curvature = Curvature::Zero();  // where they touch
  Vector3 at_point = Vector3::Zero();       // m/s, of what it is made of there

  void Look(const Vector3& place, const Vector3& normal, const Tangents& tangents, bool is_wide) {
    const Matrix3 back = pose.orientation.conjugate().toRotationMatrix();
    curvature = CurvatureAt(*shape, back * (place - pose.position), sign * (back * normal), back * tangents, is_wide);
    at_point = velocity + spin.cross(place - center);
  }
  // m/s, on the mean of `h` seconds: how much faster that goes at the place, which runs over it.
  Vector3 Change(const Vector3& over, double h) const {
    return TimeOfBend(spin, h) * spin.cross(at_point - velocity + over);
  }
};

StepRun::BendSide StepRun::BendSideOf(EntityRow entity, GeometryRow row, double sign) const {
  const GeometryRows& rows = world_.geometry_rows_[Index(entity)];
  const auto place = static_cast<size_t>(std::find(rows.begin(), rows.end(), row) - rows.begin());
  const Geometry& geometry = world_.scene_.entities[Index(entity)]->desc->rigid_body->geometries[place];
  return {.shape = &geometry.shape,
          .pose = state_.pose(entity).Transform(geometry.pose_in_entity),
          .center = CenterOf(entity),
          .velocity = state_.linear_velocities.col(Index(entity)),
          .spin = state_.angular_velocities.col(Index(entity)),
          .size = world_.reaches_[Index(entity)],
          .sign = sign};
}

// By how much more than at its beginning b slips against a on the mean of a substep, where they touch at a point, and
// parts from it.
StepRun::Bend StepRun::RolledBend(const ContactPair& pair, const ContactPoint& point, double h) const {
  BendSide a = BendSideOf(pair.entity_a, pair.geometry_a, 1), b = BendSideOf(pair.entity_b, pair.geometry_b, -1);
  const Vector3& normal = point.normal;
  Tangents tangents;
  tangents.col(0) = normal.unitOrthogonal();
  tangents.col(1) = normal.cross(tangents.col(0));
  for (BendSide* const side : {&a, &b}) side->Look(point.position, normal, tangents, pair.point_count >= kWide);
  const Vector3 slip = b.at_point - a.at_point, turn = (b.spin - a.spin).cross(normal);
  const Eigen::Vector2d slip_across = tangents.transpose() * slip;
  const Course course = CourseOf(a.curvature, b.curvature, tangents.transpose() * turn, slip_across);
  const Vector3 over_a = tangents * course.over_a, over_b = tangents * course.over_b;
  const double speed = std::max(over_a.norm(), over_b.norm()), size = std::min(a.size, b.size);
  if (speed * h > kFar * size && speed > kFaster * turn.norm() * size + slip.norm()) return {};
  // Where nothing curved tells it, the place stays with both of what slips, or goes half with each of them.
  const Vector3 between = tangents * (slip_across - course.told * slip_across) / 2;
  const Vector3 turning =
      ((a.spin + b.spin).cross(normal) + tangents * (a.curvature * course.over_a - b.curvature * course.over_b)) / 2;
  const Vector3 parting = b.Change(over_b - between, h) - a.Change(over_a + between, h);
  const double lift = h * (parting.dot(normal) + h / 2 * turning.dot(slip));
  return {b.Change(over_b, h) - a.Change(over_a, h), std::clamp(lift, -kLiftMost, kLiftMost) / h};
}

// The same of two that are flat, which touch at corners of either of them: those go round with it.
Vector3 StepRun::FlatBend(const ContactPair& pair, const Vector3& place, double h) const {
  const auto change = [&](EntityRow entity) -> Vector3 {
    const Vector3 spin = state_.angular_velocities.col(Index(entity));
    return TimeOfBend(spin, h) * spin.cross(spin.cross(place - CenterOf(entity)));
  };
  return change(pair.entity_b) - change(pair.entity_a);
}

// Of all pairs, while velocities are those at the beginning: what pushes until the middle may be held.
void StepRun::FindBends(double h) {
  const auto turns = [&](EntityRow row) {
    return state_.angular_velocities.col(Index(row)).squaredNorm() * (h * h) > kNoTurn * kNoTurn;
  };
  const auto is_smooth = [](const MixedMaterial& material) {
    return material.friction == 0 && material.kinetic_friction == 0;
  };
  for (ContactPoint& point : world_.contacts_.points) point.bend = 0;
  scratch_.bends.clear();
  for (const ContactPair& pair : world_.contacts_.pairs) {
    Vector3& bend = scratch_.bends.emplace_back(Vector3::Zero());
    if (pair.is_sensor || !(turns(pair.entity_a) || turns(pair.entity_b))) continue;
    if (!world_.rule_.info(pair.geometry_a).rolls && !world_.rule_.info(pair.geometry_b).rolls) {
      const auto points = std::span(world_.contacts_.points).subspan(pair.first_point, pair.point_count);
      const bool is_led = scratch_.jointed[pair.entity_a] || scratch_.jointed[pair.entity_b];
      Vector3 middle = Vector3::Zero();
      for (ContactPoint& point : points) {
        middle += point.position / pair.point_count;
        // What joints lead into something turns as that bends it, and not as it will.
        if (is_led) continue;
        const double parting = FlatBend(pair, point.position, h).dot(point.normal);
        point.bend = std::clamp(parting, -kLiftMost / h, kLiftMost / h);
      }
      if (!is_smooth(pair.material)) bend = FlatBend(pair, middle, h);
      continue;
    }
    for (ContactPoint& point : std::span(world_.contacts_.points).subspan(pair.first_point, pair.point_count)) {
      const Bend rolled = RolledBend(pair, point, h);
      bend += rolled.slip / pair.point_count;
      point.bend = rolled.parting;
    }
  }
}

}  // namespace genphys

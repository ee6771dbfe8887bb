#include "impact_newton.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace genphys {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

constexpr int kIterationsMax = 40;
constexpr int kPatience = 8;
// Parts of friction by which it is brought in.
constexpr std::array<double, 4> kFrictions{0, 0.3, 0.7, 1};
// m/s.
constexpr double kSettled = 1e-12;

// Rates and impulses of all blows in a column, three each: along the normal and across it, twice.
class System {
 public:
  System(std::span<const Blow> blows, std::span<const StruckBody> bodies)
      : blows_(blows), answers_(Size(), Size()), impulses_(Size()), free_(Size()), scales_(blows.size()) {
    for (const Blow& blow : blows) {
      Matrix3& axes = axes_.emplace_back();
      axes.col(0) = blow.normal;
      axes.col(1) = blow.normal.unitOrthogonal();
      axes.col(2) = blow.normal.cross(axes.col(1));
    }
    for (Eigen::Index i = 0; i < Count(); ++i) {
      for (Eigen::Index j = 0; j < Count(); ++j) answers_.block<3, 3>(3 * i, 3 * j) = Answer(bodies, At(i), At(j));
    }
    for (Eigen::Index i = 0; i < Count(); ++i) {
      const Blow& blow = blows[At(i)];
      impulses_.segment<3>(3 * i) = axes_[At(i)].transpose() * (blow.impulse * blow.normal + blow.rubbing);
      free_.segment<3>(3 * i) = axes_[At(i)].transpose() * RelativeVelocity(blow, bodies);
      free_[3 * i] -= blow.separation_speed;
      scales_[i] = std::max(answers_.diagonal().segment<3>(3 * i).maxCoeff(), std::numeric_limits<double>::min());
    }
    free_ -= answers_ * impulses_;
  }

  const VectorXd& impulses() const { return impulses_; }
  Vector3 ImpulseOn(const VectorXd& impulses, size_t blow) const {
    return axes_[blow] * impulses.segment<3>(3 * static_cast<Eigen::Index>(blow));
  }

  // What `impulses` lack to be as the laws want them, m/s, with that part of friction, and how that changes with them.
  VectorXd Lacking(const VectorXd& impulses, double friction, MatrixXd* slope) const {
    const VectorXd rates = free_ + answers_ * impulses;
    VectorXd lacking(Size());
    if (slope != nullptr) *slope = MatrixXd::Zero(Size(), Size());
    for (Eigen::Index i = 0; i < Count(); ++i)
      LackingOf(i, friction * blows_[At(i)].friction, impulses, rates, lacking, slope);
    return lacking;
  }

 private:
  Eigen::Index Count() const { return static_cast<Eigen::Index>(blows_.size()); }
  Eigen::Index Size() const { return 3 * Count(); }
  static size_t At(Eigen::Index i) { return static_cast<size_t>(i); }

  // How the rates of one blow change with the impulses of another.
  Matrix3 Answer(std::span<const StruckBody> bodies, size_t to, size_t of) const {
    const Blow &one = blows_[to], &other = blows_[of];
    Matrix3 sum = Matrix3::Zero();
    for (const auto& [here, sign] : {std::pair(one.body_a, -1.0), std::pair(one.body_b, 1.0)}) {
      for (const auto& [there, other_sign] : {std::pair(other.body_a, -1.0), std::pair(other.body_b, 1.0)}) {
        if (here != there) continue;
        const StruckBody& body = bodies[here];
        const Matrix3 shift = body.inverse_mass * body.freedom.asDiagonal().toDenseMatrix();
        const Matrix3 turn =
            Skew(one.position - body.center) * body.inverse_tensor * Skew(other.position - body.center);
        sum += sign * other_sign * (shift - turn);
      }
    }
    return axes_[to].transpose() * sum * axes_[of];
  }

  static Matrix3 Skew(const Vector3& v) {
    Matrix3 skew;
    skew << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return skew;
  }

  // Each law says that an impulse is the nearest one that may be to itself less a multiple of its rate.
  void LackingOf(Eigen::Index blow, double friction, const VectorXd& impulses, const VectorXd& rates, VectorXd& lacking,
                 MatrixXd* slope) const {
    const Eigen::Index n = 3 * blow;
    const double scale = scales_[blow];
    const double pressed = scale * impulses[n] - rates[n];
    const Vector2 rubbed = scale * impulses.segment<2>(n + 1) - rates.segment<2>(n + 1);
    const bool presses = pressed > 0;
    const double bound = friction * std::max(pressed, 0.0), size = rubbed.norm();
    const bool slips = size > bound;
    lacking[n] = presses ? rates[n] : scale * impulses[n];
    const Vector2 way = size > 0 ? Vector2(rubbed / size) : Vector2(Vector2::Zero());
    lacking.segment<2>(n + 1) =
        slips ? Vector2(scale * impulses.segment<2>(n + 1) - bound * way) : Vector2(rates.segment<2>(n + 1));
    if (slope == nullptr) return;
    if (presses) {
      slope->row(n) = answers_.row(n);
    } else {
      (*slope)(n, n) = scale;
    }
    if (!slips) {
      slope->middleRows<2>(n + 1) = answers_.middleRows<2>(n + 1);
      return;
    }
    slope->block<2, 2>(n + 1, n + 1) = scale * Matrix2::Identity();
    if (!presses || !(friction > 0)) return;
    MatrixXd press = -answers_.row(n), rub = -answers_.middleRows<2>(n + 1);
    press(0, n) += scale;
    rub.block<2, 2>(0, n + 1) += scale * Matrix2::Identity();
    const Matrix2 turned = (Matrix2::Identity() - way * way.transpose()) / size;
    slope->middleRows<2>(n + 1) -= friction * way * press + bound * turned * rub;
  }

  std::span<const Blow> blows_;
  std::vector<Matrix3> axes_;
  MatrixXd answers_;   // 1/kg
  VectorXd impulses_;  // N*s
  VectorXd free_;      // m/s, without impulses and beyond what is asked for
  VectorXd scales_;    // 1/kg, by blow
};

// From `impulses` as near to the laws as it comes, with a part of friction; returns what is left, m/s.
double Approach(const System& system, double friction, VectorXd& impulses) {
  VectorXd present = impulses;
  MatrixXd slope;
  VectorXd lacking = system.Lacking(present, friction, &slope);
  double left = lacking.norm();
  for (int i = 0, since = 0; i < kIterationsMax && since < kPatience && left > kSettled; ++i, ++since) {
    // Points of a face bear a load in many ways: of all changes that do it the smallest.
    present -= slope.completeOrthogonalDecomposition().solve(lacking);
    lacking = system.Lacking(present, friction, &slope);
    if (!(lacking.norm() < left)) continue;
    since = 0;
    left = lacking.norm();
    impulses = present;
  }
  return left;
}

}  // namespace

bool SolveAtOnce(std::span<Blow> blows, std::span<const StruckBody> bodies) {
  const System system(blows, bodies);
  const double before = system.Lacking(system.impulses(), 1, nullptr).norm();
  VectorXd impulses = system.impulses();
  double left = Approach(system, 1, impulses);
  if (left > kSettled) {
    // Who slips where depends on how hard all press, which without friction is a matter of one solution.
    VectorXd others = VectorXd::Zero(impulses.size());
    double other_left = 0;
    for (const double friction : kFrictions) other_left = Approach(system, friction, others);
    if (other_left < left) {
      left = other_left;
      impulses = others;
    }
  }
  if (!(left < before)) return false;
  for (size_t i = 0; i < blows.size(); ++i) {
    const Vector3 impulse = system.ImpulseOn(impulses, i);
    blows[i].impulse = std::max(impulse.dot(blows[i].normal), 0.0);
    blows[i].rubbing = impulse - impulse.dot(blows[i].normal) * blows[i].normal;
  }
  return true;
}

}  // namespace genphys

#include "impact_newton.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace genphys {
namespace {

constexpr int kSizeMax = 3 * static_cast<int>(kBlowsAtOnce);
using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

constexpr int kIterationsMax = 40;
// Iterations in a row that may come no nearer.
constexpr int kPatience = 8, kHaste = 2;
// Parts of friction by which it is brought in.
constexpr std::array<double, 4> kFrictions{0, 0.3, 0.7, 1};
// m/s.
constexpr double kSettled = 1e-12;
// Of how a blow gives way: so much more it does in a step of the method. Points of a face bear a load in many ways, of
// all of which this takes the smallest change.
constexpr double kGive = 1e-8;

// Rates and impulses of all blows in a column, three each: along the normal and across it, twice. `kCount` is how many
// there are, if that is known beforehand, or Eigen::Dynamic.
template <int kCount>
class System {
 public:
  static constexpr int kSize = kCount == Eigen::Dynamic ? Eigen::Dynamic : 3 * kCount;
  static constexpr int kRoom = kCount == Eigen::Dynamic ? kSizeMax : 3 * kCount;
  using Column = Eigen::Matrix<double, kSize, 1, 0, kRoom, 1>;
  using Square = Eigen::Matrix<double, kSize, kSize, 0, kRoom, kRoom>;

  System(std::span<const Blow> blows, std::span<const StruckBody> bodies, std::span<const OfBlow> rates)
      : blows_(blows), answers_(Size(), Size()), impulses_(Size()), free_(Size()) {
    for (size_t i = 0; i < blows.size(); ++i) {
      axes_[i].col(0) = blows[i].normal;
      axes_[i].col(1) = blows[i].normal.unitOrthogonal();
      axes_[i].col(2) = blows[i].normal.cross(axes_[i].col(1));
    }
    for (Eigen::Index i = 0; i < Count(); ++i) {
      for (Eigen::Index j = i; j < Count(); ++j) {
        const Matrix3 answer = Answer(bodies, At(i), At(j));
        answers_.template block<3, 3>(3 * i, 3 * j) = answer;
        answers_.template block<3, 3>(3 * j, 3 * i) = answer.transpose();
      }
      const Blow& blow = blows[At(i)];
      impulses_.template segment<3>(3 * i) = axes_[At(i)].transpose() * (blow.impulse * blow.normal + blow.rubbing);
      free_.template segment<3>(3 * i) = rates[At(i)];
      scales_[At(i)] =
          std::max(answers_.diagonal().template segment<3>(3 * i).maxCoeff(), std::numeric_limits<double>::min());
    }
    free_.noalias() -= answers_ * impulses_;
  }

  const Column& impulses() const { return impulses_; }
  Vector3 ImpulseOn(const Column& impulses, size_t blow) const {
    return axes_[blow] * impulses.template segment<3>(3 * static_cast<Eigen::Index>(blow));
  }

  // What `impulses` lack to be as the laws want them, m/s, with that part of friction, and how that changes with them
  // where every blow gives way a little.
  Column Lacking(const Column& impulses, double friction, Square* slope) const {
    Column rates = free_;
    rates.noalias() += answers_ * impulses;
    Column lacking(Size());
    if (slope != nullptr) *slope = Square::Zero(Size(), Size());
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
        if (here != there || bodies[here].inverse_mass == 0) continue;
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
  void LackingOf(Eigen::Index blow, double friction, const Column& impulses, const Column& rates, Column& lacking,
                 Square* slope) const {
    const Eigen::Index n = 3 * blow;
    const double scale = scales_[At(blow)];
    const double pressed = scale * impulses[n] - rates[n];
    const Vector2 rubbed = scale * impulses.template segment<2>(n + 1) - rates.template segment<2>(n + 1);
    const bool presses = pressed > 0;
    const double bound = friction * std::max(pressed, 0.0), size = rubbed.norm();
    const bool slips = size > bound;
    lacking[n] = presses ? rates[n] : scale * impulses[n];
    const Vector2 way = size > 0 ? Vector2(rubbed / size) : Vector2(Vector2::Zero());
    lacking.template segment<2>(n + 1) = slips ? Vector2(scale * impulses.template segment<2>(n + 1) - bound * way)
                                               : Vector2(rates.template segment<2>(n + 1));
    if (slope == nullptr) return;
    if (presses) {
      slope->row(n) = answers_.row(n);
      (*slope)(n, n) += kGive * scale;
    } else {
      (*slope)(n, n) = scale;
    }
    if (!slips) {
      slope->template middleRows<2>(n + 1) = answers_.template middleRows<2>(n + 1);
      slope->diagonal().template segment<2>(n + 1).array() += kGive * scale;
      return;
    }
    slope->template block<2, 2>(n + 1, n + 1) = scale * Matrix2::Identity();
    if (!presses || !(friction > 0)) return;
    Eigen::Matrix<double, 1, kSize, Eigen::RowMajor, 1, kRoom> press = -answers_.row(n);
    Eigen::Matrix<double, 2, kSize, 0, 2, kRoom> rub = -answers_.template middleRows<2>(n + 1);
    press[n] += scale;
    rub.template block<2, 2>(0, n + 1) += scale * Matrix2::Identity();
    const Matrix2 turned = bound / size * (Matrix2::Identity() - way * way.transpose());
    slope->template middleRows<2>(n + 1).noalias() -= friction * way * press;
    slope->template middleRows<2>(n + 1).noalias() -= turned.lazyProduct(rub);
  }

  std::span<const Blow> blows_;
  std::array<Matrix3, kBlowsAtOnce> axes_;
  Square answers_;                           // 1/kg
  Column impulses_;                          // N*s
  Column free_;                              // m/s, without impulses and beyond what is asked for
  std::array<double, kBlowsAtOnce> scales_;  // 1/kg, by blow
};

// From `impulses` as near to the laws as it comes before so many iterations do not help, with a part of friction;
// returns what is left, m/s.
template <typename System>
double Approach(const System& system, double friction, int patience, typename System::Column& impulses) {
  typename System::Column present = impulses;
  typename System::Square slope;
  typename System::Column lacking = system.Lacking(present, friction, &slope);
  double left = lacking.norm();
  for (int i = 0, since = 0; i < kIterationsMax && since < patience && left > kSettled; ++i, ++since) {
    present -= slope.partialPivLu().solve(lacking);
    lacking = system.Lacking(present, friction, &slope);
    if (!(lacking.norm() < left)) continue;
    since = 0;
    left = lacking.norm();
    impulses = present;
  }
  return left;
}

template <int kCount>
bool SolveSo(std::span<Blow> blows, std::span<const StruckBody> bodies, std::span<const OfBlow> rates,
             bool thoroughly) {
  using Column = typename System<kCount>::Column;
  const System<kCount> system(blows, bodies, rates);
  const double before = system.Lacking(system.impulses(), 1, nullptr).norm();
  Column impulses = system.impulses();
  double left = Approach(system, 1, thoroughly ? kPatience : kHaste, impulses);
  if (left > kSettled && thoroughly) {
    // Who slips where depends on how hard all press, which without friction is a matter of one solution.
    Column others = Column::Zero(impulses.size());
    double other_left = 0;
    for (const double friction : kFrictions) other_left = Approach(system, friction, kPatience, others);
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

}  // namespace

bool SolveAtOnce(std::span<Blow> blows, std::span<const StruckBody> bodies, std::span<const OfBlow> rates,
                 bool thoroughly) {
  // Mostly the corners of a face.
  const auto solve = blows.size() == 4 ? &SolveSo<4> : &SolveSo<Eigen::Dynamic>;
  return solve(blows, bodies, rates, thoroughly);
}

}  // namespace genphys

#include "impacts/impact_newton.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace genphys {
namespace {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

constexpr int kIterationsMax = 40;
// Iterations in a row that may come no nearer.
constexpr int kPatience = 8, kHaste = 2;
// Parts of friction by which it is brought in.
constexpr std::array<double, 4> kFrictions{0, 0.3, 0.7, 1};
// m/s.
constexpr double kSettled = 1e-12;
// A part of what is lacking. What something that moves by itself presses against what nothing moves has no solution,
// and the impulses that come a little nearer to none grow without end.
constexpr double kNearEnough = 0.01;
// Of how a blow gives way: so much more it does in a step of the method. Points of a face bear a load in many ways, of
// all of which this takes the smallest change.
constexpr double kGive = 1e-8;

// Which law a blow obeys: it has no impulse, holds its bodies together, rubs as hard as it can, or presses where
// nothing can rub.
enum class Law : uint8_t { kParts, kGrips, kSlips, kGlides };

// Rates and impulses of all blows in a column, three each: along the normal and across it, twice. `kCount` is how many
// there are, if that is known beforehand, or Eigen::Dynamic; `kMost` is how many there may be.
template <int kCount, size_t kMost>
class System {
 public:
  static constexpr int kSize = kCount == Eigen::Dynamic ? Eigen::Dynamic : 3 * kCount;
  // More would be too much for a stack.
  static constexpr int kRoom = kMost <= kBlowsAtOnce ? 3 * static_cast<int>(kMost) : Eigen::Dynamic;
  using Laws = std::array<Law, kMost>;
  using Column = Eigen::Matrix<double, kSize, 1, 0, kRoom, 1>;
  using Square = Eigen::Matrix<double, kSize, kSize, 0, kRoom, kRoom>;

  // Impulses as the laws see them, with a part of friction.
  struct Look {
    Column impulses;
    Column rates;
    Column lacking;  // to be as the laws want them, m/s
    Laws laws{};

    // Impulses between these two change what is lacking in proportion.
    bool IsAlongALineWith(const Look& other) const {
      return laws == other.laws && std::ranges::find(laws, Law::kSlips) == laws.end();
    }
  };

  /// On bodies that nothing ties together.
  System(std::span<const Blow> blows, std::span<const StruckBody> bodies, std::span<const OfBlow> rates)
      : System(blows) {
    std::array<std::array<Side, 2>, kMost> sides;
    for (size_t i = 0; i < blows.size(); ++i) {
      for (const bool of_b : {false, true}) sides[i][of_b] = SideOf(blows[i], axes_[i], of_b, bodies);
    }
    for (Eigen::Index i = 0; i < Count(); ++i) {
      for (Eigen::Index j = i; j < Count(); ++j) {
        const Matrix3 answer = Answer(sides[At(i)], sides[At(j)]);
        answers_.template block<3, 3>(3 * i, 3 * j) = answer;
        answers_.template block<3, 3>(3 * j, 3 * i) = answer.transpose();
      }
    }
    Begin(rates);
  }

  /// Of which is known how `rates` answer to impulses, 1/kg.
  System(std::span<const Blow> blows, const Eigen::MatrixXd& answers, std::span<const OfBlow> rates) : System(blows) {
    answers_ = answers;
    Begin(rates);
  }

  const Column& impulses() const { return impulses_; }
  Vector3 ImpulseOn(const Column& impulses, size_t blow) const {
    return axes_[blow] * impulses.template segment<3>(3 * static_cast<Eigen::Index>(blow));
  }

  Look At(const Column& impulses, double friction) const {
    Look look{.impulses = impulses, .rates = free_, .lacking = Column(Size())};
    look.rates.noalias() += answers_ * impulses;
    for (Eigen::Index i = 0; i < Count(); ++i) Judge(i, friction * blows_[At(i)].friction, look);
    return look;
  }

  // How what is lacking changes with impulses where every blow gives way a little.
  Square SlopeAt(const Look& look, double friction) const {
    Square slope = Square::Zero(Size(), Size());
    for (Eigen::Index i = 0; i < Count(); ++i) FillSlope(i, friction * blows_[At(i)].friction, look, slope);
    return slope;
  }

 private:
  // What impulses along the three axes of a blow do to one of its bodies.
  struct Side {
    uint32_t body = 0;
    bool is_movable = false;
    Matrix3 push;   // along which they act
    Matrix3 shift;  // m/s per N*s
    Matrix3 lever;  // m
    Matrix3 turn;   // rad/s per N*s
  };

  explicit System(std::span<const Blow> blows)
      : blows_(blows), answers_(Size(), Size()), impulses_(Size()), free_(Size()) {
    for (size_t i = 0; i < blows.size(); ++i) {
      axes_[i].col(0) = blows[i].normal;
      axes_[i].col(1) = blows[i].normal.unitOrthogonal();
      axes_[i].col(2) = blows[i].normal.cross(axes_[i].col(1));
    }
  }

  void Begin(std::span<const OfBlow> rates) {
    for (Eigen::Index i = 0; i < Count(); ++i) {
      const Blow& blow = blows_[At(i)];
      impulses_.template segment<3>(3 * i) = axes_[At(i)].transpose() * (blow.impulse * blow.normal + blow.rubbing);
      free_.template segment<3>(3 * i) = rates[At(i)];
      scales_[At(i)] =
          std::max(answers_.diagonal().template segment<3>(3 * i).maxCoeff(), std::numeric_limits<double>::min());
    }
    free_.noalias() -= answers_ * impulses_;
  }

  Eigen::Index Count() const { return static_cast<Eigen::Index>(blows_.size()); }
  Eigen::Index Size() const { return 3 * Count(); }
  static size_t At(Eigen::Index i) { return static_cast<size_t>(i); }

  static Side SideOf(const Blow& blow, const Matrix3& axes, bool of_b, std::span<const StruckBody> bodies) {
    Side side{.body = of_b ? blow.body_b : blow.body_a};
    const StruckBody& body = bodies[side.body];
    side.is_movable = body.inverse_mass != 0;
    if (!side.is_movable) return side;
    side.push = of_b ? axes : Matrix3(-axes);
    side.shift = body.inverse_mass * body.freedom.asDiagonal() * side.push;
    const Vector3 arm = blow.position - body.center;
    for (int i = 0; i < 3; ++i) side.lever.col(i) = arm.cross(side.push.col(i));
    side.turn = body.inverse_tensor * side.lever;
    return side;
  }

  // How the rates of one blow change with the impulses of another.
  static Matrix3 Answer(std::span<const Side, 2> to, std::span<const Side, 2> of) {
    Matrix3 sum = Matrix3::Zero();
    for (const Side& here : to) {
      for (const Side& there : of) {
        if (here.body != there.body || !here.is_movable) continue;
        sum += here.push.transpose().lazyProduct(there.shift) + here.lever.transpose().lazyProduct(there.turn);
      }
    }
    return sum;
  }

  // Each law says that an impulse is the nearest one that may be to itself less a multiple of its rate: this less that.
  Vector2 Rubbed(Eigen::Index n, const Look& look) const {
    return scales_[At(n / 3)] * look.impulses.template segment<2>(n + 1) - look.rates.template segment<2>(n + 1);
  }
  double Pressed(Eigen::Index n, const Look& look) const {
    return scales_[At(n / 3)] * look.impulses[n] - look.rates[n];
  }

  // Finds out which law a blow obeys, and what it lacks.
  void Judge(Eigen::Index blow, double friction, Look& look) const {
    const Eigen::Index n = 3 * blow;
    const double scale = scales_[At(blow)], pressed = Pressed(n, look);
    const bool presses = pressed > 0;
    const double bound = presses ? friction * pressed : 0;
    const Vector2 rubbed = Rubbed(n, look);
    const bool slips = !(bound > 0) || rubbed.norm() > bound;
    look.lacking[n] = presses ? look.rates[n] : scale * look.impulses[n];
    look.lacking.template segment<2>(n + 1) = slips ? Vector2(scale * look.impulses.template segment<2>(n + 1))
                                                    : Vector2(look.rates.template segment<2>(n + 1));
    if (slips && bound > 0) look.lacking.template segment<2>(n + 1) -= bound * rubbed.normalized();
    look.laws[At(blow)] = !presses ? Law::kParts : !slips ? Law::kGrips : bound > 0 ? Law::kSlips : Law::kGlides;
  }

  void FillSlope(Eigen::Index blow, double friction, const Look& look, Square& slope) const {
    const Eigen::Index n = 3 * blow;
    const double scale = scales_[At(blow)];
    const Law law = look.laws[At(blow)];
    const int held = law == Law::kParts ? 0 : law == Law::kGrips ? 3 : 1;
    for (int i = 0; i < 3; ++i) {
      if (i < held) slope.row(n + i) = answers_.row(n + i);
      slope(n + i, n + i) += i < held ? kGive * scale : scale;
    }
    if (law != Law::kSlips) return;
    const Vector2 rubbed = Rubbed(n, look);
    const double size = rubbed.norm();
    const Vector2 way = rubbed / size;
    Eigen::Matrix<double, 1, kSize, Eigen::RowMajor, 1, kRoom> press = -answers_.row(n);
    Eigen::Matrix<double, 2, kSize, 0, 2, kRoom> rub = -answers_.template middleRows<2>(n + 1);
    press[n] += scale;
    rub.template block<2, 2>(0, n + 1) += scale * Matrix2::Identity();
    const Matrix2 turned = friction * Pressed(n, look) / size * (Matrix2::Identity() - way * way.transpose());
    slope.template middleRows<2>(n + 1).noalias() -= friction * way * press;
    slope.template middleRows<2>(n + 1).noalias() -= turned.lazyProduct(rub);
  }

  std::span<const Blow> blows_;
  std::array<Matrix3, kMost> axes_;
  Square answers_;                    // 1/kg
  Column impulses_;                   // N*s
  Column free_;                       // m/s, without impulses and beyond what is asked for
  std::array<double, kMost> scales_;  // 1/kg, by blow
};

// From `impulses` as near to the laws as it comes before so many iterations do not help, with a part of friction;
// returns what is left, m/s.
template <typename System>
double Approach(const System& system, double friction, int patience, typename System::Column& impulses) {
  using Look = typename System::Look;
  Look present = system.At(impulses, friction);
  Eigen::PartialPivLU<typename System::Square> slope(impulses.size());
  bool is_known = false;
  double left = present.lacking.norm();
  for (int i = 0, since = 0; i < kIterationsMax && since < patience && left > kSettled; ++i, ++since) {
    if (!is_known) slope.compute(system.SlopeAt(present, friction));
    const Look next = system.At(present.impulses - slope.solve(present.lacking), friction);
    // Mostly the second iteration only takes away what giving way has left of the first one.
    is_known = next.IsAlongALineWith(present);
    present = next;
    const double lacking = present.lacking.norm();
    if (!(lacking < left)) continue;
    since = 0;
    left = lacking;
    impulses = present.impulses;
  }
  return left;
}

// It leaves no more than that part of what is lacking, or does nothing.
template <typename System>
bool SolveSo(std::span<Blow> blows, const System& system, bool thoroughly, double most = 1) {
  using Column = typename System::Column;
  const double before = system.At(system.impulses(), 1).lacking.norm();
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
  if (!(left < most * before)) return false;
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
  if (blows.size() == 4) return SolveSo(blows, System<4, 4>(blows, bodies, rates), thoroughly);
  return SolveSo(blows, System<Eigen::Dynamic, kBlowsAtOnce>(blows, bodies, rates), thoroughly);
}

bool SolveTiedAtOnce(std::span<Blow> blows, const Eigen::MatrixXd& answers, std::span<const OfBlow> rates,
                     bool thoroughly) {
  return SolveSo(blows, System<Eigen::Dynamic, kTiedBlowsAtOnce>(blows, answers, rates), thoroughly, kNearEnough);
}

}  // namespace genphys

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "genphys/math.h"
#include "impacts/impact_solve.h"
#include "impacts/ties.h"

namespace genphys {

/// Three components and a zero: processors calculate with pairs of numbers.
using Padded = Eigen::Vector4d;

inline Padded Pad(const Vector3& v) { return {v.x(), v.y(), v.z(), 0}; }

/// Velocities of a body while blows change them, m/s and rad/s.
struct Speeds {
  Padded linear;
  Padded angular;
};

/// What an impulse of one along an axis does to a body that is tied to those that it hits.
struct Passed {
  uint32_t body = 0;
  Padded shift;  // m/s per N*s
  Padded turn;   // rad/s per N*s
};

/// What the two bodies of a blow do along an axis (from a to b) and what an impulse along it does to them and to those
/// that are tied to them.
class Along {
 public:
  /// Whom it is passed on to is added to `passed`.
  Along(const Vector3& axis, const Blow& blow, std::span<const StruckBody> bodies, Ties& ties,
        std::vector<Passed>& passed);

  /// How fast b goes this way against a, m/s.
  [[gnu::always_inline]] double Rate(const Speeds& a, const Speeds& b) const {
    return (axis_.cwiseProduct(b.linear - a.linear) + a_.lever.cwiseProduct(a.angular) +
            b_.lever.cwiseProduct(b.angular))
        .sum();
  }
  [[gnu::always_inline]] void Push(double impulse, Speeds& a, Speeds& b) const {
    a.linear += impulse * a_.shift;
    b.linear += impulse * b_.shift;
    a.angular += impulse * a_.turn;
    b.angular += impulse * b_.turn;
  }
  void PassOn(double impulse, std::span<const Passed> passed, std::span<Speeds> speeds) const {
    for (const Passed& to : passed.subspan(first_passed_, last_passed_ - first_passed_)) {
      speeds[to.body].linear += impulse * to.shift;
      speeds[to.body].angular += impulse * to.turn;
    }
  }
  /// Change of the rate per impulse along another axis, 1/kg.
  double Answer(const Along& to) const {
    return Rate({.linear = to.a_.shift, .angular = to.a_.turn}, {.linear = to.b_.shift, .angular = to.b_.turn});
  }
  /// That along this axis, if nobody were tied.
  double FreeAnswer(const StruckBody& a, const StruckBody& b) const;

 private:
  struct Side {
    Side(const Vector3& push, const Vector3& position, const StruckBody& body);

    Padded lever;  // m
    Padded shift;  // m/s per N*s
    Padded turn;   // rad/s per N*s
  };

  void Tie(const Vector3& axis, const Blow& blow, Ties& ties, std::vector<Passed>& passed);

  Padded axis_;
  Side a_;
  Side b_;
  size_t first_passed_;
  size_t last_passed_;
};

/// One blow against its two bodies. Impulses and rates are along its normal and two axes across it.
class Settling {
 public:
  /// The blow outlives it.
  Settling(Blow& blow, std::span<const StruckBody> bodies, Ties& ties, std::vector<Passed>& passed)
      : Settling(blow, blow.normal.unitOrthogonal(), bodies, ties, passed) {}

  const Blow& blow() const { return *blow_; }
  /// N*s, along the normal and across it.
  const Vector3& impulse() const { return impulse_; }
  /// One of its bodies is, to others.
  bool is_tied() const { return is_tied_; }
  /// An impulse along the normal changes how its bodies go.
  bool gives_way() const { return softness_ > 0; }

  void Restart(double separation_speed) {
    blow_->separation_speed = separation_speed;
    impulse_.setZero();
  }
  /// Tells the blow what it came to.
  void Finish();
  /// How much the rate along an axis changes per impulse along it, 1/kg.
  double Softness(int axis) const { return answers_(axis, axis); }
  /// Changes its impulse by `far`, N*s, as far as Coulomb lets it.
  void Leap(const Vector3& far, std::span<Speeds> speeds, std::span<const Passed> passed);
  /// How b goes against a, m/s.
  Vector3 Motion(std::span<const Speeds> speeds) const;
  /// Of that and of how the surfaces run, what is beyond what it is to do.
  Vector3 Rates(std::span<const Speeds> speeds) const;
  /// Changes `speeds` as an impulse (N*s) along one of the three axes does.
  void Push(int axis, double impulse, std::span<Speeds> speeds, std::span<const Passed> passed) const;
  /// Comes to the impulses of `solved`, which is this blow.
  void Take(const Blow& solved, std::span<Speeds> speeds, std::span<const Passed> passed);

  /// Brings the blow to what it is to be, as all others are now: all the way, or by one turn of its normal and then one
  /// of its friction, which costs less, and is all that is done where joints or locked axes hold a body. Both return by
  /// how much (m/s) a velocity had to be changed.
  double Settle(std::span<Speeds> speeds, std::span<const Passed> passed);
  double Relax(std::span<Speeds> speeds, std::span<const Passed> passed);

 private:
  Settling(Blow& blow, const Vector3& first, std::span<const StruckBody> bodies, Ties& ties,
           std::vector<Passed>& passed);

  Vector3 Settled(const Vector3& rates) const;
  Vector3 Slipped(const Vector3& free, double slip) const;
  Eigen::Vector2d Rubbed(const Eigen::Vector2d& slip, double bound) const;
  void Give(const Vector3& impulse, std::span<Speeds> speeds, std::span<const Passed> passed);

  Blow* blow_;
  Vector3 first_;  // across the normal
  Vector3 second_;
  Along along_[3];          // the normal and these
  Matrix3 answers_;         // change of rates per impulses, 1/kg
  Matrix3 stopping_;        // impulses that take away rates, kg; of what is neither tied nor locked
  Eigen::Vector2d run_;     // m/s along the two axes: see Blow
  Vector3 impulse_;         // N*s
  double softness_;         // 1/kg along the normal
  bool is_tied_;            // one of the two is, to others
  bool is_locked_ = false;  // in some direction no impulse changes its rate
};

}  // namespace genphys

#include "impact_solve.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "disjoint_sets.h"

namespace genphys {
namespace {

constexpr int kSweepsMax = 100;
// m/s: the sweeps end once no blow changed a velocity by more.
constexpr double kSettled = 1e-12;

// The matrix of the cross product with `v`.
Matrix3 Crossing(const Vector3& v) {
  Matrix3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// One of the two bodies of a blow, as seen from where it is hit.
struct Side {
  Side(StruckBody& struck, const Vector3& position)
      : body(struck),
        arm(position - struck.center),
        shove(struck.inverse_mass * struck.freedom),
        turn(struck.inverse_tensor * Crossing(arm)) {}

  Vector3 Velocity() const { return body.linear_velocity + body.angular_velocity.cross(arm); }
  void Push(const Vector3& impulse) {
    body.linear_velocity += shove.cwiseProduct(impulse);
    body.angular_velocity += turn * impulse;
  }
  // Change of the velocity here per impulse, 1/kg.
  Matrix3 Mobility() const { return Matrix3(shove.asDiagonal()) - Crossing(arm) * turn; }

  StruckBody& body;
  Vector3 arm;    // m, from the centre of mass
  Vector3 shove;  // 1/kg
  Matrix3 turn;   // rad/s per N*s
};

// One blow against its two bodies.
class Settling {
 public:
  Settling(Blow& blow, std::span<StruckBody> bodies)
      : blow_(blow),
        a_(bodies[blow.body_a], blow.position),
        b_(bodies[blow.body_b], blow.position),
        mobility_(a_.Mobility() + b_.Mobility()),
        softness_(blow.normal.dot(mobility_ * blow.normal)) {}

  // Each returns by how much (m/s) a velocity had to be changed.
  double Separate() {
    if (!(softness_ > 0)) return 0;
    const double lacking = blow_.separation_speed - Relative().dot(blow_.normal);
    const double impulse = std::max(lacking / softness_, -blow_.impulse);
    if (impulse == 0) return 0;
    blow_.impulse += impulse;
    Push(impulse * blow_.normal);
    return std::abs(impulse) * softness_;
  }

  double Rub() {
    const double bound = blow_.friction * blow_.impulse;
    if (!(bound > 0) && blow_.rubbing.isZero(0)) return 0;
    const Vector3 relative = Relative();
    const Vector3 slip = relative - relative.dot(blow_.normal) * blow_.normal;
    const double speed = slip.norm();
    Vector3 wanted = blow_.rubbing;
    double softness = 0;
    if (speed > 0) {
      const Vector3 along = slip / speed;
      softness = along.dot(mobility_ * along);
      if (softness > 0) wanted -= slip / softness;
    }
    const double size = wanted.norm();
    if (size > bound) wanted *= bound / size;
    const Vector3 impulse = wanted - blow_.rubbing;
    blow_.rubbing = wanted;
    Push(impulse);
    return impulse.norm() * softness;
  }

 private:
  Vector3 Relative() const { return b_.Velocity() - a_.Velocity(); }
  void Push(const Vector3& impulse) {
    a_.Push(-impulse);
    b_.Push(impulse);
  }

  Blow& blow_;
  Side a_;
  Side b_;
  Matrix3 mobility_;
  double softness_;  // 1/kg along the normal
};

// Sorts blows into groups that have no movable body in common, each in the order in which the blows came.
class Groups {
 public:
  Groups(std::span<const Blow> blows, std::span<const StruckBody> bodies) : sets_(bodies.size()) {
    const auto is_movable = [&](uint32_t body) { return bodies[body].inverse_mass > 0; };
    for (const Blow& blow : blows) {
      if (is_movable(blow.body_a) && is_movable(blow.body_b)) sets_.Join(blow.body_a, blow.body_b);
    }
    for (uint32_t i = 0; i < blows.size(); ++i) {
      const Blow& blow = blows[i];
      order_.emplace_back(sets_.Find(is_movable(blow.body_a) ? blow.body_a : blow.body_b), i);
    }
    std::sort(order_.begin(), order_.end());
  }

  // Calls visit(blow) for each blow, and done() after the last one of each group.
  template <typename Visit, typename Done>
  void Walk(Visit&& visit, Done&& done) const {
    for (size_t i = 0; i < order_.size(); ++i) {
      visit(order_[i].second);
      if (i + 1 == order_.size() || order_[i + 1].first != order_[i].first) done();
    }
  }

 private:
  DisjointSets sets_;
  std::vector<std::pair<uint32_t, uint32_t>> order_;  // root and blow
};

void Settle(std::vector<Settling>& group) {
  for (int sweep = 0; sweep < kSweepsMax; ++sweep) {
    double largest = 0;
    for (Settling& blow : group) largest = std::max({largest, blow.Separate(), blow.Rub()});
    if (largest <= kSettled) return;
  }
}

}  // namespace

Vector3 RelativeVelocity(const Blow& blow, std::span<const StruckBody> bodies) {
  return bodies[blow.body_b].VelocityAt(blow.position) - bodies[blow.body_a].VelocityAt(blow.position);
}

double KineticEnergy(std::span<const StruckBody> bodies) {
  double sum = 0;
  for (const StruckBody& body : bodies) {
    if (body.inverse_mass == 0) continue;
    sum += body.linear_velocity.squaredNorm() / body.inverse_mass +
           body.angular_velocity.dot(body.tensor * body.angular_velocity);
  }
  return sum / 2;
}

void SolveBlows(std::span<Blow> blows, std::span<StruckBody> bodies) {
  std::vector<Settling> group;
  Groups(blows, bodies)
      .Walk([&](uint32_t i) { group.emplace_back(blows[i], bodies); },
            [&] {
              Settle(group);
              group.clear();
            });
}

}  // namespace genphys

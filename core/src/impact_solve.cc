#include "impact_solve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "disjoint_sets.h"

namespace genphys {
namespace {

constexpr uint32_t kSweepsMax = 100;
// m/s: the sweeps end once no blow changed a velocity by more.
constexpr double kSettled = 1e-12;
// Or once so many in a row did not halve what they change, and that is no more than this part of the first change.
constexpr int kPatience = 8;
constexpr double kLittle = 1e-4;
// Kinetic energy may grow by rounding only.
constexpr double kEnergySlack = 1e-12;
constexpr int kEnergyBisections = 30;

// The matrix of the cross product with `v`.
Matrix3 Crossing(const Vector3& v) {
  Matrix3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// One of the two bodies of a blow, as seen from where it is hit.
struct Side {
  Side(StruckBody& struck, const Blow& blow)
      : body(struck),
        arm(blow.position - struck.center),
        shove(struck.inverse_mass * struck.freedom),
        turn(struck.inverse_tensor * Crossing(arm)),
        lever(arm.cross(blow.normal)),
        parting(shove.cwiseProduct(blow.normal)),
        parting_turn(turn * blow.normal) {}

  Vector3 Velocity() const { return body.linear_velocity + body.angular_velocity.cross(arm); }
  double Parting(const Vector3& normal) const {
    return normal.dot(body.linear_velocity) + lever.dot(body.angular_velocity);
  }
  void Push(const Vector3& impulse) {
    body.linear_velocity += shove.cwiseProduct(impulse);
    body.angular_velocity += turn * impulse;
  }
  // The same by an impulse along the normal.
  void Part(double impulse) {
    body.linear_velocity += impulse * parting;
    body.angular_velocity += impulse * parting_turn;
  }
  // Change of the velocity here per impulse, 1/kg.
  Matrix3 Mobility() const { return Matrix3(shove.asDiagonal()) - Crossing(arm) * turn; }

  StruckBody& body;
  Vector3 arm;           // m, from the centre of mass
  Vector3 shove;         // 1/kg
  Matrix3 turn;          // rad/s per N*s
  Vector3 lever;         // m, of the normal
  Vector3 parting;       // m/s per N*s along the normal
  Vector3 parting_turn;  // rad/s per N*s along the normal
};

// One blow against its two bodies.
class Settling {
 public:
  Settling(Blow& blow, std::span<StruckBody> bodies)
      : blow_(blow),
        a_(bodies[blow.body_a], blow),
        b_(bodies[blow.body_b], blow),
        mobility_(a_.Mobility() + b_.Mobility()),
        softness_(blow.normal.dot(mobility_ * blow.normal)) {}

  Blow& blow() { return blow_; }
  const Blow& blow() const { return blow_; }

  // Each returns by how much (m/s) a velocity had to be changed.
  double Separate() {
    if (!(softness_ > 0)) return 0;
    const double lacking = blow_.separation_speed - (b_.Parting(blow_.normal) - a_.Parting(blow_.normal));
    const double impulse = std::max(lacking / softness_, -blow_.impulse);
    if (impulse == 0) return 0;
    blow_.impulse += impulse;
    a_.Part(-impulse);
    b_.Part(impulse);
    return std::abs(impulse) * softness_;
  }

  double Rub() {
    const double bound = blow_.friction * blow_.impulse;
    if (!(bound > 0) && blow_.rubbing.isZero(0)) return 0;
    const Vector3 relative = b_.Velocity() - a_.Velocity();
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
    a_.Push(-impulse);
    b_.Push(impulse);
    return impulse.norm() * softness;
  }

 private:
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

// How sweeps come nearer. Two points of a body that are timed apart, and so lie a little askew, cannot both stand still
// while one leaves faster than the other: what is left of that no sweep takes away.
class Progress {
 public:
  // Whether a sweep that changed `largest` (m/s) left little, and was one of some that hardly changed less and less.
  bool IsStuck(double largest) {
    first_ = std::max(first_, largest);
    ++since_;
    if (largest <= least_ / 2) {
      least_ = largest;
      since_ = 0;
    }
    return since_ >= kPatience && largest <= kLittle * first_;
  }

 private:
  double first_ = 0;
  double least_ = std::numeric_limits<double>::infinity();
  int since_ = 0;  // sweeps since it was halved
};

// Blows that have no movable body in common with any other.
class Group {
 public:
  explicit Group(std::span<StruckBody> bodies) : bodies_(bodies), changed_in_(bodies.size(), 0) {}

  void Add(Blow& blow) { blows_.emplace_back(blow, bodies_); }
  void Clear() { blows_.clear(); }

  void Settle() {
    ForgetChanges();
    Progress progress;
    // Counted from one, so that each has a turn in the first.
    for (uint32_t sweep = 1; sweep <= kSweepsMax; ++sweep) {
      double largest = 0;
      for (Settling& settling : blows_) {
        const uint32_t a = settling.blow().body_a, b = settling.blow().body_b;
        // Neither has been changed since its last turn.
        if (changed_in_[a] + 1 < sweep && changed_in_[b] + 1 < sweep) continue;
        const double change = std::max(settling.Separate(), settling.Rub());
        if (change > kSettled) NoteChange(a, b, sweep);
        largest = std::max(largest, change);
      }
      if (largest <= kSettled || progress.IsStuck(largest)) return;
    }
  }

  void Restitute() {
    Remember();
    const double allowed = (1 + kEnergySlack) * Energy();
    Settle();
    if (is_driven_ || Energy() <= allowed) return;
    asked_.clear();
    for (const Settling& settling : blows_) asked_.push_back(settling.blow().separation_speed);
    double low = 0, high = 1;
    for (int i = 0; i < kEnergyBisections; ++i) {
      const double part = i + 1 < kEnergyBisections ? (low + high) / 2 : low;
      Return(part);
      Settle();
      (Energy() <= allowed ? low : high) = part;
    }
  }

 private:
  struct Velocities {
    uint32_t body = 0;
    Vector3 linear;
    Vector3 angular;
  };

  void ForgetChanges() {
    for (const Settling& settling : blows_) {
      for (const uint32_t body : {settling.blow().body_a, settling.blow().body_b}) changed_in_[body] = 0;
    }
  }

  // What cannot be moved stays as it is, or all on one ground would stir each other.
  void NoteChange(uint32_t a, uint32_t b, uint32_t sweep) {
    for (const uint32_t body : {a, b}) {
      if (bodies_[body].inverse_mass > 0) changed_in_[body] = sweep;
    }
  }

  // Marks in passing whom it has.
  void Remember() {
    before_.clear();
    is_driven_ = false;
    ForgetChanges();
    for (const Settling& settling : blows_) {
      for (const uint32_t each : {settling.blow().body_a, settling.blow().body_b}) {
        const StruckBody& body = bodies_[each];
        if (body.inverse_mass == 0) {
          is_driven_ |= !body.linear_velocity.isZero(0) || !body.angular_velocity.isZero(0);
        } else if (changed_in_[each] == 0) {
          changed_in_[each] = 1;
          before_.push_back({each, body.linear_velocity, body.angular_velocity});
        }
      }
    }
  }

  // To where it began, to ask for a part of the separation.
  void Return(double part) {
    for (const Velocities& each : before_) {
      bodies_[each.body].linear_velocity = each.linear;
      bodies_[each.body].angular_velocity = each.angular;
    }
    for (size_t i = 0; i < blows_.size(); ++i) {
      Blow& blow = blows_[i].blow();
      blow.separation_speed = part * asked_[i];
      blow.impulse = 0;
      blow.rubbing.setZero();
    }
  }

  // Kinetic, of all that can be moved, J.
  double Energy() const {
    double sum = 0;
    for (const Velocities& each : before_) {
      const StruckBody& body = bodies_[each.body];
      sum += body.linear_velocity.squaredNorm() / body.inverse_mass +
             body.angular_velocity.dot(body.tensor * body.angular_velocity);
    }
    return sum / 2;
  }

  std::span<StruckBody> bodies_;
  std::vector<Settling> blows_;
  std::vector<uint32_t> changed_in_;  // the last sweep, by body
  std::vector<Velocities> before_;
  std::vector<double> asked_;  // m/s, by blow
  bool is_driven_ = false;     // something that cannot be moved moves
};

template <typename Solve>
void SolveGroups(std::span<Blow> blows, std::span<StruckBody> bodies, Solve&& solve) {
  Group group(bodies);
  Groups(blows, bodies)
      .Walk([&](uint32_t i) { group.Add(blows[i]); },
            [&] {
              solve(group);
              group.Clear();
            });
}

}  // namespace

Vector3 RelativeVelocity(const Blow& blow, std::span<const StruckBody> bodies) {
  return bodies[blow.body_b].VelocityAt(blow.position) - bodies[blow.body_a].VelocityAt(blow.position);
}

void SolveBlows(std::span<Blow> blows, std::span<StruckBody> bodies) {
  SolveGroups(blows, bodies, [](Group& group) { group.Settle(); });
}

void Restitute(std::span<Blow> blows, std::span<StruckBody> bodies) {
  SolveGroups(blows, bodies, [](Group& group) { group.Restitute(); });
}

}  // namespace genphys

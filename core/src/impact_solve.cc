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
// A part of what it would give way if nobody held it.
constexpr double kHeldFast = 1e-3;

using Vector2 = Eigen::Vector2d;
// Three components and a zero: processors calculate with pairs of numbers.
using Padded = Eigen::Vector4d;

Padded Pad(const Vector3& v) { return {v.x(), v.y(), v.z(), 0}; }

// Velocities of a body while blows change them, m/s and rad/s.
struct Speeds {
  Padded linear;
  Padded angular;
};

// What an impulse of one along an axis does to a body that is tied to those that it hits.
struct Passed {
  uint32_t body = 0;
  Padded shift;  // m/s per N*s
  Padded turn;   // rad/s per N*s
};

// What the two bodies of a blow do along an axis (from a to b) and what an impulse along it does to them and to those
// that are tied to them.
class Along {
 public:
  // Whom it is passed on to is added to `passed`.
  Along(const Vector3& axis, const Blow& blow, std::span<const StruckBody> bodies, Ties& ties,
        std::vector<Passed>& passed)
      : axis_(Pad(axis)),
        a_(-axis, blow.position, bodies[blow.body_a]),
        b_(axis, blow.position, bodies[blow.body_b]),
        first_passed_(passed.size()),
        last_passed_(passed.size()) {
    if (!ties.With(blow.body_a).empty() || !ties.With(blow.body_b).empty()) Tie(axis, blow, ties, passed);
  }

  // How fast b goes this way against a, m/s.
  double Rate(const Speeds& a, const Speeds& b) const {
    return (axis_.cwiseProduct(b.linear - a.linear) + a_.lever.cwiseProduct(a.angular) +
            b_.lever.cwiseProduct(b.angular))
        .sum();
  }
  void Push(double impulse, Speeds& a, Speeds& b) const {
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
  // Change of the rate per impulse along another axis, 1/kg.
  double Answer(const Along& to) const {
    return Rate({.linear = to.a_.shift, .angular = to.a_.turn}, {.linear = to.b_.shift, .angular = to.b_.turn});
  }
  // That along this axis, if nobody were tied.
  double FreeAnswer(const StruckBody& a, const StruckBody& b) const {
    const auto turned = [](const Side& side, const StruckBody& body) {
      const Vector3 lever = side.lever.head<3>();
      return lever.dot(body.inverse_tensor * lever);
    };
    return a.inverse_mass + b.inverse_mass + turned(a_, a) + turned(b_, b);
  }

 private:
  struct Side {
    Side(const Vector3& push, const Vector3& position, const StruckBody& body)
        : lever(Pad((position - body.center).cross(push))),
          shift(Pad(body.inverse_mass * body.freedom.cwiseProduct(push))),
          turn(Pad(body.inverse_tensor * lever.head<3>())) {}

    Padded lever;  // m
    Padded shift;  // m/s per N*s
    Padded turn;   // rad/s per N*s
  };

  void Tie(const Vector3& axis, const Blow& blow, Ties& ties, std::vector<Passed>& passed) {
    std::vector<Ties::Push> pushes;
    const auto push = [&](uint32_t body, const Vector3& linear, Side& side) {
      if (ties.With(body).empty()) return;
      pushes.push_back({body, linear, side.lever.head<3>()});
      side.shift.setZero();
      side.turn.setZero();
    };
    push(blow.body_a, -axis, a_);
    push(blow.body_b, axis, b_);
    std::vector<Ties::Change> changes;
    ties.Pass(pushes, changes);
    for (const Ties::Change& change : changes) {
      const Padded shift = Pad(change.linear), turn = Pad(change.angular);
      if (change.body == blow.body_a || change.body == blow.body_b) {
        Side& side = change.body == blow.body_a ? a_ : b_;
        side.shift = shift;
        side.turn = turn;
      } else {
        passed.push_back({change.body, shift, turn});
      }
    }
    last_passed_ = passed.size();
  }

  Padded axis_;
  Side a_;
  Side b_;
  size_t first_passed_;
  size_t last_passed_;
};

// One blow against its two bodies.
class Settling {
 public:
  Settling(Blow& blow, std::span<const StruckBody> bodies, Ties& ties, std::vector<Passed>& passed)
      : Settling(blow, blow.normal.unitOrthogonal(), bodies, ties, passed) {}

  Blow& blow() { return blow_; }
  const Blow& blow() const { return blow_; }

  void Restart(double separation_speed) {
    blow_.separation_speed = separation_speed;
    blow_.impulse = 0;
    rubbing_.setZero();
  }
  void Finish() { blow_.rubbing = rubbing_[0] * first_ + rubbing_[1] * second_; }

  // Each returns by how much (m/s) a velocity had to be changed.
  double Separate(std::span<Speeds> speeds, std::span<const Passed> passed) {
    if (!(softness_ > 0)) return 0;
    Speeds &a = speeds[blow_.body_a], &b = speeds[blow_.body_b];
    const double lacking = blow_.separation_speed - normal_.Rate(a, b);
    const double impulse = std::max(lacking / softness_, -blow_.impulse);
    if (impulse == 0) return 0;
    blow_.impulse += impulse;
    normal_.Push(impulse, a, b);
    if (is_tied_) normal_.PassOn(impulse, passed, speeds);
    return std::abs(impulse) * softness_;
  }

  double Rub(std::span<Speeds> speeds, std::span<const Passed> passed) {
    const double bound = blow_.friction * blow_.impulse;
    if (!(bound > 0) && rubbing_.isZero(0)) return 0;
    Speeds &a = speeds[blow_.body_a], &b = speeds[blow_.body_b];
    const Vector2 slip(across_[0].Rate(a, b), across_[1].Rate(a, b));
    const double square = slip.squaredNorm(), answer = slip.dot(answers_ * slip);
    Vector2 wanted = rubbing_;
    double softness = 0;
    if (answer > 0) {
      wanted -= (square / answer) * slip;
      softness = answer / square;
    }
    const double size = wanted.squaredNorm();
    if (size > bound * bound) wanted *= bound / std::sqrt(size);
    const Vector2 impulse = wanted - rubbing_;
    rubbing_ = wanted;
    for (int i = 0; i < 2; ++i) {
      across_[i].Push(impulse[i], a, b);
      if (is_tied_) across_[i].PassOn(impulse[i], passed, speeds);
    }
    return impulse.norm() * softness;
  }

 private:
  Settling(Blow& blow, const Vector3& first, std::span<const StruckBody> bodies, Ties& ties,
           std::vector<Passed>& passed)
      : blow_(blow),
        first_(first),
        second_(blow.normal.cross(first)),
        normal_(blow.normal, blow, bodies, ties, passed),
        across_{Along(first_, blow, bodies, ties, passed), Along(second_, blow, bodies, ties, passed)},
        rubbing_(blow.rubbing.dot(first_), blow.rubbing.dot(second_)),
        softness_(normal_.Answer(normal_)),
        is_tied_(!ties.With(blow.body_a).empty() || !ties.With(blow.body_b).empty()) {
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) answers_(i, j) = across_[i].Answer(across_[j]);
    }
    // What joints hold fast gives way by the softness of their rows alone, and that is no way.
    const double free = is_tied_ ? normal_.FreeAnswer(bodies[blow.body_a], bodies[blow.body_b]) : 0;
    if (softness_ < kHeldFast * free) softness_ = 0;
  }

  Blow& blow_;
  Vector3 first_;  // across the normal
  Vector3 second_;
  Along normal_;
  Along across_[2];
  Eigen::Matrix2d answers_;  // 1/kg, across the normal
  Vector2 rubbing_;          // N*s, the same
  double softness_;          // 1/kg along the normal
  bool is_tied_;             // one of the two is, to others
};

// Sorts blows into groups that have no movable body in common, each in the order in which the blows came.
class Groups {
 public:
  Groups(std::span<const Blow> blows, std::span<const StruckBody> bodies, const Ties& ties) : sets_(bodies.size()) {
    const auto is_movable = [&](uint32_t body) { return bodies[body].inverse_mass > 0; };
    for (uint32_t body = 0; body < bodies.size(); ++body) {
      const std::span<const uint32_t> tied = ties.With(body);
      if (!tied.empty() && tied.front() != body) sets_.Join(tied.front(), body);
    }
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
  Group(std::span<StruckBody> bodies, Ties& ties) : bodies_(bodies), ties_(ties), changed_in_(bodies.size(), 0) {
    speeds_.reserve(bodies.size());
    for (const StruckBody& body : bodies) speeds_.push_back({Pad(body.linear_velocity), Pad(body.angular_velocity)});
  }

  void Add(Blow& blow) { blows_.emplace_back(blow, bodies_, ties_, passed_); }
  // What was found is told to blows and bodies, and another group may be added.
  void Finish() {
    for (Settling& settling : blows_) {
      settling.Finish();
      VisitMoved(settling.blow(), [&](uint32_t body) {
        bodies_[body].linear_velocity = speeds_[body].linear.head<3>();
        bodies_[body].angular_velocity = speeds_[body].angular.head<3>();
      });
    }
    blows_.clear();
    passed_.clear();
  }

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
        const double parted = settling.Separate(speeds_, passed_);
        const double change = std::max(parted, settling.Rub(speeds_, passed_));
        if (change > kSettled) NoteChange(settling.blow(), sweep);
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
  // Whom it hits, and all that are tied to these.
  template <typename Visit>
  void VisitMoved(const Blow& blow, Visit&& visit) const {
    for (const uint32_t body : {blow.body_a, blow.body_b}) {
      const std::span<const uint32_t> tied = ties_.With(body);
      if (tied.empty()) visit(body);
      for (const uint32_t each : tied) visit(each);
    }
  }

  void ForgetChanges() {
    for (const Settling& settling : blows_) {
      VisitMoved(settling.blow(), [&](uint32_t body) { changed_in_[body] = 0; });
    }
  }

  // What cannot be moved stays as it is, or all on one ground would stir each other.
  void NoteChange(const Blow& blow, uint32_t sweep) {
    VisitMoved(blow, [&](uint32_t body) {
      if (bodies_[body].inverse_mass > 0) changed_in_[body] = sweep;
    });
  }

  // Marks in passing whom it has.
  void Remember() {
    movable_.clear();
    is_driven_ = false;
    ForgetChanges();
    for (const Settling& settling : blows_) {
      VisitMoved(settling.blow(), [&](uint32_t each) {
        const StruckBody& body = bodies_[each];
        if (body.inverse_mass == 0) {
          is_driven_ |= !body.linear_velocity.isZero(0) || !body.angular_velocity.isZero(0);
        } else if (changed_in_[each] == 0) {
          is_driven_ |= ties_.IsDriven(each);
          changed_in_[each] = 1;
          movable_.push_back(each);
        }
      });
    }
  }

  // To where it began, to ask for a part of the separation.
  void Return(double part) {
    for (const uint32_t each : movable_) {
      speeds_[each] = {Pad(bodies_[each].linear_velocity), Pad(bodies_[each].angular_velocity)};
    }
    for (size_t i = 0; i < blows_.size(); ++i) blows_[i].Restart(part * asked_[i]);
  }

  // Kinetic, of all that can be moved, J.
  double Energy() const {
    double sum = 0;
    for (const uint32_t each : movable_) {
      const Vector3 spin = speeds_[each].angular.head<3>();
      sum += speeds_[each].linear.squaredNorm() / bodies_[each].inverse_mass + spin.dot(bodies_[each].tensor * spin);
    }
    return sum / 2;
  }

  std::span<StruckBody> bodies_;
  Ties& ties_;
  std::vector<Speeds> speeds_;  // by body, which has them from before until the group is finished
  std::vector<Settling> blows_;
  std::vector<Passed> passed_;        // of blows_
  std::vector<uint32_t> changed_in_;  // the last sweep, by body
  std::vector<uint32_t> movable_;     // bodies of the group
  std::vector<double> asked_;         // m/s, by blow
  bool is_driven_ = false;            // something that cannot be moved moves
};

template <typename Solve>
void SolveGroups(std::span<Blow> blows, std::span<StruckBody> bodies, Ties& ties, Solve&& solve) {
  Group group(bodies, ties);
  Groups(blows, bodies, ties)
      .Walk([&](uint32_t i) { group.Add(blows[i]); },
            [&] {
              solve(group);
              group.Finish();
            });
}

}  // namespace

Vector3 RelativeVelocity(const Blow& blow, std::span<const StruckBody> bodies) {
  return bodies[blow.body_b].VelocityAt(blow.position) - bodies[blow.body_a].VelocityAt(blow.position);
}

void SolveBlows(std::span<Blow> blows, std::span<StruckBody> bodies, Ties& ties) {
  SolveGroups(blows, bodies, ties, [](Group& group) { group.Settle(); });
}

void Restitute(std::span<Blow> blows, std::span<StruckBody> bodies, Ties& ties) {
  SolveGroups(blows, bodies, ties, [](Group& group) { group.Restitute(); });
}

}  // namespace genphys

// What happens to those in space that are pushed out of an overlap: they are farther from each other afterwards and as
// fast as before, so that they would turn about each other with more angular momentum than they had.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "pairs/disjoint_sets.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// What a place may be off by rounding, as a part of how far out it is.
constexpr double kRounding = 1e-14;

}  // namespace

// One solve of `h` seconds, between that and the search for contacts after it.
class StepRun::Spread {
 public:
  Spread(StepRun& run, double h) : run_(run), h_(h) {}

  // Those who touch each other turn the slower, as if they were one. They keep their momentum, and the speeds by which
  // they slide and part.
  void Slow() {
    const auto is_pushed = [this](const Mover& mover) { return IsPushed(mover, PushOf(mover)); };
    if (std::ranges::none_of(run_.movers_, is_pushed)) return;
    Gather();
    VisitMembers([this](Mover& mover, Group& group) { AddTensor(mover, group); });
    for (Group& group : groups_) {
      if (group.Counts()) group.slower = group.tensor.ldlt().solve(group.gain);
    }
    VisitMembers([this](Mover& mover, const Group& group) { Turn(mover, group); });
  }

 private:
  // Those who touch each other.
  struct Group {
    bool is_pushed = false;
    bool is_held = false;              // not by each other alone
    double mass = 0;                   // kg
    Vector3 center = Vector3::Zero();  // m, times the mass
    Vector3 gain = Vector3::Zero();    // kg*m^2/s, by being pushed
    Matrix3 tensor = Matrix3::Zero();  // kg*m^2, about its centre
    Vector3 slower = Vector3::Zero();  // rad/s

    bool Counts() const { return is_pushed && !is_held; }
  };

  // By which its centre went another way than its velocity led, m.
  Vector3 PushOf(const Mover& mover) const {
    const Vector3& center = run_.world_.scene_.entities[Index(mover.row)]->mass.center_of_mass;
    return run_.CenterOf(mover.row) - mover.start.Transform(center) - h_ * VelocityOf(mover);
  }
  const Vector3& VelocityOf(const Mover& mover) const {
    return run_.world_.layer_.half_steps[Index(mover.row)].velocity;
  }

  static bool IsPushed(const Mover& mover, const Vector3& push) {
    const double least = kRounding * (1 + mover.start.position.norm());
    return push.squaredNorm() > least * least;
  }

  // Who hangs together, and what pushes gave them.
  void Gather() {
    groups_.resize(run_.movers_.size() + 1);
    sets_ = DisjointSets(groups_.size());
    std::vector<uint32_t> held;
    // Smooth ones cannot turn each other.
    bool is_smooth = false;
    const auto holds = [&](const ContactPair& pair) {
      is_smooth = pair.material.friction == 0;
      return run_.Holds(pair);
    };
    run_.VisitHeldTogether(holds, [&](uint32_t a, uint32_t b) {
      if (a > 0 && b > 0) sets_.Join(a, b);
      if (a == 0 || b == 0 || is_smooth) held.push_back(std::max(a, b));
    });
    for (const uint32_t number : held) groups_[sets_.Find(number)].is_held = true;
    for (size_t i = 0; i < run_.movers_.size(); ++i) {
      const Mover& mover = run_.movers_[i];
      Group& group = groups_[sets_.Find(static_cast<uint32_t>(i + 1))];
      group.is_held |=
          run_.scratch_.jointed[mover.row] || run_.world_.scene_.entities[Index(mover.row)]->traits.is_locked;
      // As nearly all are, on the ground.
      if (group.is_held) continue;
      const Vector3 push = PushOf(mover);
      const double mass = run_.MassOf(mover.row);
      group.is_pushed |= IsPushed(mover, push);
      group.mass += mass;
      group.center += mass * run_.CenterOf(mover.row);
      group.gain += mass * push.cross(VelocityOf(mover));
    }
  }

  template <typename Visit>
  void VisitMembers(Visit visit) {
    for (size_t i = 0; i < run_.movers_.size(); ++i) {
      Group& group = groups_[sets_.Find(static_cast<uint32_t>(i + 1))];
      if (group.Counts()) visit(run_.movers_[i], group);
    }
  }

  Vector3 PlaceIn(const Group& group, const Mover& mover) const {
    return run_.CenterOf(mover.row) - group.center / group.mass;
  }

  void AddTensor(const Mover& mover, Group& group) const {
    const Vector3 place = PlaceIn(group, mover);
    group.tensor += mover.turned.tensor +
                    run_.MassOf(mover.row) * (place.squaredNorm() * Matrix3::Identity() - place * place.transpose());
  }

  void Turn(const Mover& mover, const Group& group) {
    const uint32_t row = Index(mover.row);
    const Vector3 slower = group.slower.cross(PlaceIn(group, mover));
    HalfStep& half = run_.world_.layer_.half_steps[row];
    half.velocity -= slower;
    half.momentum -= mover.turned.tensor * group.slower;
    run_.state_.linear_velocities.col(row) -= slower;
    run_.state_.angular_velocities.col(row) -= group.slower;
  }

  StepRun& run_;
  double h_;
  DisjointSets sets_{0};       // of places in movers_ and one
  std::vector<Group> groups_;  // by root
};

void StepRun::SlowSpread(double h) { Spread(*this, h).Slow(); }

}  // namespace genphys

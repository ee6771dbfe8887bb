// How what joints hold together goes through a substep in which one of them comes to its limit: by what pulled it until
// then, through the blow where it is there, and on from it as it is held since. A blow goes through other joints as
// these are turned where it happens, and changes what they give from then on: whoever swings on what was stopped is
// pulled round another point.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "joints/joint_step.h"
#include "joints/kinds.h"
#include "joints/row_rate.h"
#include "motion/free_rotation.h"

namespace genphys {
namespace {

// Of a substep: so far ahead and back it is looked how rates change while bodies go on.
constexpr double kGlance = 1e-3;
// Of a substep: what comes to its limit so much sooner or later than it seemed is not followed.
constexpr double kMostLate = 0.25;
constexpr int kRounds = 2;
// Of an energy.
constexpr double kRounding = 1e-12;
// Of a push: by less it is the same.
constexpr double kSamePush = 1e-3;

}  // namespace

class JointStep::LimitCourse {
 public:
  LimitCourse(JointStep& step, const Linked& group, double h, PushOf push_of)
      : step_(step), group_(group), h_(h), push_of_(push_of) {}

  // False: this is not so simple, and nothing was done.
  bool Follow() {
    if (!Gather() || !FindReached()) return false;
    const double before = Energy();
    if (!Settle(Part::kBefore) || !Arrive() || !Strike() || !Settle(Part::kAfter)) return false;
    GoOn(h_ - time_);
    // A blow takes some, and joints give none.
    return Energy() <= (1 + kRounding) * before + work_;
  }

  // Of the blow, what the solve did not give.
  void Bear() const {
    for (size_t i = 0; i < blow_.size(); ++i) blow_owners_[i]->Bear(time_ / h_, blow_[i]);
  }

  void AddTo(std::vector<Led>& led) const {
    for (size_t i = 0; i < group_.rows.size(); ++i) {
      const JointBody& body = bodies_[i + 1];
      const Acting& acting = acting_[i + 1];
      led.push_back({.row = group_.rows[i],
                     .pose = body.pose,
                     .linear_velocity = body.linear_velocity,
                     .momentum = acting.momentum,
                     .held_rate = acting.linear - acting.outside.acceleration,
                     .held_torque = acting.torque - acting.outside.torque});
    }
  }

 private:
  enum class Part : uint8_t { kBefore, kBlow, kAfter };

  struct Joint {
    Held* held;
    size_t a, b;  // in bodies_
  };

  struct Acting {
    Vector3 momentum = Vector3::Zero();  // angular, kg*m^2/s
    genphys::Push held;                  // by joints in the last substep
    genphys::Push outside;
    Vector3 linear = Vector3::Zero();  // m/s^2, of all together
    Vector3 torque = Vector3::Zero();  // N*m
  };

  bool Gather() {
    bodies_.resize(1);
    acting_.resize(1);
    for (const EntityRow row : group_.rows) {
      const JointBody& now = step_.BodyAt(row);
      const uint32_t island = step_.islands_.IslandOf(row);
      const bool is_alone = island != Islands::kNone && step_.islands_.islands()[island].contacts == 0;
      if (!is_alone || now.factor != 1 || step_.scene_.entities[Index(row)]->traits.is_locked) return false;
      JointBody& body = Add(row);
      const HalfStep& half = step_.layer_.half_steps[Index(row)];
      Acting& acting = acting_.back();
      acting.held = {half.held_rate, half.held_torque};
      acting.momentum = now.own_tensor * body.angular_velocity;
      begins_ |= now.begins;
    }
    return true;
  }

  JointBody& Add(EntityRow row) {
    JointBody& body = bodies_.emplace_back(step_.BodyAt(row));
    sides_.push_back(row);
    acting_.emplace_back();
    body.linear_velocity = body.linear_shown;
    body.angular_velocity = body.angular_shown;
    body.row = EntityRow{static_cast<uint32_t>(bodies_.size() - 1)};
    return body;
  }

  size_t PlaceOf(EntityRow side) {
    const auto known = std::ranges::find(sides_, side);
    if (known != sides_.end()) return static_cast<size_t>(known - sides_.begin());
    Add(side);
    return sides_.size() - 1;
  }

  // Of several none is known to be the first.
  bool FindReached() {
    for (const uint32_t slot : group_.slots) {
      const auto held = std::ranges::lower_bound(step_.held_, slot, {}, &Held::slot);
      if (held == step_.held_.end() || held->slot != slot) continue;
      const JointDesc& desc = step_.scene_.joints[slot]->desc;
      joints_.push_back({&*held, PlaceOf(RowOf(desc.entity_a)), PlaceOf(RowOf(desc.entity_b))});
    }
    int reached = 0;
    for (const Joint& joint : joints_) {
      const auto [first, last] =
          std::ranges::equal_range(step_.owners_, static_cast<uint32_t>(joint.held - step_.held_.data()));
      for (auto owner = first; owner != last; ++owner) {
        const JointRow& row = step_.rows_[static_cast<size_t>(owner - step_.owners_.begin())];
        if (row.is_driven && !AddSpent(joint, row)) return false;
        if (!row.is_reached || row.impulse == 0) continue;
        ++reached;
        reached_ = &joint;
        time_ = row.until;
      }
    }
    return reached == 1;
  }

  // What drives goes by how fast that is, unless it pushes with all that it may, as it did in the last step.
  bool AddSpent(const Joint& joint, const JointRow& row) {
    const bool is_told = row.since == 0 || row.since > 1;
    if (begins_ || is_told || !IsSpent(row)) return false;
    const bool is_linear = row.kind == JointRow::Kind::kLinear;
    const JointState& before = joint.held->before;
    const double push = row.impulse * joint.held->share / h_;
    const double pushed = row.axis.dot(is_linear ? before.force : before.torque);
    if (!(std::abs(pushed - push) <= kSamePush * std::abs(push))) return false;
    JointRow& spent = spent_.emplace_back(row);
    spent.a = bodies_[joint.a].row;
    spent.b = bodies_[joint.b].row;
    spent.impulse = push;
    return true;
  }

  // W, of what pushes with all that it may.
  double PowerOfSpent() const {
    double sum = 0;
    for (const JointRow& row : spent_) sum += row.impulse * RateAt(row);
    return sum;
  }

  // The rows of what holds in that part, between bodies as they are.
  void Write(Part part, std::vector<JointRow>& rows, std::vector<Held*>* owners = nullptr) const {
    rows.clear();
    for (const auto [held, a, b] : joints_) {
      for (JointRow& row : step_.RowsBetween(held->slot, bodies_[a], bodies_[b], h_)) {
        row.target = 0;
        if (!IsLocked(row)) {
          const JointRow* const solved = IsLimit(row) ? step_.SolvedLimit(*held, row) : nullptr;
          if (solved == nullptr || solved->impulse == 0 || (solved->is_reached && part == Part::kBefore)) continue;
          // What pressed before may press less.
          if (!solved->is_reached && part != Part::kBlow && !begins_) {
            (row.lower == 0 ? row.lower : row.upper) = -solved->impulse * held->share / h_;
          }
        }
        rows.push_back(row);
        if (owners != nullptr) owners->push_back(held);
      }
    }
  }

  double RateAt(const JointRow& row) const {
    const JointBody &a = bodies_[NumberOf(row.a)], &b = bodies_[NumberOf(row.b)];
    return RateOf(row, a, {a.linear_velocity, a.angular_velocity}, b, {b.linear_velocity, b.angular_velocity});
  }

  static size_t NumberOf(EntityRow side) { return side == kWorldRow ? 0 : Index(side); }

  bool Solve(std::vector<JointRow>& rows) {
    std::vector<uint32_t> mine(rows.size()), body_of(bodies_.size());
    std::iota(mine.begin(), mine.end(), 0);
    std::iota(body_of.begin(), body_of.end(), 0);
    return solver_.Solve(0, rows, mine, body_of, bodies_) && !solver_.is_swept();
  }

  // What everybody is sped up by: as in the last substep, but for what it takes to hold joints while all go on so.
  bool Settle(Part part) {
    std::vector<JointRow> rows, ahead, back;
    Write(part, rows);
    const std::vector<JointBody> now = bodies_;
    const auto write_after = [&](double time, std::vector<JointRow>& to) {
      for (size_t i = 0; i < bodies_.size(); ++i) {
        if (bodies_[i].row != kWorldRow) Move(i, time * now[i].linear_velocity, time * now[i].angular_velocity);
      }
      Write(part, to);
      for (JointRow& row : to) row.target = RateAt(row);
      bodies_ = now;
    };
    write_after(kGlance * h_, ahead);
    write_after(-kGlance * h_, back);
    if (ahead.size() != rows.size() || back.size() != rows.size()) return false;
    for (size_t i = 0; i < rows.size(); ++i) {
      rows[i].target = (back[i].target - ahead[i].target) / (2 * kGlance * h_);
    }
    for (size_t i = 0; i < bodies_.size(); ++i) SpeedUp(i);
    const std::vector<JointBody> sped_up = bodies_;
    if (!Solve(rows)) return false;
    for (size_t i = 0; i < bodies_.size(); ++i) {
      acting_[i].linear = bodies_[i].linear_velocity;
      acting_[i].torque += bodies_[i].own_tensor * (bodies_[i].angular_velocity - sped_up[i].angular_velocity);
    }
    bodies_ = now;
    return true;
  }

  // Makes accelerations of its velocities.
  void SpeedUp(size_t i) {
    JointBody& body = bodies_[i];
    if (!body.is_movable()) {
      body.linear_velocity.setZero();
      body.angular_velocity.setZero();
      return;
    }
    Acting& acting = acting_[i];
    acting.outside = push_of_(sides_[i], body.linear_velocity, acting.momentum);
    acting.torque = acting.outside.torque + acting.held.torque;
    const Vector3 spin = body.angular_velocity;
    body.linear_velocity = acting.outside.acceleration + acting.held.acceleration;
    body.angular_velocity = body.own_inverse * (acting.torque - spin.cross(acting.momentum));
  }

  void Move(size_t i, const Vector3& way, const Vector3& turn) {
    JointBody& body = bodies_[i];
    const SceneEntity& entity = *step_.scene_.entities[Index(sides_[i])];
    body.center += way;
    body.pose.orientation = Turned(body.pose.orientation, turn, 1);
    body.axes = body.pose.orientation.toRotationMatrix();
    body.pose.position = body.center - body.axes * (entity.traits.is_dynamic ? entity.mass.center_of_mass : kNoWay);
    if (!body.is_movable()) return;
    body.own_tensor = WorldTensor(body.axes, entity.mass.tensor);
    body.own_inverse = body.inverse_tensor = WorldTensor(body.axes, entity.mass.inverse_tensor);
  }

  void GoOn(double time) {
    work_ += time / 2 * PowerOfSpent();
    for (size_t i = 0; i < bodies_.size(); ++i) {
      JointBody& body = bodies_[i];
      if (body.row == kWorldRow) continue;
      if (!body.is_movable()) {
        Move(i, time * body.linear_velocity, time * body.angular_velocity);
        continue;
      }
      Acting& acting = acting_[i];
      const Vector3 faster = body.own_inverse * (acting.torque - body.angular_velocity.cross(acting.momentum));
      const Vector3 way = time * (body.linear_velocity + time / 2 * acting.linear);
      const Vector3 turn = time * (body.angular_velocity + time / 2 * faster);
      work_ += acting.outside.acceleration.dot(way) / body.inverse_mass + acting.outside.torque.dot(turn);
      Move(i, way, turn);
      body.linear_velocity += time * acting.linear;
      acting.momentum += time * acting.torque;
      body.angular_velocity = body.own_inverse * acting.momentum;
    }
    work_ += time / 2 * PowerOfSpent();
  }

  // As far as the limit.
  bool Arrive() {
    GoOn(time_);
    for (int i = 0; i < kRounds; ++i) {
      const double late = Lateness();
      if (!(std::abs(late) <= kMostLate * h_)) return false;
      GoOn(-late);
      time_ -= late;
    }
    return time_ >= 0 && time_ <= h_;
  }

  // s, since the limit was reached.
  double Lateness() const {
    std::array<JointBody, 2> still{bodies_[reached_->a], bodies_[reached_->b]};
    for (JointBody& body : still) {
      body.linear_velocity.setZero();
      body.angular_velocity.setZero();
      body.linear_before = body.angular_before = body.linear_expected = body.angular_expected = Vector3::Zero();
    }
    for (const JointRow& row : step_.RowsBetween(reached_->held->slot, still[0], still[1], h_)) {
      const JointRow* const solved = IsLimit(row) ? step_.SolvedLimit(*reached_->held, row) : nullptr;
      if (solved != nullptr && solved->is_reached) return -h_ * row.target / RateAt(row);
    }
    return std::numeric_limits<double>::infinity();
  }

  double Energy() const {
    double sum = 0;
    for (size_t i = 1; i < bodies_.size(); ++i) {
      const JointBody& body = bodies_[i];
      if (!body.is_movable()) continue;
      sum += body.linear_velocity.squaredNorm() / body.inverse_mass / 2;
      sum += body.angular_velocity.dot(acting_[i].momentum) / 2;
    }
    return sum;
  }

  // Stops the row that is at its limit, as far as what is locked lets it.
  bool Strike() {
    Write(Part::kBlow, blow_, &blow_owners_);
    if (!Solve(blow_)) return false;
    for (size_t i = 1; i < bodies_.size(); ++i) {
      acting_[i].momentum = bodies_[i].own_tensor * bodies_[i].angular_velocity;
    }
    return true;
  }

  static inline const Vector3 kNoWay = Vector3::Zero();

  JointStep& step_;
  const Linked& group_;
  double h_;
  PushOf push_of_;
  double time_ = 0;      // s, until the limit is reached
  double work_ = 0;      // J, by what acts from outside and by motors
  bool begins_ = false;  // it is not known of all what held them
  std::vector<EntityRow> sides_{kWorldRow};
  std::vector<JointBody> bodies_{1};  // of sides_, by which rows name them
  std::vector<Acting> acting_{1};     // the same
  std::vector<Joint> joints_;
  const Joint* reached_ = nullptr;
  std::vector<JointRow> spent_;  // motors that push with all they may; their impulses are N and N*m
  std::vector<JointRow> blow_;
  std::vector<Held*> blow_owners_;
  RowSolver solver_;
};

bool JointStep::FollowReached(const Linked& group, double h, PushOf push_of, std::vector<Led>& led) {
  LimitCourse course(*this, group, h, push_of);
  if (!course.Follow()) return false;
  course.Bear();
  course.AddTo(led);
  return true;
}

}  // namespace genphys

// In which direction joints and other contacts draw over a surface what they hold or push. Friction works against the
// slip, and what begins to slip because a joint pulls does not slip yet before the solve in which it does. Forces are
// in velocities by then, but what a joint or another contact will give is known only once it is solved for: so it is
// taken to give what it did in the last solve. Where a joint begins to give something else that is not true: there the
// solve tells, and is done once more.
#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "motion/free_rotation.h"
#include "pairs/contact_points.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// Of what friction can give, the part that it may be askew, or give more.
constexpr double kAskew = 0.01;
// A finger, the floor and another one.
constexpr uint32_t kFewPartners = 3;
// Cosine between normals of one surface.
constexpr double kSameSurface = 0.999;

// m/s, of b against a at the middle of their points, before the solve.
Vector3 SlipOf(const ContactPair& pair, std::span<const ContactPoint> points) {
  Vector3 slip = Vector3::Zero();
  for (const ContactPoint& point : points) {
    slip += Across(point.relative_velocity + pair.surface_velocity + pair.bend, point.normal) / pair.point_count;
  }
  return slip;
}

}  // namespace

// What friction did between two bodies on one surface.
struct StepRun::Rubbed {
  Vector3 given = Vector3::Zero();  // N*s on b
  double most = 0;                  // N*s, that it can give
  double pressing = 0;              // N*s

  // By a pair and all of the same two bodies on its surface: these follow each other.
  void Add(const ContactBuffer& contacts, const ContactPair& pair) {
    const ContactPair* const begin = contacts.pairs.data();
    const ContactPair* const end = begin + contacts.pairs.size();
    const auto is_of_both = [&](const ContactPair& other) {
      return other.entity_a == pair.entity_a && other.entity_b == pair.entity_b;
    };
    const ContactPair* each = &pair;
    while (each > begin && is_of_both(each[-1])) --each;
    for (; each < end && is_of_both(*each); ++each) {
      if (!each->is_sensor && AreOnOneSurface(contacts, *each, pair)) Add(PointsOf(contacts, *each));
    }
  }
  void Scale(double factor) {
    given *= factor;
    most *= factor;
    pressing *= factor;
  }
  bool GivesWay() const { return given.norm() > (1 - kAskew) * most; }

 private:
  void Add(std::span<const ContactPoint> points) {
    for (const ContactPoint& point : points) {
      given += point.friction_impulse;
      most += point.friction * point.normal_impulse;
      pressing += point.normal_impulse;
    }
  }
  static bool AreOnOneSurface(const ContactBuffer& contacts, const ContactPair& a, const ContactPair& b) {
    if (a.point_count == 0 || b.point_count == 0) return false;
    return contacts.points[a.first_point].normal.dot(contacts.points[b.first_point].normal) > kSameSurface;
  }
};

// m/s, by what a solve changed of both sides, `gain_of` (row), in the middle of their points, but for what friction
// between them did. That moves at least what presses there by its weight: of what lies on one of them, too, which goes
// with it. To take it for more would let directions swing to and fro, more in each step.
Vector3 StepRun::DrawnBy(const ContactPair& pair, const Rubbed& friction,
                         absl::FunctionRef<Push(EntityRow)> gain_of) const {
  const std::span<const ContactPoint> points = PointsOf(world_.contacts_, pair);
  Vector3 middle = Vector3::Zero();
  for (const ContactPoint& point : points) middle += point.position / pair.point_count;
  double mobility = 0;  // 1/kg
  const auto gain_at_middle = [&](EntityRow row) -> Vector3 {
    if (!IsMoved(row)) return Vector3::Zero();
    const MassProperties& mass = world_.scene_.entities[Index(row)]->mass;
    mobility += 1 / mass.mass;
    const Push gain = gain_of(row);
    const Vector3 spin = WorldTensor(state_.pose(row).orientation, mass.inverse_tensor) * gain.torque;
    return gain.acceleration + spin.cross(middle - CenterOf(row));
  };
  const Vector3 gain = gain_at_middle(pair.entity_b) - gain_at_middle(pair.entity_a);
  const double weight = world_.contacts_.pull * pair.interval;  // N*s per kg
  if (mobility * friction.pressing > weight) mobility = weight / friction.pressing;
  return Across(gain - mobility * friction.given, points.front().normal);
}

void StepRun::CountPartners() {
  scratch_.partners.Clear();
  const ContactPair* last = nullptr;
  for (const ContactPair& pair : world_.contacts_.pairs) {
    if (pair.is_sensor) continue;
    const bool is_known = last != nullptr && last->entity_a == pair.entity_a && last->entity_b == pair.entity_b;
    last = &pair;
    if (is_known) continue;
    ++scratch_.partners[pair.entity_a];
    ++scratch_.partners[pair.entity_b];
  }
}

// Whether it may matter what else draws it. Among many that hold each other no direction is better than another.
bool StepRun::IsDrawn(const ContactPair& pair) const {
  if (scratch_.jointed[pair.entity_a] || scratch_.jointed[pair.entity_b]) return true;
  if (pair.material.friction == 0) return false;
  const bool is_moved_a = IsMoved(pair.entity_a), is_moved_b = IsMoved(pair.entity_b);
  if (pair.point_count > 2) return !is_moved_a || !is_moved_b;
  const auto has_few = [&](EntityRow row) { return std::as_const(scratch_.partners)[row] <= kFewPartners; };
  return pair.material.rolling_friction == 0 && (!is_moved_a || has_few(pair.entity_a)) &&
         (!is_moved_b || has_few(pair.entity_b));
}

// As the last solve tells it.
Vector3 StepRun::DrawnBefore(const ContactPair& pair, double h) const {
  const double last = world_.layer_.last_substep;
  if (pair.point_count == 0 || !IsDrawn(pair) || last == 0) return Vector3::Zero();
  Rubbed friction;
  if (const ContactPair* before = SolvedBefore(pair)) {
    friction.Add(world_.solved_, *before);
    friction.Scale(pair.interval / last);
  }
  return DrawnBy(pair, friction, [&](EntityRow row) -> Push {
    const HalfStep& half = world_.layer_.half_steps[Index(row)];
    if (!half.has_past) return {};
    const double interval = half.Interval(last, h);
    return {interval * half.held_rate, interval * half.held_torque};
  });
}

// The islands in which friction of the solve just done was misled, and what is solved once more of them.
class StepRun::Misdrawn {
 public:
  explicit Misdrawn(StepRun& run) : run_(run), islands_(run.joints_.islands()) {}

  void Find() {
    for (uint32_t number = 0; number < islands_.islands().size(); ++number) {
      if (Begins(number)) numbers_.push_back(number);
    }
    if (numbers_.empty()) return;
    FindMovers();
    std::erase_if(numbers_, [&](uint32_t number) {
      bool is_misdrawn = false;
      for (const uint32_t pair : islands_.PairsOf(number)) is_misdrawn |= TellDrawn(contacts().pairs[pair]);
      return !is_misdrawn;
    });
    std::erase_if(movers_, [&](const Mover* mover) { return !Has(mover->row, mover->row); });
  }

  bool empty() const { return numbers_.empty(); }
  bool Has(EntityRow a, EntityRow b) const { return std::ranges::binary_search(numbers_, islands_.IslandOf(a, b)); }

  // By `h` seconds, with what is known now of how it is drawn.
  void Solve(double h, std::span<JointRow> left) {
    std::vector<EntityRow> rows;
    for (const Mover* mover : movers_) rows.push_back(mover->row);
    run_.ReturnToStart(rows);
    std::vector<JointRow> again;
    for (const JointRow& row : left) {
      if (!Has(row.a, row.b)) continue;
      again.push_back(row);
      again.back().impulse = 0;
    }
    ContactBuffer part = TakeContacts();
    run_.world_.engine_->ScaleInertia(run_.joints_.scales());
    run_.world_.engine_->SolveAgain(h, rows, run_.state_, part, again);
    auto next = again.begin();
    for (JointRow& row : left) {
      if (Has(row.a, row.b)) row.impulse = (next++)->impulse;
    }
    auto point = part.points.begin();
    for (const ContactPair& pair : contacts().pairs) {
      if (!Has(pair.entity_a, pair.entity_b)) continue;
      std::copy_n(point, pair.point_count, contacts().points.begin() + pair.first_point);
      point += pair.point_count;
    }
  }

 private:
  ContactBuffer& contacts() const { return run_.world_.contacts_; }

  // Whether joints may draw something over a surface that do so for the first time in this solve, or otherwise.
  bool Begins(uint32_t number) const {
    const Islands::Island& island = islands_.islands()[number];
    const auto begins = [&](EntityRow row) {
      const HalfStep& half = run_.world_.layer_.half_steps[Index(row)];
      return half.is_drawn || !half.has_past;
    };
    return island.joint_rows > 0 && island.contacts > 0 && std::ranges::any_of(islands_.RowsOf(number), begins);
  }

  void FindMovers() {
    for (const Mover& mover : run_.movers_) {
      if (Has(mover.row, mover.row)) movers_.push_back(&mover);
    }
    std::ranges::sort(movers_, {}, [](const Mover* mover) { return mover->row; });
  }

  // Whether friction was not against the slip that there would be without it. Of what slipped before that is known well
  // enough.
  bool TellDrawn(ContactPair& pair) const {
    const std::span<const ContactPoint> points = PointsOf(contacts(), pair);
    if (points.empty() || pair.is_sensor || !run_.IsDrawn(pair)) return false;
    Rubbed friction;
    friction.Add(contacts(), pair);
    pair.drawn = run_.DrawnBy(pair, friction, [&](EntityRow row) -> Push {
      const Mover& mover = **std::ranges::lower_bound(movers_, row, {}, [](const Mover* each) { return each->row; });
      const Vector3 spun = run_.state_.angular_velocities.col(Index(row)) - mover.spin_given;
      return {run_.state_.linear_velocities.col(Index(row)) - mover.linear_given, mover.turned.tensor * spun};
    });
    if (!friction.GivesWay() || Slipped(pair)) return false;
    const Vector3 slip = SlipOf(pair, points) + pair.drawn;
    const double given = friction.given.norm();
    return given > (1 + kAskew) * friction.most || slip.cross(friction.given).norm() > kAskew * slip.norm() * given;
  }

  bool Slipped(const ContactPair& pair) const {
    const ContactPair* const before = run_.SolvedBefore(pair);
    if (before == nullptr) return false;
    Rubbed friction;
    friction.Add(run_.world_.solved_, *before);
    return friction.most > 0 && friction.GivesWay();
  }

  ContactBuffer TakeContacts() const {
    ContactBuffer part{.pull = contacts().pull};
    for (const ContactPair& pair : contacts().pairs) {
      if (!Has(pair.entity_a, pair.entity_b)) continue;
      const std::span<const ContactPoint> points = PointsOf(contacts(), pair);
      part.pairs.push_back(pair);
      part.pairs.back().first_point = static_cast<uint32_t>(part.points.size());
      part.points.insert(part.points.end(), points.begin(), points.end());
    }
    return part;
  }

  StepRun& run_;
  const Islands& islands_;
  std::vector<uint32_t> numbers_;     // of islands, ascending
  std::vector<const Mover*> movers_;  // of these, by row
};

void StepRun::SolveMisdrawn(double h, std::span<JointRow> left) {
  if (left.empty()) return;
  Misdrawn misdrawn(*this);
  misdrawn.Find();
  if (!misdrawn.empty()) misdrawn.Solve(h, left);
}

}  // namespace genphys

// What contacts owe after a solve that gave a blow to some of those that they hold together. A blow is no part of how
// it goes on, and whoever passes it on gets of it what the others give: what each contact owes, it owes to both of its
// two, or momentum would come or go.
#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "pairs/contact_points.h"
#include "pairs/disjoint_sets.h"
#include "step/step_run.h"

namespace genphys {
namespace {

// What a body is owed is so different from what it seemed to be if the larger part of that was a blow.
constexpr double kMostly = 0.5;
// The cosine between what others give a body and what pulls at it, turned round, from which on they bear it.
constexpr double kBearing = 0.7;
// Times what it seems to be and what pulls: nobody is owed more.
constexpr double kFlung = 100;

}  // namespace

// One solve of `h` seconds, between that and the search for contacts after it.
class StepRun::Jolts {
 public:
  Jolts(StepRun& run, double h) : run_(run), h_(h) {}

  void Share() {
    if (!run_.is_anybody_jolted_) return;
    Gather();
    for (size_t i = 1; i < is_jolted_.size(); ++i) {
      const uint32_t root = sets_.Find(static_cast<uint32_t>(i));
      if (!is_jolted_[root]) continue;
      is_grounded_[root] ? Carry(i) : Drop(i);
    }
  }

 private:
  struct Owed {
    Vector3 impulse = Vector3::Zero();  // N*s
    Vector3 twist = Vector3::Zero();    // N*m*s, about its centre of mass
    Vector3 seemed = Vector3::Zero();   // N*s, the impulse if there were no blow
    Vector3 ground = Vector3::Zero();   // N*s, of all that it got by what nothing moves
    Vector3 others = Vector3::Zero();   // N*s, by all others
    bool was_held = false;              // in the solve before
  };

  // Who hangs together, and what contacts owe to each of them.
  void Gather() {
    const size_t count = run_.movers_.size() + 1;
    sets_ = DisjointSets(count);
    std::vector<uint32_t> grounded, jolted;
    const auto is_pressed = [&](const ContactPair& pair) {
      return !pair.is_sensor && HasPressed(run_.world_.contacts_, pair);
    };
    run_.VisitHeldTogether(is_pressed, [&](uint32_t a, uint32_t b) {
      if (a > 0 && b > 0) return sets_.Join(a, b);
      grounded.push_back(std::max(a, b));
    });
    is_jolted_.assign(count, false);
    is_grounded_.assign(count, false);
    owed_.resize(count);
    for (const uint32_t each : grounded) is_grounded_[sets_.Find(each)] = true;
    RowValues<int>& numbers = run_.scratch_.struck_index;
    for (size_t i = 1; i < count; ++i) {
      const EntityRow row = run_.movers_[i - 1].row;
      numbers[row] = static_cast<int>(i);
      if (run_.scratch_.jolted[row]) is_jolted_[sets_.Find(static_cast<uint32_t>(i))] = true;
    }
    const auto number = [&](EntityRow row) { return std::max(std::as_const(numbers)[row], 0); };
    for (ContactPair& pair : run_.world_.contacts_.pairs) {
      const auto a = static_cast<uint32_t>(number(pair.entity_a)), b = static_cast<uint32_t>(number(pair.entity_b));
      const uint32_t root = sets_.Find(std::max(a, b));
      if (root == 0 || !is_jolted_[root] || !is_pressed(pair)) continue;
      is_grounded_[root] ? AddOwed(pair, a, b) : Forgive(pair);
    }
    numbers.Clear();
  }

  // What points give: the impulse on b, and what it turns about `origin`.
  struct Given {
    Given(std::span<const ContactPoint> points, const Vector3& origin) : about(origin) {
      for (const ContactPoint& point : points) {
        const Vector3 impulse = point.normal_impulse * point.normal + point.friction_impulse;
        sum += impulse;
        twist += (point.position - origin).cross(impulse);
      }
    }
    Vector3 TwistAbout(const Vector3& center) const { return twist + (about - center).cross(sum); }

    Vector3 about;
    Vector3 sum = Vector3::Zero();    // N*s
    Vector3 twist = Vector3::Zero();  // N*m*s
  };

  // By the solve before, if it pressed them together as well.
  std::span<const ContactPoint> Before(const ContactPair& pair) const {
    const ContactPair* before = run_.SolvedBefore(pair);
    if (before != nullptr) return PointsOf(run_.world_.solved_, *before);
    return {};
  }

  static void Forgive(ContactPair& pair) { pair.owed = 0; }

  // A contact owes for the rest of the substep what it gave in as much of the one before, or since then, if that is
  // less: of what the two give each other a part that is told to both, for one of them may be paid without the other.
  void AddOwed(ContactPair& pair, uint32_t a, uint32_t b) {
    const std::span<const ContactPoint> before = Before(pair);
    const double last = run_.world_.layer_.last_substep;
    const double scale = last > 0 ? h_ / last : 1;
    const Vector3& about = run_.world_.contacts_.points[pair.first_point].position;
    const Given now(PointsOf(run_.world_.contacts_, pair), about), then(before, about);
    const double given = now.sum.squaredNorm();
    const bool is_mutual = a > 0 && b > 0, was_less = scale * scale * then.sum.squaredNorm() < given;
    if (is_mutual) {
      const double part = std::clamp(scale * then.sum.dot(now.sum) / given, 0.0, 1.0);
      const bool is_other = IsOtherwiseHeld(pair.entity_a) || IsOtherwiseHeld(pair.entity_b);
      pair.owed = IsOtherwiseJolted(pair) ? 0 : is_other ? kOwed : kOwed * part;
    }
    const bool is_as_before = !is_mutual && was_less;
    const Given& goes_on = is_as_before ? then : now;
    const double part = is_as_before ? kOwed * scale : pair.owed;
    for (const auto& [number, sign] : {std::pair(a, -1.0), std::pair(b, 1.0)}) {
      if (number == 0) continue;
      Owed& owed = owed_[number];
      owed.impulse += sign * part * goes_on.sum;
      owed.twist += sign * part * goes_on.TwistAbout(run_.CenterOf(run_.movers_[number - 1].row));
      const Vector3 seemed = sign * kOwed * now.sum;
      owed.seemed += seemed;
      (is_mutual ? owed.others : owed.ground) += seemed;
      owed.was_held |= !before.empty();
    }
  }

  // Whether joints or locked axes hold one of the two that got a blow: they go on as if nothing pulled at them.
  bool IsOtherwiseJolted(const ContactPair& pair) const {
    const auto is_jolted = [&](EntityRow row) { return run_.scratch_.jolted[row] && IsOtherwiseHeld(row); };
    return is_jolted(pair.entity_a) || is_jolted(pair.entity_b);
  }

  bool IsOtherwiseHeld(EntityRow row) const {
    return run_.scratch_.jointed[row] || run_.world_.scene_.entities[Index(row)]->traits.is_locked;
  }

  void Give(size_t number, const Vector3& velocity, const Vector3& momentum) {
    const Mover& mover = run_.movers_[number - 1];
    HalfStep& half = run_.world_.layer_.half_steps[Index(mover.row)];
    run_.state_.linear_velocities.col(Index(mover.row)) += velocity - half.held_velocity;
    run_.state_.angular_velocities.col(Index(mover.row)) += mover.turned.inverse * (momentum - half.held_momentum);
    half.held_velocity = velocity;
    half.held_momentum = momentum;
    half.held_torque.setZero();
  }

  // What nothing holds to the ground goes on as a whole.
  void Drop(size_t number) {
    Give(number, Vector3::Zero(), Vector3::Zero());
    run_.scratch_.jolted.Mark(run_.movers_[number - 1].row);
  }

  // What lies on the ground goes on as it was held before.
  void Carry(size_t number) {
    const EntityRow row = run_.movers_[number - 1].row;
    const Owed& owed = owed_[number];
    const double mass = run_.MassOf(row);
    // Contacts are not all that holds it.
    if (IsOtherwiseHeld(row)) return;
    const Vector3 seemed = owed.seemed / mass;
    const bool is_known = owed.was_held && !IsFlung(row, owed.impulse / mass, seemed);
    const Vector3 velocity = is_known ? Vector3(owed.impulse / mass) : Borne(row, owed);
    const Vector3 twist = is_known ? owed.twist : Vector3(Vector3::Zero());
    const bool is_jolted = (velocity - seemed).norm() > kMostly * std::max(velocity.norm(), seemed.norm());
    run_.scratch_.jolted.Set(row, is_jolted);
    Give(number, velocity, twist);
  }

  // What is squeezed between two gets impulses without bounds, which come to nothing only together: of two solves each
  // they come to more than all of one, and of what pulls.
  bool IsFlung(EntityRow row, const Vector3& velocity, const Vector3& seemed) const {
    const double pull = h_ / 2 * std::as_const(run_.scratch_.accelerations)[row].norm();
    return velocity.norm() > kFlung * (seemed.norm() + pull);
  }

  // What is owed to one of which no solve knows yet how it is held: by the ground all that pulls it there.
  Vector3 Borne(EntityRow row, const Owed& owed) const {
    const Vector3 pull = h_ / 2 * std::as_const(run_.scratch_.accelerations)[row];
    if (owed.ground.dot(pull) < 0) {
      const Vector3 up = owed.ground.normalized();
      return -pull.dot(up) * up;
    }
    // A blow of others is no more than by chance against what pulls.
    const bool is_borne = -owed.others.dot(pull) > kBearing * owed.others.norm() * pull.norm();
    return is_borne ? Vector3(-pull) : Vector3(Vector3::Zero());
  }

  StepRun& run_;
  double h_;
  DisjointSets sets_{0};              // of places in movers_ and one
  std::vector<uint8_t> is_jolted_;    // by root
  std::vector<uint8_t> is_grounded_;  // by root
  std::vector<Owed> owed_;            // by place and one
};

void StepRun::ShareJolts(double h) { Jolts(*this, h).Share(); }

}  // namespace genphys

#include "impacts/impact_solve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "contacts/leaps.h"
#include "impacts/blow_groups.h"
#include "impacts/impact_newton.h"
#include "impacts/settling.h"

namespace genphys {
namespace {

constexpr uint32_t kSweepsMax = 100;
// Turns of single blows after which sweeps end, and sweeps of all of them that may be taken whatever that makes. Among
// hundreds of blows a hundred sweeps are not enough either: who still goes into another hits it once more. With these
// the steps in which 216 boxes fall on each other take 0.87 of the time.
constexpr size_t kTurnsMax = 2000;
constexpr size_t kWholeSweeps = 20;
// Of what bears a body while it hands on what it got: all sweeps that follow begin with that.
constexpr uint32_t kHandedSweeps = 20;
// m/s: the sweeps end once no blow changed a velocity by more. Of many that only come to rest nobody looks at the
// energy, which has to be right to more digits.
constexpr double kSettled = 1e-12;
constexpr double kSettledAtRest = 1e-9;
// Or once so many in a row did not halve what they change, and that is no more than this part of the first change.
constexpr int kPatience = 8;
constexpr double kLittle = 1e-4;
// So few blows that hit each other are each brought all the way in their turns: of two that take friction from each
// other, 15 sweeps do what else takes 60. Of more, those turns cost more than the sweeps that they save.
constexpr size_t kFewBlows = 3;
// Of some more, all are solved at once after so many sweeps, which show who presses, slips and leaves, if as many more
// seem to be needed.
constexpr uint32_t kFirstSweeps = 4;
constexpr uint32_t kManySweeps = 20;
// Where they lead is looked at once the parts that are left after two sweeps differ by no more than this part.
constexpr double kSteady = 0.1;
constexpr int kAxes = 3;  // of each blow
// So often at most where joints pass blows on: who leaves or lands by a solve shows in the sweeps after it.
constexpr int kTiedSolves = 4;
// Times the momentum that the heaviest has by the fastest rate. What needs more is wedged: something that moves by
// itself presses it against what does not give way, or holds it from two sides.
constexpr double kWedged = 1e3;
// Of masses.
constexpr double kUneven = 8;
// Kinetic energy may grow by rounding only.
constexpr double kEnergySlack = 1e-12;
// The part of it that may be lost where a law asks for more than there is.
constexpr double kEnergySpare = 1e-10;
constexpr int kEnergyLooksMax = 40;

// How sweeps come nearer. Two points of a body that are timed apart, and so lie a little askew, cannot both stand still
// while one leaves faster than the other: what is left of that no sweep takes away.
class Progress {
 public:
  // A sweep changed no more than that, m/s.
  void Note(double largest) {
    first_ = std::max(first_, largest);
    earlier_ = before_last_;
    before_last_ = last_;
    last_ = largest;
    ++since_;
    if (largest <= least_ / 2) {
      least_ = largest;
      since_ = 0;
    }
  }
  // Whether so many more do not settle all, if each of them lessens what they change by as much as the last one.
  bool TakesMoreThan(uint32_t sweeps) const {
    if (!(last_ < before_last_)) return true;
    double left = last_;
    for (uint32_t i = 0; i < sweeps && left > kSettledAtRest; ++i) left *= last_ / before_last_;
    return left > kSettledAtRest;
  }
  // Whether the last two lessened it by the same part, or nearly.
  bool IsSteady() const {
    return last_ < before_last_ &&
           std::abs(last_ * earlier_ - before_last_ * before_last_) <= kSteady * last_ * earlier_;
  }
  bool IsLittleLeft() const { return last_ <= kLittle * first_; }
  // Little is left, and the last sweeps hardly changed less and less.
  bool IsStuck() const { return since_ >= kPatience && IsLittleLeft(); }

 private:
  double first_ = 0;
  double last_ = 0;
  double before_last_ = 0;
  double earlier_ = 0;
  double least_ = std::numeric_limits<double>::infinity();
  int since_ = 0;  // sweeps since it was halved
};

// Calls solve(group) for each group of blows.
template <typename Solve>
void SolveGroups(std::span<Blow> blows, std::span<StruckBody> bodies, Ties& ties, Solve&& solve);

// Blows that have no movable body in common with any other.
class Group {
 public:
  /// There will be `blows_max` in it at once: each is too large to be moved about.
  Group(std::span<StruckBody> bodies, Ties& ties, size_t blows_max)
      : bodies_(bodies), ties_(ties), changed_in_(bodies.size(), 0) {
    speeds_.reserve(bodies.size());
    blows_.reserve(blows_max);
    for (const StruckBody& body : bodies) speeds_.push_back({Pad(body.linear_velocity), Pad(body.angular_velocity)});
  }

  void Add(Blow& blow) { blows_.emplace_back(blow, bodies_, ties_, passed_); }
  // What was found is told to blows and bodies, and another group may be added.
  void Finish() {
    if (RanAway()) BeginAnew();
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

  void Settle(uint32_t sweeps_max = kSweepsMax) {
    PassDown();
    ForgetChanges();
    Progress progress;
    const bool are_few = blows_.size() <= kFewBlows;
    const double settled = are_few || DoesAnyBounce() ? kSettled : kSettledAtRest;
    const size_t turns_max = std::max(kTurnsMax, kWholeSweeps * blows_.size());
    size_t turns = 0;
    bool may_leap = false;
    int solves_left = are_few || !MayBeSolvedAtOnce() ? 0 : IsTied() ? kTiedSolves : 1;
    uint32_t next_solve = kFirstSweeps;
    // Counted from one, so that each has a turn in the first.
    for (uint32_t sweep = 1; sweep <= sweeps_max && turns < turns_max; ++sweep) {
      double largest = 0;
      for (Settling& settling : blows_) {
        const uint32_t a = settling.blow().body_a, b = settling.blow().body_b;
        // Neither has been changed since its last turn.
        if (changed_in_[a] + 1 < sweep && changed_in_[b] + 1 < sweep) continue;
        ++turns;
        const double change = are_few ? settling.Settle(speeds_, passed_) : settling.Relax(speeds_, passed_);
        if (change > settled) NoteChange(settling.blow(), sweep);
        largest = std::max(largest, change);
      }
      progress.Note(largest);
      if (largest <= settled || progress.IsStuck()) return;
      if (sweep >= next_solve && solves_left > 0 && progress.TakesMoreThan(kManySweeps)) {
        solves_left -= SettleAtOnce(IsTied(), sweep) ? 1 : kTiedSolves / 2;
        next_solve = sweep + kFirstSweeps;
        leaps_.Forget();
      } else if (!are_few && (may_leap || progress.IsSteady()) && sweep + Leaps::kSweepsBetween <= sweeps_max &&
                 turns + Leaps::kSweepsBetween * blows_.size() <= turns_max) {
        if (!std::exchange(may_leap, true)) leaps_.Begin(kAxes * blows_.size());
        Leap(sweep);
      }
    }
    if (sweeps_max == kSweepsMax && !progress.IsLittleLeft() && MayBeSolvedAtOnce() && (IsTied() || IsUneven()))
      SettleAtOnce(true, kSweepsMax);
  }

  void Restitute() {
    Remember();
    const double allowed = (1 + kEnergySlack) * Energy();
    Settle();
    const double excess = Energy() - allowed;
    if (excess > 0 && !is_driven_) ReturnLess(allowed, excess);
  }

 private:
  // Begins with what the blows come to if nobody who bears others gives way: each hands on what he gets to those who
  // bear him. That is all there is to be done of what lies on the ground and stays there, for which sweeps alone need
  // the more the higher it is. Guendelman, Bridson and Fedkiw, "Nonconvex rigid bodies with stacking", ACM Trans.
  // Graph. 22 (2003), end with that; here the sweeps have the last word.
  void PassDown() {
    const auto is_known = [](const Settling& each) { return each.blow().borne != Borne::kUnknown; };
    if (std::ranges::none_of(blows_, is_known)) return;
    std::vector<Vector3> rates;
    for (const Settling& settling : blows_) rates.push_back(settling.Rates(speeds_));
    std::vector<size_t> part;
    for (size_t first = 0; first < blows_.size(); ++first) {
      const auto borne = BorneBy(first);
      if (!borne || (first > 0 && BorneBy(first - 1) == borne)) continue;
      part.clear();
      for (size_t i = first; i < blows_.size() && BorneBy(i) == borne; ++i) part.push_back(i);
      HandOn(*borne, part);
    }
    // Twice what sweeps lessen, of which nothing is there without impulses. It is more where those give way that bear.
    double sum = 0;
    for (size_t i = 0; i < blows_.size(); ++i) sum += blows_[i].impulse().dot(rates[i] + blows_[i].Rates(speeds_));
    if (!(sum <= 0)) BeginAnew();
  }

  void BeginAnew() {
    for (Settling& settling : blows_) {
      settling.Restart(settling.blow().separation_speed);
      VisitMoved(settling.blow(), [&](uint32_t body) {
        speeds_[body] = {Pad(bodies_[body].linear_velocity), Pad(bodies_[body].angular_velocity)};
      });
    }
  }

  std::optional<uint32_t> BorneBy(size_t i) const {
    const Blow& blow = blows_[i].blow();
    if (blow.borne == Borne::kUnknown || blows_[i].is_tied()) return std::nullopt;
    return blow.borne == Borne::kA ? blow.body_a : blow.body_b;
  }

  // Solves `part`, all of the blows that bear one body.
  void HandOn(uint32_t borne, std::span<const size_t> part) {
    std::vector<StruckBody> bodies{bodies_[borne]};
    bodies.front().linear_velocity = speeds_[borne].linear.head<3>();
    bodies.front().angular_velocity = speeds_[borne].angular.head<3>();
    std::vector<Blow> blows;
    for (const size_t i : part) {
      Blow& blow = blows.emplace_back(blows_[i].blow());
      uint32_t& bearer = blow.borne == Borne::kA ? blow.body_b : blow.body_a;
      bodies.push_back(bodies_[bearer].Still());
      bearer = static_cast<uint32_t>(bodies.size() - 1);
      (blow.borne == Borne::kA ? blow.body_a : blow.body_b) = 0;
      blow.borne = Borne::kUnknown;
    }
    Ties none;
    SolveGroups(blows, bodies, none, [](Group& group) { group.Settle(kHandedSweeps); });
    for (size_t i = 0; i < part.size(); ++i) blows_[part[i]].Take(blows[i], speeds_, passed_);
  }

  bool MayBeSolvedAtOnce() const { return IsTied() || blows_.size() <= kBlowsAtOnce; }

  bool IsTied() const { return std::ranges::any_of(blows_, &Settling::is_tied); }

  // Whether its masses are such that it may take sweeps too many.
  bool IsUneven() const {
    double lightest = 0, heaviest = std::numeric_limits<double>::infinity();
    for (const Settling& settling : blows_) {
      for (const uint32_t body : {settling.blow().body_a, settling.blow().body_b}) {
        const double inverse_mass = bodies_[body].inverse_mass;
        if (inverse_mass == 0) continue;
        lightest = std::max(lightest, inverse_mass);
        heaviest = std::min(heaviest, inverse_mass);
      }
    }
    return lightest > kUneven * heaviest;
  }

  bool DoesAnyBounce() const {
    return std::ranges::any_of(blows_, [](const Settling& each) { return each.blow().separation_speed > 0; });
  }

  // To where sweeps, of which this was the last one, lead to.
  void Leap(uint32_t sweep) {
    leaps_.BeginSweep();
    for (const Settling& settling : blows_) {
      for (int i = 0; i < kAxes; ++i) leaps_.Note(settling.impulse()[i], settling.Softness(i));
    }
    if (!leaps_.Decide()) return;
    size_t number = 0;
    for (Settling& settling : blows_) {
      Vector3 far;
      for (double& each : far) each = leaps_.Of(number++);
      settling.Leap(far, speeds_, passed_);
      NoteChange(settling.blow(), sweep);
    }
  }

  // What sweeps, of which this was the last one, did not bring to its end. Whether it came nearer.
  bool SettleAtOnce(bool thoroughly, uint32_t sweep) {
    if (IsTied()) return SettleTiedAtOnce(thoroughly, sweep);
    std::array<Blow, kBlowsAtOnce> blows;
    std::array<OfBlow, kBlowsAtOnce> rates;
    const size_t count = blows_.size();
    for (size_t i = 0; i < count; ++i) {
      blows_[i].Finish();
      blows[i] = blows_[i].blow();
      rates[i] = blows_[i].Rates(speeds_);
    }
    if (!SolveAtOnce(std::span(blows).first(count), bodies_, std::span(rates).first(count), thoroughly)) return false;
    for (size_t i = 0; i < count; ++i) {
      blows_[i].Take(blows[i], speeds_, passed_);
      NoteChange(blows[i], sweep);
    }
    return true;
  }

  // The same of those that press or close, and of too many of these that press hardest: of what stands on the ground
  // most corners do neither.
  bool SettleTiedAtOnce(bool thoroughly, uint32_t sweep) {
    std::vector<Settling*> part;
    const bool are_many = blows_.size() > kTiedBlowsAtOnce;
    for (Settling& settling : blows_) {
      if (!settling.gives_way()) continue;
      if (!are_many || settling.impulse()[0] > 0 || settling.Rates(speeds_)[0] < kSettled) part.push_back(&settling);
    }
    if (part.size() > kTiedBlowsAtOnce) {
      std::ranges::stable_sort(part, std::ranges::greater(), [&](const Settling* settling) {
        return settling->impulse()[0] - settling->Rates(speeds_)[0] / settling->Softness(0);
      });
      part.resize(kTiedBlowsAtOnce);
    }
    std::vector<Blow> blows;
    std::vector<OfBlow> rates;
    for (Settling* const settling : part) {
      settling->Finish();
      blows.push_back(settling->blow());
      rates.push_back(settling->Rates(speeds_));
    }
    if (!SolveTiedAtOnce(blows, AnswersOf(part), rates, thoroughly)) return false;
    const double most = kWedged * MomentumOf(part);
    if (std::ranges::any_of(blows, [&](const Blow& blow) { return blow.impulse > most; })) return false;
    for (size_t i = 0; i < blows.size(); ++i) {
      part[i]->Take(blows[i], speeds_, passed_);
      NoteChange(blows[i], sweep);
    }
    return true;
  }

  // Whether something pressed harder the more it rubbed, from sweep to sweep, until no number was as large. Where what
  // moves by itself wedges others between it and the ground, there is no answer: that is left to the next solve.
  bool RanAway() const {
    return !std::ranges::all_of(blows_, [&](const Settling& settling) {
      bool is_finite = settling.impulse().allFinite();
      VisitMoved(settling.blow(), [&](uint32_t body) {
        is_finite = is_finite && speeds_[body].linear.allFinite() && speeds_[body].angular.allFinite();
      });
      return is_finite;
    });
  }

  // What the heaviest body that they move has at the fastest rate before them, N*s.
  double MomentumOf(std::span<Settling* const> part) const {
    double mass = 0, rate = 0;
    for (const Settling* const settling : part) {
      const Blow& blow = settling->blow();
      rate = std::max(rate, RelativeVelocity(blow, bodies_).norm() + blow.separation_speed);
      VisitMoved(blow, [&](uint32_t body) {
        if (bodies_[body].inverse_mass > 0) mass = std::max(mass, 1 / bodies_[body].inverse_mass);
      });
    }
    return mass * rate;
  }

  // How rates of each answer to impulses of each, 1/kg.
  Eigen::MatrixXd AnswersOf(std::span<Settling* const> part) {
    const auto size = static_cast<Eigen::Index>(3 * part.size());
    Eigen::MatrixXd answers(size, size);
    const Speeds rest{Padded::Zero(), Padded::Zero()};
    std::vector<Speeds> moved(speeds_.size(), rest);
    for (Eigen::Index of = 0; of < size; ++of) {
      const Settling& pushed = *part[static_cast<size_t>(of / 3)];
      pushed.Push(static_cast<int>(of % 3), 1, moved, passed_);
      for (Eigen::Index to = 0; to < size; to += 3) {
        answers.block<3, 1>(to, of) = part[static_cast<size_t>(to / 3)]->Motion(moved);
      }
      VisitMoved(pushed.blow(), [&](uint32_t body) { moved[body] = rest; });
    }
    return answers;
  }

  // Whom it hits, and all that are tied to these.
  template <typename Visit>
  void VisitMoved(const Blow& blow, Visit&& visit) const {
    for (const uint32_t body : {blow.body_a, blow.body_b}) {
      const std::span<const uint32_t> tied = ties_.empty() ? std::span<const uint32_t>() : ties_.With(body);
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
      is_driven_ |= !settling.blow().run.isZero(0);
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

  // Asks for such a part of the separation that all of the energy (J) that is allowed is left, of which it would have
  // too much by `above` without that. The part is looked for by the Illinois variant of the false position: Dowell and
  // Jarratt, "A modified regula falsi method for computing the root of an equation", BIT 11 (1971).
  void ReturnLess(double allowed, double above) {
    asked_.clear();
    for (const Settling& settling : blows_) asked_.push_back(settling.blow().separation_speed);
    struct End {
      double part = 0;
      double excess = 0;  // J
      double weight = 1;
    };
    End low{0, ExcessAt(0, allowed)}, high{1, above};
    const double spare = kEnergySpare * allowed;
    double present = low.part;
    const End* last_moved = nullptr;
    for (int look = 0; look < kEnergyLooksMax && low.excess < -spare; ++look) {
      const double under = low.weight * (low.excess + spare / 2), over = high.weight * (high.excess + spare / 2);
      present = low.part - (high.part - low.part) * under / (over - under);
      const double excess = ExcessAt(present, allowed);
      End& moved = excess > 0 ? high : low;
      End& kept = excess > 0 ? low : high;
      // An end that stays counts for less and less, so that it does not stay for ever.
      if (last_moved == &moved) kept.weight /= 2;
      moved = {present, excess};
      last_moved = &moved;
    }
    if (present != low.part) ExcessAt(low.part, allowed);
  }

  // J, if it begins anew and asks for that part of the separation.
  double ExcessAt(double part, double allowed) {
    Return(part);
    Settle();
    return Energy() - allowed;
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
  Leaps leaps_;
  bool is_driven_ = false;  // something that cannot be moved moves, or a surface runs
};

template <typename Solve>
void SolveGroups(std::span<Blow> blows, std::span<StruckBody> bodies, Ties& ties, Solve&& solve) {
  const BlowGroups groups(blows, bodies, ties);
  Group group(bodies, ties, groups.largest());
  groups.Walk([&](uint32_t i) { group.Add(blows[i]); },
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

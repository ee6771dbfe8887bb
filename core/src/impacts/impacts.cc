#include "impacts/impacts.h"

#include "motion/locked_axes.h"
#include "motion/running_surfaces.h"
#include "pairs/contact_points.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace genphys {
namespace {

// m: as deep as this two bodies are in touch, for rounding leaves gaps between what was put together.
constexpr double kDepthMin = -1e-9;
// Deeper than so many times what the closing speed covers is an impact of this substep only if they are seen apart in
// it.
constexpr double kFreshDepth = 1.5;
// Where most pairs meet: memory for so many is asked for at once.
constexpr size_t kMostPoints = 4;

double ClosingOf(const ContactPoint& point) { return -point.relative_velocity.dot(point.normal); }

// The Coulomb coefficient where surfaces slip at `speed`, m/s: at rest or while sliding.
double FrictionAt(const MixedMaterial& material, double speed) {
  return speed > kSlidingSpeed ? material.kinetic_friction : material.friction;
}

}  // namespace

Impacts::Impacts(const ImpactWorld& world, double step_size, bool rewinds)
    : world_(world),
      step_size_(step_size),
      rewinds_(rewinds),
      speed_(world_, step_size),
      past_(world_, step_size),
      bearings_(world_, past_),
      crowds_(world.crowd_number) {}

bool Impacts::Solve(const ContactBuffer& contacts, const RowMarks* changed, std::span<const SweptPair> swept,
                    std::span<const FlownWay> flown) {
  ++solves_;
  moved_.clear();
  past_.Follow(flown);
  Find(contacts, changed, swept);
  if (candidates_.empty()) return false;
  const auto is_woken = [&](const Candidate& candidate) {
    return bearings_.IsWoken(candidate.pair.entity_a) || bearings_.IsWoken(candidate.pair.entity_b);
  };
  if (rewinds_) bearings_.FindStances(contacts, std::ranges::any_of(candidates_, is_woken));
  FindGroups();
  FindGoing();
  // By their depth alone the edge of a tile behind can seem to have been met before the one that was.
  Time();
  do {
    KeepEarliest();
    Time();
  } while (AreEarlierWaiting());
  CollectStruck(contacts);
  blows_.clear();
  blow_pairs_.clear();
  blows_.reserve(kMostPoints * candidates_.size());
  blow_pairs_.reserve(blows_.capacity());
  for (Candidate& candidate : candidates_) AddBlows(contacts, candidate);
  DropUnreached();
  AddSupportBlows();
  bool has_hit = false;
  if (!blows_.empty()) {
    Separate();
    NoteGrazes();
    Record();
    has_hit = MarkHit();
    if (has_hit) Apply(RestOfStep());
  }
  world_.struck_index.Clear();
  world_.group_of.Clear();
  world_.earliest.Clear();
  return has_hit || !waiting_.empty();
}

void Impacts::MarkStruck(RowMarks& marks) const {
  for (const Struck& struck : struck_) {
    if (struck.is_hit && struck.motion.is_movable()) marks.Mark(struck.row);
  }
}

std::vector<EntityRow> Impacts::WaitingSwept() const {
  std::vector<EntityRow> rows;
  for (const Candidate& candidate : waiting_) {
    if (candidate.is_swept) rows.insert(rows.end(), {candidate.pair.entity_a, candidate.pair.entity_b});
  }
  return rows;
}

void Impacts::Find(const ContactBuffer& contacts, const RowMarks* changed, std::span<const SweptPair> swept) {
  const auto is_changed = [&](const ContactPair& pair) {
    return changed == nullptr || (*changed)[pair.entity_a] || (*changed)[pair.entity_b];
  };
  // Those that waited for others have their turn as they were.
  std::swap(candidates_, waiting_);
  waiting_.clear();
  crowds_.Clear();
  std::erase_if(candidates_, [&](const Candidate& candidate) { return is_changed(candidate.pair); });
  places_.Forget();
  parting_.clear();
  for (const ContactPair& pair : contacts.pairs) {
    if (!is_changed(pair)) continue;
    if (const std::optional<Candidate> candidate = Judge(contacts, pair)) {
      candidates_.push_back(*candidate);
    } else if (Overlaps(contacts, pair)) {
      parting_.push_back(pair);
    }
  }
  for (const SweptPair& pair : swept) {
    Candidate* const known = CandidateOf(pair.geometry_a, pair.geometry_b);
    const ContactPair as_contact{.entity_a = pair.entity_a,
                                 .entity_b = pair.entity_b,
                                 .geometry_a = pair.geometry_a,
                                 .geometry_b = pair.geometry_b,
                                 .material = world_.rule.Mixed(pair.geometry_a, pair.geometry_b)};
    Candidate candidate{.pair = as_contact,
                        .time = pair.time,
                        .closing = pair.closing,
                        .is_swept = true,
                        .is_deep = pair.is_deep,
                        .is_held = IsHeldThrough(as_contact)};
    // Who looked along a way knows when it met something, and points at its end do not.
    if (known == nullptr) {
      candidates_.push_back(candidate);
    } else {
      if (ComesDeep(known->pair, known->closing)) candidate.by_depth = known->time;
      *known = candidate;
    }
  }
  FindMissed(contacts);
}

// The impact of this pair, if its points say that there was one.
std::optional<Impacts::Candidate> Impacts::Judge(const ContactBuffer& contacts, const ContactPair& pair) const {
  if (pair.is_sensor) return std::nullopt;
  // What rests or jostles closes with nothing so fast, and that is most of a pile.
  const std::span<const ContactPoint> points = PointsOf(contacts, pair);
  const auto closes = [&](const ContactPoint& point) {
    const double closing = ClosingOf(point);
    return point.depth >= kDepthMin && closing > ImpactSpeed::kMin &&
           closing > speed_.Of(pair.entity_a, pair.entity_b, point.normal);
  };
  const auto tips = [&](const ContactPoint& point) { return point.depth >= kDepthMin && TipsOnto(pair, point); };
  const bool is_free = speed_.IsFree(pair), is_beside = !is_free && std::ranges::any_of(points, tips);
  if (!is_beside && std::ranges::none_of(points, closes)) return std::nullopt;
  const auto slams = [&](const ContactPoint& point) { return closes(point) && SlamsOnto(pair, ClosingOf(point)); };
  const bool is_held = is_beside || (!is_free && (IsNewAmongHeld(pair) || std::ranges::any_of(points, slams)));
  if (!is_free && !is_held && pair.material.restitution == 0) return std::nullopt;
  const double since = past_.FreeSince(pair);
  const bool goes_back = rewinds_ && (is_free || is_held);
  std::optional<Candidate> found;
  std::optional<bool> were_apart;  // as far as somebody looked
  for (const ContactPoint& point : points) {
    if (!(closes(point) || (is_beside && tips(point))) || OnlySlidesOnto(pair, point)) continue;
    const double closing = ClosingOf(point);
    bool is_fresh = goes_back && point.depth > 0;
    if (is_fresh && point.depth > kFreshDepth * closing * since) {
      if (!were_apart) were_apart = WereApart(pair, since, point.relative_velocity.norm());
      is_fresh = *were_apart;
    }
    double time = 0;
    if (is_fresh) {
      const Vector3 pull = past_.PullOn(pair.entity_b) - past_.PullOn(pair.entity_a);
      const double square = closing * closing + 2 * pull.dot(point.normal) * point.depth;
      time = square > 0 ? 2 * point.depth / (closing + std::sqrt(square)) : point.depth / closing;
      time = std::min(time, since);
    }
    if (!found || time > found->time)
      found = Candidate{.pair = pair, .time = time, .closing = closing, .is_held = is_held, .is_beside = is_beside};
  }
  if (found) found->were_apart = were_apart.value_or(false);
  return found;
}

// Finds when those happen of which that is not known yet, unless too many hang together.
void Impacts::Time() {
  CountCrowds();
  for (Candidate& candidate : candidates_) {
    if (candidate.is_timed || candidate.time == 0) continue;
    if (!AnyGoesBack(candidate)) {
      candidate.time = 0;
      continue;
    }
    if (candidate.is_deep) continue;
    candidate.is_timed = candidate.is_swept || !IsCrowded(candidate.pair);
    if (candidate.is_timed) Refine(candidate);
    candidate.is_level = candidate.is_timed && candidate.is_swept && OnlyPassesOver(candidate);
    if (!candidate.is_level || candidate.by_depth == 0) continue;
    // Another corner than the one that passes over comes down after that.
    candidate.is_level = candidate.is_swept = false;
    candidate.time = candidate.by_depth;
    Refine(candidate);
  }
  std::erase_if(candidates_, [](const Candidate& candidate) { return candidate.is_level; });
  places_.Forget();
  for (Candidate& candidate : candidates_) PutOff(candidate);
}

// Of the first of these impacts of a body, or of what joints hold together with it, s before the end.
double& Impacts::EarliestOf(EntityRow row) {
  const Group* const group = GroupOf(row);
  return world_.earliest[group != nullptr ? group->linked.rows.front() : row];
}

void Impacts::FindEarliest() {
  world_.earliest.Clear();
  for (const Candidate& c : candidates_) {
    for (EntityRow row : {c.pair.entity_a, c.pair.entity_b}) {
      if (world_.active[Index(row)]) EarliestOf(row) = std::max(EarliestOf(row), c.time);
    }
  }
}

// Whether somebody waits who went through another one, and what it waits for turned out to happen only after that. All
// are sorted anew then: whose time is known keeps it, so that this comes to an end.
bool Impacts::AreEarlierWaiting() {
  FindEarliest();
  const bool are_any = std::ranges::any_of(waiting_, [&](const Candidate& c) {
    const double first = std::max(EarliestOf(c.pair.entity_a), EarliestOf(c.pair.entity_b));
    return c.is_swept && first > 0 && c.time > first + kSameTime * step_size_;
  });
  if (!are_any) return false;
  candidates_.insert(candidates_.end(), waiting_.begin(), waiting_.end());
  waiting_.clear();
  return true;
}

// Later impacts of a body, or of what joints hold together with it, wait until the earlier ones have changed its way.
void Impacts::KeepEarliest() {
  FindEarliest();
  std::erase_if(candidates_, [&](const Candidate& c) {
    const double first = std::max(EarliestOf(c.pair.entity_a), EarliestOf(c.pair.entity_b));
    const bool waits = c.time < first - kSameTime * step_size_;
    if (waits) waiting_.push_back(c);
    return waits;
  });
  std::sort(candidates_.begin(), candidates_.end(), [&](const Candidate& a, const Candidate& b) {
    const auto key = [&](const Candidate& c) {
      return std::tuple(world_.state.ids[Index(c.pair.entity_a)], world_.state.ids[Index(c.pair.entity_b)],
                        world_.rule.info(c.pair.geometry_a).geometry_id,
                        world_.rule.info(c.pair.geometry_b).geometry_id);
    };
    return key(a) < key(b);
  });
  places_.Forget();
}

void Impacts::HoldLocked(EntityRow row, StruckBody& body) const {
  const SceneEntity& entity = *world_.scene.entities[Index(row)];
  if (!entity.traits.is_locked) return;
  const LockedAxes& locks = entity.desc->rigid_body->locked_axes;
  for (int i = 0; i < 3; ++i) body.freedom[i] = locks.linear[static_cast<size_t>(i)] ? 0 : 1;
  body.inverse_tensor = LockedInverse(locks, body.tensor);
  DropLocked(locks, body.linear_velocity, body.angular_velocity);
}

uint32_t Impacts::NumberOf(EntityRow row) {
  int& index = world_.struck_index[row];
  if (index < 0) {
    index = static_cast<int>(struck_.size());
    struck_.push_back({.row = row, .motion = past_.MotionOf(row)});
  }
  return static_cast<uint32_t>(index);
}

void Impacts::AddStruck(EntityRow row, const Candidate& candidate) {
  Struck& struck = struck_[NumberOf(row)];
  // What nothing can move is where it is at the time of whom it meets, which is the same for all of one moment.
  if (GoesBack(row, candidate)) struck.time = std::max(struck.time, candidate.time);
}

void Impacts::CollectStruck(const ContactBuffer& contacts) {
  struck_.clear();
  struck_.reserve(2 * candidates_.size());
  bodies_.clear();
  for (const Candidate& candidate : candidates_) {
    AddStruck(candidate.pair.entity_a, candidate);
    AddStruck(candidate.pair.entity_b, candidate);
  }
  TieStruck();
  AddSupports(contacts);
  ties_.VisitLacking([&](const Ties::Change& change) {
    struck_[change.body].lacking_linear = change.linear;
    struck_[change.body].lacking_angular = change.angular;
  });
  bodies_.reserve(struck_.size());
  for (const Struck& struck : struck_) {
    StruckBody& body = bodies_.emplace_back(struck.motion.BodyBefore(struck.time));
    if (struck.motion.is_movable()) HoldLocked(struck.row, body);
    body.linear_velocity += struck.lacking_linear;
    body.angular_velocity += struck.lacking_angular;
  }
}

Vector3 Impacts::RunAcross(const ContactPair& pair, const Vector3& normal) const {
  if (!world_.rule.any_surface_runs()) return Vector3::Zero();
  const Vector3 run = SurfaceVelocity(world_.rule, world_.state, pair.geometry_a, pair.geometry_b);
  return run - run.dot(normal) * normal;
}

void Impacts::AddBlow(const Candidate& candidate, const Vector3& position, const Vector3& normal) {
  blows_.push_back({.body_a = static_cast<uint32_t>(world_.struck_index[candidate.pair.entity_a]),
                    .body_b = static_cast<uint32_t>(world_.struck_index[candidate.pair.entity_b]),
                    .position = position,
                    .normal = normal,
                    .run = RunAcross(candidate.pair, normal),
                    .borne = candidate.borne});
  blow_pairs_.push_back(&candidate);
}

void Impacts::AddBlows(const ContactBuffer& contacts, Candidate& candidate) {
  const ContactPair& pair = candidate.pair;
  const double time_a = struck_[static_cast<size_t>(world_.struck_index[pair.entity_a])].time;
  const double time_b = struck_[static_cast<size_t>(world_.struck_index[pair.entity_b])].time;
  if (candidate.time > 0) {
    Manifold manifold;
    const double gap = std::max(FlatGap(pair), kFlatPart * candidate.closing * step_size_);
    past_.FindMeeting(pair, time_a, time_b, gap, manifold);
    const auto points = std::span(manifold.points).first(static_cast<size_t>(manifold.count));
    for (const MeetingPoint& point : points) AddBlow(candidate, point.position, point.normal);
    if (candidate.is_timed) candidate.gap = GapOf(points);
    if (manifold.count > 0) return;
  }
  for (const ContactPoint& point : PointsOf(contacts, pair)) {
    if (point.depth >= kDepthMin) AddBlow(candidate, point.position, point.normal);
  }
}

// How the two separate at the blow by Newton's law, and how they rub. Returns the velocity of b against a, m/s.
Vector3 Impacts::Ask(Blow& blow, const ContactPair& pair) const {
  const Vector3 approach = RelativeVelocity(blow, bodies_);
  const double closing = -approach.dot(blow.normal);
  const bool bounces = closing > speed_.Of(pair.entity_a, pair.entity_b, blow.normal);
  blow.separation_speed = bounces ? pair.material.restitution * closing : 0;
  blow.friction = FrictionAt(pair.material, (approach + closing * blow.normal + blow.run).norm());
  return approach;
}

// Who goes on from the time of a blow. What joints hold and nothing hits, with all that hangs together with it, goes on
// as if nobody had looked: what only seems to close, for joints are about to change that, would do so again. What is
// free may be hit later. Returns whether there is anybody.
bool Impacts::MarkHit() {
  bool is_any = false;
  const auto goes_on = [&](uint32_t i) {
    const bool is_tied = !ties_.With(blows_[i].body_a).empty() || !ties_.With(blows_[i].body_b).empty();
    return blows_[i].impulse > 0 || !is_tied;
  };
  const auto mark = [&](uint32_t body) {
    struck_[body].is_hit = true;
    for (const uint32_t each : ties_.With(body)) struck_[each].is_hit = true;
  };
  VisitTogether([&](std::span<const uint32_t> together) {
    if (std::ranges::none_of(together, goes_on)) return;
    is_any = true;
    for (const uint32_t i : together) {
      mark(blows_[i].body_a);
      mark(blows_[i].body_b);
    }
  });
  return is_any;
}

void Impacts::Separate() {
  approaches_.clear();
  approaches_.reserve(blows_.size());
  for (size_t i = 0; i < blows_.size(); ++i) approaches_.push_back(Ask(blows_[i], blow_pairs_[i]->pair));
  Restitute(blows_, bodies_, ties_);
  BearBlows();
}

void Impacts::Record() {
  if (impulses_.points.empty()) impulses_.points.reserve(blows_.size());
  for (size_t i = 0; i < blows_.size(); ++i) {
    if (i == 0 || blow_pairs_[i] != blow_pairs_[i - 1]) {
      ContactPair pair = blow_pairs_[i]->pair;
      pair.first_point = static_cast<uint32_t>(impulses_.points.size());
      pair.point_count = 0;
      impulses_.pairs.push_back(pair);
    }
    ++impulses_.pairs.back().point_count;
    const Blow& blow = blows_[i];
    impulses_.points.push_back({.position = blow.position,
                                .normal = blow.normal,
                                .friction = blow.friction,
                                .normal_impulse = blow.impulse,
                                .friction_impulse = blow.rubbing,
                                .relative_velocity = approaches_[i]});
  }
}

void Impacts::Apply(const std::vector<StruckBody>& ends) {
  const std::vector<Arrival> arrivals = Arrive(ends);
  for (size_t i = 0; i < struck_.size(); ++i) {
    const Struck& struck = struck_[i];
    if (!struck.motion.is_movable() || !struck.is_hit) continue;
    const uint32_t row = Index(struck.row);
    HalfStep& half = world_.layer.half_steps[row];
    if (struck.time > 0) {
      world_.shoved.Unmark(struck.row);
      world_.free_since[struck.row] = struck.time;
      const Pose then = struck.motion.PoseBefore(struck.time);
      moved_.push_back(
          {struck.row, then, struck.time, arrivals[i].acceleration, arrivals[i].torque, arrivals[i].by_others});
      world_.state.set_pose(struck.row, arrivals[i].pose);
      world_.state.linear_velocities.col(row) = arrivals[i].linear_velocity;
      world_.state.angular_velocities.col(row) = arrivals[i].angular_velocity;
      half.Restart();
      continue;
    }
    if (rewinds_) world_.shoved.Mark(struck.row);
    // Its way says no longer how it goes.
    if (world_.jointed[struck.row]) world_.free_since[struck.row] = 0;
    const Vector3 linear = ends[i].linear_velocity - struck.lacking_linear;
    const Vector3 angular = ends[i].angular_velocity - struck.lacking_angular;
    const Vector3 gained = linear - world_.state.linear_velocities.col(row);
    const Vector3 turned = angular - world_.state.angular_velocities.col(row);
    world_.state.linear_velocities.col(row) = linear;
    world_.state.angular_velocities.col(row) = angular;
    half.is_struck = true;
    if (past_.StandsOnGround(struck.row)) half.Restart();
    half.velocity += gained;
    half.momentum += ends[i].tensor * turned;
  }
  std::sort(moved_.begin(), moved_.end(), [](const FlownWay& a, const FlownWay& b) { return a.row < b.row; });
}

}  // namespace genphys

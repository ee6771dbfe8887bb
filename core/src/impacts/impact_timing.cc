// When two met: they are taken back along their ways to where they just touch.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "impacts/impacts.h"
#include "motion/free_rotation.h"
#include "pairs/contact_points.h"
#include "shapes/reach.h"

namespace genphys {
namespace {

// Where more impacts than this hang together, each is timed by its depth alone: each look at a pair costs as much as a
// contact, and a pile has hundreds.
constexpr size_t kRefinedMax = 8;

constexpr int kLooksMax = 14;
// How deep (m, and of the way of a substep) an impact in time may be.
constexpr double kTimedDepth = 2e-7;
constexpr double kTimedPart = 1e-5;

// So many solves of one substep each find an impact when it is; after that those that roll on come on by this part of
// the substep at least, so that they come to its end.
constexpr int kManySolves = 8;
constexpr double kLeastProgress = 1.0 / 16;

// m: no deeper than this is what just comes to touch, and when it had overlapped by so much it is looked at once more.
constexpr double kJustTouching = 1e-6;
constexpr double kLookAhead = 1e-5;
// m/s: what closes more slowly is no edge that something comes to.
constexpr double kCreeping = 1e-4;
// What meets beside a point that is pressed meets there anew if that is farther away than so many times the way of a
// substep.
constexpr double kBeside = 4;
// Substeps in which what comes down at the other end goes up again, at least.
constexpr double kTippingSteps = 1;
// Of the reach of what comes down: so far it may come in a substep and be left to the next solve.
constexpr double kDeepPart = 0.005;
// What comes to an edge goes so many times as fast along the ground as it comes nearer.
constexpr double kAlong = 4;

// m, the least FlatGap(): it is what narrow phases and the way back to an impact leave between corners.
constexpr double kFlatGapLeast = 1e-6;
// rad: what lies so little askew lands flat.
constexpr double kFlatTilt = 2e-4;

// m: at which two are taken to collide that cover `way` (m) in a substep.
double DepthOfImpact(double way) { return kTimedDepth + kTimedPart * way; }

// m: so deep those may come to be that are put off, for they graze each other.
constexpr double kGrazeDepth = 2e-5;
// Of the substep: by so much they are put off at first, and by twice as much each time.
constexpr double kFirstPutOff = 1.0 / 512;

}  // namespace

// Who hangs together with whom.
void Impacts::FindCrowds(const ContactBuffer& contacts) {
  const auto join = [&](const ContactPair& pair) {
    if (!pair.is_sensor && past_.IsMovable(pair.entity_a) && past_.IsMovable(pair.entity_b))
      crowds_.Join(pair.entity_a, pair.entity_b);
  };
  for (const ContactPair& pair : contacts.pairs) join(pair);
  for (const Candidate& candidate : candidates_) join(candidate.pair);
  CountCrowds();
}

// In how many impacts they are, unless those are few in all.
void Impacts::CountCrowds() {
  if (crowds_.empty()) return;
  crowds_.StartCount();
  for (const Candidate& candidate : candidates_) crowds_.Count(MovableOf(candidate.pair));
}

bool Impacts::IsCrowded(const ContactPair& pair) { return crowds_.Of(MovableOf(pair)) > kRefinedMax; }

EntityRow Impacts::MovableOf(const ContactPair& pair) const {
  return past_.IsMovable(pair.entity_a) ? pair.entity_a : pair.entity_b;
}

bool Impacts::Overlaps(const ContactBuffer& contacts, const ContactPair& pair) const {
  return rewinds_ && !pair.is_sensor && std::ranges::any_of(PointsOf(contacts, pair), [](const ContactPoint& point) {
           return point.depth > kFlatGap;
         });
}

// m, from the mass centre of the smaller one of those of the two that can be moved.
double Impacts::ReachOf(const ContactPair& pair) const {
  double reach = std::numeric_limits<double>::infinity();
  for (const auto& [entity, geometry] :
       {std::pair(pair.entity_a, pair.geometry_a), std::pair(pair.entity_b, pair.geometry_b)}) {
    if (!past_.IsMovable(entity)) continue;
    const Vector3& center = world_.scene.entities[Index(entity)]->mass.center_of_mass;
    reach = std::min(reach, ReachFrom(center, past_.GeometryAt(geometry)));
  }
  return reach;
}

// m: by how much the other corners of what lands flat may be off. A part of millimetres lies as far askew with less.
double Impacts::FlatGap(const ContactPair& pair) const {
  return std::clamp(kFlatTilt * ReachOf(pair), kFlatGapLeast, kFlatGap);
}

// What turns fast may have met something, and part again by the end of the substep.
void Impacts::FindMissed(const ContactBuffer& contacts) {
  if (candidates_.size() > kRefinedMax) FindCrowds(contacts);
  std::erase_if(parting_, [&](const ContactPair& pair) {
    return IsCrowded(pair) || !(speed_.IsFree(pair) || IsNewAmongHeld(pair));
  });
  if (crowds_.empty() && candidates_.size() + parting_.size() > kRefinedMax) FindCrowds(contacts);
  if (!crowds_.empty()) {
    for (const ContactPair& pair : parting_) crowds_.Count(MovableOf(pair));
  }
  for (const ContactPair& pair : parting_) {
    if (IsCrowded(pair) || CandidateOf(pair.geometry_a, pair.geometry_b) != nullptr) continue;
    const double since = past_.FreeSince(pair);
    double depth = 0, speed = 0;
    for (const ContactPoint& point : PointsOf(contacts, pair)) {
      depth = std::max(depth, point.depth);
      speed = std::max(speed, point.relative_velocity.norm());
    }
    if (since == 0 || !WereApart(pair, since, speed)) continue;
    candidates_.push_back({.pair = pair,
                           .time = since / 2,
                           .closing = depth / since,
                           .were_apart = true,
                           .is_held = !speed_.IsFree(pair)});
  }
}

bool Impacts::IsNewAmongHeld(const ContactPair& pair) const {
  if (!rewinds_ || !(world_.active[Index(pair.entity_a)] || world_.active[Index(pair.entity_b)])) return false;
  EntityPair entities{world_.state.ids[Index(pair.entity_a)], world_.state.ids[Index(pair.entity_b)]};
  if (entities.b < entities.a) std::swap(entities.a, entities.b);
  if (!past_.WereTouching(entities)) return true;
  return pair.material.restitution > 0 && !past_.WerePressed(entities);
}

// Whether what closes so fast, m/s, comes deep into the other one in a substep.
bool Impacts::ComesDeep(const ContactPair& pair, double closing) const {
  return closing * step_size_ > kDeepPart * ReachOf(pair);
}

bool Impacts::SlamsOnto(const ContactPair& pair, double closing) const {
  if (!rewinds_ || (past_.IsMovable(pair.entity_a) && past_.IsMovable(pair.entity_b))) return false;
  if (world_.jointed[pair.entity_a] || world_.jointed[pair.entity_b]) return false;
  const EntityPair entities{world_.state.ids[Index(pair.entity_a)], world_.state.ids[Index(pair.entity_b)]};
  return ComesDeep(pair, closing) && !past_.WerePressed(entities);
}

bool Impacts::TipsOnto(const ContactPair& pair, const ContactPoint& point) const {
  const double closing = -point.relative_velocity.dot(point.normal);
  if (!(rewinds_ && closing > ImpactSpeed::kMin)) return false;
  // In a pile that falls most do not lie where they did, and to tell when each of them comes down takes a tenth of all.
  if (past_.IsMovable(pair.entity_a) && past_.IsMovable(pair.entity_b)) return false;
  // Of what joints hold a solve says more of the way than what is free does.
  if (world_.jointed[pair.entity_a] || world_.jointed[pair.entity_b]) return false;
  if (!IsBesideHeld(pair, point.position, point.relative_velocity)) return false;
  if (pair.material.restitution > 0 && closing > speed_.Of(pair.entity_a, pair.entity_b, point.normal)) return true;
  const bool is_alone = past_.PressesNobody(MovableOf(pair)) || ComesDeep(pair, closing);
  return is_alone && closing > TippingSpeed(pair, point);
}

// Whether the two are pressed against each other, but not near there.
bool Impacts::IsBesideHeld(const ContactPair& pair, const Vector3& position, const Vector3& velocity) const {
  const EntityPair entities{world_.state.ids[Index(pair.entity_a)], world_.state.ids[Index(pair.entity_b)]};
  const double near = kBeside * step_size_ * velocity.norm();
  return past_.WerePressed(entities) && !past_.WerePressedNear(pair, position, near);
}

// m/s: what comes down more slowly goes to and fro within a few substeps, and is left to solves. What it is held by
// takes most of its weight.
double Impacts::TippingSpeed(const ContactPair& pair, const ContactPoint& point) const {
  const EntityRow row = MovableOf(pair);
  const HalfStep& half = world_.layer.half_steps[Index(row)];
  // Of who began anew nobody knows how it is held.
  if (half.restarts || half.substep == 0) return speed_.Of(pair.entity_a, pair.entity_b, point.normal);
  const MassProperties& mass = world_.scene.entities[Index(row)]->mass;
  const Pose pose = world_.state.pose(row);
  const Vector3 arm = point.position - pose.Transform(mass.center_of_mass);
  const Vector3 spin = world_.state.angular_velocities.col(Index(row));
  const Vector3 torque = 2 / half.substep * (half.steady_twist + half.held_momentum);
  const Vector3 turning = WorldTensor(pose.orientation, mass.inverse_tensor) * torque;
  const Vector3 pull = world_.accelerations[row] + 2 / half.substep * half.held_velocity + turning.cross(arm) +
                       spin.cross(spin.cross(arm));
  return ImpactSpeed::kMin + kTippingSteps * step_size_ * std::abs(pull.dot(point.normal));
}

// The same of two of which one went through the other: what held them until then did not.
bool Impacts::IsHeldThrough(const ContactPair& pair) const {
  if (!rewinds_ || speed_.IsStillFree(pair)) return false;
  const bool is_jointed = world_.jointed[pair.entity_a] || world_.jointed[pair.entity_b];
  return !is_jointed || IsNewAmongHeld(pair);
}

bool Impacts::WereApart(const ContactPair& pair, double time, double speed) const {
  Manifold manifold;
  past_.FindMeeting(pair, time, time, 0, manifold);
  const double most = 2 * DepthOfImpact(speed * step_size_);
  const auto points = std::span(manifold.points).first(static_cast<size_t>(manifold.count));
  return std::ranges::all_of(points, [&](const MeetingPoint& point) { return point.depth <= most; });
}

// Two that are level touch at an edge when one comes to the other, and the normal there is that of neither's face.
bool Impacts::OnlySlidesOnto(const ContactPair& pair, const ContactPoint& point) const {
  const double closing = -point.relative_velocity.dot(point.normal), gap = std::max(-point.depth, 0.0);
  if (!(point.depth < kJustTouching && closing > kCreeping && closing * step_size_ > gap)) return false;
  if (gap < kLookAhead && closing <= speed_.Of(pair.entity_a, pair.entity_b, point.normal)) {
    // Most of what closes so slowly jostles, unless it is seen far ahead.
    const auto velocity = [&](EntityRow row) { return world_.state.linear_velocities.col(Index(row)); };
    const Vector3 way = velocity(pair.entity_b) - velocity(pair.entity_a);
    if (way.cross(point.normal).squaredNorm() < kAlong * kAlong * closing * closing) return false;
  }
  // What rolls over an edge goes past it, too, and lies on it all the time.
  if (past_.WerePressedSo(pair, point.normal)) return false;
  // As they went before this substep: what pulls them to the ground makes them no deeper there.
  const double time = (gap + kLookAhead) / closing;
  const Placement a = InTime(pair.entity_a, pair.geometry_a, point, Vector3::Zero(), time);
  const Placement b = InTime(pair.entity_b, pair.geometry_b, point, point.relative_velocity, time);
  Manifold manifold;
  FindContacts(past_.GeometryAt(pair.geometry_a).shape, a, past_.GeometryAt(pair.geometry_b).shape, b, 0, manifold);
  const auto points = std::span(manifold.points).first(static_cast<size_t>(manifold.count));
  return std::ranges::all_of(points, [](const MeetingPoint& p) { return p.depth < kLookAhead / 4; });
}

// The same of two of which one went past the other's edge: where they just touch any normal is as good as the next one,
// and a moment later there is one. Along that what slides over something level does not close, and what runs into a
// step does.
bool Impacts::OnlyPassesOver(const Candidate& candidate) const {
  const ContactPair& pair = candidate.pair;
  const ImpactMotion a = past_.MotionOf(pair.entity_a), b = past_.MotionOf(pair.entity_b);
  const bool goes_a = GoesBack(pair.entity_a, candidate), goes_b = GoesBack(pair.entity_b, candidate);
  Manifold manifold;
  const auto meet = [&](double time, double gap) {
    past_.FindMeeting(pair, a, goes_a ? time : 0, b, goes_b ? time : 0, gap, manifold);
    return std::span<const MeetingPoint>(manifold.points).first(static_cast<size_t>(manifold.count));
  };
  const auto approach = [&](double time, const MeetingPoint& point) {
    return Vector3(a.BodyBefore(goes_a ? time : 0).VelocityAt(point.position) -
                   b.BodyBefore(goes_b ? time : 0).VelocityAt(point.position));
  };
  double slip = 0;
  for (const MeetingPoint& point : meet(candidate.time, kLookAhead)) {
    slip = std::max(slip, approach(candidate.time, point).norm());
  }
  if (slip == 0) return false;
  const double then = candidate.time - kLookAhead / std::max(candidate.closing, slip / kAlong);
  const auto is_level = [&](double time, double depth) {
    const std::span<const MeetingPoint> points = meet(time, kLookAhead / 4);
    return !points.empty() && std::ranges::all_of(points, [&](const MeetingPoint& point) {
      const double closing = approach(time, point).dot(point.normal);
      return point.depth <= depth && closing <= speed_.Of(pair.entity_a, pair.entity_b, point.normal);
    });
  };
  if (is_level(then, std::numeric_limits<double>::infinity())) return true;
  // What a solve let come down to where it lies went there on another way than its velocity tells.
  return candidate.is_held && is_level(0, kLookAhead / 4);
}

Placement Impacts::InTime(EntityRow entity, GeometryRow geometry, const ContactPoint& point, const Vector3& velocity,
                          double time) const {
  const uint32_t row = Index(entity);
  const Vector3 spin = world_.state.angular_velocities.col(row);
  Pose pose = world_.state.pose(entity);
  pose.position += time * (velocity + spin.cross(pose.position - point.position));
  pose.orientation = Turned(pose.orientation, spin, time);
  return ToPlacement(pose.Transform(past_.GeometryAt(geometry).pose_in_entity));
}

bool Impacts::GoesBack(EntityRow row, const Candidate& candidate) const {
  // Alone it would leave behind whom joints hold together with it.
  if (IsLinked(row)) return rewinds_ && GroupOf(row)->is_tied;
  if (candidate.is_held || speed_.IsInFlight(row) || (rewinds_ && past_.StandsOnGround(row))) return true;
  return std::ranges::binary_search(going_, row);
}

// Whether what moved is where it was when the two met, and not where it is at the end.
bool Impacts::AnyGoesBack(const Candidate& candidate) const {
  const auto goes = [&](EntityRow row) { return past_.IsMovable(row) && GoesBack(row, candidate); };
  return goes(candidate.pair.entity_a) || goes(candidate.pair.entity_b);
}

// Finds who goes back for one impact at least, and so for all of them: those that meet something new that is held as
// well, and those of whom it is known how they went since they did; and who of them turns about what holds it.
void Impacts::FindGoing() {
  going_.clear();
  if (!rewinds_) return;
  for (const Candidate& candidate : candidates_) {
    for (const EntityRow row : {candidate.pair.entity_a, candidate.pair.entity_b}) {
      if (past_.IsMovable(row) && (candidate.is_held || past_.WayFromBlow(row) != nullptr)) going_.push_back(row);
    }
  }
  std::ranges::sort(going_);
  going_.erase(std::unique(going_.begin(), going_.end()), going_.end());
  std::vector<EntityRow> tipping;
  for (const Candidate& candidate : candidates_) {
    const EntityRow row = MovableOf(candidate.pair);
    if (candidate.is_beside && past_.StandsOnGround(row) && !past_.IsWoken(row)) tipping.push_back(row);
  }
  std::ranges::sort(tipping);
  past_.SetTipping(std::move(tipping));
}

// Finds the time at which the two just touch, by Newton's method between the bounds that it has seen. Two that graze
// each other close ever more slowly, so that by the speed at the end it would go to and fro: where two looks see them
// on both sides, those tell how fast they close. Two that overlap all the time collide when they begin to close.
void Impacts::Refine(Candidate& candidate) const {
  const double way = candidate.closing * step_size_;
  const double tolerance = DepthOfImpact(way);
  double gap = candidate.is_swept ? kFlatPart * way + kFlatGap : way + kFlatGap;
  const bool goes_a = GoesBack(candidate.pair.entity_a, candidate),
             goes_b = GoesBack(candidate.pair.entity_b, candidate);
  const ImpactMotion a = past_.MotionOf(candidate.pair.entity_a), b = past_.MotionOf(candidate.pair.entity_b);
  const double since = past_.FreeSince(candidate.pair);
  double touching = candidate.is_swept ? 0 : -1, apart = since, time = candidate.time;
  struct Look {
    double time;
    double lacking;  // m, too deep
  };
  std::optional<Look> last;
  Manifold manifold;
  for (int look = 0; look < kLooksMax; ++look) {
    const double time_a = goes_a ? time : 0, time_b = goes_b ? time : 0;
    const auto is_beside = [&](const MeetingPoint& point) {
      const Vector3 rate =
          b.BodyBefore(time_b).VelocityAt(point.position) - a.BodyBefore(time_a).VelocityAt(point.position);
      return IsBesideHeld(candidate.pair, point.position, rate);
    };
    past_.FindMeeting(candidate.pair, a, time_a, b, time_b, gap, manifold);
    double depth = -gap;
    const MeetingPoint* deepest = nullptr;
    for (const MeetingPoint& point : std::span(manifold.points).first(static_cast<size_t>(manifold.count))) {
      if (point.depth <= depth || (candidate.is_beside && !is_beside(point))) continue;
      depth = point.depth;
      deepest = &point;
    }
    const auto closing = [&] {
      const Vector3 approach =
          a.BodyBefore(time_a).VelocityAt(deepest->position) - b.BodyBefore(time_b).VelocityAt(deepest->position);
      return approach.dot(deepest->normal);
    };
    const bool is_near = depth >= 0 && depth <= tolerance;
    // When they were hit last they touched as well, and part.
    if (is_near && (since == step_size_ || closing() > 0)) break;
    const bool is_known = candidate.is_swept || (candidate.were_apart && depth > kFlatGap);
    const bool is_after = depth > tolerance && (is_known || closing() > 0);
    (is_after ? touching : apart) = time;
    // In the middle of what is aimed at, so that rounding does not decide on which side it ends.
    const double lacking = depth - tolerance / 2;
    const bool is_between = last && lacking * last->lacking < 0;
    double rate = is_between ? (last->lacking - lacking) / (time - last->time) : candidate.closing;
    // What was seen to come to an edge comes down beside that more slowly.
    const bool is_swept_apart = candidate.is_swept && !is_between && deepest != nullptr && lacking < 0;
    if (const double now = is_swept_apart ? closing() : 0; now > 0) rate = std::min(rate, now);
    last = deepest != nullptr ? std::optional<Look>({time, lacking}) : std::nullopt;
    // Along the chord of a bent way they seemed to meet long before they do.
    if (deepest == nullptr) gap *= 2;
    double next = time + lacking / rate;
    if (!(next > touching && next >= 0 && next < apart)) next = (std::max(touching, 0.0) + apart) / 2;
    if (next == time) break;
    time = next;
  }
  candidate.time = HasRolled(candidate, time) ? std::max(since - kLeastProgress * step_size_, 0.0) : time;
}

// Remembers who met and hardly closed by then, or not at all: what turns against a face or comes along it would do so
// again and again, each time a trifle later, and others wait for it.
void Impacts::NoteGrazes() {
  if (!rewinds_) return;
  const Candidate* last = nullptr;
  for (size_t i = 0; i < blows_.size(); ++i) {
    const Candidate* const candidate = blow_pairs_[i];
    if (candidate->time == 0) continue;
    const double closing = -approaches_[i].dot(blows_[i].normal);
    const bool grazes = closing * kLeastProgress * step_size_ <= kGrazeDepth;
    const uint64_t key = KeyOf(candidate->pair.geometry_a, candidate->pair.geometry_b);
    const auto known = grazes_.find(key);
    if (!grazes) {
      if (known != grazes_.end()) grazes_.erase(known);
    } else if (known == grazes_.end()) {
      if (candidate != last) grazes_[key] = {candidate->time, 1};
    } else if (candidate != last) {
      Graze& graze = known->second;
      graze.time = std::min(graze.time, candidate->time);
      ++graze.count;
    }
    last = candidate;
  }
}

// Those that grazed each other just before do so again a while later.
void Impacts::PutOff(Candidate& candidate) const {
  if (grazes_.empty() || candidate.time == 0) return;
  const auto known = grazes_.find(KeyOf(candidate.pair.geometry_a, candidate.pair.geometry_b));
  if (known == grazes_.end()) return;
  const auto& [time, count] = known->second;
  const double part = std::min(std::ldexp(kFirstPutOff, count - 1), kLeastProgress);
  candidate.time = std::min(candidate.time, std::max(time - part * step_size_, 0.0));
}

// Whether it is one of many hits of a body that stays in touch while it rolls, each of them hardly later than the last
// one.
bool Impacts::HasRolled(const Candidate& candidate, double time) const {
  const double since = past_.FreeSince(candidate.pair);
  if (solves_ < kManySolves || since == step_size_ || time < since - kLeastProgress * step_size_) return false;
  const auto spin = [&](EntityRow row) { return world_.state.angular_velocities.col(Index(row)); };
  if ((spin(candidate.pair.entity_a) - spin(candidate.pair.entity_b)).norm() * step_size_ < kRollingTurn) return false;
  Manifold manifold;
  past_.FindMeeting(candidate.pair, since, since, DepthOfImpact(candidate.closing * step_size_), manifold);
  return manifold.count > 0;
}

}  // namespace genphys

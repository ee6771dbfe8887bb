#include "impacts.h"

#include "locked_axes.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace genphys {
namespace {

// m/s on top of what acceleration alone brings up in a substep.
constexpr double kImpactSpeedMin = 1e-3;
// Of what that is in a substep: a hop from there to and fro takes twice as long as this part of it, and all hops after
// it together are left out.
constexpr double kShortestHop = 0.25;
// m: as deep as this two bodies are in touch, for rounding leaves gaps between what was put together.
constexpr double kDepthMin = -1e-9;
// Deeper than so many times what the closing speed covers is an impact of this substep only if they are seen apart in
// it.
constexpr double kFreshDepth = 1.5;
// Of the substep: impacts of one body that are nearer to each other happen at once.
constexpr double kSameTime = 0.05;
// More impacts at once than this are timed by their depth alone: each look at a pair costs as much as a contact.
constexpr size_t kRefinedMax = 8;
constexpr int kLooksMax = 14;
// How deep (m, and of the way of a substep) an impact in time may be.
constexpr double kTimedDepth = 2e-7;
constexpr double kTimedPart = 1e-5;
// How far from touching (m, and of the way of a substep) the other corners of what lands flat may be.
constexpr double kFlatGap = 2e-5;
constexpr double kFlatPart = 0.03;
// m/s: what slips faster slides.
constexpr double kSlidingSpeed = 1e-2;

// m: at which two are taken to collide that cover `way` (m) in a substep.
double DepthOfImpact(double way) { return kTimedDepth + kTimedPart * way; }

}  // namespace

double FrictionAt(const MixedMaterial& material, double speed) {
  return speed > kSlidingSpeed ? material.kinetic_friction : material.friction;
}

bool ImpactSpeed::IsInFlight(EntityRow row) const {
  return !world_.active[Index(row)] || world_.layer.half_steps[Index(row)].in_flight;
}

double ImpactSpeed::Of(EntityRow a, EntityRow b, const Vector3& normal) const {
  const double pull_a = world_.accelerations[a].dot(normal), pull_b = world_.accelerations[b].dot(normal);
  if (IsInFlight(a) && IsInFlight(b)) return kImpactSpeedMin + kShortestHop * std::abs(pull_b - pull_a) * step_size_;
  return kImpactSpeedMin + 2 * std::max(std::abs(pull_a), std::abs(pull_b)) * step_size_;
}

bool ImpactSpeed::IsMovable(EntityRow row, GeometryRow geometry) const {
  return world_.active[Index(row)] && world_.rule.info(geometry).is_dynamic;
}

bool ImpactSpeed::IsFree(const ContactPair& pair) const {
  const auto flew = [&](EntityRow row, GeometryRow geometry) { return IsMovable(row, geometry) && world_.flew[row]; };
  return IsStillFree(pair) || flew(pair.entity_a, pair.geometry_a) || flew(pair.entity_b, pair.geometry_b);
}

bool ImpactSpeed::IsStillFree(const ContactPair& pair) const {
  const auto flies = [&](EntityRow row, GeometryRow geometry) {
    return IsMovable(row, geometry) && world_.layer.half_steps[Index(row)].in_flight;
  };
  return flies(pair.entity_a, pair.geometry_a) || flies(pair.entity_b, pair.geometry_b);
}

Impacts::Impacts(const ImpactWorld& world, double step_size, bool rewinds)
    : world_(world), step_size_(step_size), rewinds_(rewinds), speed_(world_, step_size) {}

bool Impacts::Solve(const ContactBuffer& contacts, const RowMarks* changed, std::span<const SweptPair> swept) {
  moved_.clear();
  Find(contacts, changed, swept);
  if (candidates_.empty()) return false;
  KeepEarliest();
  for (Candidate& candidate : candidates_) {
    if (candidate.time > 0 && (candidates_.size() <= kRefinedMax || candidate.is_swept)) Refine(candidate);
  }
  CollectStruck();
  blows_.clear();
  blow_pairs_.clear();
  for (const Candidate& candidate : candidates_) AddBlows(contacts, candidate);
  if (!blows_.empty()) {
    Separate();
    Record();
    Apply(RestOfStep());
  }
  world_.struck_index.Clear();
  world_.earliest.Clear();
  if (blows_.empty()) return false;
  // What only seems to close, for joints are about to change that, would do so again.
  const bool has_hit = std::ranges::any_of(blows_, [](const Blow& blow) { return blow.impulse > 0; });
  return has_hit || !waiting_.empty() || ties_.empty();
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
  std::erase_if(candidates_, [&](const Candidate& candidate) { return is_changed(candidate.pair); });
  parting_.clear();
  for (const ContactPair& pair : contacts.pairs) {
    if (!is_changed(pair)) continue;
    if (const std::optional<Candidate> candidate = Judge(contacts, pair)) {
      candidates_.push_back(*candidate);
    } else if (MayBeMissed(contacts, pair)) {
      parting_.push_back(pair);
    }
  }
  for (const SweptPair& pair : swept) {
    const auto known = CandidateOf(pair.geometry_a, pair.geometry_b);
    const ContactPair as_contact{.entity_a = pair.entity_a,
                                 .entity_b = pair.entity_b,
                                 .geometry_a = pair.geometry_a,
                                 .geometry_b = pair.geometry_b,
                                 .material = world_.rule.Mixed(pair.geometry_a, pair.geometry_b)};
    const Candidate candidate{.pair = as_contact,
                              .time = pair.time,
                              .closing = pair.closing,
                              .is_swept = true,
                              .is_held = !speed_.IsStillFree(as_contact) && IsNewAmongHeld(as_contact)};
    if (known == candidates_.end()) {
      candidates_.push_back(candidate);
    } else if (known->time < pair.time) {
      *known = candidate;
    }
  }
  if (candidates_.size() + parting_.size() <= kRefinedMax) FindMissed(contacts);
}

std::vector<Impacts::Candidate>::iterator Impacts::CandidateOf(GeometryRow a, GeometryRow b) {
  return std::ranges::find_if(candidates_, [&](const Candidate& candidate) {
    return candidate.pair.geometry_a == a && candidate.pair.geometry_b == b;
  });
}

bool Impacts::MayBeMissed(const ContactBuffer& contacts, const ContactPair& pair) const {
  if (!rewinds_ || pair.is_sensor || !speed_.IsFree(pair)) return false;
  const auto points = std::span(contacts.points).subspan(pair.first_point, pair.point_count);
  return std::ranges::any_of(points, [&](const ContactPoint& point) { return point.depth > kFlatGap; });
}

// What turns fast may have met something, and part again by the end of the substep.
void Impacts::FindMissed(const ContactBuffer& contacts) {
  for (const ContactPair& pair : parting_) {
    if (CandidateOf(pair.geometry_a, pair.geometry_b) != candidates_.end()) continue;
    const double since = FreeSince(pair);
    double depth = 0, speed = 0;
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      depth = std::max(depth, contacts.points[i].depth);
      speed = std::max(speed, contacts.points[i].relative_velocity.norm());
    }
    if (since == 0 || !WereApart(pair, since, speed)) continue;
    candidates_.push_back({.pair = pair, .time = since / 2, .closing = depth / since, .were_apart = true});
  }
}

// What slides or rolls into something: the engine would stop it a substep too late, and in its own way.
bool Impacts::IsNewAmongHeld(const ContactPair& pair) const {
  const auto goes = [&](EntityRow row) { return world_.active[Index(row)] && !world_.jointed[row]; };
  if (!rewinds_ || !(goes(pair.entity_a) || goes(pair.entity_b))) return false;
  EntityPair entities{world_.state.ids[Index(pair.entity_a)], world_.state.ids[Index(pair.entity_b)]};
  if (entities.b < entities.a) std::swap(entities.a, entities.b);
  const std::vector<TouchingPair>& touching = world_.layer.touching;
  const auto known = std::lower_bound(touching.begin(), touching.end(), entities,
                                      [](const TouchingPair& each, const EntityPair& p) { return each.pair < p; });
  return known == touching.end() || known->pair != entities;
}

// How long before the end both were last hit, or the substep began: before that they did not go as they do now.
double Impacts::FreeSince(const ContactPair& pair) const {
  const RowValues<double>& free_since = world_.free_since;
  return std::min({step_size_, free_since[pair.entity_a], free_since[pair.entity_b]});
}

bool Impacts::WereApart(const ContactPair& pair, double time, double speed) const {
  Manifold manifold;
  FindMeeting(pair, time, time, 0, manifold);
  const double most = 2 * DepthOfImpact(speed * step_size_);
  const auto points = std::span(manifold.points).first(static_cast<size_t>(manifold.count));
  return std::ranges::all_of(points, [&](const MeetingPoint& point) { return point.depth <= most; });
}

bool Impacts::GoesBack(EntityRow row, const Candidate& candidate) const {
  // It would leave behind whom joints hold together with it.
  if (world_.active[Index(row)] && world_.jointed[row]) return false;
  return candidate.is_held || speed_.IsInFlight(row);
}

// The impact of this pair, if its points say that there was one.
std::optional<Impacts::Candidate> Impacts::Judge(const ContactBuffer& contacts, const ContactPair& pair) const {
  if (pair.is_sensor) return std::nullopt;
  // What rests closes with nothing, and that is most of a pile.
  const auto points = std::span(contacts.points).subspan(pair.first_point, pair.point_count);
  const auto closes = [](const ContactPoint& point) {
    return point.depth >= kDepthMin && -point.relative_velocity.dot(point.normal) > kImpactSpeedMin;
  };
  if (std::none_of(points.begin(), points.end(), closes)) return std::nullopt;
  const bool is_free = speed_.IsFree(pair);
  const bool is_held = !is_free && IsNewAmongHeld(pair);
  if (!is_free && !is_held && pair.material.restitution == 0) return std::nullopt;
  const double since = FreeSince(pair);
  const bool goes_back = rewinds_ && (is_free || is_held);
  std::optional<Candidate> found;
  std::optional<bool> were_apart;  // as far as somebody looked
  for (const ContactPoint& point : points) {
    if (point.depth < kDepthMin) continue;
    const double closing = -point.relative_velocity.dot(point.normal);
    if (!(closing > speed_.Of(pair.entity_a, pair.entity_b, point.normal))) continue;
    bool is_fresh = goes_back && point.depth > 0;
    if (is_fresh && point.depth > kFreshDepth * closing * since) {
      if (!were_apart) were_apart = WereApart(pair, since, point.relative_velocity.norm());
      is_fresh = *were_apart;
    }
    double time = 0;
    if (is_fresh) {
      const Vector3 pull = PullOn(pair.entity_b) - PullOn(pair.entity_a);
      const double square = closing * closing + 2 * pull.dot(point.normal) * point.depth;
      time = square > 0 ? 2 * point.depth / (closing + std::sqrt(square)) : point.depth / closing;
      time = std::min(time, since);
    }
    if (!found || time > found->time)
      found = Candidate{.pair = pair, .time = time, .closing = closing, .is_held = is_held};
  }
  if (found) found->were_apart = were_apart.value_or(false);
  return found;
}

// A body's later impacts wait until the earlier ones have changed its way.
void Impacts::KeepEarliest() {
  const auto is_moved = [&](EntityRow row) { return world_.active[Index(row)]; };
  for (const Candidate& c : candidates_) {
    for (EntityRow row : {c.pair.entity_a, c.pair.entity_b}) {
      if (is_moved(row)) world_.earliest[row] = std::max(world_.earliest[row], c.time);
    }
  }
  std::erase_if(candidates_, [&](const Candidate& c) {
    const double first = std::max(world_.earliest[c.pair.entity_a], world_.earliest[c.pair.entity_b]);
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
}

const Geometry& Impacts::GeometryAt(GeometryRow row) const {
  const EntityRow entity = world_.rule.info(row).entity;
  const GeometryRows& rows = world_.geometry_rows[Index(entity)];
  const auto place = static_cast<size_t>(std::find(rows.begin(), rows.end(), row) - rows.begin());
  return world_.scene.entities[Index(entity)]->desc->rigid_body->geometries[place];
}

Placement Impacts::Placed(GeometryRow row, const ImpactMotion& motion, double time) const {
  return ToPlacement(motion.PoseBefore(time).Transform(GeometryAt(row).pose_in_entity));
}

void Impacts::HoldLocked(EntityRow row, StruckBody& body) const {
  const SceneEntity& entity = *world_.scene.entities[Index(row)];
  if (!entity.traits.is_locked) return;
  const LockedAxes& locks = entity.desc->rigid_body->locked_axes;
  for (int i = 0; i < 3; ++i) body.freedom[i] = locks.linear[static_cast<size_t>(i)] ? 0 : 1;
  body.inverse_tensor = LockedInverse(locks, body.tensor);
  DropLocked(locks, body.linear_velocity, body.angular_velocity);
}

// What holds a body takes away what pulls at it.
Vector3 Impacts::PullOn(EntityRow row) const {
  return speed_.IsInFlight(row) ? world_.accelerations[row] : Vector3(Vector3::Zero());
}

ImpactMotion Impacts::MotionOf(EntityRow entity) const {
  const uint32_t row = Index(entity);
  const SceneEntity& scene_entity = *world_.scene.entities[row];
  const Pose pose = world_.state.pose(entity);
  const Vector3 linear = world_.state.linear_velocities.col(row), angular = world_.state.angular_velocities.col(row);
  const bool is_dynamic = scene_entity.desc->rigid_body->motion_type == MotionType::kDynamic;
  if (!is_dynamic || !world_.active[row]) return ImpactMotion::Driven(pose, linear, angular);
  return ImpactMotion::Free(pose, scene_entity.mass, linear, angular, PullOn(entity));
}

void Impacts::FindMeeting(const ContactPair& pair, double time_a, double time_b, double gap, Manifold& manifold) const {
  const ImpactMotion a = MotionOf(pair.entity_a), b = MotionOf(pair.entity_b);
  FindContacts(GeometryAt(pair.geometry_a).shape, Placed(pair.geometry_a, a, time_a), GeometryAt(pair.geometry_b).shape,
               Placed(pair.geometry_b, b, time_b), gap, manifold);
}

double Impacts::ClosingAt(const Candidate& candidate, double time_a, double time_b, const MeetingPoint& point) const {
  const StruckBody a = MotionOf(candidate.pair.entity_a).BodyBefore(time_a);
  const StruckBody b = MotionOf(candidate.pair.entity_b).BodyBefore(time_b);
  return (a.VelocityAt(point.position) - b.VelocityAt(point.position)).dot(point.normal);
}

// Finds the time at which the two just touch, by Newton's method between the bounds that it has seen. Two that overlap
// all the time collide when they begin to close.
void Impacts::Refine(Candidate& candidate) const {
  const double way = candidate.closing * step_size_;
  const double tolerance = DepthOfImpact(way);
  const double gap = candidate.is_swept ? kFlatPart * way + kFlatGap : way + kFlatGap;
  const bool goes_a = GoesBack(candidate.pair.entity_a, candidate),
             goes_b = GoesBack(candidate.pair.entity_b, candidate);
  const double since = FreeSince(candidate.pair);
  double touching = candidate.is_swept ? 0 : -1, apart = since, time = candidate.time;
  Manifold manifold;
  for (int look = 0; look < kLooksMax; ++look) {
    const double time_a = goes_a ? time : 0, time_b = goes_b ? time : 0;
    FindMeeting(candidate.pair, time_a, time_b, gap, manifold);
    double depth = -gap;
    const MeetingPoint* deepest = nullptr;
    for (const MeetingPoint& point : std::span(manifold.points).first(static_cast<size_t>(manifold.count))) {
      if (point.depth <= depth) continue;
      depth = point.depth;
      deepest = &point;
    }
    const auto closes = [&] { return ClosingAt(candidate, time_a, time_b, *deepest) > 0; };
    const bool is_near = depth >= 0 && depth <= tolerance;
    // When they were hit last they touched as well, and part.
    if (is_near && (since == step_size_ || closes())) break;
    const bool is_known = candidate.is_swept || (candidate.were_apart && depth > kFlatGap);
    const bool is_after = depth > tolerance && (is_known || closes());
    (is_after ? touching : apart) = time;
    // In the middle of what is aimed at, so that rounding does not decide on which side it ends.
    double next = time + (depth - tolerance / 2) / candidate.closing;
    if (!(next > touching && next >= 0 && next < apart)) next = (std::max(touching, 0.0) + apart) / 2;
    if (next == time) break;
    time = next;
  }
  candidate.time = time;
}

uint32_t Impacts::NumberOf(EntityRow row) {
  int& index = world_.struck_index[row];
  if (index < 0) {
    index = static_cast<int>(struck_.size());
    struck_.push_back({.row = row, .motion = MotionOf(row)});
  }
  return static_cast<uint32_t>(index);
}

void Impacts::AddStruck(EntityRow row, const Candidate& candidate) {
  Struck& struck = struck_[NumberOf(row)];
  // What nothing can move is where it is at the time of whom it meets, which is the same for all of one moment.
  if (GoesBack(row, candidate)) struck.time = std::max(struck.time, candidate.time);
}

void Impacts::CollectStruck() {
  struck_.clear();
  bodies_.clear();
  for (const Candidate& candidate : candidates_) {
    AddStruck(candidate.pair.entity_a, candidate);
    AddStruck(candidate.pair.entity_b, candidate);
  }
  TieStruck();
  for (const Struck& struck : struck_) {
    StruckBody& body = bodies_.emplace_back(struck.motion.BodyBefore(struck.time));
    if (struck.motion.is_movable()) HoldLocked(struck.row, body);
    body.linear_velocity += struck.lacking_linear;
    body.angular_velocity += struck.lacking_angular;
  }
}

void Impacts::AddBlow(const Candidate& candidate, const Vector3& position, const Vector3& normal) {
  blows_.push_back({.body_a = static_cast<uint32_t>(world_.struck_index[candidate.pair.entity_a]),
                    .body_b = static_cast<uint32_t>(world_.struck_index[candidate.pair.entity_b]),
                    .position = position,
                    .normal = normal});
  blow_pairs_.push_back(&candidate);
}

void Impacts::AddBlows(const ContactBuffer& contacts, const Candidate& candidate) {
  const ContactPair& pair = candidate.pair;
  const double time_a = struck_[static_cast<size_t>(world_.struck_index[pair.entity_a])].time;
  const double time_b = struck_[static_cast<size_t>(world_.struck_index[pair.entity_b])].time;
  if (candidate.time > 0) {
    Manifold manifold;
    const double gap = std::max(kFlatGap, kFlatPart * candidate.closing * step_size_);
    FindMeeting(pair, time_a, time_b, gap, manifold);
    for (int i = 0; i < manifold.count; ++i) {
      const MeetingPoint& point = manifold.points[static_cast<size_t>(i)];
      AddBlow(candidate, point.position, point.normal);
    }
    if (manifold.count > 0) return;
  }
  for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
    const ContactPoint& point = contacts.points[i];
    if (point.depth >= kDepthMin) AddBlow(candidate, point.position, point.normal);
  }
}

void Impacts::Separate() {
  approaches_.clear();
  for (size_t i = 0; i < blows_.size(); ++i) {
    Blow& blow = blows_[i];
    const MixedMaterial& material = blow_pairs_[i]->pair.material;
    const Vector3 approach = RelativeVelocity(blow, bodies_);
    const double closing = -approach.dot(blow.normal);
    const ContactPair& pair = blow_pairs_[i]->pair;
    const bool bounces = closing > speed_.Of(pair.entity_a, pair.entity_b, blow.normal);
    blow.separation_speed = bounces ? material.restitution * closing : 0;
    blow.friction = FrictionAt(material, (approach + closing * blow.normal).norm());
    approaches_.push_back(approach);
  }
  Restitute(blows_, bodies_, ties_);
  BearBlows();
}

// How the bodies move at the end of the substep: as they fall, unless what they came to rest on holds them.
std::vector<StruckBody> Impacts::RestOfStep() {
  std::vector<StruckBody> ends;
  for (size_t i = 0; i < struck_.size(); ++i) ends.push_back(struck_[i].motion.Coast(bodies_[i], struck_[i].time));
  std::vector<Blow> supports;
  for (size_t i = 0; i < blows_.size(); ++i) {
    const ContactPair& pair = blow_pairs_[i]->pair;
    const double leaving = RelativeVelocity(blows_[i], bodies_).dot(blows_[i].normal);
    if (leaving > speed_.Of(pair.entity_a, pair.entity_b, blows_[i].normal)) continue;
    Blow support = blows_[i];
    support.impulse = support.separation_speed = 0;
    support.rubbing.setZero();
    supports.push_back(support);
  }
  SolveBlows(supports, ends, ties_);
  return ends;
}

void Impacts::Record() {
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
  for (size_t i = 0; i < struck_.size(); ++i) {
    const Struck& struck = struck_[i];
    if (!struck.motion.is_movable()) continue;
    const uint32_t row = Index(struck.row);
    HalfStep& half = world_.layer.half_steps[row];
    if (struck.time > 0) {
      world_.free_since[struck.row] = struck.time;
      moved_.push_back({struck.row, struck.time, struck.motion.PoseBefore(struck.time)});
      const ImpactMotion after = struck.motion.After(struck.time, bodies_[i], ends[i]);
      world_.state.set_pose(struck.row, after.pose());
      world_.state.linear_velocities.col(row) = after.linear_velocity();
      world_.state.angular_velocities.col(row) = after.angular_velocity();
      half.Restart();
      continue;
    }
    const Vector3 linear = ends[i].linear_velocity - struck.lacking_linear;
    const Vector3 angular = ends[i].angular_velocity - struck.lacking_angular;
    const Vector3 gained = linear - world_.state.linear_velocities.col(row);
    const Vector3 turned = angular - world_.state.angular_velocities.col(row);
    world_.state.linear_velocities.col(row) = linear;
    world_.state.angular_velocities.col(row) = angular;
    half.is_struck = true;
    half.velocity += gained;
    half.momentum += ends[i].tensor * turned;
  }
  std::sort(moved_.begin(), moved_.end(), [](const Moved& a, const Moved& b) { return a.row < b.row; });
}

}  // namespace genphys

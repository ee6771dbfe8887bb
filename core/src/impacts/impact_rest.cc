// How those that were hit go on to the end of the substep: as they fall, or held by what they came to rest on.
#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "genphys/bounds.h"
#include "impacts/impacts.h"

namespace genphys {
namespace {

// rad: what turns farther until then is left to further impacts.
constexpr double kTurnMost = 0.64;
// m/s: what hardly turns is held as well where it was hit, if that tells its velocity to so much.
constexpr double kStraight = 1e-4;
// m: as far apart as this two are still in touch.
constexpr double kTouchGap = 1e-6;
// Where something round touches goes so far as it turns, of its reach: where it is flat it is the farther.
constexpr double kRoundWay = 4;

}  // namespace

// How the bodies move at the end of the substep: as they fall, unless what they came to rest on holds them.
std::vector<StruckBody> Impacts::RestOfStep() {
  std::vector<StruckBody> ends;
  ends.reserve(struck_.size() + blows_.size());
  for (size_t i = 0; i < struck_.size(); ++i) {
    Struck& struck = struck_[i];
    ends.push_back(struck.motion.Coast(bodies_[i], struck.time));
    // What it stands on holds it as far as it does so now.
    if (!past_.StandsOnGround(struck.row)) continue;
    struck.by_others = struck.time * (past_.PushOf(struck.row) - world_.accelerations[struck.row]);
    ends.back().linear_velocity =
        bodies_[i].linear_velocity + struck.time * world_.accelerations[struck.row] + struck.by_others;
  }
  PushOn(ends);
  std::vector<Blow> supports;
  std::vector<const Candidate*> pairs;  // of supports
  supports.reserve(blows_.size());
  std::vector<uint32_t> staying;  // of whom the bodies after all those in `ends` are
  for (size_t i = 0; i < blows_.size(); ++i) {
    const ContactPair& pair = blow_pairs_[i]->pair;
    const double leaving = RelativeVelocity(blows_[i], bodies_).dot(blows_[i].normal);
    if (leaving > speed_.Of(pair.entity_a, pair.entity_b, blows_[i].normal)) continue;
    // Nothing pulls at those to which it was passed on.
    if (blow_pairs_[i]->borne != Borne::kUnknown && blow_pairs_[i]->time == 0) continue;
    Blow support = blows_[i];
    support.impulse = support.separation_speed = 0;
    support.rubbing.setZero();
    uint32_t& bearer = support.borne == Borne::kA ? support.body_b : support.body_a;
    // Who stays where it is has borne what pulls at the other one until the end.
    if (support.borne != Borne::kUnknown && struck_[bearer].time == 0) {
      ends.push_back(ends[bearer].Still());
      staying.push_back(std::exchange(bearer, static_cast<uint32_t>(ends.size() - 1)));
    }
    supports.push_back(support);
    pairs.push_back(blow_pairs_[i]);
  }
  const std::vector<StruckBody> coasting = ends;
  SolveBlows(supports, ends, ties_);
  for (const Blow& support : supports) {
    if (const uint32_t last = std::max(support.body_a, support.body_b); last >= struck_.size()) {
      PushAside(support, staying[last - struck_.size()], ends);
      continue;
    }
    Struck &a = struck_[support.body_a], &b = struck_[support.body_b];
    if (!a.motion.is_movable() || !b.motion.is_movable()) continue;
    const Vector3 impulse = support.impulse * support.normal + support.rubbing;
    a.by_others -= bodies_[support.body_a].inverse_mass * impulse;
    b.by_others += bodies_[support.body_b].inverse_mass * impulse;
  }
  RollOn(supports, pairs, coasting, ends);
  return ends;
}

// Who stays where it is bears what pulls, with all below: the rest of what lies on it moves it, across that, and no
// faster than to go along with it.
void Impacts::PushAside(const Blow& support, uint32_t bearer, std::vector<StruckBody>& ends) const {
  const bool is_a = support.borne == Borne::kA;
  const uint32_t borne = is_a ? support.body_a : support.body_b;
  const EntityRow row = struck_[bearer].row;
  if (!past_.IsMovable(row) || IsTied(row) || IsTied(struck_[borne].row)) return;
  const Vector3& pull = world_.accelerations[row];
  const Vector3 down = pull.normalized(), impulse = support.impulse * support.normal + support.rubbing;
  const auto along = [&](const Vector3& all) { return Vector3(all - all.dot(down) * down); };
  const Vector3 slip = bodies_[borne].VelocityAt(support.position) - bodies_[bearer].VelocityAt(support.position);
  StruckBody& body = ends[bearer];
  Vector3 push = (is_a ? 1 : -1) * along(impulse);
  const double gained = body.inverse_mass * push.norm(), most = along(slip).norm() + step_size_ * pull.norm();
  if (gained > most) push *= most / gained;
  body.linear_velocity += body.inverse_mass * body.freedom.cwiseProduct(push);
  body.angular_velocity += body.inverse_tensor * (support.position - body.center).cross(push).dot(down) * down;
}

// What turns as it is held touches elsewhere at the end than where it was hit: there it is not to close. Of two that
// both move, what they give each other would have to act where they are in between, or they would not keep their
// angular momentum: they are held where they met.
void Impacts::RollOn(std::span<const Blow> supports, std::span<const Candidate* const> pairs,
                     std::span<const StruckBody> coasting, std::vector<StruckBody>& ends) const {
  // Who is held, by which support, and whether that is one of what nothing moves.
  std::vector<std::tuple<uint32_t, uint32_t, bool>> held;
  held.reserve(supports.size());
  for (uint32_t i = 0; i < supports.size(); ++i) {
    const auto [a, b] = std::pair(supports[i].body_a, supports[i].body_b);
    const bool is_known = std::max(a, b) < struck_.size();
    const auto moves = [&](uint32_t body) { return body < struck_.size() && struck_[body].motion.is_movable(); };
    const bool is_by_ground = is_known && moves(a) != moves(b);
    if (moves(a)) held.emplace_back(a, i, is_by_ground);
    if (moves(b)) held.emplace_back(b, i, is_by_ground);
  }
  std::ranges::sort(held);
  std::vector<Held> touches;
  for (size_t i = 0, next = 0; i < held.size(); i = next) {
    const uint32_t body = std::get<0>(held[i]);
    bool is_alone = true;
    touches.clear();
    for (; next < held.size() && std::get<0>(held[next]) == body; ++next) {
      const uint32_t support = std::get<1>(held[next]);
      is_alone &= std::get<2>(held[next]);
      touches.push_back({&supports[support], pairs[support]});
    }
    if (!is_alone || !MayRollOn(body, touches, coasting[body])) continue;
    const std::optional<StruckBody> end = RolledOn(body, touches, coasting[body]);
    if (end) ends[body] = *end;
  }
}

// Whether it goes on nearly straight, for as long as it is held, or else it would be through what is thin before
// anybody looked; but not so straight that it is all the same where it is held.
bool Impacts::MayRollOn(uint32_t body, std::span<const Held> touches, const StruckBody& coasting) const {
  const Struck& struck = struck_[body];
  const StruckBody& before = bodies_[body];
  const double spin = before.angular_velocity.norm(), turn = struck.time * spin;
  if (!(struck.time > 0) || IsLinked(struck.row) || turn > kTurnMost) return false;
  const auto bends = [&](const Held& touch) { return spin * turn * ReachOf(touch.candidate->pair) > kStraight; };
  return std::ranges::any_of(touches, bends) && std::ranges::all_of(touches, [&](const Held& touch) {
           const ContactPair& pair = touch.candidate->pair;
           const auto half = [&](GeometryRow row) { return SmallestHalfExtent(past_.GeometryAt(row).shape); };
           return BendOf(body, pair, coasting) <= std::min(half(pair.geometry_a), half(pair.geometry_b));
         });
}

// m: so far no point of it goes off a straight way until the end, at which it moves as `then`.
double Impacts::BendOf(uint32_t body, const ContactPair& pair, const StruckBody& then) const {
  const StruckBody& before = bodies_[body];
  const double time = struck_[body].time, turn = time * before.angular_velocity.norm();
  return (ReachOf(pair) * turn * turn + time * (then.linear_velocity - before.linear_velocity).norm()) / 2;
}

// How one moves at the end that moved as `coasting` if nothing held it. Nothing if it cannot be told: it comes down
// somewhere else meanwhile, and so is hit again.
std::optional<StruckBody> Impacts::RolledOn(uint32_t body, std::span<const Held> touches,
                                            const StruckBody& coasting) const {
  const Struck& struck = struck_[body];
  const StruckBody& before = bodies_[body];
  const ImpactMotion then = struck.motion.After(struck.time, before, coasting);
  // Itself, and what it touches.
  std::vector<StruckBody> bodies{then.BodyBefore(0)};
  std::vector<Blow> blows;
  HoldLocked(struck.row, bodies.front());
  if (!FindTouches(body, touches, then, bodies, blows)) return std::nullopt;
  Ties none;
  SolveBlows(blows, bodies, none);
  StruckBody end = coasting;
  end.linear_velocity = bodies.front().linear_velocity;
  end.angular_velocity = before.inverse_tensor * (bodies.front().tensor * bodies.front().angular_velocity);
  return end;
}

// Adds what it touches at the end, and a blow for each point there. False: it touches where it did not come by rolling.
bool Impacts::FindTouches(uint32_t body, std::span<const Held> touches, const ImpactMotion& then,
                          std::vector<StruckBody>& bodies, std::vector<Blow>& blows) const {
  Manifold manifold;
  for (size_t first = 0, next = 0; first < touches.size(); first = next) {
    const Candidate& candidate = *touches[first].candidate;
    while (next < touches.size() && touches[next].candidate == &candidate) ++next;
    const Blow& support = *touches[first].support;
    const bool is_a = support.body_a == body;
    const ImpactMotion& ground = struck_[is_a ? support.body_b : support.body_a].motion;
    const double bend = BendOf(body, candidate.pair, bodies.front());
    past_.FindMeeting(candidate.pair, is_a ? then : ground, 0, is_a ? ground : then, 0, kTouchGap + bend, manifold);
    const auto side = static_cast<uint32_t>(bodies.size());
    bodies.push_back(ground.BodyBefore(0));
    for (const MeetingPoint& point : std::span(manifold.points).first(static_cast<size_t>(manifold.count))) {
      if (!IsReached(body, touches.subspan(first, next - first), bend, bodies.back(), point.position)) {
        if (point.depth > kTouchGap) return false;
        continue;
      }
      Blow& blow = blows.emplace_back(Blow{.body_a = is_a ? 0 : side, .body_b = is_a ? side : 0});
      blow.position = point.position;
      blow.normal = point.normal;
      blow.run = RunAcross(candidate.pair, point.normal);
      blow.friction = support.friction;
    }
  }
  return true;
}

// Whether a place at which it touches the ground at the end is one that it rolled to, or slid, from where it was hit,
// if it went off a straight way by no more than `bend` (m).
bool Impacts::IsReached(uint32_t body, std::span<const Held> touches, double bend, const StruckBody& ground,
                        const Vector3& place) const {
  const StruckBody& before = bodies_[body];
  const double time = struck_[body].time, turn = time * before.angular_velocity.norm();
  const ContactPair& pair = touches.front().candidate->pair;
  const bool rolls = world_.rule.info(pair.geometry_a).rolls || world_.rule.info(pair.geometry_b).rolls;
  const double way = kTouchGap + 2 * bend + (rolls ? kRoundWay * turn * ReachOf(pair) : 0);
  return std::ranges::any_of(touches, [&](const Held& touch) {
    const Vector3& met = touch.support->position;
    const auto is_near = [&](const Vector3& at) { return (place - at).squaredNorm() <= way * way; };
    return is_near(met) || is_near(met + time * before.VelocityAt(met)) || is_near(met + time * ground.VelocityAt(met));
  });
}

}  // namespace genphys

// Where joints are at the end of a substep. A solve of their rows says what rates are to be, and ways bend while bodies
// turn: what is foretold of that makes a gap of a part of its square, and a pendulum that is pushed back along it again
// and again gains what it can never lose. Where steps resolve how an island turns it is followed instead: solved until
// its joints hold at the end of the substep, to which each body turns as a free one with the momentum that impulses at
// the start give it. That is SHAKE (Ryckaert, Ciccotti and Berendsen, J. Comput. Phys. 23, 1977) of rigid bodies, whose
// energy stays near to what it was, for it is symplectic (Leimkuhler and Reich, Simulating Hamiltonian Dynamics, 2004,
// chapters 7 and 8).
#include <algorithm>
#include <cmath>

#include "joints/joint_step.h"
#include "motion/free_rotation.h"

namespace genphys {
namespace {

// What a row makes up for is much if it is more than so many times what turning bends a way by in a substep, and than
// this (m/s or rad/s).
constexpr double kMuch = 2;
constexpr double kLeastMuch = 1e-3;
// rad in a substep: what turns by less goes where it was foretold to. With 0.06 the chains of T.joints of
// bench/accuracy take 7 % longer with one substep.
constexpr double kFollowedTurn = 0.1;
// The same of who is slender. A turn across its long axis tilts its momentum about the other one, and so spins it
// about the long axis, by the ratio of its moments more than what joints had found, and that tilts it again. Where the
// square of the turn times the ratio is more than this the tilt grows: a pole with moments like 830 to 1 began to
// whirl at 2.5 rad/s with 100 substeps per second.
constexpr double kTiltedPart = 0.5;
// rad in a substep, by which what joints give in it turns a body on: who is whipped round faster is not followed. Its
// spin before and that after lead to places that have little to do with each other, so that it gains energy now and
// then. Of 9,000 pendulums of unequal links the worst is jerked open 190 times as wide as turning makes a way without
// this, and 1.03 times with it; with 0.1 one of half of them 280 times.
constexpr double kResolvedWhip = 0.06;
// An aim is good if rows missed no more than this part of the bend of their ways, and then the next one is if they
// missed no more than that part: each is better than the last by the square of the turn, or more.
constexpr double kAimed = 3e-3;
constexpr double kNearlyAimed = 0.1;
constexpr int kAimsMax = 6;
// m/s or rad/s: less is no bend.
constexpr double kLeastBend = 1e-6;

// Whether it turns so far in a substep of `h` seconds that how it does must be followed.
bool MustFollow(const JointBody& body, double h) {
  const double square = body.angular_given.squaredNorm() * h * h;
  if (square > kFollowedTurn * kFollowedTurn) return true;
  const double ratio = std::sqrt(body.own_inverse.squaredNorm() * body.own_tensor.squaredNorm());
  return square * ratio > kTiltedPart;
}

}  // namespace

bool JointStep::BendsAlike(const JointRow& a, const JointRow& b) {
  return a.kind == b.kind && a.a == b.a && a.b == b.b && a.point == b.point;
}

double JointStep::BendAt(std::span<const JointRow> rows, size_t index, double h) const {
  const JointRow& row = rows[index];
  double bend = 0;
  for (const EntityRow side : {row.a, row.b}) {
    if (side == kWorldRow) continue;
    const JointBody& body = BodyAt(side);
    const double arm = row.kind == JointRow::Kind::kLinear ? (row.point - body.center).norm() : 1;
    bend += body.angular_given.squaredNorm() * arm * h / 2;
  }
  return bend + BendOfLine(row, index, h);
}

// The line between two points turns with whatever goes across it, however slowly bodies turn: v^2 / d.
double JointStep::BendOfLine(const JointRow& row, size_t index, double h) const {
  // Behind the rows of joints are others, of no joint.
  if (index >= owners_.size()) return 0;
  const Held& held = held_[owners_[index]];
  const JointDesc& desc = scene_.joints[held.slot]->desc;
  if (!std::holds_alternative<DistanceJoint>(desc.kind)) return 0;
  const JointBody& a = bodies_[held.a];
  const Vector3 from = JointSide::Now(a, *desc.frame_in_a).frame.position;
  const Vector3 across = row.axis.cross(bodies_[held.b].GivenAt(row.point) - a.GivenAt(from));
  const double speed = across.norm(), distance = (row.point - from).norm();
  // Who comes round faster is not followed, and nothing is explained by it.
  return speed * h <= kResolvedTurn * distance ? speed * speed / distance * h / 2 : 0;
}

// An error that is larger than the bend that lies ahead is of no turn that was followed.
bool JointStep::MakesUpForMuch(std::span<const JointRow> rows, std::span<const uint32_t> mine, double h) const {
  double bend = 0;
  for (size_t i = 0; i < mine.size(); ++i) {
    const JointRow& row = rows[mine[i]];
    if (i == 0 || !BendsAlike(rows[mine[i - 1]], row)) bend = BendAt(rows, mine[i], h);
    if (std::abs(row.target - QuietTarget(row)) > kMuch * bend + kLeastMuch) return true;
  }
  return false;
}

// Whether momenta tell how the bodies of the last solve turn: nobody is harder to turn than it is, is whipped round, or
// turns by its axes that are locked, whose rows are behind those of joints.
bool JointStep::IsResolved(std::span<const uint32_t> mine, double h) const {
  if (mine.back() >= owners_.size()) return false;
  return std::ranges::all_of(solver_.moved(), [&](uint32_t moved) {
    const JointBody& body = bodies_[moved];
    const double most = std::max(body.angular_given.norm(), body.angular_velocity.norm());
    const double gained = (body.angular_velocity - body.angular_given).norm();
    return body.factor == 1 && most * h <= kResolvedTurn && gained * h <= kResolvedWhip;
  });
}

Vector3 JointStep::FlowOf(const JointBody& body, double h) const {
  const MassProperties& mass = scene_.entities[Index(body.row)]->mass;
  if (mass.spherical) return body.angular_velocity;
  const Vector3 gained = body.own_tensor * (body.angular_velocity - body.angular_given);
  const Vector3 momentum = body.momentum_given + gained;
  return MeanFreeSpin(body.pose.orientation, body.own_inverse * momentum, momentum, mass.inverse_tensor, h);
}

// Aims the rows of an island at where the velocities of its last solve lead. Returns by which part of the bend of its
// way the row that missed most had missed that.
double JointStep::Aim(std::span<const uint32_t> mine, double h, std::vector<JointRow>& rows) {
  for (const uint32_t moved : solver_.moved()) {
    JointBody& body = bodies_[moved];
    body.linear_expected = body.linear_velocity;
    body.angular_expected = body.angular_velocity;
    body.flow = FlowOf(body, h);
    body.Foretell(h, body.flow);
  }
  double most = 0, bend = 0;
  // Behind the rows of joints are others, which foretell nothing.
  for (size_t i = 0; i < mine.size() && mine[i] < owners_.size();) {
    const uint32_t owner = owners_[mine[i]];
    Held& held = held_[owner];
    aimed_.clear();
    WriteRowsOf(held, h, 1, aimed_);
    for (size_t k = 0; i < mine.size() && mine[i] < owners_.size() && owners_[mine[i]] == owner; ++i, ++k) {
      JointRow& row = rows[mine[i]];
      if (k >= aimed_.size() || row.is_driven) continue;
      if (k == 0 || !BendsAlike(aimed_[k - 1], row)) bend = BendAt(rows, mine[i], h);
      most = std::max(most, std::abs(aimed_[k].target - row.target) / (bend + kLeastBend));
      row.target = aimed_[k].target;
    }
  }
  return most;
}

// After Aim(), from where the last solve began.
bool JointStep::SolveAgain(uint32_t island) {
  for (const uint32_t moved : solver_.moved()) bodies_[moved].Return();
  return solver_.SolveAgain(island, bodies()) && !solver_.is_swept();
}

// After a solve of an island that IsResolved().
bool JointStep::Follow(uint32_t island, double h, std::vector<JointRow>& rows) {
  const std::span<const uint32_t> mine = islands_.JointRowsOf(island);
  const auto turns = [&](uint32_t moved) { return MustFollow(bodies_[moved], h); };
  const bool is_slow = std::ranges::none_of(solver_.moved(), turns);
  bool is_aimed = is_slow;
  for (int aims = 0; !is_aimed && aims < kAimsMax; ++aims) {
    const double missed = Aim(mine, h, rows);
    is_aimed = missed <= kNearlyAimed;
    if (missed > kAimed && !SolveAgain(island)) return false;
  }
  // Making up for what no turn explains gives energy, which is watched.
  if (!is_aimed || MakesUpForMuch(rows, mine, h)) return true;
  for (const uint32_t moved : solver_.moved()) {
    JointBody& body = bodies_[moved];
    body.flow = is_slow ? body.angular_velocity : FlowOf(body, h);
    body.is_followed = true;
  }
  return true;
}

}  // namespace genphys

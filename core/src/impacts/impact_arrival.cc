// How what joints hold together goes on after a blow, to the end of the substep: under all that acts on it, and then as
// its joints let it. What they would have bent of its way meanwhile is of second order, and the next solve makes up for
// it.
#include <algorithm>
#include <cmath>
#include <utility>

#include "genphys/limits.h"
#include "impacts/impacts.h"
#include "joints/joint_step.h"
#include "joints/row_rate.h"
#include "motion/free_rotation.h"
#include "pairs/contact_points.h"

namespace genphys {
namespace {

// Of the kinetic energy of a group: so much more it may have than after the blow, beyond what did work on it.
constexpr double kGainMost = 0.02;

double EnergyOf(const StruckBody& body) {
  const Vector3& spin = body.angular_velocity;
  return (body.linear_velocity.squaredNorm() / body.inverse_mass + spin.dot(body.tensor * spin)) / 2;
}

}  // namespace

void Impacts::PushOn(std::vector<StruckBody>& ends) {
  bool is_any = false;
  for (Group& group : groups_) {
    if (!group.goes_back()) continue;
    group.wrenches.resize(group.sides.size());
    is_any = true;
  }
  if (!is_any) return;
  for (const Group& group : groups_) {
    if (group.goes_back()) AddLoose(group);
  }
  AddContacts();
  for (const Group& group : groups_) {
    if (group.goes_back()) PushOn(group, ends);
  }
}

// Adds to how its members move what pushes them from the blow on, as joints let it: all from outside, motors, springs
// and limits of joints, and what they stand on, as in the solve of this substep unless that was a blow. What held them
// before may fling them away now: they go straight on then.
void Impacts::PushOn(const Group& group, std::vector<StruckBody>& ends) {
  std::vector<Ties::Push> pushes;
  double energy = 0, work = 0;
  for (size_t i = 0; i < group.members.size(); ++i) {
    const EntityRow row = group.linked.rows[i];
    const StruckBody& body = ends[group.members[i]];
    const Vector3 gained = group.time * world_.accelerations[row];
    const Vector3 twist =
        world_.layer.half_steps[Index(row)].steady_twist * (2 / step_size_) + group.wrenches[i + 1].torque;
    pushes.push_back(
        {group.members[i], gained / body.inverse_mass + group.time * group.wrenches[i + 1].force, group.time * twist});
    energy += EnergyOf(body);
    work += (std::abs(gained.dot(body.linear_velocity)) + gained.squaredNorm() / 2) / body.inverse_mass;
  }
  std::vector<Ties::Change> changes;
  ties_.Pass(pushes, changes);
  const auto pushed = [&](const Ties::Change& change) {
    StruckBody body = ends[change.body];
    body.linear_velocity += change.linear;
    body.angular_velocity += change.angular;
    return body;
  };
  double then = 0;
  for (const Ties::Change& change : changes) then += EnergyOf(pushed(change));
  if (!(then <= (1 + kGainMost) * energy + work)) return;
  for (const Ties::Change& change : changes) ends[change.body] = pushed(change);
}

bool Impacts::IsJolted(EntityRow row) const { return row != kWorldRow && world_.jolted[row]; }

// Adds an impulse that acted on the entity in the course of the substep, if it is among those that go back together.
void Impacts::AddImpulse(EntityRow row, const Vector3& linear, const Vector3& angular) {
  const int number = std::as_const(world_.group_of)[row];
  if (number < 0) return;
  Group& group = groups_[static_cast<size_t>(number)];
  if (!group.goes_back()) return;
  const auto side = std::ranges::find(group.sides, row);
  Wrench& wrench = group.wrenches[static_cast<size_t>(side - group.sides.begin())];
  wrench.force += linear / step_size_;
  wrench.torque += angular / step_size_;
}

// The solve was of the rates before the blow: what damps them brakes those that there are since.
void Impacts::Dampen(JointRow& row) const {
  if (row.damping == 0) return;
  const JointBody world;
  const auto body_of = [&](EntityRow side) -> const JointBody& {
    return side == kWorldRow ? world : *world_.joints.Find(side);
  };
  const auto since_blow = [&](EntityRow side) -> Velocities {
    if (side == kWorldRow) return {};
    const int number = std::as_const(world_.struck_index)[side];
    const uint32_t column = Index(side);
    if (number < 0) return {world_.state.linear_velocities.col(column), world_.state.angular_velocities.col(column)};
    const StruckBody& body = bodies_[static_cast<size_t>(number)];
    return {body.linear_velocity, body.angular_velocity};
  };
  const double rate = RateOf(row, body_of(row.a), since_blow(row.a), body_of(row.b), since_blow(row.b));
  row.impulse = std::clamp(row.impulse - step_size_ * row.damping * (rate - row.rate), row.lower, row.upper);
}

void Impacts::AddLoose(const Group& group) {
  const auto add = [&](uint32_t slot) {
    const JointDesc& desc = world_.scene.joints[slot]->desc;
    if (IsJolted(RowOf(desc.entity_a)) || IsJolted(RowOf(desc.entity_b))) return;
    for (JointRow& row : world_.joints.LooseRows(slot)) {
      Dampen(row);
      for (const auto& [side, sign] : {std::pair(row.a, -1.0), std::pair(row.b, 1.0)}) {
        // What pushes others may be one of theirs as well.
        if (side == kWorldRow || GroupOf(side) != &group) continue;
        const Velocities push = ImpulseOf(row, sign, world_.joints.Find(side)->center);
        AddImpulse(side, push.linear, push.spin);
      }
    }
  };
  std::ranges::for_each(group.linked.slots, add);
  std::ranges::for_each(group.linked.loose, add);
}

bool Impacts::IsSupport(const ContactPair& pair) const {
  return std::ranges::any_of(supports_, [&](const Candidate& support) {
    return support.pair.geometry_a == pair.geometry_a && support.pair.geometry_b == pair.geometry_b;
  });
}

void Impacts::AddContacts() {
  for (const ContactPair& pair : world_.solved.pairs) {
    const bool is_member = GroupOf(pair.entity_a) != nullptr || GroupOf(pair.entity_b) != nullptr;
    if (!is_member || pair.is_sensor || IsJolted(pair.entity_a) || IsJolted(pair.entity_b)) continue;
    // What is hit now does not hold it.
    if (CandidateOf(pair.geometry_a, pair.geometry_b) != nullptr || IsSupport(pair)) continue;
    for (const ContactPoint& point : PointsOf(world_.solved, pair)) {
      const Vector3 impulse = point.normal_impulse * point.normal + point.friction_impulse;
      for (const auto& [side, sign] : {std::pair(pair.entity_a, -1.0), std::pair(pair.entity_b, 1.0)}) {
        const JointBody* const body = world_.joints.Find(side);
        if (body == nullptr) continue;
        const Vector3 push = sign * impulse;
        AddImpulse(side, push, (point.position - body->center).cross(push));
      }
    }
  }
}

// Where those are at the end that go back.
std::vector<Impacts::Arrival> Impacts::Arrive(std::span<const StruckBody> ends) const {
  std::vector<Arrival> arrivals(struck_.size());
  for (size_t i = 0; i < struck_.size(); ++i) {
    const Struck& struck = struck_[i];
    if (!struck.motion.is_movable() || !(struck.time > 0)) continue;
    const ImpactMotion after = struck.motion.After(struck.time, bodies_[i], ends[i]);
    arrivals[i] = {after.pose(), after.linear_velocity(), after.angular_velocity()};
    // Where it turned meanwhile matters no more to whom a world does not let turn so fast.
    const Vector3& spin = ends[i].angular_velocity;
    if (spin.cwiseAbs().maxCoeff() > Limits::kSpinMax) arrivals[i].angular_velocity = spin;
    arrivals[i].acceleration = (after.linear_velocity() - bodies_[i].linear_velocity) / struck.time;
    if (!past_.StandsOnGround(struck.row)) continue;
    arrivals[i].by_others = struck.by_others / struck.time;
    arrivals[i].torque = TorqueOf(arrivals[i], struck.row, bodies_[i], struck.time);
  }
  for (const Group& group : groups_) {
    if (group.goes_back()) ArriveTogether(group, arrivals);
  }
  return arrivals;
}

// N*m, that turned it since it was like `then`, `time` ago.
Vector3 Impacts::TorqueOf(const Arrival& arrival, EntityRow row, const StruckBody& then, double time) const {
  const Matrix3& own = world_.scene.entities[Index(row)]->mass.tensor;
  const Matrix3 tensor = WorldTensor(arrival.pose.orientation, own);
  return (tensor * arrival.angular_velocity - then.tensor * then.angular_velocity) / time;
}

void Impacts::ArriveTogether(const Group& group, std::vector<Arrival>& arrivals) const {
  Conform(group, arrivals);
  for (const uint32_t member : group.members) {
    Arrival& arrival = arrivals[member];
    const StruckBody& then = bodies_[member];
    arrival.acceleration = (arrival.linear_velocity - then.linear_velocity) / group.time;
    arrival.torque = TorqueOf(arrival, struck_[member].row, then, group.time);
  }
}

// Takes from how they arrive what their joints do not let them.
void Impacts::Conform(const Group& group, std::vector<Arrival>& arrivals) const {
  std::vector<JointBody> bodies = BodiesOf(group, 0);
  for (size_t i = 0; i < group.members.size(); ++i) {
    const Arrival& arrival = arrivals[group.members[i]];
    const MassProperties& mass = world_.scene.entities[Index(group.linked.rows[i])]->mass;
    const ImpactMotion motion =
        ImpactMotion::Free(arrival.pose, mass, arrival.linear_velocity, arrival.angular_velocity, Vector3::Zero());
    bodies[i + 1] = ToJointBody(i + 1, arrival.pose, motion.BodyBefore(0));
  }
  std::vector<uint32_t> slots;
  std::vector<JointRow> rows = RowsOf(group, bodies, slots);
  Ties ties;
  if (!ties.Add(group.members, std::move(bodies), std::move(rows), std::move(slots))) return;
  ties.VisitLacking([&](const Ties::Change& change) {
    arrivals[change.body].linear_velocity += change.linear;
    arrivals[change.body].angular_velocity += change.angular;
  });
}

}  // namespace genphys

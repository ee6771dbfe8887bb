// What joints hold together while something hits it.
#include <algorithm>
#include <utility>

#include "impacts/impacts.h"
#include "joints/joint_step.h"

namespace genphys {
namespace {

// Of a group, bodies times impacts: each point of an impact takes three solves of the joints of all of them. Beyond it
// they are hit one by one where they are, and what the joints make of that comes with their next solve.
constexpr size_t kTiedMost = 1024;

}  // namespace

bool Impacts::IsLinked(EntityRow row) const { return world_.jointed[row] && past_.IsMovable(row); }

const Impacts::Group* Impacts::GroupOf(EntityRow row) const {
  const int group = std::as_const(world_.group_of)[row];
  return group < 0 ? nullptr : &groups_[static_cast<size_t>(group)];
}

bool Impacts::IsTied(EntityRow row) const {
  const Group* const group = GroupOf(row);
  return group != nullptr && group->is_tied;
}

// Finds whom joints hold together with the candidates.
void Impacts::FindGroups() {
  groups_.clear();
  world_.linked.Clear();
  std::vector<size_t> impacts;
  for (const Candidate& candidate : candidates_) {
    for (const EntityRow row : {candidate.pair.entity_a, candidate.pair.entity_b}) {
      if (!IsLinked(row)) continue;
      if (!world_.linked[row]) {
        AddGroup(row);
        impacts.push_back(0);
      }
      ++impacts[static_cast<size_t>(std::as_const(world_.group_of)[row])];
    }
  }
  for (size_t i = 0; i < groups_.size(); ++i) {
    groups_[i].is_tied = impacts[i] * groups_[i].linked.rows.size() <= kTiedMost;
  }
  if (rewinds_) LeaveHeldToSolves();
}

// Of whom joints hold together with that one; returns its number.
size_t Impacts::AddGroup(EntityRow row) {
  groups_.push_back({.linked = world_.joints.TiedTo(row, world_.linked)});
  for (const EntityRow member : groups_.back().linked.rows) {
    world_.group_of[member] = static_cast<int>(groups_.size()) - 1;
  }
  return groups_.size() - 1;
}

// What cannot go back and meets something new is stopped by its next solve, as all that joints hold, and so is what
// meets its own like: chains that fall in on themselves do so all the time.
void Impacts::LeaveHeldToSolves() {
  const auto stays = [&](const Group* group) { return group != nullptr && !group->is_tied; };
  std::erase_if(candidates_, [&](Candidate& candidate) {
    const ContactPair& pair = candidate.pair;
    if (!candidate.is_held) return false;
    const Group *const a = GroupOf(pair.entity_a), *const b = GroupOf(pair.entity_b);
    if (a != nullptr && a == b && pair.material.restitution == 0) return true;
    if (candidate.is_swept || !(stays(a) || stays(b))) return false;
    candidate.time = 0;
    return pair.material.restitution == 0;
  });
  places_.Forget();
}

// Adds whom joints hold together with those that are struck.
void Impacts::TieStruck() {
  ties_ = {};
  const auto is_struck = [&](EntityRow row) { return std::as_const(world_.struck_index)[row] >= 0; };
  for (Group& group : groups_) {
    if (group.is_tied && std::ranges::any_of(group.linked.rows, is_struck)) TieAll(group);
  }
}

void Impacts::TieAll(Group& group) {
  for (const EntityRow row : group.linked.rows) {
    group.members.push_back(NumberOf(row));
    group.time = std::max(group.time, struck_[group.members.back()].time);
  }
  group.is_tied = Tie(group);
  if (!group.is_tied) group.time = 0;
  for (const uint32_t member : group.members) struck_[member].time = group.time;
}

JointBody Impacts::ToJointBody(size_t place, const Pose& pose, const StruckBody& struck) {
  JointBody body;
  body.row = EntityRow{static_cast<uint32_t>(place)};
  body.pose = pose;
  body.axes = pose.orientation.toRotationMatrix();
  body.center = struck.center;
  body.linear_velocity = struck.linear_velocity;
  body.angular_velocity = struck.angular_velocity;
  body.inverse_mass = struck.inverse_mass;
  body.own_tensor = struck.tensor;
  body.own_inverse = body.inverse_tensor = struck.inverse_tensor;
  return body;
}

// Where and how they were `time` seconds before the end.
std::vector<JointBody> Impacts::BodiesOf(const Group& group, double time) const {
  std::vector<JointBody> bodies(group.sides.size());
  for (size_t i = 1; i < bodies.size(); ++i) {
    const ImpactMotion motion = past_.MotionOf(group.sides[i]);
    bodies[i] = ToJointBody(i, motion.PoseBefore(time), motion.BodyBefore(time));
  }
  return bodies;
}

bool Impacts::Tie(Group& group) {
  group.sides = {kWorldRow};
  group.sides.insert(group.sides.end(), group.linked.rows.begin(), group.linked.rows.end());
  const auto place_of = [&](EntityRow row) {
    const auto known = std::ranges::find(group.sides, row);
    const auto place = static_cast<size_t>(known - group.sides.begin());
    if (known == group.sides.end()) group.sides.push_back(row);
    return place;
  };
  for (const uint32_t slot : group.linked.slots) {
    const JointDesc& desc = world_.scene.joints[slot]->desc;
    const size_t a = place_of(RowOf(desc.entity_a)), b = place_of(RowOf(desc.entity_b));
    group.joined.emplace_back(a, b);
  }
  std::vector<JointBody> bodies = BodiesOf(group, group.time);
  std::vector<uint32_t> slots;
  std::vector<JointRow> rows = RowsOf(group, bodies, slots);
  return ties_.Add(group.members, std::move(bodies), std::move(rows), std::move(slots));
}

// Of all that joints and locked axes hold between `bodies`; `slots` are the joints of the first of them.
std::vector<JointRow> Impacts::RowsOf(const Group& group, std::span<const JointBody> bodies,
                                      std::vector<uint32_t>& slots) const {
  std::vector<JointRow> rows;
  for (size_t i = 0; i < group.linked.slots.size(); ++i) {
    const auto& [a, b] = group.joined[i];
    world_.joints.WriteLocked(group.linked.slots[i], bodies[a], bodies[b], rows);
    slots.resize(rows.size(), group.linked.slots[i]);
  }
  world_.joints.WriteLocks(group.linked, bodies, rows);
  return rows;
}

// Tells the joints what the blows left them to bear.
void Impacts::BearBlows() {
  std::vector<Ties::Push> pushes;
  for (const Blow& blow : blows_) {
    const Vector3 impulse = blow.impulse * blow.normal + blow.rubbing;
    for (const auto& [body, sign] : {std::pair(blow.body_a, -1.0), std::pair(blow.body_b, 1.0)}) {
      if (ties_.With(body).empty()) continue;
      const Vector3 push = sign * impulse;
      pushes.push_back({body, push, (blow.position - bodies_[body].center).cross(push)});
    }
  }
  if (pushes.empty()) return;
  ties_.VisitBorne(pushes, [&](uint32_t slot, const JointRow& row) { world_.joints.Bear(slot, row); });
}

}  // namespace genphys

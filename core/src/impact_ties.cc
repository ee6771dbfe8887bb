// What joints hold together while something hits it.
#include <algorithm>

#include "impacts.h"
#include "joint_step.h"
#include "locked_axes.h"

namespace genphys {
namespace {

// Of a group, bodies times impacts: each point of an impact takes three solves of the joints of all of them. Beyond it
// they are hit one by one, and what the joints make of that comes with their next solve.
constexpr size_t kTiedMost = 1024;

JointBody ToJointBody(uint32_t place, const Pose& pose, const StruckBody& struck) {
  JointBody body;
  body.row = EntityRow{place};
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

}  // namespace

// Adds whom joints hold together with those that are struck.
void Impacts::TieStruck() {
  ties_ = {};
  world_.linked.Clear();
  // Who is added is linked.
  for (size_t i = 0; i < struck_.size(); ++i) {
    const EntityRow row = struck_[i].row;
    if (!struck_[i].motion.is_movable() || !world_.jointed[row] || world_.linked[row]) continue;
    Tie(world_.joints.LinkedWith(row, world_.linked));
  }
  ties_.VisitLacking([&](const Ties::Change& change) {
    struck_[change.body].lacking_linear = change.linear;
    struck_[change.body].lacking_angular = change.angular;
  });
}

void Impacts::Tie(const JointStep::Linked& linked) {
  std::vector<EntityRow> sorted = linked.rows;
  std::ranges::sort(sorted);
  const auto is_among = [&](EntityRow row) { return std::ranges::binary_search(sorted, row); };
  const auto impacts = static_cast<size_t>(std::ranges::count_if(candidates_, [&](const Candidate& candidate) {
    return is_among(candidate.pair.entity_a) || is_among(candidate.pair.entity_b);
  }));
  if (impacts * linked.rows.size() > kTiedMost) return;
  std::vector<JointBody> bodies(1);
  for (const EntityRow row : linked.rows) {
    const ImpactMotion motion = MotionOf(row);
    bodies.push_back(ToJointBody(static_cast<uint32_t>(bodies.size()), motion.pose(), motion.BodyBefore(0)));
  }
  std::vector<EntityRow> still;  // behind them
  const auto place_of = [&](EntityRow row) -> size_t {
    if (row == kWorldRow) return 0;
    const auto member = std::ranges::find(linked.rows, row);
    if (member != linked.rows.end()) return 1 + static_cast<size_t>(member - linked.rows.begin());
    const auto known = std::ranges::find(still, row);
    if (known != still.end()) return 1 + linked.rows.size() + static_cast<size_t>(known - still.begin());
    still.push_back(row);
    const ImpactMotion motion = MotionOf(row);
    bodies.push_back(ToJointBody(static_cast<uint32_t>(bodies.size()), motion.pose(), motion.BodyBefore(0)));
    return bodies.size() - 1;
  };
  std::vector<JointRow> rows;
  std::vector<uint32_t> slots;
  for (const uint32_t slot : linked.slots) {
    const JointDesc& desc = world_.scene.joints[slot]->desc;
    const size_t a = place_of(RowOf(desc.entity_a)), b = place_of(RowOf(desc.entity_b));
    world_.joints.WriteLocked(slot, bodies[a], bodies[b], rows);
    slots.resize(rows.size(), slot);
  }
  if (rows.empty()) return;
  const size_t of_joints = rows.size();
  for (size_t i = 0; i < linked.rows.size(); ++i) {
    const SceneEntity& entity = *world_.scene.entities[Index(linked.rows[i])];
    const LockedAxes& locks = entity.desc->rigid_body->locked_axes;
    const JointBody& body = bodies[i + 1];
    if (locks.any()) WriteLocks(locks, entity.mass, body.row, body.center, body.pose.orientation, rows);
  }
  slots.resize(of_joints);
  std::vector<uint32_t> members;
  for (const EntityRow row : linked.rows) members.push_back(NumberOf(row));
  ties_.Add(members, std::move(bodies), std::move(rows), std::move(slots));
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

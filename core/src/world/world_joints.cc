// How commands change the joints of a world. All were validated before, so nothing here can fail.
#include <algorithm>
#include <cmath>
#include <utility>

#include "genphys/world.h"
#include "joints/check_joint.h"
#include "joints/former_joints.h"
#include "joints/joint_step.h"
#include "joints/kinds.h"
#include "model/cat.h"
#include "pairs/near_pairs.h"

namespace genphys {
namespace {

// Of the larger of two targets: a motor whose speed changes by less goes on much as before. Three rods that swing for
// 20 s at 60 steps per second under motors that hardly do anything gain twice as much if every change is one.
constexpr double kJump = 0.5;

EntityPair PairOf(const JointDesc& joint) { return {joint.entity_a.id, joint.entity_b.id}; }

bool IsJump(const Motor& before, const Motor& after) {
  if (after.target_position || before.target_position) return after != before;
  const double change = std::abs(after.target_velocity - before.target_velocity);
  return change > kJump * std::max(std::abs(before.target_velocity), std::abs(after.target_velocity));
}

// Before the next step joints may be told otherwise without end, and come and go: of that little is kept.
template <typename Former>
void Note(const Former& former, const Scene& scene, std::vector<Former>& all) {
  constexpr size_t kMost = 16;  // by joint, whose coordinates are six
  if (all.size() > kMost * scene.joints.size()) KeepFirst(all, scene);
  all.push_back(former);
}

}  // namespace

Status World::CheckId(JointId id, std::string_view field) const {
  if (id.is_null()) return Refuse(Reason::kMissingField, field, Cat(field, " is not set"));
  const uint32_t slot = id.index();
  if (slot < layer_.joint_ids.generations.size()) {
    const std::optional<SceneJoint>& tenant = scene_.joints[slot];
    if (tenant && tenant->id == id) return absl::OkStatus();
    if (id.generation() < layer_.joint_ids.generations[slot]) {
      return Refuse(Reason::kStaleId, field, Cat("joint ", id.packed(), " is gone"));
    }
  }
  return Refuse(Reason::kEntityNotFound, field, Cat("there never was a joint ", id.packed()));
}

Pose World::PoseOf(const EntityRef& entity) const {
  return entity.is_world() ? Pose{} : state_.pose(EntityRow{entity.id.index()});
}

// The frames that the description leaves to the present poses.
void World::PlaceFrames(JointDesc& joint) const {
  const bool is_apart =
      std::holds_alternative<DistanceJoint>(joint.kind) || std::holds_alternative<GearJoint>(joint.kind);
  const Pose a = PoseOf(joint.entity_a), b = PoseOf(joint.entity_b);
  const auto inside = [](const Pose& outer, const Pose& pose) {
    const Quaternion back = outer.orientation.conjugate();
    return Pose{back * (pose.position - outer.position), (back * pose.orientation).normalized()};
  };
  if (is_apart || (!joint.frame_in_a && !joint.frame_in_b)) {
    if (!joint.frame_in_b) joint.frame_in_b = Pose{};
    if (is_apart && !joint.frame_in_a) joint.frame_in_a = Pose{};
  }
  if (!joint.frame_in_a) joint.frame_in_a = inside(a, b.Transform(*joint.frame_in_b));
  if (!joint.frame_in_b) joint.frame_in_b = inside(b, a.Transform(*joint.frame_in_a));
  joint.frame_in_a->orientation.normalize();
  joint.frame_in_b->orientation.normalize();
  DistanceJoint* const distance = std::get_if<DistanceJoint>(&joint.kind);
  if (distance == nullptr || distance->axis != JointAxis{}) return;
  const double present = (b.Transform(joint.frame_in_b->position) - a.Transform(joint.frame_in_a->position)).norm();
  distance->axis.limits = {present, present};
}

JointId World::Join(JointDesc joint) {
  const JointId id = layer_.joint_ids.Allocate<JointTag>();
  const uint32_t slot = id.index();
  if (slot >= scene_.joints.size()) {
    scene_.joints.resize(slot + 1);
    layer_.joints.resize(slot + 1);
  }
  PlaceFrames(joint);
  layer_.joints[slot] = JointState{};
  scene_.joints[slot] = SceneJoint{id, std::move(joint)};
  ++joint_count_;
  const JointDesc& desc = scene_.joints[slot]->desc;
  joint_index_.Add(slot, desc);
  if (!desc.collide_connected) SetTouchable(desc, false);
  RestartJoined(desc);
  UnsettleJoined(desc);
  if (scene_.world.recorded_events.changes) {
    Record(JointCreated{id, PairOf(desc), std::make_shared<const JointDesc>(desc)});
  }
  return id;
}

void World::Rejoin(const UpdateJoint& command) {
  const auto& [id, update, fields] = command;
  JointDesc& desc = scene_.joints[id.index()]->desc;
  JointDesc joint = *Merged(desc, update, fields);
  if (joint.collide_connected != desc.collide_connected) SetTouchable(desc, joint.collide_connected);
  const bool is_elsewhere = fields.Has(JointField::kFrameInA) || fields.Has(JointField::kFrameInB);
  const bool is_same_kind = joint.kind.index() == desc.kind.index();
  const bool goes_on = is_same_kind && GoesOnElsewhere(desc, joint);
  if (!is_same_kind || (is_elsewhere && !goes_on)) {
    // Its impulses and its turns mean something else.
    layer_.joints[id.index()] = JointState{};
    RestartJoined(desc);
  } else {
    if (is_elsewhere) LeaveFrames(id, desc);
    if (joint.kind != desc.kind) DriveOtherwise(id, desc, joint.kind);
  }
  desc = std::move(joint);
  PlaceFrames(desc);
  UnsettleJoined(desc);
  if (scene_.world.recorded_events.changes) {
    Record(JointUpdated{id, PairOf(desc), std::make_shared<const JointDesc>(desc), fields});
  }
}

void World::Unjoin(JointId id) {
  std::optional<SceneJoint>& joint = scene_.joints[id.index()];
  RestartJoined(joint->desc);
  UnsettleJoined(joint->desc);
  if (!joint->desc.collide_connected) SetTouchable(joint->desc, true);
  joint_index_.Remove(id.index(), joint->desc);
  joint.reset();
  layer_.joints[id.index()] = JointState{};
  layer_.joint_ids.Free(id);
  --joint_count_;
}

void World::UnjoinAndTell(JointId id) {
  const EntityPair pair = PairOf(scene_.joints[id.index()]->desc);
  Unjoin(id);
  if (scene_.world.recorded_events.changes) Record(JointDeleted{id, pair});
}

void World::UnjoinAllOf(EntityId id) {
  const std::span<const uint32_t> slots = joint_index_.Of(EntityRow{id.index()});
  for (const uint32_t slot : std::vector<uint32_t>(slots.begin(), slots.end())) UnjoinAndTell(scene_.joints[slot]->id);
}

void World::Drive(const SetMotorColumns& command) {
  for (size_t i = 0; i < command.ids.size(); ++i) {
    JointDesc& desc = scene_.joints[command.ids[i].index()]->desc;
    const std::vector<JointAxis*> axes = AxesOf(desc.kind);
    const auto driven = std::ranges::find_if(axes, [](const JointAxis* axis) { return axis->motor.has_value(); });
    const JointAxis before = **driven;
    Motor& motor = *(*driven)->motor;
    motor.target_velocity = command.velocities[i];
    if (!command.positions.empty()) motor.target_position = command.positions[i];
    if (!GoesOn(before, **driven)) {
      if (IsJump(*before.motor, motor)) RestartDriven(desc);
    } else if (*before.motor != motor) {
      NoteDrive(command.ids[i], PlacesOf(desc.kind)[static_cast<size_t>(driven - axes.begin())], before);
    }
    WakeJoined(desc);
  }
}

// Where springs and drives to positions alone are told otherwise, what they gave goes on to the boundary.
void World::DriveOtherwise(JointId id, const JointDesc& joint, const JointKind& kind) {
  JointKind before = joint.kind, after = kind;
  const std::vector<JointAxis*> from = AxesOf(before), to = AxesOf(after);
  const std::vector<uint8_t> places = PlacesOf(before);
  const auto goes_on = [](const JointAxis* a, const JointAxis* b) { return GoesOn(*a, *b); };
  const bool are_same_axes = places == PlacesOf(after);
  if (from.empty() || !are_same_axes || !std::ranges::equal(from, to, goes_on)) return RestartDriven(joint);
  for (size_t i = 0; i < from.size(); ++i) {
    if (*from[i] != *to[i]) NoteDrive(id, places[i], *from[i]);
  }
}

void World::NoteDrive(JointId id, uint8_t place, const JointAxis& before) {
  const JointDesc& joint = scene_.joints[id.index()]->desc;
  Note({id, place, before.motor, before.spring}, scene_, layer_.former_drives);
  DrawJoined(joint);
}

// It pulls from elsewhere after the boundary, by springs and drives to positions alone.
void World::LeaveFrames(JointId id, const JointDesc& joint) {
  JointState& state = layer_.joints[id.index()];
  state = {.force = state.force, .torque = state.torque, .haste = state.haste};
  Note({id, *joint.frame_in_a, *joint.frame_in_b}, scene_, layer_.former_frames);
  DrawJoined(joint);
}

// Whether the two entities of a joint may touch each other.
void World::SetTouchable(const JointDesc& joint, bool touchable) {
  if (joint.entity_a.is_world() || joint.entity_b.is_world()) return;
  const EntityRow a = RowOf(joint.entity_a);
  touchable ? rule_.Regard(joint.entity_a.id, joint.entity_b.id)
            : rule_.Disregard(joint.entity_a.id, joint.entity_b.id);
  contacts_stale_ = true;
  if (near_ != nullptr) near_->Renew(geometry_rows_[Index(a)]);
}

void World::WakeJoined(const JointDesc& joint) {
  for (const EntityRef* entity : {&joint.entity_a, &joint.entity_b}) {
    if (!entity->is_world()) WakeIslandOf(EntityRow{entity->id.index()});
  }
}

// They are held otherwise.
void World::UnsettleJoined(const JointDesc& joint) {
  for (const EntityRef* entity : {&joint.entity_a, &joint.entity_b}) {
    if (!entity->is_world()) Unsettle(EntityRow{entity->id.index()});
  }
  WakeJoined(joint);
}

// Only who asks pays for coordinates: layer_ has the turns that count.
JointState World::joint_state(JointId id) const {
  const JointDesc& desc = scene_.joints[id.index()]->desc;
  JointState state = layer_.joints[id.index()];
  const JointBody a = BodyNow(scene_, state_, RowOf(desc.entity_a)), b = BodyNow(scene_, state_, RowOf(desc.entity_b));
  const JointSide side_a = JointSide::Now(a, *desc.frame_in_a), side_b = JointSide::Now(b, *desc.frame_in_b);
  RowWriter writer(side_a, side_b, 0, {}, state, nullptr, {});
  std::visit([&](const auto& joint) { WriteRows(joint, writer); }, desc.kind);
  return state;
}

// What the joint gave until now is paid: from here on it gives more or nothing.
void World::RestartJoined(const JointDesc& joint) {
  for (const EntityRef* entity : {&joint.entity_a, &joint.entity_b}) {
    if (entity->is_world()) continue;
    HalfStep& half = layer_.half_steps[entity->id.index()];
    half.Restart();
    half.is_drawn = true;
  }
}

// The same of one that gives something else from here on, perhaps in every step.
void World::RestartDriven(const JointDesc& joint) {
  for (const EntityRef* entity : {&joint.entity_a, &joint.entity_b}) {
    if (entity->is_world()) continue;
    layer_.half_steps[entity->id.index()].RestartNowAndThen();
  }
  DrawJoined(joint);
}

// It may give another thing than in the last solve.
void World::DrawJoined(const JointDesc& joint) {
  for (const EntityRef* entity : {&joint.entity_a, &joint.entity_b}) {
    if (!entity->is_world()) layer_.half_steps[entity->id.index()].is_drawn = true;
  }
}

JointBroke World::Break(JointId id) {
  const SceneJoint& joint = *scene_.joints[id.index()];
  const JointState& state = layer_.joints[id.index()];
  const JointBroke event{id, PairOf(joint.desc), state.force.norm(), state.torque.norm()};
  Unjoin(id);
  return event;
}

}  // namespace genphys

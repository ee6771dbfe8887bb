#include "genphys/world.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>

#include "genphys/limits.h"
#include "joints/joint_step.h"
#include "model/cat.h"
#include "model/state_hash.h"
#include "model/validate.h"
#include "pairs/near_pairs.h"
#include "shapes/reach.h"
#include "step/sleeping.h"
#include "step/step_scratch.h"
#include "step/step_undo.h"
#include "world/initial_world.h"

namespace genphys {
namespace {

EntityDesc GroundPlane() {
  EntityDesc ground;
  ground.display_name = "ground";
  ground.rigid_body = RigidBody{.motion_type = MotionType::kStatic, .geometries = {Geometry{.shape = Plane{}}}};
  return ground;
}

Status CheckWorld(const WorldDesc& desc) {
  GENPHYS_RETURN_IF_ERROR(CheckVector(desc.gravity, Limits::kGravityMax, "gravity"));
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckStepper(desc.stepper), "stepper"));
  GENPHYS_RETURN_IF_ERROR(WithFieldPrefix(CheckMaterial(desc.default_material), "defaults.material"));
  GENPHYS_RETURN_IF_ERROR(
      WithFieldPrefix(CheckErrorCorrection(desc.default_error_correction), "defaults.error_correction"));
  return WithFieldPrefix(CheckAutoDisable(desc.default_auto_disable), "defaults.auto_disable");
}

// A refusal inside the commands that a new world starts with, told by the field of the world that led to it.
Status AboutWorld(const Status& status) {
  const std::optional<Refusal> refusal = RefusalOf(status);
  if (!refusal) return status;
  if (refusal->field.starts_with("commands[1]")) return Refuse(refusal->reason, "ground_plane", MessageOf(status));
  const bool about_solver = refusal->field.ends_with("stepper.solver");
  return Refuse(refusal->reason, about_solver ? "stepper.solver" : "engine", MessageOf(status));
}

}  // namespace

World::World(const BackendRegistry& registry, const WorldDesc& desc)
    : registry_(registry), joint_step_(std::make_unique<JointStep>(scene_, joint_index_, state_, active_, layer_)) {
  scene_.world = desc;
  scene_.world.engine = "none";
}

World::~World() = default;

Result<std::unique_ptr<World>> World::Create(const BackendRegistry& registry, const WorldDesc& desc) {
  GENPHYS_RETURN_IF_ERROR(CheckWorld(desc));
  std::unique_ptr<World> world(new World(registry, desc));
  std::vector<Command> start{SetEngine{desc.engine}};
  // An engine that knows no planes still makes a usable world, one without a floor.
  const Backend* backend = registry.Find(desc.engine);
  const bool can_have_ground = backend == nullptr || backend->capabilities().Has(Feature::kShapePlane);
  const bool ground_plane = desc.ground_plane.value_or(can_have_ground);
  world->scene_.world.ground_plane = ground_plane;
  if (ground_plane) start.push_back(CreateEntity{GroundPlane()});
  const Result<std::vector<CreatedId>> applied = world->Apply(start);
  if (!applied.ok()) return AboutWorld(applied.status());
  return world;
}

Status World::CheckId(EntityId id, std::string_view field) const {
  if (id.is_null()) return Refuse(Reason::kMissingField, field, Cat(field, " is not set"));
  const uint32_t slot = id.index();
  if (slot < layer_.ids.generations.size()) {
    const std::optional<SceneEntity>& tenant = scene_.entities[slot];
    if (tenant && tenant->id == id) return absl::OkStatus();
    if (id.generation() < layer_.ids.generations[slot]) {
      return Refuse(Reason::kStaleId, field, Cat("entity ", id.packed(), " is gone"));
    }
  }
  return Refuse(Reason::kEntityNotFound, field, Cat("there never was an entity ", id.packed()));
}

Result<EntityDesc> World::Describe(EntityId id) const {
  GENPHYS_RETURN_IF_ERROR(CheckId(id, "entity_id"));
  const uint32_t row = id.index();
  EntityDesc desc = *scene_.entities[row]->desc;
  desc.pose = state_.pose(EntityRow{row});
  if (desc.rigid_body) {
    desc.rigid_body->linear_velocity = state_.linear_velocities.col(row);
    desc.rigid_body->angular_velocity = state_.angular_velocities.col(row);
  }
  return desc;
}

std::vector<Event> World::TakeEvents() { return std::exchange(events_, {}); }

void World::Record(EventKind kind) { events_.push_back({layer_.next_event_sequence++, layer_.step, std::move(kind)}); }

uint64_t World::StateHash() const {
  std::string bytes;
  Serialize(scene_, bytes);
  Serialize(state_, bytes);
  Serialize(layer_, bytes);
  Serialize(solved_, bytes);
  if (engine_ != nullptr) engine_->SaveState(bytes);
  return HashBytes(bytes);
}

Status World::OverBudget(std::string_view why, bool is_engine_new) const {
  return Refuse(Reason::kBudgetExceeded, "",
                Cat("step ", layer_.step + 1, " was undone (", why, is_engine_new ? "; the engine began anew" : "",
                    "): move entities apart, remove some, or let filters ",
                    "or a collision space keep them from meeting, and step again"));
}

// Of a step that was cut short.
Status World::Undone(const Status& why, bool is_engine_new) const {
  const std::string message = Cat(MessageOf(why), " within step ", layer_.step + 1, ", which was undone",
                                  is_engine_new ? "; the engine began anew" : "");
  const std::optional<Refusal> refusal = RefusalOf(why);
  return refusal ? Refuse(refusal->reason, refusal->field, message) : Status(why.code(), message);
}

Status World::Diverged(std::string_view why) {
  faulted_ = true;
  // The engine is beyond use after a fault, and its columns were not taken over. Queries do without.
  engine_.reset();
  near_ = std::make_unique<NearPairs>();
  for (const EntityRow row : RowsOfBodies()) {
    const RigidBody& body = *scene_.entities[Index(row)]->desc->rigid_body;
    near_->Add(rule_, {body, geometry_rows_[Index(row)]}, state_.pose(row), false);
  }
  contacts_.Clear();
  solved_.Clear();
  return Refuse(Reason::kDiverged, "",
                Cat("step ", layer_.step + 1, " failed and was undone (", why, "); the world can be read and reset"));
}

void World::Reset() {
  ++changes_;
  events_.clear();
  stats_ = {};
  aftermath_ = {};
  // Before the first step there is nothing to go back to, but an engine that commands ended is made anew.
  if (initial_ == nullptr && !faulted_) return;
  if (initial_ != nullptr) {
    scene_ = initial_->scene;
    state_ = initial_->state;
    layer_ = initial_->layer;
  }
  // Who does the same again tells them again.
  layer_.forces.clear();
  initial_.reset();
  entity_count_ = static_cast<uint32_t>(
      std::count_if(scene_.entities.begin(), scene_.entities.end(), [](const auto& e) { return e.has_value(); }));
  solved_.Clear();
  active_.Clear();
  lately_active_.Clear();
  active_count_ = 0;
  rule_ = PairRule();
  joint_count_ = static_cast<uint32_t>(
      std::count_if(scene_.joints.begin(), scene_.joints.end(), [](const auto& joint) { return joint.has_value(); }));
  geometry_rows_.assign(scene_.entities.size(), {});
  for (uint32_t row = 0; row < scene_.entities.size(); ++row) {
    const std::optional<SceneEntity>& entity = scene_.entities[row];
    if (entity && entity->desc->rigid_body) {
      geometry_rows_[row] = rule_.Add(EntityRow{row}, entity->id, *entity->desc->rigid_body);
      IgnoreOthers(*entity, true);
    }
  }
  joint_index_.Clear();
  for (const std::optional<SceneJoint>& joint : scene_.joints) {
    if (!joint) continue;
    joint_index_.Add(joint->id.index(), joint->desc);
    const auto& [a, b] = std::pair(joint->desc.entity_a, joint->desc.entity_b);
    if (!joint->desc.collide_connected && !a.is_world() && !b.is_world()) rule_.Disregard(a.id, b.id);
  }
  faulted_ = false;
  try {
    RebuildEngine();
  } catch (const EngineFault& fault) {
    // What ended the last one ends this one, too: the world stays faulted.
    Diverged(fault.what()).IgnoreError();
  }
}

void World::RebuildEngine(bool recalls) {
  contacts_.Clear();
  contacts_stale_ = true;
  is_all_unsettled_ = true;
  engine_.reset();
  near_.reset();
  backend_ = registry_.Find(scene_.world.engine);
  if (backend_ == nullptr) return;
  engine_ = backend_->CreateWorld(backend_->Resolve(scene_.world.stepper));
  near_ = std::make_unique<NearPairs>();
  for (EntityRow row : RowsOfBodies()) AddToEngine(row);
  DropSolved();
  if (recalls) engine_->Recall(solved_);
}

// In order of ids.
std::vector<EntityRow> World::RowsOfBodies() const {
  std::vector<EntityRow> rows;
  for (uint32_t row = 0; row < scene_.entities.size(); ++row) {
    if (scene_.entities[row] && scene_.entities[row]->desc->rigid_body) rows.push_back(EntityRow{row});
  }
  std::sort(rows.begin(), rows.end(),
            [&](EntityRow a, EntityRow b) { return state_.ids[Index(a)] < state_.ids[Index(b)]; });
  return rows;
}

bool World::ShouldBeActive(EntityRow entity) const {
  const uint32_t row = Index(entity);
  const auto& desc = scene_.entities[row];
  if (!desc || !desc->desc->rigid_body || layer_.faulted[row]) return false;
  switch (desc->desc->rigid_body->motion_type) {
    case MotionType::kStatic:
      return false;
    case MotionType::kKinematic:
      return !state_.linear_velocities.col(row).isZero(0) || !state_.angular_velocities.col(row).isZero(0) ||
             IsOnItsWay(state_.ids[row]);
    case MotionType::kDynamic:
      return !state_.asleep[row];
  }
  return false;
}

void World::AddToEngine(EntityRow row) {
  const SceneEntity& entity = *scene_.entities[Index(row)];
  const RigidBody& body = *entity.desc->rigid_body;
  engine_->AddBody({row, entity.id, body, entity.mass, geometry_rows_[Index(row)]}, state_);
  near_->Add(rule_, {body, geometry_rows_[Index(row)]}, state_.pose(row), true);
  reaches_[Index(row)] = ReachFrom(entity.mass.center_of_mass, body);
  flown_[Index(row)] = false;
  SetActive(row, true);
  UpdateActive(row);
}

void World::UpdateActive(EntityRow row) {
  const bool should = ShouldBeActive(row);
  if (should == active_[Index(row)]) return;
  SetActive(row, should);
  contacts_stale_ = true;
  const auto& body = scene_.entities[Index(row)]->desc->rigid_body;
  if (engine_ == nullptr || !body) return;
  engine_->SetActive({&row, 1}, should);
  near_->SetActive({*body, geometry_rows_[Index(row)]}, should);
}

// Where the entity was put and how it moves now.
void World::TellPose(EntityRow row) {
  if (engine_ == nullptr) return;
  flown_[Index(row)] = false;
  engine_->WriteState({&row, 1}, state_);
  near_->Place({*scene_.entities[Index(row)]->desc->rigid_body, geometry_rows_[Index(row)]}, state_.pose(row));
}

void World::Wake(EntityRow row) {
  if (!state_.asleep[Index(row)] || layer_.faulted[Index(row)]) return;
  HalfStep& half = layer_.half_steps[Index(row)];
  // Most are held by something, or they would not have slept; whether that still does, the next solve tells.
  const bool floats = half.in_flight && layer_.last_touches[Index(row)].empty() && joint_index_.Of(row).empty();
  if (undo_ != nullptr) undo_->Keep(row);
  state_.asleep[Index(row)] = false;
  layer_.rest_times[Index(row)] = 0;
  // What it is owed is for half a substep of when it fell asleep, and would be taken for that of another one now.
  if (half.substep != layer_.last_substep) half.Restart();
  half.in_flight = floats;
  half.is_woken = !floats;
  Unsettle(row);
  UpdateActive(row);
  roused_.push_back(row);
  if (scene_.world.recorded_events.sleeping) woken_.push_back(state_.ids[Index(row)]);
}

void World::SetActive(EntityRow row, bool is_active) {
  if (active_[Index(row)] == is_active) return;
  if (is_active) {
    active_.Add(Index(row));
    lately_active_.Add(Index(row));
    ++active_count_;
  } else {
    active_.Remove(Index(row));
    --active_count_;
  }
  if (!is_active) return;
  stirred_.Add(Index(row));
  is_stirred_ = true;
}

// Takes up again who touches somebody that is active.
void World::StirLying() {
  if (!std::exchange(is_stirred_, false)) return;
  std::vector<TouchingPair> taken;
  stirred_.ForEach([&](uint32_t row) {
    if (!active_[row]) return;
    const size_t first = taken.size();
    layer_.lying.VisitOf(state_.ids[row], [&](const TouchingPair& touching) { taken.push_back(touching); });
    for (size_t i = first; i < taken.size(); ++i) layer_.lying.Erase(taken[i]);
  });
  stirred_.Clear();
  std::ranges::sort(taken);
  if (undo_ != nullptr) undo_->Stirred(taken);
  const auto old_size = static_cast<std::ptrdiff_t>(layer_.touching.size());
  layer_.touching.insert(layer_.touching.end(), taken.begin(), taken.end());
  std::inplace_merge(layer_.touching.begin(), layer_.touching.begin() + old_size, layer_.touching.end());
}

// Lays aside who touches but moves no more.
void World::LayLying() {
  std::erase_if(layer_.touching, [&](const TouchingPair& touching) {
    if (active_[touching.pair.a.index()] || active_[touching.pair.b.index()]) return false;
    layer_.lying.Insert(touching);
    return true;
  });
}

void World::WakeAll() {
  // Each of many static entities that a batch brings in asks for it, when those that slept are awake already.
  const uint8_t* const first = state_.asleep.data();
  const uint8_t* const end = first + state_.rows();
  for (const uint8_t* row = first; row < end; ++row) {
    row = static_cast<const uint8_t*>(std::memchr(row, 1, static_cast<size_t>(end - row)));
    if (row == nullptr) return;
    Wake(EntityRow{static_cast<uint32_t>(row - first)});
  }
}

}  // namespace genphys

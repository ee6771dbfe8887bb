#include "world.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "contacts.h"

namespace genphys::bullet_backend {
namespace {

// An island with joints is solved all at once, unless asked otherwise, while it has no more rows than this.
constexpr size_t kAutomaticRowsMax = 160;
// So is one without joints that has no more points than this, if weights in it are uneven. Of boxes on top of each
// other, the topmost a hundred times as heavy, that takes as long as sweeps for eight of them, and 1.6 times as long
// for twelve, of which sweeps let the topmost fall.
constexpr size_t kUnevenPointsMax = 48;
// Where all islands shall be solved all at once, those that would take too long for it are not.
constexpr size_t kDirectContactsMax = 100;
constexpr size_t kDirectRowsMax = 300;

// Those of `contacts`, which are const or not.
auto PointsOf(const ContactPair& pair, auto& contacts) {
  return std::span(contacts.points).subspan(pair.first_point, pair.point_count);
}

}  // namespace

void World::AddBody(const BodyDesc& desc, const StateArrays& state) {
  const auto row = Index(desc.row);
  if (row >= bodies_.size()) bodies_.resize(row + 1);
  bodies_[row] = std::make_unique<Body>(desc, state);
  for (PlacedGeometry& geometry : bodies_[row]->geometries) {
    if (Index(geometry.row) >= geometries_.size()) geometries_.resize(Index(geometry.row) + 1);
    geometries_[Index(geometry.row)] = &geometry;
  }
}

void World::RemoveBody(EntityRow row) {
  for (const PlacedGeometry& geometry : body(row).geometries) geometries_[Index(geometry.row)] = nullptr;
  memory_.Remove(body(row).id);
  bodies_[Index(row)] = nullptr;
}

void World::SetActive(std::span<const EntityRow> rows, bool active) {
  for (const EntityRow row : rows) {
    body(row).is_active = active;
    memory_.SetActive(body(row).id, active);
  }
}

void World::WriteState(std::span<const EntityRow> rows, const StateArrays& state) {
  for (const EntityRow row : rows) body(row).TakePose(state);
}

void World::ScaleInertia(std::span<const InertiaScale> scales) {
  for (const EntityRow row : scaled_) {
    if (bodies_[Index(row)] != nullptr) body(row).inertia_factor = 1;
  }
  scaled_.clear();
  for (const InertiaScale& scale : scales) {
    body(scale.row).inertia_factor = scale.factor;
    scaled_.push_back(scale.row);
  }
}

void World::FindPoints(GeometryRow a, GeometryRow b, std::vector<ContactPoint>& points) {
  PlacedGeometry& first = geometry(a);
  PlacedGeometry& second = geometry(b);
  Manifold meeting;
  FindMeeting(first.shape, first.placement, second.shape, second.placement, meeting);
  for (int i = 0; i < meeting.count; ++i) {
    const MeetingPoint& point = meeting.points[static_cast<size_t>(i)];
    points.push_back({.position = point.position, .normal = point.normal, .depth = point.depth});
  }
}

// Only what is near something is ever asked for, so that geometries follow their body when they are.
PlacedGeometry& World::geometry(GeometryRow row) {
  PlacedGeometry& geometry = *geometries_[Index(row)];
  if (std::exchange(geometry.body->is_moved, false)) geometry.body->PlaceGeometries();
  return geometry;
}

ContactMemory::Motion World::MotionOf(EntityId id) const {
  using Motion = ContactMemory::Motion;
  const Body* const body = id.index() < bodies_.size() ? bodies_[id.index()].get() : nullptr;
  if (body == nullptr || body->id != id) return Motion::kGone;
  if (body->motion_type == MotionType::kStatic) return Motion::kNone;
  return body->is_active ? Motion::kMoving : Motion::kResting;
}

// In the frame of what slides over the other its points stand still.
std::pair<ContactMemory::Key, Placement> World::Identify(const ContactPair& pair) {
  const PlacedGeometry &a = geometry(pair.geometry_a), &b = geometry(pair.geometry_b);
  return {{a.body->id, b.body->id, a.id, b.id},
          b.body->motion_type == MotionType::kDynamic ? b.placement : a.placement};
}

void World::Recall(const ContactBuffer& solved) {
  memory_.Recall(
      solved, [&](const ContactPair& pair) { return Identify(pair); },
      [&](const ContactPair& pair, std::vector<ContactPoint>& points) {
        FindPoints(pair.geometry_a, pair.geometry_b, points);
      });
}

void World::Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                  std::span<JointRow> joint_rows) {
  memory_.Recognise(
      contacts, [&](EntityId id) { return MotionOf(id); }, [&](const ContactPair& pair) { return Identify(pair); });
  ++solve_stamp_;
  for (const EntityRow row : rows) body(row).solve_stamp = solve_stamp_;
  for (ContactPoint& point : contacts.points) {
    point.normal_impulse = 0;
    point.friction_impulse.setZero();
  }
  islands_.Find(state.rows(), rows, contacts, joint_rows);
  for (uint32_t i = 0; i < islands_.islands().size(); ++i) SolveIsland(i, step_size, state, contacts, joint_rows);
  for (const EntityRow row : rows) Move(body(row), step_size, state);
}

void World::SolveAgain(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts,
                       std::span<JointRow> joint_rows) {
  ContactMemory kept = std::exchange(memory_, memory_.OfBefore());
  Solve(step_size, rows, state, contacts, joint_rows);
  memory_ = std::move(kept);
}

bool World::IsDirect(uint32_t number, const ContactBuffer& contacts) {
  const Islands::Island& island = islands_.islands()[number];
  if (settings_.solver == Solver::kIterative) return false;
  if (settings_.solver == Solver::kDirect) {
    return island.contacts <= kDirectContactsMax && island.joint_rows <= kDirectRowsMax;
  }
  if (island.joint_rows == 0) {
    if (island.contacts > kUnevenPointsMax) return false;
    const auto mass_of = [&](EntityRow row) -> PushSpread::Mass {
      const Body& pushed = body(row);
      return {pushed.pose.Transform(pushed.center_of_mass), pushed.rigid->getInvMass(),
              pushed.moments.cwiseInverse().norm()};
    };
    return PushSpread::Of(islands_, number, contacts, {}, mass_of) >= PushSpread::kUneven;
  }
  return 3 * island.contacts + island.joint_rows <= kAutomaticRowsMax;
}

void World::SolveIsland(uint32_t number, double step_size, const StateArrays& state, ContactBuffer& contacts,
                        std::span<JointRow> joint_rows) {
  const Islands::Island& island = islands_.islands()[number];
  ++island_stamp_;
  solver_.Begin(step_size, contacts.pull, island.contacts <= ContactSweeps::kFewPoints && island.joint_rows == 0);
  LoadContacts(number, state, contacts);
  LoadRows(number, state, joint_rows);
  solver_.Solve(IsDirect(number, contacts));
}

// Null if nothing that happens in this solve can move the body and it does not move by itself either.
Body* World::Load(Body& body, const StateArrays& state) {
  const bool is_driven = body.motion_type == MotionType::kKinematic && body.is_active;
  if (!is_driven && body.solve_stamp != solve_stamp_) return nullptr;
  if (body.island_stamp != island_stamp_) {
    body.island_stamp = island_stamp_;
    body.touch_stamp = solve_stamp_;
    body.LoadRigid(state);
    solver_.AddBody(body);
  }
  return &body;
}

void World::LoadContacts(uint32_t number, const StateArrays& state, ContactBuffer& contacts) {
  for (const uint32_t i : islands_.PairsOf(number)) {
    const ContactPair& pair = contacts.pairs[i];
    Body* const side_a = Load(body(pair.entity_a), state);
    Body* const side_b = Load(body(pair.entity_b), state);
    ContactMemory::PerPoint<PointImpulse>& impulses = memory_.pairs()[i].impulses;
    solver_.AddPair(side_a, side_b, pair, PointsOf(pair, contacts), {impulses.data(), impulses.size()});
  }
}

void World::LoadRows(uint32_t number, const StateArrays& state, std::span<JointRow> joint_rows) {
  const auto load = [&](EntityRow row) -> Body* {
    // The world and entities without physics are no bodies here.
    const bool is_body = Index(row) < bodies_.size() && bodies_[Index(row)] != nullptr;
    return is_body ? Load(body(row), state) : nullptr;
  };
  for (const uint32_t i : islands_.JointRowsOf(number))
    solver_.AddRow(load(joint_rows[i].a), load(joint_rows[i].b), joint_rows[i]);
}

void World::Move(Body& body, double step_size, StateArrays& state) {
  const auto row = Index(body.row);
  if (body.touch_stamp != solve_stamp_) {
    body.solved = {.linear_velocity = state.linear_velocities.col(row),
                   .angular_velocity = state.angular_velocities.col(row)};
  }
  body.pose = MovedBy(body.solved, step_size, body.center_of_mass, body.pose);
  if (!body.pose.position.allFinite() || !body.pose.orientation.coeffs().allFinite()) {
    throw EngineFault(absl::StrCat("the motion of entity ", body.id.packed(), " is not finite"));
  }
  state.linear_velocities.col(row) = body.solved.linear_velocity;
  state.angular_velocities.col(row) = body.solved.angular_velocity;
  state.set_pose(body.row, body.pose);
  body.is_moved = true;
}

}  // namespace genphys::bullet_backend

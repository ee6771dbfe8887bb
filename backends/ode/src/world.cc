#include "world.h"

#include <algorithm>
#include <limits>

#include "contacts.h"
#include "genphys/ray_cast.h"
#include "library.h"

namespace genphys::ode_backend {
namespace {

// Before a solve too: ODE itself notices in the middle of one, and then its memory for the step is lost.
void CheckFinite(const Motion& motion) {
  if (!motion.linear_velocity.allFinite() || !motion.angular_velocity.allFinite()) {
    throw EngineFault("ODE: a velocity is not finite");
  }
}

}  // namespace

void World::AddBody(const BodyDesc& desc, const StateArrays& state) {
  PrepareThread();
  if (Index(desc.row) >= bodies_.size()) bodies_.resize(Index(desc.row) + 1);
  Body& body = bodies_[Index(desc.row)];
  body.id = desc.id;
  body.serial = ++last_serial_;
  body.motion_type = desc.body.motion_type;
  body.is_active = true;
  if (body.motion_type == MotionType::kDynamic) {
    body.mass = desc.mass;
    body.is_centered = desc.mass.center_of_mass.isZero(0);
  }
  body.geometries.assign(desc.geometries.begin(), desc.geometries.end());

  const Pose pose = state.pose(desc.row);
  for (size_t i = 0; i < desc.geometries.size(); ++i) {
    const GeometryRow row = desc.geometries[i];
    if (Index(row) >= shapes_.size()) shapes_.resize(Index(row) + 1);
    PlacedShape& shape = shapes_[Index(row)];
    shape = PlacedShape(desc.row, desc.body.geometries[i]);
    shape.Place(pose.position, pose.orientation);
    if (shape.is_plane()) {
      broad_phase_.AddHalfSpace(row, shape.half_space());
    } else {
      broad_phase_.Add(row, shape.box(), body.motion_type != MotionType::kStatic);
    }
  }
}

void World::RemoveBody(EntityRow row) {
  for (GeometryRow geometry : bodies_[Index(row)].geometries) {
    broad_phase_.Remove(geometry);
    shapes_[Index(geometry)] = PlacedShape();
  }
  bodies_[Index(row)] = Body{};
}

void World::SetActive(std::span<const EntityRow> rows, bool active) {
  for (EntityRow row : rows) {
    Body& body = bodies_[Index(row)];
    if (body.is_active == active) continue;
    body.is_active = active;
    if (body.motion_type == MotionType::kStatic) continue;
    for (GeometryRow geometry : body.geometries) broad_phase_.SetMoving(geometry, active);
  }
}

void World::WriteState(std::span<const EntityRow> rows, const StateArrays& state) {
  PrepareThread();
  // Solve() takes velocities and centres of mass from the columns, so only the geometries have to follow here.
  for (EntityRow row : rows) {
    const Pose pose = state.pose(row);
    Place(bodies_[Index(row)], pose.position, pose.orientation);
  }
}

void World::Place(const Body& body, const Vector3& position, const Quaternion& orientation) {
  for (GeometryRow row : body.geometries) {
    PlacedShape& shape = shapes_[Index(row)];
    shape.Place(position, orientation);
    if (shape.is_plane()) {
      broad_phase_.MoveHalfSpace(row, shape.half_space());
    } else {
      broad_phase_.Move(row, shape.box());
    }
  }
}

void World::Collide(const PairRule& rule, ContactBuffer& contacts) {
  PrepareThread();
  contacts.Clear();
  UpdateNeighbours(rule);
  for (const Neighbours& pair : neighbours_) {
    if (!broad_phase_.MayTouch(pair.a, pair.b)) continue;
    const PlacedShape& a = shapes_[Index(pair.a)];
    const PlacedShape& b = shapes_[Index(pair.b)];
    const auto first_point = static_cast<uint32_t>(contacts.points.size());
    const uint32_t count = FindPoints(a, b, contacts.points);
    if (count == 0) continue;
    contacts.pairs.push_back({.entity_a = a.entity(),
                              .entity_b = b.entity(),
                              .geometry_a = pair.a,
                              .geometry_b = pair.b,
                              .material = rule.Mixed(pair.a, pair.b),
                              .is_sensor = pair.is_sensor,
                              .first_point = first_point,
                              .point_count = count});
  }
}

void World::UpdateNeighbours(const PairRule& rule) {
  std::erase_if(neighbours_, [&](const Neighbours& pair) {
    return broad_phase_.IsFresh(pair.a) || broad_phase_.IsFresh(pair.b) || !broad_phase_.AreNeighbours(pair.a, pair.b);
  });
  new_neighbours_.clear();
  broad_phase_.VisitFreshPairs([&](GeometryRow a, GeometryRow b) { AddNeighbours(rule, a, b); });
  broad_phase_.ForgetFresh();
  if (new_neighbours_.empty()) return;
  std::sort(new_neighbours_.begin(), new_neighbours_.end());
  merged_neighbours_.resize(neighbours_.size() + new_neighbours_.size());
  std::merge(neighbours_.begin(), neighbours_.end(), new_neighbours_.begin(), new_neighbours_.end(),
             merged_neighbours_.begin());
  neighbours_.swap(merged_neighbours_);
}

void World::AddNeighbours(const PairRule& rule, GeometryRow a, GeometryRow b) {
  const PairRule::Verdict verdict = rule.Decide(a, b);
  if (verdict == PairRule::Verdict::kIgnore) return;
  if (!rule.Before(a, b)) std::swap(a, b);
  const PairRule::GeometryInfo& info_a = rule.info(a);
  const PairRule::GeometryInfo& info_b = rule.info(b);
  new_neighbours_.push_back({info_a.entity_id, info_b.entity_id, info_a.geometry_id, info_b.geometry_id, a, b,
                             verdict == PairRule::Verdict::kSensor});
}

void World::Solve(double step_size, std::span<const EntityRow> rows, StateArrays& state, ContactBuffer& contacts) {
  PrepareThread();
  MarkContacts(contacts, true);
  solved_rows_.clear();
  for (EntityRow row : rows) {
    // What touches nothing needs no solver, and ODE would take more time for it than for all the rest.
    if (bodies_[Index(row)].has_contact) {
      solved_rows_.push_back(row);
    } else {
      Fly(row, step_size, state);
    }
  }
  MarkContacts(contacts, false);
  if (solved_rows_.empty()) return;
  solver_.Begin(static_cast<uint32_t>(solved_rows_.size()), step_size);
  LoadBodies(state);
  LoadContacts(state, contacts);
  solver_.Step();
  StoreImpulses(contacts);
  StoreBodies(state);
}

void World::MarkContacts(const ContactBuffer& contacts, bool has_contact) {
  for (const ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor) continue;
    bodies_[Index(pair.entity_a)].has_contact = has_contact;
    bodies_[Index(pair.entity_b)].has_contact = has_contact;
  }
}

void World::Fly(EntityRow row, double step_size, StateArrays& state) {
  const Motion motion = MotionOf(row, state);
  CheckFinite(motion);
  const double angle = motion.angular_velocity.norm() * step_size;
  Quaternion orientation = motion.orientation;
  if (angle > 0) {
    const Eigen::AngleAxisd turn(angle, motion.angular_velocity.normalized());
    orientation = (turn * orientation).normalized();
  }
  StorePose(row, motion.position + step_size * motion.linear_velocity, orientation, state);
}

Motion World::MotionOf(EntityRow row, const StateArrays& state) const {
  const Body& body = bodies_[Index(row)];
  const Pose pose = state.pose(row);
  const uint32_t column = Index(row);
  return {body.is_centered ? pose.position : pose.Transform(body.mass.center_of_mass), pose.orientation,
          state.linear_velocities.col(column), state.angular_velocities.col(column)};
}

void World::LoadBodies(const StateArrays& state) {
  for (uint32_t i = 0; i < solved_rows_.size(); ++i) {
    Body& body = bodies_[Index(solved_rows_[i])];
    body.solved_as = i;
    const Motion motion = MotionOf(solved_rows_[i], state);
    CheckFinite(motion);
    solver_.SetBody(i, body.serial, body.mass, motion);
  }
}

World::Side World::SideOf(EntityRow row, const StateArrays& state) const {
  const Body& body = bodies_[Index(row)];
  if (body.motion_type == MotionType::kStatic || !body.is_active) return {};
  const Motion motion = MotionOf(row, state);
  return {body.solved_as, motion.position, motion.linear_velocity, motion.angular_velocity};
}

// Change of velocity per impulse at a point, 1/kg, at most: whatever the direction of the push.
double World::MobilityAt(const Vector3& point, EntityRow row, const StateArrays& state) const {
  const Body& body = bodies_[Index(row)];
  if (body.solved_as == kUnsolved) return 0;
  const double arm = (point - MotionOf(row, state).position).squaredNorm();
  return 1 / body.mass.mass + arm * body.mass.inverse_tensor.norm();
}

double World::MobilitySpread(const StateArrays& state, const ContactBuffer& contacts) const {
  double highest = 0, lowest = std::numeric_limits<double>::infinity();
  for (const ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor) continue;
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      for (const EntityRow row : {pair.entity_a, pair.entity_b}) {
        const double mobility = MobilityAt(contacts.points[i].position, row, state);
        if (mobility == 0) continue;
        highest = std::max(highest, mobility);
        lowest = std::min(lowest, mobility);
      }
    }
  }
  return highest > 0 ? highest / lowest : 1;
}

void World::LoadContacts(const StateArrays& state, const ContactBuffer& contacts) {
  solved_.clear();
  size_t count = 0;
  for (const ContactPair& pair : contacts.pairs) count += pair.is_sensor ? 0 : pair.point_count;
  solver_.ReserveContacts(count, solver_.may_be_direct() ? MobilitySpread(state, contacts) : 1);
  for (const ContactPair& pair : contacts.pairs) {
    if (pair.is_sensor) continue;
    const Side a = SideOf(pair.entity_a, state);
    const Side b = SideOf(pair.entity_b, state);
    if (a.solved_as == kUnsolved && b.solved_as == kUnsolved) continue;
    for (uint32_t i = pair.first_point; i < pair.first_point + pair.point_count; ++i) {
      LoadContact(contacts.points[i], i, a, b);
    }
  }
}

void World::LoadContact(const ContactPoint& point, uint32_t index, const Side& a, const Side& b) {
  // The solver pushes one side away from the other, and the one that it pushes must be movable.
  const double sign = b.solved_as != kUnsolved ? 1 : -1;
  const Side& pushed = sign > 0 ? b : a;
  const Side& other = sign > 0 ? a : b;
  const Vector3 other_velocity = other.VelocityAt(point.position);
  solver_.AddContact({.body = pushed.solved_as,
                      .other = other.solved_as,
                      .position = point.position,
                      .normal = sign * point.normal,
                      .depth = point.depth,
                      .friction = point.friction,
                      .relative_velocity = pushed.VelocityAt(point.position) - other_velocity,
                      .other_velocity = other.solved_as == kUnsolved ? other_velocity : Vector3::Zero()});
  solved_.push_back({index, sign});
}

void World::StoreImpulses(ContactBuffer& contacts) const {
  for (size_t i = 0; i < solved_.size(); ++i) {
    ContactPoint& point = contacts.points[solved_[i].point];
    const Vector3 impulse = solved_[i].sign * solver_.Impulse(i);
    point.normal_impulse = impulse.dot(point.normal);
    point.friction_impulse = impulse - point.normal_impulse * point.normal;
  }
}

void World::StoreBodies(StateArrays& state) {
  for (uint32_t i = 0; i < solved_rows_.size(); ++i) {
    const EntityRow row = solved_rows_[i];
    bodies_[Index(row)].solved_as = kUnsolved;
    const Motion motion = solver_.motion(i);
    CheckFinite(motion);
    state.linear_velocities.col(Index(row)) = motion.linear_velocity;
    state.angular_velocities.col(Index(row)) = motion.angular_velocity;
    StorePose(row, motion.position, motion.orientation, state);
  }
}

void World::StorePose(EntityRow row, const Vector3& center_of_mass, const Quaternion& orientation, StateArrays& state) {
  const Body& body = bodies_[Index(row)];
  Pose pose{center_of_mass, orientation};
  if (!body.is_centered) pose.position -= orientation * body.mass.center_of_mass;
  state.set_pose(row, pose);
  Place(body, pose.position, pose.orientation);
}

void World::CastRays(const PairRule& rule, std::span<const Ray> rays, uint64_t collides_with_bits,
                     std::span<RayHit> hits) {
  std::transform(rays.begin(), rays.end(), hits.begin(),
                 [&](const Ray& ray) { return CastRay(rule, ray, collides_with_bits); });
}

RayHit World::CastRay(const PairRule& rule, const Ray& ray, uint64_t collides_with_bits) const {
  RayHit best;
  best.fraction = 1;
  broad_phase_.VisitRay(ray, best.fraction, [&](GeometryRow row) {
    if (!rule.SeenByRay(row, collides_with_bits)) return;
    const PlacedShape& shape = shapes_[Index(row)];
    const Matrix3 to_shape = shape.rotation().transpose();
    const auto entry =
        EnterShape(shape.shape(), {to_shape * (ray.origin - shape.position()), to_shape * ray.translation});
    if (!entry) return;
    const EntityId id = body_of(row).id;
    const bool is_better =
        best.entity.is_null() || std::tie(entry->fraction, id) < std::tie(best.fraction, best.entity);
    if (is_better) best = {id, entry->fraction, shape.rotation() * entry->normal};
  });
  return best.entity.is_null() ? RayHit{} : best;
}

void World::FindOnSegment(const Ray& segment, std::vector<GeometryRow>& found) {
  broad_phase_.VisitRay(segment, 1.0, [&](GeometryRow row) { found.push_back(row); });
}

void World::FindInBounds(const Bounds& bounds, std::vector<GeometryRow>& found) {
  broad_phase_.VisitBounds({bounds.min, bounds.max}, [&](GeometryRow row) { found.push_back(row); });
}

void World::SaveState(std::string& bytes) const {
  // Nothing is remembered from one solve to the next.
  static_cast<void>(bytes);
}

}  // namespace genphys::ode_backend

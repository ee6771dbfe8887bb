#include "genphys/pair_rule.h"

#include <algorithm>
#include <utility>

namespace genphys {
namespace {

std::pair<EntityId, EntityId> KeyOf(EntityId a, EntityId b) { return std::minmax(a, b); }

bool Rolls(const Shape& shape) {
  return std::holds_alternative<Sphere>(shape) || std::holds_alternative<Capsule>(shape) ||
         std::holds_alternative<Cylinder>(shape) || std::holds_alternative<Cone>(shape) ||
         std::holds_alternative<Ellipsoid>(shape);
}

}  // namespace

PairRule::Verdict PairRule::Decide(GeometryRow row_a, GeometryRow row_b) const {
  const GeometryInfo& a = infos_[Index(row_a)];
  const GeometryInfo& b = infos_[Index(row_b)];
  if (a.entity == b.entity) return Verdict::kIgnore;
  if ((a.category_bits & b.collides_with_bits) == 0 || (b.category_bits & a.collides_with_bits) == 0) {
    return Verdict::kIgnore;
  }
  if (a.space != 0 && a.space == b.space) return Verdict::kIgnore;
  if (!disregarded_.empty() && disregarded_.contains(KeyOf(a.entity_id, b.entity_id))) return Verdict::kIgnore;
  if (a.is_sensor || b.is_sensor) {
    // A sensor tells of visitors; two sensors would only tell of each other, and two static ones never change.
    const bool useful = a.is_sensor != b.is_sensor && !(a.is_static && b.is_static);
    return useful ? Verdict::kSensor : Verdict::kIgnore;
  }
  return a.is_dynamic || b.is_dynamic ? Verdict::kCollide : Verdict::kIgnore;
}

bool PairRule::SeenByRay(GeometryRow geometry, uint64_t bits) const {
  const GeometryInfo& info = infos_[Index(geometry)];
  return !info.is_sensor && (info.category_bits & bits) != 0;
}

MixedMaterial PairRule::Mixed(GeometryRow a, GeometryRow b) const {
  return Mix(infos_[Index(a)].material, infos_[Index(b)].material);
}

bool PairRule::Before(GeometryRow row_a, GeometryRow row_b) const {
  const GeometryInfo& a = infos_[Index(row_a)];
  const GeometryInfo& b = infos_[Index(row_b)];
  return std::pair(a.entity_id, a.geometry_id) < std::pair(b.entity_id, b.geometry_id);
}

GeometryRows PairRule::Add(EntityRow entity, EntityId id, const RigidBody& body) {
  GeometryRows rows;
  rows.reserve(body.geometries.size());
  for (const Geometry& geometry : body.geometries) {
    if (free_.empty()) {
      free_.push_back(GeometryRow{static_cast<uint32_t>(infos_.size())});
      infos_.emplace_back();
    }
    const GeometryRow row = free_.back();
    free_.pop_back();
    infos_[Index(row)] = {
        .entity = entity,
        .geometry_id = geometry.id,
        .entity_id = id,
        .category_bits = geometry.category_bits,
        .collides_with_bits = geometry.collides_with_bits,
        .space = SpaceRoot(geometry.collision_space),
        .is_sensor = geometry.is_sensor,
        .is_static = body.motion_type == MotionType::kStatic,
        .is_dynamic = body.motion_type == MotionType::kDynamic,
        .rolls = Rolls(geometry.shape),
        .material = geometry.material,
        .surface_velocity = geometry.pose_in_entity.orientation * geometry.surface_velocity,
        .correction = body.error_correction,
        .data = HeldShapes::DataOf(geometry.shape),
    };
    shapes_.Add(geometry.shape);
    if (!geometry.surface_velocity.isZero(0)) ++running_surfaces_;
    rows.push_back(row);
  }
  return rows;
}

void PairRule::Remove(std::span<const GeometryRow> rows) {
  for (GeometryRow row : rows) {
    if (!infos_[Index(row)].surface_velocity.isZero(0)) --running_surfaces_;
    shapes_.Remove(infos_[Index(row)].data);
    infos_[Index(row)] = GeometryInfo{};
    free_.push_back(row);
  }
}

void PairRule::Disregard(EntityId a, EntityId b) { ++disregarded_[KeyOf(a, b)]; }

void PairRule::Regard(EntityId a, EntityId b) {
  const auto found = disregarded_.find(KeyOf(a, b));
  if (--found->second == 0) disregarded_.erase(found);
}

uint32_t PairRule::SpaceRoot(const std::string& collision_space) {
  if (collision_space.empty()) return 0;
  // Members of "car/wheels" are members of "car" too, so whatever shares the first name shares a space.
  std::string root = collision_space.substr(0, collision_space.find('/'));
  return space_roots_.try_emplace(std::move(root), static_cast<uint32_t>(space_roots_.size()) + 1).first->second;
}

}  // namespace genphys

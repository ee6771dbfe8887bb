#include "impacts/impact_past.h"

#include <algorithm>
#include <utility>

#include "pairs/contact_points.h"

namespace genphys {
namespace {

// The cosine between two normals that may be those of one place a substep later.
constexpr double kSameNormal = 0.9;

}  // namespace

bool ImpactPast::IsMovable(EntityRow row) const {
  return world_.active[Index(row)] && world_.scene.entities[Index(row)]->traits.is_dynamic;
}

bool ImpactPast::IsHit(EntityRow row) const { return std::as_const(world_.free_since)[row] < step_size_; }

bool ImpactPast::StandsOnGround(EntityRow row) const {
  return std::as_const(world_.stances)[row] == kOnGround && !world_.jointed[row];
}

double ImpactPast::FreeSince(const ContactPair& pair) const {
  const RowValues<double>& free_since = world_.free_since;
  return std::min({step_size_, free_since[pair.entity_a], free_since[pair.entity_b]});
}

bool ImpactPast::WereTouching(const EntityPair& entities) const {
  const auto known = touching_search_.LowerBound(world_.layer.touching, entities, &TouchingPair::pair);
  return known != world_.layer.touching.end() && known->pair == entities;
}

double ImpactPast::Apart(const EntityPair& entities, double impulse) const {
  double give = 0;
  for (const EntityId id : {entities.a, entities.b}) {
    const EntityRow row{id.index()};
    if (IsMovable(row)) give += 1 / world_.scene.entities[Index(row)]->mass.mass;
  }
  return impulse * give;
}

template <typename Found>
bool ImpactPast::AnySolved(const EntityPair& entities, Found&& found) const {
  const auto ids = [&](const ContactPair& pair) {
    return EntityPair{world_.state.ids[Index(pair.entity_a)], world_.state.ids[Index(pair.entity_b)]};
  };
  const std::vector<ContactPair>& solved = world_.solved.pairs;
  for (auto pair = solved_search_.LowerBound(solved, entities, ids); pair != solved.end(); ++pair) {
    if (ids(*pair) != entities) return false;
    if (found(*pair)) return true;
  }
  return false;
}

template <typename Found>
bool ImpactPast::AnyRemembered(const EntityPair& entities, Found&& found) const {
  for (const auto& [woken, other] : {std::pair(entities.a, entities.b), std::pair(entities.b, entities.a)}) {
    if (!IsWoken(EntityRow{woken.index()})) continue;
    const std::vector<LastTouch>& touches = world_.layer.last_touches[woken.index()];
    for (const LastTouch& touch : std::ranges::equal_range(touches, other, {}, &LastTouch::other)) {
      if (found(touch.points)) return true;
    }
  }
  return false;
}

bool ImpactPast::WerePressed(const EntityPair& entities) const {
  const auto were_pressed = [&](const auto& points) {
    double impulse = 0;
    for (const auto& point : points) impulse += point.normal_impulse;
    return Apart(entities, impulse) > ImpactSpeed::kMin;
  };
  return AnySolved(entities, [&](const ContactPair& pair) { return were_pressed(PointsOf(world_.solved, pair)); }) ||
         AnyRemembered(entities, were_pressed);
}

template <typename Found>
bool ImpactPast::AnyPressed(const ContactPair& pair, Found&& found) const {
  const EntityPair entities{world_.state.ids[Index(pair.entity_a)], world_.state.ids[Index(pair.entity_b)]};
  const auto presses = [&](const auto& point) { return point.normal_impulse > 0 && found(point); };
  const bool did_press = AnySolved(entities, [&](const ContactPair& before) {
    if (before.geometry_a != pair.geometry_a || before.geometry_b != pair.geometry_b) return false;
    return std::ranges::any_of(PointsOf(world_.solved, before), presses);
  });
  const uint32_t id_a = world_.rule.info(pair.geometry_a).geometry_id;
  const uint32_t id_b = world_.rule.info(pair.geometry_b).geometry_id;
  const auto is_of = [&](const EventContactPoint& point) {
    return point.geometry_a == id_a && point.geometry_b == id_b;
  };
  return did_press || AnyRemembered(entities, [&](const std::vector<EventContactPoint>& points) {
           return std::ranges::any_of(points, [&](const auto& point) { return is_of(point) && presses(point); });
         });
}

bool ImpactPast::WerePressedSo(const ContactPair& pair, const Vector3& normal) const {
  return AnyPressed(pair, [&](const auto& point) { return point.normal.dot(normal) > kSameNormal; });
}

bool ImpactPast::WerePressedNear(const ContactPair& pair, const Vector3& position, double distance) const {
  return AnyPressed(
      pair, [&](const auto& pressed) { return (pressed.position - position).squaredNorm() <= distance * distance; });
}

bool ImpactPast::PressesNobody(EntityRow row) const {
  if (!among_others_) {
    among_others_.emplace();
    for (const ContactPair& pair : world_.solved.pairs) {
      if (pair.is_sensor || !IsMovable(pair.entity_a) || !IsMovable(pair.entity_b)) continue;
      if (HasPressed(world_.solved, pair)) among_others_->insert(among_others_->end(), {pair.entity_a, pair.entity_b});
    }
    std::ranges::sort(*among_others_);
  }
  return !std::ranges::binary_search(*among_others_, row);
}

const FlownWay* ImpactPast::WayFromBlow(EntityRow row) const {
  if (!IsHit(row)) return nullptr;
  const auto way = std::ranges::lower_bound(ways_, row, {}, &FlownWay::row);
  return way != ways_.end() && way->row == row ? &*way : nullptr;
}

Vector3 ImpactPast::CourseOf(EntityRow row) const {
  if (const FlownWay* const way = WayFromBlow(row)) return way->acceleration;
  if (IsHit(row) || IsWoken(row)) return Vector3::Zero();
  return world_.accelerations[row] + 2 / step_size_ * world_.layer.half_steps[Index(row)].held_velocity;
}

Vector3 ImpactPast::TwistOf(EntityRow row) const {
  if (const FlownWay* const way = WayFromBlow(row)) return way->torque;
  if (IsHit(row) || IsWoken(row)) return Vector3::Zero();
  const HalfStep& half = world_.layer.half_steps[Index(row)];
  return 2 / step_size_ * (half.steady_twist + half.held_momentum);
}

Vector3 ImpactPast::PushOf(EntityRow row) const {
  const FlownWay* const way = WayFromBlow(row);
  return world_.accelerations[row] + (way != nullptr ? way->by_others : Vector3(Vector3::Zero()));
}

// What holds a body takes away what pulls at it.
Vector3 ImpactPast::PullOn(EntityRow row) const {
  if (speed_.IsInFlight(row)) {
    // What it landed on bears it from there on.
    const FlownWay* const way = WayFromBlow(row);
    return way != nullptr ? way->acceleration : world_.accelerations[row];
  }
  return StandsOnGround(row) ? CourseOf(row) : Vector3(Vector3::Zero());
}

ImpactMotion ImpactPast::MotionOf(EntityRow entity) const {
  const uint32_t row = Index(entity);
  const SceneEntity& scene_entity = *world_.scene.entities[row];
  const Pose pose = world_.state.pose(entity);
  const Vector3 linear = world_.state.linear_velocities.col(row), angular = world_.state.angular_velocities.col(row);
  const bool is_dynamic = scene_entity.desc->rigid_body->motion_type == MotionType::kDynamic;
  if (!is_dynamic || !world_.active[row]) return ImpactMotion::Driven(pose, linear, angular);
  const bool is_shoved = world_.shoved[entity], is_led = world_.jointed[entity] || is_shoved;
  if (is_led || std::ranges::binary_search(tipping_, entity)) {
    const auto way = std::ranges::lower_bound(ways_, entity, {}, &FlownWay::row);
    if (way != ways_.end() && way->row == entity) {
      const Vector3 acceleration = is_led ? way->acceleration : CourseOf(entity);
      const Vector3 torque = is_led ? way->torque : TwistOf(entity);
      ImpactMotion along =
          ImpactMotion::Along(way->start, way->time, pose, scene_entity.mass, linear, angular, acceleration, torque);
      if (!world_.jointed[entity]) along.GoesOnPushed();
      return along;
    }
  }
  return ImpactMotion::Free(pose, scene_entity.mass, linear, angular, PullOn(entity));
}

const Geometry& ImpactPast::GeometryAt(GeometryRow row) const {
  const EntityRow entity = world_.rule.info(row).entity;
  const GeometryRows& rows = world_.geometry_rows[Index(entity)];
  const auto place = static_cast<size_t>(std::find(rows.begin(), rows.end(), row) - rows.begin());
  return world_.scene.entities[Index(entity)]->desc->rigid_body->geometries[place];
}

Placement ImpactPast::Placed(GeometryRow row, const ImpactMotion& motion, double time) const {
  return ToPlacement(motion.PoseBefore(time).Transform(GeometryAt(row).pose_in_entity));
}

void ImpactPast::FindMeeting(const ContactPair& pair, double time_a, double time_b, double gap,
                             Manifold& manifold) const {
  FindMeeting(pair, MotionOf(pair.entity_a), time_a, MotionOf(pair.entity_b), time_b, gap, manifold);
}

void ImpactPast::FindMeeting(const ContactPair& pair, const ImpactMotion& a, double time_a, const ImpactMotion& b,
                             double time_b, double gap, Manifold& manifold) const {
  FindContacts(GeometryAt(pair.geometry_a).shape, Placed(pair.geometry_a, a, time_a), GeometryAt(pair.geometry_b).shape,
               Placed(pair.geometry_b, b, time_b), gap, manifold);
}

}  // namespace genphys

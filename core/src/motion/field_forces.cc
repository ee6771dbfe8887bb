#include "motion/field_forces.h"

#include <algorithm>
#include <cmath>

#include "motion/spring_forces.h"
#include "shapes/submersion.h"

namespace genphys {
namespace {

Bounds BoundsOf(const Region& region) {
  return {region.corner.cwiseMin(region.opposite_corner), region.corner.cwiseMax(region.opposite_corner)};
}

bool Resists(const DragField& drag) { return drag.linear > 0 || drag.quadratic > 0 || drag.angular > 0; }

}  // namespace

void FieldForces::Reach::Add(const ForceField& field) {
  if (const auto* spring = std::get_if<SpringField>(&field.kind)) {
    tied.insert(tied.end(), {spring->a, spring->b});
  } else if (!field.entities.empty()) {
    listed.push_back(field.entities);
  } else if (field.region) {
    regions.push_back(BoundsOf(*field.region));
  } else {
    is_everywhere = true;
  }
}

FieldForces::Reach FieldForces::reach() const {
  Reach reach;
  for (const auto& [id, field] : scene_.force_fields) reach.Add(field);
  return reach;
}

Vector3 FieldForces::CenterOf(EntityRow row) const {
  return state_.pose(row).Transform(entity(row).mass.center_of_mass);
}

bool FieldForces::ActsOn(const ForceField& field, EntityRow row) const {
  if (!field.entities.empty() &&
      !std::binary_search(field.entities.begin(), field.entities.end(), state_.ids[Index(row)])) {
    return false;
  }
  if (!field.region) return true;
  const Vector3 center = CenterOf(row);
  return BoundsOf(*field.region).Contains({center, center});
}

void FieldForces::Add(const std::vector<EntityRow>& rows, double h, RowValues<Wrench>& wrenches) const {
  for (const auto& [id, field] : scene_.force_fields) {
    if (std::holds_alternative<DragField>(field.kind) || std::holds_alternative<SpringField>(field.kind)) continue;
    for (const EntityRow row : rows) {
      if (!ActsOn(field, row)) continue;
      Wrench& wrench = wrenches[row];
      const double mass = entity(row).mass.mass;
      if (const auto* uniform = std::get_if<UniformField>(&field.kind)) {
        wrench.force += uniform->force + mass * uniform->acceleration;
      } else if (const auto* gravity = std::get_if<PointGravityField>(&field.kind)) {
        const Vector3 r = gravity->center - CenterOf(row);
        const double distance = std::sqrt(r.squaredNorm() + gravity->softening * gravity->softening);
        wrench.force += mass * gravity->strength / (distance * distance * distance) * r;
      } else if (const auto* fluid = std::get_if<BuoyancyField>(&field.kind)) {
        const Submersion part =
            Submerge(*entity(row).desc->rigid_body, state_.pose(row), fluid->surface_normal, fluid->surface_offset);
        const Vector3 lift = -fluid->fluid_density * part.volume_below * scene_.world.gravity;
        wrench.force += lift;
        wrench.torque += (part.center - CenterOf(row)).cross(lift);
      }
    }
  }
  AddSprings(h, wrenches);
}

void FieldForces::AddSprings(double h, RowValues<Wrench>& wrenches) const {
  std::vector<TiedPair> pairs;
  for (const auto& [id, field] : scene_.force_fields) {
    const auto* spring = std::get_if<SpringField>(&field.kind);
    if (spring == nullptr || !(Moves(spring->a) || Moves(spring->b))) continue;
    TiedPair pair{
        .spring = spring, .a = EndOf(spring->a, spring->point_in_a), .b = EndOf(spring->b, spring->point_in_b)};
    if (pair.Prepare()) pairs.push_back(pair);
  }
  // Each damper answers to the velocity that all forces of this substep make, those of the other springs among them.
  // One sweep does for one spring; more go on until the last digits stay.
  constexpr int kSweepsMax = 50;
  constexpr double kSettled = 1e-14;
  for (int sweep = 0; sweep < kSweepsMax; ++sweep) {
    double change = 0, most = 0;
    for (TiedPair& pair : pairs) {
      const double before = pair.pull;
      pair.Push(-before, wrenches);
      pair.pull = pair.PullAt(pair.Speed(pair.Reach(h), wrenches), h);
      pair.Push(pair.pull, wrenches);
      change = std::max(change, std::abs(pair.pull - before));
      most = std::max(most, std::abs(pair.pull));
    }
    if (pairs.size() < 2 || change <= kSettled * most) return;
  }
}

// Whether forces move it now.
bool FieldForces::Moves(EntityId id) const {
  if (id.is_null() || state_.asleep[id.index()]) return false;
  const std::optional<RigidBody>& body = scene_.entities[id.index()]->desc->rigid_body;
  return body && body->motion_type == MotionType::kDynamic;
}

SpringEnd FieldForces::EndOf(EntityId id, const Vector3& point) const {
  SpringEnd end{.point = point};
  if (id.is_null()) return end;
  const uint32_t row = id.index();
  const SceneEntity& tied = *scene_.entities[row];
  const Pose pose = state_.pose(EntityRow{row});
  const std::optional<RigidBody>& body = tied.desc->rigid_body;
  const bool dynamic = body && body->motion_type == MotionType::kDynamic;
  end.row = EntityRow{row};
  end.point = pose.Transform(point);
  end.moves = Moves(id);
  end.arm = end.point - (dynamic ? pose.Transform(tied.mass.center_of_mass) : pose.position);
  end.linear_velocity = state_.linear_velocities.col(row);
  end.angular_velocity = state_.angular_velocities.col(row);
  if (!end.moves) return end;
  const Matrix3 rotation = pose.orientation.toRotationMatrix();
  end.inverse_mass = 1 / tied.mass.mass;
  end.inverse_tensor = rotation * tied.mass.inverse_tensor * rotation.transpose();
  end.gravity = body->gravity_scale * scene_.world.gravity;
  return end;
}

Resistance FieldForces::ResistanceOf(EntityRow row, const Matrix3& inverse_tensor) const {
  const SceneEntity& slowed = entity(row);
  Resistance sum(slowed.mass.mass, inverse_tensor, slowed.traits.linear_damping, slowed.traits.angular_damping);
  VisitDrag(row, [&](const DragField& drag, double part) { sum.Add(drag, part); });
  return sum;
}

bool FieldForces::IsInMedium(EntityRow row) const {
  bool is_any = false;
  VisitDrag(row, [&](const DragField& drag, double part) { is_any |= part > 0 && Resists(drag); });
  return is_any;
}

template <typename Visit>
void FieldForces::VisitDrag(EntityRow row, Visit visit) const {
  for (const auto& [id, field] : scene_.force_fields) {
    if (const auto* drag = std::get_if<DragField>(&field.kind)) {
      if (ActsOn(field, row)) visit(*drag, 1.0);
    } else if (const auto* fluid = std::get_if<BuoyancyField>(&field.kind)) {
      // What lies below is dear to find.
      if (!Resists(fluid->drag) || !ActsOn(field, row)) continue;
      const Submersion part =
          Submerge(*entity(row).desc->rigid_body, state_.pose(row), fluid->surface_normal, fluid->surface_offset);
      if (part.volume > 0) visit(fluid->drag, part.volume_below / part.volume);
    }
  }
}

}  // namespace genphys

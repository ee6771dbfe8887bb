#include "motion/field_forces.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "motion/spring_forces.h"
#include "shapes/submersion.h"

namespace genphys {
namespace {

Bounds BoundsOf(const Region& region) {
  return {region.corner.cwiseMin(region.opposite_corner), region.corner.cwiseMax(region.opposite_corner)};
}

bool Resists(const DragField& drag) { return drag.linear > 0 || drag.quadratic > 0 || drag.angular > 0; }

// The solution of m v' = -(linear + quadratic |v|) v after `h` seconds: its direction stays, and 1 / speed obeys a
// linear equation (the substitution of Bernoulli).
double Slowed(double speed, double mass, double linear, double quadratic, double h) {
  const double rate = linear / mass, bend = quadratic * speed / mass;
  // (1 - exp(-x)) / x, which has no digits left as it stands when x is small.
  const double mean = rate * h > 0 ? -std::expm1(-rate * h) / (rate * h) : 1;
  return speed * std::exp(-rate * h) / (1 + bend * h * mean);
}

// The solution of L' = -angular I^-1 L after `h` seconds: along each principal axis by its own exponential.
Vector3 SlowedMomentum(const Vector3& momentum, double angular, const Matrix3& inverse_tensor, double h) {
  Eigen::SelfAdjointEigenSolver<Matrix3> principal;
  principal.computeDirect(inverse_tensor);
  const Vector3 left = (-h * angular * principal.eigenvalues().array()).exp();
  return principal.eigenvectors() * left.cwiseProduct(principal.eigenvectors().transpose() * momentum);
}

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

void FieldForces::Drag(EntityRow row, double h, const Matrix3& inverse_tensor, const Vector3& held, Vector3& velocity,
                       Vector3& momentum) const {
  const auto slow = [&](const DragField& drag, double part) {
    const Vector3 relative = velocity + held - drag.medium_velocity;
    const double speed = relative.norm();
    if (speed > 0) {
      const double slowed = Slowed(speed, entity(row).mass.mass, part * drag.linear, part * drag.quadratic, h);
      velocity += relative * (slowed / speed - 1);
    }
    if (drag.angular > 0) momentum = SlowedMomentum(momentum, part * drag.angular, inverse_tensor, h);
  };
  VisitDrag(row, slow);
}

FieldForces::Resistance FieldForces::ResistanceTo(EntityRow row, const Vector3& velocity) const {
  Resistance sum;
  VisitDrag(row, [&](const DragField& drag, double part) {
    const double speed = (velocity - drag.medium_velocity).norm();
    const double rate = part * (drag.linear + drag.quadratic * speed) / entity(row).mass.mass;
    sum.rate += rate;
    sum.flow += rate * drag.medium_velocity;
  });
  return sum;
}

// What is pushed through a medium comes to the speed at which both are in balance. With more than this part of a
// velocity taken in the time, pushes and drag in turns would not find it: with 0.14 of it the speed is 0.26 % off, with
// 0.8 6 %.
std::optional<Vector3> FieldForces::Driven(EntityRow row, double damping, double time, const Vector3& velocity,
                                           const Vector3& acceleration) const {
  constexpr double kMuch = 0.2;
  constexpr int kRoundsMax = 50;
  constexpr double kFound = 1e-12;
  const Resistance pushed = ResistanceTo(row, velocity + time * acceleration);
  double rate = damping + pushed.rate;
  if (!(rate * time > kMuch)) return std::nullopt;
  Vector3 balanced = (pushed.flow + acceleration) / rate;
  // The mean of what resists at one guess and at the next is right at once where drag goes with the square of speed.
  for (int i = 0; i < kRoundsMax; ++i) {
    const Resistance resistance = ResistanceTo(row, balanced);
    const double now = damping + resistance.rate;
    if (now == 0) return std::nullopt;
    const double before = std::exchange(rate, std::sqrt(rate * now));
    balanced = resistance.flow / now + acceleration / rate;
    if (std::abs(rate - before) <= kFound * rate) break;
  }
  const double slows = std::max(rate, damping + ResistanceTo(row, velocity).rate);
  return balanced + std::exp(-slows * time) * (velocity - balanced);
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

#include "contact_solver.h"

#include <algorithm>

namespace genphys::spheres_backend {
namespace {

// Of an overlap in each substep.
constexpr double kPushedOut = 0.2;
// What is so many times as fast as what resists slows it down in a step rolls on for some steps.
constexpr double kRollsOn = 4;

// `value` with no greater length than `bound`.
Vector3 Within(const Vector3& value, double bound) {
  const double length = value.norm();
  return length > bound ? Vector3(value * (bound / length)) : value;
}

}  // namespace

ContactSolver::Body& ContactSolver::BodyAt(EntityRow row) {
  const auto [place, is_new] = bodies_.try_emplace(row);
  Body& body = place->second;
  if (is_new) {
    body.motion.velocity = state_.linear_velocities.col(Index(row));
    body.motion.spin = state_.angular_velocities.col(Index(row));
    body.center = state_.pose(row).position;
  }
  return body;
}

void ContactSolver::AddMover(EntityRow row, const MassProperties& mass) {
  Body& body = BodyAt(row);
  const Pose pose = state_.pose(row);
  const Matrix3 rotation = pose.orientation.toRotationMatrix();
  body.center = pose.Transform(mass.center_of_mass);
  body.inverse_mass = 1 / mass.mass;
  body.inverse_tensor = rotation * mass.inverse_tensor * rotation.transpose();
}

void ContactSolver::AddContact(const ContactPair& pair, ContactPoint& point) {
  Contact& contact = contacts_.emplace_back();
  contact.a = &BodyAt(pair.entity_a);
  contact.b = &BodyAt(pair.entity_b);
  contact.arm_a = point.position - contact.a->center;
  contact.arm_b = point.position - contact.b->center;
  contact.material = pair.material;
  contact.rolling = pair.rolling;
  contact.bend = pair.bend;
  contact.point = &point;
  point.normal_impulse = 0;
  point.friction_impulse.setZero();
}

Vector3 ContactSolver::SlipOf(const Contact& contact) {
  const Motion& a = contact.a->motion;
  const Motion& b = contact.b->motion;
  return b.velocity + b.spin.cross(contact.arm_b) - a.velocity - a.spin.cross(contact.arm_a);
}

double ContactSolver::Softness(const Contact& contact, const Vector3& axis) {
  const auto of = [&](const Body& body, const Vector3& arm) {
    const Vector3 turn = arm.cross(axis);
    return body.inverse_mass + turn.dot(body.inverse_tensor * turn);
  };
  return of(*contact.a, contact.arm_a) + of(*contact.b, contact.arm_b);
}

double ContactSolver::AngularSoftness(const Contact& contact, const Vector3& axis) {
  return axis.dot((contact.a->inverse_tensor + contact.b->inverse_tensor) * axis);
}

void ContactSolver::Apply(const Contact& contact, const Vector3& impulse, const Vector3& torque) {
  Body& a = *contact.a;
  Body& b = *contact.b;
  a.motion.velocity -= a.inverse_mass * impulse;
  a.motion.spin -= a.inverse_tensor * (contact.arm_a.cross(impulse) + torque);
  b.motion.velocity += b.inverse_mass * impulse;
  b.motion.spin += b.inverse_tensor * (contact.arm_b.cross(impulse) + torque);
}

void ContactSolver::SweepNormal(Contact& contact, double step_size) {
  ContactPoint& point = *contact.point;
  const double softness = Softness(contact, point.normal);
  if (softness == 0) return;
  // A gap may be closed within the step, but no more than that.
  const double allowed = std::min(0.0, point.depth) / step_size - point.bend;
  const double lacking = allowed - SlipOf(contact).dot(point.normal);
  const double impulse = std::max(lacking / softness, -point.normal_impulse);
  point.normal_impulse += impulse;
  Apply(contact, impulse * point.normal, Vector3::Zero());
}

void ContactSolver::SweepFriction(Contact& contact) {
  ContactPoint& point = *contact.point;
  const Vector3 slip = SlipOf(contact) + contact.bend;
  const Vector3 along = slip - slip.dot(point.normal) * point.normal;
  const double speed = along.norm();
  Vector3 wanted = point.friction_impulse;
  if (speed > 0) {
    const double softness = Softness(contact, along / speed);
    if (softness == 0) return;
    wanted -= along / softness;
  }
  wanted = Within(wanted, point.friction * point.normal_impulse);
  const Vector3 change = wanted - point.friction_impulse;
  point.friction_impulse = wanted;
  Apply(contact, change, Vector3::Zero());
}

void ContactSolver::SweepTorques(Contact& contact) {
  const Vector3& normal = contact.point->normal;
  const double load = contact.point->normal_impulse;
  const Vector3 turning = contact.b->motion.spin - contact.a->motion.spin;
  if (contact.material.spinning_friction > 0) {
    const double softness = AngularSoftness(contact, normal);
    if (softness == 0) return;
    const double bound = contact.material.spinning_friction * load;
    const double wanted = std::clamp(contact.spinning - turning.dot(normal) / softness, -bound, bound);
    Apply(contact, Vector3::Zero(), (wanted - contact.spinning) * normal);
    contact.spinning = wanted;
  }
  if (contact.material.rolling_friction > 0) {
    const Vector3 wanted = ResistanceTo(turning - turning.dot(normal) * normal, contact);
    Apply(contact, Vector3::Zero(), wanted - contact.torque);
    contact.torque = wanted;
  }
}

// N*m*s on b. What rolls on for some steps is braked the way it goes in the middle of this one, and not held across.
Vector3 ContactSolver::ResistanceTo(const Vector3& rolling, const Contact& contact) {
  const ContactPoint& point = *contact.point;
  const double most = contact.material.rolling_friction * point.normal_impulse;
  const Vector3 middle = contact.rolling - contact.rolling.dot(point.normal) * point.normal;
  const double speed = middle.norm();
  if (speed > 0) {
    const Vector3 along = middle / speed;
    const double softness = AngularSoftness(contact, along);
    if (speed > kRollsOn * softness * most) {
      return std::clamp(contact.torque.dot(along) - rolling.dot(along) / softness, -most, most) * along;
    }
  }
  const double rate = rolling.norm();
  Vector3 wanted = contact.torque;
  if (rate > 0) wanted -= rolling / AngularSoftness(contact, rolling / rate);
  return Within(wanted, most);
}

void ContactSolver::SweepPush(Contact& contact, double step_size) {
  const ContactPoint& point = *contact.point;
  const double softness = Softness(contact, point.normal);
  if (softness == 0 || point.depth <= 0) return;
  Body& a = *contact.a;
  Body& b = *contact.b;
  const Vector3 leaving =
      b.motion.push + b.motion.turn.cross(contact.arm_b) - a.motion.push - a.motion.turn.cross(contact.arm_a);
  const double lacking = kPushedOut * point.depth / step_size - leaving.dot(point.normal);
  const double impulse = std::max(lacking / softness, -contact.push);
  contact.push += impulse;
  a.motion.push -= impulse * a.inverse_mass * point.normal;
  a.motion.turn -= impulse * a.inverse_tensor * contact.arm_a.cross(point.normal);
  b.motion.push += impulse * b.inverse_mass * point.normal;
  b.motion.turn += impulse * b.inverse_tensor * contact.arm_b.cross(point.normal);
}

void ContactSolver::Solve(double step_size, uint32_t sweeps) {
  for (uint32_t i = 0; i < sweeps; ++i) {
    for (Contact& contact : contacts_) {
      SweepNormal(contact, step_size);
      SweepFriction(contact);
      SweepTorques(contact);
      SweepPush(contact, step_size);
    }
  }
}

}  // namespace genphys::spheres_backend

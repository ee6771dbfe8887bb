#include "row_composer.h"

#include <ode/ode.h>

#include <Eigen/LU>
#include <cmath>

#include "convert.h"

namespace genphys::ode_backend {
namespace {

// m/s: nothing that the model takes comes near this, so that a contact with this target never pushes.
constexpr double kNeverReached = 1e9;
// By how much less than what is to be corrected the second anchor of a ball joint stands off: so little that its lever
// arm stays that of the point, and so much that the digits of a position still tell it.
constexpr double kBallReduction = 1000;
// Axes of a gear that are nearer to one line than this are taken as parallel.
constexpr double kLeastSine = 1e-6;
// kg: nothing of the model moves that.
constexpr double kImmovableMass = 1e30;

Vector3 Perpendicular(const Vector3& axis) {
  dVector3 n, p, q;
  ToOde(axis, n);
  dPlaneSpace(n, p, q);
  return FromOde(p);
}

}  // namespace

struct RowComposer::Weight {
  dxBody* body;
  dMass mass;
};

RowComposer::RowComposer(dxWorld* world, dxJointGroup* joints) : world_(world), joints_(joints) {}

RowComposer::~RowComposer() = default;

void RowComposer::Begin(size_t count, double step_size) {
  step_size_ = step_size;
  // A gear is composed of three joints.
  if (feedback_.size() < 3 * count) feedback_.resize(3 * count);
  feedback_count_ = 0;
  composed_.clear();
}

RowComposer::Told RowComposer::Tell(const Row& row) {
  const double target = row.row->target - row.given_rate;
  if (row.b != nullptr) return {row.b, row.a, row.row->axis, target};
  return {row.a, nullptr, -row.row->axis, target};
}

double RowComposer::ForceOf(double impulse) const {
  return std::isinf(impulse) ? dInfinity : std::abs(impulse) / step_size_;
}

dJointFeedback* RowComposer::Attach(dxJoint* joint, const Told& told) {
  dJointAttach(joint, told.first, told.second);
  dJointFeedback* const feedback = &feedback_[feedback_count_++];
  dJointSetFeedback(joint, feedback);
  return feedback;
}

void RowComposer::Add(std::span<const Row> block) {
  const JointRow& row = *block.front().row;
  if (row.kind == JointRow::Kind::kAngular) return AddAngular(block.front());
  if (row.kind == JointRow::Kind::kGeared) return AddGear(block.front());
  if (row.lower == 0 || row.upper == 0) return AddNormal(block.front());
  if (block.size() == 3) return AddBall(block);
  AddFriction(block);
}

void RowComposer::AddBall(std::span<const Row> block) {
  const JointRow& row = *block.front().row;
  dxJoint* const joint = dJointCreateBall(world_, joints_);
  Attach(joint, Tell(block.front()));
  Vector3 target = Vector3::Zero();
  for (const Row& part : block) {
    const Told told = Tell(part);
    target += told.target * told.axis;
    Note(part, told.axis, true);
  }
  const Vector3 off = row.point + step_size_ / kBallReduction * target;
  dVector3 second;
  ToOde(off, second);
  // The second anchor is told in the frame of its body, or in the world when there is none.
  if (dxBody* const body = Tell(block.front()).second) dBodyGetPosRelPoint(body, off.x(), off.y(), off.z(), second);
  dJointSetBallAnchor(joint, row.point.x(), row.point.y(), row.point.z());
  dJointSetBallAnchor2(joint, second[0], second[1], second[2]);
  dJointSetBallParam(joint, dParamERP, kBallReduction);
  dJointSetBallParam(joint, dParamCFM, row.softness * step_size_);
}

void RowComposer::AddFriction(std::span<const Row> block) {
  const JointRow& row = *block.front().row;
  const Told first = Tell(block.front());
  dContact contact = {};
  contact.surface.mode = dContactMu2 | dContactFDir1 | dContactMotionN | dContactMotion1 | dContactSlip1;
  contact.surface.mu = ForceOf(row.upper);
  contact.surface.motionN = -kNeverReached;
  contact.surface.motion1 = first.target;
  contact.surface.slip1 = row.softness * step_size_;
  ToOde(row.point, contact.geom.pos);
  ToOde(first.axis, contact.fdir1);
  Vector3 normal = Perpendicular(first.axis);
  if (block.size() == 2) {
    const Told second = Tell(block.back());
    // ODE's second direction is the normal cross the first.
    normal = first.axis.cross(second.axis);
    contact.surface.mode |= dContactMotion2 | dContactSlip2;
    contact.surface.mu2 = ForceOf(block.back().row->upper);
    contact.surface.motion2 = second.target;
    contact.surface.slip2 = block.back().row->softness * step_size_;
  }
  ToOde(normal, contact.geom.normal);
  Attach(dJointCreateContact(world_, joints_, &contact), first);
  for (const Row& part : block) Note(part, Tell(part).axis, true);
}

void RowComposer::AddNormal(const Row& part) {
  const JointRow& row = *part.row;
  Told told = Tell(part);
  // A normal only pushes; what may only pull is told the other way round.
  const double sign = row.lower == 0 ? 1 : -1;
  dContact contact = {};
  contact.surface.mode = dContactMotionN | dContactSoftCFM;
  contact.surface.motionN = sign * told.target;
  contact.surface.soft_cfm = row.softness * step_size_;
  ToOde(row.point, contact.geom.pos);
  ToOde(sign * told.axis, contact.geom.normal);
  Attach(dJointCreateContact(world_, joints_, &contact), told);
  Note(part, told.axis, true);
}

void RowComposer::AddAngular(const Row& part) {
  const JointRow& row = *part.row;
  const Told told = Tell(part);
  dxJoint* const joint = dJointCreateAMotor(world_, joints_);
  Attach(joint, told);
  dJointSetAMotorMode(joint, dAMotorUser);
  dJointSetAMotorNumAxes(joint, 1);
  const bool is_one_sided = row.lower == 0 || row.upper == 0;
  // A stop only holds back from below; what may only pull is told the other way round.
  const double sign = row.upper == 0 ? -1 : 1;
  const Vector3 axis = sign * told.axis;
  dJointSetAMotorAxis(joint, 0, 0, axis.x(), axis.y(), axis.z());
  if (is_one_sided) {
    // The stop is behind by as much as the target asks for, and takes that away at once. Where the target lets the stop
    // be reached first, the error is the same and taken the other way.
    const double target = sign * told.target;
    dJointSetAMotorAngle(joint, 0, -std::abs(target));
    dJointSetAMotorParam(joint, dParamLoStop, 0);
    dJointSetAMotorParam(joint, dParamHiStop, dInfinity);
    dJointSetAMotorParam(joint, dParamStopERP, std::copysign(step_size_, target));
    dJointSetAMotorParam(joint, dParamStopCFM, row.softness * step_size_);
    dJointSetAMotorParam(joint, dParamBounce, 0);
  } else {
    dJointSetAMotorParam(joint, dParamVel, told.target);
    dJointSetAMotorParam(joint, dParamFMax, ForceOf(row.upper));
    dJointSetAMotorParam(joint, dParamCFM, row.softness * step_size_);
  }
  Note(part, told.axis, false);
}

// No joint of ODE turns two bodies about different axes or by different amounts. Each side therefore lends half of its
// moment about its axis to a shaft: a body of its own, too heavy to be moved and locked to the side about that axis, so
// that both together turn as the side alone would. The rims of both shafts touch where a rate along a line is the rate
// of the gear: that line is a row which ODE has.
void RowComposer::AddGear(const Row& part) {
  const JointRow& row = *part.row;
  const double target = row.target - part.given_rate;
  if (part.a == nullptr || part.b == nullptr) {
    const Vector3& axis = part.b != nullptr ? row.axis_b : row.axis;
    const double length = axis.norm();
    dxJoint* const joint = dJointCreateAMotor(world_, joints_);
    Attach(joint, {part.b != nullptr ? part.b : part.a, nullptr, axis / length, target / length});
    dJointSetAMotorMode(joint, dAMotorUser);
    dJointSetAMotorNumAxes(joint, 1);
    dJointSetAMotorAxis(joint, 0, 0, axis.x() / length, axis.y() / length, axis.z() / length);
    dJointSetAMotorParam(joint, dParamVel, target / length);
    dJointSetAMotorParam(joint, dParamFMax, dInfinity);
    dJointSetAMotorParam(joint, dParamCFM, row.softness / (length * length) * step_size_);
    composed_.push_back({part.row, axis / length, feedback_count_ - 1, false, 1 / length});
    return;
  }
  const Vector3 across = row.axis.cross(row.axis_b);
  const double sine = across.norm() / (row.axis.norm() * row.axis_b.norm());
  const Vector3 line = sine > kLeastSine ? Vector3(across.normalized()) : Perpendicular(row.axis_b.normalized());
  // A push along the line at the origin turns a body whose centre is there about its axis, as much as the row says.
  dxBody* const shaft_b = AddShaft(part.b, row.axis_b.normalized(), -line.cross(row.axis_b));
  dxBody* const shaft_a = AddShaft(part.a, row.axis.normalized(), line.cross(row.axis));
  JointRow rim = row;
  rim.kind = JointRow::Kind::kLinear;
  rim.axis = line;
  rim.point = Vector3::Zero();
  rim.target = target;
  const Row between{shaft_a, shaft_b, &rim, 0};
  AddFriction({&between, 1});
  composed_.back().row = part.row;
}

dxBody* RowComposer::AddShaft(dxBody* body, const Vector3& axis, const Vector3& center) {
  if (shaft_count_ == shafts_.size()) {
    shafts_.push_back(dBodyCreate(world_));
    dBodySetGyroscopicMode(shafts_.back(), 0);
  }
  dxBody* const shaft = shafts_[shaft_count_++];
  dBodyEnable(shaft);
  dMass mass;
  dBodyGetMass(body, &mass);
  weights_.push_back({body, mass});
  const Vector3 own =
      Eigen::Map<const Eigen::Matrix<dReal, 3, 4, Eigen::RowMajor>>(dBodyGetRotation(body)).leftCols<3>().transpose() *
      axis;
  Eigen::Map<Eigen::Matrix<dReal, 3, 4, Eigen::RowMajor>> tensor(mass.I);
  const double moment = 0.5 / own.dot(tensor.leftCols<3>().inverse() * own);
  tensor.leftCols<3>() -= moment * own * own.transpose();
  dBodySetMass(body, &mass);
  dMass shaft_mass;
  dMassSetParameters(&shaft_mass, kImmovableMass, 0, 0, 0, moment, moment, moment, 0, 0, 0);
  dBodySetMass(shaft, &shaft_mass);
  const Vector3 spin = axis * axis.dot(FromOde(dBodyGetAngularVel(body)));
  dBodySetPosition(shaft, center.x(), center.y(), center.z());
  SetUpright(shaft);
  dBodySetLinearVel(shaft, 0, 0, 0);
  dBodySetAngularVel(shaft, spin.x(), spin.y(), spin.z());

  dxJoint* const lock = dJointCreateAMotor(world_, joints_);
  Attach(lock, {body, shaft, axis, 0});
  dJointSetAMotorMode(lock, dAMotorUser);
  dJointSetAMotorNumAxes(lock, 1);
  dJointSetAMotorAxis(lock, 0, 0, axis.x(), axis.y(), axis.z());
  dJointSetAMotorParam(lock, dParamVel, 0);
  dJointSetAMotorParam(lock, dParamFMax, dInfinity);
  return shaft;
}

void RowComposer::TakeImpulses() {
  for (const Composed& composed : composed_) {
    const dJointFeedback& feedback = feedback_[composed.feedback];
    composed.row->impulse =
        composed.scale * step_size_ * composed.axis.dot(FromOde(composed.is_push ? feedback.f1 : feedback.t1));
  }
  ReturnWeights();
}

void RowComposer::ReturnWeights() {
  // In the order back, for a body may have lent more than once.
  for (; !weights_.empty(); weights_.pop_back()) dBodySetMass(weights_.back().body, &weights_.back().mass);
  for (; shaft_count_ > 0; --shaft_count_) dBodyDisable(shafts_[shaft_count_ - 1]);
}

void RowComposer::DropShafts() {
  ReturnWeights();
  for (dxBody* const shaft : shafts_) dBodyDestroy(shaft);
  shafts_.clear();
}

}  // namespace genphys::ode_backend

#include "exact_solver.h"

#include <ode/ode.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "contact_surface.h"
#include "convert.h"
#include "genphys/backend.h"
#include "library.h"

namespace genphys::ode_backend {
namespace {

// Softness of a contact, of the inverse of the masses that it moves: the solver divides by what redundant contacts
// leave over.
constexpr double kSoftness = 1e-4;
// It eliminates one contact after the other. Where a feather meets a mountain too little is left of the sixteen digits
// of a number, and it fails; sweeps only come nearer the solution more slowly. Contacts alone bear more than joints do,
// which are not soft.
constexpr double kSpreadMax = 1e9;
constexpr double kSpreadMaxJointed = 1e6;
// kg and kg*m^2: nothing of the model moves that.
constexpr double kImmovableMass = 1e30;
// What is so many times as fast as friction at one of its points slows it down in a step slides on for some steps.
constexpr double kSlides = 4;
// The same of what hangs together with joints, which may press it far more than in the last step.
constexpr double kSlidesJointed = 16;

// The bits as they are: the library's setter would normalise, and its own results must pass through unchanged. Its
// getters give the place where it keeps them.
void SetOrientation(dBodyID body, const Quaternion& orientation) {
  const dQuaternion q = {orientation.w(), orientation.x(), orientation.y(), orientation.z()};
  dMatrix3 rotation;
  dQtoR(q, rotation);
  std::memcpy(const_cast<dReal*>(dBodyGetQuaternion(body)), q, sizeof(dQuaternion));
  std::memcpy(const_cast<dReal*>(dBodyGetRotation(body)), rotation, sizeof(dMatrix3));
}

void SetMass(dBodyID body, const MassProperties& mass) {
  const Matrix3& t = mass.tensor;
  dMass ode_mass;
  dMassSetParameters(&ode_mass, mass.mass, 0, 0, 0, t(0, 0), t(1, 1), t(2, 2), t(0, 1), t(0, 2), t(1, 2));
  dBodySetMass(body, &ode_mass);
}

// The mean of the inverse moments, 1/(kg*m^2).
double Turnability(const MassProperties& mass) { return mass.inverse_tensor.trace() / 3; }

}  // namespace

ExactSolver::ExactSolver()
    // With none of its own, a world queues its work in one that the whole process shares without a lock.
    : threading_(dThreadingAllocateSelfThreadedImplementation()),
      world_(dWorldCreate()),
      contacts_(dJointGroupCreate(0)),
      composer_(world_, contacts_) {
  dWorldSetStepThreadingImplementation(world_, dThreadingImplementationGetFunctions(threading_), threading_);
  dWorldSetGravity(world_, 0, 0, 0);
  dWorldSetAutoDisableFlag(world_, 0);
  dWorldSetDamping(world_, 0, 0);
  dWorldSetERP(world_, kErrorReduction);
  dWorldSetContactSurfaceLayer(world_, kSurfaceLayer);
}

ExactSolver::~ExactSolver() {
  dJointGroupDestroy(contacts_);
  dWorldDestroy(world_);
  if (is_faulted_) {
    Abandon(threading_);
  } else {
    dThreadingFreeImplementation(threading_);
  }
}

// Spare bodies cost a little in every step, and more when they are created anew: as many are kept as are in use. A
// group keeps the memory of the most joints that it ever had and walks through it whenever it is emptied: one that has
// become too large is made anew.
void ExactSolver::Trim(uint32_t count) {
  constexpr size_t kSpareBodiesMin = 64;
  constexpr size_t kSpareJointsMin = 1024;
  EmptyGroup();
  if (bodies_.size() > 2 * size_t{count} + kSpareBodiesMin) Shrink(count);
  if (most_joints_ > 4 * recent_joints_ + kSpareJointsMin) {
    dJointGroupDestroy(contacts_);
    contacts_ = dJointGroupCreate(0);
    composer_.SetGroup(contacts_);
    most_joints_ = 0;
  }
  recent_joints_ = 0;
}

void ExactSolver::Begin(uint32_t count, double step_size, double pull) {
  pull_ = pull;
  Rewind();
  lines_.Begin();
  step_size_ = step_size;
  if (count > bodies_.size()) Grow(count);
  for (; body_count_ < count; ++body_count_) dBodyEnable(bodies_[body_count_]);
  for (; body_count_ > count; --body_count_) dBodyDisable(bodies_[body_count_ - 1]);
}

void ExactSolver::Rewind() {
  EmptyGroup();
  composer_.ReturnWeights();
  torsion_softness_ = 0;
  // New joints start from the softness of the world.
  dWorldSetCFM(world_, 0);
  for (; turner_count_ > 0; --turner_count_) dBodyDisable(turners_[turner_count_ - 1]);
}

void ExactSolver::EmptyGroup() {
  const size_t joints = contact_count_ + row_count_;
  most_joints_ = std::max(most_joints_, joints);
  recent_joints_ = std::max(recent_joints_, joints);
  dJointGroupEmpty(contacts_);
  contact_count_ = 0;
  row_count_ = 0;
}

void ExactSolver::Grow(uint32_t count) {
  // ODE goes through its bodies from the last created to the first. Those that only stand for sides stay the last, or
  // what is left over by a solve would depend on how many bodies there were before.
  composer_.DropShafts();
  for (dxBody* const turner : turners_) dBodyDestroy(turner);
  turners_.clear();
  while (bodies_.size() < count) {
    dBodyID body = dBodyCreate(world_);
    // What the velocity says is what the body turns, by the exponential map; the layer owns the gyroscopic terms.
    dBodySetFiniteRotationMode(body, 1);
    dBodySetGyroscopicMode(body, 0);
    dBodyDisable(body);
    bodies_.push_back(body);
    masses_.emplace_back();
  }
}

void ExactSolver::Shrink(uint32_t count) {
  while (bodies_.size() > count) {
    dBodyDestroy(bodies_.back());
    bodies_.pop_back();
    masses_.pop_back();
  }
  body_count_ = std::min(body_count_, count);
}

void ExactSolver::SetBody(uint32_t body, const MassProperties& mass, const Motion& motion) {
  dBodyID id = bodies_[body];
  // The library inverts the tensor each time, and who is solved as which body changes with every one that comes or
  // goes.
  if (masses_[body].mass != mass.mass || masses_[body].tensor != mass.tensor) {
    masses_[body] = {};
    SetMass(id, mass);
    masses_[body] = mass;
  }
  const Vector3& p = motion.position;
  const Vector3& v = motion.linear_velocity;
  const Vector3& w = motion.angular_velocity;
  dBodySetPosition(id, p.x(), p.y(), p.z());
  SetOrientation(id, motion.orientation);
  dBodySetLinearVel(id, v.x(), v.y(), v.z());
  dBodySetAngularVel(id, w.x(), w.y(), w.z());
}

bool ExactSolver::MaySolve(bool is_jointed, double spread) {
  return spread <= (is_jointed ? kSpreadMaxJointed : kSpreadMax);
}

void ExactSolver::Reserve(size_t contacts, size_t rows) {
  if (feedback_.size() < contacts) feedback_.resize(contacts);
  composer_.Begin(rows, step_size_);
}

void ExactSolver::AddRows(std::span<JointRow> block, uint32_t body_a, uint32_t body_b,
                          std::span<const double> given_rates) {
  const auto body = [&](uint32_t index) { return index == ContactConstraint::kImmovable ? nullptr : bodies_[index]; };
  std::array<RowComposer::Row, 3> rows;
  for (size_t i = 0; i < block.size(); ++i) {
    rows[i] = {body(body_a), body(body_b), &block[i], given_rates[i]};
  }
  composer_.Add(std::span(rows).first(block.size()));
  row_count_ += block.size();
}

void ExactSolver::AddContact(const ContactConstraint& contact) {
  dContact ode_contact = {};
  ode_contact.surface.mode = dContactApprox1;
  ToOde(contact.position, ode_contact.geom.pos);
  ToOde(contact.normal, ode_contact.geom.normal);
  ode_contact.surface.motionN = -contact.bend;
  if (contact.depth < 0) {
    // A gap may be closed within the step, but no more than that.
    ode_contact.surface.motionN += contact.depth / step_size_;
  } else {
    SetDepth(contact, step_size_, ode_contact);
  }
  SetSoftness(Softness(contact), ode_contact);
  Untie(contact_count_, ode_contact);
  const bool resists_turning = contact.rolling_friction > 0 || contact.spinning_friction > 0;
  const double soon = std::max(InverseMass(contact) * contact.grip, pull_ * contact.friction * step_size_);
  SetFriction(contact, SlipOf(contact), (contact.is_jointed ? kSlidesJointed : kSlides) * soon, step_size_,
              ode_contact);
  if (resists_turning) SetTorsion(contact, ode_contact);
  dBodyID body = bodies_[contact.body], other = OtherBody(contact);
  lines_.Turn(contact, body, contact.other == ContactConstraint::kImmovable ? nullptr : other,
              Softness(contact) / step_size_, step_size_, ode_contact);
  SetOtherVelocity(contact, ode_contact);
  dJointID joint = dJointCreateContact(world_, contacts_, &ode_contact);
  dJointAttach(joint, body, other);
  dJointSetFeedback(joint, &feedback_[contact_count_++]);
}

void ExactSolver::SetTorsion(const ContactConstraint& contact, dContact& to) {
  double turnability = Turnability(masses_[contact.body]);
  if (contact.other != ContactConstraint::kImmovable) turnability += Turnability(masses_[contact.other]);
  const double load = std::max(contact.load, pull_ * step_size_ / InverseMass(contact));
  TurnToRolling(contact, kSlides * turnability * contact.rolling_friction * load, step_size_, to);
  to.surface.mode |= dContactRolling | dContactAxisDep;
  to.surface.mu2 = to.surface.mu;
  to.surface.rhoN = std::max(contact.spinning_friction, kLeastArm);
  // ODE has one softness for all of these rows in the world: that of the one which is hardest to turn.
  const double softness = kSoftness * step_size_ * turnability;
  torsion_softness_ = torsion_softness_ > 0 ? std::min(torsion_softness_, softness) : softness;
}

dxBody* ExactSolver::OtherBody(const ContactConstraint& contact) {
  if (contact.other != ContactConstraint::kImmovable) return bodies_[contact.other];
  const bool is_turned = contact.rolling_friction > 0 || contact.spinning_friction > 0;
  if (!is_turned || contact.other_spin.isZero(0)) return nullptr;
  if (turner_count_ == turners_.size()) {
    turners_.push_back(dBodyCreate(world_));
    dBodySetGyroscopicMode(turners_.back(), 0);
    dMass mass;
    dMassSetParameters(&mass, kImmovableMass, 0, 0, 0, kImmovableMass, kImmovableMass, kImmovableMass, 0, 0, 0);
    dBodySetMass(turners_.back(), &mass);
  }
  dBodyID turner = turners_[turner_count_++];
  dBodyEnable(turner);
  dBodySetPosition(turner, contact.position.x(), contact.position.y(), contact.position.z());
  SetUpright(turner);
  dBodySetLinearVel(turner, 0, 0, 0);
  dBodySetAngularVel(turner, contact.other_spin.x(), contact.other_spin.y(), contact.other_spin.z());
  return turner;
}

double ExactSolver::InverseMass(const ContactConstraint& contact) const {
  const double inverse_mass = 1 / masses_[contact.body].mass;
  return contact.other == ContactConstraint::kImmovable ? inverse_mass : inverse_mass + 1 / masses_[contact.other].mass;
}

double ExactSolver::Softness(const ContactConstraint& contact) const {
  return contact.softness * kSoftness * step_size_ * InverseMass(contact);
}

void ExactSolver::Step() {
  is_faulted_ = true;
  dWorldSetCFM(world_, torsion_softness_);
  if (dWorldStep(world_, step_size_) == 0) throw EngineFault("ODE: not enough memory for a step");
  is_faulted_ = false;
}

bool ExactSolver::IsToBeSolvedAnew(bool failed) {
  const bool is_to_be = failed ? lines_.GoBack() : lines_.Follow(feedback_, step_size_);
  if (is_to_be) Rewind();
  return is_to_be;
}

Motion ExactSolver::motion(uint32_t body) const {
  dBodyID id = bodies_[body];
  const dReal* q = dBodyGetQuaternion(id);
  return {FromOde(dBodyGetPosition(id)), Quaternion(q[0], q[1], q[2], q[3]), FromOde(dBodyGetLinearVel(id)),
          FromOde(dBodyGetAngularVel(id))};
}

Vector3 ExactSolver::Impulse(size_t contact) const { return step_size_ * FromOde(feedback_[contact].f1); }

}  // namespace genphys::ode_backend

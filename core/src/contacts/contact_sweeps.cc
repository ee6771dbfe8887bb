#include "genphys/contact_sweeps.h"

#include <cmath>

#include "contacts/sweeps.h"

namespace genphys {
namespace {

// Turn by a constant angular velocity, exact however fast.
Quaternion TurnBy(const Vector3& turn) {
  const double angle = turn.norm();
  // At smaller angles the quotient is a half to the last bit, and at zero it is undefined.
  const double scale = angle > 1e-8 ? std::sin(angle / 2) / angle : 0.5;
  return {std::cos(angle / 2), scale * turn.x(), scale * turn.y(), scale * turn.z()};
}

}  // namespace

Pose MovedBy(const SweptBody& body, double step_size, const Vector3& center_of_mass, const Pose& pose) {
  Pose moved = pose;
  for (const Vector3& velocity : {body.angular_velocity, body.turn}) {
    const Vector3 turn = step_size * velocity;
    if (!turn.isZero(0)) moved.orientation = (TurnBy(turn) * moved.orientation).normalized();
  }
  moved.position += step_size * (body.linear_velocity + body.push);
  if (!center_of_mass.isZero(0)) {
    moved.position += pose.orientation * center_of_mass - moved.orientation * center_of_mass;
  }
  return moved;
}

ContactSweeps::ContactSweeps() : impl_(std::make_unique<Impl>()) {}

ContactSweeps::~ContactSweeps() = default;

void ContactSweeps::SetIterations(uint32_t iterations, bool may_go_on) { impl_->SetIterations(iterations, may_go_on); }

void ContactSweeps::Begin(double step_size, double pull, bool are_few) { impl_->Begin(step_size, pull, are_few); }

uint32_t ContactSweeps::AddBody(const SweptBody& body) { return impl_->AddBody(body); }

void ContactSweeps::AddPair(uint32_t a, uint32_t b, const ContactPair& pair, std::span<ContactPoint> points,
                            std::span<PointImpulse> impulses) {
  impl_->AddPair({a, b, &pair, points, impulses});
}

void ContactSweeps::AddRow(uint32_t a, uint32_t b, JointRow& row) { impl_->AddRow(a, b, row); }

void ContactSweeps::Solve() { impl_->Solve(); }

bool ContactSweeps::SolveDirectly(BoundedSolver* bounded, bool may_sweep) {
  return impl_->SolveDirectly(bounded, may_sweep);
}

const SweptBody& ContactSweeps::body(uint32_t number) const { return impl_->body(number); }

}  // namespace genphys

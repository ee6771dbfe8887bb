#include "impact_solve.h"

#include <algorithm>
#include <cmath>

namespace genphys {
namespace {

constexpr int kSweepsMax = 100;
// m/s: the sweeps end once no blow changed a velocity by more.
constexpr double kSettled = 1e-12;

double Softness(const StruckBody& body, const Vector3& point, const Vector3& axis) {
  const Vector3 turn = (point - body.center).cross(axis);
  return body.inverse_mass * axis.dot(body.freedom.cwiseProduct(axis)) + turn.dot(body.inverse_tensor * turn);
}

// One blow against its two bodies.
class Settling {
 public:
  Settling(Blow& blow, std::span<StruckBody> bodies) : blow_(blow), a_(bodies[blow.body_a]), b_(bodies[blow.body_b]) {}

  // Each returns by how much (m/s) a velocity had to be changed.
  double Separate() {
    const double softness = SoftnessAlong(blow_.normal);
    if (!(softness > 0)) return 0;
    const double lacking = blow_.separation_speed - Relative().dot(blow_.normal);
    const double impulse = std::max(lacking / softness, -blow_.impulse);
    blow_.impulse += impulse;
    Push(impulse * blow_.normal);
    return std::abs(impulse) * softness;
  }

  double Rub() {
    if (!(blow_.friction > 0)) return 0;
    const Vector3 relative = Relative();
    const Vector3 slip = relative - relative.dot(blow_.normal) * blow_.normal;
    const double speed = slip.norm();
    Vector3 wanted = blow_.rubbing;
    double softness = 0;
    if (speed > 0) {
      softness = SoftnessAlong(slip / speed);
      if (softness > 0) wanted -= slip / softness;
    }
    const double bound = blow_.friction * blow_.impulse, size = wanted.norm();
    if (size > bound) wanted *= bound / size;
    const Vector3 impulse = wanted - blow_.rubbing;
    blow_.rubbing = wanted;
    Push(impulse);
    return impulse.norm() * softness;
  }

 private:
  Vector3 Relative() const { return b_.VelocityAt(blow_.position) - a_.VelocityAt(blow_.position); }
  double SoftnessAlong(const Vector3& axis) const {
    return Softness(a_, blow_.position, axis) + Softness(b_, blow_.position, axis);
  }
  void Push(const Vector3& impulse) {
    a_.Push(-impulse, blow_.position);
    b_.Push(impulse, blow_.position);
  }

  Blow& blow_;
  StruckBody& a_;
  StruckBody& b_;
};

}  // namespace

Vector3 RelativeVelocity(const Blow& blow, std::span<const StruckBody> bodies) {
  return bodies[blow.body_b].VelocityAt(blow.position) - bodies[blow.body_a].VelocityAt(blow.position);
}

double KineticEnergy(std::span<const StruckBody> bodies) {
  double sum = 0;
  for (const StruckBody& body : bodies) {
    if (body.inverse_mass == 0) continue;
    sum += body.linear_velocity.squaredNorm() / body.inverse_mass +
           body.angular_velocity.dot(body.tensor * body.angular_velocity);
  }
  return sum / 2;
}

void SolveBlows(std::span<Blow> blows, std::span<StruckBody> bodies) {
  for (int sweep = 0; sweep < kSweepsMax; ++sweep) {
    double largest = 0;
    for (Blow& blow : blows) {
      Settling settling(blow, bodies);
      largest = std::max({largest, settling.Separate(), settling.Rub()});
    }
    if (largest <= kSettled) return;
  }
}

}  // namespace genphys

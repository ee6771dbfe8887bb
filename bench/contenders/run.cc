#include "run.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace genphys::bench {

double JointGap(const Simulation& simulation, const Scene& scene) {
  double gap = 0;
  for (const JointDesc& joint : scene.joints) {
    if (!std::holds_alternative<BallJoint>(joint.kind) && !std::holds_alternative<HingeJoint>(joint.kind)) continue;
    const auto end = [&](const EntityRef& ref, const Vector3& point) {
      const std::optional<size_t> place = PlaceOf(ref);
      if (!place) return point;
      const Motion motion = simulation.MotionOf(*place);
      return Vector3(motion.position + motion.orientation * point);
    };
    gap = std::max(
        gap,
        (end(joint.entity_a, joint.frame_in_a->position) - end(joint.entity_b, joint.frame_in_b->position)).norm());
  }
  return gap;
}

Run::Run(std::unique_ptr<Simulation> simulation, const Scene& scene, double step_size, StepPlan plan)
    : simulation_(std::move(simulation)), scene_(scene), step_size_(step_size), plan_(plan) {
  for (const EntityDesc& body : scene.bodies) {
    const bool moves = body.rigid_body->motion_type == MotionType::kDynamic;
    masses_.push_back(moves ? MassOf(body) : MassProperties{});
  }
}

double Run::NextStep(double left) {
  if (plan_ == StepPlan::kEven) return step_size_;
  const double step = step_size_ * (0.5 + static_cast<double>(generator_()) / static_cast<double>(std::mt19937::max()));
  // The last step takes what is left, and no step is much smaller than the others.
  return left < step + step_size_ / 2 ? left : step;
}

void Run::StepTo(double time, const std::function<void()>& after_each) {
  const double begin = time_;
  for (int64_t count = 1;; ++count) {
    const double left = time - time_;
    if (left < step_size_ * 1e-6) break;
    const double step = NextStep(left);
    simulation_->Step(step);
    // Not summed up where the sum is known.
    time_ = plan_ == StepPlan::kEven ? begin + static_cast<double>(count) * step_size_ : time_ + step;
    if (after_each) after_each();
  }
}

double Run::KineticEnergy() const {
  double energy = 0;
  for (size_t i = 0; i < masses_.size(); ++i) {
    if (masses_[i].mass == 0) continue;
    const Motion motion = (*this)[i];
    const Vector3 spin = motion.orientation.conjugate() * motion.spin;
    energy += (masses_[i].mass * motion.velocity.squaredNorm() + spin.dot(masses_[i].tensor * spin)) / 2;
  }
  return energy;
}

double Run::Energy() const {
  double energy = KineticEnergy();
  for (size_t i = 0; i < masses_.size(); ++i) {
    if (masses_[i].mass > 0) energy -= masses_[i].mass * scene_.gravity.dot((*this)[i].position);
  }
  return energy;
}

Vector3 Run::Momentum() const {
  Vector3 sum = Vector3::Zero();
  for (size_t i = 0; i < masses_.size(); ++i) {
    if (masses_[i].mass > 0) sum += masses_[i].mass * (*this)[i].velocity;
  }
  return sum;
}

Vector3 Run::AngularMomentum() const {
  Vector3 sum = Vector3::Zero();
  for (size_t i = 0; i < masses_.size(); ++i) {
    if (masses_[i].mass == 0) continue;
    const Motion motion = (*this)[i];
    const Matrix3 turn = motion.orientation.toRotationMatrix();
    sum += masses_[i].mass * motion.position.cross(motion.velocity) +
           turn * masses_[i].tensor * turn.transpose() * motion.spin;
  }
  return sum;
}

}  // namespace genphys::bench

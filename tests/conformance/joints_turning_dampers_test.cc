// Dampers of joints whose axes turn in space.
#include <Eigen/LU>
#include <cmath>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsTurningDampers);

constexpr double kDamping = 0.3;  // N*m*s
constexpr double kTime = 0.5;     // s

// Two bodies on a hinge through both their centres of mass, and nothing else: b turns by `angle` about z of a.
struct Pair {
  Quaternion turn_a = Quaternion::Identity();
  Vector3 spin_a{2, -5, 3};  // rad/s
  double angle = 0;          // rad
  double rate = 4;           // rad/s
};

const Vector3 kTensorA(0.3, 0.9, 0.7), kTensorB(0.8, 0.2, 0.6);  // kg*m^2

struct Change {
  Vector3 spin_a = Vector3::Zero();  // rad/s^2
  double rate = 0;
};

Matrix3 Turned(const Vector3& tensor, const Quaternion& by) {
  const Matrix3 axes = by.toRotationMatrix();
  return axes * tensor.asDiagonal() * axes.transpose();
}

// Of Newton and Euler: nothing turns the two together, and the damper alone turns b about the hinge.
Change ChangeOf(const Pair& pair) {
  const Vector3 axis = pair.turn_a * Vector3::UnitZ();
  const Matrix3 a = Turned(kTensorA, pair.turn_a);
  const Matrix3 b = Turned(kTensorB, pair.turn_a * Quaternion(Eigen::AngleAxisd(pair.angle, Vector3::UnitZ())));
  const Vector3 spin_b = pair.spin_a + pair.rate * axis;
  // Of b, if neither spin of a nor rate changed.
  const Vector3 of_b = b * pair.spin_a.cross(pair.rate * axis) + spin_b.cross(b * spin_b);
  Eigen::Matrix4d matrix;
  matrix << a + b, b * axis, axis.transpose() * b, axis.dot(b * axis);
  Eigen::Vector4d wanted;
  wanted << -of_b - pair.spin_a.cross(a * pair.spin_a), -kDamping * pair.rate - axis.dot(of_b);
  const Eigen::Vector4d found = matrix.fullPivLu().solve(wanted);
  return {found.head<3>(), found[3]};
}

Pair Gone(const Pair& pair, const Pair& going, const Change& change, double time) {
  Quaternion spun(0, going.spin_a.x(), going.spin_a.y(), going.spin_a.z());
  Pair gone = pair;
  gone.turn_a.coeffs() += time / 2 * (spun * going.turn_a).coeffs();
  gone.turn_a.normalize();
  gone.spin_a += time * change.spin_a;
  gone.angle += time * going.rate;
  gone.rate += time * change.rate;
  return gone;
}

// By the midpoint rule, in parts of which so many are right to 1e-8.
Pair Course() {
  constexpr int kParts = 20000;
  Pair pair;
  const double h = kTime / kParts;
  for (int i = 0; i < kParts; ++i) {
    const Pair middle = Gone(pair, pair, ChangeOf(pair), h / 2);
    pair = Gone(pair, middle, ChangeOf(middle), h);
  }
  return pair;
}

EntityDesc Wheel(const Vector3& tensor, const Vector3& spin) {
  EntityDesc desc = Ball({0, 0, 0}, 0.1);
  desc.rigid_body->inertia.tensor = Matrix3(tensor.asDiagonal());
  desc.rigid_body->angular_velocity = spin;
  return desc;
}

TEST_P(JointsTurningDampers, TakeWhatTheyTakeInSpaceAsWell) {
  Proves({Claim::kJointHinge, Claim::kJointSpring});
  const Pair begin, end = Course();
  for (const int rate : {120, 240, 480, 960}) {
    StepperDesc stepper;
    stepper.step_size = 1.0 / rate;
    const auto world = MakeSpace(GetParam(), stepper, Vector3::Zero());
    const EntityId a = Add(*world, Wheel(kTensorA, begin.spin_a));
    const EntityId b = Add(*world, Wheel(kTensorB, begin.spin_a + begin.rate * Vector3::UnitZ()));
    HingeJoint hinge;
    hinge.axis.spring = Spring{.stiffness = 0, .damping = kDamping};
    const JointId joint = Join(*world, Between(a, b, hinge));
    Steps(*world, static_cast<int>(std::lround(kTime * rate)));
    const double turned = FromColumn(world->state().orientations.col(a.index())).angularDistance(end.turn_a);
    EXPECT_LT(turned, 8.0 / (rate * rate)) << rate << " steps per second";
    EXPECT_NEAR(StateOf(*world, joint).positions[5], end.angle, 8.0 / (rate * rate)) << rate << " steps per second";
  }
}

}  // namespace
}  // namespace genphys::testing

// What comes to the limit of a joint while it carries something by a further one: the blow goes through both, and what
// is carried swings on about a point that is stopped. Of second order, like all that joints hold.
#include <algorithm>
#include <cmath>
#include <functional>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsLimitsCarrying, Claim::kJointHinge, Claim::kJointLimit);

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

constexpr double kGravity = 9.81, kHalf = 0.05, kTime = 0.4;

/// Two coordinates, the first of which has an upper limit: mass(q) q'' = force(q, q').
struct System {
  std::function<Matrix2(const Vector2&)> mass;
  std::function<Vector2(const Vector2&, const Vector2&)> force;
};

struct Course {
  Vector2 place, rate;
  bool is_pressed = false;  // against the limit

  Vector2 Acceleration(const System& system) const {
    const Matrix2 mass = system.mass(place);
    const Vector2 force = system.force(place, rate);
    return is_pressed ? Vector2(0, force[1] / mass(1, 1)) : Vector2(mass.inverse() * force);
  }

  // Runge-Kutta, of fourth order.
  Course After(const System& system, double h) const {
    const auto at = [&](double time, const Course& slope) {
      return Course{place + time * slope.rate, rate + time * slope.Acceleration(system), is_pressed};
    };
    const Course b = at(h / 2, *this), c = at(h / 2, b), d = at(h, c);
    return {place + h / 6 * (rate + 2 * b.rate + 2 * c.rate + d.rate),
            rate + h / 6 *
                       (Acceleration(system) + 2 * b.Acceleration(system) + 2 * c.Acceleration(system) +
                        d.Acceleration(system)),
            is_pressed};
  }

  void Strike(const System& system) {
    const Vector2 along = system.mass(place).inverse().col(0);
    rate -= rate[0] / along[0] * along;
    is_pressed = Acceleration(system)[0] > 0;
  }

  // Whether what presses it would have to pull.
  bool IsLetGo(const System& system) const {
    return is_pressed && system.mass(place).row(0).dot(Acceleration(system)) > system.force(place, rate)[0];
  }
};

Course Integrated(const System& system, Course course, double limit) {
  constexpr double kStep = 1e-4;
  for (double left = kTime; left > 1e-12;) {
    double step = std::min(kStep, left);
    if (course.IsLetGo(system)) course.is_pressed = false;
    Course next = course.After(system, step);
    if (!course.is_pressed && next.place[0] > limit) {
      double before = 0, after = step;
      while (after - before > 1e-15) {
        const double middle = (before + after) / 2;
        (course.After(system, middle).place[0] > limit ? after : before) = middle;
      }
      step = after;
      next = course.After(system, step);
      next.Strike(system);
      // It leaves from there, or stays.
      next.place[0] = limit;
    }
    course = next;
    left -= step;
  }
  return course;
}

/// A rod that hangs from `top` at `angle`, and turns.
struct Rod {
  double mass, length;

  double moment() const { return mass / 12 * (length * length + 4 * kHalf * kHalf) + mass * length * length / 4; }
  static Vector2 Along(double angle) { return {std::sin(angle), -std::cos(angle)}; }
  static Vector2 Ahead(double angle) { return {std::cos(angle), std::sin(angle)}; }

  EntityDesc Hung(const Vector2& top, const Vector2& velocity, double angle, double rate) const {
    const Vector2 center = top + length / 2 * Along(angle), moves = velocity + length / 2 * rate * Ahead(angle);
    EntityDesc rod = Body(Box{{kHalf, kHalf, length / 2}}, {center.x(), 0, center.y()}, mass);
    rod.pose.orientation = Quaternion(Eigen::AngleAxisd(-angle, Vector3::UnitY()));
    rod.rigid_body->linear_velocity = {moves.x(), 0, moves.y()};
    rod.rigid_body->angular_velocity = {0, -rate, 0};
    return rod;
  }
};

constexpr Rod kUpper{2, 0.5}, kLower{1.5, 0.4};

/// A hinge that counts angles as Rod does.
Pose HingeAt(const Vector2& place) {
  return {{place.x(), 0, place.y()}, Quaternion(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()))};
}

// Where the rod is that hangs at the end of what comes to a limit, and where it should be.
struct Ends {
  Vector2 found, exact;
};

Ends Pendulum(World& world, const Course& start, double way) {
  const double lever = kLower.length / 2, both = kLower.mass * kUpper.length * lever;
  const System system{.mass = [=](const Vector2& q) -> Matrix2 {
                        const double across = both * std::cos(q[0] - q[1]);
                        return Matrix2{{kUpper.moment() + kLower.mass * kUpper.length * kUpper.length, across},
                                       {across, kLower.moment()}};
                      },
                      .force = [=](const Vector2& q, const Vector2& v) -> Vector2 {
                        const double round = both * std::sin(q[0] - q[1]);
                        const double weight = (kUpper.mass / 2 + kLower.mass) * kUpper.length * kGravity;
                        return {-round * v[1] * v[1] - weight * std::sin(q[0]),
                                round * v[0] * v[0] - kLower.mass * lever * kGravity * std::sin(q[1])};
                      }};
  const Vector2 elbow = kUpper.length * Rod::Along(start.place[0]);
  const EntityId upper = Add(world, kUpper.Hung(Vector2::Zero(), Vector2::Zero(), start.place[0], start.rate[0]));
  const Vector2 moves = kUpper.length * start.rate[0] * Rod::Ahead(start.place[0]);
  const EntityId lower = Add(world, kLower.Hung(elbow, moves, start.place[1], start.rate[1]));
  HingeJoint limited;
  limited.axis.limits.upper = way;
  Join(world, ToWorld(upper, limited, HingeAt(Vector2::Zero())));
  const Pose of_upper = world.state().pose(EntityRow{upper.index()});
  const Quaternion back = of_upper.orientation.conjugate();
  const Pose hinge = HingeAt(elbow);
  Join(world,
       Between(upper, lower, HingeJoint{}, {back * (hinge.position - of_upper.position), back * hinge.orientation}));
  Steps(world, static_cast<int>(std::lround(kTime / world.scene().world.stepper.step_size)));
  const Course end = Integrated(system, start, start.place[0] + way);
  const Vector3 found = PositionOf(world, lower);
  return {{found.x(), found.z()},
          kUpper.length * Rod::Along(end.place[0]) + kLower.length / 2 * Rod::Along(end.place[1])};
}

// Of a cart that `pull` (N) draws along its slider, or its motor does.
Ends Cart(World& world, const Course& start, double way, double pull, bool is_driven = false) {
  const double lever = kLower.length / 2, both = kLower.mass * lever;
  const System system{.mass = [=](const Vector2& q) -> Matrix2 {
                        const double across = both * std::cos(q[1]);
                        return Matrix2{{kUpper.mass + kLower.mass, across}, {across, kLower.moment()}};
                      },
                      .force = [=](const Vector2& q, const Vector2& v) -> Vector2 {
                        return {both * std::sin(q[1]) * v[1] * v[1] + pull, -both * kGravity * std::sin(q[1])};
                      }};
  const Vector2 moves(start.rate[0], 0);
  EntityDesc crate = Crate({0, 0, 0}, kHalf, kUpper.mass);
  crate.rigid_body->linear_velocity = {moves.x(), 0, 0};
  const EntityId cart = Add(world, crate);
  const EntityId rod = Add(world, kLower.Hung(Vector2::Zero(), moves, start.place[1], start.rate[1]));
  SliderJoint limited;
  limited.axis.limits.upper = way;
  // To a speed that it does not come to.
  if (is_driven) limited.axis.motor = Motor{.target_velocity = std::copysign(1e3, pull), .force_max = std::abs(pull)};
  Join(world, ToWorld(cart, limited, FrameAlong(Vector3::UnitX())));
  Join(world, Between(cart, rod, HingeJoint{}, HingeAt(Vector2::Zero())));
  if (pull != 0 && !is_driven) Do(world, ApplyForce{.id = cart, .force = {pull, 0, 0}, .steps = 100'000});
  Steps(world, static_cast<int>(std::lround(kTime / world.scene().world.stepper.step_size)));
  const Course end = Integrated(system, start, way);
  const Vector3 found = PositionOf(world, rod);
  return {{found.x(), found.z()}, Vector2(end.place[0], 0) + lever * Rod::Along(end.place[1])};
}

// `most` (m/s^2) times the square of the step. At 960 steps per second the first order is many times that.
template <typename Run>
void ExpectSecondOrder(const std::string& engine, double most, Run&& run) {
  for (const int rate : {60, 240, 960}) {
    for (int i = 0; i < 10; ++i) {
      const auto world = MakeSpace(engine, {.step_size = 1.0 / rate, .substeps = 1});
      const Ends ends = run(*world, 0.0137 * i);
      EXPECT_LE((ends.found - ends.exact).norm(), most / rate / rate) << i << " at " << rate;
    }
  }
}

TEST_P(JointsLimitsCarrying, APendulumSwingsOnAboutTheRodThatIsStopped) {
  ExpectSecondOrder(GetParam(), 12, [](World& world, double faster) {
    return Pendulum(world, {{-0.8, -0.5}, {3 + faster, 4}}, 0.5);
  });
}

TEST_P(JointsLimitsCarrying, ACartThatComesToItsEndIsDrawnBackByWhatSwingsOnIt) {
  Proves({Claim::kJointSlider});
  ExpectSecondOrder(GetParam(), 5, [](World& world, double faster) {
    return Cart(world, {{0, 0.4}, {1.5 + faster, 1}}, 0.3, 0);
  });
}

TEST_P(JointsLimitsCarrying, ACartIsPulledBackFromItsEnd) {
  Proves({Claim::kJointSlider});
  ExpectSecondOrder(GetParam(), 5, [](World& world, double faster) {
    return Cart(world, {{0, 0.4}, {2.5 + faster, 1}}, 0.3, -15);
  });
}

TEST_P(JointsLimitsCarrying, ACartIsPressedAgainstItsEnd) {
  Proves({Claim::kJointSlider});
  ExpectSecondOrder(GetParam(), 40, [](World& world, double faster) {
    return Cart(world, {{0, 0.4}, {1 + faster, 1}}, 0.3, 60);
  });
}

// A motor that pushes with all it may is a force as good as any.
TEST_P(JointsLimitsCarrying, ACartIsDrivenAgainstItsEnd) {
  Proves({Claim::kJointSlider, Claim::kJointMotor});
  ExpectSecondOrder(GetParam(), 40, [](World& world, double faster) {
    return Cart(world, {{0, 0.4}, {1 + faster, 1}}, 0.3, 60, true);
  });
}

TEST_P(JointsLimitsCarrying, ACartIsDrivenBackFromItsEnd) {
  Proves({Claim::kJointSlider, Claim::kJointMotor});
  ExpectSecondOrder(GetParam(), 5, [](World& world, double faster) {
    return Cart(world, {{0, 0.4}, {2.5 + faster, 1}}, 0.3, -15, true);
  });
}

}  // namespace
}  // namespace genphys::testing

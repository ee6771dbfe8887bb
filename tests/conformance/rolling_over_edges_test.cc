// What rolls on an edge or on something round stays on it, and goes on as a pendulum that stands on its head.
#include <cmath>
#include <optional>

#include "engine_test.h"
#include "support/course.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(RollingOverEdges, Claim::kSphere);

constexpr double kGravity = 9.81;
constexpr double kRadius = 0.5;
constexpr double kMoment = 0.4;  // over m r^2
constexpr double kFirstAngle = 0.93;
constexpr double kDuration = 0.15;

// A ball on something fixed at the origin, around which its centre turns at `arm` m, from an angle (rad) above the
// level on. It turns by itself `ratio` times as fast as its centre.
struct Roll {
  std::optional<double> under;  // m, radius of a ball; else the edge of a block
  double rate = 2.65;           // rad/s, at the beginning

  double arm() const { return kRadius + under.value_or(0); }
  double ratio() const { return arm() / kRadius; }
};

struct Missed {
  double place = 0;  // m, at the end
  double spin = 0;   // rad/s, the most on the way
};

Missed Follow(const std::string& engine, const Roll& roll, int rate) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .ground_plane = false};
  desc.stepper.quality = Quality::kFast;
  desc.stepper.step_size = 1.0 / rate;
  desc.default_material.friction = 5;
  desc.default_auto_disable.enabled = false;
  const auto world = testing::MakeWorld(desc);
  Require(*world, Feature::kContacts);
  if (roll.under) {
    EntityDesc under = Body(Sphere{*roll.under}, Vector3::Zero());
    under.rigid_body->motion_type = MotionType::kStatic;
    Add(*world, under);
  } else {
    Add(*world, Block({1, 0, -1}, {1, 1, 1}));
  }
  const double arm = roll.arm();
  const auto place = [&](double angle) { return Vector3(-arm * std::cos(angle), 0, arm * std::sin(angle)); };
  EntityDesc ball = Body(Sphere{kRadius}, place(kFirstAngle));
  ball.rigid_body->linear_velocity = roll.rate * arm * Vector3(std::sin(kFirstAngle), 0, std::cos(kFirstAngle));
  ball.rigid_body->angular_velocity = {0, roll.rate * roll.ratio(), 0};
  const EntityId id = Add(*world, ball);
  // Of one kilogram and its spin about the place where it touches.
  const double pull = kGravity * arm / (arm * arm + kMoment * kRadius * kRadius * roll.ratio() * roll.ratio());
  const auto law = [&](double angle, double) { return -pull * std::cos(angle); };
  Missed missed;
  for (int step = 1; step <= std::lround(kDuration * rate); ++step) {
    Steps(*world, 1);
    const auto [angle, turning] = CourseOf(kFirstAngle, roll.rate, static_cast<double>(step) / rate, 100, law);
    missed.place = (PositionOf(*world, id) - place(angle)).norm();
    missed.spin = std::max(missed.spin, std::abs(SpinOf(*world, id).y() / roll.ratio() - turning));
  }
  return missed;
}

TEST_P(RollingOverEdges, IsOfSecondOrderAtEveryRate) {
  for (const Roll& roll : {Roll{}, Roll{.under = 0.5, .rate = 1.5}, Roll{.under = 2, .rate = 1.5}}) {
    for (const int rate : {120, 180, 240, 360, 480}) {
      const Missed missed = Follow(GetParam(), roll, rate);
      const double scale = std::pow(120.0 / rate, 2);
      EXPECT_LT(missed.place, 2e-5 * scale) << roll.arm() << " m, " << rate << " steps per second";
      EXPECT_LT(missed.spin, 2e-3 * scale) << roll.arm() << " m, " << rate << " steps per second";
    }
  }
}

// A ball that rolls at `speed` meets a step after `time` and goes on about its edge, around which the blow leaves its
// angular momentum. Returns how far off it is 0.15 s later, m.
double MissedAfterStep(const std::string& engine, double speed, double time, int rate) {
  constexpr double kHeight = 0.1;
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .ground_plane = false};
  desc.stepper.step_size = 1.0 / rate;
  desc.default_material.friction = 5;
  desc.default_auto_disable.enabled = false;
  const auto world = testing::MakeWorld(desc);
  Require(*world, Feature::kContacts);
  Add(*world, Block({-4, 0, -0.5}, {5, 1, 0.5}));
  Add(*world, Block({2, 0, kHeight - 0.5}, {1, 1, 0.5}));
  const double angle_then = std::asin((kRadius - kHeight) / kRadius);
  EntityDesc desc_of_ball = Body(Sphere{kRadius}, {1 - kRadius * std::cos(angle_then) - speed * time, 0, kRadius});
  desc_of_ball.rigid_body->linear_velocity = {speed, 0, 0};
  desc_of_ball.rigid_body->angular_velocity = {0, speed / kRadius, 0};
  const EntityId ball = Add(*world, desc_of_ball);
  const int steps = static_cast<int>(std::lround((time + kDuration) * rate));
  Steps(*world, steps);
  const double turning = speed / kRadius * (kMoment + 1 - kHeight / kRadius) / (kMoment + 1);
  const auto law = [](double angle, double) { return -kGravity * std::cos(angle) / ((1 + kMoment) * kRadius); };
  const double angle = CourseOf(angle_then, turning, static_cast<double>(steps) / rate - time, 400, law).first;
  const Vector3 place = Vector3(1, 0, kHeight) + kRadius * Vector3(-std::cos(angle), 0, std::sin(angle));
  return (PositionOf(*world, ball) - place).norm();
}

TEST_P(RollingOverEdges, BeginsWhereAStepIsMet) {
  for (const int rate : {120, 240, 480}) {
    for (const double speed : {1.34, 1.55, 1.76}) {
      for (const double time : {0.0617, 0.1332, 0.2113}) {
        EXPECT_LT(MissedAfterStep(GetParam(), speed, time, rate), 0.05 / rate)
            << speed << " m/s, after " << time << " s, " << rate << " steps per second";
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

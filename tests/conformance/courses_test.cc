// Floors that are told a velocity, or a pose, for each step go smoothly through it where the last steps tell how, and
// carry what lies on them as the course does of which they were told samples.
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "conformance/engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Courses, Claim::kKinematicPush);

constexpr double kGravity = 9.81;
constexpr double kFriction = 0.5;
constexpr double kTime = 2;  // s

/// Goes to and fro so that it begins and ends as smoothly as it turns.
struct Course {
  double acceleration_max;  // m/s^2
  double rate = 3;          // rad/s

  double At(double time) const {
    const double speed = acceleration_max / rate;
    return speed / 2 * (time - std::sin(2 * rate * time) / (2 * rate));
  }
};

enum class Told { kPoses, kVelocities };

class Carried {
 public:
  Carried(const std::string& engine, int rate) : step_(1.0 / rate) {
    WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = step_}};
    desc.ground_plane = false;
    desc.default_material.friction = kFriction;
    desc.default_auto_disable.enabled = false;
    world_ = MakeWorld(desc);
    Require(*world_, Feature::kContacts);
    EntityDesc floor = Block(kFloor, {4, 4, 1});
    floor.rigid_body->motion_type = MotionType::kKinematic;
    floor_ = Add(*world_, floor);
    load_ = Add(*world_, Body(Box{{0.2, 0.2, 0.1}}, kLoad, 1));
  }

  /// The load begins at `there`.
  void Start(const Vector3& floor_velocity, const Vector3& there, const Vector3& load_velocity) {
    Do(*world_, SetVelocity{.id = floor_, .linear = floor_velocity});
    Do(*world_, SetPose{.id = load_, .position = kLoad + there});
    Do(*world_, SetVelocity{.id = load_, .linear = load_velocity});
  }

  /// The floor to so far from where it began, in a step.
  void LeadTo(const Vector3& there, Told told) {
    const Vector3 velocity = (there - (PositionOf(*world_, floor_) - kFloor)) / step_;
    if (told == Told::kPoses) {
      Do(*world_, SetPose{.id = floor_, .position = kFloor + there, .over_steps = 1});
    } else {
      Do(*world_, SetVelocity{.id = floor_, .linear = velocity});
    }
    Steps(*world_, 1);
    EXPECT_LE((PositionOf(*world_, floor_) - kFloor - there).norm(), 1e-12);
    EXPECT_LE((VelocityOf(*world_, floor_) - velocity).norm(), 1e-10) << "it is shown as it was told";
  }

  /// m: how far the load is at most from where it lay on the floor.
  double Lead(const Course& course, const Vector3& way, Told told) {
    double most = 0;
    for (int i = 0; i * step_ < kTime; ++i) {
      const Vector3 there = course.At((i + 1) * step_) * way;
      LeadTo(there, told);
      most = std::max(most, (load() - there).norm());
    }
    return most;
  }

  /// Of each step from now on.
  void SetSubsteps(uint32_t substeps) { Do(*world_, SetStepper{{.step_size = step_, .substeps = substeps}}); }

  /// m, from where it lay.
  Vector3 load() const { return PositionOf(*world_, load_) - kLoad; }

 private:
  static inline const Vector3 kLoad{0, 0, 0.1};
  static inline const Vector3 kFloor{0, 0, -1};

  double step_;
  std::unique_ptr<World> world_;
  EntityId floor_;
  EntityId load_;
};

TEST_P(Courses, WhatLiesOnAFloorThatIsShakenGoesWithIt) {
  Proves({Claim::kStaticFriction});
  constexpr Course kCourse{.acceleration_max = 0.97 * kFriction * kGravity};
  for (const Told told : {Told::kPoses, Told::kVelocities}) {
    const double at_60 = Carried(GetParam(), 60).Lead(kCourse, Vector3::UnitX(), told);
    EXPECT_LE(at_60, 1e-5);  // evenly through each step: 4e-3
  }
}

TEST_P(Courses, WhatLiesOnALiftStaysOnItWhileThatFallsMoreSlowly) {
  Proves({Claim::kContacts});
  constexpr Course kCourse{.acceleration_max = 0.9 * kGravity};
  for (const Told told : {Told::kPoses, Told::kVelocities}) {
    EXPECT_LE(Carried(GetParam(), 60).Lead(kCourse, Vector3::UnitZ(), told), 1e-5);
  }
}

TEST_P(Courses, WhatLiesOnAFloorThatIsShakenGoesWithItWhenSubstepsChange) {
  Proves({Claim::kStaticFriction});
  constexpr Course kCourse{.acceleration_max = 0.9 * kFriction * kGravity};
  constexpr double kStep = 1.0 / 60;
  for (const Told told : {Told::kPoses, Told::kVelocities}) {
    Carried carried(GetParam(), 60);
    for (int i = 0; i * kStep < kTime; ++i) {
      if (i % 5 == 0) carried.SetSubsteps(i % 2 == 0 ? 1 : 4);
      const Vector3 there = kCourse.At((i + 1) * kStep) * Vector3::UnitX();
      carried.LeadTo(there, told);
      ASSERT_LE((carried.load() - there).norm(), 1e-5) << "step " << i;
    }
  }
}

// Led round a circle faster than friction can follow, a load goes round a smaller one, for ever slipping outwards: what
// friction gives points straight to the middle.
TEST_P(Courses, WhatSlidesOnAFloorThatIsLedRoundGoesRoundASmallerCircle) {
  Proves({Claim::kKineticFriction});
  constexpr double kPull = kFriction * kGravity, kRate = 3;  // rad/s
  constexpr double kOwn = kPull / (kRate * kRate), kLed = 1.5 * kOwn;
  // By so much the floor is ahead.
  const double ahead = std::acos(kOwn / kLed);
  const auto at = [](double radius, double angle) -> Vector3 {
    return {radius * std::cos(angle), radius * std::sin(angle), 0};
  };
  const auto velocity = [&](double radius, double angle) { return at(kRate * radius, angle + std::numbers::pi / 2); };
  for (const int rate : {60, 137, 240}) {
    for (const Told told : {Told::kPoses, Told::kVelocities}) {
      const double step = 1.0 / rate;
      Carried carried(GetParam(), rate);
      const Vector3 there = at(kOwn, -ahead);
      carried.Start(velocity(kLed, 0), there, velocity(kOwn, -ahead));
      for (int i = 0; i * step < kTime; ++i) {
        carried.LeadTo(at(kLed, kRate * (i + 1) * step) - at(kLed, 0), told);
        // Until the course is known the floor goes evenly, and friction works as far another way.
        const Vector3 off = carried.load() - at(kOwn, kRate * (i + 1) * step - ahead);
        ASSERT_LE(off.norm(), kPull * step * step + kTouch) << "step " << i << " of 1/" << rate;
      }
    }
  }
}

}  // namespace
}  // namespace genphys::testing

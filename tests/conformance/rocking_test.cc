// What is round and whose centre of mass moves against what it rolls over: where it touches runs over it meanwhile, and
// it goes as if it touched there all the time, in second order of the step, and with all of its energy.
#include <cmath>
#include <functional>
#include <vector>

#include "engine_test.h"
#include "support/energy.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Rocking, Claim::kStaticFriction);

constexpr double kGravity = 9.81;
constexpr double kHolds = 5;  // more friction than any of them needs

std::unique_ptr<World> Level(const std::string& engine, int rate, double friction) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = 1.0 / rate}};
  desc.default_material.friction = desc.default_material.kinetic_friction = friction;
  desc.default_auto_disable.enabled = false;
  return testing::MakeWorld(desc);
}

Pose PoseOf(const World& world, EntityId id) { return world.state().pose(EntityRow{id.index()}); }

// rad about y.
double AngleOf(const World& world, EntityId id) {
  const Quaternion orientation = PoseOf(world, id).orientation;
  return 2 * std::atan2(orientation.y(), orientation.w());
}

// J, of the one body of 1 kg.
double EnergyOf(const World& world, EntityId id, const Vector3& center = Vector3::Zero()) {
  return KineticEnergyOf(world) + kGravity * PoseOf(world, id).Transform(center).z();
}

// Of what goes one way only, whose energy is inertia(angle) * rate^2 / 2 + height(angle) * gravity: Lagrange.
struct Way {
  std::function<double(double)> inertia, height;

  // Its angle `seconds` after it stood still at `angle`.
  double After(double seconds, double angle) const {
    constexpr int kSteps = 4000;
    constexpr double kSmall = 1e-5;
    const double h = seconds / kSteps;
    const auto slope = [](const std::function<double(double)>& of, double at) {
      return (of(at + kSmall) - of(at - kSmall)) / (2 * kSmall);
    };
    const auto change = [&](const Eigen::Vector2d& now) -> Eigen::Vector2d {
      const double pull = -kGravity * slope(height, now[0]) - slope(inertia, now[0]) * now[1] * now[1] / 2;
      return {now[1], pull / inertia(now[0])};
    };
    Eigen::Vector2d now(angle, 0);
    for (int i = 0; i < kSteps; ++i) {
      const Eigen::Vector2d first = change(now), second = change(now + h / 2 * first),
                            third = change(now + h / 2 * second), fourth = change(now + h * third);
      now += h / 6 * (first + 2 * second + 2 * third + fourth);
    }
    return now[0];
  }
};

const Quaternion kOnItsSide(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()));

// Round about y, and heavy at one side.
constexpr double kRound = 0.5, kOff = 0.2, kMoment = 0.08, kTilt = 0.6;

EntityId AddRolyPoly(World& world, const Shape& shape) {
  EntityDesc desc = Body(shape, {0, 0, kRound});
  if (!std::holds_alternative<Ellipsoid>(shape)) {
    desc.rigid_body->geometries[0].pose_in_entity.orientation = kOnItsSide;
  }
  desc.rigid_body->inertia.center_of_mass = Vector3(0, 0, -kOff);
  desc.rigid_body->inertia.tensor = kMoment * Matrix3::Identity();
  desc.pose.orientation = Eigen::AngleAxisd(kTilt, Vector3::UnitY());
  return Add(world, desc);
}

const Way kRolling{
    [](double angle) { return kMoment + kRound * kRound + kOff * kOff - 2 * kRound * kOff * std::cos(angle); },
    [](double angle) { return -kOff * std::cos(angle); }};
const Way kSliding{[](double angle) { return kMoment + std::pow(kOff * std::sin(angle), 2); },
                   [](double angle) { return -kOff * std::cos(angle); }};

std::vector<Shape> RoundAboutY() {
  return {Sphere{kRound}, Cylinder{kRound, 0.2}, Capsule{kRound, 0.2}, Ellipsoid{{kRound, 0.45, kRound}}};
}

// rad/s: how fast it turns at the lowest, at most.
double FastestOf(const Way& way, double angle) {
  return std::sqrt(2 * kGravity * (way.height(angle) - way.height(0)) / way.inertia(0));
}

TEST_P(Rocking, ARolyPolySwingsInSecondOrder) {
  Proves({Claim::kSphere, Claim::kCylinder, Claim::kCapsule, Claim::kEllipsoid});
  for (const double friction : {kHolds, 0.0}) {
    const Way& way = friction > 0 ? kRolling : kSliding;
    const double wanted = way.After(1, kTilt);
    for (const Shape& shape : RoundAboutY()) {
      for (const int rate : {60, 240}) {
        SCOPED_TRACE(::testing::Message() << shape.index() << " at " << rate << " with " << friction);
        const auto world = Level(GetParam(), rate, friction);
        const EntityId id = AddRolyPoly(*world, shape);
        Steps(*world, rate);
        EXPECT_NEAR(AngleOf(*world, id), wanted, std::pow(FastestOf(way, kTilt) * SubstepOf(*world), 2));
      }
    }
  }
}

// Of first order it loses one part in nine of it in 38 s at 60 steps per second, and a third without friction.
TEST_P(Rocking, ARolyPolyKeepsItsEnergy) {
  Proves({Claim::kSphere, Claim::kCylinder, Claim::kCapsule, Claim::kEllipsoid});
  for (const double friction : {kHolds, 0.0}) {
    for (const Shape& shape : RoundAboutY()) {
      SCOPED_TRACE(::testing::Message() << shape.index() << " with " << friction);
      const auto world = Level(GetParam(), 60, friction);
      const EntityId id = AddRolyPoly(*world, shape);
      const Vector3 center(0, 0, -kOff);
      const double lowest = kGravity * (kRound - kOff), swing = EnergyOf(*world, id, center) - lowest;
      Steps(*world, 20 * 60);
      EXPECT_NEAR(EnergyOf(*world, id, center) - lowest, swing, 2e-3 * swing);
    }
  }
}

// It goes over its flat side, whose curve has three times its length as radius, in a few steps. Where these can follow
// that it keeps its energy, and where they cannot it gains none.
TEST_P(Rocking, AnEllipsoidGainsNoEnergyAndKeepsItWhereStepsFollow) {
  Proves({Claim::kEllipsoid});
  const Vector3 axes(0.3, 0.2, 0.1);
  const auto height = [&](double angle) { return std::hypot(axes.x() * std::sin(angle), axes.z() * std::cos(angle)); };
  for (const double friction : {kHolds, 0.0}) {
    for (const int rate : {60, 240}) {
      SCOPED_TRACE(::testing::Message() << rate << " with " << friction);
      const auto world = Level(GetParam(), rate, friction);
      EntityDesc desc = Body(Ellipsoid{axes}, {0, 0, height(kTilt)});
      desc.pose.orientation = Eigen::AngleAxisd(kTilt, Vector3::UnitY());
      const EntityId id = Add(*world, desc);
      const double lowest = kGravity * axes.z(), swing = EnergyOf(*world, id) - lowest;
      Steps(*world, rate);
      const double left = (EnergyOf(*world, id) - lowest) / swing;
      EXPECT_LE(left, 1.001);
      // At 60 it is lifted by more in a substep than is followed.
      EXPECT_GE(left, rate == 240 ? 0.995 : 0);
    }
  }
}

TEST_P(Rocking, APlankRocksOnACylinderInSecondOrder) {
  Proves({Claim::kCylinder, Claim::kBox});
  constexpr double kCurve = 1, kHalf = 0.1, kLong = 1, kStart = 0.3;
  constexpr double kInertia = (kLong * kLong + kHalf * kHalf) / 3;
  const Way way{[](double angle) { return kInertia + kHalf * kHalf + std::pow(kCurve * angle, 2); },
                [](double angle) { return (kCurve + kHalf) * std::cos(angle) + kCurve * angle * std::sin(angle); }};
  const double wanted = way.After(2, kStart);
  for (const int rate : {60, 240}) {
    SCOPED_TRACE(rate);
    const auto world = Level(GetParam(), rate, kHolds);
    const Vector3 top(0, 0, 5);
    EntityDesc roll = Body(Cylinder{kCurve, 1}, top);
    roll.rigid_body->motion_type = MotionType::kStatic;
    roll.pose.orientation = kOnItsSide;
    Add(*world, roll);
    const Vector3 away(std::sin(kStart), 0, std::cos(kStart)), along(std::cos(kStart), 0, -std::sin(kStart));
    EntityDesc plank = Body(Box{{kLong, 0.2, kHalf}}, top + (kCurve + kHalf) * away - kCurve * kStart * along);
    plank.pose.orientation = Eigen::AngleAxisd(kStart, Vector3::UnitY());
    const EntityId id = Add(*world, plank);
    Steps(*world, 2 * rate);
    EXPECT_NEAR(AngleOf(*world, id), wanted, std::pow(FastestOf(way, kStart) * SubstepOf(*world), 2));
  }
}

// A coin that leans and rolls round in a circle comes back to where it was.
TEST_P(Rocking, ACoinRollsInACircle) {
  Proves({Claim::kCylinder});
  constexpr double kRadius = 0.2, kHalf = 0.01, kTurn = 3;  // rad/s, about the vertical
  const Vector3 up = Vector3::UnitZ(), axle(std::cos(0.3), 0, std::sin(0.3));
  const Vector3 down = (up.dot(axle) * axle - up).normalized(), arm = kRadius * down - kHalf * axle;
  const Vector3 side = Vector3::UnitY();
  const double about = kRadius * kRadius / 2, across = kRadius * kRadius / 4 + kHalf * kHalf / 3;
  // What is left over of the torques about `side` if it also turns by `spin` about its axle: everything goes round.
  const auto spin_of = [&](double spin) -> Vector3 { return kTurn * up + spin * axle; };
  const auto left_over = [&](double spin) {
    const Vector3 turn = spin_of(spin), momentum = across * turn + (about - across) * turn.dot(axle) * axle;
    const Vector3 force = kTurn * up.cross(-turn.cross(arm)) + kGravity * up;
    return (arm.cross(force) - kTurn * up.cross(momentum)).dot(side);
  };
  const double spin = -left_over(0) / (left_over(1) - left_over(0));
  const Vector3 turn = spin_of(spin), velocity = -turn.cross(arm);
  for (const int rate : {60, 240}) {
    SCOPED_TRACE(rate);
    const auto world = Level(GetParam(), rate, kHolds);
    EntityDesc coin = Body(Cylinder{kRadius, kHalf}, {0, 0, -arm.z()});
    coin.pose.orientation = Quaternion::FromTwoVectors(up, axle);
    coin.rigid_body->linear_velocity = velocity;
    coin.rigid_body->angular_velocity = turn;
    const EntityId id = Add(*world, coin);
    const Vector3 start = PositionOf(*world, id), center = start + up.cross(velocity) / kTurn;
    Steps(*world, rate);
    const Vector3 wanted = center + Eigen::AngleAxisd(kTurn, up) * (start - center);
    EXPECT_NEAR((PositionOf(*world, id) - wanted).norm(), 0,
                2 * velocity.norm() * std::pow(turn.norm() * SubstepOf(*world), 2));
  }
}

}  // namespace
}  // namespace genphys::testing

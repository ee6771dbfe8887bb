// What joints hold meets things at its own time, like everything else: all that they hold together goes back to when it
// did, and forward again as joints let it. Known are Newton's law, the laws of a fall and of a pendulum, and that what
// is welded together is one body.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "conformance/engine_test.h"
#include "support/energy.h"
#include "support/joints.h"
#include "support/random.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsBounces, Claim::kContacts, Claim::kRestitution);

constexpr double kStep = 1.0 / 60;
constexpr double kGravity = 9.81;

EntityDesc Lively(EntityDesc desc, double restitution, const Vector3& velocity = Vector3::Zero()) {
  Material& material = desc.rigid_body->geometries[0].material;
  material.restitution = restitution;
  material.friction = 0;
  desc.rigid_body->linear_velocity = velocity;
  return desc;
}

EntityDesc Wall(double restitution, double half_thickness = 0.01) {
  return Lively(Block(Vector3::Zero(), {half_thickness, 2, 2}), restitution);
}

EntityDesc Ground(double restitution) {
  EntityDesc desc = Lively(Block(Vector3::Zero(), Vector3::Ones()), restitution);
  desc.rigid_body->geometries[0].shape = Plane{};
  return desc;
}

// A ball on its way to a wall along x, and what joints make of it: it goes straight on all the same.
EntityId AddOnJoint(World& world, int kind, const Vector3& from, double speed, double restitution) {
  const EntityDesc ball = Lively(Ball(from, 0.05), restitution, {speed, 0, 0});
  const EntityId id = Add(world, ball);
  if (kind == 0) {
    Join(world, ToWorld(id, SliderJoint{}, FrameAlong(Vector3::UnitX(), from)));
    return id;
  }
  EntityDesc behind = ball;
  behind.pose.position.x() -= 0.5;
  const EntityId other = Add(world, behind);
  Join(world, kind == 1 ? Between(id, other, FixedJoint{}) : Between(id, other, DistanceJoint{}));
  return id;
}

TEST_P(JointsBounces, PassNoThinWallAtAnySpeed) {
  Proves({Claim::kJointSlider, Claim::kJointFixed, Claim::kJointDistance, Claim::kSphere});
  for (uint64_t seed = 1; seed <= 90; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double speed = random.LogUniform(1, 300), restitution = seed % 4 == 0 ? 0 : random.Uniform(0, 1);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
    Add(*world, Wall(restitution));
    const double ahead = random.Uniform(0.1, 2);
    const Vector3 from(-0.06 - ahead, random.Uniform(-1, 1), random.Uniform(-1, 1));
    const EntityId ball = AddOnJoint(*world, static_cast<int>(seed % 3), from, speed, restitution);
    Steps(*world, static_cast<int>(ahead / speed / kStep) + 2);
    EXPECT_LT(PositionOf(*world, ball).x(), -0.0599);
    // Measured: 2.5e-6 of the speed where they are welded, 2e-8 where they are tied.
    EXPECT_NEAR(VelocityOf(*world, ball).x(), -restitution * speed, 1e-5 * speed);
  }
}

// A ball on its way to a wall along x, on a joint that locks nothing and holds nothing there, or almost. Returns it,
// and what it is joined to unless that is the world.
std::pair<EntityId, EntityId> AddOnLooseJoint(World& world, int kind, const Vector3& from, double speed,
                                              double restitution) {
  const EntityId ball = Add(world, Lively(Ball(from, 0.05), restitution, {speed, 0, 0}));
  EntityId other;
  DistanceJoint distance;
  if (kind < 2) {
    distance.axis.limits.upper = 1000;
    if (kind == 1) other = Add(world, Lively(Ball({0, 20, 0}, 0.05), 0, {0, 1, 0}));
  } else if (kind == 2) {
    distance.axis.spring = Spring{.stiffness = 1e-8, .rest = 50};
  } else {
    distance.axis.motor = Motor{.target_velocity = 1, .force_max = 1e-7};
  }
  SixDofJoint free;
  free.along.fill(JointAxis{});
  free.about.fill(JointAxis{});
  JointDesc joint = Between(other, ball, kind == 4 ? JointKind(free) : JointKind(distance));
  if (other.is_null()) joint.frame_in_a = Pose{{0, 0, 50}};
  joint.frame_in_b = Pose{};
  Join(world, joint);
  return {ball, other};
}

TEST_P(JointsBounces, PassNoThinWallOnAJointThatHoldsNothing) {
  Proves({Claim::kJointDistance, Claim::kJointSixDof, Claim::kJointLimit, Claim::kJointSpring, Claim::kJointMotor,
          Claim::kSphere});
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double speed = random.LogUniform(3, 300), restitution = seed % 4 == 0 ? 0 : random.Uniform(0, 1);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
    Add(*world, Wall(restitution));
    const double ahead = random.Uniform(0.1, 2);
    const Vector3 from(-0.06 - ahead, random.Uniform(-1, 1), random.Uniform(-1, 1));
    const auto [ball, other] = AddOnLooseJoint(*world, static_cast<int>(seed % 5), from, speed, restitution);
    const int steps = static_cast<int>(ahead / speed / kStep) + 2;
    Steps(*world, steps);
    const double time = steps * kStep, since = time - ahead / speed;
    // As if it were free: to where it is from when it met the wall, which is known by so much of a depth.
    const double met = ImpactDepth(speed, SubstepOf(*world));
    EXPECT_NEAR(PositionOf(*world, ball).x(), -0.06 - restitution * speed * since, 2 * (1 + restitution) * met);
    // Spring and motor give it that much, and what stays there is pushed out of the depth at which it was found.
    EXPECT_NEAR(VelocityOf(*world, ball).x(), -restitution * speed, 1e-6 + met / SubstepOf(*world));
    EXPECT_EQ(Of<ContactBegan>(world->TakeEvents()).size(), 1u);
    const double aside = other.is_null() ? 20 + time : PositionOf(*world, other).y();
    EXPECT_NEAR(aside, 20 + time, kRounded * 20) << "nothing hit what it is joined to";
  }
}

// A motor whose force has no end, and which locks nothing, pushes a ball against a wall.
TEST_P(JointsBounces, PushOnFromTheBlowWhatTheyDoNotLock) {
  Proves({Claim::kJointDistance, Claim::kJointMotor});
  constexpr double kPush = 40, kMass = 2, kAhead = 0.3, kRestitution = 0.7;
  const double pull = kPush / kMass, speed = std::sqrt(2 * pull * kAhead), met = speed / pull;
  const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
  Add(*world, Wall(kRestitution));
  const EntityId ball = Add(*world, Lively(Ball({-0.06 - kAhead, 0, 0}, 0.05, kMass), kRestitution));
  DistanceJoint distance;
  distance.axis.motor = Motor{.target_velocity = 1000, .force_max = kPush};
  JointDesc joint = ToWorld(ball, distance, {{-10, 0, 0}});
  joint.frame_in_b = Pose{};
  Join(*world, joint);
  const int steps = static_cast<int>(met / kStep) + 1;
  Steps(*world, steps);
  for (int more = 0; more < 3; ++more) {
    const double since = (steps + more) * kStep - met;
    SCOPED_TRACE(since);
    const double depth = ImpactDepth(speed, SubstepOf(*world));
    EXPECT_NEAR(PositionOf(*world, ball).x(), -0.06 - kRestitution * speed * since + pull / 2 * since * since,
                2 * (1 + kRestitution) * depth);
    EXPECT_NEAR(VelocityOf(*world, ball).x(), -kRestitution * speed + pull * since, 2 * pull * depth / speed);
    Steps(*world, 1);
  }
}

TEST_P(JointsBounces, SwingBackWhatHitsAWallAsFastAsItCame) {
  Proves({Claim::kJointHinge, Claim::kBox});
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double spin = random.LogUniform(1, 20), restitution = random.Uniform(0.3, 1);
    const double behind = random.Uniform(0.3, 1.2);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep}, Vector3::Zero());
    // A rod from the origin, which goes round and meets an edge across its way.
    Add(*world, Lively(Block({0.9, 0.03, 0}, {0.05, 0.01, 0.5}), restitution));
    EntityDesc rod = Lively(Body(Box{{0.5, 0.02, 0.02}}, {0.5, 0, 0}), restitution);
    const Quaternion back(Eigen::AngleAxisd(-behind, Vector3::UnitZ()));
    rod.pose = {back * rod.pose.position, back};
    rod.rigid_body->angular_velocity = {0, 0, spin};
    rod.rigid_body->linear_velocity = Vector3(0, 0, spin).cross(rod.pose.position);
    const EntityId id = Add(*world, rod);
    Join(*world, ToWorld(id, HingeJoint{}, FrameAlong(Vector3::UnitZ())));
    Steps(*world, static_cast<int>(behind / spin / kStep) + 1);
    const double turn = spin * SubstepOf(*world);
    EXPECT_NEAR(SpinOf(*world, id).z(), -restitution * spin, (turn * turn + 1e-4) * spin);
  }
}

// Balls that hang side by side, in touch. The last one goes on as the first would without the others.
TEST_P(JointsBounces, PassThroughACradle) {
  Proves({Claim::kJointDistance, Claim::kSphere});
  constexpr double kRadius = 0.1, kLength = 1, kSwing = 0.8, kTime = 0.65;
  double angle = -kSwing, rate = 0;
  constexpr int kSmall = 100'000;
  for (int i = 0; i < kSmall; ++i) {  // leapfrog
    const double h = kTime / kSmall;
    rate -= h / 2 * kGravity / kLength * std::sin(angle);
    angle += h * rate;
    rate -= h / 2 * kGravity / kLength * std::sin(angle);
  }
  for (const int count : {2, 3, 5, 8}) {
    SCOPED_TRACE(count);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep});
    EntityId last;
    for (int i = 0; i < count; ++i) {
      const Vector3 hook(2 * kRadius * i, 0, 5), down(0, 0, -kLength);
      const Quaternion turn(Eigen::AngleAxisd(i == 0 ? kSwing : 0, Vector3::UnitY()));
      last = Add(*world, Lively(Ball(hook + turn * down, kRadius), 1));
      Join(*world, {.entity_b = {.id = last}, .frame_in_a = Pose{hook}, .frame_in_b = Pose{}, .kind = DistanceJoint{}});
    }
    Steps(*world, static_cast<int>(std::lround(kTime / kStep)));
    const Vector3 swung = PositionOf(*world, last) - Vector3(2 * kRadius * (count - 1), 0, 5);
    EXPECT_LE((swung - kLength * Vector3(std::sin(angle), 0, -std::cos(angle))).norm(), 5e-4);
  }
}

TEST_P(JointsBounces, LeaveWhatRunsOnAVerticalRailItsFall) {
  Proves({Claim::kJointSlider, Claim::kPlane, Claim::kSphere});
  const auto world = MakeSpace(GetParam(), {.step_size = kStep});
  Add(*world, Ground(1));
  const EntityId ball = Add(*world, Lively(Ball({0, 0, 1.1}, 0.1), 1));
  Join(*world, ToWorld(ball, SliderJoint{}, FrameAlong(Vector3::UnitZ(), {0, 0, 1.1})));
  const double fall = std::sqrt(2 / kGravity);
  for (int second = 1; second <= 10; ++second) {
    Steps(*world, 60);
    const double since = std::fmod(second + fall, 2 * fall) - fall;
    const double height = PositionOf(*world, ball).z() - 0.1, speed = VelocityOf(*world, ball).z();
    EXPECT_NEAR(height, 1 - kGravity * since * since / 2, 1e-5);
    EXPECT_NEAR(speed * speed / 2 + kGravity * height, kGravity, 1e-9);
  }
}

// Two balls that a joint makes one, and the body that they would be in steps that are much shorter.
TEST_P(JointsBounces, LetWhatIsWeldedTogetherBounceAsOneBody) {
  Proves({Claim::kJointFixed, Claim::kCompound, Claim::kSphere});
  constexpr double kRadius = 0.1, kArm = 0.3, kTime = 0.6;
  for (const double tilt : {0.2, 0.5, 0.9, 1.2}) {
    SCOPED_TRACE(tilt);
    const Vector3 middle(0, 0, 1), arm = kArm * Vector3(std::cos(tilt), 0, std::sin(tilt));
    const auto world = MakeSpace(GetParam(), {.step_size = kStep / 2});
    Add(*world, Ground(1));
    const EntityId lower = Add(*world, Lively(Ball(middle - arm, kRadius), 1));
    const EntityId upper = Add(*world, Lively(Ball(middle + arm, kRadius), 1));
    Join(*world, Between(lower, upper, FixedJoint{}));
    Steps(*world, static_cast<int>(std::lround(2 * kTime / kStep)));

    const auto reference = MakeSpace(GetParam(), {.step_size = 1.0 / 4000});
    Add(*reference, Ground(1));
    EntityDesc both = Lively(Ball(middle, kRadius, 2), 1);
    both.pose.orientation = Quaternion(Eigen::AngleAxisd(-tilt, Vector3::UnitY()));
    Geometry second = both.rigid_body->geometries[0];
    both.rigid_body->geometries[0].pose_in_entity.position = {-kArm, 0, 0};
    second.pose_in_entity.position = {kArm, 0, 0};
    both.rigid_body->geometries.push_back(second);
    const EntityId one = Add(*reference, both);
    Steps(*reference, static_cast<int>(std::lround(kTime * 4000)));
    const uint32_t row = one.index();
    const Vector3 there = reference->state().pose(EntityRow{row}).Transform(Vector3(-kArm, 0, 0));
    EXPECT_LT((PositionOf(*world, lower) - there).norm(), 5e-4);
  }
}

// A body on the floor whose arm is hit goes on standing there.
TEST_P(JointsBounces, LeaveStandingWhatStandsMeanwhile) {
  Proves({Claim::kJointHinge, Claim::kBox, Claim::kPlane, Claim::kSphere});
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep});
    Add(*world, Ground(0));
    const EntityId stand = Add(*world, Lively(Body(Box{{0.5, 0.5, 0.5}}, {0, 0, 0.5}, 100), 0));
    EntityDesc arm = Lively(Body(Box{{0.02, 0.02, 0.3}}, {0, 0.6, 1}), 1);
    const EntityId hanging = Add(*world, arm);
    Join(*world, Between(stand, hanging, HingeJoint{}, FrameAlong(Vector3::UnitY(), {0, 0.6, 0.8})));
    Steps(*world, 60);
    const double height = PositionOf(*world, stand).z();
    EntityDesc ball = Lively(Ball({-0.3 - random.Uniform(0, 0.2), 0.6, 0.8}, 0.05, 0.1), 1, {6, 0, 0});
    ball.rigid_body->gravity_scale = 0;
    Add(*world, ball);
    for (int step = 0; step < 10; ++step) {
      Steps(*world, 1);
      EXPECT_GT(PositionOf(*world, stand).z(), height - 2e-5);
    }
    EXPECT_GT(std::abs(SpinOf(*world, hanging).y()), 0.5);
  }
}

// A light pair that lands with a heavy one on it is hit from both sides in turns, at one time.
TEST_P(JointsBounces, FallNoMoreThanOnceWhereOneIsHitFromBothSides) {
  Proves({Claim::kJointFixed, Claim::kBox, Claim::kPlane});
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto world = MakeSpace(GetParam(), {.step_size = kStep});
    Add(*world, Ground(0));
    const double height = random.Uniform(0.5, 2), heavy = random.LogUniform(3, 100);
    double start = 0;
    std::vector<std::pair<EntityId, double>> masses;
    const auto add_pair = [&](double z, double mass) {
      EntityId last;
      for (const double x : {-0.3, 0.3}) {
        const EntityId id = Add(*world, Lively(Body(Box{{0.25, 0.3, 0.1}}, {x, 0, z}, mass), 0));
        if (x > 0) Join(*world, Between(last, id, FixedJoint{}));
        last = id;
        masses.emplace_back(id, mass);
        start += mass * kGravity * z;
      }
    };
    add_pair(height, 1);
    add_pair(height + 0.2, heavy);
    for (int step = 0; step < 60; ++step) {
      Steps(*world, 1);
      double energy = KineticEnergyOf(*world);
      for (const auto& [id, mass] : masses) energy += mass * kGravity * PositionOf(*world, id).z();
      EXPECT_LE(energy, start * 1.0001);
    }
    EXPECT_LT(KineticEnergyOf(*world), 1e-3 * start);
  }
}

// Bodies with four limbs of two links each, which fall on each other.
TEST_P(JointsBounces, MakeNoEnergyInAHeapOfLimbs) {
  Proves({Claim::kJointHinge, Claim::kBox, Claim::kSphere, Claim::kPlane});
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double restitution = seed % 2 == 0 ? 0 : 0.5;
    // Steps that resolve how they turn, and such as do not.
    const int rate = seed % 3 != 0 ? 60 : 10;
    const auto world = MakeSpace(GetParam(), {.step_size = 1.0 / rate});
    EntityDesc ground = Ground(restitution);
    ground.rigid_body->geometries[0].material.friction = 0.5;
    Add(*world, ground);
    std::vector<std::pair<EntityId, double>> masses;
    const auto add = [&](EntityDesc desc, const Vector3& place, const Quaternion& turn, double mass) {
      desc.rigid_body->geometries[0].material.restitution = restitution;
      desc.rigid_body->geometries[0].material.friction = 0.5;
      desc.pose = {place, turn};
      masses.emplace_back(Add(*world, desc), mass);
      return masses.back().first;
    };
    for (int k = 0; k < 6; ++k) {
      const Vector3 place(random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5), 1 + 0.8 * k);
      const Quaternion turn = random.Turn();
      const EntityId trunk = add(Body(Box{{0.15, 0.1, 0.25}}, place, 5), place, turn, 5);
      for (int limb = 0; limb < 4; ++limb) {
        const Vector3 root(limb % 2 == 0 ? 0.15 : -0.15, 0, limb < 2 ? 0.25 : -0.25);
        const Vector3 half = 0.15 * Vector3(root.x(), 0, 0.4 * root.z()).normalized();
        EntityId last = trunk;
        Vector3 end = root;
        for (int link = 0; link < 2; ++link) {
          const EntityId next = add(Ball(place, 0.07), place + turn * (end + half), turn, 1);
          Join(*world, Between(last, next, HingeJoint{}, FrameAlong(Vector3::UnitY(), last == trunk ? root : half)));
          last = next;
          end += 2 * half;
        }
      }
    }
    const auto energy = [&] {
      double sum = KineticEnergyOf(*world);
      for (const auto& [id, mass] : masses) sum += mass * kGravity * PositionOf(*world, id).z();
      return sum;
    };
    const double start = energy();
    for (int step = 0; step < 2 * rate; ++step) {
      Steps(*world, 1);
      EXPECT_LE(energy(), 1.001 * start);
    }
  }
}

}  // namespace
}  // namespace genphys::testing

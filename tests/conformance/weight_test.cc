// What lies or hangs weighs what it weighs.
#include <cmath>
#include <functional>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(Weight);

constexpr int kAveraged = 60;  // steps

// A table top, four legs, and five more things on it, all one entity.
EntityDesc TenGeometries(double mass, double heading) {
  EntityDesc table;
  table.pose = {{0.3, -0.2, 0.9}, Quaternion(Eigen::AngleAxisd(heading, Vector3::UnitZ()))};
  table.rigid_body = RigidBody{.geometries = {Geometry{.shape = Box{{1, 1, 0.1}}}}, .inertia = {.mass = mass}};
  const auto add = [&](const Shape& shape, const Vector3& place) {
    table.rigid_body->geometries.push_back({.shape = shape, .pose_in_entity = {place, {1, 0, 0, 0}}});
  };
  for (const double x : {-0.8, 0.8}) {
    for (const double y : {-0.8, 0.8}) add(Box{{0.1, 0.1, 0.4}}, {x, y, -0.5});
  }
  add(Sphere{0.2}, {0.5, 0, 0.3});
  add(Cylinder{0.2, 0.1}, {-0.5, 0, 0.2});
  add(Capsule{0.1, 0.1}, {0, 0.5, 0.3});
  add(Box{{0.2, 0.1, 0.1}}, {0, -0.5, 0.2});
  add(Sphere{0.1}, {0, 0, 0.2});
  table.rigid_body->auto_disable.enabled = false;
  return table;
}

// N*s per step on what is not static, of all contacts with what is.
double MeanPush(World& world) {
  world.TakeEvents();
  Steps(world, kAveraged);
  double sum = 0;
  for (const ContactPersisted& contact : Of<ContactPersisted>(world.TakeEvents())) {
    const auto is_ground = [&](EntityId id) {
      return world.scene().entities[id.index()]->desc->rigid_body->motion_type == MotionType::kStatic;
    };
    if (!is_ground(contact.pair.a) && !is_ground(contact.pair.b)) continue;
    for (const EventContactPoint& point : contact.points) sum += point.normal_impulse * std::abs(point.normal.z());
  }
  return sum / kAveraged;
}

WorldDesc Lying(const std::string& engine, double gravity, Solver solver) {
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -gravity}, .stepper = {.solver = solver}};
  desc.recorded_events.persisting_contacts = true;
  return desc;
}

struct Case {
  double mass, gravity, heading;
};

std::vector<Case> Cases() {
  Random random(21);
  std::vector<Case> cases{{1, 9.81, 0}};
  for (int i = 0; i < 4; ++i) {
    cases.push_back({random.LogUniform(1e-2, 1e3), random.Uniform(1.6, 25), random.Uniform(-3, 3)});
  }
  return cases;
}

// How near which solver comes. An engine that lacks the latter refuses it, and has passed with the former then.
constexpr std::pair<Solver, double> kSolvers[] = {{Solver::kIterative, kSwept}, {Solver::kDirect, kDirect}};

TEST_P(Weight, OfACompoundOfTenIsWhatItsContactsPush) {
  Proves({Claim::kContactImpulses, Claim::kCompound, Claim::kSolverIterative});
  for (const auto& [solver, error] : kSolvers) {
    if (solver == Solver::kDirect) Proves({Claim::kSolverDirect});
    for (const Case& c : Cases()) {
      const auto world = testing::MakeWorld(Lying(GetParam(), c.gravity, solver));
      Add(*world, TenGeometries(c.mass, c.heading));
      Steps(*world, 180);
      EXPECT_NEAR(MeanPush(*world) / (c.mass * c.gravity / 60), 1, error) << "mass " << c.mass;
    }
  }
}

TEST_P(Weight, OfAPileOfTenIsWhatTheFloorPushes) {
  Proves({Claim::kContactImpulses, Claim::kSolverIterative});
  const std::vector<Case> cases = Cases();
  for (const auto& [solver, error] : kSolvers) {
    // A solve of all of a pile at once is slow enough for fewer cases to do.
    for (const Case& c : std::span(cases).first(3)) {
      const auto world = testing::MakeWorld(Lying(GetParam(), c.gravity, solver));
      // Four below, three on them, two, and one.
      for (int layer = 0; layer < 4; ++layer) {
        for (int i = 0; i < 4 - layer; ++i) {
          EntityDesc brick = Body(Box{{0.5, 0.3, 0.25}}, {1.05 * (i + layer / 2.0), 0, 0.25 + 0.5 * layer}, c.mass);
          brick.rigid_body->auto_disable.enabled = false;
          Add(*world, brick);
        }
      }
      Steps(*world, 240);
      EXPECT_NEAR(MeanPush(*world) / (10 * c.mass * c.gravity / 60), 1, error) << "mass " << c.mass;
    }
  }
}

// The box of a tower with so many below it, and its mass as a part of the lowest one's.
using TowerOf = std::function<std::pair<Vector3, double>(int below, Random& random)>;

std::vector<TowerOf> Towers() {
  return {
      [](int, Random&) { return std::pair(Vector3(0.5, 0.5, 0.5), 1.0); },
      [](int, Random& random) {
        return std::pair(Vector3(random.Uniform(0.3, 0.6), random.Uniform(0.3, 0.6), random.Uniform(0.2, 0.5)), 1.0);
      },
      [](int below, Random&) { return std::pair(Vector3(0.5, 0.5, 0.5), below + 1.0); },
  };
}

TEST_P(Weight, OfATowerOfTenIsWhatTheFloorPushes) {
  Proves({Claim::kContactImpulses, Claim::kSolverIterative});
  const std::vector<Case> cases = Cases();
  for (const auto& [solver, error] : kSolvers) {
    for (const TowerOf& tower : Towers()) {
      for (const Case& c : std::span(cases).first(3)) {
        Random random(static_cast<uint64_t>(100 * c.gravity));
        const auto world = testing::MakeWorld(Lying(GetParam(), c.gravity, solver));
        double top = 0, mass = 0;
        for (int i = 0; i < 10; ++i) {
          const auto& [half, part] = tower(i, random);
          EntityDesc brick = Body(Box{half}, {random.Uniform(-0.02, 0.02), 0, top + half.z()}, part * c.mass);
          brick.rigid_body->auto_disable.enabled = false;
          Add(*world, brick);
          top += 2 * half.z();
          mass += part * c.mass;
        }
        Steps(*world, 240);
        EXPECT_NEAR(MeanPush(*world) / (mass * c.gravity / 60), 1, error) << "mass " << mass;
      }
    }
  }
}

TEST_P(Weight, IsOvercomeByALittleMore) {
  Proves({Claim::kContactImpulses});
  constexpr int kSteps = 30;
  for (const Case& c : Cases()) {
    for (const double part : {0.97, 1.03}) {
      const auto world = testing::MakeWorld(Lying(GetParam(), c.gravity, Solver::kAutomatic));
      EntityDesc crate = Crate({0, 0, 0.5}, 0.5, c.mass);
      crate.rigid_body->auto_disable.enabled = false;
      const EntityId id = Add(*world, crate);
      Steps(*world, 60);
      const double start = PositionOf(*world, id).z();
      Do(*world, ApplyForce{.id = id, .force = {0, 0, part * c.mass * c.gravity}, .steps = kSteps});
      Steps(*world, kSteps);

      const double time = kSteps / 60.0, risen = std::max(part - 1, 0.0) * c.gravity * time * time / 2;
      // The solver may let go a substep late, and take the depth of rest for an overlap.
      const double late = (part - 1) * c.gravity * time * SubstepOf(*world);
      EXPECT_NEAR(PositionOf(*world, id).z() - start, risen, 2 * std::max(late, kTouch)) << part << " of " << c.gravity;
    }
  }
}

TEST_P(Weight, OfASleeperIsStillTold) {
  Proves({Claim::kContactsOf, Claim::kContactImpulses});
  for (const Case& c : Cases()) {
    const auto world = testing::MakeWorld(Lying(GetParam(), c.gravity, Solver::kAutomatic));
    const EntityId low = Add(*world, Crate({0, 0, 0.5}, 0.5, c.mass));
    const EntityId high = Add(*world, Crate({0, 0, 1.4}, 0.4, 2 * c.mass));
    Steps(*world, 180);
    ASSERT_TRUE(Asleep(*world, low) && Asleep(*world, high));
    // Somebody else goes on, so that solves go on without the sleepers.
    Add(*world, Ball({50, 0, 100}));
    Steps(*world, 10);
    ASSERT_TRUE(Asleep(*world, low) && Asleep(*world, high));
    const double substep = SubstepOf(*world);
    for (const std::string& engine : {GetParam(), OtherEngine(GetParam())}) {
      Do(*world, SetEngine{engine});
      const Result<std::vector<EntityContact>> contacts = world->ContactsOf(low);
      ASSERT_TRUE(contacts.ok());
      ASSERT_EQ(contacts->size(), 2u);
      for (const EntityContact& contact : *contacts) {
        const double above = contact.other == high ? 2 : 3;
        double impulse = 0;
        for (const EventContactPoint& point : contact.points) impulse += point.normal_impulse;
        EXPECT_NEAR(impulse / (above * c.mass * c.gravity * substep), 1, kSwept) << "with " << contact.other.packed();
      }
    }
    Do(*world, ApplyImpulse{.id = high, .linear = {0, 0, 20 * c.mass}});
    Steps(*world, 5);
    EXPECT_EQ(world->ContactsOf(high)->size(), 0u) << "it flies";
  }
}

TEST_P(Weight, OfAChainIsWhatItsJointsHold) {
  Proves({Claim::kJointBall});
  // Solved all at once; links of whatever mass, in whatever order.
  for (const Case& c : Cases()) {
    const auto world = MakeSpace(GetParam(), {}, {0, 0, -c.gravity});
    Random random(static_cast<uint64_t>(1000 * c.gravity));
    std::vector<JointId> joints;
    std::vector<double> masses;
    EntityId above;
    for (int i = 0; i < 8; ++i) {
      masses.push_back(c.mass * random.LogUniform(0.2, 5));
      const EntityId link = Add(*world, Body(Capsule{0.05, 0.15}, {0, 0, -0.4 * i - 0.2}, masses.back()));
      joints.push_back(Join(*world, Between(above, link, BallJoint{}, Pose{{0, 0, i == 0 ? 0 : -0.2}, {1, 0, 0, 0}})));
      above = link;
    }
    Steps(*world, 60);
    double weight = 0;
    for (size_t i = joints.size(); i-- > 0;) {
      weight += masses[i] * c.gravity;
      EXPECT_NEAR(StateOf(*world, joints[i]).force.z() / weight, 1, kDirect) << "joint " << i << " mass " << c.mass;
    }
  }
}

}  // namespace
}  // namespace genphys::testing

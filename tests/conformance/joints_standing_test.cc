// What joints hold together stands on something and is hit from above. What bears it bears the blow, too: whoever is
// hit above where it stands goes nowhere, and Newton's law tells how what hit it is thrown back.
#include <algorithm>
#include <cmath>
#include <vector>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"
#include "support/smooth.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsStanding, Claim::kContacts, Claim::kRestitution, Claim::kBox, Claim::kSphere);

constexpr double kStep = 1.0 / 60;
constexpr double kGravity = 9.81;
constexpr double kRadius = 0.15;
const Vector3 kHalf(0.25, 0.15, 0.1);

JointKind KindOf(uint64_t seed) {
  SixDofJoint bent;
  bent.about[1] = JointAxis{};
  const std::vector<JointKind> kinds{BallJoint{},  HingeJoint{},    SliderJoint{}, UniversalJoint{},
                                     FixedJoint{}, DistanceJoint{}, WheelJoint{},  bent};
  return kinds[seed % kinds.size()];
}

struct Standing {
  std::vector<EntityId> bodies;
  std::vector<Vector3> tops;  // where something may fall on what stands, m
};

// Wide boxes on the floor, each on the one before. Returns how high they are, m.
double AddPlates(World& world, Random& random, int count, double restitution, std::vector<EntityId>& plates) {
  const Vector3 half(4, 1, 0.1);
  double top = 0;
  for (int i = 0; i < count; ++i) {
    const EntityDesc plate = Body(Box{half}, {1.5, 0, top + half.z()}, random.LogUniform(2, 50));
    plates.push_back(Add(world, Smooth(plate, restitution)));
    top += 2 * half.z();
  }
  return top;
}

// Boxes in a row, each joined to the next one; on one of them may lie another that is joined to its neighbour.
Standing AddRow(World& world, Random& random, const JointKind& kind, double restitution, double ground) {
  Standing standing;
  const int count = 2 + static_cast<int>(random.Uniform(0, 5));
  const double apart = 2 * kHalf.x() + 0.1;
  for (int i = 0; i < count; ++i) {
    const EntityDesc box = Body(Box{kHalf}, {apart * i, 0, ground + kHalf.z()}, random.LogUniform(0.3, 3));
    standing.bodies.push_back(Add(world, Smooth(box, restitution)));
    standing.tops.push_back({apart * i, 0, ground + 2 * kHalf.z()});
  }
  const Pose middle = FrameAlong(random.Direction(), {apart / 2, 0, 0});
  for (int i = 0; i + 1 < count; ++i) {
    Join(world,
         Between(standing.bodies[static_cast<size_t>(i)], standing.bodies[static_cast<size_t>(i + 1)], kind, middle));
  }
  if (random.Chance(0.5)) {
    standing.bodies.push_back(Add(world, Smooth(Body(Box{kHalf}, {0, 0, ground + 3 * kHalf.z()}), restitution)));
    Join(world, Between(standing.bodies[1], standing.bodies.back(), BallJoint{}, {{-apart / 2, 0, kHalf.z()}}));
    standing.tops[0].z() = ground + 4 * kHalf.z();
  }
  return standing;
}

// A top on four legs, the middle of which is at `foot`.
Standing AddTable(World& world, Random& random, const JointKind& kind, double restitution, const Vector3& foot,
                  const Vector3& top = {0.5, 0.4, 0.04}) {
  const Vector3 leg(0.05, 0.05, 0.3);
  const double height = 2 * (leg.z() + top.z());
  Standing table;
  const Vector3 middle = foot + Vector3(0, 0, height - top.z());
  table.bodies.push_back(Add(world, Smooth(Body(Box{top}, middle, 3), restitution)));
  for (const double x : {-top.x() + leg.x(), top.x() - leg.x()}) {
    for (const double y : {-top.y() + leg.y(), top.y() - leg.y()}) {
      table.bodies.push_back(Add(world, Smooth(Body(Box{leg}, foot + Vector3(x, y, leg.z()), 0.5), restitution)));
      const Vector3 axis = random.Chance(0.5) ? Vector3::UnitX() : Vector3::UnitY();
      Join(world, Between(table.bodies[0], table.bodies.back(), kind, FrameAlong(axis, {x, y, -top.z()})));
    }
  }
  table.tops.push_back(foot + Vector3(0, 0, height));
  return table;
}

// On what joints hold together, or another body, stands.
enum class Bearer { kFloor, kPlate, kTwoPlates, kTable };

double AddBearer(World& world, Random& random, Bearer bearer, double restitution, std::vector<EntityId>& bearers) {
  if (bearer != Bearer::kTable) return AddPlates(world, random, static_cast<int>(bearer), restitution, bearers);
  const std::vector<JointKind> kinds{FixedJoint{}, HingeJoint{}, UniversalJoint{}};
  const JointKind& kind = kinds[static_cast<size_t>(random.Uniform(0, 3))];
  const Standing table = AddTable(world, random, kind, restitution, {1.5, 0, 0}, {4, 1, 0.1});
  bearers = table.bodies;
  return table.tops.front().z();
}

// Something falls on what stands there.
void FallOnIt(const std::string& engine, uint64_t seed, Bearer bearer) {
  SCOPED_TRACE(seed);
  Random random(seed);
  const bool sleeps = seed % 2 == 0, is_table = seed % 3 == 0;
  const double restitution = random.Chance(0.3) ? 0 : random.Uniform(0.3, 0.9), fall = random.Uniform(0.5, 1.5);
  const auto world = FloorOf(engine, sleeps);
  const JointKind kind = is_table && seed % 2 == 0 ? JointKind(FixedJoint{}) : KindOf(seed / 2);
  std::vector<EntityId> bearers;
  const double ground = AddBearer(*world, random, bearer, restitution, bearers);
  Standing standing = is_table ? AddTable(*world, random, kind, restitution, {0, 0, ground})
                               : AddRow(*world, random, kind, restitution, ground);
  standing.bodies.insert(standing.bodies.end(), bearers.begin(), bearers.end());
  Steps(*world, 20);
  const Vector3& top =
      standing.tops[static_cast<size_t>(random.Uniform(0, 1) * static_cast<double>(standing.tops.size()))];
  const Vector3 beside(random.Uniform(-0.2, 0.2), random.Uniform(-0.1, 0.1), kRadius + fall);
  const double mass = random.LogUniform(0.1, 100);
  const EntityId ball = Add(*world, Smooth(Ball(top + beside, kRadius, mass), restitution));
  const double down = std::sqrt(2 * fall / kGravity), up = restitution * std::sqrt(2 * fall * kGravity);
  const int steps = static_cast<int>(down / kStep) + 1;
  Steps(*world, steps);
  double fastest = 0;
  for (const EntityId body : standing.bodies) fastest = std::max(fastest, VelocityOf(*world, body).norm());
  // They lie up to 2.5e-5 askew, and what is heavy and changes by up to 10 m/s throws 0.5 kg aside by so much. What
  // lies on something with legs is a little less at rest.
  const double unrest = bearer == Bearer::kTable ? 4e-3 : 1e-3;
  EXPECT_LT(fastest, unrest + 5e-4 * mass) << mass << " kg";
  const double since = restitution > 0 ? steps * kStep - down : 0;
  EXPECT_NEAR(PositionOf(*world, ball).z(), (top + beside).z() - fall + up * since - kGravity * since * since / 2,
              1e-3);
}

TEST_P(JointsStanding, AreNotDrivenIntoTheFloorByWhatFallsOnThem) {
  Proves({Claim::kJointBall, Claim::kJointHinge, Claim::kJointSlider, Claim::kJointUniversal, Claim::kJointFixed,
          Claim::kJointDistance, Claim::kJointWheel, Claim::kJointSixDof});
  for (uint64_t seed = 1; seed <= 96; ++seed) FallOnIt(GetParam(), seed, Bearer::kFloor);
}

TEST_P(JointsStanding, AreNotDrivenIntoBodiesThatTheyLieOnEither) {
  for (uint64_t seed = 1; seed <= 96; ++seed) {
    FallOnIt(GetParam(), seed, seed % 2 == 0 ? Bearer::kPlate : Bearer::kTwoPlates);
  }
}

TEST_P(JointsStanding, AreNotDrivenIntoOthersThatJointsHoldTogether) {
  for (uint64_t seed = 1; seed <= 90; ++seed) FallOnIt(GetParam(), seed, Bearer::kTable);
}

TEST_P(JointsStanding, BearWithTheFloorWhatHitsBodiesThatLieOnThem) {
  for (uint64_t seed = 1; seed <= 96; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double restitution = seed % 3 == 0 ? 0 : random.Uniform(0.3, 0.9), fall = random.Uniform(0.5, 1.5);
    const auto world = FloorOf(GetParam(), seed % 2 == 0);
    std::vector<EntityId> bodies;
    const double ground = AddBearer(*world, random, Bearer::kTable, restitution, bodies);
    const Vector3 from(random.Uniform(-2, 5), random.Uniform(-0.8, 0.8), ground + 2 * kHalf.z() + kRadius + fall);
    bodies.push_back(Add(*world, Smooth(Body(Box{kHalf}, {from.x(), from.y(), ground + kHalf.z()}), restitution)));
    Steps(*world, 20);
    const double mass = random.LogUniform(0.1, 100);
    const EntityId ball = Add(*world, Smooth(Ball(from, kRadius, mass), restitution));
    const double down = std::sqrt(2 * fall / kGravity), up = restitution * std::sqrt(2 * fall * kGravity);
    const int steps = static_cast<int>(down / kStep) + 1;
    Steps(*world, steps);
    // Some of those awake show what half of a substep of their weight gives them.
    const double fallen = kGravity * kStep / 4;
    double fastest = 0;
    for (const EntityId body : bodies) fastest = std::max(fastest, VelocityOf(*world, body).norm());
    EXPECT_LT(fastest, fallen + 1e-3 + 5e-4 * mass) << mass << " kg";
    const double since = restitution > 0 ? steps * kStep - down : 0;
    EXPECT_NEAR(PositionOf(*world, ball).z(), from.z() - fall + up * since - kGravity * since * since / 2, 1e-3);
  }
}

}  // namespace
}  // namespace genphys::testing

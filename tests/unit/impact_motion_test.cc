#include "core/src/impacts/impact_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/random.h"

namespace genphys {
namespace {

using testing::Random;

constexpr double kReach = 3;  // m
constexpr double kTime = 1.0 / 60;
constexpr int kPoints = 30;
constexpr int kMoments = 16;

// How far a point of the body is off the straight line between where it is at the ends, at most.
double BowOf(const ImpactMotion& motion, const Vector3& center, const Vector3& point) {
  const auto at = [&](double time) { return motion.PoseBefore(time).Transform(center + point); };
  const Vector3 start = at(kTime), way = at(0) - start;
  double bow = 0;
  for (int i = 1; i < kMoments; ++i) {
    const double part = static_cast<double>(i) / kMoments;
    const Vector3 off = at(kTime * (1 - part)) - start;
    const double along = way.squaredNorm() > 0 ? std::clamp(off.dot(way) / way.squaredNorm(), 0.0, 1.0) : 0;
    bow = std::max(bow, (off - along * way).norm());
  }
  return bow;
}

double BowOf(const ImpactMotion& motion, const Vector3& center, Random& random) {
  double bow = 0;
  for (int i = 0; i < kPoints; ++i) {
    bow = std::max(bow, BowOf(motion, center, kReach * random.Direction()));
  }
  return bow;
}

MassProperties RandomMass(Random& random) {
  // Of three masses on the axes, so that moments are as bodies may have them, slender ones too.
  const Vector3 squares(random.LogUniform(1e-4, 1), random.LogUniform(1e-4, 1), random.LogUniform(1e-4, 1));
  MassProperties mass;
  mass.mass = 1;
  mass.center_of_mass = random.Vector(1);
  mass.tensor = Vector3(squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y()).asDiagonal();
  mass.inverse_tensor = mass.tensor.inverse();
  return mass;
}

Pose RandomPose(Random& random) {
  const Vector3 turn = random.Vector(3);
  return {random.Vector(5), Quaternion(Eigen::AngleAxisd(turn.norm(), turn.normalized()))};
}

TEST(ImpactMotion, OfAFreeBodyBowsNoMoreThanItSays) {
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const MassProperties mass = RandomMass(random);
    const double spin = random.LogUniform(0.1, 80);
    const auto motion =
        ImpactMotion::Free(RandomPose(random), mass, random.Vector(10), spin * random.Direction(), random.Vector(100));

    const double most = motion.BowMax(kTime, kReach);

    EXPECT_LE(BowOf(motion, mass.center_of_mass, random), most);
    // Rather than nothing at all: as much as the spin takes a point off its chord, a few times.
    if (spin * kTime < 0.5) {
      EXPECT_LE(most, kTime * kTime / 8 * (200 + 4 * kReach * spin * spin));
    }
  }
}

TEST(ImpactMotion, OfADrivenBodyBowsNoMoreThanItSays) {
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Vector3 spin = random.LogUniform(0.1, 300) * random.Direction();
    const auto motion = ImpactMotion::Driven(RandomPose(random), random.Vector(10), spin);

    EXPECT_LE(BowOf(motion, Vector3::Zero(), random), motion.BowMax(kTime, kReach));
  }
}

TEST(ImpactMotion, ThatJointsLeadBowsNoMoreThanItSays) {
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const MassProperties mass = RandomMass(random);
    const Pose start = RandomPose(random);
    const Vector3 turn = random.LogUniform(1e-3, 1) * random.Direction();
    const Pose end{start.position + random.Vector(0.3),
                   Quaternion(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * start.orientation};
    const Vector3 spin = turn / kTime + random.Vector(5), torque = random.Vector(10 * mass.tensor.trace());
    const auto motion =
        ImpactMotion::Along(start, kTime, end, mass, random.Vector(10), spin, random.Vector(100), torque);

    EXPECT_LE(BowOf(motion, mass.center_of_mass, random), motion.BowMax(kTime, kReach));
  }
}

TEST(ImpactMotion, ThatTurnsTooFastToSayBowsWithoutBound) {
  const MassProperties mass{.mass = 1, .tensor = Matrix3::Identity(), .inverse_tensor = Matrix3::Identity()};
  const auto motion = ImpactMotion::Free({}, mass, Vector3::Zero(), {0, 0, 2 / kTime}, Vector3::Zero());

  EXPECT_EQ(motion.BowMax(kTime, kReach), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace genphys

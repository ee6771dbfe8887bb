#include "core/src/impacts/settling.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>
#include <vector>

namespace genphys {
namespace {

// Two bodies that collide anyhow, with any friction, one of them perhaps of far more mass, or a thin rod.
struct Collision {
  explicit Collision(uint32_t seed) : generator(seed) {
    bodies = {Any(), Any()};
    blow = {.body_a = 0,
            .body_b = 1,
            .position = {Number(), Number(), Number()},
            .normal = Vector3(Number(), Number(), Number()).normalized(),
            .friction = std::pow(10.0, Number())};
    blow.separation_speed = -0.5 * RelativeVelocity(blow, bodies).dot(blow.normal);
  }

  double Number() { return std::uniform_real_distribution<double>(-1, 1)(generator); }

  StruckBody Any() {
    StruckBody body;
    const double mass = std::pow(10.0, 2 * Number());
    const Quaternion turn = Quaternion(Number(), Number(), Number(), Number()).normalized();
    const Vector3 moments = mass * Vector3(0.1, 0.2, 0.15 + 0.14 * Number());
    body.center = {Number(), Number(), Number()};
    body.linear_velocity = 3 * Vector3(Number(), Number(), Number());
    body.angular_velocity = 5 * Vector3(Number(), Number(), Number());
    body.inverse_mass = 1 / mass;
    body.tensor = turn.toRotationMatrix() * moments.asDiagonal() * turn.toRotationMatrix().transpose();
    body.inverse_tensor = body.tensor.inverse();
    return body;
  }

  // Returns by how much a second turn changes what the first one came to, m/s.
  double Settle() {
    Ties free;
    std::vector<Passed> passed;
    std::vector<Speeds> speeds;
    for (const StruckBody& body : bodies) speeds.push_back({Pad(body.linear_velocity), Pad(body.angular_velocity)});
    Settling settling(blow, bodies, free, passed);
    settling.Settle(speeds, passed);
    const double again = settling.Settle(speeds, passed);
    settling.Finish();
    for (size_t i = 0; i < bodies.size(); ++i) {
      bodies[i].linear_velocity = speeds[i].linear.head<3>();
      bodies[i].angular_velocity = speeds[i].angular.head<3>();
    }
    return again;
  }

  // m/s, along the normal and across it.
  double Parting() const { return RelativeVelocity(blow, bodies).dot(blow.normal); }
  Vector3 Slip() const { return RelativeVelocity(blow, bodies) - Parting() * blow.normal; }

  std::mt19937 generator;
  std::vector<StruckBody> bodies;
  Blow blow;
};

TEST(Settling, LeavesABlowAtOnceAsNewtonAndCoulombSay) {
  int parting = 0, stuck = 0, slipping = 0;
  for (uint32_t seed = 1; seed <= 2000; ++seed) {
    SCOPED_TRACE(seed);
    Collision collision(seed);
    EXPECT_LE(collision.Settle(), 1e-11);
    const Blow& blow = collision.blow;
    const double bound = blow.friction * blow.impulse;
    ASSERT_GE(blow.impulse, 0);
    EXPECT_LE(blow.rubbing.norm(), bound * (1 + 1e-12));
    EXPECT_NEAR(blow.rubbing.dot(blow.normal), 0, 1e-12 * bound);
    if (blow.impulse == 0) {
      EXPECT_GE(collision.Parting(), blow.separation_speed);
      ++parting;
      continue;
    }
    EXPECT_NEAR(collision.Parting(), blow.separation_speed, 1e-11);
    const Vector3 slip = collision.Slip();
    if (slip.norm() < 1e-11) {
      ++stuck;
    } else {
      // All of friction, and against what is left.
      EXPECT_NEAR(blow.rubbing.norm(), bound, 1e-12 * bound);
      EXPECT_LE((blow.rubbing / bound + slip.normalized()).norm() * slip.norm(), 1e-10);
      ++slipping;
    }
  }
  EXPECT_GT(parting, 300);
  EXPECT_GT(stuck, 300);
  EXPECT_GT(slipping, 300);
}

TEST(Settling, LeavesASlipAloneThatNoFrictionBrakes) {
  Collision collision(1);
  for (uint32_t seed = 2; collision.blow.separation_speed <= 0; ++seed) collision = Collision(seed);
  collision.blow.friction = 0;
  collision.Settle();
  EXPECT_GT(collision.blow.impulse, 0);
  EXPECT_TRUE(collision.blow.rubbing.isZero(0));
  EXPECT_NEAR(collision.Parting(), collision.blow.separation_speed, 1e-12);
}

// What lands on something immovable and is locked along some axes.
Collision Landing(const Vector3& freedom, const Vector3& velocity) {
  StruckBody body;
  body.inverse_mass = 1;
  body.freedom = freedom;
  body.linear_velocity = velocity;
  Collision collision(1);
  collision.bodies = {StruckBody(), body};
  collision.blow = {.body_a = 0, .body_b = 1, .friction = 0.5, .separation_speed = 0.25};
  return collision;
}

TEST(Settling, StopsWhatIsLockedAcrossItsWay) {
  Collision collision = Landing({1, 0, 1}, {0.3, 0, -1});
  EXPECT_LE(collision.Settle(), 1e-12);
  EXPECT_LE((collision.blow.rubbing - Vector3(-0.3, 0, 0)).norm(), 1e-12);
  EXPECT_LE((collision.bodies[1].linear_velocity - Vector3(0, 0, 0.25)).norm(), 1e-12);
}

TEST(Settling, LetsWhatIsLockedAlongItsSlipBounceAlone) {
  Collision collision = Landing({0, 0, 1}, {2, 0, -1});
  collision.Settle();
  EXPECT_NEAR(collision.blow.impulse, 1.25, 1e-12);
  EXPECT_LE((collision.bodies[1].linear_velocity - Vector3(2, 0, 0.25)).norm(), 1e-12);
}

}  // namespace
}  // namespace genphys

#include "core/src/impacts/impact_solve.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace genphys {
namespace {

constexpr double kRestitution = 0.9;

StruckBody Moving(const Vector3& moments, const Vector3& velocity, const Vector3& spin) {
  StruckBody body;
  body.inverse_mass = 1;
  body.tensor = moments.asDiagonal();
  body.inverse_tensor = body.tensor.inverse();
  body.linear_velocity = velocity;
  body.angular_velocity = spin;
  return body;
}

double EnergyOf(const StruckBody& body) {
  return (body.linear_velocity.squaredNorm() + body.angular_velocity.dot(body.tensor * body.angular_velocity)) / 2;
}

// Of `body` on the immovable body 0, from below.
Blow FromBelow(uint32_t body, const Vector3& position, double friction, const std::vector<StruckBody>& bodies) {
  Blow blow{.body_a = 0, .body_b = body, .position = position, .friction = friction};
  blow.separation_speed = -kRestitution * RelativeVelocity(blow, bodies).z();
  return blow;
}

// A rod of 1 m and 1 kg that hits the ground at one end, aslant and spinning: Newton's law and Coulomb's together ask
// for a fifth more energy than it has.
struct Rod {
  static constexpr double kSlant = 0.613;  // rad, from upright
  static constexpr double kFriction = 0.392;

  static StruckBody Body() { return Moving({1 / 12.0, 1 / 12.0, 1e-3}, {0.341, 0, -1}, {0, 4.696, 0}); }
  static Vector3 End() { return {0.5 * std::sin(kSlant), 0, -0.5 * std::cos(kSlant)}; }
};

TEST(Restitute, GivesNobodyEnergyThatNewtonAndCoulombTogetherAskFor) {
  std::vector<StruckBody> bodies{StruckBody(), Rod::Body()};
  const Blow blow = FromBelow(1, Rod::End(), Rod::kFriction, bodies);
  Ties free;
  std::vector<StruckBody> as_asked = bodies;
  std::array<Blow, 1> asked{blow}, restituted{blow};
  SolveBlows(asked, as_asked, free);
  ASSERT_GT(EnergyOf(as_asked[1]), 1.15 * EnergyOf(bodies[1]));
  const double before = EnergyOf(bodies[1]);
  Restitute(restituted, bodies, free);
  EXPECT_LE(EnergyOf(bodies[1]), before * (1 + 1e-12));
  // All that there is, for it asks for more.
  EXPECT_NEAR(EnergyOf(bodies[1]), before, 1e-9 * before);
  EXPECT_GT(RelativeVelocity(restituted[0], bodies).z(), 0);
}

TEST(Restitute, TakesNothingFromThoseWhoHitNobodyOfThese) {
  std::vector<StruckBody> bodies{StruckBody(), Rod::Body(),
                                 Moving(Vector3::Constant(0.1), {0, 0, -2}, Vector3::Zero())};
  bodies[2].center = {10, 0, 0};
  std::array<Blow, 2> blows{FromBelow(1, Rod::End(), Rod::kFriction, bodies), FromBelow(2, {10, 0, -0.5}, 0.5, bodies)};
  const double rods = EnergyOf(bodies[1]);
  Ties free;
  Restitute(blows, bodies, free);
  EXPECT_LE(EnergyOf(bodies[1]), rods * (1 + 1e-12));
  EXPECT_NEAR(bodies[2].linear_velocity.z(), kRestitution * 2, 1e-15);
}

// A box that lands on its four corners, sliding and turning a little. Where a corner separates as it is to, friction is
// within the disc and against the slip; where it separates faster, nothing pushes. Sweeps end where they hardly change
// anything any more: by at most 1e-4 of the first change, or of what each changes less than 0.92 of the one before.
TEST(Restitute, LeavesAtEachOfManyPointsTheLawsOfNewtonAndCoulomb) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> number(-1, 1);
  const double speed_tolerance = 2 * 1e-4 / (1 - 0.92) * 2;  // m/s
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(trial);
    std::vector<StruckBody> bodies{StruckBody(),
                                   Moving({0.1, 0.12, 0.15}, {number(generator), number(generator), -2},
                                          0.3 * Vector3(number(generator), number(generator), number(generator)))};
    std::vector<Blow> blows;
    for (const double x : {-0.4, 0.4}) {
      for (const double y : {-0.3, 0.3}) blows.push_back(FromBelow(1, {x, y, -0.2}, 0.4, bodies));
    }
    Ties free;
    Restitute(blows, bodies, free);
    for (const Blow& blow : blows) {
      const Vector3 left = RelativeVelocity(blow, bodies);
      EXPECT_GE(left.z(), blow.separation_speed - speed_tolerance);
      EXPECT_GE(blow.impulse, 0);
      EXPECT_LE(blow.rubbing.norm(), 0.4 * blow.impulse * (1 + 1e-12));
      if (blow.impulse > 1e-2) {
        EXPECT_NEAR(left.z(), blow.separation_speed, speed_tolerance);
      }
      const Vector3 slip(left.x(), left.y(), 0);
      if (slip.norm() > 0.1 && blow.impulse > 1e-2) {
        EXPECT_LE(blow.rubbing.dot(slip), -0.95 * 0.4 * blow.impulse * slip.norm());
      }
    }
  }
}

// Onto a crate of 1 kg that stands on its four corners something comes down whose mass lies between these. Of how many
// such blows every one obeys the laws in the end.
int SolvedOf(int trials, double lightest, double heaviest) {
  std::mt19937 generator(2);
  std::uniform_real_distribution<double> number(-1, 1);
  int solved = 0;
  for (int trial = 0; trial < trials; ++trial) {
    StruckBody crate = Moving(Vector3::Constant(1 / 6.0), Vector3::Zero(), Vector3::Zero());
    StruckBody ball = Moving(Vector3::Constant(0.1), {number(generator), number(generator), -3}, Vector3::Zero());
    const double mass = lightest * std::pow(heaviest / lightest, (number(generator) + 1) / 2);
    ball.inverse_mass /= mass;
    ball.tensor *= mass;
    ball.inverse_tensor /= mass;
    const Vector3 top(0.4 * number(generator), 0.4 * number(generator), 0.5);
    ball.center = top + Vector3(0, 0, 0.5);
    std::vector<StruckBody> bodies{StruckBody(), crate, ball};
    std::vector<Blow> blows{{.body_a = 1, .body_b = 2, .position = top, .friction = 0.4}};
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        blows.push_back({.body_a = 0, .body_b = 1, .position = {x, y, -0.5}, .friction = 0.5});
      }
    }
    Ties free;
    SolveBlows(blows, bodies, free);
    double worst = 0;
    for (const Blow& blow : blows) {
      const Vector3 left = RelativeVelocity(blow, bodies);
      const double parting = left.dot(blow.normal);
      worst = std::max({worst, -parting, blow.impulse > 1e-6 ? parting : 0});
      EXPECT_GE(blow.impulse, 0);
      const bool sticks = blow.rubbing.norm() < 0.999 * blow.friction * blow.impulse;
      if (sticks && blow.impulse > 1e-6) worst = std::max(worst, (left - parting * blow.normal).norm());
    }
    solved += worst < 1e-9;
  }
  return solved;
}

// With sweeps alone: none of them, and 172 of the next ones.
TEST(SolveBlows, EndsAtTheLawsHoweverUnevenTheMassesAre) { EXPECT_GE(SolvedOf(300, 10, 1000), 295); }

TEST(SolveBlows, EndsAtTheLawsWhereSeveralHitOneBody) { EXPECT_GE(SolvedOf(300, 0.1, 8), 297); }

// A column of `count` bodies with a body on it that falls, each touching the next at a point, on the immovable body 0.
struct Column {
  Column(uint32_t count, double mass) : bodies(count + 2) {
    for (uint32_t i = 1; i < bodies.size(); ++i) {
      bodies[i] = Moving(Vector3::Constant(0.1), Vector3::Zero(), Vector3::Zero());
      bodies[i].center.z() = i;
    }
    bodies.back().linear_velocity.z() = -1;
    bodies.back().inverse_mass = 1 / mass;
    for (uint32_t i = count + 1; i > 0; --i) {
      blows.push_back({.body_a = i - 1, .body_b = i, .position = {0, 0, i - 0.5}, .friction = 0.5});
    }
    blows.front().separation_speed = kRestitution;
  }
  std::vector<StruckBody> bodies;
  std::vector<Blow> blows;
};

TEST(Restitute, HandsABlowDownToTheGroundHoweverManyBearIt) {
  for (const double mass : {0.1, 1.0, 100.0}) {
    Column column(60, mass);
    for (Blow& blow : column.blows) blow.borne = Borne::kB;
    Ties free;
    Restitute(column.blows, column.bodies, free);
    EXPECT_NEAR(column.bodies.back().linear_velocity.z(), kRestitution, 1e-12);
    for (size_t i = 1; i + 1 < column.bodies.size(); ++i) {
      EXPECT_NEAR(column.bodies[i].linear_velocity.z(), 0, 1e-12);
    }
    EXPECT_NEAR(column.blows.back().impulse, mass * (1 + kRestitution), 1e-10 * mass);
  }
}

TEST(Restitute, FindsTheSameWhereThoseGiveWayThatAreSaidToBear) {
  for (const double mass : {0.1, 1.0, 10.0}) {
    Column known(3, mass), unknown(3, mass);
    for (Column* column : {&known, &unknown}) column->blows.pop_back();  // nothing bears the lowest one
    for (Blow& blow : known.blows) blow.borne = Borne::kB;
    Ties free;
    Restitute(known.blows, known.bodies, free);
    Restitute(unknown.blows, unknown.bodies, free);
    for (size_t i = 0; i < known.bodies.size(); ++i) {
      EXPECT_NEAR(known.bodies[i].linear_velocity.z(), unknown.bodies[i].linear_velocity.z(), 1e-9);
    }
  }
}

// Of what a row of ten bodies still lacks sweeps leave nine tenths each.
TEST(SolveBlows, EndsAtTheLawsWhereSweepsAreSlow) {
  for (const uint32_t count : {9u, 10u, 11u}) {
    Column column(count, 1);
    column.blows.pop_back();  // nothing bears the lowest one
    column.blows.front().separation_speed = 0;
    Ties free;
    SolveBlows(column.blows, column.bodies, free);
    for (size_t i = 1; i < column.bodies.size(); ++i) {
      EXPECT_NEAR(column.bodies[i].linear_velocity.z(), -1.0 / (count + 1), 1e-8) << count << " bodies";
    }
  }
}

// A bar that hangs on something which moves along by itself, steeply before where it is held: what the ground gives it
// makes it rub, and that presses it down by many times as much. At such a speed no number tells how hard.
TEST(SolveBlows, LeaveAloneWhatWouldRunAway) {
  for (const double lead : {0.1, 0.05, 0.03}) {
    const Vector3 velocity(-1e305, 0, -1e304);
    std::vector<StruckBody> bodies{{}, Moving({1, 1, 1}, velocity, {0, 0, 0})};
    std::vector<JointBody> held(2);
    held[0].linear_velocity = held[1].linear_velocity = velocity;
    held[1].row = EntityRow{1};
    held[1].inverse_mass = 1;
    held[1].inverse_tensor.setIdentity();
    std::vector<JointRow> rows;
    for (int axis = 0; axis < 3; ++axis) {
      rows.push_back({.b = EntityRow{1}, .axis = Vector3::Unit(axis), .softness = 1e-8});
    }
    Ties ties;
    ASSERT_TRUE(ties.Add(std::array<uint32_t, 1>{1}, held, rows, {0, 0, 0}));
    std::vector<Blow> blows{{.body_a = 0, .body_b = 1, .position = {-lead, 0, -1}, .friction = 0.5}};

    SolveBlows(blows, bodies, ties);

    EXPECT_EQ(blows[0].impulse, 0) << lead;
    EXPECT_EQ(bodies[1].linear_velocity, velocity) << lead;
    EXPECT_EQ(bodies[1].angular_velocity, Vector3(0, 0, 0)) << lead;
  }
}

}  // namespace
}  // namespace genphys

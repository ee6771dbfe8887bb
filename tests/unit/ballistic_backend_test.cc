#include "genphys/backends/ballistic.h"

#include <gtest/gtest.h>

#include <cmath>

namespace genphys {
namespace {

constexpr double kStep = 1.0 / 60;
constexpr double kRounding = 1e-12;

/// One body on its own in a world that knows only flight.
struct Flight {
  explicit Flight(const MassProperties& mass, const Pose& pose = {}) {
    state.Resize(1);
    state.ids[0] = EntityId(0, 1);
    state.set_pose(row, pose);
    const RigidBody body;
    world->AddBody({.row = row, .id = state.ids[0], .body = body, .mass = mass, .geometries = {}}, state);
  }

  void Move(double time) { world->Solve(time, {&row, 1}, state, contacts, {}); }

  EntityRow row{0};
  StateArrays state;
  ContactBuffer contacts;
  std::unique_ptr<BackendWorld> world = MakeBallisticBackend()->CreateWorld(StepperSettings{});
};

TEST(BallisticBackend, ListsNeitherContactsNorRaysNorSensors) {
  const auto backend = MakeBallisticBackend();
  EXPECT_TRUE(backend->SelfTest().ok());
  EXPECT_EQ(backend->capabilities().engine(), "ballistic");
  EXPECT_TRUE(backend->capabilities().Has(Feature::kShapeBox));
  for (Feature lacking : {Feature::kContacts, Feature::kRayCasts, Feature::kSensors, Feature::kShapePlane,
                          Feature::kSolverIterative, Feature::kSolverDirect}) {
    EXPECT_FALSE(backend->capabilities().Has(lacking)) << NameOf(lacking);
  }
}

TEST(BallisticBackend, TakesWhatIsSetBeforeWhatThePresetMeans) {
  const auto backend = MakeBallisticBackend();
  StepperDesc stepper;
  stepper.quality = Quality::kAccurate;
  EXPECT_EQ(backend->Resolve(stepper).substeps, 4u);
  stepper.substeps = 7;
  EXPECT_EQ(backend->Resolve(stepper).substeps, 7u);
}

TEST(BallisticBackend, MovesABodyByItsVelocityAndKeepsThat) {
  Flight flight{MassProperties{}};
  flight.state.linear_velocities.col(0) = Vector3(1, -2, 3);
  flight.state.angular_velocities.col(0) = Vector3(0, 0, 6);

  flight.Move(0.25);

  EXPECT_EQ(flight.state.positions.col(0), Vector3(0.25, -0.5, 0.75));
  const Quaternion turned(Eigen::AngleAxisd(1.5, Vector3::UnitZ()));
  EXPECT_LT(flight.state.pose(flight.row).orientation.angularDistance(turned), kRounding);
  EXPECT_EQ(flight.state.linear_velocities.col(0), Vector3(1, -2, 3));
  EXPECT_EQ(flight.state.angular_velocities.col(0), Vector3(0, 0, 6));
}

TEST(BallisticBackend, LeavesAMotionlessBodyBitForBitWhereItIs) {
  MassProperties mass;
  mass.center_of_mass = {0.1, 0.2, 0.3};
  const Pose pose{{0.4, 0.5, 0.6}, Quaternion(0.1, 0.2, 0.3, 0.4).normalized()};
  Flight flight(mass, pose);

  flight.Move(kStep);

  EXPECT_EQ(flight.state.pose(flight.row), pose);
}

TEST(BallisticBackend, TurnsABodyAboutItsCentreOfMass) {
  MassProperties mass;
  mass.center_of_mass = {1, 0, 0};
  Flight flight(mass);
  flight.state.angular_velocities.col(0) = Vector3(0, 0, M_PI);

  for (int i = 0; i < 60; ++i) flight.Move(kStep);

  EXPECT_LT((flight.state.positions.col(0) - Vector3(2, 0, 0)).norm(), kRounding);
}

TEST(BallisticBackend, FallsAsTheLayersKicksSay) {
  constexpr double kGravity = 9.81;
  constexpr int kSteps = 60;
  Flight flight{MassProperties{}};

  for (int i = 0; i < kSteps; ++i) {
    flight.state.linear_velocities(2, 0) -= kGravity * kStep;
    flight.Move(kStep);
  }

  // Kick, then move: g h^2 (1 + 2 + ... + n).
  const double fallen = kGravity * kStep * kStep * kSteps * (kSteps + 1) / 2;
  EXPECT_NEAR(flight.state.positions(2, 0), -fallen, kRounding);
}

TEST(BallisticBackend, KeepsAUnitQuaternionThroughAMillionTurns) {
  Flight flight{MassProperties{}};
  flight.state.angular_velocities.col(0) = Vector3(300, -200, 100);

  for (int i = 0; i < 1'000'000; ++i) flight.Move(kStep);

  EXPECT_NEAR(flight.state.orientations.col(0).norm(), 1, 1e-15);
}

TEST(BallisticBackend, FindsNoContacts) {
  Flight flight{MassProperties{}};

  flight.world->FindPoints(GeometryRow{0}, GeometryRow{1}, flight.contacts.points);

  EXPECT_TRUE(flight.contacts.points.empty());
}

}  // namespace
}  // namespace genphys

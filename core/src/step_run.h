#pragma once
#include <chrono>
#include <vector>

#include "field_forces.h"
#include "genphys/world.h"
#include "joint_step.h"
#include "restitution.h"
#include "touching.h"

namespace genphys {

/// One step of one world, from the boundary before it to the boundary after it.
class StepRun {
 public:
  StepRun(World& world, double step_size);

  /// DIVERGED leaves the columns as they were.
  Status Run();

 private:
  // Columns of a row to go back to.
  struct Saved {
    EntityRow row{};
    Pose pose;
    Vector3 linear_velocity = Vector3::Zero();
    Vector3 angular_velocity = Vector3::Zero();
    bool asleep = false;
  };

  // What the layer keeps of a moving dynamic body over a substep.
  struct Mover {
    EntityRow row{};
    Vector3 linear_start = Vector3::Zero();    // at the start of the step
    Vector3 momentum_start = Vector3::Zero();  // angular, at the start of the step
    Vector3 momentum = Vector3::Zero();        // angular, with this substep's torque
    Vector3 spin_given = Vector3::Zero();      // the engine was given
    Matrix3 tensor = Matrix3::Zero();          // world, at the start of the substep
  };

  void Advance();
  void CollectRows();
  void CollideAndWake();
  bool WakeTouched();
  bool WillTouch(const ContactPair& pair) const;
  void WakeCarried(std::vector<EntityRow>& carried) const;
  void FinishJoints();
  void Substep(double h);
  void KickRow(Mover& mover, double h);
  void GatherForces(double h);
  Vector3 CenterOf(EntityRow row) const;
  Vector3 VelocityAt(EntityRow row, const Vector3& center, const Vector3& point) const;
  void ChooseFriction();
  void Unkick();
  void Bounce(double h);
  void LimitSpeeds();
  void MoveKinematic(double h);
  void FillRelativeVelocities();
  void Save(EntityRow row, bool asleep);
  void Restore();
  void AddMover(EntityRow row);
  bool IsDynamic(EntityRow row) const;
  bool Fits(EntityRow row) const;
  void Retire(EntityRow row);
  void RetireStrays();
  void FinishNetForces();
  void CountForcesDown();
  void Report();
  void FillStats();
  MovingBody BodyOf(EntityRow row) const;
  void Mark(std::string_view stage);

  World& world_;
  double step_size_;
  double substep_ = 0;  // s
  StateArrays& state_;
  FieldForces fields_;
  std::vector<Saved> saved_;
  std::vector<Mover> movers_;
  std::vector<EntityRow> rows_;            // of movers_, ascending
  std::vector<EntityRow> kinematic_rows_;  // active ones, ascending
  std::vector<Wrench> wrenches_;           // by row; empty when nothing is applied at all
  std::vector<uint8_t> tested_;            // rows that were active in some Collide() of this step
  std::vector<double> approach_;           // per contact point, m/s, as given to the engine
  StepTouches touches_;
  JointStep joints_;
  std::vector<JointBroke> broken_;
  std::vector<EntityId> faulted_;
  std::chrono::steady_clock::time_point mark_;
};

}  // namespace genphys

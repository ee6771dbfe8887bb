#pragma once
#include <span>
#include <vector>

#include "genphys/contact.h"
#include "genphys/joint_row.h"
#include "genphys/row_marks.h"
#include "genphys/scene.h"
#include "genphys/state.h"

namespace genphys {

/// Leaves out what lies along locked axes.
void DropLocked(const LockedAxes& locks, Vector3& linear_velocity, Vector3& angular_velocity);

/// The spin that the locks leave of `spin`: the angular momentum about the free axes stays, and the locks take the
/// rest. `tensor` is in world axes.
Vector3 LockedSpin(const LockedAxes& locks, const Matrix3& tensor, const Vector3& spin);

/// The inverse of `tensor` (world axes) for a body that cannot turn about locked axes.
Matrix3 LockedInverse(const LockedAxes& locks, const Matrix3& tensor);

/// Appends the rows that hold a body along its locked axes, with its centre of mass there (m, world).
void WriteLocks(const LockedAxes& locks, const MassProperties& mass, EntityRow row, const Vector3& center,
                const Quaternion& orientation, std::vector<JointRow>& joint_rows);

/// The bodies of one step that have locked axes. What touches or is joined to them is solved together with rows that
/// hold them, so that they are as heavy along their axes as they should be; what a solver leaves over is taken away, so
/// that what is locked does not drift by a bit. Arguments outlive this object.
class LockedBodies {
 public:
  LockedBodies(const Scene& scene, StateArrays& state) : scene_(scene), state_(state) {}

  /// Takes those of the dynamic `rows` that have locked axes, where they are before a solve, and lets no velocity lie
  /// along these.
  void Begin(std::span<const EntityRow> rows);
  /// Appends to `joint_rows`, which it returns, the rows that hold those which a contact or one of `joint_rows` may
  /// push.
  std::vector<JointRow>& Write(const ContactBuffer& contacts, std::vector<JointRow>& joint_rows);
  /// Brings back what moved along locked axes since Begin(). Returns whose poses it changed.
  std::span<const EntityRow> Finish();
  /// The same of those of `among` alone: rounding moves whoever is brought back once more.
  void Finish(const RowMarks& among);
  /// Lets no velocity lie along locked axes.
  void DropVelocities();
  /// Takes a row that moves from here on, after Begin(), if it has locked axes.
  void Hold(EntityRow row);
  /// Leaves a row alone from here on.
  void Forget(EntityRow row);

 private:
  struct Held {
    Vector3 center = Vector3::Zero();  // of mass, m, world
    Quaternion orientation = Quaternion::Identity();
    bool may_be_pushed = false;
  };

  void BringBack(EntityRow row, const Held& held);
  void DropVelocity(EntityRow row);
  const LockedAxes& locks(EntityRow row) const;
  const MassProperties& mass(EntityRow row) const { return scene_.entities[Index(row)]->mass; }

  const Scene& scene_;
  StateArrays& state_;
  std::vector<EntityRow> rows_;  // ascending
  std::vector<Held> held_;       // parallel to rows_
};

}  // namespace genphys

#pragma once
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "genphys/error_correction.h"
#include "genphys/joint.h"
#include "genphys/joint_row.h"
#include "genphys/layer_state.h"
#include "joints/joint_body.h"

namespace genphys {

/// No error is taken away faster than this (m/s): what was joined far apart comes together without a bang.
inline constexpr double kCorrectionSpeedMax = 10;

/// What gets nowhere is asked for no more slowly than this (m/s and rad/s): see JointState::haste.
inline constexpr double kCreepingSpeed = 0.05;
inline constexpr double kCreepingSpin = 0.1;

/// Softness of a hard row, of its own mobility. Where rows say the same thing twice a direct solver divides by what is
/// left; what hangs on such a row gives way by 1e-8 of what it would fall.
inline constexpr double kLeastSoftness = 1e-8;

/// A coordinate of a joint at the present poses: rate = axis * (relative velocity or spin) / scale.
struct Coordinate {
  size_t place = 0;                 // as kJointCoordinates lists them
  Vector3 axis = Vector3::UnitZ();  // unit length, world
  double position = 0;              // m or rad
  double scale = 1;
  bool is_angular() const { return place >= 3; }
};

/// The coordinates of a joint as they are expected at the end of the substep, in the order in which they are locked and
/// driven, or none, and how far (0 to 1) they can be relied on.
struct Foresight {
  std::span<const double> positions;
  double trust = 0;
};

/// The part of a solve that acts for `interval` seconds which is before its substep of `h` seconds.
inline double PastPart(double interval, double h) { return std::isfinite(interval) ? 1 - h / 2 / interval : 0; }

/// What a joint was told until the boundary at which the substep begins. Where frames are elsewhere since, the joint is
/// written between both, and these are its coordinates with the new ones, as kJointCoordinates lists them.
struct FormerTelling {
  std::span<const FormerDrive> drives;
  std::span<const double> told{};
};

/// Turns what a kind of joint says into rows, and notes its coordinates. All rows along a line act at the origin of
/// frame b with axes fixed in a: that is the exact rate of the origin of b as seen from a, and no row can change the
/// momentum of both together. A row asks for a rate, and over a step of finite size a coordinate changes by more than
/// its rate says, because frames turn; that is measured on the frames as they are expected at the end of the step and
/// taken off, so that the coordinate itself is met there to second order (as by SHAKE: Ryckaert, Ciccotti and
/// Berendsen, J. Comput. Phys. 23, 1977).
class RowWriter {
 public:
  /// Without `rows` the coordinates alone are noted in `state`; with them, what it takes to count full turns.
  RowWriter(const JointSide& a, const JointSide& b, double step_size, const ErrorCorrection& correction,
            JointState& state, std::vector<JointRow>* rows, const Foresight& expected, const FormerTelling& former = {})
      : a_(a),
        b_(b),
        axes_(a.frame.orientation.toRotationMatrix()),
        step_size_(step_size),
        correction_(correction),
        state_(state),
        rows_(rows),
        first_(rows != nullptr ? rows->size() : 0),
        expected_(expected),
        former_(former) {}

  /// Writes nothing, but lists the positions of all coordinates in the order in which they are locked and driven.
  RowWriter(const JointSide& a, const JointSide& b, JointState& state, std::vector<double>& positions)
      : a_(a),
        b_(b),
        axes_(a.frame.orientation.toRotationMatrix()),
        step_size_(0),
        state_(state),
        rows_(nullptr),
        positions_(&positions) {}

  /// For how long (s) the impulses of the rows act.
  double interval() const;
  /// Whether a drive that was told otherwise is too stiff for the step.
  bool is_late() const { return is_late_; }
  /// Whether rows are not asked for, but what the coordinates are.
  bool is_noting() const { return rows_ == nullptr && positions_ == nullptr; }
  /// Whether only what is locked counts.
  bool is_foretelling() const { return positions_ != nullptr; }
  const JointSide& a() const { return a_; }
  const JointSide& b() const { return b_; }

  /// The origin of b in the axes of frame a, m.
  Vector3 Offset() const;
  /// The orientation of frame b in frame a.
  Quaternion Turn() const;
  /// The coordinate along the axis `i` of frame a.
  Coordinate Along(int i) const;

  /// Holds the origins together: three rows, which mean the axes of a and lie along those of the world.
  void LockPoint();
  /// Holds the origin of b on the z axis of a.
  void LockAcross();
  /// Holds both frames parallel.
  void LockOrientation();
  /// Holds the axes `i` of both parallel: of a hinge those along z.
  void LockTilt(int i = 2);
  /// Holds the coordinate at zero.
  void Lock(const Coordinate& coordinate);
  /// Leaves the coordinate free but for what `axis` says, and notes it. Full turns are counted.
  void Drive(Coordinate coordinate, const JointAxis& axis);
  /// Counts the turns of the coordinate, which nothing drives.
  void CountTurns(size_t place, double position);
  /// Ties both spins.
  void LockGear(double ratio);

 private:
  double RateOf(const Coordinate& coordinate, bool before) const;
  double ExpectedRateOf(const Coordinate& coordinate) const;
  double Bend(const Coordinate& coordinate);
  Vector3 BendOfPoint(const Vector3& offset);
  void LockAt(const Coordinate& coordinate, double position, double bend);
  void WriteLimits(const Coordinate& coordinate, const AxisLimits& limits, double bend);
  void Reach(const Coordinate& coordinate, double gap, double bend, JointRow& row) const;
  void WriteMotor(const Coordinate& coordinate, const Motor& motor, const AxisLimits& limits, double bend);
  // A spring and damper.
  struct SoftDrive {
    double stiffness = 0;
    double damping = 0;
    double rest = 0;
    double rate = 0;
    double force_max = 0;

    static SoftDrive Of(const Motor& motor);  // to a position
    static SoftDrive Of(const Spring& spring);
    bool pulls() const { return stiffness + damping > 0 && force_max != 0; }
    double PushAt(double position) const { return stiffness * (rest - position) + damping * rate; }
  };
  // What one does for a part of the time of a solve, all of it times that part.
  struct SoftPart {
    double stiffness = 0;
    double damping = 0;
    double pull = 0;  // N or N*m at the boundary, without what damps
    double force_max = 0;

    static SoftPart Of(const SoftDrive& drive, double position, double part);
    // Of both together.
    SoftPart With(const SoftPart& other) const;
  };
  // `before`: what it was until the boundary, or null.
  // `told`: where it is with the frames that the joint has by now.
  void WriteSoft(const Coordinate& coordinate, double told, const SoftDrive& now, const SoftDrive* before);
  void WriteSoftPart(const Coordinate& coordinate, double late, const SoftPart& part, double since);
  void WriteDrives(const Coordinate& coordinate, const JointAxis& axis, double bend);
  double ToldPosition(const Coordinate& coordinate) const;
  double LatenessOf(const SoftDrive& drive, const Coordinate& coordinate);
  Vector3 TurnOfPoint(const JointBody& body) const;
  JointRow& Add(const Coordinate& coordinate);
  JointRow& AddRow(JointRow::Kind kind, const Vector3& axis);
  void Bound(double force_max);
  double Mobility(const JointRow& row, Matrix3 JointBody::*inverse_tensor) const;
  // What an impulse along a row is on b, and the opposite of what it is on a.
  struct Lever {
    Vector3 push = Vector3::Zero();
    Vector3 turn_a = Vector3::Zero();
    Vector3 turn_b = Vector3::Zero();
  };
  Lever LeverOf(const JointRow& row) const;
  // What an impulse along the one gives the rate of the other.
  double Coupling(const Lever& row, const Lever& other) const;
  // How far the row moves per impulse while the rows hold that this joint has locked so far.
  double HeldMobility(const JointRow& row) const;
  void Soften(JointRow& row);
  bool is_scaled() const { return a_.body->factor != 1 || b_.body->factor != 1; }
  // How fast (m/s or rad/s) so large an error (m or rad) may be taken away in this substep.
  double SpeedFor(double error, bool is_angular) const;
  // What it may take (J) to bring up that speed in what moves by `mobility` per impulse.
  double RepairAt(double speed, bool is_angular, double mobility) const;
  // Makes the row that was softened last take `error` (m or rad) away, as far as that may be done in this substep.
  void Correct(double error, JointRow& row) const;

  const JointSide& a_;
  const JointSide& b_;
  Matrix3 axes_;  // of frame a, as columns, world
  double step_size_;
  ErrorCorrection correction_;
  JointState& state_;
  std::vector<JointRow>* rows_;
  size_t first_ = 0;  // of the rows that are of this joint
  std::vector<double>* positions_ = nullptr;
  Foresight expected_;
  FormerTelling former_;
  bool is_late_ = false;
  size_t next_expected_ = 0;
  double mobility_ = 0;  // of the row that was softened last
};

}  // namespace genphys

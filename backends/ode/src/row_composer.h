#pragma once
#include <span>
#include <vector>

#include "genphys/joint_row.h"

struct dxBody;
struct dxJoint;
struct dxJointGroup;
struct dxWorld;
struct dJointFeedback;

namespace genphys::ode_backend {

/// Rows of joints as ODE can have them: it takes no row of ours, so that each is composed of a joint of its own that,
/// made anew for every solve, has just that row at the present poses.
///
///   three along lines, unbounded   a ball joint, whose second anchor stands off by what is to be corrected
///   one or two along lines         the friction of a contact whose normal never acts; its coefficients bound the force
///   one along a line, one-sided    the normal of a contact
///   one about a line               an angular motor, by its force or by its stop
///   a gear                         two bodies of its own between its sides; see AddGear()
class RowComposer {
 public:
  /// A row between bodies of the solver; null is a side that cannot be moved.
  struct Row {
    dxBody* a = nullptr;
    dxBody* b = nullptr;
    JointRow* row = nullptr;
    double given_rate = 0;  // of the sides that cannot be moved
  };

  RowComposer(dxWorld* world, dxJointGroup* joints);
  /// To which joints belong from now on.
  void SetGroup(dxJointGroup* joints) { joints_ = joints; }
  ~RowComposer();

  /// Starts anew for a solve of `step_size` seconds and at most `count` rows.
  void Begin(size_t count, double step_size);
  /// Adds the rows of one block. All of them are between the same bodies, of which one can be moved.
  void Add(std::span<const Row> block);
  /// Gives bodies back what they lent to others of a solve that is over, or was given up.
  void ReturnWeights();
  /// Destroys the bodies that it has of its own, to make new ones when it needs them.
  void DropShafts();
  /// Writes impulses back into the rows, once the world has stepped.
  void TakeImpulses();

 private:
  // A row told for the body that surely can be moved: rate = axis * (velocity of first - velocity of second).
  struct Told {
    dxBody* first;
    dxBody* second;
    Vector3 axis;
    double target;
  };
  struct Composed {
    JointRow* row;
    Vector3 axis;  // along which the feedback of the first body is the impulse
    size_t feedback;
    bool is_push;      // along a line
    double scale = 1;  // of the row's impulse against ODE's
  };

  static Told Tell(const Row& row);
  double ForceOf(double impulse) const;
  dJointFeedback* Attach(dxJoint* joint, const Told& told);
  void Note(const Row& row, const Vector3& axis, bool is_push) {
    composed_.push_back({row.row, axis, feedback_count_ - 1, is_push});
  }
  void AddBall(std::span<const Row> block);
  void AddFriction(std::span<const Row> block);
  void AddNormal(const Row& row);
  void AddAngular(const Row& row);
  void AddGear(const Row& row);
  dxBody* AddShaft(dxBody* body, const Vector3& axis, const Vector3& center);

  dxWorld* world_;
  dxJointGroup* joints_;
  double step_size_ = 0;
  std::vector<dJointFeedback> feedback_;  // never grows within a solve: ODE holds pointers into it
  size_t feedback_count_ = 0;
  std::vector<Composed> composed_;
  std::vector<dxBody*> shafts_;  // the first shaft_count_ are in use, the others disabled
  size_t shaft_count_ = 0;
  struct Weight;
  std::vector<Weight> weights_;  // of bodies that lent theirs to shafts
};

}  // namespace genphys::ode_backend

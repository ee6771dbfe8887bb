#pragma once
#include <limits>
#include <vector>

#include "genphys/contact.h"
#include "genphys/layer_state.h"
#include "genphys/pair_rule.h"
#include "genphys/row_marks.h"
#include "genphys/row_set.h"
#include "genphys/scene.h"
#include "genphys/state.h"
#include "joints/joint_step.h"

namespace genphys {

/// What no impact hit since the substep began.
inline constexpr double kAlwaysFree = std::numeric_limits<double>::infinity();

/// Against what somebody is pressed.
enum Stance : uint8_t { kOnGround = 1, kAmongOthers = 2 };

/// The way of a body to where it is now.
struct FlownWay {
  EntityRow row{};
  Pose start;       // of the entity's frame
  double time = 0;  // s that it took
  // What sped it up on the way, if joints hold it or from a blow on: m/s^2 and N*m.
  Vector3 acceleration = Vector3::Zero();
  Vector3 torque = Vector3::Zero();
  // Of the acceleration of what stands on the ground, what others gave it that can be moved.
  Vector3 by_others = Vector3::Zero();
};

/// What the impacts of a substep need to know of the world. All of it outlives them.
struct ImpactWorld {
  const Scene& scene;
  StateArrays& state;
  LayerState& layer;
  const PairRule& rule;
  const std::vector<GeometryRows>& geometry_rows;
  const RowSet& active;
  const RowValues<Vector3>& accelerations;  // m/s^2 from outside
  const RowMarks& flew;                     // in flight before the solve of this substep
  const RowMarks& flies;                    // moved in one go at the end of the step, with nothing in its way
  const RowMarks& jolted;                   // the solve of this substep gave it a blow
  const RowMarks& jointed;                  // held by joints
  const ContactBuffer& solved;              // what touched in this substep, with impulses
  JointStep& joints;
  RowMarks& linked;  // memory of the impacts
  RowMarks& shoved;  // hit in this substep where they are at the end, so that they went otherwise than they do now
  // The same, which they leave empty.
  RowValues<int>& group_of;      // -1: none
  RowValues<int>& struck_index;  // -1: none
  RowValues<int>& swept_index;   // the same, of sweeps
  RowValues<int>& crowd_number;  // -1: none
  RowValues<double>& earliest;
  RowValues<double>& free_since;  // s before the end
  RowValues<uint8_t>& stances;    // of Stance
  RowValues<int>& passed_index;   // -1: none
};

}  // namespace genphys

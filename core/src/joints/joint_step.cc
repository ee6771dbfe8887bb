#include "joints/joint_step.h"

#include <algorithm>
#include <cmath>

#include "joints/inertia_factor.h"
#include "joints/kinds.h"
#include "joints/row_rate.h"
#include "motion/free_rotation.h"

namespace genphys {
namespace {

// rad in a substep: from the rates of who turns farther rows cannot tell where it comes to.
constexpr double kToldTurn = 1;

Pose Between(const Pose& from, const Pose& to, double part) {
  return {from.position + part * (to.position - from.position), from.orientation.slerp(part, to.orientation)};
}

double Fade(double value, double full, double none) { return std::clamp((none - value) / (none - full), 0.0, 1.0); }

}  // namespace

JointBody BodyNow(const Scene& scene, const StateArrays& state, EntityRow row) {
  JointBody body;
  if (row == kWorldRow) return body;
  body.row = row;
  body.pose = state.pose(row);
  body.axes = body.pose.orientation.toRotationMatrix();
  body.center = body.pose.position + body.axes * scene.entities[Index(row)]->mass.center_of_mass;
  body.linear_velocity = state.linear_velocities.col(Index(row));
  body.angular_velocity = state.angular_velocities.col(Index(row));
  return body;
}

uint32_t JointStep::BodyOf(const EntityRef& entity) {
  const EntityRow row = RowOf(entity);
  if (row == kWorldRow) return 0;
  uint32_t& place = body_of_[Index(row)];
  if (place == 0) {
    place = static_cast<uint32_t>(body_count_++);
    // What is left of an earlier step is overwritten when a substep begins.
    if (bodies_.size() < body_count_) bodies_.emplace_back();
    bodies_[place].row = row;
  }
  return place;
}

ErrorCorrection JointStep::CorrectionOf(const JointDesc& desc) const {
  ErrorCorrection correction;
  for (const EntityRow side : {RowOf(desc.entity_a), RowOf(desc.entity_b)}) {
    if (side == kWorldRow) continue;
    const SceneEntity& entity = *scene_.entities[Index(side)];
    if (entity.traits.corrects) correction = Gentler(correction, entity.desc->rigid_body->error_correction);
  }
  return correction;
}

// What left the bounds of the world is held no longer, and holds nothing.
bool JointStep::MayHold(const JointDesc& desc) const {
  const auto is_gone = [&](const EntityRef& entity) {
    return !entity.id.is_null() && layer_.faulted[entity.id.index()];
  };
  return !is_gone(desc.entity_a) && !is_gone(desc.entity_b);
}

void JointStep::Start(RowMarks& jointed) {
  jointed_ = &jointed;
  for (const JointBody& body : bodies().subspan(1)) body_of_[Index(body.row)] = 0;
  body_count_ = 1;
  body_of_.resize(state_.rows());
  for (const Held& held : held_) is_held_[held.slot] = false;
  held_.clear();
  is_held_.resize(scene_.joints.size());
  former_.Take(layer_, scene_);
  rows_.clear();
  owners_.clear();
}

void JointStep::Hold(EntityRow row) {
  for (const uint32_t slot : index_.Of(row)) {
    if (is_held_[slot]) continue;
    is_held_[slot] = true;
    const JointDesc& desc = scene_.joints[slot]->desc;
    Held& held = held_.emplace_back(slot);
    held.a = BodyOf(desc.entity_a);
    held.b = BodyOf(desc.entity_b);
    held.before = layer_.joints[slot];
    held.correction = CorrectionOf(desc);
    held.last_force = layer_.joints[slot].force;
    if (!MayHold(desc)) continue;
    for (const EntityRow side : {RowOf(desc.entity_a), RowOf(desc.entity_b)}) {
      if (side != kWorldRow) jointed_->Mark(side);
    }
  }
}

bool JointStep::HoldSleeper() const {
  return std::ranges::any_of(bodies().subspan(1),
                             [&](const JointBody& body) { return state_.asleep[Index(body.row)]; });
}

const JointBody* JointStep::Find(EntityRow row) const {
  const uint32_t place = body_of_[Index(row)];
  return place != 0 ? &bodies_[place] : nullptr;
}

void JointStep::SetTensors(EntityRow row, const TurnedTensors& turned) {
  const uint32_t place = body_of_[Index(row)];
  if (place == 0) return;
  bodies_[place].axes = turned.axes;
  bodies_[place].own_tensor = turned.tensor;
  bodies_[place].own_inverse = turned.inverse;
}

void JointStep::Kick(EntityRow row, const Vector3& spin, const Vector3& turning, const Vector3& momentum,
                     bool goes_on) {
  JointBody& body = bodies_[body_of_[Index(row)]];
  body.angular_before -= turning;
  body.angular_kick = spin;
  body.momentum_given = momentum;
  body.goes_on = goes_on;
}

bool JointStep::IsFollowed(EntityRow row) const {
  const JointBody* const body = Find(row);
  return body != nullptr && body->is_followed;
}

bool JointStep::GivesMean(EntityRow row) const {
  const uint32_t island = islands_.IslandOf(row);
  return island < gives_mean_.size() && gives_mean_[island];
}

void JointStep::Load(JointBody& body, double h) const {
  const uint32_t row = Index(body.row);
  const SceneEntity& entity = *scene_.entities[row];
  const auto& rigid = entity.desc->rigid_body;
  body.pose = state_.pose(body.row);
  body.center = body.pose.position;
  body.linear_before = body.linear_velocity = body.linear_expected = state_.linear_velocities.col(row);
  body.angular_before = body.angular_velocity = body.angular_expected = state_.angular_velocities.col(row);
  body.angular_kick.setZero();
  body.inverse_mass = 0;
  body.inverse_tensor.setZero();
  body.factor = body.expected_factor = 1;
  body.pull.setZero();
  body.swing = body.pulled = 0;
  body.is_followed = body.is_late = false;
  body.interval = body.spin_most = std::numeric_limits<double>::infinity();
  const bool is_dynamic = rigid && rigid->motion_type == MotionType::kDynamic;
  if (!is_dynamic || !active_[row]) {
    body.axes = body.pose.orientation.toRotationMatrix();
    body.own_inverse.setZero();
  }
  if (!is_dynamic) return;
  body.center += body.axes * entity.mass.center_of_mass;
  if (!active_[row]) return;
  body.inverse_mass = 1 / entity.mass.mass;
  body.inverse_tensor = body.own_inverse;
  body.interval = layer_.half_steps[row].Interval(layer_.last_substep, h);
}

void JointStep::SortHeld() {
  if (!std::ranges::is_sorted(held_, {}, &Held::slot)) std::ranges::sort(held_, {}, &Held::slot);
}

void JointStep::TakeShown() {
  for (JointBody& body : bodies().subspan(1)) {
    body.linear_shown = state_.linear_velocities.col(Index(body.row));
    body.angular_shown = state_.angular_velocities.col(Index(body.row));
  }
}

void JointStep::Begin(double h) {
  SortHeld();
  for (JointBody& body : bodies().subspan(1)) Load(body, h);
  CatchTorn(h);
  Stiffen(h);
}

// What was torn off a joint and goes round so far in a substep that its rates say nothing of where its end of the joint
// comes to. By a whole turn in each it would seem to stand still while it flies away, and no row would ever know. So it
// goes round only as far as rows can tell until it is back.
void JointStep::CatchTorn(double h) {
  const auto goes_round = [&](const JointBody& body, const Pose& frame) {
    const Vector3& spin = body.angular_velocity;
    // Most turn by far less, and need no look at where their joints are.
    if (!body.is_movable() || !(spin.squaredNorm() * h * h > kToldTurn * kToldTurn)) return false;
    const Vector3 end = JointSide::Now(body, frame).frame.position - body.center;
    return spin.cross(end).norm() > kCorrectionSpeedMax;
  };
  const auto is_torn = [](std::span<const JointRow> rows) {
    double square = 0;
    for (const JointRow& row : rows) {
      if (IsLocked(row) && row.kind == JointRow::Kind::kLinear) square += row.target * row.target;
    }
    return square >= kCorrectionSpeedMax * kCorrectionSpeedMax;
  };
  for (const Held& held : held_) {
    const JointDesc& desc = scene_.joints[held.slot]->desc;
    JointBody &a = bodies_[held.a], &b = bodies_[held.b];
    const bool round_a = goes_round(a, *desc.frame_in_a), round_b = goes_round(b, *desc.frame_in_b);
    if (!(round_a || round_b) || !MayHold(desc)) continue;
    if (!is_torn(RowsBetween(held.slot, a, b, h))) continue;
    if (round_a) a.spin_most = kToldTurn / h;
    if (round_b) b.spin_most = kToldTurn / h;
  }
}

void JointStep::Stiffen(double h) {
  for (const Held& held : held_) {
    const JointDesc& desc = scene_.joints[held.slot]->desc;
    if (held.last_force.isZero(0) || !MayHold(desc)) continue;
    JointBody& a = bodies_[held.a];
    JointBody& b = bodies_[held.b];
    // All that a joint does to both acts at the origin of frame b.
    const Vector3 place = b.pose.position + b.axes * desc.frame_in_b->position;
    a.pull += PullStiffness(place - a.center, -held.last_force);
    b.pull += PullStiffness(place - b.center, held.last_force);
  }
  scales_.clear();
  for (JointBody& body : bodies()) {
    if (!body.is_movable() || body.pull.isZero(0)) continue;
    body.pulled = body.pull.norm();
    body.swing = SwingOf(body.own_inverse, body.pull, h);
    body.factor = body.expected_factor = InertiaFactor(body.swing);
    if (body.factor == 1) continue;
    body.inverse_tensor = body.own_inverse / body.factor;
    scales_.push_back({body.row, body.factor});
  }
}

// Takes the velocities that forces have brought up meanwhile.
void JointStep::Push(JointBody& body, double h) {
  const uint32_t row = Index(body.row);
  body.linear_velocity = body.linear_given = body.linear_expected = state_.linear_velocities.col(row);
  body.angular_velocity = body.angular_given = body.angular_expected = state_.angular_velocities.col(row);
  const HalfStep& half = layer_.half_steps[row];
  body.begins = body.is_movable() && (half.restarts || half.is_struck);
  if (body.is_movable() && !half.restarts) {
    body.linear_expected += body.interval * half.held_rate;
    body.angular_expected += body.own_inverse * (body.interval * half.held_torque);
  }
  body.Foretell(h, body.angular_expected);
}

double JointStep::TrustInTurns(const Held& held, double h) const {
  constexpr double kWidest = 1.4, kWide = 0.7;  // rad
  const double square =
      std::max(bodies_[held.a].angular_expected.squaredNorm(), bodies_[held.b].angular_expected.squaredNorm());
  return Fade(std::sqrt(square) * h, kWide, kWidest);
}

// Where joints pull a body to and fro within the substep, what is foretold by the last one would only drive it.
double JointStep::TrustInPulls(const Held& held) const {
  return Fade(std::max(bodies_[held.a].swing, bodies_[held.b].swing), kResolvedSwing / 2, kUnforeseenSwing);
}

void JointStep::WriteRowsOf(Held& held, double h, double trust, std::vector<JointRow>& rows) {
  const SceneJoint& joint = *scene_.joints[held.slot];
  JointState& state = layer_.joints[held.slot];
  JointBody &body_a = bodies_[held.a], &body_b = bodies_[held.b];
  Pose in_a = *joint.desc.frame_in_a, in_b = *joint.desc.frame_in_b;
  told_.clear();
  if (const FormerFrames* const former = former_.FramesOf(joint.id)) {
    const JointSide a = JointSide::Now(body_a, in_a), b = JointSide::Now(body_b, in_b);
    JointState told = state;
    RowWriter noting(a, b, 0, {}, told, nullptr, {});
    std::visit([&](const auto& kind) { WriteRows(kind, noting); }, joint.desc.kind);
    told_.assign(told.positions.begin(), told.positions.end());
    const double part = PastPart(std::min(body_a.interval, body_b.interval), h);
    in_a = Between(in_a, former->in_a, part);
    in_b = Between(in_b, former->in_b, part);
  }
  const JointSide a = JointSide::Now(body_a, in_a), b = JointSide::Now(body_b, in_b);
  expected_.clear();
  if (trust > 0) {
    const JointSide a_ahead = a.Ahead(), b_ahead = b.Ahead();
    RowWriter ahead(a_ahead, b_ahead, state, expected_);
    std::visit([&](const auto& kind) { WriteRows(kind, ahead); }, joint.desc.kind);
  }
  const auto first = static_cast<std::ptrdiff_t>(rows.size());
  RowWriter writer(a, b, h, held.correction, state, &rows, {expected_, trust}, {former_.DrivesOf(joint.id), told_});
  std::visit([&](const auto& kind) { WriteRows(kind, writer); }, joint.desc.kind);
  if (state.is_stuck()) std::for_each(rows.begin() + first, rows.end(), [](JointRow& row) { row.is_stuck = true; });
  held.share = h / writer.interval();
  // What a step does not resolve is where it is told to be at its end, and gives no mean.
  if (writer.is_late()) body_a.is_late = body_b.is_late = true;
}

std::vector<JointRow>& JointStep::Write(double h) {
  rows_.clear();
  owners_.clear();
  jolts_.clear();
  for (JointBody& body : bodies().subspan(1)) Push(body, h);
  for (uint32_t i = 0; i < held_.size(); ++i) {
    Held& held = held_[i];
    const bool is_movable = bodies_[held.a].is_movable() || bodies_[held.b].is_movable();
    if (!is_movable || !MayHold(scene_.joints[held.slot]->desc)) continue;
    WriteRowsOf(held, h, TrustInTurns(held, h) * TrustInPulls(held), rows_);
    held.was_held = true;
    owners_.resize(rows_.size(), i);
  }
  return rows_;
}

void JointStep::Take(double h) {
  const auto spin = [&](EntityRow row) -> Vector3 {
    return row == kWorldRow ? Vector3(Vector3::Zero()) : Vector3(state_.angular_velocities.col(Index(row)));
  };
  const auto velocities = [&](EntityRow row) -> Velocities {
    if (row == kWorldRow) return {};
    return {state_.linear_velocities.col(Index(row)), spin(row)};
  };
  for (Held& held : held_) held.BeginSubstep();
  former_.Clear();
  for (size_t i = 0; i < owners_.size(); ++i) {
    JointRow& row = rows_[i];
    Held& held = held_[owners_[i]];
    if (row.damping > 0) {
      const JointBody &a = BodyAt(row.a), &b = BodyAt(row.b);
      row.rate = (RateBefore(row) + RateOf(row, a, velocities(row.a), b, velocities(row.b))) / 2;
    }
    held.Bear(held.share, row);
    if (row.kind == JointRow::Kind::kLinear) {
      held.last_force += held.share / h * row.impulse * row.axis;
    } else if (row.kind == JointRow::Kind::kGeared) {
      // No pose tells how often a gear has turned, so that what it slipped is added up.
      layer_.joints[held.slot].positions[5] += h * (row.axis.dot(spin(row.a)) + row.axis_b.dot(spin(row.b)));
    }
  }
  if (std::ranges::find(gives_mean_, true) == gives_mean_.end()) return;
  for (size_t i = 0; i < held_.size(); ++i) {
    Held& held = held_[i];
    const JointBody &a = bodies_[held.a], &b = bodies_[held.b];
    const JointBody& movable = a.is_movable() ? a : b;
    if (!held.was_held || movable.begins || !movable.is_movable() || !GivesMean(movable.row)) continue;
    const auto own = std::ranges::equal_range(owners_, static_cast<uint32_t>(i));
    held.BearSince(h, std::span(rows_).subspan(static_cast<size_t>(own.begin() - owners_.begin()), own.size()));
  }
}

std::vector<JointId> JointStep::Finish(double step_size) {
  std::vector<JointId> broken;
  for (Held& held : held_) {
    if (!held.was_held) continue;
    JointState& joint = layer_.joints[held.slot];
    joint.force = held.force / step_size;
    joint.torque = held.torque / step_size;
    const SceneJoint& scene_joint = *scene_.joints[held.slot];
    const bool is_pulled = scene_joint.desc.break_force && joint.force.norm() > *scene_joint.desc.break_force;
    const bool is_twisted = scene_joint.desc.break_torque && joint.torque.norm() > *scene_joint.desc.break_torque;
    if (is_pulled || is_twisted) broken.push_back(scene_joint.id);
  }
  std::sort(broken.begin(), broken.end());
  return broken;
}

void JointStep::Restore() {
  for (const Held& held : held_) layer_.joints[held.slot] = held.before;
}

}  // namespace genphys

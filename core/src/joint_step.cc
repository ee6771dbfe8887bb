#include "joint_step.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "free_rotation.h"
#include "joints/inertia_factor.h"
#include "joints/kinds.h"

namespace genphys {
namespace {

// Each makes what was too light for the step heavier.
constexpr int kSurprisesMax = 3;
// A pull that is no more than so many times what was expected is none.
constexpr double kSurprise = kUnforeseenSwing / kResolvedSwing / 1.5;
// What was locked, and moved apart by this part of what a body gained, and more than it may by rounding: the body was
// jolted. m/s or rad/s.
constexpr double kJolt = 0.5;
constexpr double kLeastJolt = 1e-6;

// How far the way of a joint over a substep of `h` seconds can be foretold, 0 to 1. Who turns far in it comes out
// elsewhere, and where joints pull a body to and fro within it, what is foretold would only drive it.
double TrustIn(const JointBody& body, double h) {
  constexpr double kWidest = 1.4, kWide = 0.7;  // rad
  const auto fade = [](double value, double full, double none) {
    return std::clamp((none - value) / (none - full), 0.0, 1.0);
  };
  return fade(body.angular_expected.norm() * h, kWide, kWidest) *
         fade(body.swing, kResolvedSwing / 2, kUnforeseenSwing);
}

// Of a row that makes up for no error, m/s or rad/s.
double QuietTarget(const JointRow& row) {
  if (row.is_driven) return row.target;
  // A limit still ahead may be come to, which gives nothing either.
  if (row.lower == 0) return std::min(row.target, 0.0);
  if (row.upper == 0) return std::max(row.target, 0.0);
  return 0;
}

}  // namespace

uint32_t JointStep::BodyOf(const EntityRef& entity) {
  const EntityRow row = RowOf(entity);
  if (row == kWorldRow) return 0;
  uint32_t& place = body_of_[Index(row)];
  if (place == 0) {
    place = static_cast<uint32_t>(bodies_.size());
    bodies_.emplace_back().row = row;
  }
  return place;
}

ErrorCorrection JointStep::CorrectionOf(const EntityRef& entity) const {
  if (entity.is_world()) return {};
  const auto& body = scene_.entities[entity.id.index()]->desc->rigid_body;
  return body ? body->error_correction : ErrorCorrection{};
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
  for (const JointBody& body : bodies_) {
    if (body.row != kWorldRow) body_of_[Index(body.row)] = 0;
  }
  bodies_.assign(1, {});
  body_of_.resize(state_.rows());
  for (const Held& held : held_) is_held_[held.slot] = false;
  held_.clear();
  is_held_.resize(scene_.joints.size());
  rows_.clear();
  owners_.clear();
}

void JointStep::Hold(EntityRow row) {
  for (const uint32_t slot : index_.Of(row)) {
    if (is_held_[slot]) continue;
    is_held_[slot] = true;
    const JointDesc& desc = scene_.joints[slot]->desc;
    Held& held = held_.emplace_back();
    held.slot = slot;
    held.a = BodyOf(desc.entity_a);
    held.b = BodyOf(desc.entity_b);
    held.before = layer_.joints[slot];
    held.correction = Gentler(CorrectionOf(desc.entity_a), CorrectionOf(desc.entity_b));
    held.last_force = layer_.joints[slot].force;
    if (!MayHold(desc)) continue;
    for (const EntityRow side : {RowOf(desc.entity_a), RowOf(desc.entity_b)}) {
      if (side != kWorldRow) jointed_->Mark(side);
    }
  }
}

const JointBody* JointStep::Find(EntityRow row) const {
  const uint32_t place = body_of_[Index(row)];
  return place != 0 ? &bodies_[place] : nullptr;
}

void JointStep::SetTensors(EntityRow row, const Matrix3& axes, const Matrix3& inverse_tensor) {
  const uint32_t place = body_of_[Index(row)];
  if (place == 0) return;
  bodies_[place].axes = axes;
  bodies_[place].own_inverse = inverse_tensor;
}

void JointStep::Load(JointBody& body, double h) const {
  const uint32_t row = Index(body.row);
  const SceneEntity& entity = *scene_.entities[row];
  const auto& rigid = entity.desc->rigid_body;
  body.pose = state_.pose(body.row);
  body.center = body.pose.position;
  body.linear_before = body.linear_velocity = body.linear_expected = state_.linear_velocities.col(row);
  body.angular_before = body.angular_velocity = body.angular_expected = state_.angular_velocities.col(row);
  body.inverse_mass = 0;
  body.inverse_tensor.setZero();
  body.factor = body.expected_factor = 1;
  body.pull.setZero();
  body.swing = body.pulled = 0;
  body.interval = std::numeric_limits<double>::infinity();
  const bool is_dynamic = rigid && rigid->motion_type == MotionType::kDynamic;
  if (!is_dynamic || !active_[row]) body.axes = body.pose.orientation.toRotationMatrix();
  if (!is_dynamic) return;
  body.center += body.axes * entity.mass.center_of_mass;
  if (!active_[row]) return;
  body.inverse_mass = 1 / entity.mass.mass;
  body.inverse_tensor = body.own_inverse;
  body.interval = layer_.half_steps[row].Interval(layer_.last_substep, h);
}

void JointStep::Begin(double h) {
  const auto slot_of = [](const Held& held) { return held.slot; };
  if (!std::ranges::is_sorted(held_, {}, slot_of)) std::ranges::sort(held_, {}, slot_of);
  for (size_t i = 1; i < bodies_.size(); ++i) Load(bodies_[i], h);
  Stiffen(h);
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
  for (JointBody& body : bodies_) {
    if (!body.is_movable() || body.pull.isZero(0)) continue;
    body.pulled = body.pull.norm();
    body.swing = SwingOf(body.own_inverse, body.pull, h);
    body.factor = body.expected_factor = InertiaFactor(body.swing);
    if (body.factor == 1) continue;
    body.inverse_tensor = body.own_inverse / body.factor;
    scales_.push_back({body.row, body.factor});
  }
}

// Whether bodies need more inertia under what a solve of these rows gave than it found: where a chain comes taut the
// last substep did not tell.
bool JointStep::IsSurprised(std::span<const JointRow> rows, std::span<const uint32_t> mine, double h) {
  for (const uint32_t moved : solver_.moved()) bodies_[moved].pull.setZero();
  for (size_t i = 0; i < mine.size();) {
    const JointRow& first = rows[mine[i]];
    Vector3 impulse = Vector3::Zero();
    for (; i < mine.size() && rows[mine[i]].b == first.b && rows[mine[i]].point == first.point; ++i) {
      const JointRow& row = rows[mine[i]];
      if (row.kind == JointRow::Kind::kLinear) impulse += row.impulse * row.axis;
    }
    for (const auto& [side, sign] : {std::pair(first.a, -1.0), std::pair(first.b, 1.0)}) {
      if (side == kWorldRow) continue;
      JointBody& body = bodies_[body_of_[Index(side)]];
      if (body.is_movable()) body.pull += PullStiffness(first.point - body.center, sign / body.interval * impulse);
    }
  }
  bool is_surprised = false;
  for (const uint32_t moved : solver_.moved()) {
    JointBody& body = bodies_[moved];
    if (body.pull.norm() <= kSurprise * body.pulled) continue;
    const double swing = SwingOf(body.own_inverse, body.pull, h);
    if (!(swing > kUnforeseenSwing * body.factor)) continue;
    body.factor = InertiaFactor(swing);
    body.inverse_tensor = body.own_inverse / body.factor;
    is_surprised = true;
  }
  return is_surprised;
}

// Takes the velocities that forces have brought up meanwhile.
void JointStep::Push(JointBody& body, double h) {
  const uint32_t row = Index(body.row);
  body.linear_velocity = body.linear_given = body.linear_expected = state_.linear_velocities.col(row);
  body.angular_velocity = body.angular_given = body.angular_expected = state_.angular_velocities.col(row);
  const HalfStep& half = layer_.half_steps[row];
  if (body.is_movable() && half.restarts) may_jolt_ = true;
  if (body.is_movable() && !half.restarts) {
    body.linear_expected += body.interval * half.held_rate;
    body.angular_expected += body.own_inverse * (half.held_momentum * (2 * body.interval / layer_.last_substep));
  }
  body.Foretell(h);
}

bool JointStep::Visit(Held& held, double h) {
  const JointDesc& desc = scene_.joints[held.slot]->desc;
  const JointBody& body_a = bodies_[held.a];
  const JointBody& body_b = bodies_[held.b];
  if ((!body_a.is_movable() && !body_b.is_movable()) || !MayHold(desc)) return false;
  const JointSide a = JointSide::Now(body_a, *desc.frame_in_a), b = JointSide::Now(body_b, *desc.frame_in_b);
  expected_.clear();
  const double trust = std::min(TrustIn(body_a, h), TrustIn(body_b, h));
  if (trust > 0) {
    const JointSide a_ahead = a.Ahead(), b_ahead = b.Ahead();
    RowWriter ahead(a_ahead, b_ahead, layer_.joints[held.slot], expected_);
    std::visit([&](const auto& joint) { WriteRows(joint, ahead); }, desc.kind);
  }
  RowWriter writer(a, b, h, held.correction, layer_.joints[held.slot], &rows_, {expected_, trust});
  std::visit([&](const auto& joint) { WriteRows(joint, writer); }, desc.kind);
  held.share = h / writer.interval();
  return true;
}

std::vector<JointRow>& JointStep::Write(double h) {
  rows_.clear();
  owners_.clear();
  jolts_.clear();
  may_jolt_ = false;
  for (size_t i = 1; i < bodies_.size(); ++i) Push(bodies_[i], h);
  for (uint32_t i = 0; i < held_.size(); ++i) {
    if (!Visit(held_[i], h)) continue;
    held_[i].was_held = true;
    owners_.resize(rows_.size(), i);
  }
  return rows_;
}

void JointStep::FindJolts(std::span<const JointRow> rows) {
  if (!may_jolt_) return;
  jolts_.assign(islands_.islands().size(), {});
  for (const JointRow& row : rows) {
    const uint32_t island = islands_.IslandOf(row.a, row.b);
    if (island == Islands::kNone || row.is_driven || row.lower == 0 || row.upper == 0) continue;
    const auto body_of = [&](EntityRow side) -> const JointBody& {
      return bodies_[side == kWorldRow ? 0 : body_of_[Index(side)]];
    };
    const JointBody &a = body_of(row.a), &b = body_of(row.b);
    Jolt& jolt = jolts_[island];
    if (row.kind == JointRow::Kind::kLinear) {
      jolt.linear = std::max(jolt.linear, std::abs(row.axis.dot(b.BeforeAt(row.point) - a.BeforeAt(row.point))));
    } else if (row.kind == JointRow::Kind::kAngular) {
      jolt.angular = std::max(jolt.angular, std::abs(row.axis.dot(b.angular_before - a.angular_before)));
    } else {
      const double rate = row.axis_b.dot(b.angular_before) + row.axis.dot(a.angular_before);
      jolt.angular = std::max(jolt.angular, std::abs(rate));
    }
  }
}

bool JointStep::IsJolted(EntityRow row, const Vector3& gained, const Vector3& turned) const {
  const uint32_t island = jolts_.empty() ? Islands::kNone : islands_.IslandOf(row);
  if (island == Islands::kNone) return false;
  const Jolt& jolt = jolts_[island];
  return jolt.linear > std::max(kLeastJolt, kJolt * gained.norm()) ||
         jolt.angular > std::max(kLeastJolt, kJolt * turned.norm());
}

bool JointStep::SolveIsland(uint32_t island, double h, std::vector<JointRow>& rows) {
  const std::vector<uint32_t>& mine = by_island_[island];
  for (int surprises = 0;; ++surprises) {
    if (!solver_.Solve(island, rows, mine, body_of_, bodies_)) return false;
    if (surprises == kSurprisesMax || !IsSurprised(rows, mine, h)) return true;
    for (const uint32_t moved : solver_.moved()) bodies_[moved].Return();
  }
}

bool JointStep::SolveQuietly(uint32_t island, std::vector<JointRow>& rows) {
  if (island >= by_island_.size() || by_island_[island].empty()) return false;
  const std::vector<uint32_t>& mine = by_island_[island];
  targets_.clear();
  for (const uint32_t i : mine) {
    JointRow& row = rows[i];
    targets_.push_back(row.target);
    for (const EntityRow side : {row.a, row.b}) {
      if (side == kWorldRow) continue;
      JointBody& body = bodies_[body_of_[Index(side)]];
      if (!body.is_movable()) continue;
      body.factor = 1;
      body.inverse_tensor = body.own_inverse;
      body.Return();
    }
    row.target = QuietTarget(row);
  }
  const bool is_solved = solver_.Solve(island, rows, mine, body_of_, bodies_);
  for (size_t i = 0; i < mine.size(); ++i) rows[mine[i]].target = targets_[i];
  return is_solved;
}

void JointStep::BoundWaits(double h, std::span<const JointRow> rows, std::span<SolveEnergy> energies) const {
  struct Errors {
    double wait = 0;  // m or rad per second of a substep
    double made = 0;
  };
  // By island, along and about.
  std::vector<std::array<Errors, 2>> errors(energies.size());
  for (const JointRow& row : rows) {
    const uint32_t island = islands_.IslandOf(row.a, row.b);
    if (island == Islands::kNone || !energies[island].is_quiet) continue;
    const bool is_linear = row.kind == JointRow::Kind::kLinear;
    auto& [wait, made] = errors[island][is_linear ? 0 : 1];
    wait = std::max(wait, std::abs(row.target - QuietTarget(row)));
    double bend = 0;
    for (const EntityRow side : {row.a, row.b}) {
      if (side == kWorldRow) continue;
      const JointBody& body = bodies_[body_of_[Index(side)]];
      bend += body.angular_given.squaredNorm() * (is_linear ? (row.point - body.center).norm() : 1) * h / 2;
    }
    made = std::max(made, bend);
  }
  for (size_t island = 0; island < errors.size(); ++island) {
    for (const auto& [wait, made] : errors[island]) {
      if (wait > made) energies[island].way = std::max(energies[island].way, 1 - made / wait);
    }
  }
}

std::span<JointRow> JointStep::Solve(Solver solver, double h, std::span<const EntityRow> moving,
                                     const ContactBuffer& contacts, std::vector<JointRow>& rows) {
  left_.clear();
  left_rows_.clear();
  if (rows.empty()) return rows;
  islands_.Find(state_.rows(), moving, contacts, rows);
  FindJolts(rows);
  for (std::vector<uint32_t>& list : by_island_) list.clear();
  if (solver == Solver::kIterative) return rows;
  if (by_island_.size() < islands_.islands().size()) by_island_.resize(islands_.islands().size());
  for (uint32_t i = 0; i < rows.size(); ++i) {
    const uint32_t island = islands_.IslandOf(rows[i].a, rows[i].b);
    if (island == Islands::kNone || islands_.islands()[island].contacts > 0) {
      left_.push_back(i);
    } else {
      by_island_[island].push_back(i);
    }
  }
  for (uint32_t island = 0; island < islands_.islands().size(); ++island) {
    std::vector<uint32_t>& list = by_island_[island];
    if (list.empty() || SolveIsland(island, h, rows)) continue;
    left_.insert(left_.end(), list.begin(), list.end());
    list.clear();
  }
  for (JointBody& body : bodies_) {
    if (!body.is_movable()) continue;
    state_.linear_velocities.col(Index(body.row)) = body.linear_velocity;
    state_.angular_velocities.col(Index(body.row)) = body.angular_velocity;
  }
  if (left_.size() == rows.size()) return rows;
  std::sort(left_.begin(), left_.end());
  for (const uint32_t i : left_) left_rows_.push_back(rows[i]);
  return left_rows_;
}

void JointStep::TakeLeft(std::vector<JointRow>& rows) const {
  for (size_t i = 0; i < left_rows_.size(); ++i) rows[left_[i]].impulse = left_rows_[i].impulse;
}

void JointStep::AllowWork(std::span<const JointRow> rows, std::span<SolveEnergy> energies) const {
  for (const JointRow& row : rows) {
    const uint32_t island = islands_.IslandOf(row.a, row.b);
    if (island == Islands::kNone) continue;
    if (!row.is_driven) {
      energies[island].allowed += row.repair;
      continue;
    }
    // A force that does not change through the solve works along the mean of both rates.
    double rate = 0;
    for (const auto& [side, sign] : {std::pair(row.a, -1.0), std::pair(row.b, 1.0)}) {
      if (side == kWorldRow) continue;
      const JointBody& body = bodies_[body_of_[Index(side)]];
      const Vector3 linear = (body.linear_given + state_.linear_velocities.col(Index(side))) / 2;
      const Vector3 spin = (body.angular_given + state_.angular_velocities.col(Index(side))) / 2;
      const bool is_linear = row.kind == JointRow::Kind::kLinear;
      rate += sign * row.axis.dot(is_linear ? Vector3(linear + spin.cross(row.point - body.center)) : spin);
    }
    energies[island].allowed += std::max(row.impulse * rate, 0.0);
  }
}

void JointStep::Take(double h) {
  const auto spin = [&](EntityRow row) -> Vector3 {
    return row == kWorldRow ? Vector3(Vector3::Zero()) : Vector3(state_.angular_velocities.col(Index(row)));
  };
  for (Held& held : held_) held.last_force.setZero();
  for (size_t i = 0; i < owners_.size(); ++i) {
    const JointRow& row = rows_[i];
    Held& held = held_[owners_[i]];
    if (row.kind == JointRow::Kind::kLinear) {
      held.force += held.share * row.impulse * row.axis;
      held.last_force += held.share / h * row.impulse * row.axis;
    } else if (row.kind == JointRow::Kind::kAngular) {
      held.torque += held.share * row.impulse * row.axis;
    } else {
      held.torque += held.share * row.impulse * row.axis_b;
      // No pose tells how often a gear has turned, so that what it slipped is added up.
      layer_.joints[held.slot].positions[5] += h * (row.axis.dot(spin(row.a)) + row.axis_b.dot(spin(row.b)));
    }
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

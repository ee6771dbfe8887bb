#include "joints/row_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace genphys {
namespace {

constexpr int kRoundsMax = 100;
// So often may the number of rows on the wrong side fail to fall before they change sides one by one.
constexpr int kPatience = 5;
// Where that has no end, rows are swept so often instead.
constexpr int kSweeps = 100;
// Of what is compared, and m/s or rad/s: what rounding leaves is on no wrong side.
constexpr double kRelativeSlack = 1e-10, kAbsoluteSlack = 1e-13;

}  // namespace

bool RowSolver::Solve(uint32_t plan_number, std::span<JointRow> rows, std::span<const uint32_t> mine,
                      std::span<const uint32_t> body_of, std::span<JointBody> bodies) {
  Load(rows, mine, body_of, bodies);
  if (plan_number >= plans_.size()) plans_.resize(plan_number + 1);
  RowPlan& plan = plans_[plan_number];
  is_swept_ = false;
  const bool is_solved = plan.Make(groups_) && SolveBounded(plan);
  if (is_solved) Give(bodies);
  for (const uint32_t body : used_) local_of_[body] = RowPlan::kStill;
  return is_solved;
}

bool RowSolver::SolveAgain(uint32_t plan_number, std::span<JointBody> bodies) {
  const RowPlan& plan = plans_[plan_number];
  for (Line& line : lines_) {
    line.lacking += line.row->target - line.target;
    line.target = line.row->target;
  }
  // Who is at a bound mostly stays there, and the factors remain.
  CollectInside();
  Substitute(plan);
  if (!ChangeVelocities()) return false;
  if (is_bounded_ && FindWrong() > 0 && !SolveBounded(plan)) return false;
  Give(bodies);
  return true;
}

// Rows that contradict each other, as a slider and a hinge of the same two may, pull so hard against one another that
// rounding decides which of them are at bounds. Projected Gauss-Seidel comes nowhere near that: each turn of a row
// only lessens what all of them lack. False if not even numbers are left.
bool RowSolver::Sweep() {
  is_swept_ = true;
  for (Six& change : changes_) change.setZero();
  for (Line& line : lines_) line.impulse = 0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (Line& line : lines_) {
      const double before = line.impulse;
      line.impulse = std::clamp(before + LackingOf(line) / line.diagonal, line.row->lower, line.row->upper);
      for (size_t side = 0; side < 2; ++side) {
        const uint32_t body = groups_[line.group].bodies[side];
        if (body != RowPlan::kStill) changes_[body] += (line.impulse - before) * line.gain[side];
      }
    }
  }
  return std::ranges::all_of(lines_, [](const Line& line) { return std::isfinite(line.impulse); });
}

void RowSolver::Give(std::span<JointBody> bodies) const {
  for (const Line& line : lines_) line.row->impulse = line.impulse;
  for (size_t i = 0; i < used_.size(); ++i) {
    bodies[used_[i]].linear_velocity += changes_[i].head<3>();
    bodies[used_[i]].angular_velocity += changes_[i].tail<3>();
  }
}

uint32_t RowSolver::LocalOf(uint32_t body) {
  uint32_t& local = local_of_[body];
  if (local == RowPlan::kStill) {
    local = static_cast<uint32_t>(used_.size());
    used_.push_back(body);
  }
  return local;
}

void RowSolver::Load(std::span<JointRow> rows, std::span<const uint32_t> mine, std::span<const uint32_t> body_of,
                     std::span<const JointBody> bodies) {
  lines_.resize(mine.size());
  groups_.clear();
  used_.clear();
  local_of_.resize(bodies.size(), RowPlan::kStill);
  const auto body_at = [&](EntityRow row) { return row == kWorldRow ? 0 : body_of[Index(row)]; };
  const auto local_at = [&](uint32_t body) { return bodies[body].is_movable() ? LocalOf(body) : RowPlan::kStill; };
  const JointRow* last = nullptr;
  uint32_t a = 0, b = 0;
  is_bounded_ = false;
  int unbounded = 0;  // rows of a block still to come
  for (size_t i = 0; i < mine.size(); ++i) {
    JointRow& row = rows[mine[i]];
    if (last == nullptr || &row != last + 1 || row.a != last->a || row.b != last->b) {
      a = body_at(row.a);
      b = body_at(row.b);
      groups_.push_back({0, {local_at(a), local_at(b)}});
    }
    last = &row;
    ++groups_.back().size;
    Line& line = lines_[i];
    line.row = &row;
    line.target = row.target;
    line.impulse = 0;
    line.group = static_cast<uint32_t>(groups_.size() - 1);
    line.place = Place::kInside;
    if (row.block > 1) unbounded = row.block;
    if (unbounded > 0) {
      --unbounded;
      continue;
    }
    // A limit mostly has nothing to do, a motor all of it, and what shall push so just that.
    const bool is_given = row.lower == row.upper, is_one_sided = row.lower == 0 || row.upper == 0;
    if (is_given || is_one_sided) line.place = is_given || row.upper == 0 ? Place::kAtUpper : Place::kAtLower;
    is_bounded_ |= row.lower != -JointRow::kUnbounded || row.upper != JointRow::kUnbounded;
  }
  changes_.resize(used_.size());
  is_point_.assign(groups_.size(), false);
  for (size_t i = 0; i < lines_.size();) {
    const JointBody &side_a = bodies[body_at(lines_[i].row->a)], &side_b = bodies[body_at(lines_[i].row->b)];
    if (IsPoint(i)) {
      const uint32_t group = lines_[i].group;
      is_point_[group] = groups_[group].size == 3;
      LoadPoint(&lines_[i], side_a, side_b);
      i += 3;
    } else {
      LoadSides(lines_[i++], side_a, side_b);
    }
  }
}

// Whether these three lines are a block along x, y and z.
bool RowSolver::IsPoint(size_t first) const {
  const Line* const lines = &lines_[first];
  return lines[0].row->block == 3 && first + 3 <= lines_.size() && lines[2].group == lines[0].group &&
         lines[0].row->axis == Vector3::UnitX() && lines[1].row->axis == Vector3::UnitY() &&
         lines[2].row->axis == Vector3::UnitZ();
}

// The same as LoadSides() of each, without what is zero.
void RowSolver::LoadPoint(Line* lines, const JointBody& a, const JointBody& b) {
  const Vector3& point = lines[0].row->point;
  const Vector3 relative = b.VelocityAt(point) - a.VelocityAt(point);
  for (int i = 0; i < 3; ++i) {
    lines[i].lacking = lines[i].row->target - relative[i];
    lines[i].diagonal = lines[i].row->softness;
  }
  for (const size_t side : {size_t{0}, size_t{1}}) {
    const JointBody& body = side == 0 ? a : b;
    if (!body.is_movable()) continue;
    const double sign = side == 0 ? -1 : 1;
    const Vector3 arm = sign * (point - body.center);
    const auto load = [&](int i, int j, int k) {
      Six &rate = lines[i].rate[side], &gain = lines[i].gain[side];
      rate.setZero();
      rate[i] = sign;
      rate[3 + j] = arm[k];
      rate[3 + k] = -arm[j];
      gain.head<3>().setZero();
      gain[i] = sign * body.inverse_mass;
      gain.tail<3>() = arm[k] * body.inverse_tensor.col(j) - arm[j] * body.inverse_tensor.col(k);
      lines[i].diagonal += body.inverse_mass + arm[k] * gain[3 + j] - arm[j] * gain[3 + k];
    };
    load(0, 1, 2);
    load(1, 2, 0);
    load(2, 0, 1);
  }
}

void RowSolver::LoadSides(Line& line, const JointBody& a, const JointBody& b) {
  const JointRow& row = *line.row;
  Vector3 turn_a = row.axis, turn_b = row.axis_b;
  const bool is_linear = row.kind == JointRow::Kind::kLinear;
  if (is_linear) {
    turn_a = row.axis.cross(row.point - a.center);
    turn_b = (row.point - b.center).cross(row.axis);
  } else if (row.kind == JointRow::Kind::kAngular) {
    turn_a = -row.axis;
    turn_b = row.axis;
  }
  const Vector3 push = is_linear ? row.axis : Vector3(Vector3::Zero());
  const Vector3 gain_a = a.inverse_tensor * turn_a, gain_b = b.inverse_tensor * turn_b;
  const auto set = [](Six& six, const Vector3& linear, const Vector3& angular) {
    six.head<3>() = linear;
    six.tail<3>() = angular;
  };
  set(line.rate[0], -push, turn_a);
  set(line.rate[1], push, turn_b);
  set(line.gain[0], -a.inverse_mass * push, gain_a);
  set(line.gain[1], b.inverse_mass * push, gain_b);
  line.lacking = row.target - push.dot(b.linear_velocity - a.linear_velocity) - turn_a.dot(a.angular_velocity) -
                 turn_b.dot(b.angular_velocity);
  line.diagonal =
      row.softness + push.squaredNorm() * (a.inverse_mass + b.inverse_mass) + turn_a.dot(gain_a) + turn_b.dot(gain_b);
}

bool RowSolver::SolveBounded(const RowPlan& plan) {
  size_t fewest = std::numeric_limits<size_t>::max();
  int patience = kPatience;
  for (int round = 0; round < kRoundsMax; ++round) {
    CollectInside();
    Assemble(plan);
    if (!Factor(plan)) return Sweep();
    Substitute(plan);
    if (!ChangeVelocities()) return Sweep();
    if (!is_bounded_) return true;
    const size_t wrong = FindWrong();
    if (wrong == 0) return true;
    if (wrong < fewest) {
      fewest = wrong;
      patience = kPatience;
    } else {
      --patience;
    }
    if (patience > 0) {
      for (const uint32_t each : wrong_) Move(lines_[each]);
    } else {
      Move(lines_[wrong_.back()]);
    }
  }
  return Sweep();
}

void RowSolver::CollectInside() {
  inside_.clear();
  first_inside_.clear();
  is_pushed_ = false;
  for (Six& change : changes_) change.setZero();
  for (uint32_t i = 0; i < lines_.size(); ++i) {
    Line& line = lines_[i];
    if (first_inside_.size() <= line.group) first_inside_.push_back(static_cast<uint32_t>(inside_.size()));
    if (line.place == Place::kInside) {
      inside_.push_back(i);
      continue;
    }
    line.impulse = line.place == Place::kAtLower ? line.row->lower : line.row->upper;
    if (line.impulse == 0) continue;
    is_pushed_ = true;
    for (size_t side = 0; side < 2; ++side) {
      const uint32_t body = groups_[line.group].bodies[side];
      if (body != RowPlan::kStill) changes_[body] += line.impulse * line.gain[side];
    }
  }
  first_inside_.push_back(static_cast<uint32_t>(inside_.size()));
}

void RowSolver::Assemble(const RowPlan& plan) {
  values_.assign(plan.value_count(), 0);
  for (const RowPlan::Coupling& coupling : plan.couplings()) {
    if (coupling.later == coupling.earlier) {
      AssembleOwn(coupling);
    } else if (is_point_[coupling.later] && is_point_[coupling.earlier]) {
      AssemblePoints(coupling);
    } else {
      AssembleRows(coupling);
    }
  }
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    const std::span<const uint32_t> inside = InsideOf(g);
    for (size_t p = 0; p < inside.size(); ++p) {
      values_[plan.diagonal(g) + p * (groups_[g].size + 1)] = lines_[inside[p]].diagonal;
    }
  }
}

// What rows of one group share, below their diagonal. Of a point it is nothing that is linear.
void RowSolver::AssembleOwn(const RowPlan::Coupling& coupling) {
  const std::span<const uint32_t> inside = InsideOf(coupling.later);
  double* to = &values_[coupling.block];
  if (is_point_[coupling.later]) {
    const Line* const lines = &lines_[inside.front()];
    const auto shared = [&](int p, int q) {
      return lines[p].rate[coupling.side_of_later].tail<3>().dot(lines[q].gain[coupling.side_of_later].tail<3>());
    };
    to[3] += shared(1, 0);
    to[6] += shared(2, 0);
    to[7] += shared(2, 1);
    return;
  }
  for (size_t p = 0; p < inside.size(); ++p, to += groups_[coupling.later].size) {
    const Six& rate = lines_[inside[p]].rate[coupling.side_of_later];
    for (size_t q = 0; q < p; ++q) to[q] += rate.dot(lines_[inside[q]].gain[coupling.side_of_later]);
  }
}

void RowSolver::AssembleRows(const RowPlan::Coupling& coupling) {
  const std::span<const uint32_t> later = InsideOf(coupling.later), earlier = InsideOf(coupling.earlier);
  double* to = &values_[coupling.block];
  for (size_t p = 0; p < later.size(); ++p, to += groups_[coupling.earlier].size) {
    const Six& rate = lines_[later[p]].rate[coupling.side_of_later];
    for (size_t q = 0; q < earlier.size(); ++q) to[q] += rate.dot(lines_[earlier[q]].gain[coupling.side_of_earlier]);
  }
}

// Rows along the same three axes share of what is linear only what is along the same one.
void RowSolver::AssemblePoints(const RowPlan::Coupling& coupling) {
  const Line* const later = &lines_[InsideOf(coupling.later).front()];
  const Line* const earlier = &lines_[InsideOf(coupling.earlier).front()];
  double* const to = &values_[coupling.block];
  const double linear = later->rate[coupling.side_of_later][0] * earlier->gain[coupling.side_of_earlier][0];
  for (size_t p = 0; p < 3; ++p) {
    const auto turn = later[p].rate[coupling.side_of_later].tail<3>();
    for (size_t q = 0; q < 3; ++q) {
      to[3 * p + q] += turn.dot(earlier[q].gain[coupling.side_of_earlier].tail<3>()) + (p == q ? linear : 0);
    }
  }
}

bool RowSolver::Factor(const RowPlan& plan) {
  for (const uint32_t group : plan.order()) {
    const size_t size = InsideOf(group).size();
    if (size == 0) continue;
    const bool is_definite = WithRowCount(size, [&](auto count) {
      if (!FactorBlock(count, &values_[plan.diagonal(group)], groups_[group].size)) return false;
      EliminateFrom(plan, group, count);
      return true;
    });
    if (!is_definite) return false;
  }
  return true;
}

template <size_t kKnown>
void RowSolver::EliminateFrom(const RowPlan& plan, uint32_t group, RowCount<kKnown> count) {
  const size_t stride = groups_[group].size;
  const double* const factors = &values_[plan.diagonal(group)];
  const std::span<const RowPlan::Link> links = plan.links(group);
  first_undivided_.clear();
  size_t rows = 0;
  for (const RowPlan::Link& link : links) {
    first_undivided_.push_back(rows * count);
    rows += InsideOf(link.group).size();
  }
  if (undivided_.size() < rows * count) undivided_.resize(rows * count);
  double* undivided = undivided_.data();
  for (const RowPlan::Link& link : links) {
    for (size_t p = 0; p < InsideOf(link.group).size(); ++p, undivided += count) {
      DivideRow(count, factors, stride, &values_[link.block + p * stride], undivided);
    }
  }
  const std::span<const size_t> targets = plan.targets(group);
  size_t target = 0;
  for (size_t b = 0; b < links.size(); ++b) {
    const size_t height = InsideOf(links[b].group).size();
    for (size_t a = 0; a <= b; ++a, ++target) {
      const size_t columns = InsideOf(links[a].group).size(), width = groups_[links[a].group].size;
      for (size_t p = 0; p < height; ++p) {
        const double* const divided = &values_[links[b].block + p * stride];
        const double* other = &undivided_[first_undivided_[a]];
        double* const to = &values_[targets[target] + p * width];
        const size_t last = a == b ? p + 1 : columns;
        for (size_t q = 0; q < last; ++q, other += count) to[q] -= DotRows(count, divided, other);
      }
    }
  }
}

void RowSolver::FindLacking() {
  solution_.resize(inside_.size());
  for (size_t i = 0; i < inside_.size(); ++i) {
    const Line& line = lines_[inside_[i]];
    solution_[i] = line.lacking;
    for (size_t side = 0; is_pushed_ && side < 2; ++side) {
      const uint32_t body = groups_[line.group].bodies[side];
      if (body != RowPlan::kStill) solution_[i] -= line.rate[side].dot(changes_[body]);
    }
  }
}

void RowSolver::Substitute(const RowPlan& plan) {
  FindLacking();
  double* const solution = solution_.data();
  for (const uint32_t group : plan.order()) {
    const size_t stride = groups_[group].size;
    WithRowCount(InsideOf(group).size(), [&](auto count) {
      double* const own = solution + first_inside_[group];
      SubstituteForwards(count, &values_[plan.diagonal(group)], stride, own);
      for (const RowPlan::Link& link : plan.links(group)) {
        const double* row = &values_[link.block];
        for (size_t p = first_inside_[link.group]; p < first_inside_[link.group + 1]; ++p, row += stride) {
          solution[p] -= DotRows(count, row, own);
        }
      }
    });
  }
  for (auto place = plan.order().rbegin(); place != plan.order().rend(); ++place) {
    const uint32_t group = *place;
    const size_t stride = groups_[group].size;
    WithRowCount(InsideOf(group).size(), [&](auto count) {
      const double* const factors = &values_[plan.diagonal(group)];
      double* const own = solution + first_inside_[group];
      for (size_t p = 0; p < count; ++p) own[p] *= factors[p * (stride + 1)];
      for (const RowPlan::Link& link : plan.links(group)) {
        const double* row = &values_[link.block];
        for (size_t p = first_inside_[link.group]; p < first_inside_[link.group + 1]; ++p, row += stride) {
          for (size_t q = 0; q < count; ++q) own[q] -= row[q] * solution[p];
        }
      }
      SubstituteBackwards(count, factors, stride, own);
    });
  }
}

// False if the numbers did not suffice.
bool RowSolver::ChangeVelocities() {
  for (size_t i = 0; i < inside_.size(); ++i) {
    lines_[inside_[i]].impulse = solution_[i];
    if (!std::isfinite(solution_[i])) return false;
  }
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    const std::span<const uint32_t> inside = InsideOf(g);
    for (size_t side = 0; side < 2; ++side) {
      const uint32_t body = groups_[g].bodies[side];
      if (body == RowPlan::kStill) continue;
      Six& change = changes_[body];
      if (is_point_[g]) {
        const Line* const lines = &lines_[inside.front()];
        change.head<3>() += lines[0].gain[side][0] * Vector3(lines[0].impulse, lines[1].impulse, lines[2].impulse);
        for (int i = 0; i < 3; ++i) change.tail<3>() += lines[i].impulse * lines[i].gain[side].tail<3>();
      } else {
        for (const uint32_t i : inside) change += lines_[i].impulse * lines_[i].gain[side];
      }
    }
  }
  return true;
}

double RowSolver::LackingOf(const Line& line) const {
  double lacking = line.lacking - line.row->softness * line.impulse;
  for (size_t side = 0; side < 2; ++side) {
    const uint32_t body = groups_[line.group].bodies[side];
    if (body != RowPlan::kStill) lacking -= line.rate[side].dot(changes_[body]);
  }
  return lacking;
}

// Those beyond a bound, and those at one that holds them back from where they would go.
size_t RowSolver::FindWrong() {
  wrong_.clear();
  for (uint32_t i = 0; i < lines_.size(); ++i) {
    const Line& line = lines_[i];
    const double slack = kAbsoluteSlack + kRelativeSlack * std::abs(line.lacking);
    bool is_wrong = false;
    switch (line.place) {
      case Place::kInside: {
        const double below = line.row->lower - line.impulse, above = line.impulse - line.row->upper;
        is_wrong = std::max(below, above) * line.diagonal > slack;
        break;
      }
      case Place::kAtLower:
        is_wrong = LackingOf(line) > slack;
        break;
      case Place::kAtUpper:
        is_wrong = line.row->lower < line.row->upper && LackingOf(line) < -slack;
        break;
    }
    if (is_wrong) wrong_.push_back(i);
  }
  return wrong_.size();
}

void RowSolver::Move(Line& line) const {
  if (line.place != Place::kInside) {
    line.place = Place::kInside;
  } else {
    line.place = line.impulse < line.row->lower ? Place::kAtLower : Place::kAtUpper;
  }
}

}  // namespace genphys

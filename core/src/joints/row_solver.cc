#include "joints/row_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace genphys {
namespace {

constexpr int kRoundsMax = 100;
// So often may the number of rows on the wrong side fail to fall before they change sides one by one.
constexpr int kPatience = 5;
// Of what is compared, and m/s or rad/s: what rounding leaves is on no wrong side.
constexpr double kRelativeSlack = 1e-10, kAbsoluteSlack = 1e-13;

}  // namespace

bool RowSolver::Solve(uint32_t plan_number, std::span<JointRow> rows, std::span<const uint32_t> mine,
                      std::span<const uint32_t> body_of, std::span<JointBody> bodies) {
  Load(rows, mine, body_of, bodies);
  if (plan_number >= plans_.size()) plans_.resize(plan_number + 1);
  RowPlan& plan = plans_[plan_number];
  const bool is_solved = plan.Make(groups_) && SolveBounded(plan);
  if (is_solved) {
    for (const Line& line : lines_) line.row->impulse = line.impulse;
    for (size_t i = 0; i < used_.size(); ++i) {
      bodies[used_[i]].linear_velocity += changes_[i].head<3>();
      bodies[used_[i]].angular_velocity += changes_[i].tail<3>();
    }
  }
  for (const uint32_t body : used_) local_of_[body] = RowPlan::kStill;
  return is_solved;
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
  lines_.clear();
  groups_.clear();
  first_line_.clear();
  used_.clear();
  local_of_.resize(bodies.size(), RowPlan::kStill);
  const auto body_at = [&](EntityRow row) { return row == kWorldRow ? 0 : body_of[Index(row)]; };
  uint32_t last = ~uint32_t{0};
  for (const uint32_t index : mine) {
    JointRow& row = rows[index];
    const uint32_t a = body_at(row.a), b = body_at(row.b);
    const RowPlan::Group between{
        0,
        {bodies[a].is_movable() ? LocalOf(a) : RowPlan::kStill, bodies[b].is_movable() ? LocalOf(b) : RowPlan::kStill}};
    if (groups_.empty() || index != last + 1 || groups_.back().bodies != between.bodies) {
      groups_.push_back(between);
      first_line_.push_back(static_cast<uint32_t>(lines_.size()));
    }
    last = index;
    ++groups_.back().size;
    Line& line = lines_.emplace_back();
    line.row = &row;
    line.group = static_cast<uint32_t>(groups_.size() - 1);
    LoadSides(line, a, b, bodies);
    // A limit mostly has nothing to do, and a motor all of it.
    const bool is_one_sided = row.lower == 0 || row.upper == 0;
    line.place = !is_one_sided ? Place::kInside : row.lower == 0 ? Place::kAtLower : Place::kAtUpper;
  }
  changes_.assign(used_.size(), Six::Zero());
}

void RowSolver::LoadSides(Line& line, uint32_t a, uint32_t b, std::span<const JointBody> bodies) {
  const JointRow& row = *line.row;
  const JointBody &body_a = bodies[a], &body_b = bodies[b];
  if (row.kind == JointRow::Kind::kLinear) {
    line.rate[0].head<3>() = -row.axis;
    line.rate[0].tail<3>() = row.axis.cross(row.point - body_a.center);
    line.rate[1].head<3>() = row.axis;
    line.rate[1].tail<3>() = (row.point - body_b.center).cross(row.axis);
  } else {
    const bool is_geared = row.kind == JointRow::Kind::kGeared;
    line.rate[0].head<3>().setZero();
    line.rate[0].tail<3>() = is_geared ? row.axis : Vector3(-row.axis);
    line.rate[1].head<3>().setZero();
    line.rate[1].tail<3>() = is_geared ? row.axis_b : row.axis;
  }
  line.lacking = row.target;
  line.diagonal = row.softness;
  for (size_t side = 0; side < 2; ++side) {
    const JointBody& body = side == 0 ? body_a : body_b;
    const Six& rate = line.rate[side];
    line.gain[side].head<3>() = body.inverse_mass * rate.head<3>();
    line.gain[side].tail<3>().noalias() = body.inverse_tensor * rate.tail<3>();
    line.lacking -= rate.head<3>().dot(body.linear_velocity) + rate.tail<3>().dot(body.angular_velocity);
    line.diagonal += rate.dot(line.gain[side]);
  }
}

bool RowSolver::SolveBounded(const RowPlan& plan) {
  size_t fewest = std::numeric_limits<size_t>::max();
  int patience = kPatience;
  for (int round = 0; round < kRoundsMax; ++round) {
    CollectInside();
    Assemble(plan);
    if (!Factor(plan)) return false;
    Substitute(plan);
    if (!ChangeVelocities()) return false;
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
  return false;
}

void RowSolver::CollectInside() {
  if (inside_.size() < groups_.size()) inside_.resize(groups_.size());
  for (size_t g = 0; g < groups_.size(); ++g) inside_[g].clear();
  for (Six& change : changes_) change.setZero();
  for (uint32_t i = 0; i < lines_.size(); ++i) {
    Line& line = lines_[i];
    if (line.place == Place::kInside) {
      inside_[line.group].push_back(i);
      continue;
    }
    line.impulse = line.place == Place::kAtLower ? line.row->lower : line.row->upper;
    if (line.impulse == 0) continue;
    for (size_t side = 0; side < 2; ++side) {
      const uint32_t body = groups_[line.group].bodies[side];
      if (body != RowPlan::kStill) changes_[body] += line.impulse * line.gain[side];
    }
  }
}

void RowSolver::Assemble(const RowPlan& plan) {
  values_.assign(plan.value_count(), 0);
  for (const RowPlan::Coupling& coupling : plan.couplings()) {
    const std::vector<uint32_t>&later = inside_[coupling.later], &earlier = inside_[coupling.earlier];
    const size_t stride = groups_[coupling.earlier].size;
    const bool is_diagonal = coupling.later == coupling.earlier;
    for (size_t p = 0; p < later.size(); ++p) {
      double* const to = &values_[coupling.block + p * stride];
      const Six& rate = lines_[later[p]].rate[coupling.side_of_later];
      const size_t count = is_diagonal ? p + 1 : earlier.size();
      for (size_t q = 0; q < count; ++q) to[q] += rate.dot(lines_[earlier[q]].gain[coupling.side_of_earlier]);
    }
  }
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    for (size_t p = 0; p < inside_[g].size(); ++p) {
      values_[plan.diagonal(g) + p * (groups_[g].size + 1)] += lines_[inside_[g][p]].row->softness;
    }
  }
}

// L D L^T in place, with the ones of L left out.
bool RowSolver::FactorDiagonal(double* block, size_t stride, size_t count) {
  for (size_t c = 0; c < count; ++c) {
    const double pivot = block[c * stride + c];
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    for (size_t r = c + 1; r < count; ++r) {
      const double unscaled = block[r * stride + c];
      const double scaled = unscaled / pivot;
      for (size_t k = c + 1; k <= r; ++k) {
        // Rows above this one are divided already.
        const double other = k < r ? block[k * stride + c] * pivot : unscaled;
        block[r * stride + k] -= scaled * other;
      }
      block[r * stride + c] = scaled;
    }
  }
  return true;
}

bool RowSolver::Factor(const RowPlan& plan) {
  for (const uint32_t group : plan.order()) {
    if (inside_[group].empty()) continue;
    if (!FactorDiagonal(&values_[plan.diagonal(group)], groups_[group].size, inside_[group].size())) return false;
    EliminateFrom(plan, group);
  }
  return true;
}

void RowSolver::EliminateFrom(const RowPlan& plan, uint32_t group) {
  const size_t stride = groups_[group].size, count = inside_[group].size();
  const double* const diagonal = &values_[plan.diagonal(group)];
  const std::span<const RowPlan::Link> links = plan.links(group);
  unscaled_.clear();
  first_unscaled_.clear();
  for (const RowPlan::Link& link : links) {
    first_unscaled_.push_back(unscaled_.size());
    for (size_t p = 0; p < inside_[link.group].size(); ++p) {
      double* const row = &values_[link.block + p * stride];
      const size_t first = unscaled_.size();
      for (size_t q = 0; q < count; ++q) {
        double value = row[q];
        for (size_t k = 0; k < q; ++k) value -= unscaled_[first + k] * diagonal[q * stride + k];
        unscaled_.push_back(value);
      }
      for (size_t q = 0; q < count; ++q) row[q] = unscaled_[first + q] / diagonal[q * stride + q];
    }
  }
  const std::span<const size_t> targets = plan.targets(group);
  size_t target = 0;
  for (size_t b = 0; b < links.size(); ++b) {
    const size_t rows = inside_[links[b].group].size();
    for (size_t a = 0; a <= b; ++a, ++target) {
      const size_t columns = inside_[links[a].group].size(), width = groups_[links[a].group].size;
      for (size_t p = 0; p < rows; ++p) {
        const double* const scaled = &values_[links[b].block + p * stride];
        double* const to = &values_[targets[target] + p * width];
        const size_t last = a == b ? p + 1 : columns;
        for (size_t q = 0; q < last; ++q) {
          const double* const other = &unscaled_[first_unscaled_[a] + q * count];
          double sum = 0;
          for (size_t k = 0; k < count; ++k) sum += scaled[k] * other[k];
          to[q] -= sum;
        }
      }
    }
  }
}

void RowSolver::Substitute(const RowPlan& plan) {
  solution_.resize(lines_.size());
  for (const std::vector<uint32_t>* lines = inside_.data(); lines != inside_.data() + groups_.size(); ++lines) {
    for (const uint32_t i : *lines) {
      const Line& line = lines_[i];
      solution_[i] = line.lacking;
      for (size_t side = 0; side < 2; ++side) {
        const uint32_t body = groups_[line.group].bodies[side];
        if (body != RowPlan::kStill) solution_[i] -= line.rate[side].dot(changes_[body]);
      }
    }
  }
  for (const uint32_t group : plan.order()) {
    const std::vector<uint32_t>& own = inside_[group];
    const size_t stride = groups_[group].size;
    const double* const diagonal = &values_[plan.diagonal(group)];
    for (size_t p = 0; p < own.size(); ++p) {
      for (size_t q = 0; q < p; ++q) solution_[own[p]] -= diagonal[p * stride + q] * solution_[own[q]];
    }
    for (const RowPlan::Link& link : plan.links(group)) {
      for (size_t p = 0; p < inside_[link.group].size(); ++p) {
        const double* const row = &values_[link.block + p * stride];
        for (size_t q = 0; q < own.size(); ++q) solution_[inside_[link.group][p]] -= row[q] * solution_[own[q]];
      }
    }
  }
  for (auto place = plan.order().rbegin(); place != plan.order().rend(); ++place) {
    const std::vector<uint32_t>& own = inside_[*place];
    const size_t stride = groups_[*place].size;
    const double* const diagonal = &values_[plan.diagonal(*place)];
    for (size_t p = 0; p < own.size(); ++p) solution_[own[p]] /= diagonal[p * stride + p];
    for (const RowPlan::Link& link : plan.links(*place)) {
      for (size_t p = 0; p < inside_[link.group].size(); ++p) {
        const double* const row = &values_[link.block + p * stride];
        for (size_t q = 0; q < own.size(); ++q) solution_[own[q]] -= row[q] * solution_[inside_[link.group][p]];
      }
    }
    for (size_t p = own.size(); p-- > 0;) {
      for (size_t q = 0; q < p; ++q) solution_[own[q]] -= diagonal[p * stride + q] * solution_[own[p]];
    }
  }
}

// False if the numbers did not suffice.
bool RowSolver::ChangeVelocities() {
  for (size_t g = 0; g < groups_.size(); ++g) {
    for (const uint32_t i : inside_[g]) {
      Line& line = lines_[i];
      line.impulse = solution_[i];
      if (!std::isfinite(line.impulse)) return false;
      for (size_t side = 0; side < 2; ++side) {
        const uint32_t body = groups_[g].bodies[side];
        if (body != RowPlan::kStill) changes_[body] += line.impulse * line.gain[side];
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
        is_wrong = LackingOf(line) < -slack;
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

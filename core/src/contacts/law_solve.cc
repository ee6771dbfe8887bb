#include "contacts/law_solve.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace genphys {
namespace {

constexpr int kIterationsMax = 20;
// So often it may come no nearer, before so many sweeps lead it to where it may.
constexpr int kPatience = 2;
constexpr int kSweeps = 10;
// m/s or rad/s, and a part of what impulses do by themselves: it comes no nearer to the laws.
constexpr double kSettled = 1e-12;
constexpr double kRounding = 1e-14;
// m/s or rad/s: near enough if the last iteration helped little, and if none did.
constexpr double kAgreed = 1e-9;
constexpr double kNearEnough = 1e-6;
// Of what friction bears: more exact it need not be.
constexpr double kAgrees = 1e-6;
// Of its mobility: so much more a row gives way in an iteration. Where rows bear the same in many ways, it takes the
// smallest change.
constexpr double kGive = 1e-12;
// Of the mobility: what is softer turns nothing that slips so fast.
constexpr double kSoftest = 1e6;
// Of what friction bears: what starts from less holds.
constexpr double kHolding = 1 - 1e-9;

Eigen::Vector2d NearestInDisc(const Eigen::Vector2d& impulse, double most) {
  const double size = impulse.norm();
  return size > most ? Eigen::Vector2d(most / size * impulse) : impulse;
}

}  // namespace

bool LawSolve::Begin(std::span<const DirectRow> rows, std::span<const MotionChange> bodies) {
  rows_ = rows;
  moved_.assign(bodies.begin(), bodies.end());
  row_sides_.clear();
  const auto side_of = [&](const DirectRow::Part& part) { return IsMoved(part) ? part.body : RowPlan::kStill; };
  for (const DirectRow& row : rows_) row_sides_.push_back({side_of(row.a), side_of(row.b)});
  if (!elimination_.Begin(row_sides_, bodies.size())) return false;
  FindLaws();
  FindSides();
  FindAnswers();
  return true;
}

void LawSolve::FindLaws() {
  boxes_.clear();
  discs_.clear();
  laws_.assign(rows_.size(), Law::kHolds);
  for (uint32_t row = 0; row < rows_.size(); ++row) {
    const DirectRow& each = rows_[row];
    if (each.is_free()) continue;
    if (each.bounds.bounded_by == BoundedSolver::kFree) {
      boxes_.push_back(row);
      continue;
    }
    discs_.push_back({.row = row,
                      .normal = static_cast<uint32_t>(each.bounds.bounded_by),
                      .friction = each.bounds.upper,
                      .is_pair = each.is_first_of_two});
    if (each.is_first_of_two) ++row;
  }
}

void LawSolve::FindSides() {
  const std::span<const uint32_t> order = elimination_.order();
  place_.resize(order.size());
  at_.resize(order.size());
  bodies_.assign(moved_.size(), {});
  const auto visit = [&](auto&& use) {
    for (uint32_t place = 0; place < order.size(); ++place) {
      const DirectRow& row = rows_[order[place]];
      for (const DirectRow::Part* part : {&row.a, &row.b}) {
        if (IsMoved(*part)) use(place, *part, at_[order[place]][part == &row.b]);
      }
    }
  };
  visit([&](uint32_t place, const DirectRow::Part& part, uint32_t& at) {
    place_[order[place]] = place;
    at = bodies_[part.body].count++;
  });
  uint32_t first = 0;
  size_t first_answer = 0;
  for (Body& body : bodies_) {
    body.first = std::exchange(first, first + body.count);
    body.first_answer = std::exchange(first_answer, first_answer + size_t{body.count} * body.count);
  }
  sides_.resize(first);
  answers_.resize(first_answer);
  visit([&](uint32_t place, const DirectRow::Part& part, uint32_t at) {
    sides_[bodies_[part.body].first + at] = {place, &part};
  });
}

void LawSolve::FindAnswers() {
  scales_.clear();
  for (const DirectRow& row : rows_) scales_.push_back(row.softness);
  for (const Body& body : bodies_) {
    double* const square = answers_.data() + body.first_answer;
    const std::span<const Side> sides = SidesOf(body);
    for (uint32_t i = 0; i < body.count; ++i) {
      for (uint32_t j = 0; j <= i; ++j) {
        square[i * body.count + j] = square[j * body.count + i] = sides[i].part->Answer(*sides[j].part);
      }
      scales_[elimination_.order()[sides[i].place]] += square[i * body.count + i];
    }
  }
}

Eigen::Vector2d LawSolve::Of(const Disc& disc, const Eigen::VectorXd& values) const {
  return {values[disc.row], disc.is_pair ? values[disc.row + 1] : 0};
}

void LawSolve::Give(const Disc& disc, const Eigen::Vector2d& impulse) {
  impulses_[disc.row] = impulse.x();
  if (disc.is_pair) impulses_[disc.row + 1] = impulse.y();
}

void LawSolve::Foretell() {
  for (const uint32_t row : boxes_) {
    const auto& [lower, upper, bounded_by] = rows_[row].bounds;
    const bool is_between = impulses_[row] != 0 && lower < impulses_[row] && impulses_[row] < upper;
    if (!is_between) JudgeBox(row, -rows_[row].wanted);
  }
  for (Disc& disc : discs_) {
    const bool presses = laws_[disc.normal] == Law::kHolds && disc.friction > 0;
    const double most = presses ? disc.friction * impulses_[disc.normal] : 0;
    const Eigen::Vector2d impulse = Of(disc, impulses_);
    const double size = impulse.norm();
    disc.law = !presses ? Law::kAtBound : size == 0 || size < kHolding * most ? Law::kHolds : Law::kSlips;
    if (disc.law == Law::kAtBound) Give(disc, Eigen::Vector2d::Zero());
    if (disc.law != Law::kSlips) continue;
    disc.along = impulse / size;
    disc.softness = 0;
    Give(disc, most * disc.along);
  }
}

// Each law says that an impulse is the nearest one that may be to itself less a part of its rate.
bool LawSolve::Judge() {
  bool are_new = false;
  most_.clear();
  for (const Disc& disc : discs_) {
    most_.push_back(disc.friction * (impulses_[disc.normal] - rates_[disc.normal] / scales_[disc.normal]));
  }
  for (const uint32_t row : boxes_) are_new |= JudgeBox(row, rates_[row]);
  for (size_t i = 0; i < discs_.size(); ++i) are_new |= JudgeDisc(discs_[i], Of(discs_[i], rates_), most_[i]);
  return are_new;
}

bool LawSolve::JudgeBox(uint32_t row, double rate) {
  const auto& [lower, upper, bounded_by] = rows_[row].bounds;
  const double free = impulses_[row] - rate / scales_[row], bounded = std::clamp(free, lower, upper);
  const Law before = std::exchange(laws_[row], free == bounded ? Law::kHolds : Law::kAtBound);
  if (free != bounded) impulses_[row] = bounded;
  return laws_[row] != before;
}

// What slips turns the more easily the faster it slips: across its way the law is that of a row which is so soft.
bool LawSolve::JudgeDisc(Disc& disc, const Eigen::Vector2d& rate, double most) {
  const double scale = scales_[disc.row];
  const Eigen::Vector2d free = Of(disc, impulses_) - rate / scale;
  const double size = free.norm();
  const bool presses = laws_[disc.normal] == Law::kHolds && most > 0;
  const Law before = std::exchange(disc.law, !presses ? Law::kAtBound : size <= most ? Law::kHolds : Law::kSlips);
  if (disc.law == Law::kAtBound) Give(disc, Eigen::Vector2d::Zero());
  if (disc.law != Law::kSlips) return disc.law != before;
  disc.along = free / size;
  disc.softness = scale * std::min(size / most - 1, kSoftest);
  Give(disc, disc.friction * std::max(impulses_[disc.normal], 0.0) * disc.along);
  return true;
}

void LawSolve::FindRates() {
  for (const Body& body : bodies_) {
    if (body.count == 0) continue;
    MotionChange& moved = moved_[sides_[body.first].part->body];
    moved.linear.setZero();
    moved.angular.setZero();
    for (const Side& side : SidesOf(body)) {
      const double impulse = impulses_[elimination_.order()[side.place]];
      if (impulse == 0) continue;
      moved.linear += impulse * side.part->linear_gain;
      moved.angular += impulse * side.part->angular_gain;
    }
  }
  for (uint32_t row = 0; row < rows_.size(); ++row) rates_[row] = RateOf(row);
}

double LawSolve::RateOf(uint32_t row) const {
  const DirectRow& of = rows_[row];
  double rate = of.softness * impulses_[row] - of.wanted;
  for (const DirectRow::Part* part : {&of.a, &of.b}) {
    const MotionChange& moved = moved_[part->body];
    if (moved.inverse_mass > 0) rate += part->linear.dot(moved.linear) + part->angular.dot(moved.angular);
  }
  return rate;
}

double LawSolve::Lacking() const {
  double worst = 0;
  for (uint32_t row = 0; row < rows_.size(); ++row) {
    if (rows_[row].is_free()) worst = std::max(worst, std::abs(rates_[row]));
  }
  for (const uint32_t row : boxes_) {
    const auto& [lower, upper, bounded_by] = rows_[row].bounds;
    const double free = impulses_[row] - rates_[row] / scales_[row];
    worst = std::max(worst, scales_[row] * std::abs(impulses_[row] - std::clamp(free, lower, upper)));
  }
  for (const Disc& disc : discs_) worst = std::max(worst, OffOf(disc));
  return worst;
}

double LawSolve::OffOf(const Disc& disc) const {
  const double scale = scales_[disc.row], most = disc.friction * std::max(impulses_[disc.normal], 0.0);
  const Eigen::Vector2d impulse = Of(disc, impulses_);
  const double off = (impulse - NearestInDisc(impulse - Of(disc, rates_) / scale, most)).norm();
  return off > kAgrees * most ? scale * off : 0;
}

bool LawSolve::IsSettled(double lacking, double before) const {
  if (lacking <= kAgreed && lacking > before / 2) return true;
  double strongest = 0;
  for (uint32_t row = 0; row < rows_.size(); ++row) {
    strongest = std::max(strongest, scales_[row] * std::abs(impulses_[row]));
  }
  return lacking <= std::max(kSettled, kRounding * strongest);
}

// If what it starts from is no better than no impulses at all, rates say nothing.
void LawSolve::BeginLaws() {
  FindRates();
  double wanted = 0;
  for (const DirectRow& row : rows_) wanted = std::max(wanted, std::abs(row.wanted));
  if (Lacking() < wanted) {
    Judge();
  } else {
    Foretell();
  }
}

bool LawSolve::Run(Eigen::VectorXd& impulses) {
  impulses_ = impulses;
  rates_.resize(impulses.size());
  BeginLaws();
  nearest_ = impulses_;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  double nearest = kFar, before = kFar;
  bool are_new = true;
  for (int i = 0, stuck = 0; i < kIterationsMax; ++i) {
    if (are_new) FindRates();
    if (!Improve(are_new)) break;
    FindRates();
    if (!rates_.allFinite()) break;
    const double lacking = Lacking();
    if (lacking < nearest) {
      nearest = lacking;
      nearest_ = impulses_;
    }
    if (IsSettled(lacking, before)) break;
    if (lacking < before / 2) {
      before = lacking;
      stuck = 0;
    } else if (++stuck == kPatience) {
      impulses_ = nearest_;
      FindRates();
      for (int sweep = 0; sweep < kSweeps; ++sweep) Sweep();
      FindRates();
      before = kFar;
      stuck = 0;
    }
    are_new = Judge();
  }
  if (nearest > kNearEnough) return false;
  impulses = nearest_;
  return true;
}

bool LawSolve::Improve(bool are_new) {
  if (are_new) {
    Choose();
    Assemble();
    if (!elimination_.Factor()) return false;
  }
  const std::span<const uint32_t> numbers = elimination_.numbers();
  Eigen::VectorXd changes(elimination_.size());
  for (uint32_t row = 0; row < rows_.size(); ++row) {
    const uint32_t number = numbers[place_[row]];
    if (number != RowElimination::kNone) changes[number] = -rates_[row];
  }
  for (const Disc& disc : discs_) {
    if (disc.law != Law::kSlips || !disc.is_pair) continue;
    const Eigen::Vector2d rate = Of(disc, rates_);
    changes[numbers[place_[disc.row + 1]]] = disc.along.y() * rate.x() - disc.along.x() * rate.y();
  }
  elimination_.Solve(changes);
  if (!changes.allFinite()) return false;
  TakeChanges(changes);
  return true;
}

// Of what slips, the second row stands for what is across its way, and the first one goes with what presses.
void LawSolve::Choose() {
  is_chosen_.resize(rows_.size());
  for (uint32_t row = 0; row < rows_.size(); ++row) is_chosen_[place_[row]] = laws_[row] == Law::kHolds;
  for (const Disc& disc : discs_) {
    is_chosen_[place_[disc.row]] = disc.law == Law::kHolds;
    if (disc.is_pair) is_chosen_[place_[disc.row + 1]] = disc.law != Law::kAtBound;
  }
  elimination_.Choose(is_chosen_);
}

void LawSolve::Assemble() {
  turned_ = answers_;
  for (const Disc& disc : discs_) {
    if (disc.law == Law::kSlips) TurnAnswers(disc);
  }
  const std::span<const uint32_t> numbers = elimination_.numbers();
  for (const Body& body : bodies_) {
    const std::span<const Side> sides = SidesOf(body);
    const double* answers = turned_.data() + body.first_answer;
    for (const Side& to : sides) {
      const uint32_t row = numbers[to.place];
      for (uint32_t j = 0; j < body.count && row != RowElimination::kNone; ++j) {
        const uint32_t column = numbers[sides[j].place];
        if (column != RowElimination::kNone) elimination_.At(row, column) += answers[j];
      }
      answers += body.count;
    }
  }
  for (uint32_t row = 0; row < rows_.size(); ++row) {
    const uint32_t number = numbers[place_[row]];
    if (number == RowElimination::kNone) continue;
    elimination_.At(number, number) += rows_[row].softness + kGive * scales_[row];
  }
  for (const Disc& disc : discs_) {
    if (disc.law != Law::kSlips || !disc.is_pair) continue;
    const uint32_t across = numbers[place_[disc.row + 1]];
    elimination_.At(across, across) += disc.softness;
  }
}

// Turns the two rows of what slips to its way and across it, and lets what presses push along that, too.
void LawSolve::TurnAnswers(const Disc& disc) {
  const double x = disc.along.x(), y = disc.along.y();
  const DirectRow& row = rows_[disc.row];
  for (const DirectRow::Part* part : {&row.a, &row.b}) {
    if (!IsMoved(*part)) continue;
    const Body& body = bodies_[part->body];
    const bool of_b = part == &row.b;
    const uint32_t count = body.count, first = at_[disc.row][of_b], normal = at_[disc.normal][of_b];
    double* const square = turned_.data() + body.first_answer;
    const auto turn = [&](double& one, double& two) { one = std::exchange(two, x * two - y * one) * y + x * one; };
    for (uint32_t i = 0; disc.is_pair && i < count; ++i)
      turn(square[first * count + i], square[(first + 1) * count + i]);
    for (uint32_t i = 0; i < count; ++i) {
      double* const of_row = square + i * count;
      if (disc.is_pair) turn(of_row[first], of_row[first + 1]);
      of_row[normal] += disc.friction * (disc.is_pair ? 1 : x) * of_row[first];
    }
  }
}

void LawSolve::TakeChanges(const Eigen::VectorXd& changes) {
  const std::span<const uint32_t> numbers = elimination_.numbers();
  const auto change_of = [&](uint32_t row) {
    const uint32_t number = numbers[place_[row]];
    return number == RowElimination::kNone ? 0 : changes[number];
  };
  for (uint32_t row = 0; row < rows_.size(); ++row) {
    if (rows_[row].bounds.bounded_by == BoundedSolver::kFree) impulses_[row] += change_of(row);
  }
  for (const Disc& disc : discs_) {
    const Eigen::Vector2d change(change_of(disc.row), disc.is_pair ? change_of(disc.row + 1) : 0);
    if (disc.law == Law::kHolds) Give(disc, Of(disc, impulses_) + change);
    if (disc.law != Law::kSlips) continue;
    const Eigen::Vector2d across(-disc.along.y(), disc.along.x());
    Give(disc, disc.friction * impulses_[disc.normal] * disc.along + change.y() * across);
  }
}

void LawSolve::Sweep() {
  const auto wanted = [&](uint32_t row, double scale) { return impulses_[row] - RateOf(row) / scale; };
  for (uint32_t row = 0; row < rows_.size(); ++row) {
    const auto& [lower, upper, bounded_by] = rows_[row].bounds;
    if (bounded_by == BoundedSolver::kFree) BringTo(row, std::clamp(wanted(row, scales_[row]), lower, upper));
  }
  for (const Disc& disc : discs_) {
    const double scale = disc.is_pair ? std::max(scales_[disc.row], scales_[disc.row + 1]) : scales_[disc.row];
    const Eigen::Vector2d free(wanted(disc.row, scale), disc.is_pair ? wanted(disc.row + 1, scale) : 0);
    const Eigen::Vector2d impulse = NearestInDisc(free, disc.friction * std::max(impulses_[disc.normal], 0.0));
    BringTo(disc.row, impulse.x());
    if (disc.is_pair) BringTo(disc.row + 1, impulse.y());
  }
}

void LawSolve::BringTo(uint32_t row, double impulse) {
  const double change = impulse - std::exchange(impulses_[row], impulse);
  for (const DirectRow::Part* part : {&rows_[row].a, &rows_[row].b}) {
    MotionChange& moved = moved_[part->body];
    if (!(moved.inverse_mass > 0)) continue;
    moved.linear += change * part->linear_gain;
    moved.angular += change * part->angular_gain;
  }
}

}  // namespace genphys

#include "pairs/broad_phase.h"

#include <algorithm>
#include <utility>

namespace genphys {
namespace {

// A moving geometry's neighbourhood is wider than its box, so that what creeps, trembles or rolls stays within it.
constexpr double kMargin = 0.05;  // of the largest side

Bounds Widened(const Bounds& box, const Vector3& ahead) {
  const Vector3 margin = Vector3::Constant(kMargin * (box.max - box.min).maxCoeff());
  return {box.min - margin + ahead.cwiseMin(0), box.max + margin + ahead.cwiseMax(0)};
}

}  // namespace

void BroadPhase::Add(GeometryRow row, const Bounds& box, bool moving, uint32_t group) {
  Proxy& proxy = NewProxy(row);
  proxy.box = moving ? box.Shifted(-drift_) : box;
  proxy.group = group;
  Enter(row, moving);
}

void BroadPhase::AddHalfSpace(GeometryRow row, const HalfSpace& half_space) {
  Proxy& proxy = NewProxy(row);
  proxy.kind = Kind::kPlane;
  proxy.index = static_cast<uint32_t>(planes_.size());
  planes_.push_back({row, half_space});
  MarkFresh(row);
}

void BroadPhase::Remove(GeometryRow row) {
  Leave(row);
  MarkFresh(row);
  proxies_[Index(row)].kind = Kind::kAbsent;
}

// How dense the others are is not known, so it reaches out by and by. What goes little within a step may have
// neighbours that stay, and reaches no farther than past some of them; what goes far would have all that are around.
uint8_t BroadPhase::NextAhead(const Proxy& proxy, bool goes_far) {
  if (!proxy.has_met) return std::clamp<uint8_t>(2 * proxy.ahead, 1, kAheadMost);
  return goes_far ? proxy.ahead / 2 : kAhead;
}

void BroadPhase::Move(GeometryRow row, const Bounds& given, Course course) {
  Proxy& proxy = proxies_[Index(row)];
  const Bounds box = proxy.kind == Kind::kMoving ? given.Shifted(-drift_) : given;
  const Bounds before = std::exchange(proxy.box, box);
  if (proxy.neighbourhood.Contains(box)) return;
  if (proxy.kind != Kind::kMoving) {
    proxy.neighbourhood = box;
    resting_.Move(proxy.leaf, box);
    MarkFresh(row);
    return;
  }
  const Vector3 displacement = 0.5 * (box.min + box.max - before.min - before.max);
  const Vector3 size = box.max - box.min;
  // So was what jumps further than its own size.
  if (course == Course::kPut || displacement.squaredNorm() > size.squaredNorm()) return Narrow(row, proxy);
  // One step is in what is reserved.
  const Vector3 own = course == Course::kReserved ? Vector3(size - displacement.cwiseAbs()) : size;
  proxy.ahead = NextAhead(proxy, displacement.norm() > kFar * own.maxCoeff());
  proxy.has_met = false;
  proxy.neighbourhood = Widened(box, proxy.ahead * displacement);
  // With where it comes from, for whoever asks what it met on its way.
  if (course == Course::kWent) proxy.neighbourhood = proxy.neighbourhood.Union(Widened(before, Vector3::Zero()));
  moving_.Move(proxy.leaf, proxy.neighbourhood);
  MarkFresh(row);
}

// Nothing says where it goes next.
void BroadPhase::Narrow(GeometryRow row, Proxy& proxy) {
  proxy.neighbourhood = Widened(proxy.box, Vector3::Zero());
  proxy.has_met = false;
  proxy.ahead = 1;
  moving_.Move(proxy.leaf, proxy.neighbourhood);
  MarkFresh(row);
}

void BroadPhase::MoveHalfSpace(GeometryRow row, const HalfSpace& half_space) {
  planes_[proxies_[Index(row)].index].half_space = half_space;
  MarkFresh(row);
}

void BroadPhase::SetMoving(GeometryRow row, bool moving) {
  const Kind kind = proxies_[Index(row)].kind;
  if (kind == Kind::kPlane || (kind == Kind::kMoving) == moving) return;
  Leave(row);
  Bounds& box = proxies_[Index(row)].box;
  box = box.Shifted(moving ? Vector3(-drift_) : drift_);
  Enter(row, moving);
}

void BroadPhase::BeginDrift(const Vector3& way) {
  way_ = way;
  has_drifted_ = true;
}

void BroadPhase::EndDrift() {
  drift_ += way_;
  way_.setZero();
}

void BroadPhase::Settle() {
  way_.setZero();
  // Who has not drifted yet has been looked for where it is and where it would have gone.
  if (!std::exchange(has_drifted_, false) || drift_.isZero(0)) return;
  for (const GeometryRow row : moving_rows_) {
    Proxy& proxy = proxies_[Index(row)];
    proxy.box = proxy.box.Shifted(drift_);
    proxy.neighbourhood = proxy.neighbourhood.Shifted(drift_);
    MarkFresh(row);
  }
  moving_.Shift(drift_);
  drift_.setZero();
}

bool BroadPhase::IsFreeOfResting(const Bounds& box) const {
  if (!resting_.empty() && resting_.bounds().Overlaps(box)) return false;
  return std::ranges::none_of(planes_, [&](const Plane& plane) { return Reaches(box, plane.half_space); });
}

void BroadPhase::ForgetFresh() {
  for (GeometryRow row : fresh_rows_) proxies_[Index(row)].is_fresh = false;
  fresh_rows_.clear();
}

void BroadPhase::MarkFresh(GeometryRow row) {
  bool& is_fresh = proxies_[Index(row)].is_fresh;
  if (!is_fresh) fresh_rows_.push_back(row);
  is_fresh = true;
}

bool BroadPhase::MayTouch(GeometryRow a, GeometryRow b) const {
  const Proxy& first = proxies_[Index(a)];
  const Proxy& second = proxies_[Index(b)];
  if (first.kind == Kind::kPlane) return Reaches(BoxOf(second), planes_[first.index].half_space);
  if (second.kind == Kind::kPlane) return Reaches(BoxOf(first), planes_[second.index].half_space);
  if (first.kind == second.kind) return first.box.Overlaps(second.box);
  return BoxOf(first).Overlaps(BoxOf(second));
}

bool BroadPhase::MayTouch(GeometryRow row, const Bounds& box) const {
  const Proxy& proxy = proxies_[Index(row)];
  return proxy.kind == Kind::kPlane ? Reaches(box, planes_[proxy.index].half_space) : BoxOf(proxy).Overlaps(box);
}

bool BroadPhase::Surrounds(GeometryRow row, const Bounds& box) const {
  const Proxy& proxy = proxies_[Index(row)];
  return !any_fresh() && proxy.kind == Kind::kMoving && !has_drifted_ && proxy.neighbourhood.Contains(box);
}

bool BroadPhase::MayReach(GeometryRow row, const Bounds& box) const {
  const Proxy& proxy = proxies_[Index(row)];
  if (proxy.kind == Kind::kPlane) return Reaches(box, planes_[proxy.index].half_space);
  return NeighbourhoodOf(proxy).Overlaps(box);
}

bool BroadPhase::Reaches(const Bounds& box, const HalfSpace& half_space) {
  const Vector3& n = half_space.normal;
  const double lowest = n.x() * (n.x() > 0 ? box.min.x() : box.max.x()) +
                        n.y() * (n.y() > 0 ? box.min.y() : box.max.y()) +
                        n.z() * (n.z() > 0 ? box.min.z() : box.max.z());
  return lowest <= half_space.offset;
}

BroadPhase::Proxy& BroadPhase::NewProxy(GeometryRow row) {
  if (Index(row) >= proxies_.size()) proxies_.resize(Index(row) + 1);
  return proxies_[Index(row)];
}

void BroadPhase::Enter(GeometryRow row, bool moving) {
  Proxy& proxy = proxies_[Index(row)];
  proxy.kind = moving ? Kind::kMoving : Kind::kResting;
  MarkFresh(row);
  if (!moving) {
    Enter(resting_, proxy.box, row, proxy);
    return;
  }
  Enter(moving_, Widened(proxy.box, Vector3::Zero()), row, proxy);
  proxy.index = static_cast<uint32_t>(moving_rows_.size());
  moving_rows_.push_back(row);
}

void BroadPhase::Enter(BoundsTree& tree, const Bounds& neighbourhood, GeometryRow row, Proxy& proxy) {
  proxy.neighbourhood = neighbourhood;
  proxy.leaf = tree.Insert(neighbourhood, row, proxy.group);
}

void BroadPhase::Leave(GeometryRow row) {
  const Proxy& proxy = proxies_[Index(row)];
  if (proxy.kind == Kind::kPlane) {
    planes_[proxy.index] = planes_.back();
    proxies_[Index(planes_[proxy.index].row)].index = proxy.index;
    planes_.pop_back();
  } else if (proxy.kind == Kind::kMoving) {
    moving_rows_[proxy.index] = moving_rows_.back();
    proxies_[Index(moving_rows_[proxy.index])].index = proxy.index;
    moving_rows_.pop_back();
    moving_.Remove(proxy.leaf);
  } else {
    resting_.Remove(proxy.leaf);
  }
}

}  // namespace genphys

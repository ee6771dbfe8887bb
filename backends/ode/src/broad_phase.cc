#include "broad_phase.h"

namespace genphys::ode_backend {
namespace {

// The tree holds each box a little widened, so that what creeps, trembles or rolls need not be inserted anew each time.
constexpr double kMargin = 0.05;  // of the largest side
// How far ahead a leaf reaches along its last displacement.
constexpr double kAhead = 3;

Aabb Widened(const Aabb& box, const Vector3& displacement) {
  const Vector3 margin = Vector3::Constant(kMargin * (box.high - box.low).maxCoeff());
  const Vector3 ahead = kAhead * displacement;
  return {box.low - margin + ahead.cwiseMin(0), box.high + margin + ahead.cwiseMax(0)};
}

}  // namespace

void BroadPhase::Add(GeometryRow row, const Aabb& box, bool moving) {
  NewProxy(row).box = box;
  Enter(row, moving);
}

void BroadPhase::AddHalfSpace(GeometryRow row, const HalfSpace& half_space) {
  Proxy& proxy = NewProxy(row);
  proxy.kind = Kind::kPlane;
  proxy.index = static_cast<uint32_t>(planes_.size());
  planes_.push_back({row, half_space});
}

void BroadPhase::Remove(GeometryRow row) {
  Leave(row);
  proxies_[Index(row)] = Proxy{};
}

void BroadPhase::Move(GeometryRow row, const Aabb& box) {
  Proxy& proxy = proxies_[Index(row)];
  const Vector3 displacement = 0.5 * (box.low + box.high - proxy.box.low - proxy.box.high);
  proxy.box = box;
  AabbTree& tree = proxy.kind == Kind::kMoving ? moving_ : resting_;
  if (tree.box(proxy.leaf).Contains(box)) return;
  tree.Remove(proxy.leaf);
  // What jumps further than its own size was put there, and says nothing of where it goes next.
  const bool jumped = displacement.squaredNorm() > (box.high - box.low).squaredNorm();
  proxy.leaf = tree.Insert(Widened(box, jumped ? Vector3::Zero() : displacement), row);
}

void BroadPhase::SetMoving(GeometryRow row, bool moving) {
  const Kind kind = proxies_[Index(row)].kind;
  if (kind == Kind::kPlane || (kind == Kind::kMoving) == moving) return;
  Leave(row);
  Enter(row, moving);
}

bool BroadPhase::Reaches(const Aabb& box, const HalfSpace& half_space) {
  const Vector3& n = half_space.normal;
  const double lowest = n.x() * (n.x() > 0 ? box.low.x() : box.high.x()) +
                        n.y() * (n.y() > 0 ? box.low.y() : box.high.y()) +
                        n.z() * (n.z() > 0 ? box.low.z() : box.high.z());
  return lowest <= half_space.offset;
}

BroadPhase::Proxy& BroadPhase::NewProxy(GeometryRow row) {
  if (Index(row) >= proxies_.size()) proxies_.resize(Index(row) + 1);
  return proxies_[Index(row)];
}

void BroadPhase::Enter(GeometryRow row, bool moving) {
  Proxy& proxy = proxies_[Index(row)];
  proxy.kind = moving ? Kind::kMoving : Kind::kResting;
  proxy.leaf = (moving ? moving_ : resting_).Insert(Widened(proxy.box, Vector3::Zero()), row);
  if (moving) {
    proxy.index = static_cast<uint32_t>(moving_rows_.size());
    moving_rows_.push_back(row);
  }
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

}  // namespace genphys::ode_backend

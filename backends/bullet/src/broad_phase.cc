#include "broad_phase.h"

#include <algorithm>
#include <tuple>

namespace genphys::bullet_backend {
namespace {

// By how much of its size, and at most by how many metres, a leaf is larger than what it holds: a body that moves less
// stays where it is in the tree.
constexpr double kLooseness = 0.1;
constexpr double kLoosenessMax = 0.05;

btDbvtVolume VolumeOf(const Bounds& bounds) { return btDbvtVolume::FromMM(ToBullet(bounds.min), ToBullet(bounds.max)); }

double MarginOf(const Bounds& bounds) {
  return std::min(kLoosenessMax, kLooseness * (bounds.max - bounds.min).maxCoeff());
}

PlacedGeometry& GeometryOf(const btDbvtNode* leaf) { return *static_cast<PlacedGeometry*>(leaf->data); }

class PairCollector final : public btDbvt::ICollide {
 public:
  PairCollector(const PairRule& rule, std::vector<CandidatePair>& pairs) : rule_(rule), pairs_(pairs) {}

  using btDbvt::ICollide::Process;
  void Process(const btDbvtNode* x, const btDbvtNode* y) override {
    PlacedGeometry& a = GeometryOf(x);
    PlacedGeometry& b = GeometryOf(y);
    if (a.bounds.Overlaps(b.bounds)) Add(a, b);
  }

  void AddNearPlane(const btDbvtNode* node, PlacedGeometry& plane, const Vector3& normal, double level) {
    const Vector3 middle = FromBullet(node->volume.Center()), extent = FromBullet(node->volume.Extents());
    if (normal.dot(middle) - normal.cwiseAbs().dot(extent) > level) return;
    if (node->isinternal()) {
      AddNearPlane(node->childs[0], plane, normal, level);
      AddNearPlane(node->childs[1], plane, normal, level);
      return;
    }
    PlacedGeometry& geometry = GeometryOf(node);
    const Vector3 corner = (normal.array() > 0).select(geometry.bounds.min, geometry.bounds.max);
    if (normal.dot(corner) <= level) Add(plane, geometry);
  }

 private:
  void Add(PlacedGeometry& x, PlacedGeometry& y) {
    const PairRule::Verdict verdict = rule_.Decide(x.row, y.row);
    if (verdict == PairRule::Verdict::kIgnore) return;
    const bool in_order = x.body->id < y.body->id;
    pairs_.push_back({in_order ? &x : &y, in_order ? &y : &x, verdict == PairRule::Verdict::kSensor});
  }

  const PairRule& rule_;
  std::vector<CandidatePair>& pairs_;
};

class LeafCollector final : public btDbvt::ICollide {
 public:
  explicit LeafCollector(std::vector<const PlacedGeometry*>& found) : found_(found) {}

  using btDbvt::ICollide::Process;
  void Process(const btDbvtNode* leaf) override { found_.push_back(&GeometryOf(leaf)); }

 private:
  std::vector<const PlacedGeometry*>& found_;
};

}  // namespace

bool ComesBefore(const CandidatePair& x, const CandidatePair& y) {
  return std::tie(x.a->body->id, x.b->body->id, x.a->id, x.b->id) <
         std::tie(y.a->body->id, y.b->body->id, y.a->id, y.b->id);
}

void BroadPhase::Add(Body& body) {
  for (PlacedGeometry& geometry : body.geometries) {
    if (geometry.is_plane()) {
      planes_.push_back(&geometry);
      continue;
    }
    geometry.tree = body.is_moving() ? &moving_ : &resting_;
    btDbvtVolume volume = VolumeOf(geometry.bounds);
    geometry.leaf = geometry.tree->insert(volume, &geometry);
  }
}

void BroadPhase::Remove(Body& body) {
  for (PlacedGeometry& geometry : body.geometries) {
    if (geometry.is_plane()) {
      std::erase(planes_, &geometry);
      continue;
    }
    geometry.tree->remove(geometry.leaf);
    geometry.leaf = nullptr;
  }
}

void BroadPhase::Refile(Body& body) {
  btDbvt* const tree = body.is_moving() ? &moving_ : &resting_;
  for (PlacedGeometry& geometry : body.geometries) {
    if (geometry.is_plane() || geometry.tree == tree) continue;
    const btDbvtVolume volume = geometry.leaf->volume;
    geometry.tree->remove(geometry.leaf);
    geometry.tree = tree;
    geometry.leaf = tree->insert(volume, &geometry);
  }
}

void BroadPhase::Update(Body& body) {
  for (PlacedGeometry& geometry : body.geometries) {
    if (geometry.is_plane()) continue;
    btDbvtVolume volume = VolumeOf(geometry.bounds);
    geometry.tree->update(geometry.leaf, volume, MarginOf(geometry.bounds));
  }
}

void BroadPhase::FindPairs(const PairRule& rule, std::vector<CandidatePair>& pairs) {
  pairs.clear();
  if (moving_.empty()) return;
  moving_.optimizeIncremental(1);
  PairCollector collector(rule, pairs);
  moving_.collideTTpersistentStack(moving_.m_root, moving_.m_root, collector);
  moving_.collideTTpersistentStack(moving_.m_root, resting_.m_root, collector);
  for (PlacedGeometry* plane : planes_) {
    const Plane& described = std::get<Plane>(plane->collision.shape);
    const Vector3 normal = plane->placement.rotation * described.normal;
    // Bounds are widened by half of the contact gap, and a plane has none that could be.
    const double level = normal.dot(plane->placement.position) + described.offset + kContactGap;
    collector.AddNearPlane(moving_.m_root, *plane, normal, level);
  }
  std::sort(pairs.begin(), pairs.end(), ComesBefore);
}

void BroadPhase::FindOnSegment(const Vector3& start, const Vector3& end, std::vector<const PlacedGeometry*>& found) {
  found.assign(planes_.begin(), planes_.end());
  const Vector3 step = end - start;
  const double length = step.norm();
  if (!(length > 0)) return;
  btVector3 inverse;
  unsigned signs[3];
  for (int i = 0; i < 3; ++i) {
    // Bullet's own stand-in for the inverse of zero.
    inverse[i] = step[i] == 0 ? BT_LARGE_FLOAT : length / step[i];
    signs[i] = inverse[i] < 0;
  }
  LeafCollector collector(found);
  const btVector3 none(0, 0, 0);
  for (const btDbvt* tree : {&moving_, &resting_}) {
    tree->rayTestInternal(tree->m_root, ToBullet(start), ToBullet(end), inverse, signs, length, none, none, ray_stack_,
                          collector);
  }
}

void BroadPhase::FindInBounds(const Bounds& bounds, std::vector<const PlacedGeometry*>& found) {
  found.assign(planes_.begin(), planes_.end());
  const btDbvtVolume volume = VolumeOf(bounds);
  LeafCollector collector(found);
  for (btDbvt* tree : {&moving_, &resting_}) tree->collideTV(tree->m_root, volume, collector);
}

}  // namespace genphys::bullet_backend

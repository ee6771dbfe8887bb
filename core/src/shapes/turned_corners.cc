#include "shapes/turned_corners.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <span>

namespace genphys {

using Matrix2 = Eigen::Matrix2d;

namespace {

constexpr int kTurnsMax = 8;
// rad: a turn after which the next one is lost in rounding, and one of which nothing good comes.
constexpr double kLastTurn = 1e-7;
constexpr double kFar = 0.7;
// Of how far a corner is from the centre of its solid: one that would be taken farther along its piece spans a face.
constexpr double kFace = 0.5;
// Of the distance: so far beside the normal the closest point may be found to lie.
constexpr double kBeside = 1e-7;
// Of the smaller size: so much farther something else may seem to reach than what was turned.
constexpr double kRounding = 1e-13;
// So much less than nothing rounding makes of a weight.
constexpr double kNoWeight = -1e-10;

// Where the difference of two pieces of surfaces reaches farthest along the normal from a to b.
struct Piece {
  Corner corner;
  Matrix2 slope;  // m/rad: how that moves across the normal as it turns
  double weight = 0;
};

// Newton's method for the normal along which the closest point lies that pieces make up, all of which reach equally far
// along it.
class Turner {
 public:
  Turner(const Solid& a, const Solid& b, const CoreQuery& query, const Nearest& nearest) : a_(a), b_(b), query_(query) {
    Face(nearest.normal());
    const std::span<const Corner> corners = std::span(nearest.simplex.corners).first(nearest.simplex.count);
    const auto bends = [&](const Solid& solid, const Vector3& direction, Vector3 Corner::*side, const Vector3& shift) {
      return solid.is_round() && std::ranges::none_of(corners, [&](const Corner& corner) {
               const Vector3 here = query.Unshrunk(solid, corner.*side - shift);
               const Vector3 there = solid.Follow(here, direction, across_).point;
               return (there - here).squaredNorm() > kFace * kFace * (here - solid.center()).squaredNorm();
             });
    };
    bends_a_ = bends(a, normal_, &Corner::on_a, Vector3::Zero());
    bends_b_ = bends(b, -normal_, &Corner::on_b, query.shift);
    for (size_t i = 0; i < corners.size(); ++i) Add(Follow(corners[i], nearest.weights[i]));
  }

  bool bends() const { return bends_a_ || bends_b_; }

  bool Turn() {
    for (int i = 0; i < kTurnsMax; ++i) {
      const double angle = count_ == 1 ? TurnOnce<1>() : count_ == 2 ? TurnOnce<2>() : TurnOnce<3>();
      if (!(angle < kFar)) return false;
      for (Piece& piece : pieces()) piece = Follow(piece.corner, piece.weight);
      if (angle < kLastTurn) return AreAllNeeded();
    }
    return false;
  }

  // Whether what was found is nearer.
  bool Take(Nearest& nearest) const {
    const Vector3 point = Sum(&Corner::point);
    const double distance = -point.dot(normal_);
    if (!(distance > query_.nothing && distance < nearest.distance)) return false;
    if (!((point + distance * normal_).norm() <= kBeside * distance)) return false;
    for (size_t i = 0; i < count_; ++i) {
      nearest.simplex.corners[i] = pieces_[i].corner;
      nearest.weights[i] = pieces_[i].weight;
    }
    nearest.simplex.count = count_;
    nearest.closest = -distance * normal_;
    nearest.distance = distance;
    return true;
  }

  std::optional<LeastOverlap> Least() const {
    LeastOverlap least{.normal = normal_, .on_a = Sum(&Corner::on_a), .on_b = Sum(&Corner::on_b)};
    least.depth = normal_.dot(a_.Support(normal_) - b_.Support(-normal_));
    const bool is_farthest =
        least.depth - normal_.dot(least.on_a - least.on_b) <= kRounding * std::min(a_.size(), b_.size());
    return is_least_ && is_farthest ? std::optional(least) : std::nullopt;
  }

 private:
  void Face(const Vector3& normal) {
    normal_ = normal;
    across_.col(0) = normal.unitOrthogonal();
    across_.col(1) = normal.cross(across_.col(0));
  }

  std::span<Piece> pieces() { return std::span(pieces_).first(count_); }

  Vector3 Sum(Vector3 Corner::*side) const {
    Vector3 sum = Vector3::Zero();
    for (const Piece& piece : std::span(pieces_).first(count_)) sum += piece.weight * piece.corner.*side;
    return sum;
  }

  Piece Follow(const Corner& corner, double weight) const {
    Piece piece{.corner = corner, .slope = Matrix2::Zero(), .weight = weight};
    if (bends_a_) {
      const Farthest farthest = a_.Follow(query_.Unshrunk(a_, corner.on_a), normal_, across_);
      piece.corner.on_a = query_.Shrunk(a_, farthest.point);
      piece.slope += (1 - query_.shrink) * farthest.slope;
    }
    if (bends_b_) {
      const Farthest farthest = b_.Follow(query_.Unshrunk(b_, corner.on_b - query_.shift), -normal_, across_);
      piece.corner.on_b = query_.Shrunk(b_, farthest.point) + query_.shift;
      piece.slope += (1 - query_.shrink) * farthest.slope;
    }
    piece.corner.point = piece.corner.on_a - piece.corner.on_b;
    return piece;
  }

  void Add(const Piece& piece) {
    for (Piece& known : pieces()) {
      if (known.corner.on_a != piece.corner.on_a || known.corner.on_b != piece.corner.on_b) continue;
      known.weight += piece.weight;
      return;
    }
    pieces_[count_++] = piece;
  }

  // Returns the angle, rad.
  template <int kCount>
  double TurnOnce() {
    constexpr int kSize = kCount + 1;
    Matrix2 bend = Matrix2::Zero();
    for (const Piece& piece : pieces()) bend += piece.weight * piece.slope;
    const Vector3 point = Sum(&Corner::point);
    Eigen::Matrix<double, kSize, kSize> slope = Eigen::Matrix<double, kSize, kSize>::Zero();
    Eigen::Matrix<double, kSize, 1> lacking;
    slope.template topLeftCorner<2, 2>() = bend - point.dot(normal_) * Matrix2::Identity();
    lacking.template head<2>() = across_.transpose() * point;
    for (int i = 2; i < kSize; ++i) {
      const Vector3 edge = pieces_[static_cast<size_t>(i - 1)].corner.point - pieces_[0].corner.point;
      slope.template block<2, 1>(0, i) = across_.transpose() * edge;
      slope.template block<1, 2>(i, 0) = slope.template block<2, 1>(0, i).transpose();
      lacking[i] = edge.dot(normal_);
    }
    is_least_ = IsLeast<kCount>(slope);
    const Eigen::Matrix<double, kSize, 1> change = -(slope.inverse() * lacking);
    const Vector3 turn = across_ * change.template head<2>();
    Face((normal_ + turn).normalized());
    for (int i = 2; i < kSize; ++i) {
      pieces_[static_cast<size_t>(i - 1)].weight += change[i];
      pieces_[0].weight -= change[i];
    }
    return turn.norm();
  }

  // Whether the overlap is least where it changes little at first, as far as what is to reach equally far lets the
  // normal turn.
  template <int kCount>
  static bool IsLeast(const Eigen::Matrix<double, kCount + 1, kCount + 1>& slope) {
    if constexpr (kCount == 1) return slope(0, 0) > 0 && slope.determinant() > 0;
    if constexpr (kCount == 2) {
      const Eigen::Vector2d way(-slope(1, 2), slope(0, 2));
      return way.dot(slope.template topLeftCorner<2, 2>() * way) > 0;
    }
    return true;
  }

  bool AreAllNeeded() {
    double sum = 0;
    for (Piece& piece : pieces()) {
      if (!(piece.weight >= kNoWeight)) return false;
      sum += piece.weight = std::max(piece.weight, 0.0);
    }
    for (Piece& piece : pieces()) piece.weight /= sum;
    return true;
  }

  const Solid& a_;
  const Solid& b_;
  const CoreQuery& query_;
  Vector3 normal_;  // from a to b
  AxesAcross across_;
  std::array<Piece, 3> pieces_;
  size_t count_ = 0;
  bool bends_a_ = false;  // its corners move as the normal turns
  bool bends_b_ = false;
  bool is_least_ = false;
};

}  // namespace

bool TurnCorners(const Solid& a, const Solid& b, const CoreQuery& query, Nearest& nearest) {
  Turner turner(a, b, query, nearest);
  return turner.bends() && turner.Turn() && turner.Take(nearest);
}

std::optional<LeastOverlap> TurnToLeast(const Solid& a, const Solid& b, const CoreQuery& query,
                                        const Nearest& nearest) {
  Nearest there = nearest;
  for (Corner& corner : std::span(there.simplex.corners).first(there.simplex.count)) {
    corner.on_a = query.Unshrunk(a, corner.on_a);
    corner.on_b = query.Unshrunk(b, corner.on_b - query.shift);
    corner.point = corner.on_a - corner.on_b;
  }
  const CoreQuery unchanged;
  Turner turner(a, b, unchanged, there);
  return turner.Turn() ? turner.Least() : std::nullopt;
}

}  // namespace genphys

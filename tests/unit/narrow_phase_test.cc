#include "genphys/narrow_phase.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "core/src/shapes/separation.h"
#include "support/shapes.h"
#include "support/sweep.h"

namespace genphys {
namespace {

using namespace testing;

// m, of solids about a metre large: what is promised of depths.
constexpr double kExact = 1e-9;
constexpr double kGap = 1e-3;

Manifold Meet(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb, double gap = kGap) {
  Manifold manifold;
  FindContacts(a, pa, b, pb, gap, manifold);
  return manifold;
}

double DeepestOf(const Manifold& manifold) {
  double deepest = -1e9;
  for (int i = 0; i < manifold.count; ++i) deepest = std::max(deepest, manifold.points[static_cast<size_t>(i)].depth);
  return deepest;
}

Placement At(double x, double y, double z, const Quaternion& turn = Quaternion::Identity()) {
  return {{x, y, z}, turn.toRotationMatrix()};
}

class Randomly {
 public:
  Vector3 Direction() { return Vector3(normal_(random_), normal_(random_), normal_(random_)).normalized(); }
  Quaternion Turn() {
    return Quaternion(normal_(random_), normal_(random_), normal_(random_), normal_(random_)).normalized();
  }
  double Between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

 private:
  std::mt19937 random_{11};
  std::normal_distribution<double> normal_;
};

std::vector<Shape> Solids() {
  return {Sphere{0.5},
          Box{{0.5, 0.4, 0.3}},
          Capsule{0.3, 0.4},
          Cylinder{0.4, 0.5},
          Cone{0.5, 0.6},
          Ellipsoid{{0.6, 0.4, 0.5}},
          HullBox({0.4, 0.3, 0.5}),
          *MakeConvexHull({{0.5, 0, -0.4}, {-0.4, 0.4, -0.3}, {-0.4, -0.5, -0.3}, {0, 0.1, 0.6}})};
}

TEST(Separation, OfSolidsApartIsTheGreatestGapInAnyDirection) {
  Randomly random;
  for (const Shape& a : Solids()) {
    for (const Shape& b : Solids()) {
      for (int i = 0; i < 10; ++i) {
        const Vector3 place = random.Between(1.7, 3) * random.Direction();
        const Solid first(a, At(0, 0, 0, random.Turn())), second(b, {place, random.Turn().toRotationMatrix()});
        const Separation found = FindSeparation(first, second);
        EXPECT_NEAR(OverlapAlong(first, second, found.normal), found.depth, 1e-15);
        // No small turn finds a larger gap: the first derivative is nothing, to the accuracy promised of the depth.
        for (int k = 0; k < 20; ++k) {
          const Vector3 turned = (found.normal + random.Between(0, 0.1) * random.Direction()).normalized();
          ASSERT_GE(OverlapAlong(first, second, turned), found.depth - kExact) << a.index() << " " << b.index();
        }
      }
    }
  }
}

TEST(Separation, OfShallowOverlapsIsAMotionThatNoSmallTurnMakesLess) {
  Randomly random;
  for (const Shape& a : Solids()) {
    for (const Shape& b : Solids()) {
      for (int i = 0; i < 10; ++i) {
        const Matrix3 turn_a = random.Turn().toRotationMatrix(), turn_b = random.Turn().toRotationMatrix();
        const Vector3 far = 3 * random.Direction();
        const Solid first(a, {Vector3::Zero(), turn_a});
        const Separation apart = FindSeparation(first, Solid(b, {far, turn_b}));
        // Moved along the line between the closest points until it overlaps by a known depth.
        const double depth = std::pow(10, random.Between(-8, -2.5));
        const Solid second(b, {far - (depth - apart.depth) * apart.normal, turn_b});
        const Separation found = FindSeparation(first, second);
        ASSERT_LE(found.depth, depth + kExact) << a.index() << " " << b.index() << " " << i;
        for (int k = 0; k < 50; ++k) {
          const Vector3 turned = (found.normal + random.Between(0, 1e-2) * random.Direction()).normalized();
          ASSERT_GE(OverlapAlong(first, second, turned), found.depth - kExact)
              << a.index() << " " << b.index() << " " << depth;
        }
      }
    }
  }
}

// Of what is round everywhere, the points that lie farthest along the normal lie straight across from each other.
TEST(Separation, OfRoundSolidsIsExactToRounding) {
  Randomly random;
  const Shape a = Ellipsoid{{0.6, 0.4, 0.5}}, b = Ellipsoid{{0.3, 0.5, 0.35}};
  for (int i = 0; i < 200; ++i) {
    const Matrix3 turn_a = random.Turn().toRotationMatrix(), turn_b = random.Turn().toRotationMatrix();
    const Vector3 far = 3 * random.Direction();
    const Solid first(a, {Vector3::Zero(), turn_a});
    const Separation apart = FindSeparation(first, Solid(b, {far, turn_b}));
    const double depth = i % 2 == 0 ? std::pow(10, random.Between(-8, -2.5)) : -random.Between(0, 1);
    const Solid second(b, {far - (depth - apart.depth) * apart.normal, turn_b});
    const Separation found = FindSeparation(first, second);
    const Vector3 across = first.Support(found.normal) - second.Support(-found.normal);
    EXPECT_LE((across - found.depth * found.normal).norm(), 1e-13) << depth;
  }
}

TEST(NarrowPhase, OfHullsIsThatOfBoxes) {
  const Vector3 half(0.5, 0.4, 0.3);
  for (const double depth : {-5e-4, 0.0, 1e-6, 1e-3, 0.05}) {
    const Manifold manifold = Meet(Box{{2, 2, 0.5}}, At(0, 0, -0.5), HullBox(half), At(0.3, 0.2, 0.3 - depth));
    ASSERT_EQ(manifold.count, 4) << depth;
    for (int i = 0; i < 4; ++i) {
      const MeetingPoint& point = manifold.points[static_cast<size_t>(i)];
      EXPECT_NEAR(point.depth, depth, 1e-14);
      EXPECT_LT((point.normal - Vector3::UnitZ()).norm(), 1e-14);
      EXPECT_NEAR(std::abs(point.position.x() - 0.3), 0.5, 1e-14);
      EXPECT_NEAR(std::abs(point.position.y() - 0.2), 0.4, 1e-14);
      EXPECT_NEAR(point.position.z(), -depth / 2, 1e-14);
    }
  }
}

// By how much `b` has to move to leave `a`, in the best of the directions in which boxes can part.
double LeastOverlap(const Solid& a, const Matrix3& turn_a, const Solid& b, const Matrix3& turn_b) {
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Vector3& direction) {
    if (direction.norm() < 1e-6) return;
    for (const double side : {-1.0, 1.0}) {
      least = std::min(least, OverlapAlong(a, b, side * direction.normalized()));
    }
  };
  for (int i = 0; i < 3; ++i) {
    consider(turn_a.col(i));
    consider(turn_b.col(i));
    for (int j = 0; j < 3; ++j) consider(turn_a.col(i).cross(turn_b.col(j)));
  }
  return least;
}

// How far outside of a box, m.
double DistanceTo(const Shape& box, const Placement& placement, const Vector3& point) {
  const Vector3 local = placement.ToLocal(point), half = std::get<Box>(box).half_extents;
  return (local - local.cwiseMin(half).cwiseMax(-half)).norm();
}

Box RandomBox(Randomly& random) { return {{random.Between(0.1, 1), random.Between(0.1, 1), random.Between(0.1, 1)}}; }

// Two boxes that overlap by `depth` along the line between their closest points (or have a gap, where it is negative).
struct MetBoxes {
  Shape a, b;
  Placement at_a, at_b;

  MetBoxes(Randomly& random, double depth)
      : a(RandomBox(random)),
        b(RandomBox(random)),
        at_a(At(0, 0, 0, random.Turn())),
        at_b{4 * random.Direction(), random.Turn().toRotationMatrix()} {
    const Separation apart = FindSeparation({a, at_a}, {b, at_b});
    at_b.position -= (depth - apart.depth) * apart.normal;
  }
};

TEST(NarrowPhase, PartsBoxesTheShortWay) {
  Randomly random;
  for (int i = 0; i < 5000; ++i) {
    const double depth = std::pow(10, random.Between(-8, -1));
    const MetBoxes met(random, depth);
    const Manifold manifold = Meet(met.a, met.at_a, met.b, met.at_b);
    ASSERT_GT(manifold.count, 0) << i;
    const Solid a(met.a, met.at_a), b(met.b, met.at_b);
    const Vector3 normal = manifold.points[0].normal;
    const double least = LeastOverlap(a, met.at_a.rotation, b, met.at_b.rotation);
    const double taken = OverlapAlong(a, b, normal);
    // A twentieth more is what a face may take; beside a face that edges lie flat on, it takes more than the points are
    // deep.
    const double allowed = (least + 0.05 * kGap) / 0.95 + kExact;
    EXPECT_LE(std::min(taken, DeepestOf(manifold)), allowed) << i << " " << taken << " for " << least;
    for (int k = 0; k < manifold.count; ++k) {
      const MeetingPoint& point = manifold.points[static_cast<size_t>(k)];
      EXPECT_EQ(point.normal, normal);
      EXPECT_LE(point.depth, taken + kExact) << i;
      // Half-way between surfaces.
      const double outside = std::abs(point.depth) / 2 + 3 * kExact;
      EXPECT_LE(DistanceTo(met.a, met.at_a, point.position), outside) << i;
      EXPECT_LE(DistanceTo(met.b, met.at_b, point.position), outside) << i;
    }
  }
}

TEST(NarrowPhase, OfBoxesApartIsTheirDistance) {
  Randomly random;
  for (int i = 0; i < 5000; ++i) {
    const double gap = random.Between(1e-6, kGap);
    const MetBoxes met(random, -gap);
    const Manifold manifold = Meet(met.a, met.at_a, met.b, met.at_b);
    ASSERT_GT(manifold.count, 0) << i;
    EXPECT_NEAR(DeepestOf(manifold), -gap, 2 * 0.05 * kGap + kExact) << i;
    Placement away = met.at_b;
    away.position += 2 * kGap * FindSeparation({met.a, met.at_a}, {met.b, met.at_b}).normal;
    EXPECT_EQ(Meet(met.a, met.at_a, met.b, away).count, 0) << i;
  }
}

TEST(NarrowPhase, KeepsTheNormalOfBoxesThatLieFlat) {
  Randomly random;
  for (int i = 0; i < 500; ++i) {
    const Quaternion turn(Eigen::AngleAxisd(random.Between(0, 6), Vector3::UnitZ()));
    const Quaternion tilt(Eigen::AngleAxisd(random.Between(-1e-5, 1e-5), random.Direction()));
    const Manifold manifold =
        Meet(Box{{0.5, 0.5, 0.5}}, At(0, 0, 0), Box{{0.5, 0.5, 0.5}}, At(0.1, -0.2, 1 - 1e-6, tilt * turn));
    ASSERT_EQ(manifold.count, 4) << i;
    EXPECT_EQ(manifold.points[0].normal, Vector3::UnitZ()) << i;
  }
}

// Or a solve would not find what held it before.
TEST(NarrowPhase, KeepsThePointsOfADrumThatSways) {
  constexpr double kLean = 2e-4, kRadius = 0.5, kHalf = 0.2;  // rad, m
  const Shape drum = Cylinder{kRadius, kHalf};
  Randomly random;
  for (const Shape& below : {Shape(Plane{Vector3::UnitZ(), kHalf}), drum, Shape(Box{{0.4, 0.4, kHalf}})}) {
    const Quaternion turn(Eigen::AngleAxisd(0.7, Vector3::UnitZ()));
    const Manifold straight = Meet(drum, At(0, 0, 2 * kHalf, turn), below, At(0, 0, 0));
    ASSERT_EQ(straight.count, 4);
    for (int i = 0; i < 200; ++i) {
      const Vector3 about(random.Between(-1, 1), random.Between(-1, 1), 0);
      const Quaternion lean(Eigen::AngleAxisd(random.Between(0, kLean), about.normalized()));
      const Manifold leaning = Meet(drum, At(0, 0, 2 * kHalf, lean * turn), below, At(0, 0, 0));
      ASSERT_EQ(leaning.count, 4);
      for (size_t k = 0; k < 4; ++k) {
        double nearest = kRadius;
        for (size_t j = 0; j < 4; ++j) {
          nearest = std::min(nearest, (leaning.points[j].position - straight.points[k].position).norm());
        }
        EXPECT_LT(nearest, 2 * kLean) << i;
      }
    }
  }
}

TEST(NarrowPhase, FindsEdgesThatCross) {
  // Two cubes that stand on their edges, one across the other.
  const Quaternion on_edge(Eigen::AngleAxisd(M_PI / 4, Vector3::UnitX()));
  const Quaternion across(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitZ()));
  const double reach = 0.5 * std::sqrt(2);
  for (const Shape& cube : {Shape{HullBox({0.5, 0.5, 0.5})}, Shape{Box{{0.5, 0.5, 0.5}}}}) {
    for (const double depth : {1e-3, -1e-4}) {
      const Manifold manifold =
          Meet(cube, At(0, 0, 0, on_edge), cube, At(0.1, 0.2, 2 * reach - depth, across * on_edge));
      ASSERT_EQ(manifold.count, 1);
      EXPECT_NEAR(manifold.points[0].depth, depth, 1e-12);
      EXPECT_LT((manifold.points[0].normal - Vector3::UnitZ()).norm(), 1e-9);
      EXPECT_LT((manifold.points[0].position - Vector3(0.1, 0, reach - depth / 2)).norm(), 1e-9);
    }
  }
}

TEST(NarrowPhase, OfAPlaneIsWhatReachesBelowIt) {
  Randomly random;
  for (const Shape& shape : Solids()) {
    for (int i = 0; i < 20; ++i) {
      const Quaternion turn = random.Turn();
      const Solid solid(shape, At(0, 0, 0, turn));
      const double reach = solid.Reach(-Vector3::UnitZ());
      const Manifold manifold = Meet(shape, At(1, 2, reach - 0.01, turn), Plane{}, {});
      EXPECT_NEAR(DeepestOf(manifold), 0.01, 1e-12) << shape.index();
      for (int k = 0; k < manifold.count; ++k) {
        EXPECT_EQ(manifold.points[static_cast<size_t>(k)].normal, Vector3(-Vector3::UnitZ()));
      }
    }
  }
}

TEST(NarrowPhase, TurnsRoundWithItsArguments) {
  const Shape surface = GroundMesh(3, 4);
  for (const Shape& shape : Solids()) {
    for (const Shape& other : {Shape{Box{{0.5, 0.4, 0.3}}}, Shape{Plane{}}, surface}) {
      const Placement here = At(0.2, 0.1, 0.35), there = At(0, 0, 0.1);
      const Manifold one = Meet(shape, here, other, there), two = Meet(other, there, shape, here);
      EXPECT_NEAR(DeepestOf(one), DeepestOf(two), kExact);
      ASSERT_GT(one.count, 0);
      EXPECT_LT((one.points[0].normal + two.points[0].normal).norm(), 1e-6) << shape.index() << " " << other.index();
    }
  }
}

TEST(NarrowPhase, IsTheSameAtAnyScaleAndPlace) {
  Randomly random;
  for (const double scale : {1e-4, 1e4}) {
    for (int i = 0; i < 50; ++i) {
      const Vector3 half(0.5, 0.4, 0.3);
      const Quaternion turn_a = random.Turn(), turn_b = random.Turn();
      const Vector3 place = random.Between(0.9, 1.2) * random.Direction();
      const Manifold unit = Meet(HullBox(half), {Vector3::Zero(), turn_a.toRotationMatrix()}, Cone{0.4, 0.5},
                                 {place, turn_b.toRotationMatrix()}, 1);
      const Vector3 there = 100 * scale * random.Direction();
      const Manifold scaled =
          Meet(HullBox(scale * half), {there, turn_a.toRotationMatrix()}, Cone{0.4 * scale, 0.5 * scale},
               {there + scale * place, turn_b.toRotationMatrix()}, scale);
      EXPECT_NEAR(DeepestOf(scaled), scale * DeepestOf(unit), scale * kExact);
    }
  }
}

TEST(NarrowPhase, GivesFinitePointsOfAllSizesAtAllPlaces) {
  Randomly random;
  const auto size = [&] { return std::pow(10, random.Between(-5, 5)); };
  const auto shape = [&](int kind) -> Shape {
    switch (kind) {
      case 0:
        return Sphere{size()};
      case 1:
        return Box{{size(), size(), size()}};
      case 2:
        return Capsule{size(), size()};
      case 3:
        return Cylinder{size(), size()};
      case 4:
        return Cone{size(), size()};
      case 5:
        return Ellipsoid{{size(), size(), size()}};
      case 6:
        return HullBox(Vector3::Constant(std::min(size(), 5e4)), random.Turn());
      case 7:
        return Plane{random.Direction(), random.Between(-1, 1)};
      case 8:
        return BoxMesh(Vector3::Constant(size()));
      default:
        return Ground(4, size(), [&](double, double) { return size() / 10; });
    }
  };
  for (int i = 0; i < 20000 / kSweepStride; ++i) {
    const Shape a = shape(i % 10), b = shape(i / 10 % 10);
    const double distance = random.Between(0, 1) < 0.1 ? 0 : size();
    const Vector3 place = random.Between(0, 1) < 0.1 ? Vector3(1e7, -1e7, 1e7) : Vector3(0, 0, 0);
    const Placement here{place, random.Turn().toRotationMatrix()};
    const Placement there{place + distance * random.Direction(), random.Turn().toRotationMatrix()};
    const Manifold manifold = Meet(a, here, b, there, random.Between(0, 1e-2));
    ASSERT_LE(manifold.count, Manifold::kPointsMax);
    for (int k = 0; k < manifold.count; ++k) {
      const MeetingPoint& point = manifold.points[static_cast<size_t>(k)];
      ASSERT_TRUE(point.position.allFinite() && std::isfinite(point.depth)) << a.index() << " " << b.index();
      ASSERT_NEAR(point.normal.norm(), 1, 1e-9) << a.index() << " " << b.index();
    }
  }
}

TEST(SurfaceContacts, ABoxOnAMeshHasFourPointsWhateverTheTriangles) {
  for (const int cells : {1, 7, 20}) {
    for (const double turn : {0.0, 0.3, 0.6457718}) {
      const Quaternion yaw(Eigen::AngleAxisd(turn, Vector3::UnitZ()));
      const Manifold manifold = Meet(GroundMesh(3, cells), {}, Box{{0.5, 0.4, 0.3}}, At(0.13, -0.21, 0.299, yaw));
      ASSERT_EQ(manifold.count, 4) << cells << " cells turned " << turn;
      for (int i = 0; i < 4; ++i) {
        const MeetingPoint& point = manifold.points[static_cast<size_t>(i)];
        EXPECT_NEAR(point.depth, 1e-3, 1e-14);
        EXPECT_LT((point.normal - Vector3::UnitZ()).norm(), 1e-14);
        const Vector3 local = yaw.inverse() * (point.position - Vector3(0.13, -0.21, 0));
        EXPECT_NEAR(std::abs(local.x()), 0.5, 1e-6);
        EXPECT_NEAR(std::abs(local.y()), 0.4, 1e-6);
      }
    }
  }
}

TEST(SurfaceContacts, SeamsOfAFlatMeshPushNothingAside) {
  const TriangleMesh ground = GroundMesh(3, 6);
  const Heightfield field = Ground(7, 1);
  Randomly random;
  for (const Shape& shape : Solids()) {
    for (int i = 0; i < 100; ++i) {
      const Quaternion turn = random.Turn();
      const double reach = Solid(shape, At(0, 0, 0, turn)).Reach(-Vector3::UnitZ());
      const double depth = std::pow(10, random.Between(-6, -2));
      const Placement place = At(random.Between(-2, 2), random.Between(-2, 2), reach - depth, turn);
      for (const Shape& surface : {Shape{ground}, Shape{field}}) {
        const Manifold manifold = Meet(surface, {}, shape, place);
        EXPECT_NEAR(DeepestOf(manifold), depth, 1e-12) << shape.index();
        for (int k = 0; k < manifold.count; ++k) {
          EXPECT_LT((manifold.points[static_cast<size_t>(k)].normal - Vector3::UnitZ()).norm(), 1e-12);
        }
      }
    }
  }
}

TEST(SurfaceContacts, ABallInAValleyTouchesBothSlopesAndOnARidgeTheEdge) {
  const auto valley = [](double x, double) { return std::abs(x); };
  const double reach = 0.5 * std::sqrt(2);
  const Manifold in_valley = Meet(GroundMesh(3, 6, valley), {}, Sphere{0.5}, At(0, 0.3, reach - 1e-4));
  ASSERT_EQ(in_valley.count, 2);
  for (int i = 0; i < 2; ++i) {
    const MeetingPoint& point = in_valley.points[static_cast<size_t>(i)];
    EXPECT_NEAR(point.depth, 1e-4 / std::sqrt(2), 1e-12);
    EXPECT_NEAR(std::abs(point.normal.x()), std::sqrt(0.5), 1e-12);
  }
  const auto ridge = [](double x, double) { return -std::abs(x); };
  const Manifold on_ridge = Meet(GroundMesh(3, 6, ridge), {}, Sphere{0.5}, At(0.1, 0.3, 0.48));
  ASSERT_EQ(on_ridge.count, 1);
  EXPECT_NEAR(on_ridge.points[0].depth, 0.5 - std::hypot(0.1, 0.48), 1e-12);
  EXPECT_LT((on_ridge.points[0].normal - Vector3(0.1, 0, 0.48).normalized()).norm(), 1e-12);
}

TEST(SurfaceContacts, MeshesAreOpenFromBehindAndHeightfieldsSolid) {
  const Placement below = At(0.2, 0.1, -0.7);
  EXPECT_EQ(Meet(GroundMesh(3, 4), {}, Sphere{0.5}, below).count, 0);
  const Manifold sunk = Meet(Ground(7, 1), {}, Sphere{0.5}, below);
  ASSERT_GT(sunk.count, 0);
  EXPECT_NEAR(sunk.points[0].depth, 1.2, 1e-12);
  EXPECT_LT((sunk.points[0].normal - Vector3::UnitZ()).norm(), 1e-12);
}

TEST(SurfaceContacts, AreThoseOfTheSameSolid) {
  // A box rests on another one, over its edge, as on the closed mesh of that.
  Randomly random;
  for (int i = 0; i < 200; ++i) {
    const Vector3 half(0.5, 0.4, 0.3);
    const Quaternion yaw(Eigen::AngleAxisd(random.Between(0, 6.28), Vector3::UnitZ()));
    const Placement place = At(random.Between(-1.2, 1.2), random.Between(-1.2, 1.2), 1.3 - 1e-3, yaw);
    const Manifold solid = Meet(HullBox({1, 1, 1}), {}, Box{half}, place);
    const Manifold mesh = Meet(BoxMesh({1, 1, 1}), {}, Box{half}, place);
    ASSERT_EQ(solid.count > 0, mesh.count > 0) << i;
    for (int k = 0; k < mesh.count; ++k) {
      EXPECT_NEAR(mesh.points[static_cast<size_t>(k)].depth, 1e-3, 1e-12);
      EXPECT_LT((mesh.points[static_cast<size_t>(k)].normal - Vector3::UnitZ()).norm(), 1e-12);
    }
  }
}

TEST(SurfaceContacts, TwoSurfacesAreToldToMeet) {
  EXPECT_GT(Meet(GroundMesh(3, 4), {}, BoxMesh({1, 1, 1}), At(0, 0, 0.5)).count, 0);
  EXPECT_EQ(Meet(GroundMesh(3, 4), {}, BoxMesh({1, 1, 1}), At(0, 0, 1.5)).count, 0);
  EXPECT_GT(Meet(BoxMesh({1, 1, 1}), At(0, 0, 0.5), Plane{}, {}).count, 0);
  EXPECT_EQ(Meet(BoxMesh({1, 1, 1}), At(0, 0, 1.5), Plane{}, {}).count, 0);
}

TEST(NarrowPhase, FindsNothingOfABoxThatIsNowhere) {
  Placement nowhere;
  nowhere.position.setConstant(std::numeric_limits<double>::quiet_NaN());
  nowhere.rotation.setConstant(std::numeric_limits<double>::quiet_NaN());
  const Box box{{1, 1, 1}};
  for (const auto& [a, b] : {std::pair(nowhere, Placement{}), std::pair(Placement{}, nowhere)}) {
    Manifold manifold;
    FindContacts(box, a, box, b, 0, manifold);
    EXPECT_EQ(manifold.count, 0);
  }
}

}  // namespace
}  // namespace genphys

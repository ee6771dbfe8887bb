#include "genphys/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>
#include <vector>

#include "genphys/work_watch.h"
#include "support/shapes.h"
#include "support/sweep.h"

namespace genphys {
namespace {

using namespace testing;

template <typename T>
std::string WhyNot(const Result<T>& made) {
  if (made.ok()) return "";
  const Refusal refusal = *RefusalOf(made.status());
  return std::string(NameOf(refusal.reason)) + " " + refusal.field;
}

const std::vector<Vector3> kSquare{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

TEST(TriangleMesh, LeavesOutTrianglesWithoutAreaAndRepeatedOnes) {
  const Result<TriangleMesh> mesh = MakeTriangleMesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0.5, 0, 0}, {1, 0, 0}},
                                                     {0, 1, 2, 0, 1, 1, 0, 1, 3, 1, 2, 0, 0, 4, 2, 0, 2, 1});
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  // One front, given three times, and the back of it.
  EXPECT_EQ(mesh->data->triangles.size(), 2u);
  EXPECT_EQ(mesh->data->indices.size(), 18u) << "what was asked for is kept";
}

TEST(TriangleMesh, RefusesWhatIsNone) {
  EXPECT_EQ(WhyNot(MakeTriangleMesh({}, {0, 1, 2})), "MISSING_FIELD vertices");
  EXPECT_EQ(WhyNot(MakeTriangleMesh(kSquare, {})), "MISSING_FIELD indices");
  EXPECT_EQ(WhyNot(MakeTriangleMesh(kSquare, {0, 1})), "INVALID_VALUE indices");
  EXPECT_EQ(WhyNot(MakeTriangleMesh(kSquare, {0, 1, 2, 0, 2, 4})), "OUT_OF_RANGE indices[5]");
  EXPECT_EQ(WhyNot(MakeTriangleMesh(kSquare, {0, 1, 2, 0, 2, 3})), "");
  EXPECT_EQ(WhyNot(MakeTriangleMesh(kSquare, {0, 1, 1})), "INVALID_VALUE indices");
  EXPECT_EQ(WhyNot(MakeTriangleMesh({{0, 0, 0}, {1, NAN, 0}, {1, 1, 0}}, {0, 1, 2})), "NOT_FINITE vertices[4]");
  EXPECT_EQ(WhyNot(MakeTriangleMesh({{0, 0, 0}, {1, 0, 2e5}, {1, 1, 0}}, {0, 1, 2})), "OUT_OF_RANGE vertices[5]");
}

TEST(TriangleMesh, OfAMillionTrianglesIsMadeInSeconds) {
  const std::clock_t start = std::clock();
  const TriangleMesh mesh = GroundMesh(100, kManyCells, [](double x, double y) { return std::sin(x) * std::cos(y); });
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  EXPECT_EQ(mesh.data->triangles.size(), 2u * kManyCells * kManyCells);
  // Of the processor, so that others do not count. It takes one or two; sixty leave room for slower machines.
  EXPECT_LT(seconds, 60);
  RecordProperty("seconds", std::to_string(seconds));
}

TEST(TriangleMesh, IsCutShortWhereverItIsBeingMade) {
  constexpr uint32_t kPoints = 5000;
  std::vector<Vector3> points;
  for (uint32_t i = 0; i < kPoints; ++i) points.push_back({std::sin(i), std::cos(7.0 * i), std::sin(13.0 * i)});
  std::vector<uint32_t> soup;
  for (uint32_t i = 0; i < 6 * kPoints; ++i) soup.push_back(i * 2654435761u % kPoints);
  const auto asked_until = [&](int enough) {
    int asked = 0;
    const WorkWatch watch(
        [&] { return ++asked == enough ? absl::CancelledError("nobody waits any more") : absl::OkStatus(); });
    EXPECT_TRUE(MakeTriangleMesh(points, soup).ok());
    return asked;
  };

  const int all = asked_until(0);

  // Each is less than a millisecond of work.
  EXPECT_GT(all, 20);
  for (int enough = 1; enough <= all; ++enough) EXPECT_THROW(asked_until(enough), CutShort) << enough;
}

TEST(TriangleMesh, KnowsWhatLiesBeyondEachEdge) {
  // Two triangles of a square, one more that shares their diagonal the same way round, and one apart from them.
  const std::vector<Vector3> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}};
  const auto across = [&](std::vector<uint32_t> indices, const MeshData::Triangle& triangle) {
    const TriangleMesh mesh = *MakeTriangleMesh(points, std::move(indices));
    const auto& all = mesh.data->triangles;
    return mesh.data->across[static_cast<size_t>(std::ranges::find(all, triangle) - all.begin())];
  };
  constexpr uint32_t kNone = MeshData::kNone;
  using Across = MeshData::Triangle;
  EXPECT_EQ(across({0, 1, 2, 0, 2, 3, 5, 6, 7}, {0, 1, 2}), (Across{kNone, kNone, 3}));
  EXPECT_EQ(across({0, 1, 2, 0, 2, 3, 5, 6, 7}, {0, 2, 3}), (Across{1, kNone, kNone}));
  EXPECT_EQ(across({0, 1, 2, 0, 2, 3, 5, 6, 7}, {5, 6, 7}), (Across{kNone, kNone, kNone}));
  EXPECT_EQ(across({0, 1, 2, 0, 2, 3, 0, 2, 4}, {0, 1, 2}), (Across{kNone, kNone, kNone})) << "there are two";
}

TEST(Heightfield, RefusesWhatIsNone) {
  EXPECT_EQ(WhyNot(MakeHeightfield(2, 3, 1, std::vector<double>(6, 0.5))), "");
  EXPECT_EQ(WhyNot(MakeHeightfield(1, 3, 1, std::vector<double>(3, 0.5))), "OUT_OF_RANGE rows");
  EXPECT_EQ(WhyNot(MakeHeightfield(2, 1025, 1, {})), "OUT_OF_RANGE columns");
  EXPECT_EQ(WhyNot(MakeHeightfield(2, 3, 0, std::vector<double>(6, 0.5))), "OUT_OF_RANGE cell_size");
  EXPECT_EQ(WhyNot(MakeHeightfield(2, 3, 1, std::vector<double>(5, 0.5))), "INVALID_VALUE heights");
  EXPECT_EQ(WhyNot(MakeHeightfield(2, 3, 1, {0, 0, 0, 0, INFINITY, 0})), "NOT_FINITE heights[4]");
}

TEST(Surfaces, TellWhatTheyTake) {
  EXPECT_EQ(DataBytesOf(Sphere{}), 0u);
  EXPECT_EQ(DataBytesOf(TriangleMesh{}), 0u);
  // At least what was asked for, and not ten times as much.
  const auto expect_about = [](const Shape& shape, size_t asked_for) {
    EXPECT_GT(DataBytesOf(shape), asked_for);
    EXPECT_LT(DataBytesOf(shape), 10 * asked_for);
  };
  expect_about(HullBox({1, 1, 1}), 8 * sizeof(Vector3));
  expect_about(GroundMesh(1, 20), 21 * 21 * sizeof(Vector3) + 2400 * sizeof(uint32_t));
  expect_about(Ground(30, 1), 900 * sizeof(double));
}

TEST(Surfaces, AreEqualByContent) {
  EXPECT_EQ(BoxMesh({1, 2, 3}), BoxMesh({1, 2, 3}));
  EXPECT_NE(BoxMesh({1, 2, 3}), BoxMesh({1, 2, 4}));
  EXPECT_EQ(Ground(4, 1), Ground(4, 1));
  EXPECT_NE(Ground(4, 1), Ground(4, 2));
  EXPECT_NE(Heightfield{}, Ground(4, 1));
}

}  // namespace
}  // namespace genphys

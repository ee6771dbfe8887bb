#include "genphys/wire/query.h"

#include <gtest/gtest.h>

#include "wire_round_trip.h"

namespace genphys {
namespace {

const std::vector<Pose> kPoses{{{1, 2, 3}}, {{4, 5, 6}, Quaternion(0.5, 0.5, -0.5, 0.5)}};

TEST(WireQuery, KeepsShapesAndPlacesOfEveryQuestion) {
  const auto check = [](auto request) {
    EncodePosedShape(Cone{0.3, 0.4}, kPoses, &request);
    const Result<PosedShape> query = DecodePosedShape(request);
    ASSERT_TRUE(query.ok()) << query.status();
    EXPECT_EQ(query->shape, Shape(Cone{0.3, 0.4}));
    EXPECT_EQ(query->poses, kPoses);
    request.clear_orientations();
    EXPECT_EQ(DecodePosedShape(request)->poses[1], (Pose{{4, 5, 6}}));
    request.mutable_orientations()->assign(32, '\0');
    EXPECT_EQ(Verdict(DecodePosedShape(request).status()), "INVALID_VALUE orientations");
    request.mutable_shape()->mutable_convex_hull();
    EXPECT_EQ(Verdict(DecodePosedShape(request).status()), "INVALID_VALUE shape.convex_hull.vertices");
  };
  check(v1::CastShapeRequest());
  check(v1::FindOverlapsRequest());
  check(v1::FindClosestRequest());
}

TEST(WireQuery, KeepsAllHitsOfRays) {
  const std::vector<std::vector<RayEntry>> sent{
      {{{EntityId(1, 2), 3}, 0.25, {1, 0, 0}}, {{EntityId(4, 5), 6}, 0.5, {0, 1, 0}}},
      {},
      {{{EntityId(7, 8), 9}, 1, {0, 0, 1}}}};
  v1::CastRaysResponse response;
  EncodeRayEntries(sent, &response);
  const auto returned = DecodeRayEntries(response);
  ASSERT_TRUE(returned.ok()) << returned.status();
  ASSERT_EQ(returned->size(), 3u);
  EXPECT_TRUE((*returned)[1].empty());
  EXPECT_EQ((*returned)[0][1].hit, sent[0][1].hit);
  EXPECT_EQ((*returned)[0][1].fraction, 0.5);
  EXPECT_EQ((*returned)[2][0].normal, sent[2][0].normal);
  response.set_hit_counts(0, 3);
  EXPECT_EQ(Verdict(DecodeRayEntries(response).status()), "INVALID_VALUE hit_counts");
  response.add_geometry_ids(1);
  EXPECT_EQ(Verdict(DecodeRayEntries(response).status()), "INVALID_VALUE geometry_ids");
}

TEST(WireQuery, KeepsWhatAShapeMeets) {
  const std::vector<ShapeCastHit> sent{{{EntityId(1, 2), 3}, 0.25, {1, 2, 3}, {1, 0, 0}}, {}};
  v1::CastShapeResponse response;
  EncodeShapeCastHits(sent, &response);
  const auto returned = DecodeShapeCastHits(response);
  ASSERT_TRUE(returned.ok()) << returned.status();
  EXPECT_EQ((*returned)[0].hit, sent[0].hit);
  EXPECT_EQ((*returned)[0].fraction, 0.25);
  EXPECT_EQ((*returned)[0].position, sent[0].position);
  EXPECT_EQ((*returned)[0].normal, sent[0].normal);
  EXPECT_TRUE((*returned)[1].hit.entity.is_null());
  EXPECT_EQ((*returned)[1].fraction, 1);
  response.mutable_normals()->clear();
  EXPECT_EQ(Verdict(DecodeShapeCastHits(response).status()), "INVALID_VALUE normals");
}

TEST(WireQuery, KeepsOverlapsDistancesAndContacts) {
  const std::vector<std::vector<GeometryId>> overlaps{{}, {{EntityId(1, 2), 3}, {EntityId(1, 2), 4}}};
  v1::FindOverlapsResponse found;
  EncodeOverlaps(overlaps, &found);
  EXPECT_EQ(*DecodeOverlaps(found), overlaps);

  const std::vector<ClosestPoints> closest{{{EntityId(1, 2), 3}, -0.5, {1, 2, 3}, {4, 5, 6}, {0, 1, 0}}};
  v1::ClosestColumns columns;
  EncodeClosest(closest, &columns);
  const auto near = DecodeClosest(columns);
  ASSERT_TRUE(near.ok()) << near.status();
  EXPECT_EQ((*near)[0].hit, closest[0].hit);
  EXPECT_EQ((*near)[0].distance, -0.5);
  EXPECT_EQ((*near)[0].on_query, closest[0].on_query);
  EXPECT_EQ((*near)[0].on_hit, closest[0].on_hit);
  EXPECT_EQ((*near)[0].normal, closest[0].normal);

  const EntityContact contact{EntityId(1, 2), true, {{.position = {1, 2, 3}, .depth = 0.5, .geometry_b = 7}}};
  v1::GetContactsResponse touching;
  EncodeContacts({&contact, 1}, &touching);
  const std::vector<EntityContact> returned = DecodeContacts(touching);
  ASSERT_EQ(returned.size(), 1u);
  EXPECT_EQ(returned[0].other, contact.other);
  EXPECT_TRUE(returned[0].is_sensor);
  ASSERT_EQ(returned[0].points.size(), 1u);
  EXPECT_EQ(returned[0].points[0].position, contact.points[0].position);
  EXPECT_EQ(returned[0].points[0].depth, 0.5);
  EXPECT_EQ(returned[0].points[0].geometry_b, 7u);
}

}  // namespace
}  // namespace genphys

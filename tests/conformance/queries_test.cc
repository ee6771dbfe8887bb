// What questions are answered, whatever the engine.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "engine_test.h"
#include "genphys/limits.h"
#include "genphys/work_watch.h"
#include "support/random.h"
#include "support/shapes.h"

namespace genphys {
namespace {

using namespace testing;

GENPHYS_ENGINE_TESTS(Queries);

constexpr double kExact = 1e-9;  // m: the accuracy of the narrow phase at this size

EntityDesc Still(const Shape& shape, const Vector3& position) {
  EntityDesc desc = Body(shape, position);
  desc.rigid_body->motion_type = MotionType::kStatic;
  return desc;
}

std::vector<Pose> At(const std::vector<Vector3>& places) {
  std::vector<Pose> poses(places.size());
  for (size_t i = 0; i < places.size(); ++i) poses[i].position = places[i];
  return poses;
}

template <typename T>
T Must(Result<T> made) {
  EndAtRefusal(made.status());
  EXPECT_TRUE(made.ok()) << made.status();
  return made.ok() ? *std::move(made) : T{};
}

Refusal WhyNot(const Status& status) { return RefusalOf(status).value_or(Refusal{}); }

TEST_P(Queries, TellNoMoreThanFitsIntoMemory) {
  Proves({Claim::kRaysThrough});
  constexpr size_t kBodies = 2000;
  const auto world = MakeWorld();
  for (size_t i = 0; i < kBodies; ++i) Add(*world, Still(Sphere{0.5}, {0, 0, 5}));
  const Ray ray{{0, 0, 10}, {0, 0, -9}};
  const std::vector<Ray> rays(Limits::kQueryResultsMax / kBodies, ray);
  EXPECT_EQ(Must(world->CastRaysThrough(rays)).size(), rays.size());
  std::vector<Ray> more = rays;
  more.push_back(ray);
  const Refusal refusal = WhyNot(world->CastRaysThrough(more).status());
  EXPECT_EQ(refusal.reason, Reason::kLimitExceeded);
  EXPECT_EQ(refusal.field, "origins");
}

TEST_P(Queries, EndWhenNobodyWantsTheAnswerAnyMore) {
  Proves({Claim::kRayCasts, Claim::kRaysThrough, Claim::kShapeCast, Claim::kOverlap, Claim::kClosestPoints});
  const auto world = MakeWorld();
  const EntityId ball = Add(*world, Still(Sphere{0.5}, {0, 0, 5}));
  const size_t count = 1000;
  const std::vector<Ray> rays(count, Ray{{0, 0, 10}, {0, 0, -9}});
  const std::vector<Pose> poses = At(std::vector<Vector3>(count, Vector3(0, 0, 7)));
  const std::vector<Vector3> ways(count, Vector3(0, 0, -1));
  const std::vector<EntityId> ids(count, ball);
  const Shape shape = Sphere{0.5};
  const std::vector<std::function<Status()>> queries{[&] { return world->CastRays(rays).status(); },
                                                     [&] { return world->CastRaysThrough(rays).status(); },
                                                     [&] { return world->CastShape(shape, poses, ways).status(); },
                                                     [&] { return world->FindOverlaps(shape, poses).status(); },
                                                     [&] { return world->FindClosest(shape, poses, 1).status(); },
                                                     [&] { return world->MeasureDistances(ids, ids).status(); }};
  for (size_t i = 0; i < queries.size(); ++i) {
    EndAtRefusal(queries[i]());
    EXPECT_TRUE(queries[i]().ok()) << i;
    int asked = 0;
    {
      const WorkWatch watch([&] { return ++asked == 4 ? absl::CancelledError("enough") : absl::OkStatus(); });
      EXPECT_THROW(static_cast<void>(queries[i]()), CutShort) << i;
    }
    EXPECT_EQ(asked, 4) << i;
    EXPECT_TRUE(queries[i]().ok()) << i;
  }
}

TEST_P(Queries, ARayTellsOfAllThatItPassesInOrder) {
  Proves({Claim::kRaysThrough});
  const auto world = MakeWorld();
  const EntityId high = Add(*world, Still(Sphere{0.5}, {0, 0, 5}));
  const EntityId low = Add(*world, Still(HullBox({0.5, 0.5, 0.5}), {0, 0, 2}));
  EntityDesc other = Still(Box{{0.5, 0.5, 0.5}}, {0, 0, 3.5});
  other.rigid_body->geometries[0].category_bits = 4;
  const EntityId filtered = Add(*world, other);
  EntityDesc ghost = Still(Box{{0.2, 0.2, 0.2}}, {0, 0, 7});
  ghost.rigid_body->geometries[0].is_sensor = true;
  Add(*world, ghost);
  const std::vector<Ray> rays{{{0.1, 0, 10}, {0, 0, -20}}, {{9, 0, 10}, {0, 0, -5}}, {{0, 0, 4}, {0, 0, -2}}};

  const auto all = Must(world->CastRaysThrough(rays));
  ASSERT_EQ(all.size(), 3u);
  ASSERT_EQ(all[0].size(), 4u);
  EXPECT_EQ(all[0][0].hit, (GeometryId{high, 1}));
  EXPECT_NEAR(all[0][0].fraction, (5 - std::sqrt(0.24)) / 20, kExact);
  EXPECT_EQ(all[0][1].hit.entity, filtered);
  EXPECT_EQ(all[0][2].hit.entity, low);
  EXPECT_NEAR(all[0][2].fraction, 7.5 / 20, kExact);
  EXPECT_NEAR(all[0][3].fraction, 10.0 / 20, kExact) << "the floor";
  EXPECT_TRUE(all[1].empty());
  ASSERT_EQ(all[2].size(), 2u) << "it ends before the floor";
  EXPECT_EQ(all[2][0].fraction, 0) << "it starts on a surface and leads inwards";
  const auto some = Must(world->CastRaysThrough(rays, 1));
  EXPECT_EQ(some[0].size(), 3u);
}

TEST_P(Queries, AShapeIsStoppedByWhatItMeetsFirst) {
  Proves({Claim::kShapeCast});
  const auto world = MakeWorld();
  const EntityId box = Add(*world, Still(Box{{1, 1, 1}}, {0, 0, 1}));
  const EntityId mesh = Add(*world, Still(GroundMesh(2, 5), {10, 0, 1}));
  const EntityId field = Add(*world, Still(Ground(5, 1), {20, 0, 1}));
  const std::vector<Pose> poses = At({{0, 0, 6}, {10.1, 0.3, 6}, {20.1, 0.3, 6}, {30, 0, 6}, {0, 0, 2.3}, {0, 0, 9}});
  std::vector<Vector3> ways(poses.size(), Vector3(0, 0, -8));
  ways.back() = {0, 0, -6.4};

  const auto hits = Must(world->CastShape(Sphere{0.5}, poses, ways));
  ASSERT_EQ(hits.size(), poses.size());
  EXPECT_EQ(hits[0].hit, (GeometryId{box, 1}));
  EXPECT_NEAR(hits[0].fraction, 3.5 / 8, kExact);
  EXPECT_LT((hits[0].position - Vector3(0, 0, 2)).norm(), kExact);
  EXPECT_LT((hits[0].normal - Vector3::UnitZ()).norm(), kExact);
  EXPECT_EQ(hits[1].hit.entity, mesh);
  EXPECT_NEAR(hits[1].fraction, 4.5 / 8, kExact);
  EXPECT_EQ(hits[2].hit.entity, field);
  EXPECT_NEAR(hits[2].fraction, 4.5 / 8, kExact);
  EXPECT_NEAR(hits[3].fraction, 5.5 / 8, kExact) << "the floor";
  EXPECT_EQ(hits[4].fraction, 0) << "overlaps from the start";
  EXPECT_TRUE(hits[5].hit.entity.is_null()) << "ends before";
  EXPECT_EQ(hits[5].fraction, 1);
}

TEST_P(Queries, AnOverlapIsToldOfAllThatIsThere) {
  Proves({Claim::kOverlap});
  const auto world = MakeWorld();
  const EntityId box = Add(*world, Still(Box{{1, 1, 1}}, {0, 0, 3}));
  const EntityId cone = Add(*world, Still(Cone{0.5, 0.5}, {1.6, 0, 3}));
  const std::vector<Pose> poses = At({{1.2, 0, 2.6}, {-1.3 + 1e-6, 0, 3}, {-1.3 - 1e-6, 0, 3}, {0, 0, 0.2}});
  const auto found = Must(world->FindOverlaps(Sphere{0.3}, poses));
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(found[0], (std::vector<GeometryId>{{box, 1}, {cone, 1}}));
  EXPECT_EQ(found[1], (std::vector<GeometryId>{{box, 1}}));
  EXPECT_TRUE(found[2].empty());
  EXPECT_EQ(found[3].size(), 1u) << "the floor";
  EXPECT_TRUE(Must(world->FindOverlaps(Sphere{0.3}, poses, 2))[0].empty()) << "another category";
}

TEST_P(Queries, TheClosestThingIsFoundAndHowFarItIs) {
  Proves({Claim::kClosestPoints});
  const auto world = MakeWorld();
  const EntityId box = Add(*world, Still(Box{{1, 1, 1}}, {0, 0, 5}));
  const std::vector<Pose> poses = At({{3, 4, 7}, {0, 0, 1}, {0, 0, 5.8}, {0, 0, 60}});
  const auto found = Must(world->FindClosest(Sphere{0.5}, poses, 50));
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(found[0].hit, (GeometryId{box, 1}));
  const Vector3 corner(1, 1, 6), way = Vector3(3, 4, 7) - corner;
  EXPECT_NEAR(found[0].distance, way.norm() - 0.5, kExact);
  EXPECT_LT((found[0].on_hit - corner).norm(), kExact);
  EXPECT_LT((found[0].on_query - corner - (way.norm() - 0.5) * way.normalized()).norm(), kExact);
  EXPECT_LT((found[0].normal - way.normalized()).norm(), kExact);
  EXPECT_NEAR(found[1].distance, 0.5, kExact) << "the floor";
  EXPECT_NEAR(found[2].distance, -0.7, kExact) << "inside";
  EXPECT_TRUE(found[3].hit.entity.is_null()) << "too far";
}

TEST_P(Queries, TheClosestOfManyIsTheOneToWhichTheDistanceIsLeast) {
  Proves({Claim::kClosestPoints});
  const auto world = MakeWorld();
  Random random(1);
  std::vector<EntityId> all;
  for (int i = 0; i < 200; ++i) {
    const Vector3 place = random.Vector(20) + Vector3(0, 0, 30);
    EntityDesc desc = i % 2 == 0 ? Ball(place, random.LogUniform(0.1, 2)) : Crate(place, random.LogUniform(0.1, 2));
    desc.pose.orientation = random.Turn();
    if (i % 4 < 2) desc.rigid_body->motion_type = MotionType::kStatic;
    all.push_back(Add(*world, desc));
  }
  // Half of them fall, and what looks meets nobody.
  Steps(*world, 10);
  EntityDesc looking = Still(Sphere{0.2}, {});
  looking.rigid_body->geometries[0].collides_with_bits = 0;
  const EntityId eye = Add(*world, looking);
  int compared = 0;
  for (int i = 0; i < 100; ++i) {
    SCOPED_TRACE(i);
    const Vector3 place = random.Vector(i % 2 == 0 ? 25 : 200) + Vector3(0, 0, 230);
    Do(*world, SetPose{.id = eye, .position = place});
    const std::vector<ClosestPoints> each = Must(world->MeasureDistances(std::vector<EntityId>(all.size(), eye), all));
    const auto least = std::ranges::min_element(each, {}, &ClosestPoints::distance);
    const std::vector<Pose> poses = At({place});
    Do(*world, SetPose{.id = eye, .position = Vector3(0, 0, 5000)});
    const ClosestPoints closest = Must(world->FindClosest(Sphere{0.2}, poses, 1000))[0];
    if (place.z() - 0.2 < least->distance) continue;  // the floor is closer
    ++compared;
    EXPECT_EQ(closest.hit, least->hit);
    EXPECT_NEAR(closest.distance, least->distance, kExact);
    // Within less there is none.
    EXPECT_TRUE(Must(world->FindClosest(Sphere{0.2}, poses, 0.999 * least->distance))[0].hit.entity.is_null());
  }
  EXPECT_GT(compared, 50);
}

TEST_P(Queries, OfThoseThatAreEquallyCloseTheFirstIsTold) {
  Proves({Claim::kClosestPoints});
  const auto world = MakeWorld();
  const std::vector<Vector3> places{{3, 0, 50}, {-3, 0, 50}, {0, 3, 50}, {0, -3, 50}, {0, 0, 53}};
  std::vector<EntityId> ids;
  for (const Vector3& place : places) ids.push_back(Add(*world, Still(Sphere{0.5}, place)));
  const std::vector<Pose> poses = At({{0, 0, 50}});
  for (const EntityId first : ids) {
    const ClosestPoints closest = Must(world->FindClosest(Sphere{0.5}, poses, 10))[0];
    EXPECT_EQ(closest.hit.entity, first);
    EXPECT_NEAR(closest.distance, 2, kExact);
    Do(*world, DeleteEntity{first});
  }
}

TEST_P(Queries, DistancesOfEntitiesAreThoseOfTheirNearestParts) {
  Proves({Claim::kClosestPoints});
  const auto world = MakeWorld();
  EntityDesc two = Still(Sphere{0.5}, {0, 0, 5});
  two.rigid_body->geometries.push_back({.shape = Sphere{0.25}, .pose_in_entity = {{2, 0, 0}}});
  const EntityId pair = Add(*world, two);
  const EntityId cone = Add(*world, Still(Cone{0.5, 0.5}, {2, 0, 3}));
  EntityDesc empty;
  const EntityId nothing = Add(*world, empty);
  const std::vector<EntityId> from{pair, cone, pair}, to{cone, pair, nothing};
  const auto found = Must(world->MeasureDistances(from, to));
  ASSERT_EQ(found.size(), 3u);
  EXPECT_NEAR(found[0].distance, 1.25, kExact);
  EXPECT_NEAR(found[1].distance, 1.25, kExact);
  EXPECT_EQ(found[1].hit, (GeometryId{pair, 2}));
  EXPECT_LT((found[0].on_query - Vector3(2, 0, 4.75)).norm(), kExact);
  EXPECT_LT((found[0].on_hit - Vector3(2, 0, 3.5)).norm(), kExact);
  EXPECT_TRUE(found[2].hit.entity.is_null());
  const std::vector<EntityId> gone{EntityId(77, 1)};
  EXPECT_EQ(WhyNot(world->MeasureDistances(gone, gone).status()).field, "from_ids[0]");
}

TEST_P(Queries, ContactsOfAnEntityCarryItsWeightAndOutlastItsWaking) {
  Proves({Claim::kContactsOf});
  const auto world = MakeWorld();
  const EntityId crate = Add(*world, Crate({0, 0, 0.5}, 0.5, 2));
  const EntityId ball = Add(*world, Ball({5, 0, 3}));
  EXPECT_TRUE(Must(world->ContactsOf(crate)).empty()) << "before the first step nothing is known";
  Steps(*world, 20);
  const auto contacts = Must(world->ContactsOf(crate));
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_FALSE(contacts[0].is_sensor);
  ASSERT_EQ(contacts[0].points.size(), 4u);
  double impulse = 0;
  for (const EventContactPoint& point : contacts[0].points) impulse += point.normal_impulse;
  EXPECT_GT(impulse, 0);
  EXPECT_TRUE(Must(world->ContactsOf(ball)).empty());
  Steps(*world, 200);
  ASSERT_TRUE(Asleep(*world, crate));
  const EntityId late = Add(*world, Crate({9, 0, 0.5}));
  Steps(*world, 2);
  const auto lying = Must(world->ContactsOf(crate));
  ASSERT_EQ(lying.size(), 1u);
  EXPECT_EQ(lying[0].points.size(), 4u);
  EXPECT_EQ(Must(world->ContactsOf(late)).size(), 1u);
}

TEST_P(Queries, RefuseWhatIsNoQuestion) {
  Proves({Claim::kOverlap, Claim::kShapeCast, Claim::kClosestPoints, Claim::kContactsOf});
  const auto world = MakeWorld();
  const std::vector<Pose> here(1);
  EXPECT_EQ(WhyNot(world->FindOverlaps(Plane{}, here).status()).field, "shape");
  EXPECT_EQ(WhyNot(world->FindOverlaps(GroundMesh(1, 1), here).status()).field, "shape");
  EXPECT_EQ(WhyNot(world->FindOverlaps(ConvexHull{}, here).status()).field, "shape.convex_hull.vertices");
  EXPECT_EQ(WhyNot(world->FindOverlaps(Sphere{0}, here).status()).field, "shape.sphere.radius");
  const std::vector<Pose> nowhere = At({{0, 0, 0}, {0, NAN, 0}});
  std::vector<Pose> crooked(1);
  crooked[0].orientation = Quaternion(1, 1, 0, 0);
  EXPECT_EQ(WhyNot(world->FindOverlaps(Sphere{}, nowhere).status()).field, "positions[1].y");
  EXPECT_EQ(WhyNot(world->FindClosest(Sphere{}, crooked, 1).status()).field, "orientations[0]");
  EXPECT_EQ(WhyNot(world->FindClosest(Sphere{}, here, -1).status()).field, "distance_max");
  EXPECT_EQ(WhyNot(world->CastShape(Sphere{}, here, {}).status()).field, "translations");
  const std::vector<Vector3> endless{{INFINITY, 0, 0}};
  EXPECT_EQ(WhyNot(world->CastShape(Sphere{}, here, endless).status()).field, "translations[0].x");
  EXPECT_EQ(WhyNot(world->ContactsOf(EntityId()).status()).reason, Reason::kMissingField);
  Do(*world, SetEngine{"none"});
  EXPECT_EQ(WhyNot(world->FindOverlaps(Sphere{}, here).status()).reason, Reason::kUnsupportedFeature);
  EXPECT_EQ(WhyNot(world->CastRaysThrough(std::vector<Ray>(1)).status()).reason, Reason::kUnsupportedFeature);
}

TEST(QueriesOfEngines, HaveTheSameAnswersToTheLastBit) {
  std::vector<std::vector<double>> answers;
  const std::vector<std::string> able =
      ThoseWith({Feature::kShapeQueries, Feature::kShapeSphere, Feature::kShapeBox, Feature::kShapeCone,
                 Feature::kShapeConvexHull, Feature::kShapeCapsule, Feature::kShapeTriangleMesh},
                EnginesWithContacts());
  ASSERT_FALSE(able.empty());
  for (const std::string& engine : able) {
    const auto world = testing::MakeWorld(engine);
    const std::vector<Shape> shapes{Sphere{0.4}, Box{{0.4, 0.3, 0.5}}, Cone{0.4, 0.5}, HullBox({0.3, 0.4, 0.5}),
                                    Capsule{0.3, 0.2}};
    for (int i = 0; i < 40; ++i) {
      const Vector3 place(std::sin(i) * 4, std::cos(2.0 * i) * 4, 1 + 0.1 * i);
      Add(*world, Still(shapes[static_cast<size_t>(i) % shapes.size()], place));
    }
    Add(*world, Still(GroundMesh(5, 9, [](double x, double y) { return 0.2 * std::sin(x + y); }), {0, 0, 0.5}));
    std::vector<Pose> poses;
    std::vector<Vector3> ways;
    std::vector<Ray> rays;
    for (int i = 0; i < 30; ++i) {
      poses.push_back(At({{std::cos(3.0 * i) * 5, std::sin(5.0 * i) * 5, 6}})[0]);
      ways.push_back({std::cos(i), std::sin(i), -6});
      rays.push_back({poses.back().position, ways.back()});
    }
    std::vector<double> numbers;
    for (const auto& hit : Must(world->CastShape(Cone{0.3, 0.4}, poses, ways))) numbers.push_back(hit.fraction);
    for (const auto& near : Must(world->FindClosest(Cone{0.3, 0.4}, poses, 20))) numbers.push_back(near.distance);
    for (const auto& there : Must(world->FindOverlaps(Sphere{3}, poses))) numbers.push_back(double(there.size()));
    for (const auto& along : Must(world->CastRaysThrough(rays))) {
      for (const RayEntry& entry : along) numbers.push_back(entry.fraction);
    }
    EXPECT_GT(numbers.size(), 100u);
    answers.push_back(numbers);
  }
  for (const auto& numbers : answers) EXPECT_EQ(numbers, answers.front());
}

}  // namespace
}  // namespace genphys

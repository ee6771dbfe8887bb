#include <gtest/gtest.h>

#include <vector>

#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"
#include "wire_round_trip.h"

namespace genphys {
namespace {

v1::World FilledWorld() {
  v1::World world;
  FillEveryField(&world);
  world.set_engine("engines/bullet");
  world.clear_record_state_hash();
  return world;
}

TEST(WireWorld, TravelsWithAllItsFields) {
  const v1::World sent = FilledWorld();

  const Result<WorldDesc> desc = DecodeWorld(sent, "ode");
  ASSERT_TRUE(desc.ok()) << desc.status();
  v1::World returned;
  EncodeWorld(*desc, sent.name(), sent.state(), &returned);

  EXPECT_EQ(desc->engine, "bullet");
  EXPECT_TRUE(SameMessage(sent, returned));
}

TEST(WireWorld, TakesTheDocumentedDefaultForWhatIsUnset) {
  const Result<WorldDesc> desc = DecodeWorld(v1::World(), "ballistic");

  ASSERT_TRUE(desc.ok()) << desc.status();
  EXPECT_EQ(desc->engine, "ballistic");
  EXPECT_EQ(desc->gravity, Vector3(0, 0, -9.80665));
  EXPECT_EQ(desc->stepper, StepperDesc());
  EXPECT_EQ(desc->ground_plane, std::nullopt);
  EXPECT_EQ(desc->recorded_events, EventKinds());
  EXPECT_EQ(desc->default_material, Material());
}

TEST(WireWorld, RefusesAnEngineNameOfAnotherForm) {
  v1::World world;
  world.set_engine("ode");

  EXPECT_EQ(Verdict(DecodeWorld(world, "ode").status()), "INVALID_VALUE engine");
}

TEST(WireWorld, NamesEveryFeatureAsTheModelDoes) {
  for (int number = 1; number < v1::Feature_ARRAYSIZE; ++number) {
    std::string name = v1::Feature_Name(number).substr(std::string("FEATURE_").size());
    for (char& c : name) c = static_cast<char>(std::tolower(c));
    EXPECT_EQ(NameOf(static_cast<Feature>(number)), name);
  }
}

TEST(WireWorld, ListsTheFeaturesOfAnEngineInOrder) {
  v1::Engine engine;

  EncodeEngine(Capabilities("ode", "0.16", {Feature::kRayCasts, Feature::kShapeBox}), &engine);

  EXPECT_EQ(engine.name(), "engines/ode");
  EXPECT_EQ(engine.version(), "0.16");
  EXPECT_EQ(std::vector<int>(engine.features().begin(), engine.features().end()),
            (std::vector<int>{v1::FEATURE_SHAPE_BOX, v1::FEATURE_RAY_CASTS}));
}

TEST(WireWorld, TellsWhereAStepWent) {
  const StepStats stats{.entities_asleep = 1,
                        .entities_in_flight = 7,
                        .entities_in_engine = 2,
                        .pairs = 3,
                        .contacts = 4,
                        .islands = 8,
                        .stages = {{"solve", 5}, {"sort", 6}}};
  v1::StepStats encoded;

  EncodeStats(stats, &encoded);

  EXPECT_EQ(encoded.entities_asleep(), 1u);
  EXPECT_EQ(encoded.entities_in_flight(), 7u);
  EXPECT_EQ(encoded.entities_in_engine(), 2u);
  EXPECT_EQ(encoded.pairs_tested(), 3u);
  EXPECT_EQ(encoded.contacts(), 4u);
  EXPECT_EQ(encoded.islands(), 8u);
  ASSERT_EQ(encoded.stages_size(), 2);
  EXPECT_EQ(encoded.stages(1).stage(), "sort");
  EXPECT_EQ(encoded.stages(1).nanoseconds(), 6u);
}

TEST(WireRays, TravelInOrder) {
  const std::vector<Ray> rays{{{1, 2, 3}, {4, 5, 6}}, {{7, 8, 9}, {10, 11, 12}}};
  v1::CastRaysRequest request;
  EncodeRays(rays, &request);

  const Result<std::vector<Ray>> decoded = DecodeRays(request);

  ASSERT_TRUE(decoded.ok()) << decoded.status();
  ASSERT_EQ(decoded->size(), 2u);
  EXPECT_EQ((*decoded)[1].origin, rays[1].origin);
  EXPECT_EQ((*decoded)[1].translation, rays[1].translation);
}

TEST(WireRays, AreRefusedWhenTheirColumnsDifferInLength) {
  v1::CastRaysRequest request;
  EncodeRays(std::vector<Ray>(2), &request);
  request.mutable_translations()->resize(3 * sizeof(double));

  EXPECT_EQ(Verdict(DecodeRays(request).status()), "INVALID_VALUE translations");
}

TEST(WireRays, BringBackHitsAndMisses) {
  const EntityId ball(4, 2);
  v1::CastRaysResponse response;
  EncodeRayHits(std::vector<RayHit>{{ball, 0.25, Vector3::UnitX()}, {EntityId(), 0, Vector3::UnitY()}}, &response);

  const Result<std::vector<RayHit>> hits = DecodeRayHits(response);

  ASSERT_TRUE(hits.ok()) << hits.status();
  ASSERT_EQ(hits->size(), 2u);
  EXPECT_EQ((*hits)[0].entity, ball);
  EXPECT_EQ((*hits)[0].fraction, 0.25);
  EXPECT_EQ((*hits)[0].normal, Vector3::UnitX());
  EXPECT_TRUE((*hits)[1].entity.is_null());
  EXPECT_EQ((*hits)[1].fraction, 1);
  EXPECT_EQ((*hits)[1].normal, Vector3::Zero());
}

TEST(WireRays, AreRefusedWhenTheHitsDifferInLength) {
  v1::CastRaysResponse response;
  EncodeRayHits(std::vector<RayHit>(2), &response);
  response.clear_fractions();

  EXPECT_EQ(Verdict(DecodeRayHits(response).status()), "INVALID_VALUE fractions");
}

}  // namespace
}  // namespace genphys

// The life of worlds through WorldService and EngineService.
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/test_server.h"

namespace genphys::testing {
namespace {

using Worlds = v1::WorldService::Stub;
using google::protobuf::util::MessageDifferencer;

v1::GetWorldRequest Named(const std::string& name) {
  v1::GetWorldRequest request;
  request.set_name(name);
  return request;
}

v1::World WorldNamed(const std::string& name) {
  v1::World world;
  world.set_name(name);
  return world;
}

TEST(CreateWorld, MakesAUsableWorldOfAnEmptyRequest) {
  TestServer server;

  const auto created = Must(server.worlds(), &Worlds::CreateWorld, v1::CreateWorldRequest());

  EXPECT_TRUE(created.world().name().starts_with("worlds/w-")) << created.world().name();
  EXPECT_TRUE(created.world().engine().starts_with("engines/"));
  EXPECT_EQ(created.world().state(), v1::World::STATE_PAUSED);
  EXPECT_NE(created.stamp().epoch(), 0u);
  EXPECT_EQ(created.stamp().step(), 0u);
  EXPECT_EQ(server.Step(created.world().name()).stamp().step(), 1u);
}

TEST(CreateWorld, TellsWhatGetWorldTells) {
  TestServer server;
  const auto created = server.CreateWorld(WorldNamed("worlds/lab.1"));

  const auto read = Must(server.worlds(), &Worlds::GetWorld, Named("worlds/lab.1"));

  EXPECT_TRUE(MessageDifferencer::Equals(read.world(), created.world()));
  EXPECT_TRUE(MessageDifferencer::Equals(read.stamp(), created.stamp()));
}

TEST(CreateWorld, RefusesANameThatIsTaken) {
  TestServer server;
  server.CreateWorld(WorldNamed("worlds/a"));
  v1::CreateWorldRequest again;
  again.mutable_world()->set_name("worlds/a");

  ExpectRefusal(MustNot(server.worlds(), &Worlds::CreateWorld, again), Reason::kAlreadyExists, "world.name");
  again.mutable_world()->set_name("worlds/b");
  Must(server.worlds(), &Worlds::CreateWorld, again);
}

TEST(CreateWorld, RefusesAnEngineThatIsNotThereAndFeaturesThatItLacks) {
  TestServer server;
  v1::CreateWorldRequest request;

  request.mutable_world()->set_engine("engines/perpetuum");
  const Status unknown = MustNot(server.worlds(), &Worlds::CreateWorld, request);
  EXPECT_EQ(RefusalOf(unknown)->field, "world.engine") << unknown.ToString();

  request.mutable_world()->clear_engine();
  request.mutable_world()->add_required_features(v1::FEATURE_DYNAMIC_HEIGHTFIELD);
  const Status lacking = MustNot(server.worlds(), &Worlds::CreateWorld, request);
  EXPECT_EQ(lacking.code(), absl::StatusCode::kUnimplemented) << lacking.ToString();

  request.mutable_world()->set_required_features(0, v1::FEATURE_CONTACTS);
  Must(server.worlds(), &Worlds::CreateWorld, request);
}

TEST(CreateWorld, MakesNoMoreThanTheServerHosts) {
  TestServer server(ServerOptions{.worlds_max = 2});
  server.CreateWorld(WorldNamed("worlds/a"));
  server.CreateWorld(WorldNamed("worlds/b"));

  ExpectRefusal(MustNot(server.worlds(), &Worlds::CreateWorld, v1::CreateWorldRequest()), Reason::kLimitExceeded, "");
  v1::DeleteWorldRequest request;
  request.set_name("worlds/a");
  Must(server.worlds(), &Worlds::DeleteWorld, request);
  Must(server.worlds(), &Worlds::CreateWorld, v1::CreateWorldRequest());
}

TEST(CreateWorld, PutsAStateHashIntoEveryStampWhenAsked) {
  TestServer server;
  v1::World world;
  world.set_record_state_hash(true);

  const auto created = server.CreateWorld(world);
  server.AddBall(created.world().name(), 2);
  const auto first = server.Step(created.world().name());
  const auto second = server.Step(created.world().name());

  EXPECT_TRUE(created.stamp().has_state_hash());
  EXPECT_NE(first.stamp().state_hash(), created.stamp().state_hash());
  EXPECT_NE(first.stamp().state_hash(), second.stamp().state_hash());
  EXPECT_FALSE(server.CreateWorld().stamp().has_state_hash());
}

TEST(ListWorlds, PagesThroughAllInOrderOfName) {
  TestServer server;
  for (const char* name : {"worlds/c", "worlds/a", "worlds/e", "worlds/b", "worlds/d"}) {
    server.CreateWorld(WorldNamed(name));
  }
  std::vector<std::string> names;
  v1::ListWorldsRequest request;
  request.set_page_size(2);

  int pages = 0;
  do {
    const auto page = Must(server.worlds(), &Worlds::ListWorlds, request);
    EXPECT_EQ(page.worlds_size(), page.stamps_size());
    for (const v1::World& world : page.worlds()) names.push_back(world.name());
    request.set_page_token(page.next_page_token());
    ++pages;
  } while (!request.page_token().empty());

  EXPECT_EQ(names, (std::vector<std::string>{"worlds/a", "worlds/b", "worlds/c", "worlds/d", "worlds/e"}));
  EXPECT_EQ(pages, 3);
}

TEST(ListWorlds, RefusesATokenThatItDidNotGive) {
  TestServer server;
  v1::ListWorldsRequest request;
  request.set_page_token("next, please");

  ExpectRefusal(MustNot(server.worlds(), &Worlds::ListWorlds, request), Reason::kInvalidValue, "page_token");
}

TEST(DeleteWorld, LeavesNothingToFind) {
  TestServer server;
  const std::string name = server.CreateWorld().world().name();
  server.Step(name, 3);
  v1::DeleteWorldRequest request;
  request.set_name(name);

  EXPECT_EQ(Must(server.worlds(), &Worlds::DeleteWorld, request).stamp().step(), 3u);

  ExpectRefusal(MustNot(server.worlds(), &Worlds::GetWorld, Named(name)), Reason::kWorldNotFound, "name");
  ExpectRefusal(MustNot(server.worlds(), &Worlds::DeleteWorld, request), Reason::kWorldNotFound, "name");
  v1::StepRequest step;
  step.set_world(name);
  ExpectRefusal(MustNot(server.simulation(), &v1::SimulationService::Stub::Step, step), Reason::kWorldNotFound,
                "world");
}

TEST(RequestsToAWorld, AreToldApartByWhatIsWrongWithTheName) {
  TestServer server;

  ExpectRefusal(MustNot(server.worlds(), &Worlds::GetWorld, Named("")), Reason::kMissingField, "name");
  ExpectRefusal(MustNot(server.worlds(), &Worlds::GetWorld, Named("planets/a")), Reason::kInvalidValue, "name");
  ExpectRefusal(MustNot(server.worlds(), &Worlds::GetWorld, Named("worlds/" + std::string(66, 'a'))),
                Reason::kOutOfRange, "name");
  ExpectRefusal(MustNot(server.worlds(), &Worlds::GetWorld, Named("worlds/" + std::string(65, 'a'))),
                Reason::kWorldNotFound, "name");
}

TEST(ResetWorld, TakesAWorldBackInANewEpoch) {
  TestServer server;
  const auto created = server.CreateWorld();
  const std::string name = created.world().name();
  const uint64_t ball = server.AddBall(name, 5);
  server.Step(name, 30);
  v1::ResetWorldRequest request;
  request.set_name(name);

  const auto reset = Must(server.worlds(), &Worlds::ResetWorld, request);

  EXPECT_EQ(reset.stamp().step(), 0u);
  EXPECT_NE(reset.stamp().epoch(), created.stamp().epoch());
  v1::GetEntityRequest get;
  get.set_world(name);
  get.set_entity_id(ball);
  const auto entity = Must(server.simulation(), &v1::SimulationService::Stub::GetEntity, get);
  EXPECT_EQ(entity.entity().pose().position().z(), 5);
}

TEST(ListEngines, NamesEveryEngineInOrderAndGetEngineKnowsEach) {
  TestServer server;
  const auto engines = Must(server.engines(), &v1::EngineService::Stub::ListEngines, v1::ListEnginesRequest());
  ASSERT_GT(engines.engines_size(), 0);
  EXPECT_TRUE(std::is_sorted(engines.engines().begin(), engines.engines().end(),
                             [](const auto& a, const auto& b) { return a.name() < b.name(); }));
  for (const v1::Engine& engine : engines.engines()) {
    EXPECT_GT(engine.features_size(), 0) << engine.name();
    v1::GetEngineRequest get;
    get.set_name(engine.name());
    const auto got = Must(server.engines(), &v1::EngineService::Stub::GetEngine, get);
    EXPECT_TRUE(MessageDifferencer::Equals(got.engine(), engine));
  }
  v1::GetEngineRequest none;
  none.set_name("engines/none");
  const Status refused = MustNot(server.engines(), &v1::EngineService::Stub::GetEngine, none);
  ExpectRefusal(refused, Reason::kInvalidValue, "name");
  for (const v1::Engine& engine : engines.engines()) {
    EXPECT_NE(refused.message().find(engine.name()), std::string::npos) << refused;
  }
}

TEST(ListEngines, PagesThroughAll) {
  TestServer server;
  const auto all = Must(server.engines(), &v1::EngineService::Stub::ListEngines, v1::ListEnginesRequest());
  v1::ListEnginesRequest request;
  request.set_page_size(1);
  v1::ListEnginesResponse gathered;
  do {
    const auto page = Must(server.engines(), &v1::EngineService::Stub::ListEngines, request);
    EXPECT_EQ(page.engines_size(), 1);
    gathered.mutable_engines()->MergeFrom(page.engines());
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty() && gathered.engines_size() <= all.engines_size());

  EXPECT_TRUE(MessageDifferencer::Equals(gathered, all));
  request.set_page_token("engines/none");
  ExpectRefusal(MustNot(server.engines(), &v1::EngineService::Stub::ListEngines, request), Reason::kInvalidValue,
                "page_token");
}

}  // namespace
}  // namespace genphys::testing

// What an engine that fails does to its world, and what it does not do to others.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <functional>
#include <future>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "genphys/backend.h"
#include "genphys/hosting/in_process_host.h"
#include "genphys/hosting/world_methods.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/work_watch.h"

namespace genphys {
namespace {

constexpr std::chrono::seconds kPatience{60};  // only what hangs meets it

enum class Failure { kNone, kFault, kNoMemory, kHang, kCutShort, kFaultInBody };

// Moves nothing, and fails in every step, or with every body, when told to.
class FlakyWorld final : public BackendWorld {
 public:
  explicit FlakyWorld(const std::atomic<Failure>& failure) : failure_(failure) {}
  void AddBody(const BodyDesc&, const StateArrays&) override {
    if (failure_ == Failure::kFaultInBody) throw EngineFault("on purpose");
  }
  void RemoveBody(EntityRow) override {}
  void SetActive(std::span<const EntityRow>, bool) override {}
  void WriteState(std::span<const EntityRow>, const StateArrays&) override {}
  void SetStepper(const StepperSettings&) override {}
  void FindPoints(GeometryRow, GeometryRow, std::vector<ContactPoint>&) override {}
  void Solve(double, std::span<const EntityRow>, StateArrays&, ContactBuffer&, std::span<JointRow>) override {
    if (failure_ == Failure::kFault) throw EngineFault("on purpose");
    if (failure_ == Failure::kNoMemory) throw std::bad_alloc();
    if (failure_ == Failure::kCutShort) throw CutShort(absl::CancelledError("enough"));
    if (failure_ == Failure::kHang) failure_.wait(Failure::kHang);
  }
  void SaveState(std::string&) const override {}

 private:
  const std::atomic<Failure>& failure_;
};

class FlakyBackend final : public Backend {
 public:
  FlakyBackend(const std::string& name, const std::atomic<Failure>& failure)
      : failure_(failure), capabilities_(name, "1", {Feature::kShapeSphere, Feature::kContacts, Feature::kRayCasts}) {}
  const Capabilities& capabilities() const override { return capabilities_; }
  StepperSettings Resolve(const StepperDesc&) const override { return {}; }
  std::unique_ptr<BackendWorld> CreateWorld(const StepperSettings&) const override {
    return std::make_unique<FlakyWorld>(failure_);
  }
  Status SelfTest() const override { return absl::OkStatus(); }

 private:
  const std::atomic<Failure>& failure_;
  const Capabilities capabilities_;
};

class Bench {
 public:
  Bench() {
    registry.Add(std::make_unique<FlakyBackend>("flaky", failure));
    registry.Add(std::make_unique<FlakyBackend>("steady", never));
  }

  std::shared_ptr<WorldHost> MakeWorldWithBall(const std::string& name, const std::string& engine = "flaky") {
    auto host = InProcessHost::Create(registry, pool, name, v1::World(), engine);
    EXPECT_TRUE(host.ok()) << host.status().ToString();
    AddBall(**host);
    return *host;
  }
  static void AddBall(WorldHost& host) { EXPECT_TRUE(TryToAddBall(host).ok()); }
  static Status TryToAddBall(WorldHost& host) {
    v1::CreateEntityRequest request;
    request.set_world("worlds/any");
    v1::RigidBody& body = *request.mutable_entity()->mutable_rigid_body();
    body.add_geometries()->mutable_shape()->mutable_sphere()->set_radius(1);
    // Who flies freely is no business of the engine.
    body.set_linear_speed_max(1e3);
    return Ask(host, WorldMethod::kCreateEntity, request).status();
  }
  static std::future<Result<EncodedMessage>> Send(WorldHost& host, WorldCall call) {
    auto promise = std::make_shared<std::promise<Result<EncodedMessage>>>();
    host.Handle(std::move(call), [promise](Result<EncodedMessage> reply) { promise->set_value(std::move(reply)); });
    return promise->get_future();
  }
  static Result<EncodedMessage> Ask(WorldHost& host, WorldMethod method, const google::protobuf::Message& request) {
    auto future = Send(host, {.method = method, .request = EncodeReply(request)});
    if (future.wait_for(kPatience) != std::future_status::ready) return absl::DeadlineExceededError("no reply came");
    return future.get();
  }
  // So many rays down the middle of the ball.
  static v1::CastRaysRequest Rays(size_t count) {
    v1::CastRaysRequest request;
    request.set_world("worlds/any");
    for (size_t i = 0; i < count; ++i) {
      for (const auto& [vector, column] : {std::pair(Vector3(0, 0, 5), request.mutable_origins()),
                                           {Vector3(0, 0, -10), request.mutable_translations()}}) {
        column->append(reinterpret_cast<const char*>(vector.data()), 3 * sizeof(double));
      }
    }
    return request;
  }
  static Status Step(WorldHost& host) { return Ask(host, WorldMethod::kStep, StepRequest()).status(); }
  // On a worker, however quick the last one was.
  static std::future<Result<EncodedMessage>> SendStep(WorldHost& host) {
    return Send(host, {.method = WorldMethod::kStep, .request = EncodeReply(StepRequest()), .here_below = {}});
  }
  static v1::StepRequest StepRequest() {
    v1::StepRequest request;
    request.set_world("worlds/any");
    return request;
  }
  static v1::GetWorldResponse Look(WorldHost& host) {
    v1::GetWorldRequest request;
    request.set_name("worlds/any");
    const Result<EncodedMessage> reply = Ask(host, WorldMethod::kGetWorld, request);
    v1::GetWorldResponse response;
    EXPECT_TRUE(reply.ok() && response.ParseFromString(Joined(*reply))) << reply.status();
    return response;
  }
  static v1::World::State StateOf(WorldHost& host) { return Look(host).world().state(); }

  std::atomic<Failure> failure = Failure::kNone;
  const std::atomic<Failure> never = Failure::kNone;
  BackendRegistry registry;
  WorkerPool pool{2};
};

// The thread on which the reply to a step is made.
std::thread::id ThreadOfStep(WorldHost& host, bool has_commands) {
  v1::StepRequest request;
  request.set_world("worlds/a");
  auto promise = std::make_shared<std::promise<std::thread::id>>();
  host.Handle({.method = WorldMethod::kStep, .request = EncodeReply(request), .has_commands = has_commands},
              [promise](const Result<EncodedMessage>&) { promise->set_value(std::this_thread::get_id()); });
  return promise->get_future().get();
}

TEST(InProcessHost, DoesQuickStepsWithoutCommandsOnTheThreadThatAsks) {
  // Whatever else the machine does, one step of a ball alone is quick, and one call finds the world at leisure: after
  // its reply the world still has to keep it, and who asks at once, each time, may find it busy each time.
  constexpr int kTries = 1000;
  constexpr std::chrono::milliseconds kLeisure(1);
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a", "steady");
  EXPECT_NE(ThreadOfStep(*host, false), std::this_thread::get_id()) << "nobody knows yet how long a step takes";

  bool was_here = false;
  for (int i = 0; i < kTries && !was_here; ++i) {
    std::this_thread::sleep_for(kLeisure);
    was_here = ThreadOfStep(*host, false) == std::this_thread::get_id();
  }

  EXPECT_TRUE(was_here);
  EXPECT_NE(ThreadOfStep(*host, true), std::this_thread::get_id()) << "a command may take any time";
}

class FailingEngine : public ::testing::TestWithParam<Failure> {};

TEST_P(FailingEngine, FaultsItsWorldWhichCanStillBeReadAndReset) {
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a");
  ASSERT_TRUE(Bench::Step(*host).ok());
  bench.failure = GetParam();

  const Status failed = Bench::Step(*host);
  EXPECT_EQ(failed.code(),
            GetParam() == Failure::kFault ? absl::StatusCode::kAborted : absl::StatusCode::kResourceExhausted)
      << failed.ToString();

  EXPECT_EQ(Bench::StateOf(*host), v1::World::STATE_FAULTED);
  EXPECT_EQ(RefusalOf(Bench::Step(*host))->reason, Reason::kWorldFaulted);
  v1::ResetWorldRequest reset;
  reset.set_name("worlds/a");
  bench.failure = Failure::kNone;
  EXPECT_TRUE(Bench::Ask(*host, WorldMethod::kResetWorld, reset).ok());
  EXPECT_EQ(Bench::StateOf(*host), v1::World::STATE_PAUSED);
  EXPECT_TRUE(Bench::Step(*host).ok());
}

// What a step undid is known in full; what an exception left half way is not.
TEST_P(FailingEngine, LeavesAWorldThatRaysFindAsItWas) {
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a");
  bench.failure = GetParam();
  EXPECT_FALSE(Bench::Step(*host).ok());

  const Result<EncodedMessage> reply = Bench::Ask(*host, WorldMethod::kCastRays, Bench::Rays(1));

  if (GetParam() == Failure::kNoMemory) {
    EXPECT_EQ(RefusalOf(reply.status()).value_or(Refusal{}).reason, Reason::kWorldFaulted) << reply.status();
    return;
  }
  ASSERT_TRUE(reply.ok()) << reply.status();
  v1::CastRaysResponse response;
  ASSERT_TRUE(response.ParseFromString(Joined(*reply)));
  double fraction = 0;
  ASSERT_EQ(response.fractions().size(), sizeof fraction);
  std::memcpy(&fraction, response.fractions().data(), sizeof fraction);
  EXPECT_NEAR(fraction, 0.4, 1e-12);
}

TEST_P(FailingEngine, StopsAWorldThatPlays) {
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a");
  v1::PlayWorldRequest play;
  play.set_name("worlds/a");
  play.set_real_time_factor(0);
  ASSERT_TRUE(Bench::Ask(*host, WorldMethod::kPlayWorld, play).ok());
  ASSERT_EQ(Bench::StateOf(*host), v1::World::STATE_PLAYING);

  bench.failure = GetParam();

  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  while (Bench::StateOf(*host) == v1::World::STATE_PLAYING) ASSERT_LT(std::chrono::steady_clock::now(), give_up);
  EXPECT_EQ(Bench::StateOf(*host), v1::World::STATE_FAULTED);
}

TEST_P(FailingEngine, DoesNotDisturbOtherWorlds) {
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a");
  const auto other = bench.MakeWorldWithBall("worlds/b", "steady");
  bench.failure = GetParam();

  EXPECT_FALSE(Bench::Step(*host).ok());

  EXPECT_TRUE(Bench::Step(*other).ok());
}

INSTANTIATE_TEST_SUITE_P(InEveryWay, FailingEngine, ::testing::Values(Failure::kFault, Failure::kNoMemory));

// Nobody comes back to a first step that was undone: what was changed since then is there before the one to come.
TEST(InProcessHost, ResetsToWhatIsThereWhileNoStepWasDone) {
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a");
  const auto list = [&] {
    v1::ListEntitiesRequest request;
    request.set_world("worlds/any");
    const Result<EncodedMessage> reply = Bench::Ask(*host, WorldMethod::kListEntities, request);
    v1::ListEntitiesResponse response;
    EXPECT_TRUE(reply.ok() && response.ParseFromString(Joined(*reply))) << reply.status();
    return response;
  };
  v1::ResetWorldRequest reset;
  reset.set_name("worlds/a");
  bench.failure = Failure::kCutShort;
  EXPECT_FALSE(Bench::Step(*host).ok());
  bench.failure = Failure::kNone;
  Bench::AddBall(*host);
  const v1::ListEntitiesResponse before = list();

  for (const int steps : {0, 3}) {
    for (int i = 0; i < steps; ++i) EXPECT_TRUE(Bench::Step(*host).ok());
    ASSERT_TRUE(Bench::Ask(*host, WorldMethod::kResetWorld, reset).ok());

    const v1::ListEntitiesResponse after = list();
    EXPECT_EQ(after.entities_size(), before.entities_size());
    EXPECT_EQ(after.last_sequence(), before.last_sequence()) << "after " << steps << " steps";
    EXPECT_EQ(after.stamp().step(), 0u);
  }
}

// There is no beginning yet to which its engine would be made anew.
TEST(InProcessHost, HasAnEngineAgainAfterAResetFromAFailureBeforeTheFirstStep) {
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a");
  v1::ResetWorldRequest reset;
  reset.set_name("worlds/a");
  bench.failure = Failure::kFaultInBody;

  EXPECT_EQ(RefusalOf(Bench::TryToAddBall(*host)).value_or(Refusal{}).reason, Reason::kDiverged);
  EXPECT_EQ(Bench::StateOf(*host), v1::World::STATE_FAULTED);
  const Status still_failing = Bench::Ask(*host, WorldMethod::kResetWorld, reset).status();
  EXPECT_EQ(RefusalOf(still_failing).value_or(Refusal{}).reason, Reason::kDiverged);
  EXPECT_EQ(Bench::StateOf(*host), v1::World::STATE_FAULTED) << "nothing could move it";

  bench.failure = Failure::kNone;
  EXPECT_TRUE(Bench::Ask(*host, WorldMethod::kResetWorld, reset).ok());
  EXPECT_EQ(Bench::StateOf(*host), v1::World::STATE_PAUSED);
  EXPECT_TRUE(Bench::Step(*host).ok());
  bench.failure = Failure::kFault;
  EXPECT_FALSE(Bench::Step(*host).ok()) << "no engine was asked";
}

// What comes along with a first step is of the episode, not of the beginning, unless no step comes of it.
TEST(InProcessHost, ResetsToBeforeWhatCameAlongWithTheFirstStep) {
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a");
  v1::StepRequest along;
  along.set_world("worlds/any");
  v1::CreateEntity& create = *along.add_commands()->mutable_create_entity();
  create.mutable_entity()->mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_sphere();
  create.mutable_entity()->mutable_rigid_body()->set_linear_speed_max(1e3);
  create.mutable_entity()->mutable_pose()->mutable_position()->set_z(50);
  const auto created = [&] {
    const Result<EncodedMessage> reply = Bench::Ask(*host, WorldMethod::kStep, along);
    v1::StepResponse response;
    if (!reply.ok() || !response.ParseFromString(Joined(*reply))) return uint64_t{0};
    return response.results(0).created_id();
  };
  v1::ResetWorldRequest reset;
  reset.set_name("worlds/a");

  const uint64_t first = created();
  ASSERT_NE(first, 0u);
  for (int episode = 0; episode < 2; ++episode) {
    ASSERT_TRUE(Bench::Ask(*host, WorldMethod::kResetWorld, reset).ok());
    EXPECT_EQ(created(), first) << "it was not there yet";
  }

  ASSERT_TRUE(Bench::Ask(*host, WorldMethod::kResetWorld, reset).ok());
  bench.failure = Failure::kCutShort;
  EXPECT_EQ(created(), 0u);
  bench.failure = Failure::kNone;
  EXPECT_TRUE(Bench::Step(*host).ok());
  ASSERT_TRUE(Bench::Ask(*host, WorldMethod::kResetWorld, reset).ok());
  EXPECT_GT(created(), first) << "without a step of its own it was there before the first one";
}

// The code with which a query ends that asks whether it is still wanted.
absl::StatusCode EndOfQuery(std::chrono::steady_clock::time_point deadline, std::function<bool()> is_cancelled) {
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a", "steady");
  auto promise = std::make_shared<std::promise<absl::StatusCode>>();
  host->Handle({.method = WorldMethod::kCastRays,
                .request = EncodeReply(Bench::Rays(1000)),
                .deadline = deadline,
                .is_cancelled = std::move(is_cancelled)},
               [promise](const Result<EncodedMessage>& reply) { promise->set_value(reply.status().code()); });
  return promise->get_future().get();
}

TEST(InProcessHost, EndsAQueryWhoseCallerIsGone) {
  std::atomic<int> asked = 0;
  const auto never = std::chrono::steady_clock::time_point::max();
  EXPECT_EQ(EndOfQuery(never, [&] { return ++asked == 5; }), absl::StatusCode::kCancelled);
  EXPECT_EQ(asked, 5);
  EXPECT_EQ(EndOfQuery(never, [&] { return false; }), absl::StatusCode::kOk);
}

TEST(InProcessHost, EndsAQueryAtItsDeadline) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
  std::atomic<int> asked = 0;
  const auto delay = [&] {
    if (++asked == 5) std::this_thread::sleep_until(deadline);
    return false;
  };
  EXPECT_EQ(EndOfQuery(deadline, delay), absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(asked, 5);
}

TEST(InProcessHost, TellsWhereItsWorldIsWhileEveryWorkerIsInAStep) {
  Bench bench;
  const auto steady = bench.MakeWorldWithBall("worlds/b", "steady");
  std::vector<std::shared_ptr<WorldHost>> busy;
  std::vector<std::future<Result<EncodedMessage>>> steps;
  for (unsigned i = 0; i < bench.pool.threads(); ++i) {
    busy.push_back(bench.MakeWorldWithBall("worlds/a"));
    EXPECT_TRUE(Bench::Step(*busy.back()).ok());
  }
  bench.failure = Failure::kHang;
  for (const auto& host : busy) steps.push_back(Bench::SendStep(*host));

  EXPECT_EQ(Bench::Look(*steady).stamp().step(), 0u);
  for (const auto& host : busy) EXPECT_EQ(Bench::Look(*host).stamp().step(), 1u);

  bench.failure = Failure::kNone;
  bench.failure.notify_all();
  for (auto& step : steps) EXPECT_TRUE(step.get().ok());
  for (const auto& host : busy) EXPECT_EQ(Bench::Look(*host).stamp().step(), 2u);
}

TEST(InProcessHost, TellsOfAWorldWhatWasLastChangedInIt) {
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a", "steady");
  v1::StepRequest request;
  request.set_world("worlds/a");
  request.set_steps(0);
  request.add_commands()->mutable_set_gravity()->mutable_gravity()->set_x(3);

  EXPECT_TRUE(Bench::Ask(*host, WorldMethod::kStep, request).ok());

  EXPECT_EQ(Bench::Look(*host).world().gravity().x(), 3);
}

TEST(InProcessHost, RefusesWhatAsksForItsWorldInAWrongWay) {
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a", "steady");
  v1::GetWorldRequest request;
  request.set_name("no world's");

  EXPECT_EQ(RefusalOf(Bench::Ask(*host, WorldMethod::kGetWorld, request).status()).value_or(Refusal{}).field, "name");
}

TEST(InProcessHost, AnswersWhatWaitsForADeletedWorld) {
  Bench bench;
  const auto host = bench.MakeWorldWithBall("worlds/a");
  v1::DeleteWorldRequest request;
  request.set_name("worlds/a");

  EXPECT_TRUE(Bench::Ask(*host, WorldMethod::kDeleteWorld, request).ok());

  EXPECT_EQ(RefusalOf(Bench::Step(*host))->reason, Reason::kWorldNotFound);
  EXPECT_EQ(RefusalOf(Bench::Ask(*host, WorldMethod::kDeleteWorld, request).status())->reason, Reason::kWorldNotFound);
}

}  // namespace
}  // namespace genphys

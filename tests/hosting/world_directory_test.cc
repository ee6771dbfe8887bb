#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "genphys/hosting/world_directory.h"
#include "genphys/hosting/world_methods.h"

namespace genphys {
namespace {

constexpr std::chrono::seconds kPatience{60};  // only what hangs meets it

// Answers everything with its own name.
class NamedHost final : public WorldHost {
 public:
  explicit NamedHost(std::string name) : name_(std::move(name)) {}
  void Handle(WorldCall, Reply reply) override {
    v1::GetWorldResponse response;
    response.mutable_world()->set_name(name_);
    reply(EncodedMessage{EncodeReply(response)});
  }
  size_t frame_bytes_max() const override { return 0; }
  std::shared_ptr<Subscription> Watch(WorldMethod, Bytes) override { return nullptr; }
  void Drain(Status why) override { drained_with = why; }

  Status drained_with;

 private:
  const std::string name_;
};

class Bench {
 public:
  explicit Bench(size_t worlds_max = 10)
      : directory(
            pool,
            [this](const std::string& name, const v1::World&) -> Result<std::shared_ptr<WorldHost>> {
              if (name == "worlds/bad") throw std::runtime_error("on purpose");
              if (name == "worlds/refused") return Refuse(Reason::kInvalidValue, "world.engine", "on purpose");
              hosts.push_back(std::make_shared<NamedHost>(name));
              return hosts.back();
            },
            worlds_max) {}

  Result<v1::GetWorldResponse> Create(const std::string& name) {
    v1::CreateWorldRequest request;
    request.mutable_world()->set_name(name);
    return Ask<v1::GetWorldResponse>([&](Reply reply) { directory.Create(EncodeReply(request), std::move(reply)); });
  }
  Result<v1::GetWorldResponse> Handle(WorldMethod method, const std::string& name) {
    v1::GetWorldRequest request;  // DeleteWorldRequest has the same field
    request.set_name(name);
    return Ask<v1::GetWorldResponse>(
        [&](Reply reply) { directory.Handle({.method = method, .request = EncodeReply(request)}, std::move(reply)); });
  }
  Result<v1::ListWorldsResponse> List() {
    return Ask<v1::ListWorldsResponse>(
        [&](const Reply& reply) { directory.List(EncodeReply(v1::ListWorldsRequest()), reply); });
  }

  WorkerPool pool{1};
  std::vector<std::shared_ptr<NamedHost>> hosts;
  WorldDirectory directory;

 private:
  template <typename Response, typename Call>
  Result<Response> Ask(const Call& call) {
    auto promise = std::make_shared<std::promise<Result<EncodedMessage>>>();
    call([promise](Result<EncodedMessage> reply) { promise->set_value(std::move(reply)); });
    auto future = promise->get_future();
    if (future.wait_for(kPatience) != std::future_status::ready) return absl::DeadlineExceededError("no reply came");
    const Result<EncodedMessage> reply = future.get();
    if (!reply.ok()) return reply.status();
    Response response;
    EXPECT_TRUE(response.ParseFromString(Joined(*reply)));
    return response;
  }
};

Reason ReasonOf(const Result<v1::GetWorldResponse>& reply) {
  const auto refusal = RefusalOf(reply.status());
  return refusal ? refusal->reason : Reason::kUnspecified;
}

TEST(WorldDirectory, HandsARequestToTheWorldThatItNames) {
  Bench bench;
  ASSERT_TRUE(bench.Create("worlds/a").ok());
  ASSERT_TRUE(bench.Create("worlds/b").ok());

  EXPECT_EQ(bench.Handle(WorldMethod::kGetWorld, "worlds/b")->world().name(), "worlds/b");
  EXPECT_EQ(ReasonOf(bench.Handle(WorldMethod::kGetWorld, "worlds/c")), Reason::kWorldNotFound);
}

TEST(WorldDirectory, ForgetsTheNameOfADeletedWorldAtOnce) {
  Bench bench;
  ASSERT_TRUE(bench.Create("worlds/a").ok());

  EXPECT_TRUE(bench.Handle(WorldMethod::kDeleteWorld, "worlds/a").ok());

  EXPECT_EQ(ReasonOf(bench.Handle(WorldMethod::kDeleteWorld, "worlds/a")), Reason::kWorldNotFound);
  EXPECT_TRUE(bench.Create("worlds/a").ok());
}

TEST(WorldDirectory, ListsItsWorldsWhileEveryWorkerIsBusy) {
  Bench bench;
  ASSERT_TRUE(bench.Create("worlds/a").ok());
  std::promise<void> release;
  bench.pool.Post([released = release.get_future().share()] { released.wait(); });

  const Result<v1::ListWorldsResponse> worlds = bench.List();

  release.set_value();
  ASSERT_TRUE(worlds.ok()) << worlds.status();
  ASSERT_EQ(worlds->worlds_size(), 1);
  EXPECT_EQ(worlds->worlds(0).name(), "worlds/a");
}

TEST(WorldDirectory, FreesTheNameOfAWorldThatCannotBeMade) {
  Bench bench(1);

  EXPECT_EQ(bench.Create("worlds/bad").status().code(), absl::StatusCode::kInternal);
  EXPECT_EQ(bench.Create("worlds/bad").status().code(), absl::StatusCode::kInternal);
  EXPECT_EQ(ReasonOf(bench.Create("worlds/refused")), Reason::kInvalidValue);

  // There is room for one, and it is not taken.
  EXPECT_TRUE(bench.Create("worlds/a").ok());
  EXPECT_EQ(ReasonOf(bench.Create("worlds/b")), Reason::kLimitExceeded);
}

TEST(WorldDirectory, RefusesEverythingOnceItDrains) {
  Bench bench;
  ASSERT_TRUE(bench.Create("worlds/a").ok());

  bench.directory.Drain();

  EXPECT_EQ(ReasonOf(bench.Create("worlds/b")), Reason::kDraining);
  EXPECT_EQ(ReasonOf(bench.Handle(WorldMethod::kGetWorld, "worlds/a")), Reason::kDraining);
  std::promise<Status> listed, watched;
  bench.directory.List({}, [&](const Result<EncodedMessage>& reply) { listed.set_value(reply.status()); });
  EXPECT_EQ(RefusalOf(listed.get_future().get())->reason, Reason::kDraining);
  const auto stream = bench.directory.Watch(WorldMethod::kWatchEvents, {});
  stream->Next([&](const Delivery& delivery) { watched.set_value(delivery.end); });
  EXPECT_EQ(RefusalOf(watched.get_future().get())->reason, Reason::kDraining);
  EXPECT_EQ(RefusalOf(bench.hosts.front()->drained_with)->reason, Reason::kDraining);
}

}  // namespace
}  // namespace genphys

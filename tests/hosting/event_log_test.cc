#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "genphys/hosting/event_log.h"
#include "genphys/surface.h"
#include "genphys/v1/simulation_service.pb.h"
#include "support/shapes.h"

namespace genphys {
namespace {

constexpr std::chrono::seconds kPatience{60};  // only what hangs meets it
constexpr uint64_t kEpoch = 11;

const EntityId kFloor(0, 1), kBall(1, 1), kCrate(2, 1);

// A log that is fed step by step, and numbers its events.
class Feed {
 public:
  explicit Feed(EventLog::Bounds bounds) : log(std::make_shared<EventLog>(pool, Stamp{0, 0, kEpoch, {}}, bounds)) {}

  void Add(std::vector<EventKind> kinds) {
    ++step;
    std::vector<Event> events;
    for (EventKind& kind : kinds) events.push_back({++sequence, step, std::move(kind)});
    const Stamp now{step, 0.1 * static_cast<double>(step), epoch, {}};
    log->Append(now, events.empty() ? nullptr : std::make_shared<const EventChunk>(now, std::move(events)));
  }
  void AddMany(int count) {
    for (int i = 0; i < count; ++i) Add({EntitySlept{kBall}});
  }
  void Restart(uint64_t new_epoch, uint64_t sequence_then) {
    epoch = new_epoch;
    sequence = sequence_then;
    step = 0;
    log->Restart({0, 0, epoch, {}});
  }

  static constexpr int kWorkers = 2;

  WorkerPool pool{kWorkers};
  std::shared_ptr<EventLog> log;
  uint64_t epoch = kEpoch;
  uint64_t sequence = 0;
  uint64_t step = 0;
};

// Keeps the workers of a feed from doing anything until it ends.
class BusyWorkers {
 public:
  explicit BusyWorkers(Feed& feed) {
    for (int i = 0; i < Feed::kWorkers; ++i) {
      const auto begun = std::make_shared<std::promise<void>>();
      feed.pool.Post([begun, ended = ended_] {
        begun->set_value();
        ended.wait();
      });
      begun->get_future().wait();
    }
  }
  ~BusyWorkers() { end_.set_value(); }

 private:
  std::promise<void> end_;
  std::shared_future<void> ended_ = end_.get_future().share();
};

v1::WatchEventsRequest From(std::optional<uint64_t> epoch, std::optional<uint64_t> after) {
  v1::WatchEventsRequest request;
  request.set_world("worlds/w");
  if (epoch) request.set_epoch(*epoch);
  if (after) request.set_after_sequence(*after);
  return request;
}

class Reader {
 public:
  Reader(Feed& feed, const v1::WatchEventsRequest& request)
      : subscription_(feed.log->Watch(MakeBytes(request.SerializeAsString()))) {}
  ~Reader() { subscription_->Cancel(); }

  // Asks for a message that is read later.
  std::future<Delivery> Ask() {
    const auto promise = std::make_shared<std::promise<Delivery>>();
    subscription_->Next([promise](Delivery delivery) { promise->set_value(std::move(delivery)); });
    return promise->get_future();
  }
  static Delivery Wait(std::future<Delivery> future) {
    if (future.wait_for(kPatience) == std::future_status::ready) return future.get();
    ADD_FAILURE() << "no message came";
    return {};
  }
  static v1::WatchEventsResponse Decode(const Delivery& delivery) {
    v1::WatchEventsResponse response;
    EXPECT_TRUE(delivery.message) << delivery.end.ToString();
    std::string bytes;
    for (const Bytes& piece : delivery.message.value_or(EncodedMessage())) bytes += piece.view;
    EXPECT_TRUE(response.ParseFromString(bytes));
    return response;
  }
  v1::WatchEventsResponse Next() { return Decode(Wait(Ask())); }
  Status End() {
    const Delivery delivery = Wait(Ask());
    EXPECT_FALSE(delivery.message);
    return delivery.end;
  }
  Subscription& subscription() { return *subscription_; }

 private:
  std::shared_ptr<Subscription> subscription_;
};

void ExpectRange(const v1::WatchEventsResponse& response, uint64_t first, uint64_t last) {
  EXPECT_FALSE(response.has_gap());
  EXPECT_EQ(response.batch().first_sequence(), first);
  EXPECT_EQ(response.batch().last_sequence(), last);
  EXPECT_EQ(response.batch().events_size(), static_cast<int>(last + 1 - first));
}

void ExpectGap(const v1::WatchEventsResponse& response, uint64_t first, uint64_t last) {
  EXPECT_TRUE(response.has_gap());
  EXPECT_EQ(response.gap().first_sequence(), first);
  EXPECT_EQ(response.gap().last_sequence(), last);
}

TEST(EventLog, GivesEverySubscriberEveryEventInOrder) {
  Feed feed({});
  Reader reader(feed, From({}, {}));
  ExpectRange(reader.Next(), 1, 0);

  feed.Add({EntityCreated{kBall, std::make_shared<const EntityDesc>()}, EntitySlept{kBall}});
  feed.Add({});
  feed.Add({EntityWoke{kBall}});

  uint64_t next = 1;
  while (next <= 3) {
    const auto response = reader.Next();
    EXPECT_EQ(response.batch().first_sequence(), next);
    for (const v1::Event& event : response.batch().events()) EXPECT_EQ(event.sequence(), next++);
  }
}

TEST(EventLog, StampsABatchWithItsLastEvent) {
  Feed feed({});
  feed.AddMany(3);
  feed.Add({});

  const auto response = Reader(feed, From({}, 0)).Next();

  EXPECT_EQ(response.stamp().step(), 3u);
  EXPECT_EQ(response.stamp().epoch(), kEpoch);
}

TEST(EventLog, TellsTheExactRangeThatItForgot) {
  Feed feed({.events = 4, .bytes = 1 << 20});
  feed.AddMany(10);
  Reader reader(feed, From(kEpoch, 2));

  const auto gap = reader.Next();
  ExpectGap(gap, 3, 6);
  EXPECT_EQ(gap.stamp().step(), 6u);
  ExpectRange(reader.Next(), 7, 6);  // nobody touches
  ExpectRange(reader.Next(), 7, 10);
}

TEST(EventLog, ForgetsNothingWithinItsBounds) {
  Feed feed({.events = 10, .bytes = 1 << 20});
  feed.AddMany(10);

  ExpectRange(Reader(feed, From(kEpoch, 0)).Next(), 1, 10);
  feed.AddMany(1);
  ExpectGap(Reader(feed, From(kEpoch, 0)).Next(), 1, 1);
}

TEST(EventLog, IsBoundedInBytesToo) {
  Feed feed({.events = 1000, .bytes = 2 * sizeof(Event)});
  feed.AddMany(3);

  ExpectGap(Reader(feed, From(kEpoch, 0)).Next(), 1, 1);
}

TEST(EventLog, CountsTheMeshesThatItsEventsKeep) {
  EntityDesc ground;
  ground.rigid_body =
      RigidBody{.motion_type = MotionType::kStatic, .geometries = {Geometry{.shape = testing::GroundMesh(1, 50)}}};
  const size_t mesh = DataBytesOf(ground.rigid_body->geometries[0].shape);
  Feed feed({.events = 1000, .bytes = 2 * mesh});
  for (int i = 0; i < 3; ++i) feed.Add({EntityCreated{kCrate, std::make_shared<const EntityDesc>(ground)}});

  ExpectGap(Reader(feed, From(kEpoch, 0)).Next(), 1, 2);
}

TEST(EventLog, TellsWhoTouchesAfterAGap) {
  Feed feed({.events = 1, .bytes = 1 << 20});
  feed.Add({ContactBegan{{kFloor, kBall}, {}}});
  feed.Add({ContactBegan{{kFloor, kCrate}, {}}});
  feed.Add({SensorEntered{kCrate, kBall}});
  feed.Add({ContactEnded{{kFloor, kBall}}});
  feed.Add({ContactBegan{{kBall, kCrate}, {}}});
  Reader reader(feed, From(kEpoch, 0));

  ExpectGap(reader.Next(), 1, 4);
  const auto touching = reader.Next();

  ASSERT_EQ(touching.batch().events_size(), 2);
  EXPECT_EQ(touching.batch().events(0).contact_persisted().entity_b(), kCrate.packed());
  EXPECT_EQ(touching.batch().events(0).sequence(), 0u);
  EXPECT_EQ(touching.batch().events(1).sensor_entered().visitor_entity(), kBall.packed());
  ExpectRange(reader.Next(), 5, 5);
}

TEST(EventLog, TellsOnlyThoseWhoTouchWhomTheFilterNames) {
  Feed feed({.events = 1, .bytes = 1 << 20});
  feed.Add({ContactBegan{{kFloor, kBall}, {}}});
  feed.Add({ContactBegan{{kFloor, kCrate}, {}}});
  feed.AddMany(1);
  v1::WatchEventsRequest request = From(kEpoch, 0);
  request.mutable_filter()->mutable_kinds()->set_contacts(true);
  request.mutable_filter()->add_entity_ids(kCrate.packed());
  Reader reader(feed, request);

  ExpectGap(reader.Next(), 1, 2);
  const auto touching = reader.Next();

  ASSERT_EQ(touching.batch().events_size(), 1);
  EXPECT_EQ(touching.batch().events(0).contact_persisted().entity_b(), kCrate.packed());
}

TEST(EventLog, LetsASlowSubscriberLoseWhatItMustAndNothingElse) {
  Feed feed({.events = 3, .bytes = 1 << 20});
  Reader reader(feed, From({}, {}));
  reader.Next();

  feed.AddMany(20);  // nobody asks meanwhile

  ExpectGap(reader.Next(), 1, 17);
  reader.Next();
  ExpectRange(reader.Next(), 18, 20);
}

TEST(EventLog, EndsABatchBeforeItGrowsTooLarge) {
  constexpr size_t kVisualBytes = 400'000;
  Feed feed({});
  EntityDesc desc;
  desc.visual = Visual{"", "", std::string(kVisualBytes, 'x')};
  const auto entity = std::make_shared<const EntityDesc>(desc);
  feed.Add(std::vector<EventKind>(7, EntityCreated{kBall, entity}));
  Reader reader(feed, From(kEpoch, 0));

  ExpectRange(reader.Next(), 1, 3);
  ExpectRange(reader.Next(), 4, 6);
  ExpectRange(reader.Next(), 7, 7);
}

TEST(EventLog, GoesOnInTheNextEpochWithWhatHappensAgain) {
  Feed feed({});
  feed.AddMany(2);
  feed.log->MarkBeginning();
  Reader reader(feed, From({}, {}));
  reader.Next();
  feed.AddMany(3);
  ExpectRange(reader.Next(), 3, 5);

  feed.Restart(22, 2);

  const auto again = reader.Next();
  EXPECT_EQ(again.stamp().epoch(), 22u);
  ExpectRange(again, 1, 2);
  feed.AddMany(1);
  ExpectRange(reader.Next(), 3, 3);
}

TEST(EventLog, TellsWhatOfAnEpochIsLostWhenItEnds) {
  Feed feed({});
  Reader reader(feed, From({}, {}));
  reader.Next();
  feed.log->MarkBeginning();
  feed.AddMany(4);

  feed.Restart(22, 0);

  const auto gap = reader.Next();
  ExpectGap(gap, 1, 4);
  EXPECT_EQ(gap.stamp().epoch(), kEpoch);
  const auto first = reader.Next();
  ExpectRange(first, 1, 0);
  EXPECT_EQ(first.stamp().epoch(), 22u);
}

TEST(EventLog, TellsWhatOfAnEpochIsLostThatEndsBeforeAWorkerIsThere) {
  Feed feed({});
  Reader reader(feed, From({}, {}));
  reader.Next();
  feed.AddMany(1);
  ExpectRange(reader.Next(), 1, 1);
  feed.log->MarkBeginning();
  auto waiting = reader.Ask();
  {
    const BusyWorkers busy(feed);
    feed.AddMany(3);  // a worker is called for these, and comes when they are gone
    feed.Restart(22, 1);
    feed.AddMany(5);
  }

  const auto gap = Reader::Decode(Reader::Wait(std::move(waiting)));
  ExpectGap(gap, 2, 4);
  EXPECT_EQ(gap.stamp().epoch(), kEpoch);
  const auto again = reader.Next();
  EXPECT_EQ(again.stamp().epoch(), 22u);
  ExpectRange(again, 1, 6);
  feed.AddMany(1);
  ExpectRange(reader.Next(), 7, 7);
}

// The same from beside: whenever epochs end, every number of each is told once, as an event or as lost.
TEST(EventLog, TellsEveryNumberOfEveryEpochOnceWheneverTheyEnd) {
  constexpr uint64_t kEpochs = 300, kEvents = 8, kMarked = 2;
  Feed feed({});
  feed.AddMany(kMarked);
  feed.log->MarkBeginning();
  Reader reader(feed, From(kEpoch, 0));
  ExpectRange(reader.Next(), 1, kMarked);
  const std::jthread writer([&] {
    for (uint64_t epoch = 1; epoch <= kEpochs; ++epoch) {
      feed.AddMany(kEvents);
      if (epoch % 3 == 0) std::this_thread::yield();
      feed.Restart(kEpoch + epoch, kMarked);
      feed.log->MarkBeginning();
    }
  });

  uint64_t epoch = kEpoch, next = kMarked + 1;
  while (epoch < kEpoch + kEpochs || next <= kMarked) {
    const auto response = reader.Next();
    ASSERT_GE(response.stamp().epoch(), epoch);
    if (response.stamp().epoch() > epoch) {
      ASSERT_EQ(next, kMarked + kEvents + 1) << "the end of epoch " << epoch << " was not told";
      epoch = response.stamp().epoch();
      next = 1;
    }
    ASSERT_EQ(response.has_gap() ? response.gap().first_sequence() : response.batch().first_sequence(), next);
    next = 1 + (response.has_gap() ? response.gap().last_sequence() : response.batch().last_sequence());
  }
}

TEST(EventLog, TellsALateSubscriberOfTheEpochBefore) {
  Feed feed({});
  feed.AddMany(1);
  feed.log->MarkBeginning();
  feed.AddMany(5);
  feed.Restart(22, 1);

  Reader reader(feed, From(kEpoch, 4));
  const auto gap = reader.Next();
  ExpectGap(gap, 5, 6);
  EXPECT_EQ(gap.stamp().epoch(), kEpoch);
  ExpectRange(reader.Next(), 1, 1);

  // One that had it all, and one of whose epoch nothing is known, are only told the present one.
  ExpectRange(Reader(feed, From(kEpoch, 6)).Next(), 1, 1);
  ExpectRange(Reader(feed, From(77, 3)).Next(), 1, 1);
}

TEST(EventLog, RefusesANumberBeyondTheLast) {
  Feed feed({});
  feed.AddMany(3);

  const Status refused = Reader(feed, From(kEpoch, 4)).End();
  ASSERT_TRUE(RefusalOf(refused)) << refused.ToString();
  EXPECT_EQ(RefusalOf(refused)->reason, Reason::kOutOfRange);
  EXPECT_EQ(RefusalOf(refused)->field, "after_sequence");
  ExpectRange(Reader(feed, From(kEpoch, 3)).Next(), 4, 3);
}

TEST(EventLog, RefusesBytesThatAreNoRequest) {
  Feed feed({});
  const auto subscription = feed.log->Watch(MakeBytes("\x0a\x7f"));
  std::promise<Status> end;
  subscription->Next([&](const Delivery& delivery) { end.set_value(delivery.end); });

  EXPECT_EQ(end.get_future().get().code(), absl::StatusCode::kInvalidArgument);
}

TEST(EventLog, DeliversWhatIsThereBeforeItEnds) {
  Feed feed({});
  Reader reader(feed, From({}, {}));
  reader.Next();
  feed.AddMany(2);
  feed.log->End(Refuse(Reason::kDraining, "", "over"));

  ExpectRange(reader.Next(), 1, 2);
  EXPECT_EQ(RefusalOf(reader.End())->reason, Reason::kDraining);

  // Whoever comes later is told where it ended.
  Reader late(feed, From({}, {}));
  ExpectRange(late.Next(), 3, 2);
  EXPECT_EQ(RefusalOf(late.End())->reason, Reason::kDraining);
}

TEST(EventLog, AnswersAWaitingSubscriberThatGoes) {
  Feed feed({});
  Reader reader(feed, From({}, {}));
  reader.Next();
  auto waiting = reader.Ask();

  reader.subscription().Cancel();

  EXPECT_EQ(Reader::Wait(std::move(waiting)).end.code(), absl::StatusCode::kCancelled);
}

TEST(EventLog, TellsWithinASecondHowFarAFilterThatLetsNothingThroughHasCome) {
  Feed feed({});
  v1::WatchEventsRequest request = From({}, {});
  request.mutable_filter()->mutable_kinds()->set_contacts(true);
  Reader reader(feed, request);
  ExpectRange(reader.Next(), 1, 0);
  auto waiting = reader.Ask();

  feed.AddMany(5);

  const auto bookmark = Reader::Decode(Reader::Wait(std::move(waiting)));
  EXPECT_EQ(bookmark.batch().events_size(), 0);
  EXPECT_EQ(bookmark.batch().last_sequence(), 5u);
}

}  // namespace
}  // namespace genphys

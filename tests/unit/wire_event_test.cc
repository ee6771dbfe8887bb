#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"
#include "genphys/wire/filter.h"
#include "wire_round_trip.h"

namespace genphys {
namespace {

std::vector<std::string> Kinds() {
  std::vector<std::string> kinds;
  const google::protobuf::OneofDescriptor* kind = v1::Event::descriptor()->FindOneofByName("kind");
  for (int i = 0; i < kind->field_count(); ++i) kinds.push_back(kind->field(i)->name());
  return kinds;
}

v1::Event Filled(const std::string& kind) {
  v1::Event event;
  FillEveryField(&event, {{"genphys.v1.Event.kind", kind}});
  if (event.has_entity_created()) *event.mutable_entity_created()->mutable_entity() = FilledEntity();
  if (event.has_entity_updated()) {
    *event.mutable_entity_updated()->mutable_entity() = FilledEntity();
    event.mutable_entity_updated()->mutable_changed()->Clear();
    event.mutable_entity_updated()->mutable_changed()->add_paths("pose");
    event.mutable_entity_updated()->mutable_changed()->add_paths("rigid_body.inertia");
  }
  if (event.has_joint_updated()) {
    event.mutable_joint_updated()->mutable_changed()->Clear();
    event.mutable_joint_updated()->mutable_changed()->add_paths("break_force");
    event.mutable_joint_updated()->mutable_changed()->add_paths("ball");
  }
  return event;
}

class EveryEvent : public testing::TestWithParam<std::string> {};

TEST_P(EveryEvent, TravelsWithAllItsFields) {
  const v1::Event sent = Filled(GetParam());

  const Result<Event> event = DecodeEvent(sent);

  ASSERT_TRUE(event.ok()) << event.status();
  v1::Event returned;
  EncodeEvent(*event, &returned);
  EXPECT_TRUE(SameMessage(sent, returned));
}

INSTANTIATE_TEST_SUITE_P(WireEvent, EveryEvent, testing::ValuesIn(Kinds()),
                         [](const auto& named) { return named.param; });

TEST(WireEvent, LeavesContactPointsOutOnRequest) {
  for (const char* kind : {"contact_began", "contact_persisted"}) {
    const Result<Event> event = DecodeEvent(Filled(kind));
    ASSERT_TRUE(event.ok()) << event.status();

    v1::Event returned;
    EncodeEvent(*event, &returned, /*contact_points=*/false);

    EXPECT_EQ(returned.contact_began().points_size() + returned.contact_persisted().points_size(), 0) << kind;
    EXPECT_EQ(returned.kind_case(), Filled(kind).kind_case());
  }
}

const EntityId kBall(1, 1);
const EntityId kCrate(2, 1);
const EntityId kOther(3, 1);

// One event of each kind, each of which names the ball; those of two entities name the crate too.
const std::vector<EventKind> kOneOfEach{EntityCreated{kBall, std::make_shared<const EntityDesc>()},
                                        EntityUpdated{kBall, std::make_shared<const EntityDesc>(), {}},
                                        EntityDeleted{kBall},
                                        ContactBegan{{kBall, kCrate}, {}},
                                        ContactPersisted{{kBall, kCrate}, {}},
                                        ContactEnded{{kBall, kCrate}},
                                        SensorEntered{kCrate, kBall},
                                        SensorLeft{kCrate, kBall},
                                        EntityWoke{kBall},
                                        EntitySlept{kBall},
                                        EntityStartedMoving{kBall, false},
                                        EntityStoppedMoving{kBall, true},
                                        EntityFaulted{kBall},
                                        JointBroke{JointId(4, 1), {EntityId(), kBall}, 5, 6},
                                        JointCreated{JointId(4, 1), {kBall, kCrate}, nullptr},
                                        JointUpdated{JointId(4, 1), {kBall, kCrate}, nullptr, {}},
                                        JointDeleted{JointId(4, 1), {EntityId(), kBall}},
                                        ForceFieldCreated{5, {kBall, kCrate}, nullptr},
                                        ForceFieldUpdated{5, {kBall, kCrate}, nullptr},
                                        ForceFieldDeleted{5, {kBall, EntityId()}}};

std::vector<size_t> Matching(const EventFilter& filter) {
  std::vector<size_t> matching;
  for (const EventKind& kind : kOneOfEach) {
    if (filter.Matches({1, 1, kind})) matching.push_back(kind.index());
  }
  return matching;
}

template <typename... Kinds>
std::vector<size_t> IndicesOf() {
  std::vector<size_t> indices;
  for (const EventKind& kind : kOneOfEach) {
    if ((std::holds_alternative<Kinds>(kind) || ...)) indices.push_back(kind.index());
  }
  return indices;
}

TEST(WireFilter, LetsEveryKindThroughWhenNoneIsNamed) {
  ASSERT_EQ(kOneOfEach.size(), std::variant_size_v<EventKind>);

  EXPECT_EQ(Matching(EventFilter()).size(), kOneOfEach.size());
  EXPECT_EQ(Matching(EventFilter(v1::EventFilter())).size(), kOneOfEach.size());
  EXPECT_TRUE(EventFilter(v1::EventFilter()).contact_points());
}

TEST(WireFilter, LetsThroughTheKindsThatAreNamedAndNoOthers) {
  const auto only = [](auto set) {
    v1::EventFilter filter;
    set(filter.mutable_kinds());
    return Matching(EventFilter(filter));
  };

  EXPECT_EQ(only([](v1::EventKinds*) {}), std::vector<size_t>());
  EXPECT_EQ(only([](v1::EventKinds* k) { k->set_contacts(true); }), (IndicesOf<ContactBegan, ContactEnded>()));
  EXPECT_EQ(only([](v1::EventKinds* k) { k->set_persisting_contacts(true); }), IndicesOf<ContactPersisted>());
  EXPECT_EQ(only([](v1::EventKinds* k) { k->set_contact_points(true); }), std::vector<size_t>());
  EXPECT_EQ(only([](v1::EventKinds* k) { k->set_sensors(true); }), (IndicesOf<SensorEntered, SensorLeft>()));
  EXPECT_EQ(only([](v1::EventKinds* k) { k->set_sleeping(true); }), (IndicesOf<EntityWoke, EntitySlept>()));
  EXPECT_EQ(only([](v1::EventKinds* k) { k->set_moving(true); }),
            (IndicesOf<EntityStartedMoving, EntityStoppedMoving>()));
  EXPECT_EQ(only([](v1::EventKinds* k) { k->set_joints(true); }), IndicesOf<JointBroke>());
  EXPECT_EQ(only([](v1::EventKinds* k) { k->set_changes(true); }),
            (IndicesOf<EntityCreated, EntityUpdated, EntityDeleted, EntityFaulted, JointCreated, JointUpdated,
                       JointDeleted, ForceFieldCreated, ForceFieldUpdated, ForceFieldDeleted>()));
}

TEST(WireFilter, LetsThroughWhatNamesOneOfTheEntities) {
  v1::EventFilter filter;
  filter.add_entity_ids(kOther.packed());
  filter.add_entity_ids(kCrate.packed());

  EXPECT_EQ(Matching(EventFilter(filter)),
            (IndicesOf<ContactBegan, ContactPersisted, ContactEnded, SensorEntered, SensorLeft, JointCreated,
                       JointUpdated, ForceFieldCreated, ForceFieldUpdated>()));

  filter.add_entity_ids(kBall.packed());
  EXPECT_EQ(Matching(EventFilter(filter)).size(), kOneOfEach.size());
}

TEST(WireFilter, MatchesNothingForAnIdThatNamesNothing) {
  v1::EventFilter filter;
  filter.add_entity_ids(0);

  EXPECT_EQ(Matching(EventFilter(filter)), std::vector<size_t>());
}

}  // namespace
}  // namespace genphys

#include "genphys/contact_memory.h"

#include <gtest/gtest.h>

#include <vector>

namespace genphys {
namespace {

using Motion = ContactMemory::Motion;

const EntityId kFloor(0, 1), kBox(1, 1), kOther(2, 1);
const ContactMemory::Key kBoxOnFloor{kFloor, kBox, 1, 1}, kOtherOnFloor{kFloor, kOther, 1, 1};
constexpr double kInterval = 0.01;  // s
constexpr double kWeight = 2;       // N*s

std::vector<ContactPoint> PointAt(const Vector3& place) { return {{.position = place}}; }

// A solve of `keys`, each with one point at the origin that then passes on kWeight; what it started from.
std::vector<double> Solve(ContactMemory& memory, const std::vector<ContactMemory::Key>& keys,
                          const std::vector<EntityId>& resting = {}) {
  memory.Begin([&](EntityId id) {
    if (id == kFloor) return Motion::kNone;
    return std::ranges::count(resting, id) > 0 ? Motion::kResting : Motion::kMoving;
  });
  std::vector<double> starts;
  for (const ContactMemory::Key& key : keys) {
    memory.Add(key, Placement{}, kInterval, PointAt(Vector3::Zero()));
    PointImpulse& impulse = memory.pairs().back().impulses[0];
    starts.push_back(impulse.normal);
    impulse.normal = kWeight;
  }
  return starts;
}

TEST(ContactMemory, StartsFromNothingAndThenFromWhatHeld) {
  ContactMemory memory;
  EXPECT_EQ(Solve(memory, {kBoxOnFloor}), std::vector<double>{0});
  EXPECT_EQ(Solve(memory, {kBoxOnFloor}), std::vector<double>{kWeight});
}

TEST(ContactMemory, ScalesToTheTimeThatTheSolveIsFor) {
  ContactMemory memory;
  Solve(memory, {kBoxOnFloor});
  memory.Begin([](EntityId) { return Motion::kMoving; });
  memory.Add(kBoxOnFloor, Placement{}, kInterval / 2, PointAt(Vector3::Zero()));
  EXPECT_EQ(memory.pairs()[0].impulses[0].normal, kWeight / 2);
}

TEST(ContactMemory, KnowsAPointByItsPlaceInTheFrame) {
  for (const auto& [off, known] : {std::pair(0.019, true), std::pair(0.021, false)}) {
    ContactMemory memory;
    Solve(memory, {kBoxOnFloor});
    memory.Begin([](EntityId) { return Motion::kMoving; });
    const Placement moved{.position = {5, 0, 0}};
    memory.Add(kBoxOnFloor, moved, kInterval, PointAt({5 + off, 0, 0}));
    EXPECT_EQ(memory.pairs()[0].impulses[0].normal, known ? kWeight : 0) << off;
    // In all it is what held the pair, whichever points are left.
    EXPECT_EQ(memory.pairs()[0].load, kWeight) << off;
  }
}

TEST(ContactMemory, GivesAnOldPointToOneNewOneOnly) {
  ContactMemory memory;
  Solve(memory, {kBoxOnFloor});
  memory.Begin([](EntityId) { return Motion::kMoving; });
  const std::vector<ContactPoint> two{{.position = {0.001, 0, 0}}, {.position = {0.002, 0, 0}}};
  memory.Add(kBoxOnFloor, Placement{}, kInterval, two);
  EXPECT_EQ(memory.pairs()[0].impulses[0].normal, kWeight);
  EXPECT_EQ(memory.pairs()[0].impulses[1].normal, 0);
}

TEST(ContactMemory, LeavesAloneWhatIsAhead) {
  ContactMemory memory;
  Solve(memory, {kBoxOnFloor});
  memory.Begin([](EntityId) { return Motion::kMoving; });
  const std::vector<ContactPoint> ahead{{.is_ahead = true}};
  memory.Add(kBoxOnFloor, Placement{}, kInterval, ahead);
  EXPECT_EQ(memory.pairs()[0].impulses[0].normal, 0);
}

TEST(ContactMemory, ForgetsWhatIsNotMetAgainUnlessItSleeps) {
  ContactMemory memory;
  Solve(memory, {kBoxOnFloor, kOtherOnFloor});
  memory.SetActive(kOther, false);
  for (int i = 0; i < 3; ++i) Solve(memory, {}, {kOther});
  memory.SetActive(kOther, true);
  EXPECT_EQ(Solve(memory, {kBoxOnFloor, kOtherOnFloor}), (std::vector<double>{0, kWeight}));
}

TEST(ContactMemory, ForgetsWhatSleptWhenItIsRemoved) {
  ContactMemory kept, removed;
  std::string with, without;
  for (ContactMemory* memory : {&kept, &removed}) {
    Solve(*memory, {kOtherOnFloor});
    memory->SetActive(kOther, false);
    Solve(*memory, {}, {kOther});
  }
  removed.Remove(kOther);
  kept.Save(with);
  removed.Save(without);
  EXPECT_GT(with.size(), without.size());
}

// The step that puts somebody to sleep does so at its end, and the next list need not look at all of them.
TEST(ContactMemory, PutsAwayWhoSleepsBeforeTheNextList) {
  ContactMemory memory, later;
  for (ContactMemory* each : {&memory, &later}) {
    Solve(*each, {kBoxOnFloor, kOtherOnFloor});
    each->SetActive(kOther, false);
  }
  memory.PutAway([](EntityId id) {
    return id == kFloor ? Motion::kNone : id == kOther ? Motion::kResting : Motion::kMoving;
  });
  ASSERT_EQ(memory.pairs().size(), 1u);
  EXPECT_EQ(memory.pairs()[0].key, kBoxOnFloor);
  std::string bytes, as_later;
  memory.Save(bytes);
  later.Save(as_later);
  EXPECT_EQ(bytes, as_later);
  for (ContactMemory* each : {&memory, &later}) {
    each->SetActive(kOther, true);
    EXPECT_EQ(Solve(*each, {kBoxOnFloor, kOtherOnFloor}), (std::vector<double>{kWeight, kWeight}));
  }
}

// As of one whose shapes are replaced.
TEST(ContactMemory, KnowsNothingOfWhoComesBackWithTheSameId) {
  ContactMemory memory;
  Solve(memory, {kBoxOnFloor, kOtherOnFloor});
  memory.Remove(kBox);
  EXPECT_EQ(Solve(memory, {kBoxOnFloor, kOtherOnFloor}), (std::vector<double>{0, kWeight}));
}

TEST(ContactMemory, SavesNothingOfWhoWasRemoved) {
  ContactMemory memory, empty;
  std::string bytes, of_nothing;
  Solve(memory, {kBoxOnFloor});
  memory.Remove(kBox);
  memory.Save(bytes);
  empty.Save(of_nothing);
  EXPECT_EQ(bytes, of_nothing);
}

TEST(ContactMemory, KeepsWhoWasWokenAndSleepsAgain) {
  ContactMemory memory;
  Solve(memory, {kOtherOnFloor});
  memory.SetActive(kOther, false);
  Solve(memory, {}, {kOther});
  memory.SetActive(kOther, true);
  memory.SetActive(kOther, false);
  Solve(memory, {}, {kOther});
  memory.SetActive(kOther, true);
  EXPECT_EQ(Solve(memory, {kOtherOnFloor}), std::vector<double>{kWeight});
}

TEST(ContactMemory, TellsTheLoadBeforeTheLastSolve) {
  ContactMemory memory;
  Solve(memory, {kBoxOnFloor});
  Solve(memory, {kBoxOnFloor});
  ContactMemory again = memory.OfBefore();
  EXPECT_EQ(Solve(again, {kBoxOnFloor}), std::vector<double>{0});
  EXPECT_EQ(again.pairs()[0].load, kWeight);
}

// As when the engine is changed.
TEST(ContactMemory, KeepsWhoSleepsOfWhatAnotherEngineSolved) {
  ContactMemory memory;
  memory.SetActive(kOther, false);
  const std::vector<ContactPoint> solved{{.normal_impulse = kWeight}};
  memory.AddSolved(kOtherOnFloor, Placement{}, kInterval, PointAt(Vector3::Zero()), solved);
  Solve(memory, {}, {kOther});
  memory.SetActive(kOther, true);
  EXPECT_EQ(Solve(memory, {kOtherOnFloor}), std::vector<double>{kWeight});
}

TEST(ContactMemory, SharesOutWhatHeldThePointsOfAnotherEngine) {
  ContactMemory memory;
  const std::vector<ContactPoint> own{{.position = {-1, 0, 0}}, {.position = {1, 0, 0}}};
  const std::vector<ContactPoint> solved{{.position = {-0.9, 0, 0}, .normal_impulse = 1},
                                         {.position = {0.8, 0, 0}, .normal_impulse = 2},
                                         {.position = {0.9, 0, 0}, .normal_impulse = 3}};
  memory.AddSolved(kBoxOnFloor, Placement{}, kInterval, own, solved);
  EXPECT_EQ(memory.pairs()[0].impulses[0].normal, 1);
  EXPECT_EQ(memory.pairs()[0].impulses[1].normal, 5);
  memory.AddSolved(kOtherOnFloor, Placement{}, kInterval, {}, solved);
  EXPECT_EQ(memory.pairs().size(), 1u);
}

}  // namespace
}  // namespace genphys

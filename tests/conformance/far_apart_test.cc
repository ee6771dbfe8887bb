// What happens in one place goes on as if nothing happened elsewhere, to the last bit.
#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "conformance/engine_test.h"
#include "support/joints.h"
#include "support/random.h"
#include "support/random_scene.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(FarApart, Claim::kContacts, Claim::kBox);

constexpr double kAway = 20;   // m, from one place to the next
constexpr double kHeight = 8;  // m, of what hangs

using Scene = std::vector<EntityId> (*)(World& world, double x);

// Comes down on its edge and turns so fast that where it is deepest says little of when it met the floor.
std::vector<EntityId> TumblingDrum(World& world, double x) {
  EntityDesc drum = Body(Cylinder{0.2, 0.2}, {x, 0, 1.5});
  drum.pose.orientation = Eigen::AngleAxisd(0.4, Vector3(1, 0.3, 0.2).normalized());
  drum.rigid_body->linear_velocity = {1, 0.2, 0};
  drum.rigid_body->angular_velocity = {9, 30, 15};
  drum.rigid_body->geometries[0].material.restitution = 0.7;
  return {Add(world, drum)};
}

// Of crates that do not lie quite straight, so that it goes on settling for a while.
std::vector<EntityId> Tower(World& world, double x) {
  constexpr int kCrates = 12;
  std::vector<EntityId> tower;
  for (int i = 0; i < kCrates; ++i) {
    tower.push_back(Add(world, Crate({x + 0.01 * (i % 3), 0.01 * (i % 2), 0.5 + i})));
  }
  return tower;
}

// That falls, of more points than sweeps are many for.
std::vector<EntityId> Heap(World& world, double x) {
  constexpr int kRow = 3, kLayers = 8;
  Random random(5);
  std::vector<EntityId> heap;
  for (int i = 0; i < kRow * kRow * kLayers; ++i) {
    const int layer = i / (kRow * kRow), place = i % (kRow * kRow);
    const double aside = layer % 2 == 0 ? 0 : 0.4;
    EntityDesc crate = Crate({x + 1.3 * (place % kRow) + aside, 1.3 * (place / kRow) + aside, 0.55 + 1.1 * layer});
    crate.pose.orientation = Eigen::AngleAxisd(random.Uniform(-0.2, 0.2), Vector3::UnitZ());
    heap.push_back(Add(world, crate));
  }
  return heap;
}

// Of more rows of joints than are solved all at once; it hangs by one edge and swings.
std::vector<EntityId> Net(World& world, double x) {
  constexpr int kRow = 6;
  std::vector<EntityId> net;
  for (int i = 0; i < kRow * kRow; ++i) {
    const Vector3 place(x + i % kRow, i / kRow, kHeight);
    net.push_back(Add(world, Ball(place, 0.2)));
    if (i < kRow) Join(world, ToWorld(net.back(), BallJoint{}, {place}));
    if (i % kRow > 0) Join(world, Between(net[net.size() - 2], net.back(), BallJoint{}));
    if (i >= kRow) Join(world, Between(net[static_cast<size_t>(i - kRow)], net.back(), BallJoint{}));
  }
  return net;
}

// Of few rows, with a weight on it.
std::vector<EntityId> Chain(World& world, double x) {
  constexpr int kLinks = 5;
  std::vector<EntityId> chain;
  for (int i = 0; i < kLinks; ++i) {
    const Vector3 place(x + i, 0, kHeight);
    chain.push_back(Add(world, Ball(place, 0.2, i + 1 < kLinks ? 1 : 1000)));
    Join(world, i == 0 ? ToWorld(chain[0], BallJoint{}, {place - Vector3::UnitX()})
                       : Between(chain[static_cast<size_t>(i - 1)], chain.back(), BallJoint{}));
  }
  return chain;
}

// How the bodies of a scene move, by step.
struct Course {
  std::vector<Vector3> positions;  // m
  std::vector<Vector3> velocities;
  bool operator==(const Course&) const = default;
};

std::vector<EntityId> EntitiesIn(const World& world) {
  std::vector<EntityId> all;
  std::ranges::copy_if(world.state().ids, std::back_inserter(all), [](EntityId id) { return !id.is_null(); });
  return all;
}

Course CourseOf(const World& world, const std::vector<EntityId>& ids) {
  Course course;
  for (const EntityId id : ids) {
    course.positions.push_back(PositionOf(world, id));
    course.velocities.push_back(VelocityOf(world, id));
  }
  return course;
}

// In steps of 1/60 s, with `others` beside it that were there before and others that come after it.
std::vector<Course> CoursesOf(const std::string& engine, Scene scene, const std::vector<Scene>& others, int steps) {
  const auto world = testing::MakeWorld(WorldDesc{.engine = engine, .default_auto_disable = {.enabled = false}});
  const auto add_others = [&](double side) {
    double x = 0;
    for (const Scene other : others) other(*world, x += side * kAway);
  };
  add_others(-1);
  const std::vector<EntityId> ids = scene(*world, 0);
  add_others(1);
  std::vector<Course> courses;
  for (int step = 0; step < steps; ++step) {
    Steps(*world, 1);
    courses.push_back(CourseOf(*world, ids));
  }
  return courses;
}

void ExpectNoMatter(const std::string& engine, Scene scene, const std::vector<Scene>& others, int steps) {
  const std::vector<Course> alone = CoursesOf(engine, scene, {}, steps);
  const std::vector<Course> among = CoursesOf(engine, scene, others, steps);
  const auto first = std::ranges::mismatch(alone, among).in1;
  EXPECT_EQ(first, alone.end()) << "from step " << first - alone.begin() << " on";
}

TEST_P(FarApart, AreManyWhoHitTheFloorAtOnce) {
  Proves({Claim::kRestitution, Claim::kCylinder});
  ExpectNoMatter(GetParam(), TumblingDrum, std::vector<Scene>(6, TumblingDrum), 120);
}

TEST_P(FarApart, AreTowers) { ExpectNoMatter(GetParam(), Tower, std::vector<Scene>(3, Tower), 180); }

TEST_P(FarApart, IsAHeapFromATowerAndATowerFromAHeap) {
  ExpectNoMatter(GetParam(), Tower, {Heap, TumblingDrum}, 120);
  ExpectNoMatter(GetParam(), Heap, {Tower, Heap}, 120);
}

TEST_P(FarApart, IsWhatHangsFromWhatLies) {
  Proves({Claim::kJointBall});
  ExpectNoMatter(GetParam(), Chain, {Net, Tower, Chain}, 120);
  ExpectNoMatter(GetParam(), Net, {Net, Heap, Chain}, 120);
  ExpectNoMatter(GetParam(), Tower, {Net, Chain}, 120);
}

TEST_P(FarApart, AreOthersFromAnyScene) {
  constexpr int kScenes = 40, kSteps = 60;
  constexpr double kFar = 400;  // m
  for (uint64_t seed = 1; seed <= kScenes; ++seed) {
    const RandomScene alone = MakeRandomScene({GetParam()}, seed), among = MakeRandomScene({GetParam()}, seed);
    const std::vector<EntityId> ids = EntitiesIn(*alone.world);
    for (int i = 0; i < 10; ++i) TumblingDrum(*among.world, kFar + i);
    Tower(*among.world, kFar + kAway);
    Chain(*among.world, kFar + 2 * kAway);
    int step = 0;
    while (step < kSteps && CourseOf(*alone.world, ids) == CourseOf(*among.world, ids)) {
      Steps(*alone.world, 1);
      Steps(*among.world, 1);
      ++step;
    }
    EXPECT_EQ(step, kSteps) << "scene " << seed;
  }
}

// Of crates that fall asleep soon, beside a lift, with all that commands may do to them.
class Workshop {
 public:
  Workshop(World& world, double x) : world_(world), x_(x) {
    Add(world, Block({x, 0, -1}, {20, 20, 1}));
    EntityDesc lift = Block({x, 5, 0.5}, {1, 1, 0.5});
    lift.rigid_body->motion_type = MotionType::kKinematic;
    lift_ = Add(world, lift);
    for (int i = 0; i < 4; ++i) crates_.push_back(AddCrate({x, 0, 0.5 + i}));
    rider_ = AddCrate({x, 5, 1.5});
    AddCrate({x + 3, 0, 0.5});  // sleeps from some time on
  }

  // One command, whichever comes.
  void DoAny(Random& random) {
    const EntityId lowest = crates_.front(), highest = crates_.back();
    const double height = random.Uniform(0, 2);  // m
    switch (random.Below(11)) {
      case 0:
        return void(Do(world_, SetPose{.id = lift_, .position = Vector3(x_, 5, 0.5 + height), .over_steps = 4}));
      case 1:
        return void(Do(world_, SetVelocity{.id = lift_, .linear = Vector3(0, height, 0)}));
      case 2:
        return void(Do(world_, SetVelocity{.id = lift_, .linear = Vector3(0, 0, 0)}));
      case 3:
        return void(Do(world_, ApplyImpulse{.id = highest, .linear = {1, 0, height}}));
      case 4:
        return void(Do(world_, SetVelocity{.id = highest, .linear = Vector3(0, 0, -height)}));
      case 5:
        return void(Do(world_, SetPose{.id = highest, .position = Vector3(x_ + 3, 0.1, 1.4)}));
      case 6:
        return void(Do(world_, SetPose{.id = rider_, .position = Vector3(x_, 5.1, 1 + height)}));
      case 7:
        return crates_.push_back(AddCrate({x_ + 0.2, 0, 0.4 + static_cast<double>(crates_.size())}));
      case 8:
        return JoinOrNot(lowest, crates_[1]);
      case 9:
        return BlowOrNot();
      default:
        if (crates_.size() <= 2) return;
        if (!joint_.is_null()) JoinOrNot(lowest, crates_[1]);
        Do(world_, DeleteEntity{lowest});
        crates_.erase(crates_.begin());
    }
  }

 private:
  void JoinOrNot(EntityId a, EntityId b) {
    if (joint_.is_null()) {
      joint_ = Join(world_, Between(a, b, FixedJoint{}));
    } else {
      Do(world_, DeleteJoint{std::exchange(joint_, {})});
    }
  }

  void BlowOrNot() {
    if (wind_.is_null()) {
      wind_ = Do(world_, CreateForceField{{.kind = UniformField{.acceleration = {0.5, 0, 0}},
                                           .region = Region{{x_ - 20, -20, -5}, {x_ + 20, 20, 50}}}});
    } else {
      Do(world_, DeleteForceField{std::exchange(wind_, {}).packed()});
    }
  }

  EntityId AddCrate(const Vector3& position) {
    EntityDesc crate = Crate(position);
    crate.rigid_body->auto_disable = AutoDisable{.enabled = true, .rest_time = 0.1};
    return Add(world_, crate);
  }

  World& world_;
  double x_;  // m
  EntityId lift_, rider_;
  std::vector<EntityId> crates_;
  JointId joint_;
  CreatedId wind_;
};

TEST_P(FarApart, AreThoseWhomCommandsChange) {
  Proves({Claim::kKinematicLed, Claim::kJointFixed, Claim::kUniformField, Claim::kSleeping});
  constexpr int kScenes = 40, kSteps = 90;
  for (uint64_t seed = 101; seed <= 100 + kScenes; ++seed) {
    const RandomScene alone = MakeRandomScene({GetParam()}, seed), among = MakeRandomScene({GetParam()}, seed);
    const std::vector<EntityId> ids = EntitiesIn(*alone.world);
    Workshop workshop(*among.world, 400);
    Random random(seed);
    int step = 0;
    while (step < kSteps && CourseOf(*alone.world, ids) == CourseOf(*among.world, ids)) {
      workshop.DoAny(random);
      ++step;
      Steps(*alone.world, 1);
      Steps(*among.world, 1);
    }
    EXPECT_EQ(step, kSteps) << "scene " << seed;
  }
}

// What was led smoothly goes on by itself, and the first step of that finds no command of its own.
TEST_P(FarApart, IsALiftThatWasLedFromWhomCommandsChange) {
  Proves({Claim::kKinematicLed, Claim::kJointFixed, Claim::kUniformField, Claim::kSleeping});
  constexpr int kLed = 20, kSteps = 60;
  const auto courses = [&](bool is_among) {
    const auto world = testing::MakeWorld(WorldDesc{.engine = GetParam(), .default_auto_disable = {.enabled = false}});
    EntityDesc lift = Block({0, 0, 2}, {20, 20, 0.5});
    lift.rigid_body->motion_type = MotionType::kKinematic;
    const EntityId led = Add(*world, lift), crate = Add(*world, Crate({0.5, 0, 3}));
    std::optional<Workshop> workshop;
    if (is_among) workshop.emplace(*world, 400);
    Random random(3);
    std::vector<Course> all;
    for (int step = 0; step < kSteps; ++step) {
      const Vector3 velocity(0.02 * step * step, 0, 0.05 * step);  // under it the crate slides
      if (step < kLed) Do(*world, SetVelocity{.id = led, .linear = velocity, .angular = Vector3(0, 0, 0.05 * step)});
      if (is_among) workshop->DoAny(random);
      Steps(*world, 1);
      all.push_back(CourseOf(*world, {led, crate}));
    }
    return all;
  };
  const std::vector<Course> alone = courses(false), among = courses(true);
  const auto first = std::ranges::mismatch(alone, among).in1;
  EXPECT_EQ(first, alone.end()) << "from step " << first - alone.begin() << " on";
}

// Forces are told anew for every step, as a controller does.
TEST_P(FarApart, AreThoseWhoArePushed) {
  Proves({Claim::kForce});
  for (uint64_t seed = 1; seed <= 25; ++seed) {
    const RandomScene alone = MakeRandomScene({GetParam()}, seed), among = MakeRandomScene({GetParam()}, seed);
    const std::vector<EntityId> ids = EntitiesIn(*alone.world);
    Add(*alone.world, Crate({400, 0, 20}));
    const EntityId pushed = Add(*among.world, Crate({400, 0, 20}));
    for (int step = 0; step < 80; ++step) {
      Do(*among.world, ApplyForce{.id = pushed, .force = {1, 0, 0}});
      Steps(*alone.world, 1);
      Steps(*among.world, 1);
    }
    EXPECT_EQ(CourseOf(*alone.world, ids), CourseOf(*among.world, ids)) << "scene " << seed;
  }
}

}  // namespace
}  // namespace genphys::testing

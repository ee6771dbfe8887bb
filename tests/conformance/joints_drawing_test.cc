// What joints draw over a floor: friction is against the way in which they do, also when nothing slipped before.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "conformance/engine_test.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(JointsDrawing, Claim::kStaticFriction, Claim::kBox, Claim::kJointSixDof, Claim::kJointDistance);

constexpr double kGravity = 9.81, kFriction = 0.255, kHalfHeight = 0.1, kSeconds = 0.3;
constexpr double kLimit = kFriction * kGravity;  // N, of a block of 1 kg

// How far off, as part of the way, something came that should have gone `way` m.
struct Miss {
  double along = 0, across = 0;
};

class Block {
 public:
  // Drawn along `heading`, rad.
  Block(const std::string& engine, double heading, double step_size)
      : direction_(std::cos(heading), std::sin(heading), 0),
        heading_(Eigen::AngleAxisd(heading, Vector3::UnitZ())),
        step_size_(step_size) {
    WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = step_size}};
    desc.default_material.friction = kFriction;
    desc.default_auto_disable.enabled = false;
    desc.ground_plane = true;
    world_ = MakeWorld(desc);
    id_ = AddBlock(Vector3::Zero());
  }

  // Of two boxes, which are the same together.
  void MakeOfTwo() {
    Do(*world_, DeleteEntity{id_});
    EntityDesc desc = Body(Box{{0.25, 0.6, kHalfHeight}}, {0, 0, kHalfHeight}, 1);
    std::vector<Geometry>& halves = desc.rigid_body->geometries;
    halves.push_back(halves[0]);
    halves[0].pose_in_entity.position.x() = -0.25;
    halves[1].pose_in_entity.position.x() = 0.25;
    id_ = Add(*world_, desc);
  }
  EntityId AddBlock(const Vector3& beside) {
    return Add(*world_, Body(Box{{0.5, 0.6, kHalfHeight}}, beside + Vector3(0, 0, kHalfHeight), 1));
  }
  // Another one behind it, at the end of a rod.
  void AddBehind() {
    const EntityId behind = AddBlock(-2 * direction_);
    Join(*world_, {.entity_a = {.id = id_}, .entity_b = {.id = behind}, .kind = DistanceJoint{}});
  }
  // Free in every way, but for what `axis` does along the heading.
  JointId AddRail(const JointAxis& axis) { return Join(*world_, RailOf(axis)); }
  void ChangeRail(JointId rail, const JointAxis& axis) {
    UpdateJoint update{.id = rail, .joint = RailOf(axis)};
    update.fields.Add(JointField::kKind);
    Do(*world_, update);
  }
  void Pull(double force) { Do(*world_, ApplyForce{.id = id_, .force = force * direction_, .steps = 10'000}); }
  double step_size() const { return step_size_; }
  void Go(double seconds) { Steps(*world_, static_cast<int>(std::lround(seconds / step_size_))); }

  Miss MissOf(double way) const {
    const Vector3 moved = PositionOf(*world_, id_);
    return {std::abs(moved.dot(direction_) / way - 1), std::abs(moved.dot(Vector3::UnitZ().cross(direction_))) / way};
  }

 private:
  JointDesc RailOf(const JointAxis& axis) const {
    SixDofJoint rail;
    std::ranges::fill(rail.along, JointAxis{});
    std::ranges::fill(rail.about, JointAxis{});
    rail.along[0] = axis;
    return {
        .entity_b = {.id = id_}, .frame_in_a = Pose{{0, 0, kHalfHeight}, heading_}, .frame_in_b = Pose{}, .kind = rail};
  }

  Vector3 direction_;
  Quaternion heading_;
  double step_size_;
  std::unique_ptr<World> world_;
  EntityId id_;
};

// One that never gets as fast as it shall, so that it pulls with all its force.
JointAxis MotorOf(double force) { return {.motor = Motor{.target_velocity = 100, .force_max = force}}; }

double WayOf(double force) { return (force - kLimit) * kSeconds * kSeconds / 2; }

// Calls visit(block, force) with blocks in many directions, at two step sizes, and what shall pull each.
template <typename Visit>
void VisitBlocks(const std::string& engine, Visit visit) {
  for (const double rate : {60.0, 240.0}) {
    for (const double heading : {0.3, M_PI / 4, 1.2, 2.0, -1.3}) {
      for (const double part : {1.2, 2.0, 5.0}) {
        SCOPED_TRACE(::testing::Message()
                     << rate << " Hz, " << heading << " rad, " << part << " of what friction holds");
        Block block(engine, heading, 1 / rate);
        visit(block, part * kLimit);
      }
    }
  }
}

TEST_P(JointsDrawing, AMotorDrawsABlockOfOneOrTwoShapesStraightFromRest) {
  VisitBlocks(GetParam(), [](Block& block, double force) {
    for (const bool is_of_two : {false, true}) {
      if (is_of_two) block.MakeOfTwo();
      block.AddRail(MotorOf(force));
      block.Go(kSeconds);
      const Miss miss = block.MissOf(WayOf(force));
      EXPECT_LT(miss.along, 2e-5) << is_of_two;
      EXPECT_LT(miss.across, 1e-6) << is_of_two;
    }
  });
}

TEST_P(JointsDrawing, AMotorThatIsToldToPullHarderDrawsWhatItDidNotMoveStraight) {
  VisitBlocks(GetParam(), [](Block& block, double force) {
    const JointId rail = block.AddRail(MotorOf(0.9 * kLimit));
    block.Go(0.2);
    EXPECT_LT(block.MissOf(1).across, 1e-6);
    EXPECT_NEAR(block.MissOf(1).along, 1, 1e-6) << "it has not moved";
    block.ChangeRail(rail, MotorOf(force));
    block.Go(kSeconds);
    const Miss miss = block.MissOf(WayOf(force));
    EXPECT_LT(miss.along, 2e-5);
    EXPECT_LT(miss.across, 1e-5);
  });
}

TEST_P(JointsDrawing, ASpringDrawsABlockStraightFromRest) {
  VisitBlocks(GetParam(), [](Block& block, double force) {
    // Stretched by a metre, of which the block goes a part: it swings about where the spring is as strong as friction.
    block.AddRail({.spring = Spring{.stiffness = force, .rest = 1}});
    block.Go(kSeconds);
    const double middle = 1 - kLimit / force;
    const Miss miss = block.MissOf(middle * (1 - std::cos(std::sqrt(force) * kSeconds)));
    // Of second order: 1.31e-4 at 60 steps per second was measured, and 8.2e-6 at 240.
    EXPECT_LT(miss.along, 0.6 * block.step_size() * block.step_size());
    EXPECT_LT(miss.across, 1e-6);
  });
}

TEST_P(JointsDrawing, ARodDrawsTheBlockBehindStraight) {
  VisitBlocks(GetParam(), [](Block& block, double force) {
    block.AddBehind();
    block.Pull(2 * force);
    block.Go(kSeconds);
    const Miss miss = block.MissOf(WayOf(force));
    EXPECT_LT(miss.along, 2e-5);
    EXPECT_LT(miss.across, 1e-6);
  });
}

}  // namespace
}  // namespace genphys::testing

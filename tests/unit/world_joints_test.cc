#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "genphys/limits.h"
#include "support/joints.h"

namespace genphys::testing {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Scene {
  std::unique_ptr<World> world = MakeWorld("ode");
  EntityId ball = Add(*world, Ball({0, 0, 2}));
  EntityId crate = Add(*world, Crate({2, 0, 2}));
  EntityId wall = Add(*world, Block({0, 5, 0}, {1, 1, 1}));

  Refusal Refused(const std::vector<Command>& commands) const {
    const uint64_t before = world->StateHash();
    const Result<std::vector<CreatedId>> result = world->Apply(commands);
    EXPECT_FALSE(result.ok());
    EXPECT_EQ(world->StateHash(), before) << "a refused batch changes nothing";
    return result.ok() ? Refusal{} : *RefusalOf(result.status());
  }
};

void ExpectRefused(const Scene& scene, const std::vector<Command>& commands, Reason reason, std::string_view field) {
  const Refusal refusal = scene.Refused(commands);
  EXPECT_EQ(refusal.reason, reason) << NameOf(refusal.reason);
  EXPECT_EQ(refusal.field, field);
}

TEST(Joints, AreRefusedBetweenWhatCannotBeJoined) {
  Scene scene;
  const std::string joint = "commands[0].create_joint.joint";
  const auto join = [](EntityId a, EntityId b) {
    return std::vector<Command>{CreateJoint{Between(a, b, BallJoint{})}};
  };
  ExpectRefused(scene, join({}, {}), Reason::kMissingField, joint + ".entity_a");
  ExpectRefused(scene, join(scene.ball, scene.ball), Reason::kInvalidValue, joint + ".entity_b");
  ExpectRefused(scene, join(scene.wall, {}), Reason::kInvalidValue, joint + ".entity_a");
  ExpectRefused(scene, join({}, scene.wall), Reason::kInvalidValue, joint + ".entity_b");
  ExpectRefused(scene, join(EntityId(77, 0), scene.ball), Reason::kEntityNotFound, joint + ".entity_a.id");
  EXPECT_TRUE(scene.world->Apply(join(scene.wall, scene.ball)).ok());
  EXPECT_TRUE(scene.world->Apply(join(scene.crate, {})).ok());
}

TEST(Joints, MayNameWhatTheBatchHasJustCreated) {
  Scene scene;
  JointDesc joint = Between({}, scene.ball, BallJoint{});
  joint.entity_a.created_by_command = 0;
  const std::string field = "commands[1].create_joint.joint.entity_a.created_by_command";
  ExpectRefused(scene, {SetGravity{}, CreateJoint{joint}}, Reason::kInvalidValue, field);
  joint.entity_a.created_by_command = 1;
  ExpectRefused(scene, {CreateEntity{Ball({0, 0, 5})}, CreateJoint{joint}}, Reason::kInvalidValue, field);
  joint.entity_a.created_by_command = 0;

  const std::vector<Command> batch{CreateEntity{Ball({0, 0, 5})}, CreateJoint{joint}};
  const Result<std::vector<CreatedId>> created = scene.world->Apply(batch);

  ASSERT_TRUE(created.ok()) << created.status();
  const JointId id = (*created)[1];
  EXPECT_EQ(scene.world->scene().joints[id.index()]->desc.entity_a, (EntityRef{EntityId((*created)[0]), {}}));
}

TEST(Joints, NameTheNumberThatIsWrong) {
  Scene scene;
  const auto with = [&](const JointKind& kind) { return std::vector<Command>{CreateJoint{ToWorld(scene.ball, kind)}}; };
  const std::string joint = "commands[0].create_joint.joint.";
  HingeJoint hinge;
  hinge.axis.limits = {.lower = 1, .upper = 0.5};
  ExpectRefused(scene, with(hinge), Reason::kInvalidValue, joint + "hinge.limits.upper_radians");
  hinge.axis.limits = {.lower = 0.5, .upper = 0.5};
  EXPECT_TRUE(scene.world->Apply(with(hinge)).ok());

  SliderJoint slider;
  slider.axis.limits.lower = kNan;
  ExpectRefused(scene, with(slider), Reason::kNotFinite, joint + "slider.limits.lower_metres");
  slider.axis = {.limits = {}, .motor = Motor{.target_position = 1}, .spring = {}};
  ExpectRefused(scene, with(slider), Reason::kInvalidValue, joint + "slider.motor.stiffness");
  slider.axis.motor = Motor{.stiffness = 1};
  ExpectRefused(scene, with(slider), Reason::kInvalidValue, joint + "slider.motor.target_metres");
  slider.axis.motor = Motor{.force_max = -1};
  ExpectRefused(scene, with(slider), Reason::kOutOfRange, joint + "slider.motor.force_max");

  BallJoint ball;
  ball.twist = {.lower = 1, .upper = 0};
  ExpectRefused(scene, with(ball), Reason::kInvalidValue, joint + "ball.twist.upper_radians");
  ball = {.swing_max = 4};
  ExpectRefused(scene, with(ball), Reason::kOutOfRange, joint + "ball.swing_max_radians");

  WheelJoint wheel;
  wheel.suspension = JointAxis{.limits = {}, .motor = {}, .spring = Spring{.stiffness = 2 * Limits::kStiffnessMax}};
  ExpectRefused(scene, with(wheel), Reason::kOutOfRange, joint + "wheel.suspension.spring.stiffness");
  ExpectRefused(scene, with(GearJoint{.ratio = 0}), Reason::kInvalidValue, joint + "gear.ratio");
  ExpectRefused(scene, with(GearJoint{.ratio = -0.9e-6}), Reason::kOutOfRange, joint + "gear.ratio");

  JointDesc tilted = ToWorld(scene.ball, FixedJoint{});
  tilted.frame_in_b = Pose{Vector3::Zero(), Quaternion(1, 1, 0, 0)};
  ExpectRefused(scene, {CreateJoint{tilted}}, Reason::kNotUnitLength, joint + "frame_in_b.orientation");
  tilted.frame_in_b.reset();
  tilted.break_force = -1;
  ExpectRefused(scene, {CreateJoint{tilted}}, Reason::kOutOfRange, joint + "break_force");
}

TEST(Joints, OfAnEngineWithoutThemAreRefusedByName) {
  Scene scene;
  const JointId joint = Join(*scene.world, ToWorld(scene.ball, BallJoint{}));
  Do(*scene.world, SetEngine{"none"});
  const Refusal refusal = scene.Refused({CreateJoint{ToWorld(scene.crate, HingeJoint{})}});
  EXPECT_EQ(refusal.reason, Reason::kUnsupportedFeature);
  EXPECT_EQ(refusal.field, "commands[0].create_joint.joint.hinge");
  EXPECT_TRUE(scene.world->CheckId(joint, "").ok()) << "those that are there stay";

  const auto flight = MakeWorld("ballistic");
  const EntityId ball = Add(*flight, Ball({0, 0, 0}));
  const Command command = CreateJoint{ToWorld(ball, FixedJoint{})};
  EXPECT_EQ(RefusalOf(flight->Apply({&command, 1}).status())->reason, Reason::kUnsupportedFeature);
}

TEST(Joints, KeepAWorldFromAnEngineThatHasNone) {
  const auto world = MakeSpace("ode");
  Join(*world, ToWorld(Add(*world, Ball({0, 0, 0})), BallJoint{}));
  const Command command = SetEngine{"ballistic"};
  const Status status = world->Apply({&command, 1}).status();
  EXPECT_EQ(RefusalOf(status)->reason, Reason::kUnsupportedFeature);
  EXPECT_EQ(RefusalOf(status)->field, "commands[0].set_engine.engine");
}

TEST(Joints, ThatAreGoneAreStale) {
  Scene scene;
  const JointId joint = Join(*scene.world, Between(scene.ball, scene.crate, BallJoint{}));
  const Command drop = DeleteJoint{joint};
  ExpectRefused(scene, {drop, drop}, Reason::kStaleId, "commands[1].delete_joint.joint_id");
  ExpectRefused(scene, {DeleteEntity{scene.ball}, drop}, Reason::kStaleId, "commands[1].delete_joint.joint_id");
  Do(*scene.world, drop);
  ExpectRefused(scene, {drop}, Reason::kStaleId, "commands[0].delete_joint.joint_id");
  ExpectRefused(scene, {DeleteJoint{JointId(9, 0)}}, Reason::kEntityNotFound, "commands[0].delete_joint.joint_id");
  ExpectRefused(scene, {DeleteJoint{}}, Reason::kMissingField, "commands[0].delete_joint.joint_id");
}

TEST(Joints, ChangeOnlyInPartsThatTheyHave) {
  Scene scene;
  const JointId joint = Join(*scene.world, ToWorld(scene.ball, BallJoint{}));
  UpdateJoint update{.id = joint, .joint = {.kind = HingeJoint{}}, .fields = {}};
  update.fields.Add(JointField::kMotor);
  ExpectRefused(scene, {update}, Reason::kInvalidValue, "commands[0].update_joint.joint.hinge");
  update.fields = {};
  update.fields.Add(JointField::kKind);
  update.fields.Add(JointField::kBreakForce);
  update.joint.break_force = 5;
  Do(*scene.world, update);
  const JointDesc& now = scene.world->scene().joints[joint.index()]->desc;
  EXPECT_TRUE(std::holds_alternative<HingeJoint>(now.kind));
  EXPECT_EQ(now.break_force, 5);
  EXPECT_EQ(now.entity_b.id, scene.ball);
}

TEST(Joints, MotorsInColumnsNameTheRow) {
  Scene scene;
  HingeJoint driven;
  driven.axis.motor = Motor{};
  const JointId motor = Join(*scene.world, ToWorld(scene.ball, driven));
  const JointId plain = Join(*scene.world, ToWorld(scene.crate, BallJoint{}));
  const std::string path = "commands[0].set_motors.";
  ExpectRefused(scene, {SetMotorColumns{{motor, plain}, {1, 2}, {}}}, Reason::kInvalidValue, path + "joint_ids[1]");
  ExpectRefused(scene, {SetMotorColumns{{motor}, {1, 2}, {}}}, Reason::kInvalidValue, path + "targets");
  ExpectRefused(scene, {SetMotorColumns{{motor}, {2 * Limits::kSpinMax}, {}}}, Reason::kOutOfRange,
                path + "targets[0]");
  ExpectRefused(scene, {SetMotorColumns{{motor}, {1}, {1}}}, Reason::kInvalidValue, path + "joint_ids[0]");
  ExpectRefused(scene, {SetMotorColumns{{motor}, {1}, {1, 2}}}, Reason::kInvalidValue, path + "positions");
  Do(*scene.world, SetMotorColumns{{motor}, {Limits::kSpinMax}, {}});
}

TEST(Joints, AreMadeWhereTheEntitiesAreUnlessToldOtherwise) {
  Scene scene;
  const auto frames = [&](JointDesc joint) {
    const JointId id = Join(*scene.world, joint);
    const JointDesc& made = scene.world->scene().joints[id.index()]->desc;
    return std::pair(made.frame_in_a->position, made.frame_in_b->position);
  };
  JointDesc joint{.entity_a = {scene.ball, {}}, .entity_b = {scene.crate, {}}, .kind = BallJoint{}};
  EXPECT_EQ(frames(joint), std::pair(Vector3(2, 0, 0), Vector3(0, 0, 0)));
  joint.frame_in_a = Pose{{1, 0, 0}, Quaternion::Identity()};
  EXPECT_EQ(frames(joint), std::pair(Vector3(1, 0, 0), Vector3(-1, 0, 0)));
  joint.kind = DistanceJoint{};
  EXPECT_EQ(frames(joint), std::pair(Vector3(1, 0, 0), Vector3(0, 0, 0)));
  const JointDesc& rod = scene.world->scene().joints.back()->desc;
  EXPECT_EQ(std::get<DistanceJoint>(rod.kind).axis.limits, (AxisLimits{1, 1})) << "it keeps the distance that there is";
}

// What a hinge about z that was spun by three turns and a bit is told to be at once somebody is put elsewhere.
double AngleAfter(const SetPose& pose, const AxisLimits& limits = {}) {
  const auto world = MakeSpace("ode", {}, Vector3::Zero());
  EntityDesc desc = Crate(Vector3::Zero());
  desc.rigid_body->angular_velocity = {0, 0, 20};
  const EntityId crate = Add(*world, desc);
  const JointId hinge = Join(*world, ToWorld(crate, HingeJoint{}));
  Steps(*world, 60);
  EXPECT_NEAR(StateOf(*world, hinge).positions[5], 20, 1e-6);
  Do(*world,
     UpdateJoint{hinge, ToWorld(crate, HingeJoint{{.limits = limits}}), {static_cast<uint32_t>(JointField::kKind)}});
  SetPose put = pose;
  put.id = crate;
  Do(*world, put);
  return StateOf(*world, hinge).positions[5];
}

TEST(Joints, CountTheirTurnsAnewWhereSomebodyIsPutElsewhere) {
  constexpr double kRounding = 1e-12;
  const auto turned = [](double angle) { return Quaternion(Eigen::AngleAxisd(angle, Vector3::UnitZ())); };
  EXPECT_NEAR(AngleAfter({.position = Vector3::Zero(), .orientation = turned(0)}), 0, kRounding);
  EXPECT_NEAR(AngleAfter({.orientation = turned(3)}), 3, kRounding);
  EXPECT_NEAR(AngleAfter({.orientation = turned(4)}), 4 - 2 * std::numbers::pi, kRounding);
  EXPECT_NEAR(AngleAfter({.orientation = turned(4)}, {0, 4.5}), 4, kRounding) << "nothing else is within its limits";
  EXPECT_NEAR(AngleAfter({.orientation = turned(12)}, {10, std::nullopt}), 12, kRounding) << "with one limit";
  EXPECT_NEAR(AngleAfter({.position = Vector3::Zero()}), 20, 1e-6) << "it was not turned";
}

}  // namespace
}  // namespace genphys::testing

#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <set>

#include "genphys/limits.h"
#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"
#include "wire_round_trip.h"

namespace genphys {
namespace {

// Sorted as the model lists them, so that the mask that comes back is the mask that was sent.
const std::vector<std::string> kMaskPaths{"display_name",
                                          "pose",
                                          "visual",
                                          "rigid_body",
                                          "rigid_body.motion_type",
                                          "rigid_body.geometries",
                                          "rigid_body.inertia",
                                          "rigid_body.auto_disable",
                                          "rigid_body.linear_velocity",
                                          "rigid_body.angular_velocity",
                                          "rigid_body.linear_damping",
                                          "rigid_body.angular_damping",
                                          "rigid_body.gravity_scale",
                                          "rigid_body.linear_speed_max",
                                          "rigid_body.angular_speed_max"};
const std::vector<std::string> kJointMaskPaths{"frame_in_a",   "frame_in_b",   "collide_connected",
                                               "break_force",  "break_torque", "hinge",
                                               "hinge.limits", "hinge.motor",  "hinge.spring"};

v1::Command Filled(const std::string& kind) {
  v1::Command command;
  FillEveryField(&command, {{"genphys.v1.Command.kind", kind}});
  if (command.has_create_entity()) {
    *command.mutable_create_entity()->mutable_entity() = FilledEntity();
    command.mutable_create_entity()->mutable_entity()->clear_id();
  }
  if (command.has_update_entity()) {
    *command.mutable_update_entity()->mutable_entity() = FilledEntity();
    google::protobuf::FieldMask* mask = command.mutable_update_entity()->mutable_update_mask();
    mask->Clear();
    for (const std::string& path : kMaskPaths) mask->add_paths(path);
  }
  if (command.has_create_joint()) command.mutable_create_joint()->mutable_joint()->clear_id();
  if (command.has_update_joint()) {
    google::protobuf::FieldMask* mask = command.mutable_update_joint()->mutable_update_mask();
    mask->Clear();
    for (const std::string& path : kJointMaskPaths) mask->add_paths(path);
    command.mutable_update_joint()->mutable_joint()->mutable_hinge();
  }
  if (command.has_create_force_field()) command.mutable_create_force_field()->mutable_field()->clear_id();
  if (command.has_set_engine()) command.mutable_set_engine()->set_engine("engines/bullet");
  return command;
}

std::vector<std::string> Kinds() {
  std::vector<std::string> kinds;
  const google::protobuf::OneofDescriptor* kind = v1::Command::descriptor()->FindOneofByName("kind");
  for (int i = 0; i < kind->field_count(); ++i) kinds.push_back(kind->field(i)->name());
  return kinds;
}

class EveryCommand : public testing::TestWithParam<std::string> {};

TEST_P(EveryCommand, TravelsWithAllItsFields) {
  const v1::Command sent = Filled(GetParam());

  const Result<Command> command = DecodeCommand(sent);

  ASSERT_TRUE(command.ok()) << command.status();
  v1::Command returned;
  EncodeCommand(*command, &returned);
  EXPECT_TRUE(SameMessage(sent, returned));
}

INSTANTIATE_TEST_SUITE_P(WireCommand, EveryCommand, testing::ValuesIn(Kinds()),
                         [](const auto& named) { return named.param; });

class EveryJoint : public testing::TestWithParam<std::string> {};

TEST_P(EveryJoint, TravelsWithAllItsFields) {
  v1::Command sent;
  FillEveryField(&sent, {{"genphys.v1.Command.kind", "create_joint"}, {"genphys.v1.Joint.kind", GetParam()}});
  sent.mutable_create_joint()->mutable_joint()->clear_id();

  const Result<Command> command = DecodeCommand(sent);

  ASSERT_TRUE(command.ok()) << command.status();
  v1::Command returned;
  EncodeCommand(*command, &returned);
  EXPECT_TRUE(SameMessage(sent, returned));
}

INSTANTIATE_TEST_SUITE_P(WireCommand, EveryJoint,
                         testing::Values("ball", "hinge", "slider", "universal", "fixed", "wheel", "six_dof",
                                         "distance", "gear"),
                         [](const auto& named) { return named.param; });

TEST(WireCommand, TellsWhichCommandOfABatchIsRefused) {
  google::protobuf::RepeatedPtrField<v1::Command> commands;
  *commands.Add() = Filled("set_gravity");
  *commands.Add() = Filled("create_entity");
  EXPECT_EQ(DecodeCommands(commands)->size(), 2u);

  commands.Mutable(1)
      ->mutable_create_entity()
      ->mutable_entity()
      ->mutable_rigid_body()
      ->mutable_geometries(0)
      ->mutable_shape()
      ->mutable_convex_hull();

  EXPECT_EQ(Verdict(DecodeCommands(commands).status()),
            "INVALID_VALUE commands[1].create_entity.entity.rigid_body.geometries[0].shape.convex_hull.vertices");
}

TEST(WireCommand, RefusesACommandOfNoKind) {
  google::protobuf::RepeatedPtrField<v1::Command> commands;
  commands.Add();

  EXPECT_EQ(Verdict(DecodeCommands(commands).status()), "MISSING_FIELD commands[0].kind");
}

TEST(WireCommand, BringsNoMoreGeometriesThanAWorldHolds) {
  google::protobuf::RepeatedPtrField<v1::Command> commands;
  v1::Command whole;
  v1::RigidBody& body = *whole.mutable_create_entity()->mutable_entity()->mutable_rigid_body();
  for (unsigned i = 0; i < Limits::kGeometriesMax; ++i) body.add_geometries()->mutable_shape()->mutable_sphere();
  for (unsigned i = 0; i < Limits::kWorldGeometriesMax / Limits::kGeometriesMax; ++i) *commands.Add() = whole;
  const std::string next = "commands[" + std::to_string(commands.size()) + "].";
  v1::RigidBody& rest = *commands.Add()->mutable_update_entity()->mutable_entity()->mutable_rigid_body();
  for (unsigned i = 0; i < Limits::kWorldGeometriesMax % Limits::kGeometriesMax; ++i) {
    rest.add_geometries()->mutable_shape()->mutable_sphere();
  }
  EXPECT_TRUE(DecodeCommands(commands).ok());

  rest.add_geometries()->mutable_shape()->mutable_sphere();
  EXPECT_EQ(Verdict(DecodeCommands(commands).status()),
            "LIMIT_EXCEEDED " + next + "update_entity.entity.rigid_body.geometries");
}

TEST(WireCommand, RefusesAnEngineNameOfAnotherForm) {
  v1::Command command;
  for (const char* name : {"ode", "engines/", "worlds/ode", ""}) {
    command.mutable_set_engine()->set_engine(name);
    EXPECT_EQ(Verdict(DecodeCommand(command).status()), "INVALID_VALUE set_engine.engine") << name;
  }
}

TEST(WireCommand, ActsForOneStepUnlessToldOtherwise) { EXPECT_EQ(DecodeForce(v1::ApplyForce())->steps, 1u); }

TEST(WireCommand, RefusesAnIdForWhatIsYetToBeCreated) {
  v1::Command entity = Filled("create_entity"), joint = Filled("create_joint"), field = Filled("create_force_field");
  entity.mutable_create_entity()->mutable_entity()->set_id(7);
  joint.mutable_create_joint()->mutable_joint()->set_id(7);
  field.mutable_create_force_field()->mutable_field()->set_id(7);

  EXPECT_EQ(Verdict(DecodeCommand(entity).status()), "INVALID_VALUE create_entity.entity.id");
  EXPECT_EQ(Verdict(DecodeCommand(joint).status()), "INVALID_VALUE create_joint.joint.id");
  EXPECT_EQ(Verdict(DecodeCommand(field).status()), "INVALID_VALUE create_force_field.field.id");
}

TEST(WireCommand, PutsNoForceWhereOnlyTorquesAreSent) {
  v1::Command command = Filled("apply_forces");
  command.mutable_apply_forces()->clear_forces();

  const Result<Command> decoded = DecodeCommand(command);

  ASSERT_TRUE(decoded.ok()) << decoded.status();
  const auto& columns = std::get<ApplyForceColumns>(*decoded);
  EXPECT_EQ(columns.forces, (std::vector<Vector3>(columns.ids.size(), Vector3::Zero())));
  EXPECT_EQ(columns.torques.size(), columns.ids.size());
}

TEST(WireCommand, KeepsThePartOfAPoseThatIsNotSent) {
  v1::Command command;
  command.mutable_set_pose()->mutable_pose()->mutable_position()->set_x(3);

  const Result<Command> decoded = DecodeCommand(command);

  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(std::get<SetPose>(*decoded).position, Vector3(3, 0, 0));
  EXPECT_FALSE(std::get<SetPose>(*decoded).orientation.has_value());
}

uint32_t Bits(std::initializer_list<EntityField> fields) {
  EntityFields all;
  for (const EntityField field : fields) all.Add(field);
  return all.bits;
}

Result<Command> Updated(const v1::Entity& entity, std::initializer_list<const char*> paths = {}) {
  v1::Command command;
  *command.mutable_update_entity()->mutable_entity() = entity;
  for (const char* path : paths) command.mutable_update_entity()->mutable_update_mask()->add_paths(path);
  return DecodeCommand(command);
}

TEST(WireUpdate, ChangesWhatTheMaskNamesAndNothingElse) {
  const Result<Command> command = Updated(FilledEntity(), {"rigid_body.inertia", "pose"});

  ASSERT_TRUE(command.ok()) << command.status();
  EXPECT_EQ(std::get<UpdateEntity>(*command).fields.bits, Bits({EntityField::kInertia, EntityField::kPose}));
}

TEST(WireUpdate, ChangesWhatIsSetWhenThereIsNoMask) {
  v1::Entity entity;
  entity.set_display_name("crate");
  entity.mutable_rigid_body()->mutable_inertia()->set_mass(2);
  entity.mutable_rigid_body()->set_linear_damping(0);

  const Result<Command> command = Updated(entity);

  ASSERT_TRUE(command.ok()) << command.status();
  EXPECT_EQ(std::get<UpdateEntity>(*command).fields.bits,
            Bits({EntityField::kDisplayName, EntityField::kInertia, EntityField::kLinearDamping}));
}

TEST(WireUpdate, ChangesEveryPartWhenAllAreSetAndThereIsNoMask) {
  const Result<Command> command = Updated(FilledEntity());

  ASSERT_TRUE(command.ok()) << command.status();
  EntityFields all;
  all.bits = Bits({EntityField::kIgnoredEntities}) * 2 - 1;
  EXPECT_EQ(std::get<UpdateEntity>(*command).fields.bits, all.bits & ~Bits({EntityField::kRigidBody}));
}

TEST(WireUpdate, ReplacesTheWholeBodyByOneThatSetsNothing) {
  v1::Entity entity;
  entity.mutable_rigid_body();

  EXPECT_EQ(std::get<UpdateEntity>(*Updated(entity)).fields.bits, Bits({EntityField::kRigidBody}));
}

TEST(WireUpdate, RefusesPathsThatNameNoPart) {
  for (const char* path : {"nonsense", "id", "rigid_body.nonsense", "rigid_body.", "", "*", "display_name.x"}) {
    EXPECT_EQ(Verdict(Updated(FilledEntity(), {"pose", path}).status()),
              "INVALID_VALUE update_entity.update_mask.paths[1]")
        << path;
  }
}

TEST(WireUpdate, ListsWhatAPathMayName) {
  const std::string message(MessageOf(Updated(FilledEntity(), {"nonsense"}).status()));
  for (const char* path : {"display_name", "pose", "visual", "rigid_body", "rigid_body.motion_type"}) {
    EXPECT_NE(message.find(path), std::string::npos) << path << " in " << message;
  }
}

TEST(WireUpdate, NamesThePartThatADeeperPathBelongsTo) {
  const Status status = Updated(FilledEntity(), {"rigid_body.inertia.mass"}).status();

  EXPECT_EQ(Verdict(status), "INVALID_VALUE update_entity.update_mask.paths[0]");
  EXPECT_NE(MessageOf(status).find("name \"rigid_body.inertia\""), std::string::npos) << status;
}

TEST(WireUpdate, OfNothingStaysAnUpdateOfNothing) {
  v1::Command sent;
  EncodeCommand(UpdateEntity{.id = EntityId(7, 1), .entity = {.display_name = "ball"}}, &sent);

  const Result<Command> command = DecodeCommand(sent);

  ASSERT_TRUE(command.ok()) << command.status();
  EXPECT_EQ(std::get<UpdateEntity>(*command).id, EntityId(7, 1));
  EXPECT_EQ(std::get<UpdateEntity>(*command).fields.bits, 0u);
}

}  // namespace
}  // namespace genphys

// The unary calls of SimulationService.
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "support/test_server.h"

namespace genphys::testing {
namespace {

using Simulation = v1::SimulationService::Stub;
using google::protobuf::util::MessageDifferencer;

constexpr double kStepSize = 1.0 / 60;  // s, the default
constexpr double kGravity = 9.80665;    // m/s^2, the default

v1::GetEntityResponse Get(TestServer& server, const std::string& world, uint64_t id) {
  v1::GetEntityRequest request;
  request.set_world(world);
  request.set_entity_id(id);
  return Must(server.simulation(), &Simulation::GetEntity, request);
}

std::vector<double> Doubles(const std::string& column) {
  std::vector<double> values(column.size() / sizeof(double));
  std::memcpy(values.data(), column.data(), values.size() * sizeof(double));
  return values;
}

TEST(CreateEntity, TellsTheEntityAsItIsNow) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::CreateEntityRequest request;
  request.set_world(world);
  request.mutable_entity()->set_display_name("ball");
  request.mutable_entity()->mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_sphere()->set_radius(2);

  const auto created = Must(server.simulation(), &Simulation::CreateEntity, request);

  EXPECT_NE(created.entity().id(), 0u);
  EXPECT_EQ(created.entity().display_name(), "ball");
  EXPECT_NE(created.entity().rigid_body().geometries(0).id(), 0u);
  EXPECT_TRUE(created.has_stamp());
  EXPECT_TRUE(MessageDifferencer::Equals(Get(server, world, created.entity().id()).entity(), created.entity()));
}

TEST(CreateEntity, BlamesTheFieldOfTheRequest) {
  TestServer server;
  v1::CreateEntityRequest request;
  request.set_world(server.CreateWorld().world().name());
  v1::Entity& entity = *request.mutable_entity();

  // Found by the declared limits.
  entity.mutable_pose()->mutable_position()->set_x(std::numeric_limits<double>::quiet_NaN());
  ExpectRefusal(MustNot(server.simulation(), &Simulation::CreateEntity, request), Reason::kNotFinite,
                "entity.pose.position.x");
  entity.clear_pose();

  // Found when it is decoded.
  v1::Geometry& geometry = *entity.mutable_rigid_body()->add_geometries();
  geometry.mutable_shape()->mutable_sphere()->set_radius(1);
  v1::Geometry& flat = *entity.mutable_rigid_body()->add_geometries();
  for (int i = 0; i < 12; ++i) flat.mutable_shape()->mutable_convex_hull()->add_vertices(i % 3 == 2 ? 1 : i);
  ExpectRefusal(MustNot(server.simulation(), &Simulation::CreateEntity, request), Reason::kInvalidValue,
                "entity.rigid_body.geometries[1].shape.convex_hull.vertices");
  entity.mutable_rigid_body()->mutable_geometries()->RemoveLast();

  // Found by the model: no body has such moments.
  for (const double element : {1.0, 0.0, 0.0, 1.0, 0.0, 9.0}) {
    entity.mutable_rigid_body()->mutable_inertia()->add_tensor(element);
  }
  entity.mutable_rigid_body()->mutable_inertia()->set_mass(1);
  const Status inertia = MustNot(server.simulation(), &Simulation::CreateEntity, request);
  EXPECT_TRUE(RefusalOf(inertia)->field.starts_with("entity.rigid_body.inertia")) << inertia.ToString();
}

TEST(DeleteEntity, MakesTheIdStale) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::DeleteEntityRequest request;
  request.set_world(world);
  request.set_entity_id(server.AddBall(world, 3));

  Must(server.simulation(), &Simulation::DeleteEntity, request);

  ExpectRefusal(MustNot(server.simulation(), &Simulation::DeleteEntity, request), Reason::kStaleId, "entity_id");
  request.set_entity_id(uint64_t{7} << 32 | 7);
  ExpectRefusal(MustNot(server.simulation(), &Simulation::DeleteEntity, request), Reason::kEntityNotFound, "entity_id");
  request.set_entity_id(0);
  ExpectRefusal(MustNot(server.simulation(), &Simulation::DeleteEntity, request), Reason::kMissingField, "entity_id");
}

TEST(ApplyForce, PushesFromTheNextStepOn) {
  constexpr double kForce = 120;       // N
  constexpr double kTolerance = 1e-9;  // m/s: rounding of a few operations
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::CreateEntityRequest create;
  create.set_world(world);
  create.mutable_entity()->mutable_rigid_body()->mutable_inertia()->set_mass(2);
  create.mutable_entity()->mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_sphere()->set_radius(0.5);
  create.mutable_entity()->mutable_pose()->mutable_position()->set_z(50);
  const uint64_t ball = Must(server.simulation(), &Simulation::CreateEntity, create).entity().id();
  v1::ApplyForceRequest request;
  request.set_world(world);
  request.mutable_force()->set_entity_id(ball);
  request.mutable_force()->mutable_force()->set_x(kForce);

  EXPECT_EQ(Must(server.simulation(), &Simulation::ApplyForce, request).stamp().step(), 0u);
  server.Step(world);

  const auto entity = Get(server, world, ball).entity();
  EXPECT_NEAR(entity.rigid_body().linear_velocity().x(), kForce / 2 * kStepSize, kTolerance);
  EXPECT_NEAR(entity.rigid_body().linear_velocity().z(), -kGravity * kStepSize, kTolerance);
}

TEST(ApplyForce, BlamesTheFieldOfTheRequest) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  v1::ApplyForceRequest request;
  request.set_world(world);

  ExpectRefusal(MustNot(server.simulation(), &Simulation::ApplyForce, request), Reason::kMissingField, "force");
  request.mutable_force()->set_entity_id(uint64_t{9} << 32 | 9);
  ExpectRefusal(MustNot(server.simulation(), &Simulation::ApplyForce, request), Reason::kEntityNotFound,
                "force.entity_id");
  request.mutable_force()->set_steps(0);
  ExpectRefusal(MustNot(server.simulation(), &Simulation::ApplyForce, request), Reason::kOutOfRange, "force.steps");
}

TEST(ListEntities, PagesThroughAllInOrderOfId) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  for (int i = 0; i < 6; ++i) server.AddBall(world, 2 + 2 * i);
  v1::ListEntitiesRequest request;
  request.set_world(world);
  request.set_page_size(3);
  std::vector<uint64_t> ids;
  std::vector<int> sizes;

  do {
    const auto page = Must(server.simulation(), &Simulation::ListEntities, request);
    for (const v1::Entity& entity : page.entities()) ids.push_back(entity.id());
    sizes.push_back(page.entities_size());
    EXPECT_EQ(page.last_sequence(), 7u);
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());

  // Six balls and the floor.
  EXPECT_EQ(sizes, (std::vector<int>{3, 3, 1}));
  EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end()));
}

TEST(ListEntities, EndsAPageBeforeItGrowsTooLarge) {
  TestServer server;
  v1::World no_floor;
  no_floor.set_ground_plane(false);
  v1::CreateEntityRequest create;
  create.set_world(server.CreateWorld(no_floor).world().name());
  create.mutable_entity()->mutable_visual()->set_data(std::string(400'000, 'x'));
  for (int i = 0; i < 4; ++i) Must(server.simulation(), &Simulation::CreateEntity, create);
  v1::ListEntitiesRequest request;
  request.set_world(create.world());

  const auto first = Must(server.simulation(), &Simulation::ListEntities, request);
  request.set_page_token(first.next_page_token());
  const auto second = Must(server.simulation(), &Simulation::ListEntities, request);

  EXPECT_EQ(first.entities_size(), 3);
  EXPECT_EQ(second.entities_size(), 1);
  EXPECT_TRUE(second.next_page_token().empty());
}

TEST(ListEntities, RefusesTheTokenOfAnotherEpoch) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  server.AddBall(world, 3);
  v1::ListEntitiesRequest request;
  request.set_world(world);
  request.set_page_size(1);
  request.set_page_token(Must(server.simulation(), &Simulation::ListEntities, request).next_page_token());
  ASSERT_FALSE(request.page_token().empty());
  Must(server.simulation(), &Simulation::ListEntities, request);
  v1::ResetWorldRequest reset;
  reset.set_name(world);
  Must(server.worlds(), &v1::WorldService::Stub::ResetWorld, reset);

  ExpectRefusal(MustNot(server.simulation(), &Simulation::ListEntities, request), Reason::kInvalidValue, "page_token");
}

TEST(ListEntities, HasTokensThatNoOtherListTakes) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  server.AddBall(world, 3);
  v1::ListEntitiesRequest request;
  request.set_world(world);
  request.set_page_size(1);
  const std::string token = Must(server.simulation(), &Simulation::ListEntities, request).next_page_token();
  ASSERT_FALSE(token.empty());
  v1::ListJointsRequest joints;
  joints.set_world(world);
  joints.set_page_token(token);
  v1::ListForceFieldsRequest fields;
  fields.set_world(world);
  fields.set_page_token(token);

  ExpectRefusal(MustNot(server.simulation(), &Simulation::ListJoints, joints), Reason::kInvalidValue, "page_token");
  ExpectRefusal(MustNot(server.simulation(), &Simulation::ListForceFields, fields), Reason::kInvalidValue,
                "page_token");
}

TEST(ListJoints, PagesThroughAllOfThemWithWhatTheyDo) {
  TestServer server;
  v1::StepRequest step;
  step.set_world(server.CreateWorld().world().name());
  for (uint32_t i = 0; i < 3; ++i) {
    v1::Entity* const entity = step.add_commands()->mutable_create_entity()->mutable_entity();
    entity->mutable_pose()->mutable_position()->set_x(2 * i);
    entity->mutable_pose()->mutable_position()->set_z(3);
    entity->mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_sphere();
    v1::Joint* const joint = step.add_commands()->mutable_create_joint()->mutable_joint();
    joint->mutable_entity_b()->set_created_by_command(2 * i);
    joint->mutable_hinge()->mutable_motor()->set_target_velocity(i);
  }
  step.set_steps(60);
  step.mutable_frame()->set_joints(true);
  const v1::StepResponse stepped = Must(server.simulation(), &Simulation::Step, step);

  v1::ListJointsRequest request;
  request.set_world(step.world());
  request.set_page_size(2);
  const v1::ListJointsResponse first = Must(server.simulation(), &Simulation::ListJoints, request);
  request.set_page_token(first.next_page_token());
  const v1::ListJointsResponse last = Must(server.simulation(), &Simulation::ListJoints, request);

  ASSERT_EQ(first.joints_size(), 2);
  ASSERT_EQ(last.joints_size(), 1);
  EXPECT_TRUE(last.next_page_token().empty());
  EXPECT_EQ(last.joints(0).id(), stepped.results(5).created_id());
  EXPECT_EQ(last.joints(0).entity_b().id(), stepped.results(4).created_id());
  EXPECT_EQ(last.joints(0).frame_in_a().position().x(), 4) << "where the entity was when it was joined";
  ASSERT_EQ(last.states_size(), 1);
  EXPECT_EQ(last.states(0).joint_id(), last.joints(0).id());
  EXPECT_NEAR(last.states(0).positions(5), 2, 1e-5) << "a second at two radians per second";
  EXPECT_NEAR(last.states(0).rates(5), 2, 1e-5);
  EXPECT_GT(last.states(0).force().z(), 0);
  // The same in columns.
  ASSERT_EQ(stepped.frame().joint_ids().size(), 3 * sizeof(uint64_t));
  ASSERT_EQ(stepped.frame().joint_positions().size(), 18 * sizeof(double));
  EXPECT_EQ(stepped.frame().joint_rates().size(), 18 * sizeof(double));
  EXPECT_EQ(stepped.frame().joint_forces().size(), 18 * sizeof(double));
  double angle = 0;
  std::memcpy(&angle, stepped.frame().joint_positions().data() + 17 * sizeof(double), sizeof angle);
  EXPECT_EQ(angle, last.states(0).positions(5));
}

TEST(ListJoints, IsEmptyAsLongAsThereAreNone) {
  TestServer server;
  v1::ListJointsRequest request;
  request.set_world(server.CreateWorld().world().name());

  const auto joints = Must(server.simulation(), &Simulation::ListJoints, request);

  EXPECT_EQ(joints.joints_size(), 0);
  EXPECT_NE(joints.stamp().epoch(), 0u);
}

TEST(Step, CarriesCommandsInAndAFrameEventsAndStatisticsOut) {
  TestServer server;
  v1::StepRequest request;
  request.set_world(server.CreateWorld().world().name());
  v1::Entity& ball = *request.add_commands()->mutable_create_entity()->mutable_entity();
  ball.mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_sphere()->set_radius(0.5);
  ball.mutable_pose()->mutable_position()->set_z(2);
  request.add_commands()->mutable_set_gravity()->mutable_gravity()->set_z(-1);
  request.set_steps(60);
  request.mutable_frame()->set_poses(true);
  request.mutable_frame()->set_velocities(true);
  request.mutable_events();
  request.set_stats(true);

  const auto stepped = Must(server.simulation(), &Simulation::Step, request);

  EXPECT_EQ(stepped.stamp().step(), 60u);
  ASSERT_EQ(stepped.results_size(), 2);
  EXPECT_NE(stepped.results(0).created_id(), 0u);
  EXPECT_EQ(stepped.results(1).created_id(), 0u);
  // The floor and the ball.
  EXPECT_EQ(Doubles(stepped.frame().positions()).size(), 6u);
  EXPECT_EQ(Doubles(stepped.frame().linear_velocities()).size(), 6u);
  EXPECT_EQ(stepped.frame().stamp().step(), 60u);
  ASSERT_GT(stepped.events().events_size(), 0);
  EXPECT_EQ(stepped.events().events(0).entity_created().entity().id(), stepped.results(0).created_id());
  EXPECT_EQ(stepped.events().first_sequence(), 2u);  // the floor came first
  EXPECT_GE(stepped.events().last_sequence(), 2u);
  EXPECT_EQ(
      stepped.stats().entities_in_engine() + stepped.stats().entities_in_flight() + stepped.stats().entities_asleep(),
      1u);
}

TEST(Step, AppliesAllCommandsOrNone) {
  TestServer server;
  v1::World wanted;
  wanted.set_record_state_hash(true);
  const auto created = server.CreateWorld(wanted);
  v1::StepRequest request;
  request.set_world(created.world().name());
  request.add_commands()->mutable_set_gravity()->mutable_gravity()->set_z(-1);
  request.add_commands()->mutable_delete_entity()->set_entity_id(uint64_t{5} << 32 | 5);

  ExpectRefusal(MustNot(server.simulation(), &Simulation::Step, request), Reason::kEntityNotFound,
                "commands[1].delete_entity.entity_id");

  v1::GetWorldRequest get;
  get.set_name(created.world().name());
  const auto now = Must(server.worlds(), &v1::WorldService::Stub::GetWorld, get);
  EXPECT_EQ(now.stamp().state_hash(), created.stamp().state_hash());
}

TEST(Step, TakesOneStepByDefaultAndNoneWhenTold) {
  TestServer server;
  v1::StepRequest request;
  request.set_world(server.CreateWorld().world().name());

  EXPECT_EQ(Must(server.simulation(), &Simulation::Step, request).stamp().step(), 1u);
  request.set_steps(0);
  EXPECT_EQ(Must(server.simulation(), &Simulation::Step, request).stamp().step(), 1u);
  request.set_steps(100001);
  ExpectRefusal(MustNot(server.simulation(), &Simulation::Step, request), Reason::kOutOfRange, "steps");
}

TEST(Step, CanBeGivenItsOwnSize) {
  TestServer server;
  v1::StepRequest request;
  request.set_world(server.CreateWorld().world().name());
  request.set_step_size_seconds(0.125);
  request.set_steps(2);

  EXPECT_EQ(Must(server.simulation(), &Simulation::Step, request).stamp().simulation_time_seconds(), 0.25);
  request.set_step_size_seconds(0.3);
  ExpectRefusal(MustNot(server.simulation(), &Simulation::Step, request), Reason::kOutOfRange, "step_size_seconds");
}

TEST(Step, RefusesAnotherStepThanExpected) {
  TestServer server;
  v1::StepRequest request;
  request.set_world(server.CreateWorld().world().name());
  request.set_expected_step(0);
  Must(server.simulation(), &Simulation::Step, request);

  ExpectRefusal(MustNot(server.simulation(), &Simulation::Step, request), Reason::kStepMismatch, "expected_step");
}

TEST(CastRays, FindsTheFloor) {
  constexpr double kTolerance = 1e-12;
  TestServer server;
  v1::CastRaysRequest request;
  request.set_world(server.CreateWorld().world().name());
  const double origin[3] = {0, 0, 4}, down[3] = {0, 0, -8};
  request.set_origins(std::string(reinterpret_cast<const char*>(origin), sizeof(origin)));
  request.set_translations(std::string(reinterpret_cast<const char*>(down), sizeof(down)));

  const auto hits = Must(server.simulation(), &Simulation::CastRays, request);

  ASSERT_EQ(Doubles(hits.fractions()).size(), 1u);
  EXPECT_NEAR(Doubles(hits.fractions())[0], 0.5, kTolerance);
  EXPECT_NEAR(Doubles(hits.normals())[2], 1, kTolerance);
}

TEST(EveryRequest, OfBytesThatAreNoMessageIsRefused) {
  TestServer server;
  const std::string world = server.CreateWorld().world().name();
  // Field 1 says that it has more bytes than there are; field 2 of a step, a command, is no message.
  const std::string cut_off =
      "\x0a\x7f"
      "abc";
  v1::StepRequest step;
  step.set_world(world);
  const std::string bad_inside = step.SerializeAsString() + "\x12\x03\x0a\x7f\x01";

  for (const char* method :
       {"WorldService/CreateWorld", "WorldService/GetWorld", "WorldService/ListWorlds", "WorldService/DeleteWorld",
        "WorldService/ResetWorld", "WorldService/PlayWorld", "WorldService/PauseWorld",
        "SimulationService/CreateEntity", "SimulationService/DeleteEntity", "SimulationService/ApplyForce",
        "SimulationService/GetEntity", "SimulationService/ListEntities", "SimulationService/ListJoints",
        "SimulationService/Step", "SimulationService/CastRays"}) {
    std::string reply;
    const grpc::Status status = CallRaw(server.channel(), std::string("/genphys.v1.") + method, cut_off, &reply);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << method << ": " << status.error_message();
  }
  std::string reply;
  const grpc::Status inside = CallRaw(server.channel(), "/genphys.v1.SimulationService/Step", bad_inside, &reply);
  EXPECT_EQ(inside.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << inside.error_message();
  EXPECT_EQ(server.Step(world).stamp().step(), 1u);
}

TEST(EveryRequest, BeyondTheLargestSizeIsRefused) {
  TestServer server;
  std::string reply;

  const grpc::Status status = CallRaw(server.channel(), "/genphys.v1.WorldService/CreateWorld",
                                      std::string(Server::kRequestBytesMax + 1, '\0'), &reply);

  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
  server.CreateWorld();
}

}  // namespace
}  // namespace genphys::testing

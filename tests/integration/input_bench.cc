#include "integration/input_bench.h"

#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>

#include <memory>
#include <set>

#include "genphys/v1/world_service.pb.h"

namespace genphys::testing {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::MessageFactory;
using google::protobuf::MethodDescriptor;
using google::protobuf::TextFormat;

constexpr char kWorld[] = "worlds/a";
constexpr uint64_t kFieldId = 1;  // of the scene's only one
constexpr uint32_t kStepsBefore = 3, kStepsAfter = 100;
// One mistake shows in hundreds of cases: a few say what it is.
constexpr int kComplaintsMax = 20;

// Every shape, every way to move, and two driven joints; a ball lies on a crate. Nothing moves for long, for one case
// is as many steps as a call can have.
constexpr char kScene[] = R"(
  world: "worlds/a"
  commands { create_entity { entity { display_name: "soon gone" } } }
  commands { create_entity { entity {
    pose { position { z: 0.5 } } rigid_body { geometries { shape { box {} } } } } } }
  commands { create_entity { entity {
    pose { position { z: 1.5 } } rigid_body { geometries { shape { sphere {} } } } } } }
  commands { create_entity { entity {
    pose { position { x: 3 z: 1 } } rigid_body { geometries { shape { capsule {} } } } } } }
  commands { create_entity { entity {
    pose { position { x: 3 y: 3 z: 0.5 } } rigid_body { geometries { shape { cylinder {} } } } } } }
  commands { create_entity { entity { pose { position { x: -3 z: 1 } }
    rigid_body { motion_type: MOTION_TYPE_KINEMATIC
                 geometries { shape { box {} } } } } } }
  commands { create_entity { entity { pose { position { x: 3 z: 1 } }
    rigid_body { motion_type: MOTION_TYPE_STATIC geometries { is_sensor: true shape { box {} } } } } } }
  commands { create_entity { entity {
    pose { position { x: -6 z: 2 } } rigid_body { geometries { shape { sphere {} } } } } } }
  commands { create_entity { entity {
    pose { position { x: -9 z: 2 } } rigid_body { geometries { shape { sphere {} } } } } } }
  commands { create_joint { joint {
    entity_b { created_by_command: 7 } slider { motor { target_metres: 0 stiffness: 1e6 damping: 1e5 } } } } }
  commands { create_joint { joint {
    entity_b { created_by_command: 8 } slider { motor { target_metres: 0 stiffness: 1e6 damping: 1e5 } } } } }
  commands { create_force_field { field { uniform {} } } }
)";

const std::set<std::string>& ChangingMethods() {
  static const std::set<std::string> names{"ResetWorld", "PlayWorld", "PauseWorld", "CreateEntity", "DeleteEntity",
                                           "ApplyForce", "Step",      "StepWorlds", "Drive"};
  return names;
}

std::unique_ptr<Message> NewMessage(const google::protobuf::Descriptor* type) {
  return std::unique_ptr<Message>(MessageFactory::generated_factory()->GetPrototype(type)->New());
}

const MethodDescriptor& MethodNamed(const std::string& name) {
  for (const MethodDescriptor* method : Methods()) {
    if (method->name() == name) return *method;
  }
  throw std::runtime_error("the contract has no method " + name);
}

}  // namespace

InputBench::InputBench(const std::string& engine) : engine_(engine) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  channel_ = grpc::CreateCustomChannel(server_.address(), grpc::InsecureChannelCredentials(), arguments);
  Rebuild();
}

void InputBench::Complete(Message& message) const {
  const auto& reflection = *message.GetReflection();
  if (auto* body = dynamic_cast<v1::RigidBody*>(&message); body != nullptr && body->geometries_size() == 0) {
    body->add_geometries()->mutable_shape()->mutable_sphere();
  }
  if (auto* world = dynamic_cast<v1::World*>(&message)) world->set_engine("engines/" + engine_);
  if (auto* update = dynamic_cast<v1::UpdateEntity*>(&message)) update->mutable_entity()->set_id(ball_);
  if (auto* joint = dynamic_cast<v1::Joint*>(&message); joint != nullptr && !joint->has_entity_b()) {
    joint->mutable_entity_b()->set_id(ball_);
  }
  if (auto* update = dynamic_cast<v1::UpdateJoint*>(&message)) update->mutable_joint()->set_id(joints_[0]);
  if (auto* motors = dynamic_cast<v1::SetMotorColumns*>(&message)) {
    for (const uint64_t id : joints_) {
      motors->mutable_joint_ids()->append(reinterpret_cast<const char*>(&id), sizeof id);
    }
  }
  if (auto* columns = dynamic_cast<v1::ApplyForceColumns*>(&message)) {
    for (const uint64_t id : {ball_, crate_}) {
      columns->mutable_entity_ids()->append(reinterpret_cast<const char*>(&id), sizeof id);
    }
  }
  if (auto* update = dynamic_cast<v1::UpdateForceField*>(&message)) update->mutable_field()->set_id(kFieldId);
  if (auto* remove = dynamic_cast<v1::DeleteForceField*>(&message)) remove->set_field_id(kFieldId);
  if (auto* field = dynamic_cast<v1::ForceField*>(&message); field != nullptr && field->entity_ids_size() == 1) {
    field->set_entity_ids(0, ball_);
  }
  if (auto* spring = dynamic_cast<v1::SpringField*>(&message)) {
    spring->set_entity_a(ball_);
    if (spring->entity_b() != 0) spring->set_entity_b(crate_);
  }
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    if (field->name() == "entity_id") reflection.SetUInt64(&message, field, ball_);
    if (field->name() == "joint_id") reflection.SetUInt64(&message, field, joints_[0]);
    if (field->message_type() == nullptr) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      Complete(field->is_repeated() ? *reflection.MutableRepeatedMessage(&message, field, i)
                                    : *reflection.MutableMessage(&message, field));
    }
  }
}

Answer InputBench::Send(const std::string& method, const Message& request) const {
  return CallAny(channel_, MethodNamed(method), request.SerializeAsString());
}

void InputBench::Rebuild() {
  v1::DeleteWorldRequest remove;
  remove.set_name(kWorld);
  Send("DeleteWorld", remove);
  v1::CreateWorldRequest create;
  create.mutable_world()->set_name(kWorld);
  create.mutable_world()->set_engine("engines/" + engine_);
  create.mutable_world()->set_record_state_hash(true);
  const Answer made = Send("CreateWorld", create);
  if (!made.status.ok()) throw std::runtime_error("no world can be made: " + VerdictOf(made.status));
  v1::StepRequest request;
  if (!TextFormat::ParseFromString(kScene, &request)) throw std::runtime_error("the scene is no request");
  const v1::StepResponse built = MustStep(request);
  stale_ = built.results(0).created_id();
  crate_ = built.results(1).created_id();
  ball_ = built.results(2).created_id();
  joints_ = {built.results(9).created_id(), built.results(10).created_id()};
  request.clear_commands();
  request.add_commands()->mutable_delete_entity()->set_entity_id(stale_);
  request.set_steps(kStepsBefore);
  stamp_ = MustStep(request).stamp();
}

v1::StepResponse InputBench::MustStep(const v1::StepRequest& request) const {
  const Answer answer = Send("Step", request);
  v1::StepResponse response;
  if (answer.status.ok() && response.ParseFromString(answer.reply)) return response;
  throw std::runtime_error("the scene cannot be set up: " + VerdictOf(answer.status));
}

v1::WorldStamp InputBench::StampNow() const {
  v1::GetWorldRequest request;
  request.set_name(kWorld);
  const Answer answer = Send("GetWorld", request);
  v1::GetWorldResponse response;
  if (!answer.status.ok() || !response.ParseFromString(answer.reply)) {
    throw std::runtime_error("the world cannot be read: " + VerdictOf(answer.status));
  }
  return response.stamp();
}

void InputBench::Complain(const std::string& what, const std::string& complaint) {
  if (++complaints_ <= kComplaintsMax) ADD_FAILURE() << engine_ << ": " << what << ": " << complaint;
}

void InputBench::Try(const MethodDescriptor& method, const Message& request, const std::string& wanted,
                     const std::string& what) {
  Try(method, request.SerializeAsString(), wanted, what);
}

void InputBench::Try(const MethodDescriptor& method, const std::string& request, const std::string& wanted,
                     const std::string& what) {
  const Answer answer = CallAny(channel_, method, request);
  const std::string verdict = VerdictOf(answer.status);
  if (verdict != wanted) {
    Complain(what, verdict + ", wanted " + wanted + " (" + answer.status.error_message() + ")");
    return Rebuild();
  }
  if (verdict == "accepted") return GoOn(method, answer.reply, what);
  MustBeUnchanged(what);
}

bool InputBench::TryEither(const MethodDescriptor& method, const Message& request, const std::string& what) {
  const Answer answer = CallAny(channel_, method, request.SerializeAsString());
  if (answer.status.ok()) {
    GoOn(method, answer.reply, what);
    return true;
  }
  const std::string verdict = VerdictOf(answer.status);
  if (verdict.starts_with("code ") || verdict.starts_with("DIVERGED")) {
    Complain(verdict + " (" + answer.status.error_message() + ")", what);
    Rebuild();
  } else {
    MustBeUnchanged(what);
  }
  return false;
}

void InputBench::MustBeUnchanged(const std::string& what) {
  // The epoch and the time are parts of a stamp too: nothing about the world may have moved.
  if (google::protobuf::util::MessageDifferencer::Equals(StampNow(), stamp_)) return;
  Complain(what, "refused, and yet it changed the world");
  Rebuild();
}

void InputBench::TryStep(const std::string& text, const std::string& wanted) {
  v1::StepRequest request;
  ASSERT_TRUE(TextFormat::ParseFromString(text, &request)) << text;
  request.set_world(kWorld);
  Try(MethodNamed("Step"), request, wanted, text);
}

void InputBench::GoOn(const MethodDescriptor& method, const std::string& reply, const std::string& what) {
  const std::unique_ptr<Message> response = NewMessage(method.output_type());
  if (!response->ParseFromString(reply)) return Complain(what, "the reply cannot be read");
  if (const std::string path = FirstNotFinite(*response); !path.empty()) Complain(what, path + " is not finite");
  if (const auto* created = dynamic_cast<const v1::CreateWorldResponse*>(response.get())) {
    StepOn(created->world().name(), what);
    v1::DeleteWorldRequest remove;
    remove.set_name(created->world().name());
    Send("DeleteWorld", remove);
    return;
  }
  if (method.name() == "DeleteWorld") return Rebuild();
  if (!ChangingMethods().contains(method.name())) {
    if (StampNow().state_hash() != stamp_.state_hash()) Complain(what, "a question changed the world");
    return;
  }
  if (method.name() == "PlayWorld") {
    v1::PauseWorldRequest pause;
    pause.set_name(kWorld);
    Send("PauseWorld", pause);
  }
  StepOn(kWorld, what);
  Rebuild();
}

void InputBench::StepOn(const std::string& world, const std::string& what) {
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(kStepsAfter);
  if (world != kWorld) {
    // In a world that the case made there is nothing yet that could go wrong.
    v1::Entity* const entity = request.add_commands()->mutable_create_entity()->mutable_entity();
    entity->mutable_pose()->mutable_position()->set_z(0.6);
    entity->mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_box();
  }
  request.mutable_frame()->set_poses(true);
  request.mutable_frame()->set_velocities(true);
  request.mutable_frame()->set_net_forces(true);
  request.mutable_frame()->set_joints(true);
  request.mutable_events();
  const Answer answer = Send("Step", request);
  v1::StepResponse response;
  if (!answer.status.ok() || !response.ParseFromString(answer.reply)) {
    return Complain(
        "accepted, but the steps after it: " + VerdictOf(answer.status) + " (" + answer.status.error_message() + ")",
        what);
  }
  if (const std::string path = FirstNotFinite(response); !path.empty()) {
    Complain(what, "100 steps later " + path + " is not finite");
  }
}

}  // namespace genphys::testing

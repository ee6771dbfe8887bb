// The model by itself refuses every number that the contract refuses: who uses it in process, without the wire in
// front, has the same limits.
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <set>

#include "genphys/v1/simulation_service.pb.h"
#include "genphys/wire/decode.h"
#include "support/joints.h"
#include "support/limit_cases.h"
#include "support/requests.h"
#include "support/scenes.h"

namespace genphys::testing {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// Things to name: what a command needs to be about.
class ModelLimits : public ::testing::Test {
 protected:
  ModelLimits() : world_(MakeWorld("ode")) {
    ball_ = Add(*world_, Ball({0, 0, 5}));
    crate_ = Add(*world_, Crate({3, 0, 5}));
    HingeJoint hinge;
    hinge.axis.motor = Motor{.target_position = 0, .stiffness = 10};
    joint_ = Join(*world_, Between(ball_, crate_, hinge));
    other_joint_ = Join(*world_, ToWorld(crate_, hinge));
    Do(*world_, CreateForceField{{.kind = UniformField{}}});
  }

  void Complete(Message& message) const {
    if (auto* body = dynamic_cast<v1::RigidBody*>(&message); body != nullptr && body->geometries_size() == 0) {
      body->add_geometries()->mutable_shape()->mutable_sphere();
    }
    if (auto* update = dynamic_cast<v1::UpdateEntity*>(&message)) update->mutable_entity()->set_id(ball_.packed());
    if (auto* joint = dynamic_cast<v1::Joint*>(&message); joint != nullptr && !joint->has_entity_b()) {
      joint->mutable_entity_b()->set_id(ball_.packed());
    }
    if (auto* update = dynamic_cast<v1::UpdateJoint*>(&message)) update->mutable_joint()->set_id(joint_.packed());
    const auto name = [](std::string& column, std::initializer_list<uint64_t> ids) {
      column.clear();
      for (const uint64_t id : ids) column.append(reinterpret_cast<const char*>(&id), sizeof id);
    };
    if (auto* motors = dynamic_cast<v1::SetMotorColumns*>(&message)) {
      name(*motors->mutable_joint_ids(), {joint_.packed(), other_joint_.packed()});
    }
    if (auto* forces = dynamic_cast<v1::ApplyForceColumns*>(&message)) {
      name(*forces->mutable_entity_ids(), {ball_.packed(), crate_.packed()});
    }
    if (auto* update = dynamic_cast<v1::UpdateForceField*>(&message)) update->mutable_field()->set_id(1);
    if (auto* spring = dynamic_cast<v1::SpringField*>(&message)) spring->set_entity_a(ball_.packed());
    CompleteHeld(message);
  }

  void CompleteHeld(Message& message) const {
    const auto& reflection = *message.GetReflection();
    std::vector<const FieldDescriptor*> fields;
    reflection.ListFields(message, &fields);
    for (const FieldDescriptor* field : fields) {
      if (field->name() == "entity_id") reflection.SetUInt64(&message, field, ball_.packed());
      if (field->message_type() == nullptr) continue;
      const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
      for (int i = 0; i < count; ++i) {
        Complete(field->is_repeated() ? *reflection.MutableRepeatedMessage(&message, field, i)
                                      : *reflection.MutableMessage(&message, field));
      }
    }
  }

  // What the decoder and the model say to the commands, or to the step.
  Status Try(const v1::StepRequest& request) {
    const Result<std::vector<Command>> commands = DecodeCommands(request.commands());
    if (!commands.ok()) return commands.status();
    GENPHYS_RETURN_IF_ERROR(world_->Apply(*commands).status());
    if (!request.has_step_size_seconds()) return Status();
    return world_->Step(request.step_size_seconds());
  }

  std::unique_ptr<World> world_;
  EntityId ball_, crate_;
  JointId joint_, other_joint_;
};

// Texts, lists and columns are the wire's own matter: the model has what they hold in memory already.
bool IsAboutANumber(const LimitCase& probe) {
  static const std::set<std::string> kProbes{"NaN",       "+infinity", "-infinity", "below min",
                                             "above max", "zero",      "too long",  "too short"};
  return probe.refusal && kProbes.contains(probe.probe);
}

bool IsAboutTheModel(const LimitCase& probe) {
  // A change of a joint leaves the entities that it joins as they are, whoever is named.
  if (probe.field.starts_with("commands[0].update_joint") && probe.field.ends_with("created_by_command")) return false;
  return probe.field.starts_with("commands[0].") || probe.field == "step_size_seconds";
}

TEST_F(ModelLimits, AreNoWiderThanTheDeclaredOnes) {
  const auto sample = MinimalRequest(v1::StepRequest::descriptor());
  std::set<std::string> fields;
  ForEachLimitCase(*sample, {.complete = [&](Message& added) { Complete(added); }}, [&](const LimitCase& probe) {
    if (!IsAboutANumber(probe) || !IsAboutTheModel(probe)) return;
    fields.insert(probe.field);
    v1::StepRequest request;
    request.CopyFrom(probe.request);
    EXPECT_FALSE(Try(request).ok()) << probe.field << " " << probe.probe;
  });
  EXPECT_GT(fields.size(), 100u);
}

}  // namespace
}  // namespace genphys::testing

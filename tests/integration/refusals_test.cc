// What declared limits cannot say is refused too: ids that name nothing, bodies that cannot be, batches that are good
// only in part.
#include <gtest/gtest.h>

#include <cstring>

#include "conformance/engine_test.h"
#include "integration/input_bench.h"
#include "support/limit_cases.h"

namespace genphys::testing {
namespace {

std::string Number(uint64_t number) { return std::to_string(number); }

// A column with one id, as text format writes it.
std::string Column(uint64_t id) {
  std::string escaped;
  for (size_t i = 0; i < sizeof id; ++i) {
    char octal[5];
    std::snprintf(octal, sizeof octal, "\\%03o", static_cast<unsigned>((id >> (8 * i)) & 0xff));
    escaped += octal;
  }
  return escaped;
}

// The method that takes requests of this type.
const google::protobuf::MethodDescriptor& MethodFor(const google::protobuf::Descriptor& request) {
  for (const auto* method : Methods()) {
    if (method->input_type() == &request) return *method;
  }
  throw std::runtime_error("no method takes a " + request.name());
}

class LiveRefusal : public EngineTest {
 protected:
  // A command that creates a body, in text format.
  static std::string Body(const std::string& body) {
    return "commands { create_entity { entity { pose { position { x: 20 z: 5 } } rigid_body { " + body + " } } } }";
  }

  InputBench bench_{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Engines, LiveRefusal, ::testing::ValuesIn(EnginesWithContacts()), EngineName);

TEST_P(LiveRefusal, MeetsEveryIdThatNamesNothing) {
  struct Forgery {
    uint64_t id;
    std::string reason;
  };
  const uint64_t next_generation = uint64_t{1} << 32;
  const std::vector<Forgery> forgeries{{0, "MISSING_FIELD"},
                                       {bench_.stale(), "STALE_ID"},
                                       {uint64_t{1} << 32, "ENTITY_NOT_FOUND"},
                                       {bench_.ball() + next_generation, "ENTITY_NOT_FOUND"},
                                       {1'000'000, "ENTITY_NOT_FOUND"},
                                       {0xffff'ffff, "ENTITY_NOT_FOUND"},
                                       {~uint64_t{0}, "ENTITY_NOT_FOUND"}};
  struct Place {
    std::string before, after, field;
  };
  const std::vector<Place> places{
      {"delete_entity { entity_id: ", " }", "delete_entity.entity_id"},
      {"apply_force { force { x: 1 } entity_id: ", " }", "apply_force.entity_id"},
      {"apply_impulse { linear { x: 1 } entity_id: ", " }", "apply_impulse.entity_id"},
      {"set_velocity { linear { x: 1 } entity_id: ", " }", "set_velocity.entity_id"},
      {"set_pose { pose { position { x: 1 } } entity_id: ", " }", "set_pose.entity_id"},
      {"update_entity { entity { display_name: \"a\" id: ", " } }", "update_entity.entity.id"}};

  for (const Forgery& forgery : forgeries) {
    for (const Place& place : places) {
      bench_.TryStep("commands { " + place.before + Number(forgery.id) + place.after + " }",
                     forgery.reason + " commands[0]." + place.field);
    }
    bench_.TryStep("commands { apply_forces { entity_ids: \"" + Column(bench_.ball()) + Column(forgery.id) + "\" } }",
                   forgery.reason + " commands[0].apply_forces.entity_ids[1]");
    // What is gone is left out of a frame.
    bench_.TryStep("frame { entity_ids: " + Number(bench_.ball()) + " entity_ids: " + Number(forgery.id) + " }",
                   forgery.reason == "STALE_ID" ? "accepted" : forgery.reason + " frame.entity_ids[1]");
  }
  for (const Place& place : places) {
    bench_.TryStep("commands { " + place.before + Number(bench_.ball()) + place.after + " }", "accepted");
  }
  bench_.TryStep("commands { apply_forces { entity_ids: \"" + Column(bench_.ball()) + "\" } }", "accepted");
}

TEST_P(LiveRefusal, MeetsAnIdThatTheSameBatchDeletes) {
  const std::string ball = Number(bench_.ball());
  const std::string push = "commands { apply_force { entity_id: " + ball + " force { x: 1 } } }";
  const std::string remove = "commands { delete_entity { entity_id: " + ball + " } }";

  bench_.TryStep(remove + push, "STALE_ID commands[1].apply_force.entity_id");
  bench_.TryStep(push + remove, "accepted");
}

TEST_P(LiveRefusal, OfOneCommandLeavesNothingOfTheBatch) {
  const std::string good =
      Body("geometries { shape { box {} } }") +
      "commands { set_gravity { gravity { z: -1 } } } commands { delete_entity { entity_id: " + Number(bench_.crate()) +
      " } }";
  const std::string engine = "commands { set_engine { engine: \"engines/none\" } }";

  bench_.TryStep(good + engine + "commands { set_engine { engine: \"engines/perpetuum\" } }",
                 "INVALID_VALUE commands[4].set_engine.engine");
  bench_.TryStep(good + engine + "commands {}", "MISSING_FIELD commands[4].kind");
  bench_.TryStep(good + engine + "expected_step: 7", "STEP_MISMATCH expected_step");
  bench_.TryStep(good, "accepted");
}

TEST_P(LiveRefusal, MeetsInertiaThatNoBodyHas) {
  const std::string sphere = "geometries { shape { sphere {} } } ";
  const auto tensor = [&](const std::string& elements) {
    return Body(sphere + "inertia { tensor: [" + elements + "] }");
  };
  const std::string impossible = "INVALID_VALUE commands[0].create_entity.entity.rigid_body.inertia.tensor";

  bench_.TryStep(tensor("1, 0, 0, 1, 0, 2.1"), impossible);
  bench_.TryStep(tensor("1, 0, 0, 1, 0, 2"), "accepted");
  bench_.TryStep(tensor("1, 0, 0, 1, 0, 0"), impossible);
  bench_.TryStep(tensor("1, 0, 0, -1, 0, 1"), impossible);
  bench_.TryStep(tensor("1, 1.01, 0, 1, 0, 1"), impossible);
  bench_.TryStep(tensor("1, 0.4, 0, 1, 0, 1"), "accepted");
  bench_.TryStep(tensor("1e20, 0, 0, 1e20, 0, 1e20"), "accepted");
  bench_.TryStep(tensor("1e-9, 0, 0, 1e-9, 0, 1e-9"), "accepted");
}

TEST_P(LiveRefusal, MeetsABodyWithoutMass) {
  const std::string body = "commands[0].create_entity.entity.rigid_body";

  bench_.TryStep(Body(""), "MISSING_FIELD " + body + ".inertia.mass");
  bench_.TryStep(Body("inertia { mass: 1 }"), "MISSING_FIELD " + body + ".inertia.tensor");
  bench_.TryStep(Body("inertia { mass: 1 tensor: [1, 0, 0, 1, 0, 1] }"), "accepted");
  bench_.TryStep(Body("motion_type: MOTION_TYPE_STATIC"), "accepted");
  bench_.TryStep(Body("geometries { is_sensor: true shape { box {} } }"), "MISSING_FIELD " + body + ".inertia.mass");
}

TEST_P(LiveRefusal, MeetsTwoGeometriesWithOneId) {
  const auto pair = [](const std::string& a, const std::string& b) {
    return Body("geometries { id: " + a + " shape { box {} } } geometries { id: " + b + " shape { sphere {} } }");
  };

  bench_.TryStep(pair("3", "3"), "INVALID_VALUE commands[0].create_entity.entity.rigid_body.geometries[1].id");
  bench_.TryStep(pair("3", "4"), "accepted");
  bench_.TryStep(pair("0", "0"), "accepted");
}

TEST_P(LiveRefusal, MeetsMotionOfWhatDoesNotMove) {
  const std::string floor = Number(1);
  const std::string body = "commands[0].create_entity.entity.rigid_body";

  bench_.TryStep("commands { apply_force { entity_id: " + floor + " force { z: 1 } } }",
                 "INVALID_VALUE commands[0].apply_force.entity_id");
  bench_.TryStep("commands { apply_impulse { entity_id: " + floor + " linear { z: 1 } } }",
                 "INVALID_VALUE commands[0].apply_impulse.entity_id");
  bench_.TryStep("commands { set_velocity { entity_id: " + floor + " linear { z: 1 } } }",
                 "INVALID_VALUE commands[0].set_velocity.entity_id");
  bench_.TryStep("commands { set_pose { entity_id: " + floor + " pose { position { z: -1 } } } }", "accepted");
  bench_.TryStep(Body("motion_type: MOTION_TYPE_STATIC linear_velocity { x: 1 }"),
                 "INVALID_VALUE " + body + ".linear_velocity");
  bench_.TryStep(Body("motion_type: MOTION_TYPE_STATIC angular_velocity { x: 1 }"),
                 "INVALID_VALUE " + body + ".angular_velocity");
  bench_.TryStep(Body("motion_type: MOTION_TYPE_KINEMATIC linear_velocity { x: 1 }"), "accepted");
}

TEST_P(LiveRefusal, MeetsAnUpdateOfWhatIsNotThere) {
  const std::string update = "commands { update_entity { entity { id: " + Number(bench_.ball()) + " } update_mask { ";
  const std::string path = "commands[0].update_entity.update_mask.paths[0]";

  bench_.TryStep(update + "paths: \"rigid_body.colour\" } } }", "INVALID_VALUE " + path);
  bench_.TryStep(update + "paths: \"id\" } } }", "INVALID_VALUE " + path);
  bench_.TryStep(update + "paths: \"rigid_body.error_correction\" } } }", "accepted");
  bench_.TryStep(update + "paths: \"rigid_body.error_correction.slop_metres\" } } }", "INVALID_VALUE " + path);
  bench_.TryStep(update + "paths: \"rigid_body.geometries\" } } }",
                 "MISSING_FIELD commands[0].update_entity.entity.rigid_body.inertia.mass");
  bench_.TryStep(update + "paths: \"rigid_body\" } } }", "accepted");
  bench_.TryStep(update + "paths: \"rigid_body\" } } }" + update + "paths: \"rigid_body.inertia\" } } }",
                 "INVALID_VALUE commands[1].update_entity.update_mask");
}

TEST_P(LiveRefusal, OfAPlaneLooksOnlyAtWhatMakesIt) {
  // The generated cases have dynamic bodies, which may have none.
  v1::CreateEntityRequest sample;
  sample.set_world("worlds/a");
  v1::RigidBody* const body = sample.mutable_entity()->mutable_rigid_body();
  body->set_motion_type(v1::MOTION_TYPE_STATIC);
  body->add_geometries()->mutable_shape()->mutable_plane();
  const google::protobuf::MethodDescriptor& create = MethodFor(*sample.GetDescriptor());
  int accepted = 0;

  ForEachLimitCase(sample, {}, [&](const LimitCase& probe) {
    if (probe.field.find(".plane.") == std::string::npos) return;
    accepted += probe.refusal ? 0 : 1;
    bench_.Try(create, probe.request, VerdictOf(probe.refusal), probe.field + " " + probe.probe);
  });

  EXPECT_GT(accepted, 0);
}

TEST_P(LiveRefusal, MeetsTextThatIsNone) {
  const google::protobuf::MethodDescriptor& create = MethodFor(*v1::CreateEntityRequest::descriptor());
  const auto named = [](const std::string& name) {
    // An entity of which the name is all, as the wire has it: the tags and lengths of entity and display_name.
    const auto size = static_cast<char>(name.size());
    return std::string("\x0a\x08worlds/a\x12") + static_cast<char>(size + 2) + "\x12" + size + name;
  };

  bench_.Try(create, named("\xc3\xa4"), "accepted", "a letter in UTF-8");
  bench_.Try(create, named("\xe4"), "INVALID_VALUE ", "a letter in Latin-1");
  bench_.Try(create, named("\xed\xa0\x80"), "INVALID_VALUE ", "half a surrogate pair");
}

TEST_P(LiveRefusal, MeetsRequestsCutOffAnywhere) {
  v1::StepRequest request;
  request.set_world("worlds/a");
  bench_.Complete(*request.add_commands()->mutable_apply_forces());
  v1::Entity* const entity = request.add_commands()->mutable_create_entity()->mutable_entity();
  entity->set_display_name("a");
  entity->mutable_pose()->mutable_position()->set_x(30);
  entity->mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_box();
  const std::string bytes = request.SerializeAsString();
  const google::protobuf::MethodDescriptor& step = MethodFor(*request.GetDescriptor());

  v1::StepRequest part;
  size_t refused = 0;
  for (size_t size = 0; size < bytes.size(); ++size) {
    const std::string cut = bytes.substr(0, size);
    if (part.ParseFromString(cut)) continue;  // it ends between two fields: another request, and a whole one
    ++refused;
    bench_.Try(step, cut, "INVALID_VALUE ", "the first " + std::to_string(size) + " bytes");
  }
  EXPECT_GT(refused, bytes.size() / 2);
}

}  // namespace
}  // namespace genphys::testing

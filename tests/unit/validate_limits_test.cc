#include "genphys/wire/validate_limits.h"

#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/field_mask.pb.h>
#include <google/protobuf/unknown_field_set.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "genphys/v1/engine_service.pb.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/v1/world_service.pb.h"
#include "support/limit_cases.h"
#include "support/requests.h"

namespace genphys {
namespace {

using google::protobuf::Message;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string Text(const std::optional<Refusal>& refusal) {
  return refusal ? std::string(NameOf(refusal->reason)) + " " + refusal->field : "accepted";
}

std::string Verdict(const Message& message) {
  const Status status = ValidateLimits(message);
  return status.ok() ? "accepted" : Text(RefusalOf(status));
}

v1::StepRequest Request() {
  v1::StepRequest request;
  request.set_world("worlds/w");
  return request;
}

std::string Bytes(const std::vector<double>& scalars) {
  return {reinterpret_cast<const char*>(scalars.data()), scalars.size() * sizeof(double)};
}

class EveryRequest : public testing::TestWithParam<const google::protobuf::Descriptor*> {};

TEST_P(EveryRequest, IsAcceptedWithNoMoreThanItMustHave) {
  const std::unique_ptr<Message> request = MinimalRequest(GetParam());

  EXPECT_EQ(Verdict(*request), "accepted") << request->DebugString();
}

TEST_P(EveryRequest, IsJudgedAsItsDeclaredLimitsSay) {
  // Enough for every list and column at its published maximum.
  constexpr size_t kFieldBytesMax = size_t{64} << 20;
  int wrong = 0;

  ForEachLimitCase(*MinimalRequest(GetParam()), {.field_bytes_max = kFieldBytesMax}, [&](const LimitCase& probe) {
    const std::string verdict = Verdict(probe.request);
    if (verdict == Text(probe.refusal)) return;
    // One mistake in the validator shows in hundreds of cases: a few say what it is.
    if (++wrong <= 5)
      ADD_FAILURE() << probe.field << " " << probe.probe << ": " << verdict << ", wanted " << Text(probe.refusal);
  });

  EXPECT_EQ(wrong, 0);
}

TEST_P(EveryRequest, HasARefusedCaseForEveryNumberInIt) {
  std::set<std::string> refused;
  std::set<std::string> accepted;

  ForEachLimitCase(*MinimalRequest(GetParam()), {},
                   [&](const LimitCase& probe) { (probe.refusal ? refused : accepted).insert(probe.field); });

  for (const ReachableField& f : ReachableFields(GetParam())) {
    const bool is_real = f.field->cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_DOUBLE;
    EXPECT_TRUE(!is_real || refused.count(f.path)) << f.path << " is never refused";
    EXPECT_TRUE(!f.is_bounded_number() || accepted.count(f.path)) << f.path << " is never accepted";
  }
}

INSTANTIATE_TEST_SUITE_P(Wire, EveryRequest, testing::ValuesIn(RequestTypes()),
                         [](const auto& test) { return test.param->name(); });

TEST(ValidateLimits, AcceptsAnEmptyRequestForAWorld) { EXPECT_EQ(Verdict(v1::CreateWorldRequest()), "accepted"); }

TEST(ValidateLimits, AcceptsAShapeWithoutNumbers) {
  v1::CreateEntityRequest request;
  request.set_world("worlds/w");
  request.mutable_entity()->mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_sphere();

  EXPECT_EQ(Verdict(request), "accepted");
}

TEST(ValidateLimits, RefusesAnExplicitZeroRadiusAtItsFullPath) {
  v1::StepRequest request = Request();
  for (int i = 0; i < 4; ++i) request.add_commands()->mutable_create_entity()->mutable_entity();
  auto* body = request.mutable_commands(3)->mutable_create_entity()->mutable_entity()->mutable_rigid_body();
  body->add_geometries()->mutable_shape()->mutable_sphere()->set_radius(0);

  EXPECT_EQ(Verdict(request),
            "OUT_OF_RANGE commands[3].create_entity.entity.rigid_body.geometries[0].shape.sphere.radius");
}

TEST(ValidateLimits, SaysWhatWasWrong) {
  v1::StepRequest request = Request();
  request.set_step_size_seconds(0.5);

  EXPECT_EQ(ValidateLimits(request).message(), "must be at least 1e-06 and at most 0.25, is 0.5");
  EXPECT_EQ(ValidateLimits(request).code(), absl::StatusCode::kInvalidArgument);
}

TEST(ValidateLimits, ShowsAsManyDigitsAsTellAValueFromItsBound) {
  v1::StepRequest request = Request();
  v1::ApplyForce& force = *request.add_commands()->mutable_apply_force();
  force.set_entity_id(1);
  force.set_steps(1'000'000'001);
  EXPECT_EQ(ValidateLimits(request).message(), "must be at least 1 and at most 1e+09, is 1000000001");

  v1::StepRequest step = Request();
  step.set_step_size_seconds(std::nextafter(0.25, 1));
  EXPECT_EQ(ValidateLimits(step).message(), "must be at least 1e-06 and at most 0.25, is 0.2500000000000001");
}

TEST(ValidateLimits, ShowsATextOfAnotherForm) {
  v1::StepRequest request = Request();
  request.add_commands()->mutable_set_engine()->set_engine("bullet");

  EXPECT_EQ(ValidateLimits(request).message(), "must have the form engines/.+, is \"bullet\"");
}

TEST(ValidateLimits, RefusesACommandThatSaysNothing) {
  v1::StepRequest request = Request();
  request.add_commands();

  EXPECT_EQ(Verdict(request), "MISSING_FIELD commands[0].kind");
}

TEST(ValidateLimits, ListsTheAlternativesOfWhatIsUnset) {
  v1::CreateEntityRequest request;
  request.set_world("worlds/a");
  request.mutable_entity()->mutable_rigid_body()->add_geometries()->mutable_shape();

  EXPECT_EQ(ValidateLimits(request).message(),
            "must be one of sphere, box, capsule, cylinder, plane, convex_hull, triangle_mesh, heightfield, cone, "
            "ellipsoid");
}

TEST(ValidateLimits, ListsTheValuesThatAnEnumMayHaveHere) {
  v1::StepRequest request = Request();
  request.mutable_frame()->set_scalar(v1::SCALAR_FIXED64);
  EXPECT_EQ(ValidateLimits(request).message(), "must be one of SCALAR_FLOAT64 = 1, SCALAR_FLOAT32 = 2; is 3");

  v1::CreateWorldRequest create;
  create.mutable_world()->mutable_stepper()->set_quality(static_cast<v1::Stepper::Quality>(7));
  EXPECT_EQ(ValidateLimits(create).message(),
            "must be one of QUALITY_FAST = 1, QUALITY_BALANCED = 2, QUALITY_ACCURATE = 3; is 7");
}

TEST(ValidateLimits, NamesAnUnsetKindOfTheMessageItselfWithoutAPrefix) {
  EXPECT_EQ(Verdict(v1::Command()), "MISSING_FIELD kind");
}

TEST(ValidateLimits, RefusesACommandKindOfALaterVersion) {
  v1::StepRequest request = Request();
  // A field number that this version does not know: the command arrives with nothing in it.
  v1::Command& command = *request.add_commands();
  command.GetReflection()->MutableUnknownFields(&command)->AddVarint(1000, 1);

  EXPECT_EQ(Verdict(request), "MISSING_FIELD commands[0].kind");
}

TEST(ValidateLimits, NamesTheRowAndTheComponentOfAColumn) {
  v1::StepRequest request = Request();
  v1::ApplyForceColumns& columns = *request.add_commands()->mutable_apply_forces();
  columns.set_entity_ids(std::string(5 * 8, '\1'));
  std::vector<double> forces(15, 1.0);
  forces[13] = kNan;
  columns.set_forces(Bytes(forces));
  EXPECT_EQ(Verdict(request), "NOT_FINITE commands[0].apply_forces.forces[4].y");
  forces[13] = 1;
  columns.set_forces(Bytes(forces));
  EXPECT_EQ(Verdict(request), "accepted");
}

TEST(ValidateLimits, NamesTheComponentOfAnOrientationInAColumn) {
  v1::FindOverlapsRequest request;
  request.set_world("worlds/a");
  request.mutable_shape()->mutable_sphere();
  request.set_positions(Bytes({0, 0, 0, 1, 1, 1}));
  request.set_orientations(Bytes({1, 0, 0, 0, 1.5, 0, 0, 0}));
  EXPECT_EQ(Verdict(request), "OUT_OF_RANGE orientations[1].w");
  request.set_orientations(Bytes({1, 0, 0, 0, 1, 0, 0, kNan}));
  EXPECT_EQ(Verdict(request), "NOT_FINITE orientations[1].z");
  request.set_orientations(Bytes({1, 0, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(Verdict(request), "accepted");
}

TEST(ValidateLimits, NamesTheRowAloneOfAColumnOfOneScalar) {
  v1::StepRequest request = Request();
  v1::SetMotorColumns& motors = *request.add_commands()->mutable_set_motors();
  motors.set_joint_ids(std::string(2 * 8, '\1'));
  motors.set_targets(Bytes({1, kNan}));

  EXPECT_EQ(Verdict(request), "NOT_FINITE commands[0].set_motors.targets[1]");
}

TEST(ValidateLimits, AcceptsAColumnOfTorquesWithoutForces) {
  v1::StepRequest request = Request();
  v1::ApplyForceColumns& columns = *request.add_commands()->mutable_apply_forces();
  columns.set_entity_ids(std::string(8, '\1'));
  columns.set_torques(Bytes({-1e12, 0, 1e12}));

  EXPECT_EQ(Verdict(request), "accepted");
}

TEST(ValidateLimits, RefusesForcesWithoutEntities) {
  v1::StepRequest request = Request();
  request.add_commands()->mutable_apply_forces()->set_forces(Bytes({0, 0, 0}));

  EXPECT_EQ(Verdict(request), "INVALID_VALUE commands[0].apply_forces.forces");
}

TEST(ValidateLimits, NamesTheComponentOfAVector) {
  v1::StepRequest request = Request();
  request.add_commands()->mutable_set_gravity()->mutable_gravity()->set_x(-kInfinity);

  EXPECT_EQ(Verdict(request), "NOT_FINITE commands[0].set_gravity.gravity.x");
}

TEST(ValidateLimits, AcceptsZeroInARequiredVector) {
  v1::StepRequest request = Request();
  request.add_commands()->mutable_set_gravity()->mutable_gravity();

  EXPECT_EQ(Verdict(request), "accepted");
}

TEST(ValidateLimits, NeverTakesTheZeroQuaternionForTheIdentity) {
  v1::CreateEntityRequest request;
  request.set_world("worlds/w");
  request.mutable_entity()->mutable_pose()->mutable_orientation();

  EXPECT_EQ(Verdict(request), "NOT_UNIT_LENGTH entity.pose.orientation");
}

TEST(ValidateLimits, ReportsTheFirstOfSeveralViolationsInOrderOfFieldNumbers) {
  v1::StepRequest request;
  request.set_world("worlds/");
  request.add_commands();
  request.set_steps(1'000'000);

  EXPECT_EQ(Verdict(request), "INVALID_VALUE world");
  request.set_world("worlds/w");
  EXPECT_EQ(Verdict(request), "MISSING_FIELD commands[0].kind");
  request.clear_commands();
  EXPECT_EQ(Verdict(request), "OUT_OF_RANGE steps");
}

TEST(ValidateLimits, RefusesNamesOfAnotherFormAndLetsThroughTheirNeighbours) {
  v1::GetWorldRequest request;
  for (const char* name : {"worlds/a", "worlds/A-1.b_c", "worlds/0"}) {
    request.set_name(name);
    EXPECT_EQ(Verdict(request), "accepted") << name;
  }
  for (const char* name :
       {"a", "world/a", "worlds/a/b", "worlds/-a", "worlds/a b", "worlds/ä", " worlds/a", "worlds/a\n"}) {
    request.set_name(name);
    EXPECT_EQ(Verdict(request), "INVALID_VALUE name") << name;
  }
}

TEST(ValidateLimits, RefusesAFeatureThatNamesNothing) {
  v1::CreateWorldRequest request;
  request.mutable_world()->add_required_features(v1::FEATURE_CONTACTS);
  request.mutable_world()->add_required_features(v1::FEATURE_UNSPECIFIED);

  EXPECT_EQ(Verdict(request), "INVALID_VALUE world.required_features[1]");
}

TEST(ValidateLimits, RefusesScalarsThatAFrameCannotHave) {
  v1::StepRequest request = Request();
  request.mutable_frame()->set_scalar(v1::SCALAR_FLOAT32);
  EXPECT_EQ(Verdict(request), "accepted");

  request.mutable_frame()->set_scalar(v1::SCALAR_FIXED64);
  EXPECT_EQ(Verdict(request), "INVALID_VALUE frame.scalar");
}

TEST(ValidateLimits, ReadsMessagesOfOtherClassesWithTheSameDescriptor) {
  const v1::StepRequest request = Request();
  google::protobuf::DynamicMessageFactory factory;
  const std::unique_ptr<Message> dynamic(factory.GetPrototype(v1::StepRequest::descriptor())->New());
  ASSERT_TRUE(dynamic->ParseFromString(request.SerializeAsString()));
  EXPECT_EQ(Verdict(*dynamic), "accepted");

  dynamic->GetReflection()->SetString(dynamic.get(), v1::StepRequest::descriptor()->FindFieldByName("world"), "w");
  EXPECT_EQ(Verdict(*dynamic), "INVALID_VALUE world");
}

TEST(ValidateLimits, RefusesAMessageOfAnotherContract) {
  EXPECT_EQ(Verdict(google::protobuf::FieldMask()), "INVALID_VALUE ");
}

TEST(ValidateLimits, MayBeCalledFirstByManyThreadsAtOnce) {
  constexpr int kThreads = 8;
  std::vector<std::string> verdicts(kThreads);
  std::vector<std::thread> threads;

  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&, i] {
      for (const auto* type : RequestTypes()) {
        const std::string verdict = Verdict(*MinimalRequest(type));
        if (verdict != "accepted") verdicts[static_cast<size_t>(i)] = type->name() + ": " + verdict;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();

  EXPECT_EQ(verdicts, std::vector<std::string>(kThreads));
}

}  // namespace
}  // namespace genphys

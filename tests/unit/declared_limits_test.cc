// What the contract declares is complete, well formed, and the same as the model's own numbers.
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "absl/strings/ascii.h"
#include "genphys/capabilities.h"
#include "genphys/limits.h"
#include "genphys/status.h"
#include "genphys/v1/command.pb.h"
#include "genphys/v1/engine_service.pb.h"
#include "genphys/v1/error.pb.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/v1/world_service.pb.h"
#include "support/limit_fields.h"
#include "support/requests.h"

namespace genphys {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

class DeclaredLimits : public testing::TestWithParam<const Descriptor*> {};

TEST_P(DeclaredLimits, BoundEveryNumber) {
  for (const ReachableField& f : ReachableFields(GetParam())) {
    if (!f.is_number()) continue;
    const bool is_real = f.field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
    const bool any_integer = f.limit->unrestricted() && !is_real;
    EXPECT_TRUE(f.is_bounded_number() || f.limit->unit_length() || any_integer) << f.path << " has no declared limit";
    if (f.is_bounded_number()) {
      EXPECT_TRUE(std::isfinite(f.limit->min()) && std::isfinite(f.limit->max())) << f.path;
      EXPECT_LT(f.limit->min(), f.limit->max()) << f.path;
    }
  }
}

TEST_P(DeclaredLimits, BoundEveryTextListAndColumn) {
  for (const ReachableField& f : ReachableFields(GetParam())) {
    const v1::Limit& limit = *f.limit;
    EXPECT_TRUE(!f.field->is_repeated() || limit.max_items() > 0) << f.path << " may have any number of elements";
    if (f.field->cpp_type() != FieldDescriptor::CPPTYPE_STRING) continue;
    if (limit.has_column()) {
      EXPECT_GT(limit.max_items(), 0u) << f.path << " may have any number of rows";
    } else {
      EXPECT_GT(limit.max_length(), 0u) << f.path << " may be of any length";
    }
  }
}

// `{}` must be usable: where zero is refused, a client that says nothing is told from one that says zero.
TEST_P(DeclaredLimits, RefuseNoZeroThatWasNeverSaid) {
  for (const ReachableField& f : ReachableFields(GetParam())) {
    const bool own = f.limit == &LimitOf(f.field);
    if (!own || !f.is_number() || f.field->is_repeated() || f.field->has_presence()) continue;
    const bool zero_is_refused = f.limit->has_min() && (f.limit->min() > 0 || f.limit->exclusive_min());
    EXPECT_TRUE(!zero_is_refused || f.limit->required()) << f.path << " should be optional or required";
  }
}

TEST_P(DeclaredLimits, DescribeWellFormedColumns) {
  for (const ReachableField& f : ReachableFields(GetParam())) {
    if (!f.limit->has_column()) continue;
    const v1::Column& column = f.limit->column();
    EXPECT_EQ(f.field->type(), FieldDescriptor::TYPE_BYTES) << f.path;
    EXPECT_GT(column.width(), 0u) << f.path;
    EXPECT_NE(column.scalar(), v1::SCALAR_UNSPECIFIED) << f.path;
    if (column.scalar() != v1::SCALAR_FIXED64) {
      EXPECT_TRUE(f.limit->has_min() && f.limit->has_max()) << f.path << " has no declared limit";
    }
    if (column.rows_as().empty()) continue;
    const FieldDescriptor* decider = f.field->containing_type()->FindFieldByName(column.rows_as());
    ASSERT_NE(decider, nullptr) << f.path;
    EXPECT_TRUE(LimitOf(decider).has_column()) << f.path;
    EXPECT_EQ(LimitOf(decider).max_items(), f.limit->max_items()) << f.path;
  }
}

INSTANTIATE_TEST_SUITE_P(Wire, DeclaredLimits, testing::ValuesIn(RequestTypes()),
                         [](const auto& test) { return test.param->name(); });

struct Agreement {
  const Descriptor* type;
  const char* field;
  double min;
  double max;
};

TEST(DeclaredLimits, AreTheLimitsOfTheModel) {
  using L = Limits;
  const Agreement agreements[] = {
      {v1::Inertia::descriptor(), "mass", L::kMassMin, L::kMassMax},
      {v1::Inertia::descriptor(), "tensor", -L::kInertiaMax, L::kInertiaMax},
      {v1::Sphere::descriptor(), "radius", L::kSizeMin, L::kSizeMax},
      {v1::Box::descriptor(), "half_extents", L::kSizeMin, L::kSizeMax},
      {v1::Capsule::descriptor(), "radius", L::kSizeMin, L::kSizeMax},
      {v1::Capsule::descriptor(), "half_length", L::kSizeMin, L::kSizeMax},
      {v1::Cylinder::descriptor(), "radius", L::kSizeMin, L::kSizeMax},
      {v1::Cylinder::descriptor(), "half_length", L::kSizeMin, L::kSizeMax},
      {v1::Cone::descriptor(), "radius", L::kSizeMin, L::kSizeMax},
      {v1::Cone::descriptor(), "half_length", L::kSizeMin, L::kSizeMax},
      {v1::Ellipsoid::descriptor(), "semi_axes", L::kSizeMin, L::kSizeMax},
      {v1::ConvexHull::descriptor(), "vertices", -L::kSizeMax, L::kSizeMax},
      {v1::TriangleMesh::descriptor(), "vertices", -L::kSizeMax, L::kSizeMax},
      {v1::Heightfield::descriptor(), "rows", 2, L::kHeightfieldSideMax},
      {v1::Heightfield::descriptor(), "columns", 2, L::kHeightfieldSideMax},
      {v1::Heightfield::descriptor(), "cell_size", L::kSizeMin, L::kSizeMax},
      {v1::Heightfield::descriptor(), "heights", -L::kSizeMax, L::kSizeMax},
      {v1::Pose::descriptor(), "position", -L::kPositionMax, L::kPositionMax},
      {v1::ApplyForce::descriptor(), "point", -L::kPositionMax, L::kPositionMax},
      {v1::CastRaysRequest::descriptor(), "origins", -L::kPositionMax, L::kPositionMax},
      {v1::CastRaysRequest::descriptor(), "translations", -L::kRayLengthMax, L::kRayLengthMax},
      {v1::Geometry::descriptor(), "surface_velocity", -L::kSpeedMax, L::kSpeedMax},
      {v1::RigidBody::descriptor(), "linear_velocity", -L::kSpeedMax, L::kSpeedMax},
      {v1::RigidBody::descriptor(), "angular_velocity", -L::kSpinMax, L::kSpinMax},
      {v1::RigidBody::descriptor(), "linear_damping", 0, L::kDampingMax},
      {v1::RigidBody::descriptor(), "angular_damping", 0, L::kDampingMax},
      {v1::RigidBody::descriptor(), "gravity_scale", -L::kGravityScaleMax, L::kGravityScaleMax},
      {v1::RigidBody::descriptor(), "linear_speed_max", 0, L::kSpeedMax},
      {v1::RigidBody::descriptor(), "angular_speed_max", 0, L::kSpinMax},
      {v1::RigidBody::descriptor(), "geometries", 0, L::kGeometriesMax},
      {v1::SetVelocity::descriptor(), "linear", -L::kSpeedMax, L::kSpeedMax},
      {v1::SetVelocity::descriptor(), "angular", -L::kSpinMax, L::kSpinMax},
      {v1::StepRequest::descriptor(), "step_size_seconds", L::kStepSizeMin, L::kStepSizeMax},
      {v1::Stepper::descriptor(), "step_size_seconds", L::kStepSizeMin, L::kStepSizeMax},
      {v1::Stepper::descriptor(), "substeps", 1, L::kSubstepsMax},
      {v1::Stepper::descriptor(), "iterations", 1, L::kIterationsMax},
      {v1::Material::descriptor(), "density", L::kDensityMin, L::kDensityMax},
      {v1::Material::descriptor(), "friction", 0, L::kFrictionMax},
      {v1::Material::descriptor(), "kinetic_friction", 0, L::kFrictionMax},
      {v1::Material::descriptor(), "rolling_friction", 0, L::kFrictionArmMax},
      {v1::Material::descriptor(), "spinning_friction", 0, L::kFrictionArmMax},
      {v1::World::descriptor(), "gravity", -L::kGravityMax, L::kGravityMax},
      {v1::SetGravity::descriptor(), "gravity", -L::kGravityMax, L::kGravityMax},
      {v1::ApplyForce::descriptor(), "force", -L::kForceMax, L::kForceMax},
      {v1::ApplyForce::descriptor(), "torque", -L::kForceMax, L::kForceMax},
      {v1::ApplyForce::descriptor(), "steps", 1, L::kForceStepsMax},
      {v1::ApplyImpulse::descriptor(), "linear", -L::kForceMax, L::kForceMax},
      {v1::ApplyImpulse::descriptor(), "angular", -L::kForceMax, L::kForceMax},
      {v1::ApplyForceColumns::descriptor(), "forces", -L::kForceMax, L::kForceMax},
      {v1::ApplyForceColumns::descriptor(), "torques", -L::kForceMax, L::kForceMax},
      {v1::AutoDisable::descriptor(), "linear_speed_max", 0, L::kSpeedMax},
      {v1::AutoDisable::descriptor(), "angular_speed_max", 0, L::kSpinMax},
      {v1::AutoDisable::descriptor(), "rest_time_seconds", 0, L::kRestTimeMax},
      {v1::ErrorCorrection::descriptor(), "time_constant_seconds", 0, L::kCorrectionTimeMax},
      {v1::ErrorCorrection::descriptor(), "correction_speed_max", 0, L::kSpeedMax},
      {v1::ErrorCorrection::descriptor(), "slop_metres", 0, L::kSlopMax},
  };
  for (const Agreement& agreement : agreements) {
    const FieldDescriptor* field = agreement.type->FindFieldByName(agreement.field);
    ASSERT_NE(field, nullptr) << agreement.type->name() << "." << agreement.field;
    const v1::Limit& limit = LimitOf(field);
    const bool counts = field->message_type() != nullptr && field->is_repeated();
    EXPECT_EQ(limit.min(), agreement.min) << field->full_name();
    EXPECT_EQ(counts ? static_cast<double>(limit.max_items()) : limit.max(), agreement.max) << field->full_name();
  }
}

TEST(DeclaredLimits, CountIgnoredEntitiesAsTheModelDoes) {
  const FieldDescriptor* field = v1::RigidBody::descriptor()->FindFieldByName("ignored_entity_ids");
  EXPECT_EQ(LimitOf(field).max_items(), Limits::kIgnoredEntitiesMax);
}

TEST(ErrorReason, HasTheNamesAndNumbersOfTheModel) {
  const auto* reasons = v1::ErrorReason_descriptor();
  ASSERT_EQ(reasons->value_count(), static_cast<int>(Reason::kInvalidValue) + 1);
  for (int i = 0; i < reasons->value_count(); ++i) {
    EXPECT_EQ(reasons->value(i)->number(), i);
    EXPECT_EQ(reasons->value(i)->name(), "ERROR_REASON_" + std::string(NameOf(static_cast<Reason>(i))));
  }
}

TEST(Feature, HasTheNamesAndNumbersOfTheModel) {
  const auto* features = v1::Feature_descriptor();
  ASSERT_EQ(features->value_count(), static_cast<int>(Feature::kCount));
  for (int i = 1; i < features->value_count(); ++i) {
    const std::string name(NameOf(static_cast<Feature>(i)));
    EXPECT_EQ(features->value(i)->number(), i);
    EXPECT_EQ(features->value(i)->name(), "FEATURE_" + absl::AsciiStrToUpper(name));
  }
}

}  // namespace
}  // namespace genphys

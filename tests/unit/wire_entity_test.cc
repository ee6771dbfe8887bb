#include <gtest/gtest.h>

#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"
#include "wire_round_trip.h"

namespace genphys {
namespace {

class EveryShape : public testing::TestWithParam<std::string> {};

TEST_P(EveryShape, TravelsInAnEntityWithAllItsFields) {
  const v1::Entity sent = FilledEntity(GetParam());

  const Result<EntityDesc> desc = DecodeEntity(sent);
  ASSERT_TRUE(desc.ok()) << desc.status();
  v1::Entity returned;
  EncodeEntity(EntityId::FromPacked(sent.id()), *desc, &returned);

  EXPECT_TRUE(SameMessage(sent, returned));
}

INSTANTIATE_TEST_SUITE_P(WireEntity, EveryShape, testing::Values("sphere", "box", "capsule", "cylinder", "plane"),
                         [](const auto& named) { return named.param; });

class EveryMissingShape : public testing::TestWithParam<std::string> {};

TEST_P(EveryMissingShape, IsRefusedByName) {
  const Status status = DecodeEntity(FilledEntity(GetParam())).status();

  EXPECT_EQ(Verdict(status), "UNSUPPORTED_FEATURE rigid_body.geometries[0].shape." + GetParam());
  EXPECT_NE(MessageOf(status).find("shape_" + GetParam()), std::string::npos) << status;
}

INSTANTIATE_TEST_SUITE_P(WireEntity, EveryMissingShape, testing::Values("convex_hull", "triangle_mesh", "heightfield"),
                         [](const auto& named) { return named.param; });

TEST(WireEntity, RefusesAShapeOfNoKind) {
  v1::Entity entity;
  entity.mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_sphere();
  entity.mutable_rigid_body()->add_geometries();

  EXPECT_EQ(Verdict(DecodeEntity(entity).status()), "MISSING_FIELD rigid_body.geometries[1].shape.kind");
}

TEST(WireEntity, RefusesEachFieldOfErrorCorrectionButNotAnEmptyOne) {
  v1::Entity entity;
  v1::ErrorCorrection* correction = entity.mutable_rigid_body()->mutable_error_correction();
  EXPECT_EQ(Verdict(DecodeEntity(entity).status()), "accepted");

  const google::protobuf::Descriptor* type = v1::ErrorCorrection::descriptor();
  for (int i = 0; i < type->field_count(); ++i) {
    correction->Clear();
    correction->GetReflection()->SetDouble(correction, type->field(i), 1);
    EXPECT_EQ(Verdict(DecodeEntity(entity).status()), "UNSUPPORTED_FEATURE rigid_body.error_correction")
        << type->field(i)->name();
  }
}

TEST(WireEntity, TakesTheDocumentedDefaultForWhatIsUnset) {
  v1::Entity entity;
  v1::RigidBody* body = entity.mutable_rigid_body();
  body->add_geometries()->mutable_shape()->mutable_sphere();
  body->add_geometries()->mutable_shape()->mutable_box();
  body->add_geometries()->mutable_shape()->mutable_capsule();
  body->add_geometries()->mutable_shape()->mutable_cylinder();
  body->add_geometries()->mutable_shape()->mutable_plane();

  const Result<EntityDesc> desc = DecodeEntity(entity);

  ASSERT_TRUE(desc.ok()) << desc.status();
  EXPECT_EQ(desc->pose, Pose());
  EXPECT_EQ(desc->visual, std::nullopt);
  ASSERT_TRUE(desc->rigid_body.has_value());
  EXPECT_EQ(desc->rigid_body->motion_type, MotionType::kDynamic);
  EXPECT_EQ(
      desc->rigid_body->geometries,
      (std::vector<Geometry>{
          {.shape = Sphere{}}, {.shape = Box{}}, {.shape = Capsule{}}, {.shape = Cylinder{}}, {.shape = Plane{}}}));
  EXPECT_EQ(desc->rigid_body->auto_disable, AutoDisable());
  EXPECT_FALSE(desc->rigid_body->inertia.mass || desc->rigid_body->inertia.tensor);
}

TEST(WireEntity, KeepsAnEntityWithoutPhysicsWithoutPhysics) {
  const Result<EntityDesc> desc = DecodeEntity(v1::Entity());

  ASSERT_TRUE(desc.ok()) << desc.status();
  EXPECT_FALSE(desc->rigid_body.has_value());
  v1::Entity returned;
  EncodeEntity(EntityId(), *desc, &returned);
  EXPECT_FALSE(returned.has_rigid_body());
  EXPECT_FALSE(returned.has_visual());
}

TEST(WireEntity, ReadsATensorAsASymmetricMatrix) {
  v1::Entity entity;
  for (const double element : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}) {
    entity.mutable_rigid_body()->mutable_inertia()->add_tensor(element);
  }

  const Result<EntityDesc> desc = DecodeEntity(entity);

  ASSERT_TRUE(desc.ok()) << desc.status();
  EXPECT_EQ(desc->rigid_body->inertia.tensor, (Matrix3{{1, 2, 3}, {2, 4, 5}, {3, 5, 6}}));
}

}  // namespace
}  // namespace genphys

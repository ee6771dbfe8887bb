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

INSTANTIATE_TEST_SUITE_P(WireEntity, EveryShape,
                         testing::Values("sphere", "box", "capsule", "cylinder", "plane", "cone", "ellipsoid"),
                         [](const auto& named) { return named.param; });

v1::Shape* AddShape(v1::Entity& entity) { return entity.mutable_rigid_body()->add_geometries()->mutable_shape(); }

TEST(WireEntity, KeepsHullsMeshesAndHeightfieldsAsTheyWereGiven) {
  v1::Entity sent;
  for (const double number : {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0, 0.1, 0.2, 0.3}) {
    // The last vertex lies inside, and is kept all the same.
    if (sent.rigid_body().geometries_size() == 0) AddShape(sent);
    sent.mutable_rigid_body()->mutable_geometries(0)->mutable_shape()->mutable_convex_hull()->add_vertices(number);
  }
  v1::TriangleMesh* mesh = AddShape(sent)->mutable_triangle_mesh();
  for (const double number : {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0}) mesh->add_vertices(number);
  for (const uint32_t number : {0u, 1u, 2u, 0u, 0u, 1u, 0u, 2u, 3u}) mesh->add_indices(number);
  v1::Heightfield* field = AddShape(sent)->mutable_heightfield();
  field->set_rows(2);
  field->set_columns(3);
  field->set_cell_size(0.5);
  for (int i = 0; i < 6; ++i) field->add_heights(0.1 * i);

  const Result<EntityDesc> desc = DecodeEntity(sent);
  ASSERT_TRUE(desc.ok()) << desc.status();
  v1::Entity returned;
  EncodeEntity(EntityId(), *desc, &returned);

  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(SameMessage(sent.rigid_body().geometries(i).shape(), returned.rigid_body().geometries(i).shape()));
  }
}

TEST(WireEntity, RefusesShapesThatAreNoneByTheirField) {
  const auto verdict = [](const auto& fill) {
    v1::Entity entity;
    fill(*AddShape(entity));
    return Verdict(DecodeEntity(entity).status());
  };
  const std::string path = "rigid_body.geometries[0].shape.";
  const auto flat = [](v1::Shape& shape) {
    for (int i = 0; i < 12; ++i) shape.mutable_convex_hull()->add_vertices(i % 3 == 2 ? 1 : i);
  };
  EXPECT_EQ(verdict(flat), "INVALID_VALUE " + path + "convex_hull.vertices");
  const auto beyond = [](v1::Shape& shape) {
    for (int i = 0; i < 9; ++i) shape.mutable_triangle_mesh()->add_vertices(i * i);
    for (const uint32_t number : {0u, 1u, 3u}) shape.mutable_triangle_mesh()->add_indices(number);
  };
  EXPECT_EQ(verdict(beyond), "OUT_OF_RANGE " + path + "triangle_mesh.indices[2]");
  const auto without_area = [](v1::Shape& shape) {
    for (int i = 0; i < 9; ++i) shape.mutable_triangle_mesh()->add_vertices(i);
    for (const uint32_t number : {0u, 1u, 2u}) shape.mutable_triangle_mesh()->add_indices(number);
  };
  EXPECT_EQ(verdict(without_area), "INVALID_VALUE " + path + "triangle_mesh.indices");
  const auto too_few = [](v1::Shape& shape) {
    shape.mutable_heightfield()->set_rows(2);
    shape.mutable_heightfield()->set_columns(2);
    for (int i = 0; i < 3; ++i) shape.mutable_heightfield()->add_heights(i);
  };
  EXPECT_EQ(verdict(too_few), "INVALID_VALUE " + path + "heightfield.heights");
}

TEST(WireEntity, RefusesAShapeOfNoKind) {
  v1::Entity entity;
  entity.mutable_rigid_body()->add_geometries()->mutable_shape()->mutable_sphere();
  entity.mutable_rigid_body()->add_geometries();

  EXPECT_EQ(Verdict(DecodeEntity(entity).status()), "MISSING_FIELD rigid_body.geometries[1].shape.kind");
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

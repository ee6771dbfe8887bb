#include "genphys/pair_rule.h"

#include <gtest/gtest.h>

namespace genphys {
namespace {

using Verdict = PairRule::Verdict;

Material Filled() { return Filled(Material{}, Material{}); }

struct Rules {
  PairRule rule;
  uint32_t next = 0;

  GeometryRow Add(MotionType motion, const Geometry& geometry) {
    RigidBody body{.motion_type = motion, .geometries = {geometry}};
    body.geometries[0].material = genphys::Filled(geometry.material, Material{});
    const uint32_t row = next++;
    return rule.Add(EntityRow{row}, EntityId(row, 0), body).front();
  }
};

TEST(PairRule, DynamicBodiesCollideWithAll) {
  Rules rules;
  const GeometryRow ball = rules.Add(MotionType::kDynamic, {});
  for (MotionType motion : {MotionType::kStatic, MotionType::kKinematic, MotionType::kDynamic}) {
    const GeometryRow other = rules.Add(motion, {});
    EXPECT_EQ(rules.rule.Decide(ball, other), Verdict::kCollide);
    EXPECT_EQ(rules.rule.Decide(other, ball), Verdict::kCollide);
  }
}

TEST(PairRule, WhatNoForceMovesIgnoresEachOther) {
  Rules rules;
  const GeometryRow wall = rules.Add(MotionType::kStatic, {}), lift = rules.Add(MotionType::kKinematic, {});
  EXPECT_EQ(rules.rule.Decide(wall, lift), Verdict::kIgnore);
}

TEST(PairRule, BothMasksMustAgree) {
  Rules rules;
  const GeometryRow a = rules.Add(MotionType::kDynamic, {.category_bits = 1, .collides_with_bits = 2});
  const GeometryRow b = rules.Add(MotionType::kDynamic, {.category_bits = 2, .collides_with_bits = 1});
  const GeometryRow one_sided = rules.Add(MotionType::kDynamic, {.category_bits = 2, .collides_with_bits = 4});
  EXPECT_EQ(rules.rule.Decide(a, b), Verdict::kCollide);
  EXPECT_EQ(rules.rule.Decide(a, one_sided), Verdict::kIgnore);
  EXPECT_EQ(rules.rule.Decide(one_sided, a), Verdict::kIgnore);
}

TEST(PairRule, MembersOfOneSpaceIgnoreEachOtherAlsoWhenNested) {
  Rules rules;
  const GeometryRow body = rules.Add(MotionType::kDynamic, {.collision_space = "car"});
  const GeometryRow wheel = rules.Add(MotionType::kDynamic, {.collision_space = "car/wheels"});
  const GeometryRow cart = rules.Add(MotionType::kDynamic, {.collision_space = "cart"});
  EXPECT_EQ(rules.rule.Decide(body, wheel), Verdict::kIgnore);
  EXPECT_EQ(rules.rule.Decide(body, cart), Verdict::kCollide);
}

TEST(PairRule, ASensorTellsOfVisitorsAndNotOfOtherSensors) {
  Rules rules;
  const GeometryRow gate = rules.Add(MotionType::kStatic, {.is_sensor = true});
  EXPECT_EQ(rules.rule.Decide(gate, rules.Add(MotionType::kDynamic, {})), Verdict::kSensor);
  EXPECT_EQ(rules.rule.Decide(gate, rules.Add(MotionType::kKinematic, {})), Verdict::kSensor);
  EXPECT_EQ(rules.rule.Decide(gate, rules.Add(MotionType::kStatic, {})), Verdict::kIgnore);
  EXPECT_EQ(rules.rule.Decide(gate, rules.Add(MotionType::kDynamic, {.is_sensor = true})), Verdict::kIgnore);
}

TEST(PairRule, RaysSeeTheirCategoriesAndNoSensors) {
  Rules rules;
  const GeometryRow ball = rules.Add(MotionType::kDynamic, {.category_bits = 4});
  const GeometryRow gate = rules.Add(MotionType::kStatic, {.category_bits = 4, .is_sensor = true});
  EXPECT_TRUE(rules.rule.SeenByRay(ball, 6));
  EXPECT_FALSE(rules.rule.SeenByRay(ball, 3));
  EXPECT_FALSE(rules.rule.SeenByRay(gate, 4));
}

TEST(PairRule, MixesByTheGeometricMean) {
  const MixedMaterial mixed = Mix({.friction = 0.2, .kinetic_friction = 0.1, .restitution = 0.25, .density = 1},
                                  {.friction = 0.8, .kinetic_friction = 0.9, .restitution = 1, .density = 1});
  EXPECT_DOUBLE_EQ(mixed.friction, 0.4);
  EXPECT_DOUBLE_EQ(mixed.kinetic_friction, 0.3);
  EXPECT_DOUBLE_EQ(mixed.restitution, 0.5);
}

TEST(Materials, TakeTheWorldsDefaultsAndThenTheModels) {
  const Material filled = Filled(Material{.restitution = 0.7}, Material{.friction = 0.9, .kinetic_friction = 0.6});
  EXPECT_EQ(filled, (Material{.friction = 0.9,
                              .kinetic_friction = 0.6,
                              .restitution = 0.7,
                              .density = 1000,
                              .friction_mixing = Mixing::kGeometricMean,
                              .restitution_mixing = Mixing::kGeometricMean,
                              .rolling_friction = 0,
                              .spinning_friction = 0}));
  EXPECT_EQ(*Filled(Material{.friction = 0.2}, Material{.kinetic_friction = 0.6}).kinetic_friction, 0.2);
  EXPECT_EQ(Filled(), (Material{.friction = 0.5,
                                .kinetic_friction = 0.5,
                                .restitution = 0,
                                .density = 1000,
                                .friction_mixing = Mixing::kGeometricMean,
                                .restitution_mixing = Mixing::kGeometricMean,
                                .rolling_friction = 0,
                                .spinning_friction = 0}));
}

}  // namespace
}  // namespace genphys

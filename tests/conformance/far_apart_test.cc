// What happens in one place goes on as if nothing happened elsewhere, to the last bit.
#include <algorithm>
#include <string>
#include <vector>

#include "engine_test.h"

namespace genphys::testing {
namespace {

GENPHYS_ENGINE_TESTS(FarApart, Claim::kContacts);

constexpr double kAway = 20;  // m, from one place to the next
constexpr int kOthers = 12;

using Bodies = std::vector<EntityDesc>;

// How the bodies of a world at one place move.
struct Course {
  std::vector<Vector3> positions;  // m
  std::vector<Vector3> velocities;
  bool operator==(const Course&) const = default;
};

// Of `bodies` in `steps` steps, with `others` in so many places before and as many after them.
std::vector<Course> CoursesOf(const std::string& engine, const Bodies& bodies, const Bodies& others, int places,
                              int steps) {
  const auto world = testing::MakeWorld(WorldDesc{.engine = engine, .default_auto_disable = {.enabled = false}});
  const auto add_others = [&](double side) {
    for (int place = 1; place <= places; ++place) {
      for (EntityDesc other : others) {
        other.pose.position.x() += side * kAway * place;
        Add(*world, other);
      }
    }
  };
  add_others(-1);
  std::vector<EntityId> ids;
  for (const EntityDesc& body : bodies) ids.push_back(Add(*world, body));
  add_others(1);
  std::vector<Course> courses;
  for (int step = 0; step < steps; ++step) {
    Steps(*world, 1);
    Course& course = courses.emplace_back();
    for (const EntityId id : ids) {
      course.positions.push_back(PositionOf(*world, id));
      course.velocities.push_back(VelocityOf(*world, id));
    }
  }
  return courses;
}

void ExpectNoMatter(const std::string& engine, const Bodies& bodies, const Bodies& others, int steps) {
  const std::vector<Course> alone = CoursesOf(engine, bodies, others, 0, steps);
  const std::vector<Course> among = CoursesOf(engine, bodies, others, kOthers / 2, steps);
  const auto [first, other] = std::ranges::mismatch(alone, among);
  ASSERT_EQ(first, alone.end()) << "since step " << first - alone.begin() << " by "
                                << (first->positions[0] - other->positions[0]).norm() << " m";
}

// Comes down on its edge and turns so fast that where it is deepest says little of when it met the floor.
EntityDesc TumblingDrum() {
  EntityDesc drum = Body(Cylinder{0.2, 0.2}, {0, 0, 1.5});
  drum.pose.orientation = Eigen::AngleAxisd(0.4, Vector3(1, 0.3, 0.2).normalized());
  drum.rigid_body->linear_velocity = {1, 0.2, 0};
  drum.rigid_body->angular_velocity = {9, 30, 15};
  drum.rigid_body->geometries[0].material.restitution = 0.7;
  return drum;
}

TEST_P(FarApart, AreManyWhoHitTheFloorAtOnce) {
  Proves({Claim::kRestitution});
  ExpectNoMatter(GetParam(), {TumblingDrum()}, {TumblingDrum()}, 32);
}

}  // namespace
}  // namespace genphys::testing

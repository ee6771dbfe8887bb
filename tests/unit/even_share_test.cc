#include "contacts/even_share.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace genphys {
namespace {

constexpr double kRounding = 1e-12;

// Of a face that leans, at its corners and in between.
std::vector<ContactPoint> Face(std::span<const std::array<double, 2>> places) {
  const Quaternion turn(Eigen::AngleAxisd(0.3, Vector3(1, 2, 3).normalized()));
  std::vector<ContactPoint> points;
  for (const auto& [x, y] : places) {
    points.push_back({.position = Vector3(50, 7, -3) + turn * Vector3(x, y, 0), .normal = turn * Vector3::UnitZ()});
  }
  return points;
}

constexpr std::array<std::array<double, 2>, 4> kCorners{{{2, 1}, {-2, 1}, {-2, -1}, {2, -1}}};
constexpr std::array<std::array<double, 2>, 6> kMore{{{2, 1}, {-2, 1}, {-2, -1}, {2, -1}, {0.5, 0.3}, {-1, 0.9}}};

constexpr std::array<std::array<double, 2>, 4> kLine{{{0, 0}, {1, 0}, {2, 0}, {3, 0}}};

std::vector<PointImpulse> Loads(std::initializer_list<double> loads) {
  std::vector<PointImpulse> impulses;
  for (const double load : loads) impulses.push_back({.normal = load});
  return impulses;
}

// The force, and what it turns about the first point.
std::pair<double, Vector3> Wrench(std::span<const ContactPoint> points, std::span<const PointImpulse> impulses) {
  double force = 0;
  Vector3 torque = Vector3::Zero();
  for (size_t i = 0; i < points.size(); ++i) {
    force += impulses[i].normal;
    torque += (points[i].position - points[0].position).cross(impulses[i].normal * points[i].normal);
  }
  return {force, torque};
}

void ExpectSameWrench(std::span<const ContactPoint> points, std::span<const PointImpulse> before,
                      std::span<const PointImpulse> after) {
  const auto [force_before, torque_before] = Wrench(points, before);
  const auto [force, torque] = Wrench(points, after);
  EXPECT_NEAR(force, force_before, kRounding);
  EXPECT_LE((torque - torque_before).norm(), kRounding);
}

TEST(EvenShare, IsThatOfALinearPressureWithTheSameForceAndTorques) {
  for (const auto& points : {Face(kCorners), Face(kMore)}) {
    auto impulses = Loads({5, 1, 2, 0});
    impulses.resize(points.size());
    const auto before = impulses;

    ShareEvenly(points, impulses);

    ExpectSameWrench(points, before, impulses);
    EXPECT_NEAR(impulses[0].normal + impulses[2].normal, impulses[1].normal + impulses[3].normal, kRounding);
    const auto once = impulses;
    ShareEvenly(points, impulses);
    for (size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(impulses[i].normal, once[i].normal, kRounding);
  }
}

TEST(EvenShare, HasNoPointPull) {
  const auto points = Face(kCorners);
  auto impulses = Loads({8, 0, 0, 0});
  const auto before = impulses;

  ShareEvenly(points, impulses);

  ExpectSameWrench(points, before, impulses);
  for (const PointImpulse& impulse : impulses) EXPECT_GE(impulse.normal, -kRounding);
}

TEST(EvenShare, LeavesAloneWhatThreePointsOrSeveralFacesBear) {
  auto few = Face(kCorners);
  few.pop_back();
  auto ahead = Face(kCorners), bent = Face(kCorners), line = Face(kLine);
  ahead[2].is_ahead = true;
  bent[1].normal = Vector3::UnitX();
  for (const auto& points : {few, ahead, bent, line}) {
    auto impulses = Loads({5, 1, 2, 0});
    impulses.resize(points.size());
    const auto before = impulses;

    ShareEvenly(points, impulses);

    for (size_t i = 0; i < points.size(); ++i) EXPECT_EQ(impulses[i].normal, before[i].normal);
  }
}

}  // namespace
}  // namespace genphys

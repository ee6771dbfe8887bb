#include <cmath>
#include <string>

#include "contenders/dice.h"
#include "contenders/pile.h"
#include "problem.h"

namespace genphys::bench {
namespace {

constexpr int kRate = 60;

// Far enough from each other to know nothing of each other.
Problem Tumblers() {
  constexpr int kRow = 10;
  constexpr double kSpacing = 5;
  Problem problem{.id = "T.tumblers", .title = "1,000 tumbling bodies in free flight", .duration = 1, .rates = {kRate}};
  problem.scene.gravity.setZero();
  Dice dice(1);
  for (int i = 0; i < kRow * kRow * kRow; ++i) {
    const Vector3 place(i % kRow, i / kRow % kRow, i / kRow / kRow);
    problem.scene.Add(Box{{0.8, 0.6, 0.35}}, 12, {.position = kSpacing * place}, Vector3::Zero(),
                      2 * dice.NextVector());
  }
  return problem;
}

Problem RestingPile() {
  return {.id = "T.pile",
          .title = "1,000 boxes in a pile that has come to rest, awake",
          .scene = PileOf({}),
          .duration = 1,
          .rates = {kRate, 2 * kRate},
          .settle = 4,
          .is_large = true};
}

Problem FallingPile() {
  return {.id = "T.falling",
          .title = "216 boxes that fall on each other, e = 0.3",
          .scene = PileOf({.row = 6, .layers = 6, .rise = 1.3, .restitution = 0.3}),
          .duration = 3,
          .rates = {kRate, 2 * kRate},
          .is_large = true};
}

Problem Joints() {
  constexpr int kChains = 20;
  constexpr int kLinks = 10;
  constexpr double kLength = 0.2;
  Problem problem{
      .id = "T.joints", .title = "20 swinging chains of 10 links: 200 joints", .duration = 2, .rates = {kRate}};
  for (int chain = 0; chain < kChains; ++chain) {
    const Vector3 hook(0, chain, 0);
    std::optional<size_t> above;
    for (int i = 0; i < kLinks; ++i) {
      const Vector3 place = hook + Vector3(kLength * (i + 0.5), 0, 0);
      const Pose pose{place, Turn(1.5707963267948966, Vector3::UnitY())};
      const size_t link = problem.scene.Add(Capsule{0.02, kLength / 2 - 0.02}, 0.1, pose);
      problem.scene.Join(BallJoint{}, above, link, hook + Vector3(kLength * i, 0, 0));
      above = link;
    }
  }
  return problem;
}

}  // namespace

void AddCosts(std::vector<Problem>& problems) {
  problems.push_back(Tumblers());
  problems.push_back(RestingPile());
  problems.push_back(FallingPile());
  problems.push_back(Joints());
}

std::vector<Problem> Problems() {
  std::vector<Problem> problems;
  AddFreeBodies(problems);
  AddJoints(problems);
  AddChains(problems);
  AddSliding(problems);
  AddBounces(problems);
  AddCollisions(problems);
  AddLinkedCollisions(problems);
  AddSwitches(problems);
  AddAny(problems);
  AddCosts(problems);
  return problems;
}

}  // namespace genphys::bench

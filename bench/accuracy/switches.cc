#include <cmath>
#include <string>

#include "problem.h"

namespace genphys::bench {
namespace {

constexpr double kChange = 1;
constexpr double kTime = 1.5;
constexpr double kPath = kGravity * (kTime - kChange) * (kTime - kChange) / 2;

std::vector<Quantity> Compare(const Vector3& now, const Vector3& before, const Vector3& start, double path) {
  const double meters = (now - start - Vector3(0, 0, path)).norm();
  return {{"error", meters / kPath}, {"meters", meters}, {"from_there", std::abs(now.z() - before.z() - path)}};
}

Problem SupportRemoved() {
  Problem problem{.id = "D1",
                  .title = "what a block rests on is taken away",
                  .error = "place 0.5 s later / 1.226 m",
                  .scene = {.friction = 0.5},
                  .duration = kChange};
  const size_t table = problem.scene.AddStatic(Box{{1, 1, 0.5}}, At(0, 0, -0.5));
  const size_t block = problem.scene.Add(Box{{0.2, 0.2, 0.05}}, 1, At(0, 0, 0.05));
  problem.euler_error = kGravity * (kTime - kChange) / 2 / kPath;
  problem.measure = [scene = problem.scene, table, block](const Lab& lab) {
    Run run = lab.Start(scene);
    run.StepTo(kChange);
    const Vector3 before = run[block].position;
    run.simulation().Remove(table);
    run.StepTo(kTime);
    return Compare(run[block].position, before, scene.bodies[block].pose.position, -kPath);
  };
  return problem;
}

Problem GravityReversed() {
  Problem problem{.id = "D2",
                  .title = "gravity is reversed under a resting block",
                  .error = "place 0.5 s later / 1.226 m",
                  .scene = {.has_ground = true, .friction = 0.5},
                  .duration = kChange};
  problem.scene.Add(Box{{0.2, 0.2, 0.05}}, 1, At(0, 0, 0.05));
  problem.euler_error = kGravity * (kTime - kChange) / 2 / kPath;
  problem.measure = [scene = problem.scene](const Lab& lab) {
    Run run = lab.Start(scene);
    run.StepTo(kChange);
    const Vector3 before = run[0].position;
    run.simulation().SetGravity(-scene.gravity);
    run.StepTo(kTime);
    return Compare(run[0].position, before, scene.bodies[0].pose.position, kPath);
  };
  return problem;
}

}  // namespace

void AddSwitches(std::vector<Problem>& problems) {
  problems.push_back(SupportRemoved());
  problems.push_back(GravityReversed());
}

}  // namespace genphys::bench

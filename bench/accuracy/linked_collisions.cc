// Something runs into what joints hold together: they pass the blow on while it lasts.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

#include "problem.h"

namespace genphys::bench {
namespace {

constexpr double kRadius = 0.1;
constexpr double kSpeed = 4;
constexpr double kTime = 0.2;  // they met at half of it
constexpr double kRodLength = 1;
constexpr double kRodHeight = 0.05;
constexpr double kRodInertia = (kRodLength * kRodLength + kRodHeight * kRodHeight) / 12;  // of 1 kg, kg*m^2

// Rods of 1 kg in a row along x that begins at the origin, joined by balls, and a sphere of `mass` (kg) on its way down
// to `x` (m) of it. The first rod is on a hinge if `is_hung`.
Scene RodsAndSphere(int rods, bool is_hung, double mass, double x, double restitution) {
  Scene scene{.gravity = Vector3::Zero(), .restitution = restitution};
  for (int i = 0; i < rods; ++i) {
    const size_t rod = scene.Add(Box{{kRodLength / 2, 0.025, kRodHeight / 2}}, 1, At(kRodLength * (i + 0.5), 0, 0));
    if (i > 0) scene.Join(BallJoint{}, rod - 1, rod, {kRodLength * i, 0, 0});
    if (i == 0 && is_hung) scene.Join(HingeJoint{}, std::nullopt, rod, Vector3::Zero(), Vector3::UnitY());
  }
  const double from = kRadius + kRodHeight / 2 + kSpeed * kTime / 2;
  scene.Add(Sphere{kRadius}, mass, At(x, 0, from), {0, 0, -kSpeed});
  return scene;
}

// Speeds downwards of the middles of rods and their spins about y (turning x downwards), and that of the sphere, after
// it hit: impulses of the blow and of the joints are those that leave what is joined together, and the sphere going
// away from where it hit at e times the speed at which it came (Newton), of all equations at once.
struct After {
  Eigen::VectorXd rods;  // speed and spin of each in turn
  double sphere = 0;
};

After AfterBlow(int rods, bool is_hung, double mass, double x, double restitution) {
  const int joints = rods - 1 + (is_hung ? 1 : 0), hit = std::min(static_cast<int>(x / kRodLength), rods - 1);
  const int unknowns = 2 * rods + 1, size = unknowns + joints + 1;
  Eigen::MatrixXd equations = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd wanted = Eigen::VectorXd::Zero(size);
  for (int i = 0; i < rods; ++i) {
    equations(2 * i, 2 * i) = 1;
    equations(2 * i + 1, 2 * i + 1) = kRodInertia;
  }
  equations(2 * rods, 2 * rods) = mass;
  wanted[2 * rods] = mass * kSpeed;
  const auto add_point = [&](int row, int rod, double offset, double sign) {
    equations(row, 2 * rod) += sign;
    equations(row, 2 * rod + 1) += sign * offset;
  };
  int row = unknowns;
  if (is_hung) add_point(row++, 0, -kRodLength / 2, 1);
  for (int i = 1; i < rods; ++i, ++row) {
    add_point(row, i - 1, kRodLength / 2, -1);
    add_point(row, i, -kRodLength / 2, 1);
  }
  add_point(row, hit, x - kRodLength * (hit + 0.5), 1);
  equations(row, 2 * rods) = -1;
  wanted[row] = restitution * kSpeed;
  equations.topRightCorner(unknowns, joints + 1) = -equations.bottomLeftCorner(joints + 1, unknowns).transpose();
  const Eigen::VectorXd found = equations.fullPivLu().solve(wanted);
  return {found.head(2 * rods), found[2 * rods]};
}

Problem Struck(const std::string& id, const std::string& title, int rods, bool is_hung, double mass, double x) {
  constexpr double kRestitution = 0.5;
  Problem problem{.id = id,
                  .title = title,
                  .error = "speeds after it, the worst / 4 m/s",
                  .scene = RodsAndSphere(rods, is_hung, mass, x, kRestitution),
                  .duration = kTime,
                  .first_order = false};
  problem.measure = [scene = problem.scene, rods, is_hung, mass, x](const Lab& lab) -> std::vector<Quantity> {
    const After truth = AfterBlow(rods, is_hung, mass, x, kRestitution);
    Run run = lab.Start(scene);
    run.StepTo(kTime);
    const auto sphere = static_cast<size_t>(rods);
    double worst = std::abs(run[sphere].velocity.z() + truth.sphere);
    // What is hung keeps its spin, and what flies its momentum, from then on. Rods of a row turn each other.
    double momentum = mass * run[sphere].velocity.z();
    for (size_t i = 0; i < sphere; ++i) momentum += run[i].velocity.z();
    if (rods == 1) worst = std::max(worst, std::abs(run[0].spin.y() - truth.rods[1]));
    return {{"error", worst / kSpeed}, {"momentum", is_hung ? 0 : std::abs(momentum / (mass * kSpeed) + 1)}};
  };
  return problem;
}

}  // namespace

void AddLinkedCollisions(std::vector<Problem>& problems) {
  problems.push_back(Struck("C6.hung", "0.5 kg runs into a rod of 1 kg on a hinge, e = 0.5", 1, true, 0.5, 0.8));
  problems.push_back(Struck("C6.row", "2 kg run into the end of three rods in a row, e = 0.5", 3, false, 2, 2.9));
}

}  // namespace genphys::bench

// Figures of bones on joints with limits: what games and animations have most of.
#include <cmath>

#include "case.h"

namespace genphys::bench {
namespace {

JointKind Socket(double swing, double twist) {
  return BallJoint{.swing_max = swing, .twist = {.lower = -twist, .upper = twist}};
}

JointKind Bend(double lower, double upper) {
  return HingeJoint{{.limits = {.lower = lower, .upper = upper}, .motor = {}, .spring = {}}};
}

// Eleven bones, upright, their feet 6 cm over `at`; they go over at `lean` (1/s).
class Ragdoll {
 public:
  Ragdoll(Scene& scene, const Vector3& at, double lean) : scene_(scene), at_(at), lean_(lean) {
    const size_t pelvis = Bone({0, 0, 1}, 0.06, 0.12, 12);
    const size_t chest = Bone({0, 0, 1.32}, 0.1, 0.14, 24);
    const size_t head = Bone({0, 0, 1.66}, 0, 0.1, 5);
    Link(pelvis, chest, {0, 0, 1.15}, Socket(0.5, 0.5));
    Link(chest, head, {0, 0, 1.54}, Socket(0.7, 1));
    for (const double side : {1.0, -1.0}) {
      const double shoulder = 0.24 * side, hip = 0.1 * side;
      const size_t arm = Bone({0, shoulder, 1.28}, 0.1, 0.05, 2.5), forearm = Bone({0, shoulder, 0.96}, 0.1, 0.04, 1.8);
      const size_t thigh = Bone({0, hip, 0.68}, 0.14, 0.07, 8), shin = Bone({0, hip, 0.24}, 0.14, 0.05, 4);
      Link(chest, arm, {0, shoulder, 1.43}, Socket(1.5, 1));
      Link(arm, forearm, {0, shoulder, 1.12}, Bend(-2.4, 0));
      Link(pelvis, thigh, {0, hip, 0.9}, Socket(1.2, 0.5));
      Link(thigh, shin, {0, hip, 0.46}, Bend(0, 2.4));
    }
  }

 private:
  size_t Bone(const Vector3& place, double half_length, double radius, double mass) {
    const Shape shape = half_length > 0 ? Shape(Capsule{radius, half_length}) : Shape(Sphere{radius});
    return scene_.Add(shape, mass, {.position = place + at_}, Vector3(lean_ * place.z(), 0.1, 0));
  }

  void Link(size_t upper, size_t lower, const Vector3& place, const JointKind& kind) {
    const bool is_socket = std::holds_alternative<BallJoint>(kind);
    scene_.Join(kind, upper, lower, place + at_, is_socket ? Vector3(0, 0, -1) : Vector3::UnitY());
  }

  Scene& scene_;
  Vector3 at_;
  double lean_;
};

Scene Single() {
  constexpr int kCount = 20, kRow = 5;
  Scene scene{.has_ground = true, .friction = 0.5};
  for (int i = 0; i < kCount; ++i) Ragdoll(scene, Vector3(3 * (i % kRow), 3 * (i / kRow), 0.6), 0.5);
  return scene;
}

Scene Heaped() {
  constexpr int kCount = 24, kRow = 3;
  Scene scene{.has_ground = true, .friction = 0.5};
  for (int i = 0; i < kCount; ++i) {
    const double layer = i / (kRow * kRow);
    Ragdoll(scene, Vector3(0.9 * (i % kRow), 0.9 * (i / kRow % kRow), 0.6 + 2.1 * layer), 0.1);
  }
  return scene;
}

}  // namespace

void AddFigures(std::vector<Case>& cases) {
  cases.push_back({.id = "ragdolls",
                   .title = "20 ragdolls fall, each by itself",
                   .make = Single,
                   .phases = {{"falling", 0, 1.5}, {"lying", 4, 1}}});
  cases.push_back({.id = "heap",
                   .title = "24 ragdolls fall onto one heap",
                   .make = Heaped,
                   .phases = {{"falling", 0, 1.5}, {"lying", 4, 1}}});
}

}  // namespace genphys::bench

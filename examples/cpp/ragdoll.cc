// A ragdoll of eleven bodies falls, lands, and comes to rest with every joint in one piece and within its range.
//
//   ragdoll [--address 127.0.0.1:50051] [--engine ode]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "genphys/client/client.h"

namespace {

using namespace genphys;  // NOLINT(google-build-using-namespace): an example reads better without prefixes

constexpr char kUsage[] = R"(Drops a ragdoll through a genphys server and tells what happens.

Usage: ragdoll [options]
  --address A   host:port or unix:path of the server (default 127.0.0.1:50051; script/server starts one)
  --engine E    ode, bullet, ... (default: the server's)
  --help        this text

The exit status is 0 if the physics came out as it should, 1 if not, 2 if the server could not be used.
)";

constexpr double kStepSize = 1.0 / 240;
constexpr uint32_t kStepsPerCall = 24;
constexpr int kCallsMax = 200;    // twenty seconds
constexpr double kDrop = 1;       // m: how high the feet are let go
constexpr double kGapMax = 5e-3;  // m, between what a joint holds together
// rad, beyond a range: the edge of a cone is met to second order, (w h)^2 for a limb at 30 rad/s in half a step.
constexpr double kBeyondMax = (30 * kStepSize / 2) * (30 * kStepSize / 2);

[[noreturn]] void GiveUp(const Status& status) {
  std::fprintf(stderr, "ragdoll: %s\n", MessageOf(status).c_str());
  std::exit(2);
}

template <typename T>
T Must(Result<T> result) {
  if (!result.ok()) GiveUp(result.status());
  return *std::move(result);
}

class Ragdoll {
 public:
  explicit Ragdoll(client::World world) : world_(std::move(world)) {
    AddBone("pelvis", {0, 0, 1.00}, 0.06, 0.12, 12);
    AddBone("chest", {0, 0, 1.32}, 0.10, 0.14, 24);
    AddBone("head", {0, 0, 1.66}, 0, 0.10, 5);
    Link("pelvis", "chest", {0, 0, 1.15}, Cone(0.5, 0.5));
    Link("chest", "head", {0, 0, 1.54}, Cone(0.7, 1.0));
    for (const double side : {1.0, -1.0}) AddLimbs(side > 0 ? "left " : "right ", 0.24 * side, 0.10 * side);
  }

  int Run() {
    double gap = 0, beyond = 0;
    bool asleep = false;
    client::Frame frame;
    for (int call = 0; call < kCallsMax && !asleep; ++call) {
      frame = Must(world_.Step(kStepsPerCall)).frame;
      for (const client::JointInfo& joint : Must(world_.ListJoints())) {
        gap = std::max(gap, GapOf(frame, joint.joint));
        beyond = std::max(beyond, BeyondOf(joint));
      }
      asleep = std::all_of(bones_.begin(), bones_.end(),
                           [&](const auto& bone) { return frame.asleep(*frame.row(bone.second.id)); });
    }
    const double head = frame.positions()(2, *frame.row(bones_["head"].id));
    Check(gap <= kGapMax, "its joints held together within %.2f mm", 1e3 * gap);
    Check(beyond <= kBeyondMax, "no joint went beyond its range by more than %.4f rad", beyond);
    Check(head > 0.05 && head < 0.8, "its head lies %.2f m above the floor", head);
    Check(asleep, "it came to rest after %.1f s", frame.stamp().simulation_time);
    std::printf("\n%s\n", all_good_ ? "Everything came out as it should." : "Something is not as it should be.");
    return all_good_ ? 0 : 1;
  }

 private:
  struct Bone {
    EntityId id;
    Vector3 place;  // of the standing figure
  };

  void AddBone(const std::string& name, const Vector3& place, double half_length, double radius, double mass) {
    const Shape shape = half_length > 0 ? Shape(Capsule{.radius = radius, .half_length = half_length})
                                        : Shape(Sphere{.radius = radius});
    bones_[name] = {Must(world_.Add(shape, {.display_name = name,
                                            .position = place + Vector3(0, 0, kDrop),
                                            .mass = mass,
                                            .friction = 0.8,
                                            // It leans while it falls.
                                            .linear_velocity = {0.5 * place.z(), 0.1, 0}})),
                    place};
  }

  void AddLimbs(const std::string& side, double shoulder, double hip) {
    AddBone(side + "arm", {0, shoulder, 1.28}, 0.10, 0.05, 2.5);
    AddBone(side + "forearm", {0, shoulder, 0.96}, 0.10, 0.04, 1.8);
    AddBone(side + "thigh", {0, hip, 0.68}, 0.14, 0.07, 8);
    AddBone(side + "shin", {0, hip, 0.24}, 0.14, 0.05, 4);
    Link("chest", side + "arm", {0, shoulder, 1.43}, Cone(1.5, 1));
    Link(side + "arm", side + "forearm", {0, shoulder, 1.12}, Bend(-2.4, 0));
    Link("pelvis", side + "thigh", {0, hip, 0.90}, Cone(1.2, 0.5));
    Link(side + "thigh", side + "shin", {0, hip, 0.46}, Bend(0, 2.4));
  }

  static JointKind Cone(double swing, double twist) {
    return BallJoint{.swing_max = swing, .twist = {.lower = -twist, .upper = twist}};
  }

  static JointKind Bend(double lower, double upper) {
    return HingeJoint{{.limits = {.lower = lower, .upper = upper}, .motor = {}, .spring = {}}};
  }

  void Link(const std::string& upper, const std::string& lower, const Vector3& place, const JointKind& kind) {
    // A ball's z points down, along what hangs; elbows and knees turn about y.
    const Vector3 z = std::holds_alternative<BallJoint>(kind) ? Vector3(0, 0, -1) : Vector3(0, 1, 0);
    const Quaternion turn = Quaternion::FromTwoVectors(Vector3::UnitZ(), z);
    Must(world_.Join({.entity_a = {bones_[upper].id, {}},
                      .entity_b = {bones_[lower].id, {}},
                      .frame_in_a = Pose{place - bones_[upper].place, turn},
                      .kind = kind}));
  }

  static double GapOf(const client::Frame& frame, const JointDesc& joint) {
    const auto end = [&](const EntityRef& entity, const Pose& in_entity) {
      return frame.pose(*frame.row(entity.id)).Transform(in_entity.position);
    };
    return (end(joint.entity_a, *joint.frame_in_a) - end(joint.entity_b, *joint.frame_in_b)).norm();
  }

  static double BeyondOf(const client::JointInfo& joint) {
    const auto beyond = [](const AxisLimits& limits, double position) {
      return std::max({limits.lower.value_or(position) - position, position - limits.upper.value_or(position), 0.0});
    };
    const auto& positions = joint.state.positions;
    if (const auto* hinge = std::get_if<HingeJoint>(&joint.joint.kind)) return beyond(hinge->axis.limits, positions[5]);
    const auto& ball = std::get<BallJoint>(joint.joint.kind);
    return std::max(beyond(ball.twist, positions[5]), positions[3] - *ball.swing_max);
  }

  template <typename... Numbers>
  void Check(bool good, const char* format, Numbers... numbers) {
    all_good_ = all_good_ && good;
    std::printf("%s  ", good ? "  as expected:" : "NOT AS EXPECTED:");
    std::printf(format, numbers...);
    std::printf("\n");
  }

  client::World world_;
  std::map<std::string, Bone> bones_;
  bool all_good_ = true;
};

}  // namespace

int main(int argc, char** argv) {
  std::string address = "127.0.0.1:50051", engine;
  for (int i = 1; i < argc; i += 2) {
    const std::string_view name = argv[i];
    if (i + 1 < argc && name == "--address") {
      address = argv[i + 1];
    } else if (i + 1 < argc && name == "--engine") {
      engine = argv[i + 1];
    } else {
      std::fprintf(name == "--help" ? stdout : stderr, "%s", kUsage);
      return name == "--help" ? 0 : 2;
    }
  }
  const client::Server server = Must(client::Connect(address));
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -9.81}, .stepper = {.step_size = kStepSize}};
  // Limbs are soft, and do not roll on for ever.
  desc.default_material.rolling_friction = 0.01;
  client::World world = Must(server.CreateWorld({.world = desc}));
  std::printf("Server %s, engine %s: a ragdoll is let go %g m above the floor.\n", address.c_str(),
              Must(world.Info()).world.engine.c_str(), kDrop);
  return Ragdoll(std::move(world)).Run();
}

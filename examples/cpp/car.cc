// A car of a chassis and four wheel joints stands on its springs, drives off, and brakes; what happens is told and
// checked.
//
//   car [--address 127.0.0.1:50051] [--engine ode]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "genphys/client/client.h"

namespace {

using namespace genphys;  // NOLINT(google-build-using-namespace): an example reads better without prefixes

constexpr char kUsage[] = R"(Drives a car through a genphys server and tells what happens.

Usage: car [options]
  --address A   host:port or unix:path of the server (default 127.0.0.1:50051; script/server starts one)
  --engine E    ode, bullet, ... (default: the server's)
  --help        this text

The exit status is 0 if the physics came out as it should, 1 if not, 2 if the server could not be used.
)";

constexpr double kGravity = 9.81;
constexpr double kStepSize = 1.0 / 120;
constexpr uint32_t kSecond = 120;  // steps
constexpr double kChassisMass = 800, kWheelMass = 20;
constexpr double kWheelRadius = 0.35;
constexpr double kHalfBase = 1.25, kHalfTrack = 0.75;  // of the axles, and of the wheels of one
constexpr double kHeight = 0.9;                        // of the chassis above the floor
constexpr double kStiffness = 40'000, kDamping = 4'000;
constexpr double kTorque = 400;  // of each driven wheel
constexpr double kSpeed = 8;

[[noreturn]] void GiveUp(const Status& status) {
  std::fprintf(stderr, "car: %s\n", MessageOf(status).c_str());
  std::exit(2);
}

template <typename T>
T Must(Result<T> result) {
  if (!result.ok()) GiveUp(result.status());
  return *std::move(result);
}

class Drive {
 public:
  explicit Drive(client::World world) : world_(std::move(world)) {
    chassis_ = Must(world_.Add(Box{.half_extents = {1.7, 0.6, 0.25}},
                               {.display_name = "chassis", .position = {0, 0, kHeight}, .mass = kChassisMass}));
    for (const double x : {kHalfBase, -kHalfBase}) {
      for (const double y : {kHalfTrack, -kHalfTrack}) AddWheel(x, y);
    }
  }

  int Run() {
    Play(3);
    // The springs were drawn without load, so that they give way by the weight on each over their stiffness.
    const double sag = kChassisMass * kGravity / 4 / kStiffness;
    const double measured = Must(world_.ListJoints()).front().state.positions[2];
    constexpr double kSinks = 2e-3;  // m: wheels may sink that far into the floor
    Check(std::abs(measured - sag) <= kSinks, "its springs give way by %.1f mm; weight over stiffness says %.1f mm",
          1e3 * measured, 1e3 * sag);

    Aim(kSpeed);
    Play(6);
    Check(std::abs(velocity().x() - kSpeed) <= 0.02 * kSpeed, "it drives at %.2f m/s; its motors aim at %.2f",
          velocity().x(), kSpeed);
    Check(std::abs(position().y()) <= 0.1, "it has gone %.1f m, and left the straight line by %.3f m", position().x(),
          std::abs(position().y()));

    Aim(0);
    Play(6);
    Check(velocity().norm() <= 0.05, "it brakes to %.3f m/s", velocity().norm());
    std::printf("\n%s\n", all_good_ ? "Everything came out as it should." : "Something is not as it should be.");
    return all_good_ ? 0 : 1;
  }

 private:
  void AddWheel(double x, double y) {
    EntityDesc wheel =
        client::Body(Cylinder{.radius = kWheelRadius, .half_length = 0.1},
                     {.display_name = "wheel", .position = {x, y, kWheelRadius}, .mass = kWheelMass, .friction = 1.0});
    // A cylinder's axis is its z, and a wheel spins about y.
    wheel.rigid_body->geometries[0].pose_in_entity.orientation = Quaternion(std::sqrt(0.5), std::sqrt(0.5), 0, 0);
    const EntityId id = Must(world_.Create(wheel));
    WheelJoint kind;
    kind.suspension = JointAxis{.limits = {.lower = -0.2, .upper = 0.2},
                                .motor = {},
                                .spring = Spring{.stiffness = kStiffness, .damping = kDamping}};
    if (x < 0) kind.spin.motor = Motor{.target_velocity = 0, .force_max = kTorque};
    const JointId joint = Must(world_.Join({.entity_a = {chassis_, {}},
                                            .entity_b = {id, {}},
                                            .frame_in_a = Pose{{x, y, kWheelRadius - kHeight}, {1, 0, 0, 0}},
                                            .kind = kind}));
    if (x < 0) driven_.push_back(joint);
  }

  // One command for all motors.
  void Aim(double speed) {
    const Command command = SetMotorColumns{
        .ids = driven_, .velocities = std::vector<double>(driven_.size(), speed / kWheelRadius), .positions = {}};
    Must(world_.Apply({&command, 1}));
  }

  void Play(uint32_t seconds) { frame_ = Must(world_.Step(seconds * kSecond)).frame; }

  Vector3 position() const { return frame_.positions().col(*frame_.row(chassis_)); }
  Vector3 velocity() const { return frame_.linear_velocities().col(*frame_.row(chassis_)); }

  template <typename... Numbers>
  void Check(bool good, const char* format, Numbers... numbers) {
    all_good_ = all_good_ && good;
    std::printf("%s  ", good ? "  as expected:" : "NOT AS EXPECTED:");
    std::printf(format, numbers...);
    std::printf("\n");
  }

  client::World world_;
  EntityId chassis_;
  std::vector<JointId> driven_;
  client::Frame frame_;
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
  WorldDesc desc{.engine = engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = kStepSize}};
  client::World world = Must(server.CreateWorld({.world = desc}));
  std::printf("Server %s, engine %s: a car of %g kg on four wheel joints.\n", address.c_str(),
              Must(world.Info()).world.engine.c_str(), kChassisMass);
  return Drive(std::move(world)).Run();
}

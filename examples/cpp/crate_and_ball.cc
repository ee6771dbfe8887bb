// The crate and the ball: a crate stands on the floor, a ball falls onto it, and what happens is told and checked.
//
//   crate_and_ball [--address 127.0.0.1:50051] [--engine ode] [--x 0.7]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "genphys/client/client.h"

namespace {

using namespace genphys;  // NOLINT(google-build-using-namespace): an example reads better without prefixes

constexpr char kUsage[] = R"(Drops a ball onto a crate through a genphys server and tells what happens.

Usage: crate_and_ball [options]
  --address A   host:port or unix:path of the server (default 127.0.0.1:50051; script/server starts one)
  --engine E    ode, bullet, ... (default: the server's)
  --x X         where the ball hangs, metres from the middle of the crate, -3 to 3 (default 0.7: it meets the edge;
                0.3: it lands on the flat top; 1.2: it misses)
  --help        this text

The exit status is 0 if the physics came out as it should, 1 if not, 2 if the server could not be used.
)";

constexpr double kGravity = 9.81;
constexpr double kStepSize = 1.0 / 240;
constexpr double kCrateHalf = 0.5;  // of its edges
constexpr double kCrateTop = 2 * kCrateHalf;
constexpr double kRadius = 0.5;
constexpr double kMass = 1;
constexpr double kStartHeight = 5;

struct Options {
  std::string address = "127.0.0.1:50051";
  std::string engine;
  double x = 0.7;
};

enum class Ending { kOnTop, kOverTheEdge, kBesideIt };

// What theory says about a ball that falls at x.
struct Prediction {
  Ending ending;
  double height;  // of the ball's centre at the first touch
  double time;    // of the first touch
};

Prediction Predict(double x) {
  const double beyond = std::abs(x) - kCrateHalf;
  Prediction p{Ending::kOnTop, kCrateTop + kRadius, 0};
  if (beyond >= kRadius) {
    p = {Ending::kBesideIt, kRadius, 0};
  } else if (beyond > 0) {
    p = {Ending::kOverTheEdge, kCrateTop + std::sqrt(kRadius * kRadius - beyond * beyond), 0};
  }
  p.time = std::sqrt(2 * (kStartHeight - p.height) / kGravity);
  return p;
}

[[noreturn]] void GiveUp(const Status& status) {
  std::fprintf(stderr, "crate_and_ball: %s\n", MessageOf(status).c_str());
  if (const std::optional<Refusal> refusal = RefusalOf(status)) {
    std::fprintf(stderr, "refused for %s %s\n", std::string(NameOf(refusal->reason)).c_str(), refusal->field.c_str());
  }
  std::exit(2);
}

template <typename T>
T Must(Result<T> result) {
  if (!result.ok()) GiveUp(result.status());
  return *std::move(result);
}

class Story {
 public:
  Story(client::World world, const Options& options) : world_(std::move(world)), start_x_(options.x) {
    crate_ = Must(world_.Add(Box{.half_extents = {kCrateHalf, kCrateHalf, kCrateHalf}},
                             {.display_name = "crate", .position = {0, 0, kCrateHalf}, .mass = kMass}));
    ball_ = Must(world_.Add(Sphere{.radius = kRadius},
                            {.display_name = "ball", .position = {options.x, 0, kStartHeight}, .mass = kMass}));
  }

  int Run() {
    const Prediction predicted = Predict(start_x_);
    std::printf(
        "A crate of 1 m and 1 kg stands on the floor. A ball of radius 0.5 m and 1 kg hangs at x = %g m, "
        "z = %g m,\nand is let go.\n\n",
        start_x_, kStartHeight);
    Play(predicted.time + 10, /*until_asleep=*/false);
    if (!touched_at_) {
      Check(false, "the ball touched something");
      return 1;
    }
    std::printf("\n");
    Check(std::abs(*touched_at_ - predicted.time) <= kStepSize,
          "it first touched at t = %.4f s; a free fall to z = %.5f m takes %.6f s", *touched_at_, predicted.height,
          predicted.time);
    if (predicted.ending == Ending::kOnTop) {
      CheckThatItStaysOnTop();
    } else {
      CheckThatItRollsOnTheFloor(predicted.ending == Ending::kOverTheEdge);
      if (!asleep_) CheckThatItFallsAsleepWhenDamped();
    }
    std::printf("\n%s\n", all_good_ ? "Everything came out as it should." : "Something is not as it should be.");
    return all_good_ ? 0 : 1;
  }

 private:
  // Steps for `duration` seconds, a tenth of a second per call, and tells each event.
  void Play(double duration, bool until_asleep) {
    constexpr uint32_t kStepsPerCall = 24;
    const double until = stamp_.simulation_time + duration;
    while (stamp_.simulation_time < until && !(until_asleep && asleep_)) {
      client::StepResult result = Must(world_.Step(kStepsPerCall));
      stamp_ = result.stamp;
      frame_ = std::move(result.frame);
      for (const Event& event : result.events) Tell(event);
    }
  }

  void Tell(const Event& event) {
    const double time = static_cast<double>(event.step) * kStepSize;
    if (const auto* began = std::get_if<ContactBegan>(&event.kind)) {
      TellContact(time, *began);
    } else if (const auto* ended = std::get_if<ContactEnded>(&event.kind)) {
      std::printf("%8.4f s  the %s no longer touches the %s\n", time, Name(ended->pair.b), Name(ended->pair.a));
    } else if (const auto* slept = std::get_if<EntitySlept>(&event.kind)) {
      std::printf("%8.4f s  the %s falls asleep\n", time, Name(slept->id));
      if (slept->id == ball_) asleep_ = true;
    } else if (const auto* woke = std::get_if<EntityWoke>(&event.kind)) {
      std::printf("%8.4f s  the %s wakes up\n", time, Name(woke->id));
      if (woke->id == ball_) asleep_ = false;
    }
  }

  void TellContact(double time, const ContactBegan& contact) {
    double speed = 0;
    for (const EventContactPoint& point : contact.points) {
      speed = std::max(speed, -point.relative_velocity.dot(point.normal));
    }
    std::printf("%8.4f s  the %s touches the %s in %zu point(s), coming at %.3f m/s\n", time, Name(contact.pair.b),
                Name(contact.pair.a), contact.points.size(), speed);
    const bool is_ball = contact.pair.a == ball_ || contact.pair.b == ball_;
    if (is_ball && !touched_at_) touched_at_ = time;
  }

  const char* Name(EntityId id) const {
    if (id == ball_) return "ball";
    return id == crate_ ? "crate" : "floor";
  }

  template <typename... Numbers>
  void Check(bool good, const char* format, Numbers... numbers) {
    all_good_ = all_good_ && good;
    std::printf("%s  ", good ? "  as expected:" : "NOT AS EXPECTED:");
    std::printf(format, numbers...);
    std::printf("\n");
  }

  uint32_t BallRow() const {
    if (const std::optional<uint32_t> row = frame_.row(ball_)) return *row;
    GiveUp(absl::InternalError("the ball is not in the frame"));
  }

  void CheckThatItStaysOnTop() {
    constexpr double kMayMove = 0.01;  // m
    const Vector3 position = frame_.positions().col(BallRow());
    const double moved = (position - Vector3(start_x_, 0, kCrateTop + kRadius)).norm();
    Check(moved < kMayMove, "10 s later it lies on the crate, %.2g m from where it landed", moved);
  }

  void CheckThatItRollsOnTheFloor(bool pushed) {
    constexpr double kHeightError = 1e-3;  // m
    constexpr double kSlip = 1e-3;         // m/s
    const Vector3 position = frame_.positions().col(BallRow());
    const Vector3 velocity = frame_.linear_velocities().col(BallRow());
    const Vector3 spin = frame_.angular_velocities().col(BallRow());
    if (pushed) {
      Check(position.x() * start_x_ > start_x_ * start_x_, "the crate pushed it away: it is at x = %.3f m",
            position.x());
    }
    Check(std::abs(position.z() - kRadius) <= kHeightError, "10 s later it is on the floor, at z = %.5f m",
          position.z());
    const double slip = (velocity - spin.cross(kRadius * Vector3::UnitZ())).norm();
    Check(slip < kSlip, "it goes at %.4f m/s without slipping: %.2g m/s between it and the floor", velocity.norm(),
          slip);
  }

  void CheckThatItFallsAsleepWhenDamped() {
    std::printf("\nNow its rotation is damped, as by thick grass.\n");
    UpdateEntity damp{.id = ball_, .entity = {.rigid_body = RigidBody{.angular_damping = 5}}};
    damp.fields.Add(EntityField::kAngularDamping);
    const Command command = damp;
    Must(world_.Apply({&command, 1}));
    Play(30, /*until_asleep=*/true);
    Check(asleep_, "it has come to rest at x = %.3f m", frame_.positions()(0, BallRow()));
  }

  client::World world_;
  double start_x_;
  EntityId crate_;
  EntityId ball_;
  client::Stamp stamp_;
  client::Frame frame_;
  std::optional<double> touched_at_;
  bool asleep_ = false;
  bool all_good_ = true;
};

std::optional<Options> ReadArguments(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i += 2) {
    const std::string_view name = argv[i];
    if (i + 1 == argc) return std::nullopt;
    if (name == "--address") {
      options.address = argv[i + 1];
    } else if (name == "--engine") {
      options.engine = argv[i + 1];
    } else if (name == "--x") {
      char* end = nullptr;
      options.x = std::strtod(argv[i + 1], &end);
      if (end == argv[i + 1] || *end != '\0' || !(std::abs(options.x) <= 3)) return std::nullopt;
    } else {
      return std::nullopt;
    }
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == "--help") {
    std::printf("%s", kUsage);
    return 0;
  }
  const std::optional<Options> options = ReadArguments(argc, argv);
  if (!options) {
    std::fprintf(stderr, "%s", kUsage);
    return 2;
  }
  const client::Server server = Must(client::Connect(options->address));
  WorldDesc desc{.engine = options->engine, .gravity = {0, 0, -kGravity}, .stepper = {.step_size = kStepSize}};
  client::World world = Must(server.CreateWorld({.world = desc}));
  const client::WorldInfo info = Must(world.Info());
  std::printf("Server %s, engine %s, %g steps per second.\n", options->address.c_str(), info.world.engine.c_str(),
              1 / kStepSize);
  return Story(std::move(world), *options).Run();
}

// genphysd: reads the command line, runs the server, and stops it when it is told to.
#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <poll.h>
#include <signal.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <absl/synchronization/mutex.h>
#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "genphys/builtin_backends.h"
#include "genphys/services/server.h"

namespace {

// Calls under way may go on for so long after a signal, and the program ends after kEndMax whatever they do.
constexpr std::chrono::milliseconds kGrace{3000};
constexpr std::chrono::milliseconds kEndMax{4500};

constexpr char kDescription[] = "genphysd hosts rigid-body worlds behind gRPC.";
constexpr char kExamples[] = R"(Examples:
  genphysd                                     serves at 127.0.0.1:50051
  genphysd --listen 127.0.0.1:0                at a free port, which is printed
  genphysd --listen 127.0.0.1:50051 --listen unix:/tmp/genphys.sock
  genphysd --default-engine bullet --log-level debug

Once it serves, it prints a line per address on standard output: "genphysd listening on 127.0.0.1:50051".
SIGTERM and SIGINT stop it: calls under way may end, streams end with UNAVAILABLE, and it exits with 0 within 5 s.
Requests have at most 64 MiB; replies are as large as they are.)";

struct CommandLine {
  genphys::ServerOptions server;
  std::string isolate = "none";
  std::string log_level = "info";
  bool exit_with_parent = false;
};

std::string CheckIsolation(const std::string& value) {
  if (value == "none") return "";
  if (value == "shard" || value == "world") return "--isolate " + value + " is not built yet: use --isolate none";
  return "--isolate is none, shard or world, not " + value;
}

// CLI::Range says of what is no number that it is not within the range.
CLI::Validator WholeNumber(int64_t min, int64_t max) {
  const std::string range = std::to_string(min) + " to " + std::to_string(max);
  return CLI::Validator(
      [=](const std::string& value) {
        int64_t number = 0;
        const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
        if (error == std::errc::invalid_argument || end != value.data() + value.size()) {
          return "\"" + value + "\" is no whole number from " + range;
        }
        const bool fits = error == std::errc() && number >= min && number <= max;
        return fits ? std::string() : value + " is not from " + range;
      },
      range);
}

void Declare(CLI::App& app, CommandLine& line) {
  app.footer(kExamples);
  app.add_option("--listen", line.server.addresses, "host:port (port 0: a free one) or unix:path; may be repeated")
      ->default_str("127.0.0.1:50051")
      ->allow_extra_args(false);
  app.add_flag("--insecure-any-address", line.server.any_address,
               "allow addresses that other machines reach: nothing protects the worlds there");
  app.add_option("--isolate", line.isolate, "where worlds live; none: in this process")
      ->capture_default_str()
      ->check(CheckIsolation);
  app.add_option("--workers", line.server.workers, "threads that simulate; 0: one per processor")
      ->capture_default_str()
      ->check(WholeNumber(0, 1024));
  app.add_option("--default-engine", line.server.default_engine,
                 "engine of worlds that name none, as in ode; unset: the first of this build");
  app.add_option("--max-worlds", line.server.worlds_max, "most worlds at a time")
      ->capture_default_str()
      ->check(WholeNumber(1, 1'000'000));
  app.add_flag("--exit-with-parent", line.exit_with_parent, "end when standard input closes");
  app.add_option("--log-level", line.log_level, "what goes to standard error")
      ->capture_default_str()
      ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error", "critical", "off"}));
  app.set_version_flag("--version", "genphysd " GENPHYS_VERSION);
}

void LogToStandardError(const std::string& level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("genphysd"));
  spdlog::set_level(spdlog::level::from_str(level));
  // gRPC says on standard error whatever it meets; only whoever asks for details wants that.
  gpr_set_log_function([](gpr_log_func_args* args) {
    const bool is_error = args->severity == GPR_LOG_SEVERITY_ERROR;
    spdlog::log(is_error ? spdlog::level::debug : spdlog::level::trace, "grpc: {}", args->message);
  });
  // So does protobuf of text that is no UTF-8, which every client may send as often as it likes.
  google::protobuf::SetLogHandler(
      [](google::protobuf::LogLevel severity, const char*, int, const std::string& message) {
        const bool is_fatal = severity == google::protobuf::LOGLEVEL_FATAL;
        spdlog::log(is_fatal ? spdlog::level::critical : spdlog::level::debug, "protobuf: {}", message);
      });
}

// Signals are waited for, in every thread, so they are blocked before there is more than one.
int BlockSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigprocmask(SIG_BLOCK, &signals, nullptr);
  // Whoever read the log may go.
  signal(SIGPIPE, SIG_IGN);
  return signalfd(-1, &signals, SFD_CLOEXEC);
}

// Returns when a signal comes, or when standard input closes if that matters.
void WaitForTheEnd(int signals, bool exit_with_parent) {
  std::array<pollfd, 2> sources{{{signals, POLLIN, 0}, {STDIN_FILENO, POLLIN, 0}}};
  while (true) {
    if (poll(sources.data(), exit_with_parent ? 2 : 1, -1) < 0) continue;
    if (sources[0].revents != 0) {
      spdlog::info("stopping on a signal");
      return;
    }
    std::array<char, 4096> ignored{};
    if (sources[1].revents != 0 && read(STDIN_FILENO, ignored.data(), ignored.size()) <= 0) {
      spdlog::info("stopping, for standard input was closed");
      return;
    }
  }
}

int Run(const CommandLine& line) {
  // Debian's abseil looks for deadlocks at every lock that gRPC takes.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  const int signals = BlockSignals();
  auto server = genphys::Server::Start(genphys::BuiltinBackends(), line.server);
  if (!server.ok()) {
    std::fprintf(stderr, "genphysd: %s\n", genphys::MessageOf(server.status()).c_str());
    return EXIT_FAILURE;
  }
  for (const std::string& address : (*server)->addresses()) std::printf("genphysd listening on %s\n", address.c_str());
  std::fflush(stdout);
  WaitForTheEnd(signals, line.exit_with_parent);
  // A step that never ends must not keep the program alive.
  std::thread([] {
    std::this_thread::sleep_for(kEndMax);
    spdlog::warn("a step does not end; leaving it");
    spdlog::shutdown();
    std::_Exit(EXIT_SUCCESS);
  }).detach();
  (*server)->Shutdown(kGrace);
  spdlog::info("stopped");
  spdlog::shutdown();
  // Nothing is left to save, and a world with a million entities takes longer to take apart than to forget.
  std::_Exit(EXIT_SUCCESS);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine line;
  CLI::App app(kDescription, "genphysd");
  Declare(app, line);
  CLI11_PARSE(app, argc, argv);
  if (line.server.addresses.empty()) line.server.addresses = {"127.0.0.1:50051"};
  LogToStandardError(line.log_level);
  return Run(line);
}

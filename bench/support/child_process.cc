#include "child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <stdexcept>
#include <thread>

namespace genphys::bench {
namespace {

// Programs that end when their input does are given this long to do so.
constexpr std::chrono::milliseconds kGraceMax{5'000};
constexpr std::chrono::milliseconds kPause{10};

}  // namespace

ChildProcess::ChildProcess(std::vector<std::string> arguments) : program_(arguments.front()) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  std::array<int, 2> input{}, output{};
  if (pipe2(input.data(), O_CLOEXEC) != 0 || pipe2(output.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error("no pipe can be made");
  }
  // Spawned, not forked: gRPC's threads may be running here.
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output[1], STDOUT_FILENO);
  const int error = posix_spawnp(&pid_, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(input[0]);
  close(output[1]);
  input_ = input[1];
  output_ = output[0];
  if (error == 0) return;
  close(input_);
  close(output_);
  throw std::runtime_error(program_ + " cannot be started");
}

ChildProcess::~ChildProcess() {
  close(input_);
  close(output_);
  const auto end = std::chrono::steady_clock::now() + kGraceMax;
  while (waitpid(pid_, nullptr, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() >= end) kill(pid_, SIGKILL);
    std::this_thread::sleep_for(kPause);
  }
}

void ChildProcess::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(input_, bytes.data(), bytes.size());
    if (count <= 0) throw std::runtime_error(program_ + " no longer listens");
    bytes.remove_prefix(static_cast<size_t>(count));
  }
}

std::string ChildProcess::ReadLine() {
  size_t end;
  while ((end = received_.find('\n')) == std::string::npos) {
    std::array<char, 4096> buffer{};
    const ssize_t count = read(output_, buffer.data(), buffer.size());
    if (count <= 0) throw std::runtime_error(program_ + " ended before it answered");
    received_.append(buffer.data(), static_cast<size_t>(count));
  }
  std::string line = received_.substr(0, end);
  received_.erase(0, end + 1);
  return line;
}

double ChildProcess::cpu_time() const {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &time) != 0) {
    throw std::runtime_error(program_ + " is gone");
  }
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace genphys::bench

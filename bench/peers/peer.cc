#include "peer.h"

#include <cstdlib>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "scene_json.h"
#include "support/child_process.h"

namespace genphys::bench {
namespace {

// The running program. Requests are lines with a JSON array each; only some are answered, so that many steps cost one
// turn of the pipe. See protocol.py.
class Program {
 public:
  explicit Program(std::vector<std::string> command) : command_(std::move(command)) { Launch(); }

  const std::string& about() const { return about_; }
  /// Which of its simulations is the present one.
  size_t turn() const { return turn_; }

  void Start(const Scene& scene) {
    const std::string json = ToJson(scene);
    // It may have ended in the hands of the last scene.
    if (!process_) Launch();
    ++turn_;
    Ask("[\"start\"," + json + "]\n");
  }

  /// What it answers to the last of some requests.
  std::string Ask(const std::string& requests) {
    if (!process_) throw std::runtime_error("it has ended");
    std::string line;
    try {
      process_->Write(requests);
      line = process_->ReadLine();
    } catch (const std::exception&) {
      process_.reset();
      throw;
    }
    const size_t blank = line.find(' ');
    const std::string rest = blank == std::string::npos ? "" : line.substr(blank + 1);
    if (line.substr(0, blank) == "no") throw std::runtime_error(rest);
    if (line.substr(0, blank) != "ok") throw std::runtime_error("it says \"" + line + '"');
    return rest;
  }

 private:
  void Launch() {
    process_.emplace(command_);
    about_ = Ask("[\"about\"]\n");
  }

  std::vector<std::string> command_;
  std::optional<ChildProcess> process_;
  std::string about_;
  size_t turn_ = 0;
};

// What goes wrong in a request that has no answer is told with the next one that has.
class PeerSimulation final : public Simulation {
 public:
  PeerSimulation(std::shared_ptr<Program> program, const Scene& scene) : program_(std::move(program)) {
    program_->Start(scene);
    turn_ = program_->turn();
    motions_.resize(scene.bodies.size());
  }

  // Steps are only counted until somebody asks what came of them.
  void Step(double step_size) override {
    if (count_ > 0 && step_size != step_size_) PutSteps();
    step_size_ = step_size;
    ++count_;
    is_known_ = false;
  }

  double TimedSteps(double step_size, long count) override {
    is_known_ = false;
    return Numbers("[\"time\"," + Exact(step_size) + ',' + std::to_string(count) + ']').at(0);
  }

  Motion MotionOf(size_t body) const override {
    if (!is_known_) Look();
    return motions_.at(body);
  }

  void Hold(size_t body, const Vector3& force, const Vector3& torque) override {
    Put("[\"hold\"," + std::to_string(body) + Tail(force) + Tail(torque) + ']');
  }
  void Kick(size_t body, const Vector3& impulse) override {
    Put("[\"kick\"," + std::to_string(body) + Tail(impulse) + ']');
  }
  void SetGravity(const Vector3& gravity) override { Put("[\"gravity\"" + Tail(gravity) + ']'); }
  void Remove(size_t body) override { Put("[\"remove\"," + std::to_string(body) + ']'); }
  void Release(size_t joint) override { Put("[\"release\"," + std::to_string(joint) + ']'); }

  StepStats Explain(double step_size) override {
    Step(step_size);
    return {};
  }

 private:
  static std::string Tail(const Vector3& v) { return ',' + Exact(v.x()) + ',' + Exact(v.y()) + ',' + Exact(v.z()); }

  void PutSteps() const {
    if (count_ == 0) return;
    waiting_ += "[\"step\"," + Exact(step_size_) + ',' + std::to_string(count_) + "]\n";
    count_ = 0;
  }

  void Put(const std::string& request) const {
    PutSteps();
    waiting_ += request + '\n';
    is_known_ = false;
  }

  std::vector<double> Numbers(const std::string& request) const {
    if (turn_ != program_->turn()) throw std::logic_error("a peer simulates one scene at a time");
    Put(request);
    const std::string answer = program_->Ask(std::exchange(waiting_, ""));
    std::vector<double> numbers;
    // Not by a stream, which is slower and does not read "nan".
    const char* at = answer.c_str();
    for (char* end = nullptr;; at = end) {
      const double number = std::strtod(at, &end);
      if (end == at) return numbers;
      numbers.push_back(number);
    }
  }

  void Look() const {
    constexpr size_t kNumbers = 13;
    const std::vector<double> all = Numbers("[\"state\"]");
    if (all.size() != kNumbers * motions_.size()) throw std::runtime_error("it tells of other bodies");
    for (size_t i = 0; i < motions_.size(); ++i) {
      const double* n = &all[kNumbers * i];
      motions_[i] = {Vector3(n), Quaternion(n[3], n[4], n[5], n[6]), Vector3(n + 7), Vector3(n + 10)};
    }
    is_known_ = true;
  }

  std::shared_ptr<Program> program_;
  size_t turn_ = 0;
  // Looking changes these, and nothing that anybody sees.
  mutable double step_size_ = 0;
  mutable size_t count_ = 0;       // steps not yet asked for
  mutable std::string waiting_;    // requests that are not yet sent
  mutable bool is_known_ = false;  // whether `motions_` is of now
  mutable std::vector<Motion> motions_;
};

}  // namespace

Peer StartPeer(const std::string& description) {
  const size_t sign = description.find('=');
  if (sign == std::string::npos) throw std::runtime_error("a peer is told as <name>=<program> <arguments>");
  std::istringstream words(description.substr(sign + 1));
  std::vector<std::string> command;
  for (std::string word; words >> word;) command.push_back(word);
  if (command.empty()) throw std::runtime_error("a peer needs a program");
  const std::string name = description.substr(0, sign);
  const auto program = std::make_shared<Program>(std::move(command));
  return {{name, name, [program](const Scene& scene) { return std::make_unique<PeerSimulation>(program, scene); }},
          program->about()};
}

}  // namespace genphys::bench

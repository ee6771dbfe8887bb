#pragma once
#include <array>
#include <string>

#include "genphys/v1/simulation_service.pb.h"
#include "integration/live_server.h"
#include "integration/raw_call.h"

namespace genphys::testing {

/// A live server with one small world, "worlds/a", in which requests are tried, good ones and bad ones. A good one that
/// changes something is tried in a world of its own: the same world, made anew.
class InputBench {
 public:
  explicit InputBench(const std::string& engine);

  /// Of a ball that lies on a crate.
  uint64_t ball() const { return ball_; }
  /// Of a crate that lies on the floor.
  uint64_t crate() const { return crate_; }
  /// Of an entity that was deleted.
  uint64_t stale() const { return stale_; }
  const std::string& engine() const { return engine_; }

  /// Puts ids of things that exist, and what a body needs, wherever `message` asks for them.
  void Complete(google::protobuf::Message& message) const;

  /// Sends `request` and fails the test unless the verdict is `wanted`, in the words of VerdictOf(). What is refused
  /// must leave the state hash as it was. After what is accepted, the world must step 100 times with a finite state.
  void Try(const google::protobuf::MethodDescriptor& method, const google::protobuf::Message& request,
           const std::string& wanted, const std::string& what);
  /// That for bytes.
  void Try(const google::protobuf::MethodDescriptor& method, const std::string& request, const std::string& wanted,
           const std::string& what);
  /// That where either may be: returns whether it was accepted. A refusal must be one of ours, and not for what the
  /// steps came to.
  bool TryEither(const google::protobuf::MethodDescriptor& method, const google::protobuf::Message& request,
                 const std::string& what);
  /// Try() for a StepRequest to the world in text format, `text` being what comes after its name.
  void TryStep(const std::string& text, const std::string& wanted);

 private:
  Answer Send(const std::string& method, const google::protobuf::Message& request) const;
  void Rebuild();
  v1::StepResponse MustStep(const v1::StepRequest& request) const;
  v1::WorldStamp StampNow() const;
  void MustBeUnchanged(const std::string& what);
  void GoOn(const google::protobuf::MethodDescriptor& method, const std::string& reply, const std::string& what);
  void StepOn(const std::string& world, const std::string& what);
  void Complain(const std::string& what, const std::string& complaint);

  const std::string engine_;
  LiveServer server_;
  std::shared_ptr<grpc::Channel> channel_;
  uint64_t ball_ = 0, crate_ = 0, stale_ = 0;
  std::array<uint64_t, 2> joints_{};
  v1::WorldStamp stamp_;
  int complaints_ = 0;
};

}  // namespace genphys::testing

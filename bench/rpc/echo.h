#pragma once
#include <grpcpp/channel.h>
#include <grpcpp/support/byte_buffer.h>

#include <memory>
#include <string>
#include <string_view>

#include "support/child_process.h"

namespace genphys::v1 {
class StepRequest;
}

namespace genphys::bench {

/// What carrying a reply costs without a world: a unary gRPC call over TCP to another process, which answers with what
/// it has ready. The server is this very program, started once more.
class Echo {
 public:
  enum class Kind {
    kBytes,     // neither side looks into the bytes: the least that a unary call can be
    kMessages,  // both sides have messages, as programs do: the server encodes a copy of its reply, the client decodes
                // it
  };

  explicit Echo(Kind kind);
  ~Echo();

  /// What the following calls carry.
  void Carry(const std::string& request, const std::string& reply);
  /// One call. A failure, or a reply of another size than given, is a std::runtime_error.
  void Call();

  const ChildProcess& server() const { return server_; }

 private:
  void CallWithBytes();
  void CallWithMessages();

  const Kind kind_;
  ChildProcess server_;
  std::shared_ptr<grpc::Channel> channel_;
  grpc::ByteBuffer request_bytes_;
  std::unique_ptr<v1::StepRequest> request_;
  size_t reply_size_ = 0;
};

/// The first argument that makes this program such a server; the second one is its kind.
inline constexpr std::string_view kEchoServer = "--echo-server";

/// The server's side: prints the port that it listens at, and reads replies from standard input until that is closed.
int RunEchoServer(std::string_view kind);

}  // namespace genphys::bench

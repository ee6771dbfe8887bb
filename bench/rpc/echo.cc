#include "echo.h"

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <iostream>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "genphys/client/options.h"
#include "genphys/v1/simulation_service.grpc.pb.h"

namespace genphys::bench {
namespace {

constexpr char kMethod[] = "/genphys.v1.SimulationService/Step";
constexpr std::string_view kBytes = "bytes";
constexpr std::string_view kMessages = "messages";

grpc::ByteBuffer ToByteBuffer(const std::string& bytes) {
  const grpc::Slice slice(bytes);
  return grpc::ByteBuffer(&slice, 1);
}

/// Answers every Step with the reply last learned. `Base` is the service with Step taken as messages or as bytes.
template <typename Base, typename Request, typename Reply>
class EchoService final : public Base {
 public:
  void Learn(Reply reply) {
    const std::lock_guard lock(mutex_);
    reply_ = std::move(reply);
  }

  grpc::ServerUnaryReactor* Step(grpc::CallbackServerContext* context, const Request*, Reply* response) override {
    {
      const std::lock_guard lock(mutex_);
      *response = reply_;
    }
    grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
    reactor->Finish(grpc::Status::OK);
    return reactor;
  }

 private:
  std::mutex mutex_;
  Reply reply_;
};

using Simulation = v1::SimulationService;
using BytesService =
    EchoService<Simulation::WithRawCallbackMethod_Step<Simulation::Service>, grpc::ByteBuffer, grpc::ByteBuffer>;
using MessageService =
    EchoService<Simulation::WithCallbackMethod_Step<Simulation::Service>, v1::StepRequest, v1::StepResponse>;

std::shared_ptr<grpc::Channel> Connect(const std::string& port) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return grpc::CreateCustomChannel("127.0.0.1:" + port, grpc::InsecureChannelCredentials(), arguments);
}

void Check(const grpc::Status& status, size_t size, size_t wanted) {
  if (!status.ok()) throw std::runtime_error("the echo failed: " + status.error_message());
  if (size != wanted) throw std::runtime_error("the echo came back with another size");
}

// Replies come as a line with their size and that many bytes; each is acknowledged by a line.
template <typename Learn>
int Serve(grpc::Service& service, Learn learn) {
  int port = 0;
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&service);
  const std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  if (server == nullptr || port == 0) return EXIT_FAILURE;
  std::cout << port << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    std::string reply(std::stoul(line), '\0');
    if (!std::cin.read(reply.data(), static_cast<std::streamsize>(reply.size()))) return EXIT_FAILURE;
    learn(reply);
    std::cout << "ready" << std::endl;
  }
  server->Shutdown();
  return EXIT_SUCCESS;
}

}  // namespace

Echo::Echo(Kind kind)
    : kind_(kind),
      server_({"/proc/self/exe", std::string(kEchoServer), std::string(kind == Kind::kBytes ? kBytes : kMessages)}),
      channel_(Connect(server_.ReadLine())),
      request_(std::make_unique<v1::StepRequest>()) {}

Echo::~Echo() = default;

void Echo::Carry(const std::string& request, const std::string& reply) {
  request_bytes_ = ToByteBuffer(request);
  if (!request_->ParseFromString(request)) throw std::runtime_error("the echo's request is none");
  reply_size_ = reply.size();
  server_.Write(std::to_string(reply.size()) + '\n');
  server_.Write(reply);
  server_.ReadLine();
}

void Echo::Call() {
  if (kind_ == Kind::kBytes) {
    CallWithBytes();
  } else {
    CallWithMessages();
  }
}

void Echo::CallWithBytes() {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + client::kDefaultDeadline);
  grpc::CompletionQueue queue;
  const auto call = grpc::GenericStub(channel_).PrepareUnaryCall(&context, kMethod, request_bytes_, &queue);
  call->StartCall();
  grpc::ByteBuffer reply;
  grpc::Status status;
  call->Finish(&reply, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  Check(status, reply.Length(), reply_size_);
}

void Echo::CallWithMessages() {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + client::kDefaultDeadline);
  v1::StepResponse reply;
  const grpc::Status status = Simulation::Stub(channel_).Step(&context, *request_, &reply);
  Check(status, reply.ByteSizeLong(), reply_size_);
}

int RunEchoServer(std::string_view kind) {
  if (kind == kBytes) {
    BytesService service;
    return Serve(service, [&](const std::string& reply) { service.Learn(ToByteBuffer(reply)); });
  }
  MessageService service;
  return Serve(service, [&](const std::string& bytes) {
    v1::StepResponse reply;
    if (!reply.ParseFromString(bytes)) std::exit(EXIT_FAILURE);
    service.Learn(std::move(reply));
  });
}

}  // namespace genphys::bench

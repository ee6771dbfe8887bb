#include "support/test_server.h"

#include <fcntl.h>
#include <grpcpp/generic/generic_stub.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include "genphys/builtin_backends.h"
#include "genphys/wire/error.h"

namespace genphys::testing {

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "genphys-XXXXXX").string();
  path_ = mkdtemp(pattern.data());
}

TemporaryFolder::~TemporaryFolder() { std::filesystem::remove_all(path_); }

TestServer::TestServer(ServerOptions options) {
  if (options.addresses.empty()) options.addresses = {"unix:" + (folder_.path() / "socket").string()};
  auto server = Server::Start(BuiltinBackends(), options);
  if (!server.ok()) {
    ADD_FAILURE() << "the server does not start: " << server.status().message();
    std::abort();
  }
  server_ = *std::move(server);
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  // Servers of other tests have been at other sockets: nothing of their channels is of use here.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  channel_ = grpc::CreateCustomChannel(address(), grpc::InsecureChannelCredentials(), arguments);
  engines_ = v1::EngineService::NewStub(channel_);
  worlds_ = v1::WorldService::NewStub(channel_);
  simulation_ = v1::SimulationService::NewStub(channel_);
}

TestServer::~TestServer() {
  if (!stopped_) server_->Shutdown(std::chrono::milliseconds(0));
}

v1::CreateWorldResponse TestServer::CreateWorld(const v1::World& world) {
  v1::CreateWorldRequest request;
  *request.mutable_world() = world;
  return Must(worlds(), &v1::WorldService::Stub::CreateWorld, request);
}

uint64_t TestServer::AddBall(const std::string& world, double z) {
  v1::CreateEntityRequest request;
  request.set_world(world);
  request.mutable_entity()->mutable_pose()->mutable_position()->set_z(z);
  v1::Geometry* const geometry = request.mutable_entity()->mutable_rigid_body()->add_geometries();
  geometry->mutable_shape()->mutable_sphere()->set_radius(0.5);
  return Must(simulation(), &v1::SimulationService::Stub::CreateEntity, request).entity().id();
}

v1::StepResponse TestServer::Step(const std::string& world, uint32_t steps) {
  v1::StepRequest request;
  request.set_world(world);
  request.set_steps(steps);
  return Must(simulation(), &v1::SimulationService::Stub::Step, request);
}

Status Received(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  google::rpc::Status details;
  if (!status.error_details().empty() && details.ParseFromString(status.error_details())) return DecodeStatus(details);
  return Status(static_cast<absl::StatusCode>(status.error_code()), status.error_message());
}

void ExpectRefusal(const Status& status, Reason reason, const std::string& field) {
  const std::optional<Refusal> refusal = RefusalOf(status);
  ASSERT_TRUE(refusal) << status.ToString();
  EXPECT_EQ(NameOf(refusal->reason), NameOf(reason)) << status.ToString();
  EXPECT_EQ(refusal->field, field) << status.ToString();
  EXPECT_EQ(status.code(), CodeOf(reason)) << status.ToString();
}

grpc::Status CallRaw(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                     const std::string& request, std::string* response) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  const grpc::Slice slice(request);
  grpc::CompletionQueue queue;
  const auto call = stub.PrepareUnaryCall(&context, method, grpc::ByteBuffer(&slice, 1), &queue);
  call->StartCall();
  grpc::ByteBuffer reply;
  grpc::Status status;
  call->Finish(&reply, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  std::vector<grpc::Slice> slices;
  if (status.ok() && reply.Dump(&slices).ok()) {
    for (const grpc::Slice& piece : slices) {
      response->append(reinterpret_cast<const char*>(piece.begin()), piece.size());
    }
  }
  return status;
}

ServerProcess::ServerProcess(std::vector<std::string> arguments) {
  const char* const program = std::getenv("GENPHYS_SERVER");
  if (program == nullptr) {
    ADD_FAILURE() << "GENPHYS_SERVER does not say where the server is";
    std::abort();
  }
  arguments.insert(arguments.begin(), program);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const std::string errors = (folder_.path() / "errors").string();
  int input[2], output[2];
  if (pipe2(input, O_CLOEXEC) != 0 || pipe2(output, O_CLOEXEC) != 0) std::abort();
  pid_ = fork();
  if (pid_ == 0) {
    dup2(input[0], STDIN_FILENO);
    dup2(output[1], STDOUT_FILENO);
    dup2(open(errors.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), STDERR_FILENO);
    execv(program, argv.data());
    _exit(127);
  }
  close(input[0]);
  close(output[1]);
  input_ = input[1];
  output_ = output[0];
}

ServerProcess::~ServerProcess() {
  if (pid_ > 0) {
    Signal(SIGKILL);
    Wait();
  }
  CloseInput();
  close(output_);
}

std::string ServerProcess::ReadLine() {
  std::string line;
  for (char byte = 0; read(output_, &byte, 1) == 1 && byte != '\n';) line += byte;
  return line;
}

std::string ServerProcess::ReadErrors() const {
  std::ifstream file(folder_.path() / "errors");
  return {std::istreambuf_iterator<char>(file), {}};
}

void ServerProcess::CloseInput() {
  if (input_ >= 0) close(std::exchange(input_, -1));
}

void ServerProcess::Signal(int signal) const { kill(pid_, signal); }

int ServerProcess::Wait() {
  int status = 0;
  waitpid(std::exchange(pid_, -1), &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace genphys::testing

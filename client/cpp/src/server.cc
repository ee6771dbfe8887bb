#include "genphys/client/server.h"

#include <utility>

#include "connection.h"
#include "genphys/wire/decode.h"
#include "genphys/wire/encode.h"
#include "genphys/wire/error.h"
#include "requests.h"

namespace genphys::client {
namespace {

using Worlds = v1::WorldService::Stub;
using Engines = v1::EngineService::Stub;

constexpr int kPageSize = 1000;
constexpr std::string_view kWorldPrefix = "worlds/";

std::string FullName(const std::string& name) {
  return name.empty() || name.starts_with(kWorldPrefix) ? name : std::string(kWorldPrefix) + name;
}

}  // namespace

Result<Server> Connect(const std::string& address, const ConnectOptions& options) {
  auto connection = std::make_shared<Connection>(address, options);
  GENPHYS_RETURN_IF_ERROR(connection->WaitUntilConnected(options.connect_timeout));
  return Server(std::move(connection));
}

Server::Server(std::shared_ptr<Connection> connection) : connection_(std::move(connection)) {}

Result<World> Server::CreateWorld(const WorldOptions& options) const {
  v1::CreateWorldRequest request;
  request.set_request_id(connection_->NextRequestId());
  EncodeWorld(options.world, FullName(options.name), v1::World::STATE_UNSPECIFIED, request.mutable_world());
  request.mutable_world()->set_record_state_hash(options.record_state_hash);
  v1::CreateWorldResponse response;
  GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->worlds(), &Worlds::CreateWorld, request, &response));
  return World(connection_, response.world().name(), !options.keep);
}

Result<World> Server::OpenWorld(const std::string& name) const {
  World world(connection_, FullName(name), /*owned=*/false);
  const Result<WorldInfo> info = world.Info();
  if (!info.ok()) return info.status();
  return world;
}

Result<std::vector<std::string>> Server::ListWorlds() const {
  std::vector<std::string> names;
  v1::ListWorldsRequest request;
  request.set_page_size(kPageSize);
  do {
    v1::ListWorldsResponse response;
    GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->worlds(), &Worlds::ListWorlds, request, &response));
    for (const v1::World& world : response.worlds()) names.push_back(world.name());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return names;
}

Result<std::vector<EngineInfo>> Server::ListEngines() const {
  std::vector<EngineInfo> engines;
  v1::ListEnginesRequest request;
  request.set_page_size(kPageSize);
  do {
    v1::ListEnginesResponse response;
    GENPHYS_RETURN_IF_ERROR(connection_->Call(connection_->engines(), &Engines::ListEngines, request, &response));
    for (const v1::Engine& engine : response.engines()) {
      Result<std::string> name = DecodeEngineName(engine.name());
      if (!name.ok()) return name.status();
      EngineInfo info{*std::move(name), engine.version(), {}};
      for (const int feature : engine.features()) {
        // A newer server may have features that this build has no name for.
        if (v1::Feature_IsValid(feature)) info.features.push_back(static_cast<Feature>(feature));
      }
      engines.push_back(std::move(info));
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return engines;
}

std::vector<Result<StepResult>> Server::StepWorlds(std::span<const WorldSteps> wanted,
                                                   std::optional<std::chrono::milliseconds> deadline) const {
  v1::StepWorldsRequest request;
  for (const WorldSteps& each : wanted) {
    v1::StepRequest* const step = request.add_requests();
    step->set_world(each.world);
    EncodeStep(each.steps, each.options, step);
  }
  std::vector<std::optional<Result<StepResult>>> found(wanted.size());
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + deadline.value_or(connection_->deadline()));
  const auto reader = connection_->simulation().StepWorlds(&context, request);
  for (auto message = std::make_shared<v1::StepWorldsResponse>(); reader->Read(message.get());
       message = std::make_shared<v1::StepWorldsResponse>()) {
    for (const v1::StepWorldsResult& result : message->results()) {
      if (result.index() >= found.size()) continue;
      std::optional<Result<StepResult>>& place = found[result.index()];
      if (result.has_refusal()) {
        place = DecodeRefusal(result.refusal());
      } else {
        place = DecodeStep(std::shared_ptr<const v1::StepResponse>(message, &result.response()));
      }
    }
  }
  Status end = FromGrpc(reader->Finish());
  if (end.ok()) end = absl::InternalError("the server left a world out");
  std::vector<Result<StepResult>> results;
  for (std::optional<Result<StepResult>>& each : found) {
    results.push_back(each ? *std::move(each) : Result<StepResult>(end));
  }
  return results;
}

}  // namespace genphys::client

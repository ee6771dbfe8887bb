#include "engine_service.h"

#include <algorithm>
#include <string>

#include "genphys/hosting/world_methods.h"
#include "genphys/wire/encode.h"
#include "transport.h"

namespace genphys {

EngineService::EngineService(const BackendRegistry& registry) {
  for (const auto& backend : registry.backends()) EncodeEngine(backend->capabilities(), &engines_.emplace_back());
  std::sort(engines_.begin(), engines_.end(), [](const auto& a, const auto& b) { return a.name() < b.name(); });
}

template <typename Request, typename Response>
grpc::ServerUnaryReactor* EngineService::Answer(grpc::CallbackServerContext* context, const grpc::ByteBuffer& request,
                                                grpc::ByteBuffer* response,
                                                Status (EngineService::*answer)(const Request&, Response*)
                                                    const) const {
  Request decoded;
  Response reply;
  Status status = DecodeRequest(ToBytes(request), &decoded);
  if (status.ok()) status = (this->*answer)(decoded, &reply);
  if (status.ok()) *response = ToByteBuffer(EncodeReply(reply));
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  reactor->Finish(ToGrpcStatus(status));
  return reactor;
}

grpc::ServerUnaryReactor* EngineService::ListEngines(grpc::CallbackServerContext* context,
                                                     const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return Answer(context, *request, response, &EngineService::List);
}

grpc::ServerUnaryReactor* EngineService::GetEngine(grpc::CallbackServerContext* context,
                                                   const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return Answer(context, *request, response, &EngineService::Get);
}

Status EngineService::List(const v1::ListEnginesRequest& request, v1::ListEnginesResponse* response) const {
  // A page goes on after the engine that its token names.
  auto engine = engines_.begin();
  if (!request.page_token().empty()) {
    engine = std::find_if(engines_.begin(), engines_.end(),
                          [&](const v1::Engine& other) { return other.name() == request.page_token(); });
    if (engine == engines_.end()) {
      return Refuse(Reason::kInvalidValue, "page_token", "page_token is none of this server's");
    }
    ++engine;
  }
  const int page_size = request.page_size() > 0 ? request.page_size() : static_cast<int>(engines_.size());
  while (engine != engines_.end() && response->engines_size() < page_size) *response->add_engines() = *engine++;
  if (engine != engines_.end()) response->set_next_page_token(std::prev(engine)->name());
  return absl::OkStatus();
}

Status EngineService::Get(const v1::GetEngineRequest& request, v1::GetEngineResponse* response) const {
  for (const v1::Engine& engine : engines_) {
    if (engine.name() != request.name()) continue;
    *response->mutable_engine() = engine;
    return absl::OkStatus();
  }
  std::string names;
  for (const v1::Engine& engine : engines_) names += (names.empty() ? "" : ", ") + engine.name();
  return Refuse(Reason::kInvalidValue, "name", "there is no " + request.name() + "; there are: " + names);
}

}  // namespace genphys

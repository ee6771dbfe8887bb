#pragma once
#include <grpcpp/grpcpp.h>

#include <vector>

#include "genphys/registry.h"
#include "genphys/v1/engine_service.grpc.pb.h"

namespace genphys {

using RawEngineService = v1::EngineService::WithRawCallbackMethod_ListEngines<
    v1::EngineService::WithRawCallbackMethod_GetEngine<v1::EngineService::Service>>;

/// Tells what the engines of the registry can do. "engines/none" is no engine and is not among them.
class EngineService final : public RawEngineService {
 public:
  /// `registry` outlives the service.
  explicit EngineService(const BackendRegistry& registry);

  grpc::ServerUnaryReactor* ListEngines(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetEngine(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;

 private:
  // Decoded here and not by gRPC, which would refuse what is no request without saying why.
  template <typename Request, typename Response>
  grpc::ServerUnaryReactor* Answer(grpc::CallbackServerContext* context, const grpc::ByteBuffer& request,
                                   grpc::ByteBuffer* response,
                                   Status (EngineService::*answer)(const Request&, Response*) const) const;
  Status List(const v1::ListEnginesRequest& request, v1::ListEnginesResponse* response) const;
  Status Get(const v1::GetEngineRequest& request, v1::GetEngineResponse* response) const;

  std::vector<v1::Engine> engines_;  // by name
};

}  // namespace genphys

#pragma once
#include <grpcpp/grpcpp.h>

#include <vector>

#include "genphys/registry.h"
#include "genphys/v1/engine_service.grpc.pb.h"

namespace genphys {

/// Tells what the engines of the registry can do. "engines/none" is no engine and is not among them.
class EngineService final : public v1::EngineService::CallbackService {
 public:
  /// `registry` outlives the service.
  explicit EngineService(const BackendRegistry& registry);

  grpc::ServerUnaryReactor* ListEngines(grpc::CallbackServerContext* context, const v1::ListEnginesRequest* request,
                                        v1::ListEnginesResponse* response) override;
  grpc::ServerUnaryReactor* GetEngine(grpc::CallbackServerContext* context, const v1::GetEngineRequest* request,
                                      v1::GetEngineResponse* response) override;

 private:
  Status List(const v1::ListEnginesRequest& request, v1::ListEnginesResponse* response) const;
  Status Get(const v1::GetEngineRequest& request, v1::GetEngineResponse* response) const;

  std::vector<v1::Engine> engines_;  // by name
};

}  // namespace genphys

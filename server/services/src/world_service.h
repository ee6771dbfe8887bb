#pragma once
#include "calls.h"
#include "genphys/v1/world_service.grpc.pb.h"

namespace genphys {

using RawWorldService =
    v1::WorldService::WithRawCallbackMethod_CreateWorld<v1::WorldService::WithRawCallbackMethod_GetWorld<
        v1::WorldService::WithRawCallbackMethod_ListWorlds<v1::WorldService::WithRawCallbackMethod_DeleteWorld<
            v1::WorldService::WithRawCallbackMethod_ResetWorld<v1::WorldService::WithRawCallbackMethod_PlayWorld<
                v1::WorldService::WithRawCallbackMethod_PauseWorld<v1::WorldService::Service>>>>>>>;

/// Hands encoded requests to the directory and encoded replies back.
class WorldService final : public RawWorldService {
 public:
  WorldService(WorldDirectory& directory, OpenCalls& calls) : directory_(directory), calls_(calls) {}

  grpc::ServerUnaryReactor* CreateWorld(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetWorld(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                     grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListWorlds(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* DeleteWorld(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ResetWorld(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* PlayWorld(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* PauseWorld(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;

 private:
  WorldDirectory& directory_;
  OpenCalls& calls_;
};

}  // namespace genphys

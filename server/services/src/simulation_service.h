#pragma once
#include "calls.h"
#include "genphys/v1/simulation_service.grpc.pb.h"

namespace genphys {

using RawSimulationService =
    v1::SimulationService::WithRawCallbackMethod_CreateEntity<v1::SimulationService::WithRawCallbackMethod_DeleteEntity<
        v1::SimulationService::WithRawCallbackMethod_ApplyForce<v1::SimulationService::WithRawCallbackMethod_GetEntity<
            v1::SimulationService::WithRawCallbackMethod_ListEntities<
                v1::SimulationService::WithRawCallbackMethod_ListJoints<
                    v1::SimulationService::WithRawCallbackMethod_ListForceFields<
                        v1::SimulationService::WithRawCallbackMethod_Step<
                            v1::SimulationService::WithRawCallbackMethod_CastRays<
                                v1::SimulationService::WithRawCallbackMethod_CastShape<
                                    v1::SimulationService::WithRawCallbackMethod_FindOverlaps<
                                        v1::SimulationService::WithRawCallbackMethod_FindClosest<
                                            v1::SimulationService::WithRawCallbackMethod_MeasureDistances<
                                                v1::SimulationService::WithRawCallbackMethod_GetContacts<
                                                    v1::SimulationService::WithRawCallbackMethod_WatchEvents<
                                                        v1::SimulationService::WithRawCallbackMethod_WatchFrames<
                                                            v1::SimulationService::WithRawCallbackMethod_StepWorlds<
                                                                v1::SimulationService::WithRawCallbackMethod_Drive<
                                                                    v1::SimulationService::Service>>>>>>>>>>>>>>>>>>;

/// Hands encoded requests to worlds, and encoded replies and streams back.
class SimulationService final : public RawSimulationService {
 public:
  SimulationService(WorldDirectory& directory, OpenCalls& calls) : directory_(directory), calls_(calls) {}

  grpc::ServerUnaryReactor* CreateEntity(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* DeleteEntity(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ApplyForce(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetEntity(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListEntities(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListJoints(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListForceFields(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                            grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* Step(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                 grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* CastRays(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                     grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* CastShape(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* FindOverlaps(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* FindClosest(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* MeasureDistances(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                             grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetContacts(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchEvents(grpc::CallbackServerContext* context,
                                                          const grpc::ByteBuffer* request) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchFrames(grpc::CallbackServerContext* context,
                                                          const grpc::ByteBuffer* request) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* StepWorlds(grpc::CallbackServerContext* context,
                                                         const grpc::ByteBuffer* request) override;
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Drive(grpc::CallbackServerContext* context) override;

 private:
  WorldDirectory& directory_;
  OpenCalls& calls_;
};

}  // namespace genphys

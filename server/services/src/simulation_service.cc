#include "simulation_service.h"

#include "transport.h"

namespace genphys {

grpc::ServerUnaryReactor* SimulationService::CreateEntity(grpc::CallbackServerContext* context,
                                                          const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kCreateEntity, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::DeleteEntity(grpc::CallbackServerContext* context,
                                                          const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kDeleteEntity, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::ApplyForce(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kApplyForce, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::GetEntity(grpc::CallbackServerContext* context,
                                                       const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kGetEntity, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::ListEntities(grpc::CallbackServerContext* context,
                                                          const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kListEntities, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::ListJoints(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kListJoints, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::ListForceFields(grpc::CallbackServerContext* context,
                                                             const grpc::ByteBuffer* request,
                                                             grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kListForceFields, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::Step(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                                  grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kStep, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::CastRays(grpc::CallbackServerContext* context,
                                                      const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kCastRays, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::CastShape(grpc::CallbackServerContext* context,
                                                       const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kCastShape, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::FindOverlaps(grpc::CallbackServerContext* context,
                                                          const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kFindOverlaps, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::FindClosest(grpc::CallbackServerContext* context,
                                                         const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kFindClosest, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::MeasureDistances(grpc::CallbackServerContext* context,
                                                              const grpc::ByteBuffer* request,
                                                              grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kMeasureDistances, context, request, response);
}

grpc::ServerUnaryReactor* SimulationService::GetContacts(grpc::CallbackServerContext* context,
                                                         const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kGetContacts, context, request, response);
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* SimulationService::WatchEvents(grpc::CallbackServerContext*,
                                                                           const grpc::ByteBuffer* request) {
  return new MessageStream(calls_, directory_.Watch(WorldMethod::kWatchEvents, ToBytes(*request)));
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* SimulationService::WatchFrames(grpc::CallbackServerContext*,
                                                                           const grpc::ByteBuffer* request) {
  return new MessageStream(calls_, directory_.Watch(WorldMethod::kWatchFrames, ToBytes(*request)));
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* SimulationService::StepWorlds(grpc::CallbackServerContext* context,
                                                                          const grpc::ByteBuffer* request) {
  return new MessageStream(calls_, directory_.StepWorlds(ToBytes(*request), DeadlineOf(*context)));
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* SimulationService::Drive(
    grpc::CallbackServerContext* context) {
  return new DriveStream(calls_, directory_.OpenDrive(DeadlineOf(*context)));
}

}  // namespace genphys

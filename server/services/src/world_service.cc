#include "world_service.h"

#include "transport.h"

namespace genphys {

grpc::ServerUnaryReactor* WorldService::CreateWorld(grpc::CallbackServerContext* context,
                                                    const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  directory_.Create(ToBytes(*request), Replier(calls_, reactor, response));
  return reactor;
}

grpc::ServerUnaryReactor* WorldService::ListWorlds(grpc::CallbackServerContext* context,
                                                   const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  directory_.List(ToBytes(*request), Replier(calls_, reactor, response));
  return reactor;
}

grpc::ServerUnaryReactor* WorldService::GetWorld(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                                 grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kGetWorld, context, request, response);
}

grpc::ServerUnaryReactor* WorldService::DeleteWorld(grpc::CallbackServerContext* context,
                                                    const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kDeleteWorld, context, request, response);
}

grpc::ServerUnaryReactor* WorldService::ResetWorld(grpc::CallbackServerContext* context,
                                                   const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kResetWorld, context, request, response);
}

grpc::ServerUnaryReactor* WorldService::PlayWorld(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                                  grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kPlayWorld, context, request, response);
}

grpc::ServerUnaryReactor* WorldService::PauseWorld(grpc::CallbackServerContext* context,
                                                   const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return CallWorld(directory_, calls_, WorldMethod::kPauseWorld, context, request, response);
}

}  // namespace genphys

#include "world_service.h"

#include "transport.h"

namespace genphys {

grpc::ServerUnaryReactor* WorldService::CreateWorld(grpc::CallbackServerContext*, const grpc::ByteBuffer* request,
                                                    grpc::ByteBuffer* response) {
  auto* const call = new UnaryCall(response);
  directory_.Create(ToBytes(*request), call->Replier());
  return call;
}

grpc::ServerUnaryReactor* WorldService::ListWorlds(grpc::CallbackServerContext*, const grpc::ByteBuffer* request,
                                                   grpc::ByteBuffer* response) {
  auto* const call = new UnaryCall(response);
  directory_.List(ToBytes(*request), call->Replier());
  return call;
}

grpc::ServerUnaryReactor* WorldService::GetWorld(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                                 grpc::ByteBuffer* response) {
  return UnaryCall::ToWorld(directory_, WorldMethod::kGetWorld, context, request, response);
}

grpc::ServerUnaryReactor* WorldService::DeleteWorld(grpc::CallbackServerContext* context,
                                                    const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return UnaryCall::ToWorld(directory_, WorldMethod::kDeleteWorld, context, request, response);
}

grpc::ServerUnaryReactor* WorldService::ResetWorld(grpc::CallbackServerContext* context,
                                                   const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return UnaryCall::ToWorld(directory_, WorldMethod::kResetWorld, context, request, response);
}

grpc::ServerUnaryReactor* WorldService::PlayWorld(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                                  grpc::ByteBuffer* response) {
  return UnaryCall::ToWorld(directory_, WorldMethod::kPlayWorld, context, request, response);
}

grpc::ServerUnaryReactor* WorldService::PauseWorld(grpc::CallbackServerContext* context,
                                                   const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return UnaryCall::ToWorld(directory_, WorldMethod::kPauseWorld, context, request, response);
}

}  // namespace genphys

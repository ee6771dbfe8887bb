#include "integration/raw_call.h"

#include <grpcpp/generic/generic_stub.h>

#include <cmath>
#include <cstring>

#include "genphys/v1/engine_service.pb.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/v1/world_service.pb.h"
#include "genphys/wire/error.h"
#include "google/rpc/error_details.pb.h"
#include "support/test_server.h"

namespace genphys::testing {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptor;
using google::protobuf::Message;
using google::protobuf::MethodDescriptor;

std::string Text(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string text;
  if (!buffer.Dump(&slices).ok()) return text;
  for (const grpc::Slice& slice : slices) text.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  return text;
}

// What is told of a refusal in its details, which every client reads in its own way.
struct Details {
  int infos = 0;
  std::string reason, field, blamed;
};

Details DetailsOf(const google::rpc::Status& status) {
  Details details;
  for (const google::protobuf::Any& detail : status.details()) {
    google::rpc::ErrorInfo info;
    google::rpc::BadRequest request;
    if (detail.UnpackTo(&info) && info.domain() == kErrorDomain) {
      ++details.infos;
      details.reason = info.reason();
      if (info.metadata().contains("field")) details.field = info.metadata().at("field");
    } else if (detail.UnpackTo(&request) && request.field_violations_size() == 1) {
      details.blamed = request.field_violations(0).field();
    }
  }
  return details;
}

// What the call of the first request alone would have ended with, its fields named from the top of the stream's
// message.
grpc::Status StatusOf(const v1::Refusal& refusal, const std::string& holder) {
  const Reason reason = DecodeReason(refusal.reason());
  const std::string field =
      refusal.field().empty() || refusal.field() == holder ? refusal.field() : holder + "." + refusal.field();
  return {static_cast<grpc::StatusCode>(refusal.code()), refusal.message(),
          EncodeStatus(Refuse(reason, field, refusal.message())).SerializeAsString()};
}

// How the first message of a stream says that it went.
grpc::Status StatusIn(const MethodDescriptor& method, const std::string& reply) {
  v1::StepWorldsResponse worlds;
  v1::DriveResponse driven;
  if (method.name() == "StepWorlds" && worlds.ParseFromString(reply) && worlds.results(0).has_refusal()) {
    return StatusOf(worlds.results(0).refusal(), "requests[0]");
  }
  if (method.name() == "Drive" && driven.ParseFromString(reply) && driven.has_refusal()) {
    return StatusOf(driven.refusal(), "step");
  }
  return grpc::Status::OK;
}

bool AllFinite(const std::string& column) {
  for (size_t i = 0; i + sizeof(double) <= column.size(); i += sizeof(double)) {
    double value;
    std::memcpy(&value, column.data() + i, sizeof value);
    if (!std::isfinite(value)) return false;
  }
  return true;
}

// Columns that are no numbers, and ids of which any bits are good.
bool IsColumnOfNumbers(const FieldDescriptor& field) {
  return field.type() == FieldDescriptor::TYPE_BYTES && field.name() != "entity_ids" && field.name() != "asleep" &&
         field.name() != "data";
}

std::string FirstNotFiniteElement(const Message& message, const FieldDescriptor* field, int index) {
  const auto& reflection = *message.GetReflection();
  const bool list = field->is_repeated();
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE: {
      const double value =
          list ? reflection.GetRepeatedDouble(message, field, index) : reflection.GetDouble(message, field);
      return std::isfinite(value) ? "" : field->name();
    }
    case FieldDescriptor::CPPTYPE_MESSAGE: {
      const Message& held =
          list ? reflection.GetRepeatedMessage(message, field, index) : reflection.GetMessage(message, field);
      const std::string inner = FirstNotFinite(held);
      return inner.empty() ? "" : field->name() + "." + inner;
    }
    case FieldDescriptor::CPPTYPE_STRING:
      return !IsColumnOfNumbers(*field) || AllFinite(reflection.GetString(message, field)) ? "" : field->name();
    default:
      return "";
  }
}

}  // namespace

std::vector<const MethodDescriptor*> Methods() {
  std::vector<const MethodDescriptor*> methods;
  for (const FileDescriptor* file :
       {v1::Engine::descriptor()->file(), v1::World::descriptor()->file(), v1::StepRequest::descriptor()->file()}) {
    for (int s = 0; s < file->service_count(); ++s) {
      for (int m = 0; m < file->service(s)->method_count(); ++m) methods.push_back(file->service(s)->method(m));
    }
  }
  return methods;
}

Answer CallAny(const std::shared_ptr<grpc::Channel>& channel, const MethodDescriptor& method,
               const std::string& request) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  grpc::CompletionQueue queue;
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  const auto call = stub.PrepareCall(&context, "/" + method.service()->full_name() + "/" + method.name(), &queue);
  call->StartCall(nullptr);
  wait();
  const grpc::Slice slice(request);
  call->WriteLast(grpc::ByteBuffer(&slice, 1), grpc::WriteOptions(), nullptr);
  wait();
  grpc::ByteBuffer reply;
  call->Read(&reply, nullptr);
  const bool replied = wait();
  if (replied && method.server_streaming()) context.TryCancel();
  Answer answer;
  call->Finish(&answer.status, nullptr);
  wait();
  if (replied) answer.reply = Text(reply);
  if (replied && method.server_streaming()) answer.status = StatusIn(method, answer.reply);
  return answer;
}

std::string VerdictOf(const grpc::Status& status) {
  if (status.ok()) return "accepted";
  const std::string said = "code " + std::to_string(status.error_code()) + " \"" + status.error_message() + "\"";
  google::rpc::Status rich;
  if (status.error_details().empty() || !rich.ParseFromString(status.error_details())) return said + " without details";
  const Details details = DetailsOf(rich);
  v1::ErrorReason reason = v1::ERROR_REASON_UNSPECIFIED;
  v1::ErrorReason_Parse("ERROR_REASON_" + details.reason, &reason);
  const bool right_code =
      rich.code() == status.error_code() && rich.code() == static_cast<int>(CodeOf(DecodeReason(reason)));
  if (details.infos != 1 || !right_code) return said + " with " + rich.ShortDebugString();
  if (details.blamed != details.field) return said + " blames " + details.blamed + " and " + details.field;
  return details.reason + " " + details.field;
}

std::string VerdictOf(const std::optional<Refusal>& refusal) {
  return refusal ? std::string(NameOf(refusal->reason)) + " " + refusal->field : "accepted";
}

std::string FirstNotFinite(const Message& message) {
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const int count = field->is_repeated() ? message.GetReflection()->FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const std::string path = FirstNotFiniteElement(message, field, i);
      if (!path.empty()) return path;
    }
  }
  return "";
}

}  // namespace genphys::testing

#include "support/requests.h"

#include "genphys/v1/engine_service.pb.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/v1/world_service.pb.h"
#include "support/limit_cases.h"
#include "support/limit_fields.h"

namespace genphys {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptor;
using google::protobuf::Message;
using google::protobuf::MessageFactory;

std::vector<const Descriptor*> RequestTypes() {
  std::vector<const Descriptor*> types;
  for (const FileDescriptor* file :
       {v1::Engine::descriptor()->file(), v1::World::descriptor()->file(), v1::StepRequest::descriptor()->file()}) {
    for (int s = 0; s < file->service_count(); ++s) {
      for (int m = 0; m < file->service(s)->method_count(); ++m) {
        types.push_back(file->service(s)->method(m)->input_type());
      }
    }
  }
  return types;
}

std::unique_ptr<Message> MinimalRequest(const Descriptor* type) {
  std::unique_ptr<Message> request(MessageFactory::generated_factory()->GetPrototype(type)->New());
  FillRequired(*request);
  return request;
}

bool ReachableField::is_number() const {
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_BOOL:
    case FieldDescriptor::CPPTYPE_ENUM:
    case FieldDescriptor::CPPTYPE_STRING:
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return false;
    default:
      return true;
  }
}

namespace {

void Collect(const Descriptor* type, const FieldDescriptor* holder, const std::string& prefix,
             std::vector<ReachableField>& fields) {
  const v1::Limit* inherited = InheritedLimit(type, holder);
  for (int i = 0; i < type->field_count(); ++i) {
    const FieldDescriptor* field = type->field(i);
    const std::string path = prefix + ElementName(field);
    fields.push_back({field, path, inherited != nullptr ? inherited : &LimitOf(field)});
    if (field->message_type() != nullptr) Collect(field->message_type(), field, path + ".", fields);
  }
}

}  // namespace

std::vector<ReachableField> ReachableFields(const Descriptor* type) {
  std::vector<ReachableField> fields;
  Collect(type, nullptr, "", fields);
  return fields;
}

}  // namespace genphys

#include "support/filled_message.h"

#include <google/protobuf/descriptor.h>

#include "genphys/v1/limits.pb.h"

namespace genphys {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr int kRows = 2;

class Filler {
 public:
  explicit Filler(const Alternatives& wanted) : wanted_(wanted) {}

  void Fill(Message* message) {
    const google::protobuf::Descriptor* type = message->GetDescriptor();
    for (int i = 0; i < type->field_count(); ++i) {
      const FieldDescriptor* field = type->field(i);
      if (!Chosen(field)) continue;
      const int count = field->is_repeated() ? ElementsOf(field) : 1;
      for (int element = 0; element < count; ++element) Set(message, field);
    }
  }

 private:
  bool Chosen(const FieldDescriptor* field) const {
    const google::protobuf::OneofDescriptor* oneof = field->real_containing_oneof();
    if (oneof == nullptr) return true;
    const auto wanted = wanted_.find(oneof->full_name());
    return wanted == wanted_.end() ? field->index_in_oneof() == 0 : field->name() == wanted->second;
  }

  static int ElementsOf(const FieldDescriptor* field) {
    const uint64_t multiple = field->options().GetExtension(v1::limit).items_multiple();
    return multiple == 0 ? kRows : static_cast<int>(multiple);
  }

  int Next() { return ++last_; }

  std::string NextText(const FieldDescriptor* field) {
    if (!field->options().GetExtension(v1::limit).has_column()) return "text" + std::to_string(Next());
    const v1::Column& column = field->options().GetExtension(v1::limit).column();
    std::string bytes;
    for (uint32_t i = 0; i < kRows * column.width(); ++i) {
      const double scalar = Next();
      bytes.append(reinterpret_cast<const char*>(&scalar), sizeof scalar);
    }
    return bytes;
  }

  const google::protobuf::EnumValueDescriptor* NextEnum(const FieldDescriptor* field) {
    // Never the first, which is what an unset field has.
    return field->enum_type()->value(1 + Next() % (field->enum_type()->value_count() - 1));
  }

  void Set(Message* message, const FieldDescriptor* field) {
    const google::protobuf::Reflection& r = *message->GetReflection();
    const bool list = field->is_repeated();
    switch (field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_DOUBLE:
        return list ? r.AddDouble(message, field, Next()) : r.SetDouble(message, field, Next());
      case FieldDescriptor::CPPTYPE_FLOAT:
        return list ? r.AddFloat(message, field, 1.0f) : r.SetFloat(message, field, 1.0f);
      case FieldDescriptor::CPPTYPE_INT32:
        return list ? r.AddInt32(message, field, Next()) : r.SetInt32(message, field, Next());
      case FieldDescriptor::CPPTYPE_UINT32:
        return list ? r.AddUInt32(message, field, NextUnsigned()) : r.SetUInt32(message, field, NextUnsigned());
      case FieldDescriptor::CPPTYPE_INT64:
        return list ? r.AddInt64(message, field, Next()) : r.SetInt64(message, field, Next());
      case FieldDescriptor::CPPTYPE_UINT64:
        return list ? r.AddUInt64(message, field, NextLong()) : r.SetUInt64(message, field, NextLong());
      case FieldDescriptor::CPPTYPE_BOOL:
        return list ? r.AddBool(message, field, true) : r.SetBool(message, field, true);
      case FieldDescriptor::CPPTYPE_ENUM:
        return list ? r.AddEnum(message, field, NextEnum(field)) : r.SetEnum(message, field, NextEnum(field));
      case FieldDescriptor::CPPTYPE_STRING:
        return list ? r.AddString(message, field, NextText(field)) : r.SetString(message, field, NextText(field));
      case FieldDescriptor::CPPTYPE_MESSAGE:
        return Fill(list ? r.AddMessage(message, field) : r.MutableMessage(message, field));
    }
  }

  uint32_t NextUnsigned() { return static_cast<uint32_t>(Next()); }
  /// Uses both halves, as ids do.
  uint64_t NextLong() { return (uint64_t{NextUnsigned()} << 32) + NextUnsigned(); }

  const Alternatives& wanted_;
  int last_ = 0;
};

}  // namespace

void FillEveryField(Message* message, const Alternatives& wanted) { Filler(wanted).Fill(message); }

}  // namespace genphys

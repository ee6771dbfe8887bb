#include "support/limit_fields.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace genphys {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::OneofDescriptor;
using google::protobuf::Reflection;

const v1::Limit& LimitOf(const FieldDescriptor* field) { return field->options().GetExtension(v1::limit); }

const v1::Limit* InheritedLimit(const Descriptor* type, const FieldDescriptor* holder) {
  if (holder == nullptr) return nullptr;
  for (int i = 0; i < type->field_count(); ++i) {
    const FieldDescriptor* field = type->field(i);
    if (field->options().HasExtension(v1::limit) || field->message_type() != nullptr) return nullptr;
  }
  return &LimitOf(holder);
}

std::pair<double, double> RangeOfType(const FieldDescriptor* field) {
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return {std::numeric_limits<int32_t>::min(), std::numeric_limits<int32_t>::max()};
    case FieldDescriptor::CPPTYPE_UINT32:
      return {0, std::numeric_limits<uint32_t>::max()};
    case FieldDescriptor::CPPTYPE_INT64:
      return {-0x1p63, 0x1p63};
    case FieldDescriptor::CPPTYPE_UINT64:
      return {0, 0x1p64};
    default:
      throw std::invalid_argument(field->full_name() + " is no integer");
  }
}

std::string ElementName(const FieldDescriptor* field) { return field->name() + (field->is_repeated() ? "[0]" : ""); }

void SetNumber(Message& message, const FieldDescriptor* f, double value) {
  const Reflection& r = *message.GetReflection();
  const bool list = f->is_repeated();
  switch (f->cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return list ? r.SetRepeatedDouble(&message, f, 0, value) : r.SetDouble(&message, f, value);
    case FieldDescriptor::CPPTYPE_FLOAT: {
      const auto v = static_cast<float>(value);
      return list ? r.SetRepeatedFloat(&message, f, 0, v) : r.SetFloat(&message, f, v);
    }
    case FieldDescriptor::CPPTYPE_INT32: {
      const auto v = static_cast<int32_t>(value);
      return list ? r.SetRepeatedInt32(&message, f, 0, v) : r.SetInt32(&message, f, v);
    }
    case FieldDescriptor::CPPTYPE_UINT32: {
      const auto v = static_cast<uint32_t>(value);
      return list ? r.SetRepeatedUInt32(&message, f, 0, v) : r.SetUInt32(&message, f, v);
    }
    case FieldDescriptor::CPPTYPE_UINT64: {
      const uint64_t v = value < 0x1p64 ? static_cast<uint64_t>(value) : std::numeric_limits<uint64_t>::max();
      return list ? r.SetRepeatedUInt64(&message, f, 0, v) : r.SetUInt64(&message, f, v);
    }
    case FieldDescriptor::CPPTYPE_INT64: {
      const int64_t v = value < 0x1p63 ? static_cast<int64_t>(value) : std::numeric_limits<int64_t>::max();
      return list ? r.SetRepeatedInt64(&message, f, 0, v) : r.SetInt64(&message, f, v);
    }
    case FieldDescriptor::CPPTYPE_ENUM: {
      const auto v = static_cast<int>(value);
      return list ? r.SetRepeatedEnumValue(&message, f, 0, v) : r.SetEnumValue(&message, f, v);
    }
    default:
      throw std::invalid_argument(f->full_name() + " is no number");
  }
}

void SetText(Message& message, const FieldDescriptor* field, const std::string& text) {
  const Reflection& reflection = *message.GetReflection();
  if (field->is_repeated()) {
    reflection.SetRepeatedString(&message, field, 0, text);
  } else {
    reflection.SetString(&message, field, text);
  }
}

std::string ExampleText(const v1::Limit& limit) {
  for (const std::string text : {"worlds/a", "engines/ode"}) {
    if (limit.pattern().starts_with(text.substr(0, text.find('/') + 1))) return text;
  }
  return "a";
}

namespace {

double ValidNumber(const v1::Limit& limit) {
  return std::clamp(1.0, limit.has_min() ? limit.min() : 1.0, limit.has_max() ? limit.max() : 1.0);
}

void FillField(Message& message, const FieldDescriptor* field) {
  if (field->is_repeated()) {
    return FillElements(message, field, std::max<uint64_t>(1, LimitOf(field).items_multiple()));
  }
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return FillHeld(*message.GetReflection()->MutableMessage(&message, field), field);
    case FieldDescriptor::CPPTYPE_STRING:
      return SetText(message, field, ExampleText(LimitOf(field)));
    default:
      return SetNumber(message, field, ValidNumber(LimitOf(field)));
  }
}

// A repeated message's copies are made of one that is filled only once.
void AddElement(Message& message, const FieldDescriptor* field, const std::function<void(Message&)>& complete) {
  const Reflection& reflection = *message.GetReflection();
  const int size = reflection.FieldSize(message, field);
  Message* added = reflection.AddMessage(&message, field);
  if (size > 0) {
    added->CopyFrom(reflection.GetRepeatedMessage(message, field, size - 1));
    return;
  }
  FillHeld(*added, field);
  if (complete) complete(*added);
}

}  // namespace

void FillMessage(Message& message, const v1::Limit* inherited) {
  const Descriptor* type = message.GetDescriptor();
  for (int i = 0; i < type->field_count(); ++i) {
    const FieldDescriptor* field = type->field(i);
    const OneofDescriptor* oneof = field->real_containing_oneof();
    if (oneof != nullptr) {
      if (field->index_in_oneof() == 0) FillField(message, field);
    } else if (inherited == nullptr) {
      if (LimitOf(field).required()) FillField(message, field);
    } else if (inherited->unit_length()) {
      SetNumber(message, field, i == 0 ? 1 : 0);
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
      SetNumber(message, field, ValidNumber(*inherited));
    }
  }
}

void FillHeld(Message& message, const FieldDescriptor* holder) {
  FillMessage(message, InheritedLimit(message.GetDescriptor(), holder));
}

void FillElements(Message& message, const FieldDescriptor* f, uint64_t count,
                  const std::function<void(Message&)>& complete) {
  if (!f->is_repeated()) return;
  const Reflection& r = *message.GetReflection();
  const double number = ValidNumber(LimitOf(f));
  while (static_cast<uint64_t>(r.FieldSize(message, f)) > count) r.RemoveLast(&message, f);
  while (static_cast<uint64_t>(r.FieldSize(message, f)) < count) {
    switch (f->cpp_type()) {
      case FieldDescriptor::CPPTYPE_MESSAGE:
        AddElement(message, f, complete);
        break;
      case FieldDescriptor::CPPTYPE_STRING:
        r.AddString(&message, f, ExampleText(LimitOf(f)));
        break;
      case FieldDescriptor::CPPTYPE_ENUM:
        r.AddEnumValue(&message, f, 1);
        break;
      case FieldDescriptor::CPPTYPE_DOUBLE:
        r.AddDouble(&message, f, number);
        break;
      case FieldDescriptor::CPPTYPE_UINT32:
        r.AddUInt32(&message, f, static_cast<uint32_t>(number));
        break;
      case FieldDescriptor::CPPTYPE_UINT64:
        r.AddUInt64(&message, f, static_cast<uint64_t>(number));
        break;
      default:
        throw std::invalid_argument("no list of this type was needed before: " + f->full_name());
    }
  }
}

size_t BytesOfElement(const FieldDescriptor* field) {
  // An element of a list of messages is a few fields long when only what it must have is set.
  constexpr size_t kSmallMessage = 64;
  return field->message_type() != nullptr ? kSmallMessage : sizeof(double);
}

size_t BytesPerScalar(const v1::Column& column) {
  return column.scalar() == v1::SCALAR_FLOAT32 ? sizeof(float) : sizeof(double);
}

size_t BytesPerRow(const v1::Column& column) { return column.width() * BytesPerScalar(column); }

void FillColumns(Message& message, size_t rows) {
  const Reflection& reflection = *message.GetReflection();
  const Descriptor* type = message.GetDescriptor();
  for (int i = 0; i < type->field_count(); ++i) {
    const FieldDescriptor* field = type->field(i);
    const v1::Column& column = LimitOf(field).column();
    if (!LimitOf(field).has_column()) continue;
    const FieldDescriptor* decider = column.rows_as().empty() ? field : type->FindFieldByName(column.rows_as());
    const size_t decided = reflection.GetString(message, decider).size() / BytesPerRow(LimitOf(decider).column());
    std::string bytes = reflection.GetString(message, field);
    bytes.resize((decided != 0 ? decided : rows) * BytesPerRow(column));
    reflection.SetString(&message, field, bytes);
  }
}

void ClearColumns(Message& message) {
  const Descriptor* type = message.GetDescriptor();
  for (int i = 0; i < type->field_count(); ++i) {
    if (LimitOf(type->field(i)).has_column()) message.GetReflection()->ClearField(&message, type->field(i));
  }
}

void SetScalar(std::string& bytes, const v1::Column& column, size_t index, double value) {
  char* place = bytes.data() + index * BytesPerScalar(column);
  if (column.scalar() == v1::SCALAR_FLOAT32) {
    const auto narrow = static_cast<float>(value);
    std::memcpy(place, &narrow, sizeof(narrow));
  } else {
    std::memcpy(place, &value, sizeof(value));
  }
}

double NextScalar(const v1::Column& column, double value, double towards) {
  if (column.scalar() != v1::SCALAR_FLOAT32) return std::nextafter(value, towards);
  return std::nextafter(static_cast<float>(value), static_cast<float>(towards));
}

}  // namespace genphys

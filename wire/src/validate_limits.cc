#include "genphys/wire/validate_limits.h"

#include <google/protobuf/message.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <string>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "genphys/limits.h"
#include "limits_plan.h"

namespace genphys {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

static_assert(std::endian::native == std::endian::little, "columns are read where they lie");

// One step of the way to a field. The way is a list on the stack: it costs nothing until something is refused.
struct Place {
  const Place* holder = nullptr;
  const FieldDescriptor* field = nullptr;
  int64_t index = -1;
  std::string_view component;  // of that element
};

// A message under examination. Its reflection is looked up once, for asking costs as much as reading a field.
struct Holder {
  const Message& message;
  const Reflection& reflection;
  const Place* place;
};

std::string PathOf(const Place& place) {
  std::string path;
  for (const Place* p = &place; p != nullptr && p->field != nullptr; p = p->holder) {
    std::string step = p->field->name();
    if (p->index >= 0) absl::StrAppend(&step, "[", p->index, "]");
    if (!p->component.empty()) step.append(".").append(p->component);
    path = path.empty() ? step : absl::StrCat(step, ".", path);
  }
  return path;
}

Status RefuseAt(const Place& place, Reason reason, std::string_view message) {
  return Refuse(reason, PathOf(place), message);
}

std::string RangeText(const v1::Limit& limit) {
  std::string text = "must be ";
  if (limit.has_min()) absl::StrAppend(&text, limit.exclusive_min() ? "more than " : "at least ", limit.min());
  if (limit.has_min() && limit.has_max()) absl::StrAppend(&text, " and ");
  if (limit.has_max()) absl::StrAppend(&text, "at most ", limit.max());
  return text;
}

// With as many digits as it takes to see that `value` is not within the range.
std::string OutsideText(const FieldRules& rules, double value) {
  constexpr int kDigitsShown = 6, kDigitsOfADouble = 17;
  char text[32];
  for (int digits = kDigitsShown; digits <= kDigitsOfADouble; ++digits) {
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    const double shown = std::strtod(text, nullptr);
    if (!(shown >= rules.min && shown <= rules.max)) break;
  }
  return text;
}

Status CheckNumber(const FieldRules& rules, const Place& place, double value) {
  if (value >= rules.min && value <= rules.max) return {};
  if (!std::isfinite(value)) return RefuseAt(place, Reason::kNotFinite, "must be finite");
  return RefuseAt(place, Reason::kOutOfRange,
                  absl::StrCat(RangeText(*rules.limit), ", is ", OutsideText(rules, value)));
}

Status CheckEnum(const FieldRules& rules, const Place& place, int value) {
  const bool known = rules.field->enum_type()->FindValueByNumber(value) != nullptr;
  // An element of a list was meant to say something; only a field may say that it leaves the choice open.
  const bool says_something = value != 0 || !rules.repeated;
  if (known && says_something && value >= rules.min && value <= rules.max) return {};
  std::string meant;
  for (int i = 0; i < rules.field->enum_type()->value_count(); ++i) {
    const auto& each = *rules.field->enum_type()->value(i);
    if (each.number() == 0 || each.number() < rules.min || each.number() > rules.max) continue;
    absl::StrAppend(&meant, meant.empty() ? "" : ", ", each.name(), " = ", each.number());
  }
  return RefuseAt(place, Reason::kInvalidValue, absl::StrCat("must be one of ", meant, "; is ", value));
}

template <typename Scalar>
int64_t FirstOutside(std::string_view bytes, double min, double max) {
  const size_t count = bytes.size() / sizeof(Scalar);
  const auto load = [&](size_t i) {
    Scalar scalar;
    std::memcpy(&scalar, bytes.data() + i * sizeof(Scalar), sizeof(Scalar));
    return static_cast<double>(scalar);
  };
  // Without a branch per scalar; NaN compares false and so falls outside.
  size_t inside = 0;
  for (size_t i = 0; i < count; ++i) {
    const double value = load(i);
    inside += static_cast<size_t>(value >= min) & static_cast<size_t>(value <= max);
  }
  if (inside == count) return -1;
  for (size_t i = 0;; ++i) {
    if (const double value = load(i); !(value >= min && value <= max)) return static_cast<int64_t>(i);
  }
}

// How the scalars of a row are called, as in the messages that have one field for each.
std::string_view ComponentName(const v1::Column& column, size_t component) {
  constexpr std::string_view kQuaternion[] = {"w", "x", "y", "z"}, kVector[] = {"x", "y", "z"};
  if (column.width() == std::size(kVector)) return kVector[component];
  return column.width() == std::size(kQuaternion) ? kQuaternion[component] : std::string_view();
}

template <typename Scalar>
Status CheckScalars(const FieldRules& rules, const Place& place, std::string_view bytes) {
  const int64_t outside = FirstOutside<Scalar>(bytes, rules.min, rules.max);
  if (outside < 0) return {};
  Scalar scalar;
  std::memcpy(&scalar, bytes.data() + static_cast<size_t>(outside) * sizeof(Scalar), sizeof(Scalar));
  const v1::Column& column = rules.limit->column();
  const int64_t width = column.width();
  const std::string_view component = ComponentName(column, static_cast<size_t>(outside % width));
  return CheckNumber(rules, Place{place.holder, place.field, outside / width, component}, static_cast<double>(scalar));
}

size_t BytesPerRow(const v1::Column& column) {
  return column.width() * (column.scalar() == v1::SCALAR_FLOAT32 ? sizeof(float) : sizeof(double));
}

Status CheckRows(const Holder& holder, const FieldRules& rules, const Place& place, size_t rows) {
  if (rules.rows_as == nullptr || (rows == 0 && rules.limit->column().may_be_empty())) return {};
  std::string scratch;
  const std::string& other = holder.reflection.GetStringReference(holder.message, rules.rows_as, &scratch);
  const size_t wanted = other.size() / BytesPerRow(rules.rows_as->options().GetExtension(v1::limit).column());
  if (rows == wanted) return {};
  return RefuseAt(
      place, Reason::kInvalidValue,
      absl::StrCat("must have as many rows as ", rules.rows_as->name(), ", which has ", wanted, "; has ", rows));
}

Status CheckColumn(const Holder& holder, const FieldRules& rules, const Place& place, std::string_view bytes) {
  const v1::Column& column = rules.limit->column();
  const size_t row = BytesPerRow(column);
  if (bytes.size() % row != 0) {
    return RefuseAt(place, Reason::kInvalidValue,
                    absl::StrCat("must be a multiple of ", row, " bytes long, is ", bytes.size()));
  }
  const size_t rows = bytes.size() / row;
  if (rules.limit->max_items() != 0 && rows > rules.limit->max_items()) {
    return RefuseAt(place, Reason::kOutOfRange,
                    absl::StrCat("must have at most ", rules.limit->max_items(), " rows, has ", rows));
  }
  GENPHYS_RETURN_IF_ERROR(CheckRows(holder, rules, place, rows));
  switch (column.scalar()) {
    case v1::SCALAR_FLOAT64:
      return CheckScalars<double>(rules, place, bytes);
    case v1::SCALAR_FLOAT32:
      return CheckScalars<float>(rules, place, bytes);
    default:
      return {};
  }
}

// The beginning of a text that is refused, without half a character at its end.
std::string Shown(std::string_view text) {
  constexpr size_t kBytesMax = 200;
  if (text.size() <= kBytesMax) return std::string(text);
  size_t bytes = kBytesMax;
  while (bytes > 0 && (static_cast<unsigned char>(text[bytes]) & 0xc0) == 0x80) --bytes;
  return std::string(text.substr(0, bytes));
}

Status CheckText(const FieldRules& rules, const Place& place, std::string_view text) {
  const v1::Limit& limit = *rules.limit;
  if (limit.max_length() != 0 && text.size() > limit.max_length()) {
    return RefuseAt(place, Reason::kOutOfRange,
                    absl::StrCat("must be at most ", limit.max_length(), " bytes long, is ", text.size()));
  }
  if (!rules.pattern || text.empty() || RE2::FullMatch({text.data(), text.size()}, *rules.pattern)) return {};
  return RefuseAt(place, Reason::kInvalidValue,
                  absl::StrCat("must have the form ", limit.pattern(), ", is \"", Shown(text), "\""));
}

Status CheckMessage(const Message& message, const MessageRules& rules, const Place* place);

Status CheckUnitLength(const Message& vector, const Place& place) {
  const Reflection& reflection = *vector.GetReflection();
  double squares = 0;
  for (int i = 0; i < vector.GetDescriptor()->field_count(); ++i) {
    const double component = reflection.GetDouble(vector, vector.GetDescriptor()->field(i));
    squares += component * component;
  }
  const double length = std::sqrt(squares);
  if (std::abs(length - 1) <= Limits::kUnitLengthTolerance) return {};
  return RefuseAt(place, Reason::kNotUnitLength, absl::StrCat("must have length 1, has ", length));
}

Status CheckHeldMessage(const FieldRules& rules, const Place& place, const Message& held) {
  GENPHYS_RETURN_IF_ERROR(CheckMessage(held, *rules.message, &place));
  return rules.limit->unit_length() ? CheckUnitLength(held, place) : Status();
}

Status CheckString(const Holder& holder, const FieldRules& rules, const Place& place, const std::string& value) {
  return rules.limit->has_column() ? CheckColumn(holder, rules, place, value) : CheckText(rules, place, value);
}

Status CheckElement(const Holder& holder, const FieldRules& rules, const Place& place) {
  const Reflection& r = holder.reflection;
  const Message& message = holder.message;
  const FieldDescriptor* f = rules.field;
  const int i = static_cast<int>(place.index);
  switch (rules.type) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return CheckNumber(rules, place, r.GetRepeatedDouble(message, f, i));
    case FieldDescriptor::CPPTYPE_FLOAT:
      return CheckNumber(rules, place, r.GetRepeatedFloat(message, f, i));
    case FieldDescriptor::CPPTYPE_INT32:
      return CheckNumber(rules, place, r.GetRepeatedInt32(message, f, i));
    case FieldDescriptor::CPPTYPE_UINT32:
      return CheckNumber(rules, place, r.GetRepeatedUInt32(message, f, i));
    case FieldDescriptor::CPPTYPE_INT64:
      return CheckNumber(rules, place, static_cast<double>(r.GetRepeatedInt64(message, f, i)));
    case FieldDescriptor::CPPTYPE_UINT64:
      return CheckNumber(rules, place, static_cast<double>(r.GetRepeatedUInt64(message, f, i)));
    case FieldDescriptor::CPPTYPE_ENUM:
      return CheckEnum(rules, place, r.GetRepeatedEnumValue(message, f, i));
    case FieldDescriptor::CPPTYPE_STRING: {
      std::string scratch;
      return CheckString(holder, rules, place, r.GetRepeatedStringReference(message, f, i, &scratch));
    }
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return CheckHeldMessage(rules, place, r.GetRepeatedMessage(message, f, i));
    case FieldDescriptor::CPPTYPE_BOOL:
      return {};
  }
  return {};
}

bool IsInteger(FieldDescriptor::CppType type) {
  switch (type) {
    case FieldDescriptor::CPPTYPE_INT32:
    case FieldDescriptor::CPPTYPE_UINT32:
    case FieldDescriptor::CPPTYPE_INT64:
    case FieldDescriptor::CPPTYPE_UINT64:
      return true;
    default:
      return false;
  }
}

Status CheckRepeated(const Holder& holder, const FieldRules& rules) {
  const v1::Limit& limit = *rules.limit;
  const auto size = static_cast<uint64_t>(holder.reflection.FieldSize(holder.message, rules.field));
  const Place place{holder.place, rules.field};
  if (size == 0) return rules.required ? RefuseAt(place, Reason::kMissingField, "must not be empty") : Status();
  if (limit.max_items() != 0 && size > limit.max_items()) {
    return RefuseAt(place, Reason::kOutOfRange,
                    absl::StrCat("must have at most ", limit.max_items(), " elements, has ", size));
  }
  if (limit.items_multiple() != 0 && size % limit.items_multiple() != 0) {
    return RefuseAt(place, Reason::kInvalidValue,
                    absl::StrCat("must have a multiple of ", limit.items_multiple(), " elements, has ", size));
  }
  if (limit.unrestricted() && IsInteger(rules.type)) return {};
  for (uint64_t i = 0; i < size; ++i) {
    GENPHYS_RETURN_IF_ERROR(CheckElement(holder, rules, Place{holder.place, rules.field, static_cast<int64_t>(i)}));
  }
  return {};
}

Status CheckSingular(const Holder& holder, const FieldRules& rules) {
  const Reflection& r = holder.reflection;
  const Message& message = holder.message;
  const FieldDescriptor* f = rules.field;
  const Place place{holder.place, f};
  // For a field that cannot tell unset from zero, "has" means that it is not zero.
  if (rules.required && !r.HasField(message, f)) return RefuseAt(place, Reason::kMissingField, "must be set");
  if (rules.has_presence && !r.HasField(message, f)) return {};
  switch (rules.type) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return CheckNumber(rules, place, r.GetDouble(message, f));
    case FieldDescriptor::CPPTYPE_FLOAT:
      return CheckNumber(rules, place, r.GetFloat(message, f));
    case FieldDescriptor::CPPTYPE_INT32:
      return CheckNumber(rules, place, r.GetInt32(message, f));
    case FieldDescriptor::CPPTYPE_UINT32:
      return CheckNumber(rules, place, r.GetUInt32(message, f));
    case FieldDescriptor::CPPTYPE_INT64:
      return CheckNumber(rules, place, static_cast<double>(r.GetInt64(message, f)));
    case FieldDescriptor::CPPTYPE_UINT64:
      return CheckNumber(rules, place, static_cast<double>(r.GetUInt64(message, f)));
    case FieldDescriptor::CPPTYPE_ENUM:
      return CheckEnum(rules, place, r.GetEnumValue(message, f));
    case FieldDescriptor::CPPTYPE_STRING: {
      std::string scratch;
      return CheckString(holder, rules, place, r.GetStringReference(message, f, &scratch));
    }
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return CheckHeldMessage(rules, place, r.GetMessage(message, f));
    case FieldDescriptor::CPPTYPE_BOOL:
      return {};
  }
  return {};
}

Status CheckOneof(const Holder& holder, const RuleGroup& group) {
  const FieldDescriptor* set = holder.reflection.GetOneofFieldDescriptor(holder.message, group.oneof);
  if (set != nullptr) return CheckSingular(holder, group.fields[static_cast<size_t>(set->index_in_oneof())]);
  const std::string path = holder.place == nullptr ? "" : absl::StrCat(PathOf(*holder.place), ".");
  std::string names;
  for (const FieldRules& each : group.fields) absl::StrAppend(&names, names.empty() ? "" : ", ", each.field->name());
  return Refuse(Reason::kMissingField, path + group.oneof->name(), "must be one of " + names);
}

Status CheckMessage(const Message& message, const MessageRules& rules, const Place* place) {
  const Holder holder{message, *message.GetReflection(), place};
  for (const RuleGroup& group : rules.groups) {
    if (group.oneof != nullptr) {
      GENPHYS_RETURN_IF_ERROR(CheckOneof(holder, group));
    } else if (group.fields.front().repeated) {
      GENPHYS_RETURN_IF_ERROR(CheckRepeated(holder, group.fields.front()));
    } else {
      GENPHYS_RETURN_IF_ERROR(CheckSingular(holder, group.fields.front()));
    }
  }
  return {};
}

}  // namespace

Status ValidateLimits(const Message& message) {
  const MessageRules* rules = RulesOf(message.GetDescriptor());
  if (rules == nullptr) return Refuse(Reason::kInvalidValue, "", message.GetTypeName() + " is no part of the contract");
  return CheckMessage(message, *rules, nullptr);
}

}  // namespace genphys

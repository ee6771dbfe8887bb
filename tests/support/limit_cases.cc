#include "support/limit_cases.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "support/limit_fields.h"

namespace genphys {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::OneofDescriptor;
using Way = std::vector<const FieldDescriptor*>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
// Lengths on either side of the documented tolerance of 1e-3, far enough from it for rounding not to matter.
constexpr double kAlmostUnit = 1.0009;
constexpr double kNotUnit = 1.0011;
constexpr size_t kColumnRows = 2;

struct Target {
  std::unique_ptr<Message> request;
  Message* holder;
  std::string prefix;
};

class Generator {
 public:
  Generator(const Message& sample, const LimitCaseOptions& options, const std::function<void(const LimitCase&)>& visit)
      : sample_(sample), options_(options), visit_(visit) {}

  void Walk(const Descriptor* type, const Way& way) {
    const v1::Limit* inherited = InheritedLimit(type, way.empty() ? nullptr : way.back());
    for (int i = 0; i < type->real_oneof_decl_count(); ++i) {
      const OneofDescriptor* oneof = type->oneof_decl(i);
      Emit(way, oneof->name(), "unset", Reason::kMissingField,
           [&](Message& holder) { holder.GetReflection()->ClearOneof(&holder, oneof); });
    }
    for (int i = 0; i < type->field_count(); ++i) {
      const FieldDescriptor* field = type->field(i);
      Probe(way, field, inherited != nullptr ? *inherited : LimitOf(field), inherited != nullptr);
      if (field->message_type() == nullptr) continue;
      Way next = way;
      next.push_back(field);
      Walk(field->message_type(), next);
    }
  }

 private:
  using Mutation = std::function<void(Message& holder)>;

  // The sample with everything added that leads to the field at the end of `way`.
  Target Reach(const Way& way) const {
    Target target{std::unique_ptr<Message>(sample_.New()), nullptr, ""};
    target.request->CopyFrom(sample_);
    target.holder = target.request.get();
    for (const FieldDescriptor* field : way) {
      const auto& reflection = *target.holder->GetReflection();
      const bool is_new = field->is_repeated() ? reflection.FieldSize(*target.holder, field) == 0
                                               : !reflection.HasField(*target.holder, field);
      target.prefix += field->name() + (field->is_repeated() ? "[0]." : ".");
      if (is_new) {
        Message* added = field->is_repeated() ? reflection.AddMessage(target.holder, field)
                                              : reflection.MutableMessage(target.holder, field);
        FillHeld(*added, field);
        if (options_.complete) options_.complete(*added);
        target.holder = added;
      } else {
        target.holder = field->is_repeated() ? reflection.MutableRepeatedMessage(target.holder, field, 0)
                                             : reflection.MutableMessage(target.holder, field);
      }
    }
    return target;
  }

  void Emit(const Way& way, const std::string& name, const std::string& probe, std::optional<Reason> reason,
            const Mutation& mutate) const {
    const Target target = Reach(way);
    mutate(*target.holder);
    const std::string path = target.prefix + name;
    std::optional<Refusal> refusal;
    if (reason) refusal = Refusal{*reason, path};
    visit_({*target.request, path, probe, refusal});
  }

  void Probe(const Way& way, const FieldDescriptor* field, const v1::Limit& limit, bool inherited) const {
    if (limit.required() && !inherited && field->real_containing_oneof() == nullptr) {
      Emit(way, field->name(), "unset", Reason::kMissingField,
           [&](Message& holder) { holder.GetReflection()->ClearField(&holder, field); });
    }
    if (field->is_repeated()) ProbeCount(way, field, limit);
    switch (field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_BOOL:
        return;
      case FieldDescriptor::CPPTYPE_MESSAGE:
        if (limit.unit_length()) ProbeUnitLength(way, field);
        return;
      case FieldDescriptor::CPPTYPE_ENUM:
        return ProbeEnum(way, field, limit);
      case FieldDescriptor::CPPTYPE_STRING:
        return limit.has_column() ? ProbeColumn(way, field, limit) : ProbeText(way, field, limit);
      case FieldDescriptor::CPPTYPE_DOUBLE:
      case FieldDescriptor::CPPTYPE_FLOAT:
        return ProbeReal(way, field, limit);
      default:
        return ProbeInteger(way, field, limit);
    }
  }

  void EmitNumber(const Way& way, const FieldDescriptor* field, const std::string& probe, double value,
                  std::optional<Reason> reason) const {
    Emit(way, ElementName(field), probe, reason, [&](Message& holder) {
      FillElements(holder, field, std::max<uint64_t>(1, LimitOf(field).items_multiple()));
      SetNumber(holder, field, value);
    });
  }

  void ProbeReal(const Way& way, const FieldDescriptor* field, const v1::Limit& limit) const {
    EmitNumber(way, field, "NaN", kNan, Reason::kNotFinite);
    EmitNumber(way, field, "+infinity", kInfinity, Reason::kNotFinite);
    EmitNumber(way, field, "-infinity", -kInfinity, Reason::kNotFinite);
    if (limit.has_min()) {
      const bool exclusive = limit.exclusive_min();
      EmitNumber(way, field, "at min", limit.min(),
                 exclusive ? std::optional<Reason>(Reason::kOutOfRange) : std::nullopt);
      EmitNumber(way, field, "above min", std::nextafter(limit.min(), kInfinity), std::nullopt);
      EmitNumber(way, field, "below min", std::nextafter(limit.min(), -kInfinity), Reason::kOutOfRange);
    }
    if (limit.has_max()) {
      EmitNumber(way, field, "at max", limit.max(), std::nullopt);
      EmitNumber(way, field, "above max", std::nextafter(limit.max(), kInfinity), Reason::kOutOfRange);
    }
  }

  void ProbeInteger(const Way& way, const FieldDescriptor* field, const v1::Limit& limit) const {
    const auto [lowest, highest] = RangeOfType(field);
    if (limit.unrestricted()) EmitNumber(way, field, "largest of its type", highest, std::nullopt);
    if (limit.has_min()) {
      EmitNumber(way, field, "at min", limit.min(), std::nullopt);
      const bool is_unset = limit.min() == 1 && !field->has_presence() && limit.required();
      if (limit.min() > lowest) {
        EmitNumber(way, field, "below min", limit.min() - 1, is_unset ? Reason::kMissingField : Reason::kOutOfRange);
      }
    }
    if (limit.has_max()) {
      EmitNumber(way, field, "at max", limit.max(), std::nullopt);
      if (limit.max() < highest) EmitNumber(way, field, "above max", limit.max() + 1, Reason::kOutOfRange);
    }
  }

  void ProbeEnum(const Way& way, const FieldDescriptor* field, const v1::Limit& limit) const {
    const auto emit = [&](int number, bool accepted) {
      Emit(way, ElementName(field), "number " + std::to_string(number),
           accepted ? std::nullopt : std::optional<Reason>(Reason::kInvalidValue), [&](Message& holder) {
             FillElements(holder, field, 1);
             SetNumber(holder, field, number);
           });
    };
    int highest = 0;
    for (int i = 0; i < field->enum_type()->value_count(); ++i) {
      const int number = field->enum_type()->value(i)->number();
      highest = std::max(highest, number);
      const bool in_range = (!limit.has_min() || number >= limit.min()) && (!limit.has_max() || number <= limit.max());
      emit(number, in_range && !(field->is_repeated() && number == 0));
    }
    emit(highest + 1, false);
    emit(-1, false);
  }

  void ProbeText(const Way& way, const FieldDescriptor* field, const v1::Limit& limit) const {
    const auto emit = [&](const std::string& probe, std::optional<Reason> reason, const std::string& text) {
      Emit(way, ElementName(field), probe, reason, [&](Message& holder) {
        FillElements(holder, field, 1);
        SetText(holder, field, text);
      });
    };
    if (limit.max_length() != 0 && limit.max_length() <= options_.field_bytes_max) {
      std::string longest = ExampleText(limit);
      longest.resize(limit.max_length(), 'a');
      emit("at max length", std::nullopt, longest);
      emit("above max length", Reason::kOutOfRange, longest + "a");
    }
    if (!limit.pattern().empty()) emit("of another form", Reason::kInvalidValue, "//");
  }

  void ProbeCount(const Way& way, const FieldDescriptor* field, const v1::Limit& limit) const {
    const uint64_t multiple = std::max<uint64_t>(1, limit.items_multiple());
    const auto emit = [&](const std::string& probe, uint64_t count, std::optional<Reason> reason) {
      if (count * BytesOfElement(field) > options_.field_bytes_max) return;
      Emit(way, field->name(), probe, reason, [&](Message& holder) { FillElements(holder, field, count, complete()); });
    };
    if (multiple > 1)
      emit("not a multiple", multiple + 1 <= limit.max_items() ? multiple + 1 : multiple - 1, Reason::kInvalidValue);
    if (limit.max_items() == 0) return;
    emit("at max items", limit.max_items() / multiple * multiple, std::nullopt);
    emit("above max items", (limit.max_items() / multiple + 1) * multiple, Reason::kOutOfRange);
  }

  void ProbeUnitLength(const Way& way, const FieldDescriptor* field) const {
    const auto emit = [&](const std::string& probe, double length, std::optional<Reason> reason) {
      Emit(way, field->name(), probe, reason, [&](Message& holder) {
        Message* vector = holder.GetReflection()->MutableMessage(&holder, field);
        vector->Clear();
        // Not along an axis, so that every component has to be counted.
        const double component = length / std::sqrt(static_cast<double>(vector->GetDescriptor()->field_count()));
        for (int i = 0; i < vector->GetDescriptor()->field_count(); ++i) {
          SetNumber(*vector, vector->GetDescriptor()->field(i), i % 2 == 0 ? component : -component);
        }
      });
    };
    emit("zero", 0, Reason::kNotUnitLength);
    emit("unit", 1, std::nullopt);
    emit("almost unit", kAlmostUnit, std::nullopt);
    emit("too long", kNotUnit, Reason::kNotUnitLength);
    emit("too short", 2 - kNotUnit, Reason::kNotUnitLength);
  }

  void ProbeColumn(const Way& way, const FieldDescriptor* field, const v1::Limit& limit) const {
    const auto emit = [&](const std::string& probe, const std::string& name, std::optional<Reason> reason,
                          const std::function<void(std::string&)>& mutate) {
      Emit(way, name, probe, reason, [&](Message& holder) {
        FillColumns(holder, kColumnRows);
        std::string bytes = holder.GetReflection()->GetString(holder, field);
        mutate(bytes);
        holder.GetReflection()->SetString(&holder, field, bytes);
      });
    };
    const size_t row = BytesPerRow(limit.column());
    emit("one byte more", field->name(), Reason::kInvalidValue, [](std::string& bytes) { bytes.push_back('\0'); });
    emit("one byte less", field->name(), Reason::kInvalidValue, [](std::string& bytes) { bytes.pop_back(); });
    if (row > BytesPerScalar(limit.column())) {
      emit("part of a row more", field->name(), Reason::kInvalidValue,
           [&](std::string& bytes) { bytes.append(BytesPerScalar(limit.column()), '\0'); });
    }
    if (!limit.column().rows_as().empty()) {
      emit("one row more", field->name(), Reason::kInvalidValue, [&](std::string& bytes) { bytes.append(row, '\0'); });
      emit("one row less", field->name(), Reason::kInvalidValue,
           [&](std::string& bytes) { bytes.resize(bytes.size() - row); });
      emit("empty", field->name(),
           limit.column().may_be_empty() ? std::nullopt : std::optional<Reason>(Reason::kInvalidValue),
           [](std::string& bytes) { bytes.clear(); });
    }
    if (const uint64_t rows = limit.max_items(); rows != 0 && (rows + 1) * row <= options_.field_bytes_max) {
      Emit(way, field->name(), "at max rows", std::nullopt, [&](Message& holder) {
        ClearColumns(holder);
        FillColumns(holder, rows);
      });
      emit("above max rows", field->name(), Reason::kOutOfRange,
           [&](std::string& bytes) { bytes.resize((rows + 1) * row); });
    }
    if (limit.column().scalar() != v1::SCALAR_FIXED64) ProbeScalars(field, limit, emit);
  }

  // As a refusal names a scalar: by its row, and by its component where a row has several.
  static std::string PlaceInColumn(const v1::Column& column, size_t index) {
    const std::string row = "[" + std::to_string(index / column.width()) + "]";
    const std::string components = column.width() == 1 ? "" : column.width() == 3 ? "xyz" : "wxyz";
    return components.empty() ? row : row + "." + components[index % column.width()];
  }

  template <typename EmitColumn>
  static void ProbeScalars(const FieldDescriptor* field, const v1::Limit& limit, const EmitColumn& emit) {
    const auto probe = [&](const std::string& name, double value, std::optional<Reason> reason) {
      for (const size_t index : {size_t{0}, kColumnRows * limit.column().width() - 1}) {
        emit(name, field->name() + PlaceInColumn(limit.column(), index), reason,
             [&](std::string& bytes) { SetScalar(bytes, limit.column(), index, value); });
      }
    };
    probe("NaN", kNan, Reason::kNotFinite);
    probe("+infinity", kInfinity, Reason::kNotFinite);
    probe("-infinity", -kInfinity, Reason::kNotFinite);
    probe("at min", limit.min(), std::nullopt);
    probe("below min", NextScalar(limit.column(), limit.min(), -kInfinity), Reason::kOutOfRange);
    probe("at max", limit.max(), std::nullopt);
    probe("above max", NextScalar(limit.column(), limit.max(), kInfinity), Reason::kOutOfRange);
  }

  const std::function<void(Message&)>& complete() const { return options_.complete; }

  const Message& sample_;
  const LimitCaseOptions& options_;
  const std::function<void(const LimitCase&)>& visit_;
};

}  // namespace

void FillRequired(Message& message) { FillMessage(message, nullptr); }

void ForEachLimitCase(const Message& sample, const LimitCaseOptions& options,
                      const std::function<void(const LimitCase&)>& visit) {
  Generator(sample, options, visit).Walk(sample.GetDescriptor(), {});
}

}  // namespace genphys

#include "limits_plan.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "genphys/v1/engine_service.pb.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/v1/world_service.pb.h"

namespace genphys {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptor;
using google::protobuf::OneofDescriptor;

const v1::Limit& DeclaredLimit(const FieldDescriptor* field) { return field->options().GetExtension(v1::limit); }

// A type that leaves its limits to the field that holds it, like Vector3.
bool TakesLimitOfHolder(const Descriptor* type) {
  for (int i = 0; i < type->field_count(); ++i) {
    const FieldDescriptor* field = type->field(i);
    if (field->options().HasExtension(v1::limit) || field->message_type() != nullptr) return false;
  }
  return true;
}

bool AcceptsEverything(const FieldRules& rules) {
  return rules.type == FieldDescriptor::CPPTYPE_BOOL && !rules.repeated && !rules.required;
}

// Read as a whole before the first use and never changed again, so that readers need no lock.
class Plans {
 public:
  Plans() {
    for (const Descriptor* type : {v1::Engine::descriptor(), v1::World::descriptor(), v1::StepRequest::descriptor()}) {
      AddFile(type->file());
    }
  }

  const MessageRules* Find(const Descriptor* type) const {
    const auto found = roots_.find(type);
    return found == roots_.end() ? nullptr : found->second;
  }

 private:
  // A type, and the limit that it takes over: null, or that of the field which holds it.
  using Key = std::pair<const Descriptor*, const v1::Limit*>;

  void AddFile(const FileDescriptor* file) {
    if (!files_.insert(file).second) return;
    for (int i = 0; i < file->message_type_count(); ++i) {
      roots_.emplace(file->message_type(i), &Build(file->message_type(i), nullptr));
    }
    for (int i = 0; i < file->dependency_count(); ++i) {
      if (file->dependency(i)->package() == file->package()) AddFile(file->dependency(i));
    }
  }

  const MessageRules& Build(const Descriptor* type, const v1::Limit* inherited) {
    const auto [entry, is_new] = plans_.try_emplace(Key{type, inherited});
    if (!is_new) return *entry->second;
    // Entered before its fields are read, so that a type that contains itself finds itself.
    entry->second = std::make_unique<MessageRules>();
    MessageRules& rules = *entry->second;

    std::vector<const FieldDescriptor*> fields;
    for (int i = 0; i < type->field_count(); ++i) fields.push_back(type->field(i));
    std::sort(fields.begin(), fields.end(), [](auto* a, auto* b) { return a->number() < b->number(); });
    for (const FieldDescriptor* field : fields) {
      const OneofDescriptor* oneof = field->real_containing_oneof();
      if (oneof == nullptr) {
        FieldRules field_rules = BuildField(field, inherited);
        if (!AcceptsEverything(field_rules)) AddGroup(rules, nullptr).push_back(std::move(field_rules));
      } else if (!HasGroup(rules, oneof)) {
        std::vector<FieldRules>& members = AddGroup(rules, oneof);
        for (int i = 0; i < oneof->field_count(); ++i) members.push_back(BuildField(oneof->field(i), inherited));
      }
    }
    return rules;
  }

  static std::vector<FieldRules>& AddGroup(MessageRules& rules, const OneofDescriptor* oneof) {
    return rules.groups.emplace_back(RuleGroup{oneof, {}}).fields;
  }

  static bool HasGroup(const MessageRules& rules, const OneofDescriptor* oneof) {
    return std::any_of(rules.groups.begin(), rules.groups.end(), [&](const auto& g) { return g.oneof == oneof; });
  }

  FieldRules BuildField(const FieldDescriptor* field, const v1::Limit* inherited) {
    FieldRules rules;
    rules.field = field;
    rules.type = field->cpp_type();
    rules.repeated = field->is_repeated();
    rules.has_presence = field->has_presence();
    rules.limit = inherited != nullptr ? inherited : &DeclaredLimit(field);
    const v1::Limit& limit = *rules.limit;
    rules.required = inherited == nullptr && limit.required();
    if (limit.has_min()) rules.min = limit.min();
    if (limit.has_max()) rules.max = limit.max();
    if (limit.exclusive_min()) rules.min = std::nextafter(rules.min, std::numeric_limits<double>::infinity());
    if (!limit.pattern().empty()) rules.pattern = std::make_shared<RE2>(limit.pattern());
    assert(!limit.has_column() || (limit.column().width() > 0 && limit.column().scalar() != v1::SCALAR_UNSPECIFIED));
    if (!limit.column().rows_as().empty()) {
      rules.rows_as = field->containing_type()->FindFieldByName(limit.column().rows_as());
      assert(rules.rows_as != nullptr);
    }
    if (const Descriptor* type = field->message_type()) {
      rules.message = &Build(type, TakesLimitOfHolder(type) ? rules.limit : nullptr);
    }
    return rules;
  }

  std::set<const FileDescriptor*> files_;
  std::map<Key, std::unique_ptr<MessageRules>> plans_;
  std::unordered_map<const Descriptor*, const MessageRules*> roots_;
};

}  // namespace

const MessageRules* RulesOf(const Descriptor* descriptor) {
  // Never destroyed: a thread may still validate while the program ends.
  static const Plans& plans = *new Plans;
  return plans.Find(descriptor);
}

}  // namespace genphys

#include "joint_mask.h"

#include <array>
#include <string>
#include <string_view>

#include "joint_kinds.h"
#include "update_mask.h"

namespace genphys {
namespace {

struct FieldPath {
  std::string_view path;
  JointField field;
};

constexpr std::array kPaths{
    FieldPath{"frame_in_a", JointField::kFrameInA},
    FieldPath{"frame_in_b", JointField::kFrameInB},
    FieldPath{"collide_connected", JointField::kCollideConnected},
    FieldPath{"break_force", JointField::kBreakForce},
    FieldPath{"break_torque", JointField::kBreakTorque},
};

// Inside a hinge or a slider.
constexpr std::array kParts{
    FieldPath{"limits", JointField::kLimits},
    FieldPath{"motor", JointField::kMotor},
    FieldPath{"spring", JointField::kSpring},
};

bool HasParts(std::string_view kind) { return kind == "hinge" || kind == "slider"; }

// Where in the mask it stands is told by whoever goes through that.
Status RefusePath(const std::string& path, std::string_view why) {
  return Refuse(Reason::kInvalidValue, "", "\"" + path + "\" " + std::string(why));
}

Result<JointField> DecodePath(const std::string& path, std::string_view kind) {
  for (const FieldPath& known : kPaths) {
    if (path == known.path) return known.field;
  }
  if (path == "entity_a" || path == "entity_b") return RefusePath(path, "stays: make another joint instead");
  const size_t dot = path.find('.');
  const std::string_view head = std::string_view(path).substr(0, dot);
  if (KindOfName(head) == v1::Joint::KIND_NOT_SET) {
    std::string all;
    for (const FieldPath& known : kPaths) all.append(known.path).append(", ");
    return RefusePath(path, "names no field that an update can change: " + all + "and the kind of the joint");
  }
  if (head != kind) return RefusePath(path, "is not of the kind that the joint sets");
  if (dot == std::string::npos) return JointField::kKind;
  const std::string_view part = std::string_view(path).substr(dot + 1);
  for (const FieldPath& known : kParts) {
    if (HasParts(kind) && part == known.path) return known.field;
  }
  return RefusePath(path, "cannot change alone; name \"" + std::string(head) + "\" and set all of it");
}

}  // namespace

Result<JointFields> DecodeJointMask(const v1::Joint& joint, const google::protobuf::FieldMask& mask) {
  JointFields fields;
  for (int i = 0; i < mask.paths_size(); ++i) {
    const Result<JointField> field = DecodePath(mask.paths(i), NameOfKind(joint.kind_case()));
    if (!field.ok()) return WithFieldPrefix(field.status(), PlaceInMask(i));
    fields.Add(*field);
  }
  return fields;
}

JointFields PopulatedFields(const v1::Joint& joint) {
  JointFields fields;
  const auto add_if = [&fields](bool populated, JointField field) {
    if (populated) fields.Add(field);
  };
  add_if(joint.kind_case() != v1::Joint::KIND_NOT_SET, JointField::kKind);
  add_if(joint.has_frame_in_a(), JointField::kFrameInA);
  add_if(joint.has_frame_in_b(), JointField::kFrameInB);
  add_if(joint.collide_connected(), JointField::kCollideConnected);
  add_if(joint.has_break_force(), JointField::kBreakForce);
  add_if(joint.has_break_torque(), JointField::kBreakTorque);
  return fields;
}

void EncodeJointMask(const JointKind& kind, JointFields fields, google::protobuf::FieldMask* out) {
  for (const FieldPath& known : kPaths) {
    if (fields.Has(known.field)) out->add_paths(known.path.data(), known.path.size());
  }
  const std::string name(NameOfKind(CaseOf(kind)));
  if (fields.Has(JointField::kKind)) out->add_paths(name);
  for (const FieldPath& known : kParts) {
    if (fields.Has(known.field)) out->add_paths(name + "." + std::string(known.path));
  }
}

}  // namespace genphys

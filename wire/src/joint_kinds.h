#pragma once
#include <array>
#include <string_view>

#include "genphys/joint.h"
#include "genphys/v1/joint.pb.h"

namespace genphys {

struct JointKindRow {
  v1::Joint::KindCase kind;
  std::string_view name;  // of the field
};

/// By index of the model's alternative.
inline constexpr std::array<JointKindRow, std::variant_size_v<JointKind>> kJointKinds{
    JointKindRow{v1::Joint::kBall, "ball"},      JointKindRow{v1::Joint::kHinge, "hinge"},
    JointKindRow{v1::Joint::kSlider, "slider"},  JointKindRow{v1::Joint::kUniversal, "universal"},
    JointKindRow{v1::Joint::kFixed, "fixed"},    JointKindRow{v1::Joint::kWheel, "wheel"},
    JointKindRow{v1::Joint::kSixDof, "six_dof"}, JointKindRow{v1::Joint::kDistance, "distance"},
    JointKindRow{v1::Joint::kGear, "gear"}};

inline v1::Joint::KindCase CaseOf(const JointKind& kind) { return kJointKinds[kind.index()].kind; }

/// Empty when it is not set.
inline std::string_view NameOfKind(v1::Joint::KindCase kind) {
  for (const JointKindRow& row : kJointKinds) {
    if (row.kind == kind) return row.name;
  }
  return {};
}

inline v1::Joint::KindCase KindOfName(std::string_view name) {
  for (const JointKindRow& row : kJointKinds) {
    if (row.name == name) return row.kind;
  }
  return v1::Joint::KIND_NOT_SET;
}

}  // namespace genphys

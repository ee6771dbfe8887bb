#pragma once
#include <google/protobuf/message.h>

#include <map>
#include <string>

namespace genphys {

/// Full name of a oneof to the name of the alternative that is wanted in it.
using Alternatives = std::map<std::string, std::string>;

/// Sets every field of `message` and of all that it holds to a value of its own, so that a conversion that drops a
/// field or takes one for another is seen. Of a oneof the wanted alternative is set, else its first. Columns and lists
/// whose number of elements must be a multiple get as many as they need.
void FillEveryField(google::protobuf::Message* message, const Alternatives& wanted = {});

}  // namespace genphys

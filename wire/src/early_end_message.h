#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "genphys/ids.h"
#include "genphys/v1/error.pb.h"
#include "genphys/wire/early_end.h"

namespace genphys {

void EncodeEarlyEnd(const EarlyEnd& end, v1::EarlyEnd* out);
EarlyEnd DecodeEarlyEnd(const v1::EarlyEnd& message);

/// What goes into the headers of a reply has to be short: clients take 8 KiB of them, unless told otherwise.
inline constexpr size_t kCreatedTextMax = 4096;

/// Which command created what, as the contract writes it: "3:7 5:9-11". Nothing if that is longer than allowed.
std::optional<std::string> CreatedText(std::span<const CreatedId> created);

/// The ids up to those of the last command that `text` names; without any if it is none of ours.
std::vector<CreatedId> CreatedOf(std::string_view text);

}  // namespace genphys

#pragma once
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "genphys/status.h"
#include "support/limit_cases.h"

namespace genphys::testing {

/// Knows the cases within the declared limits that are refused nevertheless, for what they mean, by a server whose
/// default engine and whose worlds' engine is `engine`. All of them are listed in the source, and every one is a rule.
class Meaning {
 public:
  explicit Meaning(const std::string& engine);

  /// How a case that lies within the declared limits must be refused; nothing if it must be accepted.
  std::optional<Refusal> RefusalFor(const LimitCase& probe);

  /// Rules that matched no case so far.
  std::vector<std::string> Unused() const;

 private:
  struct Rule {
    /// For the name of the request, a dot, and the path of the probed field.
    std::string where;
    /// For the probe.
    std::string probe;
    Reason reason;
    /// Path that is blamed, in terms of the groups of `where`.
    std::string blamed;
    std::regex where_pattern = std::regex(where);
    std::regex probe_pattern = std::regex(probe);
    bool used = false;
  };

  std::vector<Rule> rules_;
};

}  // namespace genphys::testing

#include "integration/meaning.h"

#include "genphys/v1/engine_service.pb.h"
#include "genphys/v1/stepper.pb.h"
#include "support/scenes.h"

namespace genphys::testing {
namespace {

constexpr char kAny[] = ".*";
constexpr char kLargestId[] = "largest of its type";
constexpr char kLongest[] = "at max length";

// Names of things that are not there.
struct Known {
  const char* where;
  const char* probe;
  Reason reason;
  const char* blamed;
};

const std::vector<Known> kNames{
    {R"(GetEngineRequest\.(name))", kLongest, Reason::kInvalidValue, "$1"},
    {R"([A-Za-z]+Request\.(world|name))", kLongest, Reason::kWorldNotFound, "$1"},
    {R"(CreateWorldRequest\.(world\.engine))", kLongest, Reason::kInvalidValue, "$1"},
    {R"(StepRequest\.(commands\[0\]\.set_engine\.engine))", kLongest, Reason::kInvalidValue, "$1"},
    {R"([A-Za-z]+Request\.(page_token))", kLongest, Reason::kInvalidValue, "$1"},
    {R"([A-Za-z]+Request\.(entity_id|force\.entity_id))", kLargestId, Reason::kEntityNotFound, "$1"},
    {R"(StepRequest\.(commands\[0\]\.[a-z_]+\.entity_id))", kLargestId, Reason::kEntityNotFound, "$1"},
    {R"(CreateEntityRequest\.(entity\.id))", kLargestId, Reason::kInvalidValue, "$1"},
    {R"(StepRequest\.(commands\[0\]\.create_(?:entity\.entity|joint\.joint|force_field\.field)\.id))", kLargestId,
     Reason::kInvalidValue, "$1"},
    {R"(StepRequest\.(commands\[0\]\.update_entity\.entity\.id))", kLargestId, Reason::kEntityNotFound, "$1"},
    {R"(StepRequest\.(commands\[0\]\.[a-z]+_force_field\.field\.(?:entity_ids\[0\]|spring\.entity_[ab])))", kLargestId,
     Reason::kEntityNotFound, "$1"},
    {R"(StepRequest\.(commands\[0\]\.(?:update_force_field\.field\.id|delete_force_field\.field_id)))", kLargestId,
     Reason::kEntityNotFound, "$1"},
    {R"([A-Za-z]+Request\.(frame\.entity_ids\[0\]))", kLargestId, Reason::kEntityNotFound, "$1"},
    {R"([A-Za-z]+Request\.(.*rigid_body\.ignored_entity_ids\[0\]))", kLargestId, Reason::kEntityNotFound, "$1"},
    // What a list is lengthened by names no dynamic entity.
    {R"(StepRequest\.(commands\[0\]\.[a-z]+_force_field\.field\.entity_ids))", "at max items", Reason::kInvalidValue,
     "$1[0]"},
    {R"(StepRequest\.(commands\[0\]\.update_entity\.update_mask\.paths).*)", kAny, Reason::kInvalidValue, "$1[0]"},
    {R"(StepRequest\.(commands\[0\]\.update_joint\.joint\.id))", kLargestId, Reason::kEntityNotFound, "$1"},
    {R"(StepRequest\.(commands\[0\]\.delete_joint\.joint_id))", kLargestId, Reason::kEntityNotFound, "$1"},
    {R"(StepRequest\.(commands\[0\]\.create_joint\.joint\.entity_[ab]\.id))", kLargestId, Reason::kEntityNotFound,
     "$1"},
    // The command before this one is none that creates an entity.
    {R"(StepRequest\.(commands\[0\]\.create_joint\.joint\.entity_[ab]\.created_by_command))", kAny,
     Reason::kInvalidValue, "$1"},
    {R"(StepRequest\.(commands\[0\]\.create_force_field\.created_by_commands)(?:\[0\])?)", kAny, Reason::kInvalidValue,
     "$1[0]"},
    {R"(StepRequest\.(commands\[0\]\.create_force_field\.spring_[ab]_created_by_command))", kAny, Reason::kInvalidValue,
     "$1"},
    {R"(StepRequest\.(commands\[0\]\.update_joint\.update_mask\.paths).*)", kAny, Reason::kInvalidValue, "$1[0]"},
    {R"(StepRequest\.(commands\[0\]\.set_motors)\..*)", "at max rows", Reason::kMissingField, "$1.joint_ids[0]"},
    // What a column is lengthened by is zeros.
    {R"(StepRequest\.(commands\[0\]\.apply_forces)\..*)", "at max rows", Reason::kMissingField, "$1.entity_ids[0]"},
    // The present is neither there nor then.
    {R"(StepRequest\.(expected_step))", kLargestId, Reason::kStepMismatch, "$1"},
    {R"(WatchEventsRequest\.(after_sequence))", kLargestId, Reason::kOutOfRange, "$1"},
};

// What no body is. The neighbours that are possible have tests of their own.
const std::vector<Known> kImpossible{
    // The entities of these cases are dynamic, and a half space is not.
    {R"([A-Za-z]+Request\.(.*\.shape\.plane)\..*)", kAny, Reason::kInvalidValue, "$1"},
    // Points at one place bound no body and span no triangle, and one height is no field.
    {R"([A-Za-z]+Request\.(.*\.shape\.convex_hull)\..*)", kAny, Reason::kInvalidValue, "$1.vertices"},
    // A mesh has one vertex then, which is number 0, and names others.
    {R"([A-Za-z]+Request\.(.*\.shape\.triangle_mesh)\.indices\[0\])", "at min", Reason::kOutOfRange, "$1.indices[1]"},
    {R"([A-Za-z]+Request\.(.*\.shape\.triangle_mesh)\.(?:vertices|indices)\[0\])", kAny, Reason::kOutOfRange,
     "$1.indices[0]"},
    {R"([A-Za-z]+Request\.(.*\.shape\.triangle_mesh)\..*)", kAny, Reason::kInvalidValue, "$1.indices"},
    {R"([A-Za-z]+Request\.(.*\.shape\.heightfield)\..*)", kAny, Reason::kInvalidValue, "$1.heights"},
    // The same of a query, which asks for a bounded shape besides.
    {R"([A-Za-z]+Request\.(shape)\.plane\..*)", kAny, Reason::kInvalidValue, "$1"},
    {R"([A-Za-z]+Request\.(shape\.convex_hull)\..*)", kAny, Reason::kInvalidValue, "$1.vertices"},
    {R"([A-Za-z]+Request\.(shape\.triangle_mesh)\.indices\[0\])", "at min", Reason::kOutOfRange, "$1.indices[1]"},
    {R"([A-Za-z]+Request\.(shape\.triangle_mesh)\.(?:vertices|indices)\[0\])", kAny, Reason::kOutOfRange,
     "$1.indices[0]"},
    {R"([A-Za-z]+Request\.(shape\.triangle_mesh)\..*)", kAny, Reason::kInvalidValue, "$1.indices"},
    {R"([A-Za-z]+Request\.(shape\.heightfield)\..*)", kAny, Reason::kInvalidValue, "$1.heights"},
    // What a column is lengthened by is zeros, which turn nothing and name nobody. A length of 1.001 is accepted.
    {R"((?:CastShape|FindOverlaps|FindClosest)Request\.orientations\[0\]\.w)", "at min|at max", Reason::kNotUnitLength,
     "orientations[1]"},
    {R"((?:CastShape|FindOverlaps|FindClosest)Request\.(?:positions|orientations|translations).*)", "(?!empty).*",
     Reason::kNotUnitLength, "orientations[0]"},
    {R"(MeasureDistancesRequest\.(?:from|to)_ids.*)", kAny, Reason::kMissingField, "from_ids[0]"},
    // A motor drives to a position by its stiffness, and one without the other is none.
    {R"(StepRequest\.(.*\.motor)\.target_(?:radians|metres))", kAny, Reason::kInvalidValue, "$1.stiffness"},
    {R"(StepRequest\.(.*\.(?:hinge|about_[xyz]|steering|spin)\.motor)\.(?:stiffness|damping))", "at max|above min",
     Reason::kInvalidValue, "$1.target_radians"},
    {R"(StepRequest\.(.*\.(?:slider|distance|suspension|along_[xyz])\.motor)\.(?:stiffness|damping))",
     "at max|above min", Reason::kInvalidValue, "$1.target_metres"},
    {R"(StepRequest\.(.*\.distance\.limits\.upper_metres))", "at min|above min", Reason::kOutOfRange, "$1"},
    // The entities of these cases are dynamic, and only kinematic ones are led.
    {R"(StepRequest\.(commands\[0\]\.set_pose\.over_steps))", "at max|above min", Reason::kInvalidValue, "$1"},
    // With all other elements 1, no element makes a tensor that is positive definite.
    {R"([A-Za-z]+Request\.(.*\.inertia\.tensor).*)", kAny, Reason::kInvalidValue, "$1"},
};

}  // namespace

Meaning::Meaning(const std::string& engine) {
  for (const auto* some : {&kNames, &kImpossible}) {
    for (const Known& known : *some) rules_.push_back({known.where, known.probe, known.reason, known.blamed});
  }
  const Capabilities& capabilities = Engines().Find(engine)->capabilities();
  for (int number = v1::Feature_MIN + 1; number <= v1::Feature_MAX; ++number) {
    if (capabilities.Has(static_cast<Feature>(number))) continue;
    rules_.push_back({R"(CreateWorldRequest\.world\.required_features\[0\])", "number " + std::to_string(number),
                      Reason::kUnsupportedFeature, "world.engine"});
  }
  if (!capabilities.Has(Feature::kSolverDirect)) {
    rules_.push_back({R"((?:CreateWorld|Step)Request\.(.*stepper\.solver))",
                      "number " + std::to_string(v1::Stepper::SOLVER_DIRECT), Reason::kUnsupportedFeature, "$1"});
  }
}

std::optional<Refusal> Meaning::RefusalFor(const LimitCase& probe) {
  std::string where = probe.request.GetDescriptor()->name() + "." + probe.field, holder;
  // What streams of steps hold means what it means to Step.
  for (const std::string path : {"requests[0].", "step."}) {
    if (!probe.field.starts_with(path)) continue;
    holder = path;
    where = "StepRequest." + probe.field.substr(path.size());
  }
  for (Rule& rule : rules_) {
    std::smatch match;
    if (!std::regex_match(where, match, rule.where_pattern)) continue;
    if (!std::regex_match(probe.probe, rule.probe_pattern)) continue;
    rule.used = true;
    return Refusal{rule.reason, holder + match.format(rule.blamed)};
  }
  return std::nullopt;
}

std::vector<std::string> Meaning::Unused() const {
  std::vector<std::string> unused;
  for (const Rule& rule : rules_) {
    if (!rule.used) unused.push_back(rule.where + " " + rule.probe);
  }
  return unused;
}

}  // namespace genphys::testing

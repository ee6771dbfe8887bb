// Every field of every request, within its limits and outside, by way of a live server. The cases come from the
// descriptors and the declared limits, so that a new field is covered without anyone remembering it.
#include <gtest/gtest.h>

#include "conformance/engine_test.h"
#include "integration/input_bench.h"
#include "integration/meaning.h"
#include "support/limit_cases.h"
#include "support/requests.h"
#include "support/sweep.h"

namespace genphys::testing {
namespace {

using google::protobuf::Message;
using google::protobuf::MethodDescriptor;

// Enough for every list and column at its published maximum, and half of what a request may have.
constexpr size_t kFieldBytesMax = size_t{32} << 20;

// Streams of steps hold whole StepRequests: what those hold is tried by the cases of Step, from which they go the same
// way.
bool IsTriedByStep(const LimitCase& probe) {
  const std::string& field = probe.field;
  for (const std::string holder : {"requests[0].", "step."}) {
    if (field.starts_with(holder) && field.find('.', holder.size()) != std::string::npos) return true;
  }
  return false;
}

class LiveInput : public ::testing::TestWithParam<std::tuple<std::string, const MethodDescriptor*>> {
 protected:
  const std::string& engine() const { return std::get<0>(GetParam()); }
  const MethodDescriptor& method() const { return *std::get<1>(GetParam()); }
};

INSTANTIATE_TEST_SUITE_P(Engines, LiveInput,
                         ::testing::Combine(::testing::ValuesIn(EnginesWithContacts()), ::testing::ValuesIn(Methods())),
                         [](const auto& test) {
                           return std::get<0>(test.param) + "_" + std::get<1>(test.param)->name();
                         });

TEST_P(LiveInput, IsAcceptedIfAndOnlyIfItLiesWithinTheLimits) {
  InputBench bench(engine());
  Meaning meaning(engine());
  const std::unique_ptr<Message> sample = MinimalRequest(method().input_type());
  bench.Complete(*sample);
  const LimitCaseOptions options{.field_bytes_max = kFieldBytesMax,
                                 .complete = [&](Message& added) { bench.Complete(added); }};
  int cases = 0;

  ForEachLimitCase(*sample, options, [&](const LimitCase& probe) {
    if (IsTriedByStep(probe) || cases++ % kSweepStride != 0) return;
    const std::optional<Refusal> refusal = probe.refusal ? probe.refusal : meaning.RefusalFor(probe);
    bench.Try(method(), probe.request, VerdictOf(refusal), probe.field + " " + probe.probe);
  });

  EXPECT_GT(cases, 0);
}

TEST_P(LiveInput, OfOtherBytesThanARequestIsRefused) {
  InputBench bench(engine());

  // A group that nothing ends, a length beyond the end, a varint without end, a field without a number.
  for (const std::string bytes : {"\x0b", "\x0a\x7f", "\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff", "\x02\x01\x61"}) {
    bench.Try(method(), bytes, "INVALID_VALUE ", "bytes");
  }
}

class MeaningOfCases : public EngineTest {};

INSTANTIATE_TEST_SUITE_P(Engines, MeaningOfCases, ::testing::ValuesIn(EnginesWithContacts()), EngineName);

TEST_P(MeaningOfCases, HasNoRuleThatMatchesNone) {
  Meaning meaning(GetParam());

  for (const MethodDescriptor* method : Methods()) {
    ForEachLimitCase(*MinimalRequest(method->input_type()), {.field_bytes_max = kFieldBytesMax},
                     [&](const LimitCase& probe) {
                       if (!probe.refusal) meaning.RefusalFor(probe);
                     });
  }

  EXPECT_EQ(meaning.Unused(), std::vector<std::string>());
}

}  // namespace
}  // namespace genphys::testing

#include <gtest/gtest.h>

#include "genphys/wire/error.h"
#include "google/rpc/error_details.pb.h"
#include "wire_round_trip.h"

namespace genphys {
namespace {

class EveryReason : public testing::TestWithParam<int> {};

TEST_P(EveryReason, HasTheSameNameOnTheWireAndTravelsWithItsField) {
  const auto reason = static_cast<Reason>(GetParam());
  EXPECT_EQ(v1::ErrorReason_Name(GetParam()), "ERROR_REASON_" + std::string(NameOf(reason)));
  EXPECT_EQ(EncodeReason(reason), GetParam());
  EXPECT_EQ(DecodeReason(EncodeReason(reason)), reason);
  const Status sent = Refuse(reason, "commands[3].set_pose", "why");

  const Status received = DecodeStatus(EncodeStatus(sent));

  EXPECT_EQ(received.code(), CodeOf(reason));
  EXPECT_EQ(MessageOf(received), "why");
  ASSERT_TRUE(RefusalOf(received).has_value());
  EXPECT_EQ(RefusalOf(received)->reason, reason);
  EXPECT_EQ(RefusalOf(received)->field, "commands[3].set_pose");
  v1::Refusal in_stream;
  EncodeRefusal(sent, &in_stream);
  EXPECT_EQ(in_stream.code(), static_cast<int>(CodeOf(reason)));
  EXPECT_EQ(DecodeRefusal(in_stream), sent);
}

TEST(WireError, KeepsCodesThatAreNoRefusalOfOursInAStream) {
  const Status sent = absl::CancelledError("the call was cancelled");
  v1::Refusal refusal;

  EncodeRefusal(sent, &refusal);

  EXPECT_EQ(refusal.reason(), v1::ERROR_REASON_UNSPECIFIED);
  EXPECT_EQ(DecodeRefusal(refusal), sent);
}

// Zero is no refusal of ours, so it is not restored as one.
INSTANTIATE_TEST_SUITE_P(WireError, EveryReason, testing::Range(1, static_cast<int>(v1::ErrorReason_ARRAYSIZE)));

EarlyEnd Created(std::vector<uint64_t> ids) {
  EarlyEnd end{7, 4'000'000'000'000};
  for (const uint64_t id : ids) end.created.push_back(EntityId::FromPacked(id));
  return end;
}

TEST(WireError, TellsHowFarStepsCame) {
  for (const Status& status : {Status(absl::DeadlineExceededError("late")), Refuse(Reason::kDiverged, "", "why")}) {
    const google::rpc::Status encoded = EncodeStatus(WithEarlyEnd(status, Created({})));

    ASSERT_EQ(encoded.details_size(), 1);
    google::rpc::ErrorInfo info;
    ASSERT_TRUE(encoded.details(0).UnpackTo(&info));
    EXPECT_EQ(info.metadata().at("steps_done"), "7");
    EXPECT_EQ(info.metadata().at("step"), "4000000000000");
    EXPECT_FALSE(info.metadata().contains("created_ids"));
    EXPECT_EQ(DecodeStatus(encoded), WithEarlyEnd(status, Created({})));
  }
  EXPECT_EQ(EncodeStatus(absl::DeadlineExceededError("late")).details_size(), 0);
}

TEST(WireError, TellsWhatWasCreatedBeforeStepsEndedEarly) {
  const EarlyEnd end = Created({0, 0, 0, 7, 0, 9, 10, 11, (uint64_t{3} << 32) + 12});
  const Status sent = WithEarlyEnd(absl::DeadlineExceededError("late"), end);

  const google::rpc::Status encoded = EncodeStatus(sent);

  google::rpc::ErrorInfo info;
  ASSERT_TRUE(encoded.details(0).UnpackTo(&info));
  EXPECT_EQ(info.metadata().at("created_ids"), "3:7 5:9-11 8:12884901900");
  EXPECT_EQ(EarlyEndOf(DecodeStatus(encoded)), end);
  v1::Refusal in_stream;
  EncodeRefusal(sent, &in_stream);
  EXPECT_EQ(in_stream.early_end().steps_done(), 7u);
  EXPECT_EQ(in_stream.early_end().created_ids(5), 9u);
  EXPECT_EQ(EarlyEndOf(DecodeRefusal(in_stream)), end);
}

TEST(WireError, TellsHowManyCommandsWereCarriedOut) {
  EarlyEnd end = Created({5, 6});
  end.commands_done = 2;
  const Status sent = WithEarlyEnd(absl::DeadlineExceededError("late"), end);

  const google::rpc::Status encoded = EncodeStatus(sent);

  google::rpc::ErrorInfo info;
  ASSERT_TRUE(encoded.details(0).UnpackTo(&info));
  EXPECT_EQ(info.metadata().at("commands_done"), "2");
  EXPECT_EQ(EarlyEndOf(DecodeStatus(encoded)), end);
  v1::Refusal in_stream;
  EncodeRefusal(sent, &in_stream);
  EXPECT_EQ(in_stream.early_end().commands_done(), 2u);
  EXPECT_EQ(EarlyEndOf(DecodeRefusal(in_stream)), end);
}

TEST(WireError, LeavesOutCreatedIdsThatHeadersHaveNoRoomFor) {
  std::vector<uint64_t> many, scattered;
  for (uint64_t i = 1; i <= 100'000; ++i) {
    many.push_back(i);
    scattered.push_back(2 * i);
  }

  const google::rpc::Status encoded = EncodeStatus(WithEarlyEnd(absl::DeadlineExceededError(""), Created(scattered)));

  EXPECT_EQ(EarlyEndOf(DecodeStatus(encoded)), Created({}));
  const Status whole = WithEarlyEnd(absl::DeadlineExceededError(""), Created(many));
  EXPECT_EQ(EarlyEndOf(DecodeStatus(EncodeStatus(whole))), Created(many));
}

TEST(WireError, TakesNoCreatedIdsFromTextThatIsNone) {
  for (const char* const text :
       {"7", "x:7", "1:", "1:7-", "1:7-6", "1:7 0:8", "1:7,2:8", "1:1-9999999999999", "99999999999:1"}) {
    google::rpc::ErrorInfo info;
    info.set_reason("UNSPECIFIED");
    info.set_domain("genphys");
    (*info.mutable_metadata())["steps_done"] = "7";
    (*info.mutable_metadata())["step"] = "4000000000000";
    (*info.mutable_metadata())["created_ids"] = text;
    google::rpc::Status status;
    status.set_code(static_cast<int>(absl::StatusCode::kDeadlineExceeded));
    status.add_details()->PackFrom(info);

    EXPECT_EQ(EarlyEndOf(DecodeStatus(status)), Created({})) << text;
  }
}

TEST(WireError, BlamesTheFieldInTheStandardWay) {
  const google::rpc::Status status = EncodeStatus(Refuse(Reason::kOutOfRange, "entity.pose.position.x", "too far"));

  ASSERT_EQ(status.details_size(), 2);
  google::rpc::BadRequest request;
  ASSERT_TRUE(status.details(0).UnpackTo(&request));
  ASSERT_EQ(request.field_violations_size(), 1);
  EXPECT_EQ(request.field_violations(0).field(), "entity.pose.position.x");
  EXPECT_EQ(request.field_violations(0).description(), "too far");
  google::rpc::ErrorInfo info;
  ASSERT_TRUE(status.details(1).UnpackTo(&info));
  EXPECT_EQ(info.reason(), "OUT_OF_RANGE");
  EXPECT_EQ(info.domain(), "genphys");
  EXPECT_EQ(info.metadata().at("field"), "entity.pose.position.x");
}

TEST(WireError, BlamesNoFieldWhereNoneIsToBlame) {
  const google::rpc::Status status = EncodeStatus(Refuse(Reason::kDraining, "", "shutting down"));

  ASSERT_EQ(status.details_size(), 1);
  google::rpc::ErrorInfo info;
  ASSERT_TRUE(status.details(0).UnpackTo(&info));
  EXPECT_EQ(info.metadata().size(), 0u);
}

TEST(WireError, LeavesAStatusOfOtherOriginAsItIs) {
  const Status sent(absl::StatusCode::kDeadlineExceeded, "late");

  const google::rpc::Status encoded = EncodeStatus(sent);

  EXPECT_EQ(encoded.details_size(), 0);
  EXPECT_EQ(DecodeStatus(encoded), sent);
}

TEST(WireError, DoesNotTakeTheDetailsOfOthersForARefusal) {
  google::rpc::ErrorInfo info;
  info.set_reason("STALE_ID");
  info.set_domain("example.com");
  google::rpc::Status status;
  status.set_code(static_cast<int>(absl::StatusCode::kNotFound));
  status.add_details()->PackFrom(info);
  EXPECT_EQ(RefusalOf(DecodeStatus(status)), std::nullopt);

  info.set_domain("genphys");
  info.set_reason("OF_THE_FUTURE");
  status.mutable_details(0)->PackFrom(info);

  EXPECT_EQ(RefusalOf(DecodeStatus(status)), std::nullopt);
  EXPECT_EQ(DecodeStatus(status).code(), absl::StatusCode::kNotFound);
}

TEST(WireError, TellsWhyACommandWasRefused) {
  v1::Error error;

  EncodeError(Refuse(Reason::kStaleId, "entity_id", "gone"), &error);

  EXPECT_EQ(error.reason(), v1::ERROR_REASON_STALE_ID);
  EXPECT_EQ(error.field(), "entity_id");
  EXPECT_EQ(error.message(), "gone");
}

}  // namespace
}  // namespace genphys

#include <gtest/gtest.h>

#include <string>

#include "genphys/hosting/request_head.h"
#include "genphys/hosting/world_methods.h"
#include "genphys/v1/simulation_service.pb.h"
#include "genphys/v1/world_service.pb.h"

namespace genphys {
namespace {

const RequestHeadFields kStepFields = RequestHeadFields::Of(*v1::StepRequest::descriptor());

TEST(RequestHead, FindsWorldAndRequestIdAmongOtherFields) {
  v1::StepRequest request;
  request.set_world("worlds/a");
  request.add_commands()->mutable_create_entity()->mutable_entity()->set_display_name("not the head");
  request.set_steps(7);
  request.set_step_size_seconds(0.01);
  request.set_request_id("id");
  const std::string bytes = request.SerializeAsString();

  const auto head = ScanRequestHead(kStepFields, bytes);

  ASSERT_TRUE(head);
  EXPECT_EQ(head->world, "worlds/a");
  EXPECT_EQ(head->request_id, "id");
  EXPECT_TRUE(head->has_commands);
}

TEST(RequestHead, TakesTheNameOfRequestsThatNameTheirWorldSo) {
  v1::GetWorldRequest request;
  request.set_name("worlds/b");
  const std::string bytes = request.SerializeAsString();

  const auto head = ScanRequestHead(RequestHeadFields::Of(*v1::GetWorldRequest::descriptor()), bytes);

  ASSERT_TRUE(head);
  EXPECT_EQ(head->world, "worlds/b");
  EXPECT_TRUE(head->request_id.empty());
  EXPECT_FALSE(head->has_commands);
}

TEST(RequestHead, TakesTheLastOfFieldsThatComeTwiceAsEveryDecoderDoes) {
  v1::StepRequest first, second;
  first.set_world("worlds/a");
  second.set_world("worlds/b");
  const std::string bytes = first.SerializeAsString() + second.SerializeAsString();
  v1::StepRequest decoded;
  ASSERT_TRUE(decoded.ParseFromString(bytes));

  EXPECT_EQ(ScanRequestHead(kStepFields, bytes)->world, decoded.world());
}

TEST(RequestHead, IsEmptyInAnEmptyRequest) {
  const auto head = ScanRequestHead(kStepFields, "");

  ASSERT_TRUE(head);
  EXPECT_TRUE(head->world.empty());
}

TEST(RequestHead, IsRefusedInEveryMessageThatIsCutOffInsideAField) {
  v1::StepRequest request;
  request.set_world("worlds/a");
  request.set_steps(300);
  request.set_step_size_seconds(0.01);
  request.set_request_id("id");
  const std::string bytes = request.SerializeAsString();
  for (size_t size = 0; size <= bytes.size(); ++size) {
    const std::string cut = bytes.substr(0, size);
    v1::StepRequest decoded;

    // Protobuf's own decoder is the judge.
    EXPECT_EQ(ScanRequestHead(kStepFields, cut).has_value(), decoded.ParseFromString(cut)) << size;
  }
}

TEST(RequestHead, IsRefusedInBytesThatAreNoMessage) {
  const std::string endless_varint(11, '\xff');
  const std::string longer_than_the_message = "\x0a\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01";
  const std::string field_zero = "\x02\x01x";
  const std::string unknown_wire_type = "\x0f";
  for (const std::string& bytes : {endless_varint, longer_than_the_message, field_zero, unknown_wire_type}) {
    EXPECT_FALSE(ScanRequestHead(kStepFields, bytes));
  }
}

TEST(ScanPayloads, FindsEveryElementOfAList) {
  v1::StepWorldsRequest request;
  for (const char* world : {"worlds/a", "worlds/b"}) request.add_requests()->set_world(world);
  const std::string bytes = request.SerializeAsString();

  const auto payloads = ScanPayloads(v1::StepWorldsRequest::kRequestsFieldNumber, bytes);

  ASSERT_TRUE(payloads);
  ASSERT_EQ(payloads->size(), 2u);
  EXPECT_EQ((*payloads)[1], request.requests(1).SerializeAsString());
  EXPECT_TRUE(ScanPayloads(7, bytes)->empty());
  EXPECT_FALSE(ScanPayloads(1, bytes.substr(0, bytes.size() - 1)));
}

TEST(WorldMethods, AllHaveARequestThatNamesItsWorld) {
  for (int i = 0; i <= static_cast<int>(WorldMethod::kWatchFrames); ++i) {
    const WorldMethodInfo& info = InfoOf(static_cast<WorldMethod>(i));
    ASSERT_NE(info.request, nullptr);
    EXPECT_EQ(info.head.world, 1u) << info.name;
    const bool has_request_id = info.request->FindFieldByName("request_id") != nullptr;
    EXPECT_EQ(info.head.request_id != 0, has_request_id) << info.name;
  }
}

}  // namespace
}  // namespace genphys

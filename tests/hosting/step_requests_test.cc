// What a world knows of a request that repeats the last one.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "genphys/hosting/bytes.h"
#include "server/hosting/src/step_requests.h"

namespace genphys {
namespace {

using Decoded = std::shared_ptr<const v1::StepRequest>;

v1::StepRequest Request(const std::string& id) {
  v1::StepRequest request;
  request.set_world("worlds/a");
  request.set_steps(2);
  request.mutable_frame()->set_poses(true);
  request.set_request_id(id);
  request.set_expected_step(7);
  return request;
}

Result<Decoded> Decode(StepRequests& requests, const v1::StepRequest& request) {
  return requests.Decode(MakeBytes(request.SerializeAsString()));
}

Decoded MustDecode(StepRequests& requests, const v1::StepRequest& request) {
  Result<Decoded> decoded = Decode(requests, request);
  EXPECT_TRUE(decoded.ok()) << decoded.status();
  return decoded.value_or(std::make_shared<const v1::StepRequest>());
}

TEST(StepRequests, AreDecoded) {
  StepRequests requests;
  const Decoded first = MustDecode(requests, Request("1"));
  EXPECT_EQ(first->SerializeAsString(), Request("1").SerializeAsString());
}

TEST(StepRequests, ThatDifferInTheirIdAreOne) {
  StepRequests requests;
  const Decoded first = MustDecode(requests, Request("call-1"));
  EXPECT_EQ(MustDecode(requests, Request("call-2")), first);
  EXPECT_EQ(MustDecode(requests, Request("call-1")), first);
}

TEST(StepRequests, WithoutAnIdAreOneToo) {
  StepRequests requests;
  EXPECT_EQ(MustDecode(requests, Request("")), MustDecode(requests, Request("")));
}

TEST(StepRequests, ThatDifferElsewhereAreNot) {
  StepRequests requests;
  v1::StepRequest other = Request("call-2");
  MustDecode(requests, Request("call-1"));
  other.set_steps(3);
  EXPECT_EQ(MustDecode(requests, other)->steps(), 3u);
  other.set_expected_step(8);
  EXPECT_EQ(MustDecode(requests, other)->expected_step(), 8u);
  other.set_world("worlds/b");
  EXPECT_EQ(MustDecode(requests, other)->world(), "worlds/b");
  other.set_request_id("call-10");
  EXPECT_EQ(MustDecode(requests, other)->request_id(), "call-10");
}

TEST(StepRequests, WithCommandsAreEachTheirOwn) {
  StepRequests requests;
  v1::StepRequest request = Request("call-1");
  request.add_commands()->mutable_delete_entity()->set_entity_id(1);
  const Decoded first = MustDecode(requests, request);
  EXPECT_NE(MustDecode(requests, request), first);
}

TEST(StepRequests, AreRefusedWhateverCameBefore) {
  StepRequests requests;
  const Decoded good = MustDecode(requests, Request("call-1"));

  v1::StepRequest bad = Request("call-2");
  bad.set_steps(UINT32_MAX);
  EXPECT_EQ(RefusalOf(Decode(requests, bad).status()).value_or(Refusal{}).field, "steps");
  EXPECT_EQ(RefusalOf(Decode(requests, bad).status()).value_or(Refusal{}).field, "steps");
  EXPECT_EQ(RefusalOf(Decode(requests, Request(std::string(129, 'a'))).status()).value_or(Refusal{}).field,
            "request_id");
  // Protobuf's texts are UTF-8, which nothing but the bytes of an id can break here.
  std::string bytes = Request("call-2").SerializeAsString();
  bytes[bytes.find("call-2")] = '\xff';
  EXPECT_FALSE(requests.Decode(MakeBytes(bytes)).ok());

  EXPECT_EQ(MustDecode(requests, Request("call-3"))->SerializePartialAsString(), good->SerializePartialAsString());
}

}  // namespace
}  // namespace genphys

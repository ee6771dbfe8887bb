#include <gtest/gtest.h>

#include <string>

#include "genphys/hosting/reply_cache.h"

namespace genphys {
namespace {

std::string Reply(const ReplyCache& cache, const std::string& id, uint64_t fingerprint) {
  const auto found = cache.Find(id, fingerprint);
  if (!found) return "nothing";
  return found->ok() ? Joined(**found) : NameOf(RefusalOf(found->status())->reason).data();
}

TEST(ReplyCache, GivesBackWhatItKeeps) {
  ReplyCache cache;
  cache.Keep("a", 1, EncodedMessage{MakeBytes("first")});

  EXPECT_EQ(Reply(cache, "a", 1), "first");
  EXPECT_EQ(Reply(cache, "b", 1), "nothing");
}

TEST(ReplyCache, RefusesTheIdOfAnotherRequest) {
  ReplyCache cache;
  cache.Keep("a", 1, EncodedMessage{MakeBytes("first")});

  EXPECT_EQ(Reply(cache, "a", 2), "INVALID_VALUE");
}

TEST(ReplyCache, KeepsErrorsToo) {
  ReplyCache cache;
  cache.Keep("a", 1, Refuse(Reason::kDiverged, "", "half done"));

  EXPECT_EQ(Reply(cache, "a", 1), "DIVERGED");
}

TEST(ReplyCache, KeepsTheFirstOutcomeOfAnId) {
  ReplyCache cache;
  cache.Keep("a", 1, EncodedMessage{MakeBytes("first")});
  cache.Keep("a", 1, EncodedMessage{MakeBytes("second")});

  EXPECT_EQ(Reply(cache, "a", 1), "first");
}

TEST(ReplyCache, ForgetsTheOldestBeyondItsNumberOfReplies) {
  ReplyCache cache({.replies = 2, .bytes = 1000});
  cache.Keep("a", 1, EncodedMessage{MakeBytes("1")});
  cache.Keep("b", 2, EncodedMessage{MakeBytes("2")});
  EXPECT_EQ(Reply(cache, "a", 1), "1");

  cache.Keep("c", 3, EncodedMessage{MakeBytes("3")});

  EXPECT_EQ(Reply(cache, "a", 1), "nothing");
  EXPECT_EQ(Reply(cache, "b", 2), "2");
  EXPECT_EQ(Reply(cache, "c", 3), "3");
}

TEST(ReplyCache, ForgetsTheOldestBeyondItsBytesButNeverTheNewest) {
  ReplyCache cache({.replies = 10, .bytes = 8});
  cache.Keep("a", 1, EncodedMessage{MakeBytes("1234")});
  cache.Keep("b", 2, EncodedMessage{MakeBytes("1234")});
  EXPECT_EQ(Reply(cache, "a", 1), "1234");

  cache.Keep("c", 3, EncodedMessage{MakeBytes("1")});
  EXPECT_EQ(Reply(cache, "a", 1), "nothing");
  EXPECT_EQ(Reply(cache, "b", 2), "1234");

  cache.Keep("d", 4, EncodedMessage{MakeBytes("larger than all")});
  EXPECT_EQ(Reply(cache, "c", 3), "nothing");
  EXPECT_EQ(Reply(cache, "d", 4), "larger than all");
}

TEST(ReplyCache, TellsRequestsApartByMethodAndBytes) {
  EXPECT_EQ(ReplyCache::Fingerprint("m", "r"), ReplyCache::Fingerprint("m", "r"));
  EXPECT_NE(ReplyCache::Fingerprint("m", "r"), ReplyCache::Fingerprint("n", "r"));
  EXPECT_NE(ReplyCache::Fingerprint("m", "r"), ReplyCache::Fingerprint("m", "s"));
}

}  // namespace
}  // namespace genphys

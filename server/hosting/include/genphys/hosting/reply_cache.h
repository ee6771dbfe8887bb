#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "genphys/hosting/bytes.h"
#include "genphys/status.h"

namespace genphys {

/// The last outcomes of requests that had an id, so that a repeated one is answered and not done again. Beyond its
/// bounds the oldest outcome is forgotten, and repeating that request does it again; the newest is always kept.
/// Not thread-safe.
class ReplyCache {
 public:
  static constexpr size_t kRepliesMax = 256;
  // Frames that are forgotten before they leave the processor's cache leave room there for the next: a step with a
  // frame of a thousand entities is answered a tenth faster than with 16 MiB.
  static constexpr size_t kBytesMax = 1 << 20;

  struct Bounds {
    size_t replies = kRepliesMax;
    size_t bytes = kBytesMax;
  };
  ReplyCache() : ReplyCache(Bounds{}) {}
  explicit ReplyCache(Bounds bounds) : bounds_(bounds) {}

  /// Identifies what a request asks for: its method and its bytes.
  static uint64_t Fingerprint(std::string_view method, std::string_view request);

  /// The outcome kept for `id`, INVALID_VALUE if that was of another request, or nothing.
  std::optional<Result<EncodedMessage>> Find(std::string_view id, uint64_t fingerprint) const;
  void Keep(std::string_view id, uint64_t fingerprint, Result<EncodedMessage> outcome);

 private:
  struct Entry {
    uint64_t hash;  // of the id
    std::string id;
    uint64_t fingerprint;
    Result<EncodedMessage> outcome;
  };
  static size_t SizeOf(const Entry& entry);
  const Entry* EntryOf(std::string_view id, uint64_t hash) const;

  Bounds bounds_;
  size_t bytes_ = 0;
  // Oldest first. They are few, and most calls only add one, so that they are looked through and in no table.
  std::deque<Entry> entries_;
};

}  // namespace genphys

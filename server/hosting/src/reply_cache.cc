#include "genphys/hosting/reply_cache.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace genphys {

uint64_t ReplyCache::Fingerprint(std::string_view method, std::string_view request) {
  const std::hash<std::string_view> hash;
  return hash(request) * 31 + hash(method);
}

const ReplyCache::Entry* ReplyCache::EntryOf(std::string_view id, uint64_t hash) const {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& entry) { return entry.hash == hash && entry.id == id; });
  return found == entries_.end() ? nullptr : &*found;
}

std::optional<Result<EncodedMessage>> ReplyCache::Find(std::string_view id, uint64_t fingerprint) const {
  const Entry* const found = EntryOf(id, std::hash<std::string_view>()(id));
  if (found == nullptr) return std::nullopt;
  if (found->fingerprint != fingerprint) {
    return Refuse(Reason::kInvalidValue, "request_id", "request_id was used for another request before");
  }
  return found->outcome;
}

void ReplyCache::Keep(std::string_view id, uint64_t fingerprint, Result<EncodedMessage> outcome) {
  const uint64_t hash = std::hash<std::string_view>()(id);
  if (EntryOf(id, hash) != nullptr) return;
  entries_.push_back({hash, std::string(id), fingerprint, std::move(outcome)});
  bytes_ += SizeOf(entries_.back());
  while (entries_.size() > 1 && (entries_.size() > bounds_.replies || bytes_ > bounds_.bytes)) {
    bytes_ -= SizeOf(entries_.front());
    entries_.pop_front();
  }
}

size_t ReplyCache::SizeOf(const Entry& entry) { return entry.outcome.ok() ? genphys::SizeOf(*entry.outcome) : 0; }

}  // namespace genphys

#include "genphys/hosting/reply_cache.h"

#include <functional>
#include <utility>

namespace genphys {

uint64_t ReplyCache::Fingerprint(std::string_view method, std::string_view request) {
  const std::hash<std::string_view> hash;
  return hash(request) * 31 + hash(method);
}

std::optional<Result<EncodedMessage>> ReplyCache::Find(std::string_view id, uint64_t fingerprint) const {
  const auto found = entries_.find(std::string(id));
  if (found == entries_.end()) return std::nullopt;
  if (found->second.fingerprint != fingerprint) {
    return Refuse(Reason::kInvalidValue, "request_id", "request_id was used for another request before");
  }
  return found->second.outcome;
}

void ReplyCache::Keep(std::string_view id, uint64_t fingerprint, Result<EncodedMessage> outcome) {
  const auto [entry, is_new] = entries_.try_emplace(std::string(id), Entry{fingerprint, std::move(outcome)});
  if (!is_new) return;
  bytes_ += SizeOf(entry->second);
  oldest_first_.push_back(entry->first);
  while (oldest_first_.size() > 1 && (oldest_first_.size() > bounds_.replies || bytes_ > bounds_.bytes)) {
    const auto oldest = entries_.find(oldest_first_.front());
    bytes_ -= SizeOf(oldest->second);
    entries_.erase(oldest);
    oldest_first_.pop_front();
  }
}

size_t ReplyCache::SizeOf(const Entry& entry) { return entry.outcome.ok() ? genphys::SizeOf(*entry.outcome) : 0; }

}  // namespace genphys
